"""Stability: maps, borders, natural frequencies, responses, branches, basins, and the report of a machine."""
