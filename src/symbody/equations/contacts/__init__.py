"""Contacts on the graph: where shapes touch, and the forces there."""
