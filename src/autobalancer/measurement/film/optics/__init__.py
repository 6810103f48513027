"""From marks to the camera, and outlines of round things as it sees them."""
