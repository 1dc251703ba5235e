"""The expression graph on paper: text, LaTeX, definitions for what is too long to write out."""
