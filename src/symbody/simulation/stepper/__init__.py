"""Motions in steps that the caller takes one by one: for controllers, games, hardware and learning."""
