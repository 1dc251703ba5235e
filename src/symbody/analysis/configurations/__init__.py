"""Configurations that fulfil the constraints: assembly, closed forms, ranges, closed gaps."""
