"""Kernels for values that are held between samples."""
