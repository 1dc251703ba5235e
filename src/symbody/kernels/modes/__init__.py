"""Which elements hold: unilateral rows, bounded rows and cones of friction."""
