"""The rig of the source, with the printed values and with those fitted to its simulated curve, and its curves."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from autobalancer.assembly.quantities import with_value_at
from autobalancer.files.examples import rig
from autobalancer.machine import Machine

DATA = Path(__file__).parent / "data"
RPM = math.pi / 30.0
BEARINGS = ["B1", "B2"]


def fitted() -> Machine:
    """The rig with the values that fit the simulated curve of figure 8."""
    machine = rig("rodrigues_rig_point_balls")
    for path, value in (
        ("rotor.supports[1].stiffness", ["21495 N/m", "15793 N/m"]),
        ("rotor.supports[2].stiffness", ["21495 N/m", "15793 N/m"]),
        ("rotor.stiffness_proportional_damping", "2.501e-4 s"),
        ("unbalances[1].moment", 1.28 * 2.893e-5),
        ("unbalances[1].angle", "223.6 deg"),
        ("unbalances[2].misalignment", "6.79e-5 rad"),
    ):
        machine = with_value_at(machine, path, value)
    return machine


def columns(name: str) -> tuple[np.ndarray, np.ndarray]:
    """The two columns of a file, in the units of its head."""
    first, second = np.loadtxt(DATA / f"{name}.csv", delimiter=",", skiprows=1).T
    return first, second
