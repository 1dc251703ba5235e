"""Rows of the constraints beside the joints, one file a family, and their registry."""
