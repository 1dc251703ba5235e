"""Motions that move no mass, and the balances of forces that determine them."""
