"""Contacts as data: shapes that touch, and laws of the forces between them."""
