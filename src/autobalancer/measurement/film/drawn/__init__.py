"""A film of a simulated race: camera, shutter and scene."""
