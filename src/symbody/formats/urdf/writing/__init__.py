"""A model as URDF."""
