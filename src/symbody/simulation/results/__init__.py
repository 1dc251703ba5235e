"""The motion that was found, its file, and what to say about it."""
