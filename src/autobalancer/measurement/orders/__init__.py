"""Angle and speed from a tacho, and what a vibration does in each order of the speed."""
