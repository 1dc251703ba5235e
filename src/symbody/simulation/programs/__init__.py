"""Whole simulations as programs that stand alone."""
