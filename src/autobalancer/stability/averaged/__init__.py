"""The averaged equations: Spannan (2021), chapter 4."""
