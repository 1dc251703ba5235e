"""Ways to mass matrix and forcing; none imports another."""
