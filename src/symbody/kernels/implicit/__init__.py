"""Kernels of the generalized-alpha method."""
