"""Pinocchio in C++."""
