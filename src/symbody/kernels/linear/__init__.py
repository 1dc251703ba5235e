"""Kernels of linear algebra: pivots, ranks, factors."""
