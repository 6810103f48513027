"""The equilibrium angle of one ball in a slowly turned race."""
