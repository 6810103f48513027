"""Balls that stall at a resonance: from where they are released, and down to where they are captured."""
