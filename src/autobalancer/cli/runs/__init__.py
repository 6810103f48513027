"""Commands that run machines, and those that show runs."""
