"""Commands for measured signals and films: the group ``measure``."""
