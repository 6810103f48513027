"""Speeds from which on the balanced state is stable, and maps of its growth rate."""
