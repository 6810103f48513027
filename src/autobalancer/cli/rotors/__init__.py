"""Commands for rotors without balls, measurements and the fluid."""
