"""Configurations at rest: `find_equilibrium`."""
