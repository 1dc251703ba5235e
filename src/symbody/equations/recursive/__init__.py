"""Recursions along the one tree of a mechanism: inverse dynamics, composite and articulated bodies."""
