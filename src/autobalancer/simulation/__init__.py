"""Run a machine in time."""
