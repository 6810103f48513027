"""Measured signals: their form, and the files from which they are read."""
