"""Simulation and measurement side by side: the same quantities, the same measures, and machines fitted to run-ups."""
