"""Inverse dynamics: what makes a mechanism move as it is told to."""
