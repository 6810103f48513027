"""Slip of a ball on a wall, as a friction law sees it."""

from __future__ import annotations

from autobalancer.kernels.fields import Field, Record

SLIP = Record(
    Field("slip", "m/s", "velocity with which the ball slides on the wall, of either sign"),
    Field("pressed", "N", "force of the wall"),
    Field("sliding", "1", "coefficient of friction, the key `sliding_friction`"),
    Field("slip_speed", "m/s", "the key `slip_speed`"),
    Field("radius", "m", "of the ball"),
)
"""What a friction law knows of a contact. No time and no place, so that it can only brake."""
