"""Motions with inputs that FMUs compute, step by step."""
