"""Parameters of a machine from what was measured on it."""
