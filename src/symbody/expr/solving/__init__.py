"""Equations solved in closed form with SymPy, in a process that can be ended."""
