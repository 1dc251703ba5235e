"""The expression graph on which everything computes."""
