"""What is given from outside while a mechanism moves."""
