"""The rig with its two balls, as the source simulates it and as it was measured.

The source simulates point balls that pass through each other, at rest in the rotor on its heavy spot. Balls that start at
exactly one angle stay together for ever, stable or not, so the second one is put off by 10 mrad. The balls of the rig have a
size: they roll, and touch. Its race runs out by 5 um; where to is not printed. The race damping of the source is
c_b = c/(m R^2 w), with w = 1675 rpm.
"""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from autobalancer.assembly.quantities import with_value_at
from autobalancer.machine import Machine
from autobalancer.studies.stepped_response import stepped_response
from reproductions.rodrigues2011.rig import BEARINGS, RPM, fitted

OFF = 0.01  # rad
REFERENCE = 1675.0  # rpm
ORBIT, BALL, DIAMETER = 0.0428, 0.44e-3, 4.76e-3
MASS = 1.28
RUN_OUT, AHEAD = 5e-6, math.radians(91.4)  # m; of the heavy spot, chosen of eight directions to meet figure 9
RACE = "balancers[1].races[1]."
STEPS = np.arange(600.0, 5401.0, 10.0)  # rpm, as in the experiment


def with_balls(damping: float, washers: int = 3, *, off: float = OFF) -> Machine:
    """The fitted rig with point balls and a race damping c_b; other numbers of washers by table 2, which is linear in them."""
    machine = fitted()
    if washers != 3:
        couple = complex(3.96 - 2.96 * washers, 4.71) * 1e-5  # chi e^(-i beta), rad
        machine = with_unbalance(machine, 2.893e-5 * washers / 3.0, -math.atan2(couple.imag, couple.real), abs(couple))
    heavy = float(machine.unbalances[0].angle)
    balls = {"count": 2, "mass": BALL, "motion": "point", "start_angles": (heavy, heavy + off)}
    machine = with_value_at(machine, f"{RACE}balls[1]", balls)
    return with_value_at(machine, f"{RACE}drag.damping", damping * BALL * ORBIT**2 * REFERENCE * RPM)


def as_measured(washers: int, *, run_out: bool = True, rolling: float = 0.0) -> Machine:
    """The rig with balls that roll and touch, c_b = 0.1, with the run-out of its race, and ``rolling`` resistance.

    The adherence is twice the rolling resistance.
    """
    machine = with_balls(0.1, washers)
    heavy = float(machine.unbalances[0].angle)
    balls = {
        "count": 2,
        "mass": BALL,
        "diameter": DIAMETER,
        "motion": "rolling",
        "start_angles": (heavy - 0.1, heavy + 0.1),
    }
    machine = with_value_at(machine, f"{RACE}balls[1]", balls)
    if rolling:
        friction = {"rolling_resistance": rolling, "adherence": 2.0 * rolling}
        machine = with_value_at(machine, f"{RACE}friction", friction)
    if not run_out:
        return machine
    machine = with_value_at(machine, f"{RACE}eccentricity", RUN_OUT)
    return with_value_at(machine, f"{RACE}eccentricity_angle", heavy + AHEAD)


def with_unbalance(machine: Machine, eccentricity: float, angle: float, misalignment: float) -> Machine:
    """The rig with an eccentricity (m) an angle (rad) ahead of a misalignment (rad); balls stay where they are."""
    for path, value in (
        ("unbalances[1].moment", MASS * eccentricity),
        ("unbalances[1].angle", angle),
        ("unbalances[2].misalignment", misalignment),
    ):
        machine = with_value_at(machine, path, value)
    return machine


def without_balls(machine: Machine) -> Machine:
    """The plain rotor."""
    return Machine(**{key: getattr(machine, key) for key in machine.model_fields_set if key != "balancers"})


def from_heavy_spot(machine: Machine, speeds: np.ndarray, *, dwell: float, window: float) -> xr.Dataset:
    """Every speed (rpm) begun anew."""
    return stepped_response(
        machine, speeds * RPM, dwell=dwell, window=window, start="fixed", stations=BEARINGS, tolerance=1e-8
    )


def stepped(machine: Machine) -> xr.Dataset:
    """As in the experiment: 0.25 s at a speed, 0.25 s of measurement, 10 rpm on, state carried over, then down again."""
    return stepped_response(machine, STEPS * RPM, dwell=0.25, window=0.25, direction="both", stations=BEARINGS)


def level(leg: xr.Dataset, low: float, high: float) -> float:
    """Geometric mean of our amplitudes in a band of the speed (rpm), mm."""
    speeds = leg["speed"].values / RPM
    return geometric_mean(speeds, leg["amplitude"].values * 1e3, low, high)


def geometric_mean(speeds: np.ndarray, amplitudes: np.ndarray, low: float, high: float) -> float:
    """Geometric mean of amplitudes in a band of the speed."""
    inside = (speeds >= low) & (speeds <= high)
    return float(np.exp(np.log(amplitudes[inside]).mean()))
