"""Compiled functions on plain arrays: they know no units, no labels and no machine."""
