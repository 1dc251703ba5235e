"""Linear equations about a point: `linearize`."""
