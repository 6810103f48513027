"""Balls that are free in the plane of their race, and the walls they feel, as numbers."""
