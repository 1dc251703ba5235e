"""What follows from formed equations by solving: accelerations, projections, degrees of freedom."""
