"""Bearings that become stiffer as they deflect."""

from __future__ import annotations

import numpy as np

from autobalancer.kernels.fields import Field, Record

HARDENING = Record(
    Field("cubic", "N/m^3", "force over the third power of the distance"),
    Field("contact", "N/m", "stiffness of the stop"),
    Field("clearance", "m", "distance at which it begins"),
    Field("center_x", "m", "middle of the bearing from where the rotor rests"),
    Field("center_y", "m", "the same"),
    Field("first", "", "where the pieces of its table begin", kind=np.int64),
    Field("pieces", "", "how many there are; 0: it has none", kind=np.int64),
    Field("rest_x", "N", "force of the bearing there, which is part of the rest"),
    Field("rest_y", "N", "the same"),
)
"""A central force between a place of the rotor and the ground."""
