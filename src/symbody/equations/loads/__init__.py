"""Loads on bodies: gravity, drives, forces, springs, bushings, friction."""
