"""Balancers: races, the balls in them and the fluid around these."""
