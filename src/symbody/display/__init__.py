"""How values of the package show themselves in notebooks."""
