"""Drives, forces, springs, bushings and friction as data."""
