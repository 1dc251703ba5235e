"""Texts for other people's tools: Fortran, MATLAB and Octave, Julia, JAX, CasADi; one language a file."""
