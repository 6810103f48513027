"""Periodic motions in the frame of the rotor: as points of a curve, and their special points."""
