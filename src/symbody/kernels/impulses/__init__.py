"""Steps over impacts: impulses of many gaps and their friction at once."""
