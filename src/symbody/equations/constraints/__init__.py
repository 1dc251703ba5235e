"""Constraint equations of cut joints and of constraints, one file a family."""
