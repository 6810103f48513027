"""Sensors on a simulated machine: what a logger would have written of a run."""
