"""Configurations that fulfil the constraints: assembly, closed forms, ranges, ropes that pull."""
