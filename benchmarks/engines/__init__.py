"""One file for each engine, all with the same interface, `algebra.Algebra`."""
