"""What comes in: files that cannot be trusted."""
