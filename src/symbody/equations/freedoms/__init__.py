"""Freedoms counted, and speeds chosen, at assembled configurations."""
