"""Loops in C over functions known by their address."""
