"""Guided balls at the stations of a linear rotor, at all nodes of a long step."""
