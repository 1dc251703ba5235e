"""Inverse dynamics: the inputs of a prescribed motion."""
