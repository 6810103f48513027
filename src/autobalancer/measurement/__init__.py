"""What can be said of a balancer from measurements, without a model of its rotor."""
