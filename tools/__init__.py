"""What the house needs around the package; not installed."""
