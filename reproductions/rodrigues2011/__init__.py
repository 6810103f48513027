"""Rodrigues, Champneys, Friswell and Wilson (2011): a rigid rotor on anisotropic bearings with a ball balancer."""
