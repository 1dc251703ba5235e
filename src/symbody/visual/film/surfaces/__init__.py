"""What is seen of facets: layers, regions of one colour, stretches of edges in front."""
