"""How elements declare themselves: fields with roles, units and defaults, and how arguments are read."""
