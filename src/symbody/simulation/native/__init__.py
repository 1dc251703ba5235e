"""The loop that numba compiles once for every model, and the methods it runs."""
