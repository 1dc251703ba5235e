"""What acts on bodies: gravity, drives, forces, springs, bushings, friction."""
