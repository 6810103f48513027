"""Balls on a rotor of which only the receptance is known."""
