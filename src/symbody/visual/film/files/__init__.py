"""Files of pictures and films: pixels, SVG, axes of matplotlib, GIF, MP4."""
