"""What a question about stability needs of a machine at one speed: the rotor as the balls see it, unbalance, balls."""
