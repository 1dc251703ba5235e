"""What workers compute: one task a function, each from JSON data to JSON data."""
