"""Kernels for many motions side by side, one in each lane of a register."""
