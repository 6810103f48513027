"""All states in which the balls rest in the rotor, and which of them are stable."""
