"""Robots in URDF: read safely, made a `Model` with notes on assumptions, and written again."""
