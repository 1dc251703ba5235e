"""Dependent speeds, written in the independent ones."""
