"""A rotor on rubber that softens with the amplitude, where x and y differ: steady motion in ellipses."""
