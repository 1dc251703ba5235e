"""The language of formulas: from text to instructions that the expression graph takes in."""
