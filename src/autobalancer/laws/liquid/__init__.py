"""Fluids that thin or thicken, and liquids with a free surface."""
