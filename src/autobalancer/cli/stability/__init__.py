"""Commands that answer before a run."""
