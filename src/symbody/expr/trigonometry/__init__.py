"""The trigonometric normal form, in which formulas read as a textbook prints them."""
