"""From equations to sequences and bound functions: the only folder here that reads equations."""
