"""Constraints of a motion: branches, redundancy, change points, minimal coordinates."""
