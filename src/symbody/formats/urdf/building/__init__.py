"""A robot as a model: bodies, joints, loops."""
