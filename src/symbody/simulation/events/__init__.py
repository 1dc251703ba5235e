"""What is watched while a mechanism moves."""
