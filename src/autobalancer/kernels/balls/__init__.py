"""Balls: guided on the path of their race, or resolved in contact with its walls."""
