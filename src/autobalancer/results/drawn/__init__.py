"""What pictures draw of a machine, beside the arrays of a run."""
