"""Robots in URDF: read safely, told what was assumed, made a `Model`, and written again."""
