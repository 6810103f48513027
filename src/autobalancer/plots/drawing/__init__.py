"""What all pictures share: look, units of axes, labels that do not overlap, files."""
