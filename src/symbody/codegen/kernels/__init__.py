"""Kernels in other languages: a reader of the files in `symbody.kernels`, and a writer for each language."""
