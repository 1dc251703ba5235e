"""Ways to mass matrix and forcing; none knows another."""
