"""Rotor models: what carries the balancers."""
