"""What drives the rotor and what shakes it, over time."""

from __future__ import annotations

import numpy as np

from autobalancer.kernels.fields import Field, Record

PRESCRIBED, TORQUE = 0, 1  # kinds of drive
LINEAR, HILL = 0, 1  # kinds of a segment
HARMONIC, RECORDED = 0, 1  # kinds of an excitation

SEGMENT = Record(
    Field("start", "s", "its begin"),
    Field("kind", "", "LINEAR or HILL", kind=np.int64),
    Field("value", "rad/s or N m", "LINEAR: speed, or torque of the drive, at its begin"),
    Field("rate", "rad/s^2 or N m/s", "LINEAR: what it gains per time"),
    Field("end", "rad/s or N m", "HILL: where the S-shaped rise ends"),
    Field("half_time", "s", "HILL: time of half the rise"),
    Field("exponent", "1", "HILL: how steep the rise is"),
    Field("begin", "rad/s or N m", "HILL: where the rise begins"),
    Field("unbalance_x", "kg m", "resultant unbalance in the rotor, at its begin"),
    Field("unbalance_y", "kg m", "resultant unbalance in the rotor, at its begin"),
    Field("unbalance_rate_x", "kg m/s", "what it gains per time"),
    Field("unbalance_rate_y", "kg m/s", "what it gains per time"),
    Field("changing", "", "whether the loads of any unbalance change in it", kind=np.int64),
)
"""A stretch of time over which drive and unbalance keep their course."""

SHAKE = Record(
    Field("kind", "", "HARMONIC or RECORDED", kind=np.int64),
    Field("felt", "", "whether balls feel it: motion of the base", kind=np.int64),
    Field("x_real", "m/s^2 or N", "HARMONIC: amplitude along x, real part of e^(i w t)"),
    Field("x_imaginary", "m/s^2 or N", "HARMONIC: imaginary part"),
    Field("y_real", "m/s^2 or N", "HARMONIC: amplitude along y, real part"),
    Field("y_imaginary", "m/s^2 or N", "HARMONIC: imaginary part"),
    Field("frequency", "rad/s or 1", "HARMONIC: frequency, or how often per turn"),
    Field("by_angle", "", "whether the frequency counts in turns of the rotor", kind=np.int64),
    Field("table_x", "", "RECORDED: number of the table along x", kind=np.int64),
    Field("table_y", "", "RECORDED: number of the table along y", kind=np.int64),
)
"""One excitation from outside; its two rows of ``vectors`` are accelerations of the coordinates per unit along x and y."""

COUPLING, MOUNT = 0, 1  # kinds of a link

LINK = Record(
    Field(
        "kind", "", "COUPLING, from the rotor to the motor, or MOUNT of the motor's stator, the last one", kind=np.int64
    ),
    Field("state", "", "place of its twist in the state; its speed comes next", kind=np.int64),
    Field("inertia", "kg m^2", "of what turns on the motor's side, or of the stator; 0: its speed is prescribed"),
    Field("stiffness", "N m/rad", "torque over twist"),
    Field("damping", "N m s/rad", "torque over speed of the twist"),
    Field("error", "rad", "amplitude of the twist without a torque"),
    Field("order", "1", "cycles of it per turn of the rotor's side"),
    Field("phase", "rad", "of it"),
)
"""An elastic piece of the drive train. The twist of a coupling is the angle of its motor's side less that of its rotor's side."""

RIPPLE = Record(
    Field("torque", "N m", "amplitude"),
    Field("order", "1", "cycles per turn of the motor against its stator"),
    Field("phase", "rad", "at angle zero"),
)
"""A torque of the motor that changes as it turns."""
