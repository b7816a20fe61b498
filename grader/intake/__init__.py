"""Open and prepare submitted files, which must not be trusted."""
