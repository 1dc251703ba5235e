"""Many motions of one mechanism: cases, chunks of them, workers, and what comes back."""
