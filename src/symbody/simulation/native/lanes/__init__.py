"""Motions side by side in the lanes of wide registers."""
