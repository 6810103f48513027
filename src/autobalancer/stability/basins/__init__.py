"""Which end state follows from which start."""
