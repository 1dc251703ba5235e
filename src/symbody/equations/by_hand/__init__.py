"""Mechanisms whose frames, forces and constraints are placed by hand."""
