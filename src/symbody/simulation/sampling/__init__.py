"""Values that are held between samples."""
