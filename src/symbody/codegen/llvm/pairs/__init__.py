"""Limbs of equal structure side by side: each operation of a left and a right leg is one instruction."""
