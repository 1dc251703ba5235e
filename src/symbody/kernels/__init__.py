"""Numerical kernels, each written once: ordinary Python files in a small typed language.

Python runs them, slowly: the reference. `codegen.kernels` reads the same files and writes them in other
languages, and as machine code; all give the same bits. `docs/kernels.md` defines the language.
"""
