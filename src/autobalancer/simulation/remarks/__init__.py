"""What must be said of a run in words."""
