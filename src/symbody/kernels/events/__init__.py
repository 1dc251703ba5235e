"""Kernels for events: where they happen, what happens then, and motions cut there."""
