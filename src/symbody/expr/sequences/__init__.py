"""From the graph to numbers: straight lines of operations, and their evaluation in Python."""
