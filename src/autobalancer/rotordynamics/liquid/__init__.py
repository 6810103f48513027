"""Rings partly filled with liquid on a rotor: steady response and small motions."""
