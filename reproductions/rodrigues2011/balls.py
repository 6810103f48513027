"""The rig with its two balls, as the source simulates it: undeflected, balls at rest in the rotor on its heavy spot.

Balls that start at exactly one angle stay together for ever, stable or not, so the second one is put off by 10 mrad. The
race damping of the source is c_b = c/(m R^2 w), with w = 1675 rpm.
"""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from autobalancer.assembly.parameters import with_parameter
from autobalancer.machine import Machine
from autobalancer.studies.frequency_response import frequency_response
from reproductions.rodrigues2011.rig import BEARINGS, RPM, fitted

OFF = 0.01  # rad
REFERENCE = 1675.0  # rpm
ORBIT, BALL = 0.0428, 0.44e-3
MASS = 1.28


def with_balls(damping: float, washers: int = 3) -> Machine:
    """The fitted rig with a race damping c_b; other numbers of washers by table 2, which is linear in them."""
    machine = fitted()
    if washers != 3:
        couple = complex(3.96 - 2.96 * washers, 4.71) * 1e-5  # chi e^(-i beta), rad
        for path, value in (
            ("unbalances[1].moment", MASS * 2.893e-5 * washers / 3.0),
            ("unbalances[1].angle", -math.atan2(couple.imag, couple.real)),
            ("unbalances[2].misalignment", abs(couple)),
        ):
            machine = with_parameter(machine, path, value)
    heavy = float(machine.unbalances[0].angle)
    machine = with_parameter(machine, "balancers[1].races[1].balls[1].start_angles", (heavy, heavy + OFF))
    drag = damping * BALL * ORBIT**2 * REFERENCE * RPM
    return with_parameter(machine, "balancers[1].races[1].drag.beta", drag)


def from_heavy_spot(machine: Machine, speeds: np.ndarray, *, dwell: float, window: float) -> xr.Dataset:
    """Every speed (rpm) begun anew."""
    return frequency_response(
        machine, speeds * RPM, dwell=dwell, window=window, start="fixed", stations=BEARINGS, tolerance=1e-8
    )
