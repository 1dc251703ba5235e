"""Mechanisms whose equations change: sticking and slipping, taut and slack, parts of one motion."""
