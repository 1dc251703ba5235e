"""Equations as they are asked for: outputs by name, formulas as books print them."""
