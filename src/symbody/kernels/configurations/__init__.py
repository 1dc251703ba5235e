"""Kernels for states that fulfil the constraints: assembly, first state, projection."""
