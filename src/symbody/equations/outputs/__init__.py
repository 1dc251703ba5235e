"""Outputs of equations: roots by name, formulas as books print them."""
