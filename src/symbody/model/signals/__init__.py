"""Signals: names for formulas, for outputs of the mechanism, and for states with a rate."""
