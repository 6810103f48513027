"""Rotors without moving balls: natural frequencies, Campbell diagrams, critical speeds, unbalance response."""
