"""Pictures of a rotor without balls: modes, critical speeds, response to unbalance."""
