"""Ways to integrate, and to hold constraints."""
