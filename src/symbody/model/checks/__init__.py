"""What makes a description a model: all contradictions found at once."""
