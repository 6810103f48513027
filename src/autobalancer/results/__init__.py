"""Labelled arrays: what a run or a measurement says, with units, long names and provenance."""
