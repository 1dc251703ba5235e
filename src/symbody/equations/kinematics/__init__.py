"""Variables, frames and their motion."""
