"""Whether a run is balanced, and what is left where."""
