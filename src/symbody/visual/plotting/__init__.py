"""Outputs of a motion as curves and paths."""
