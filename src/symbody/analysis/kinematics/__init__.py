"""Kinematic analysis: driven coordinates followed, ratios of velocities, singular configurations."""
