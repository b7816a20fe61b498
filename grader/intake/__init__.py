"""Open and prepare submitted files, which cannot be trusted."""
