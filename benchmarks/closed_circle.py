"""From a machine to its signals and back: how often intervals of 95 % hold the true values of a simulated rig.

A case draws a rig at random, runs it up, measures it with two noisy displacement sensors and a camera that sees the balls 100
times a second, and fits the rig to what was measured. The fit begins at the same machine in each case and knows of the true one
only the signals, the drive and where the balls start.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import xarray as xr

import autobalancer as ab
from autobalancer.errors import RangeWarning
from autobalancer.machine import Machine
from autobalancer.random_numbers import generator
from benchmarks import measured

CASES = 1000
RIG = """name = "small rig"
axis = "vertical"
rotor = { kind = "planar", mass = "10 kg", stiffness = "1 MN/m", damping = "300 N*s/m" }
drive = { kind = "speed", profile = { kind = "ramp", start = "150 rad/s", end = "600 rad/s", duration = "0.25 s" } }
unbalances = [{ moment = "400 g*mm" }]
run = { duration = "0.3 s" }
[[balancers]]
[[balancers.races]]
orbit_radius = "100 mm"
drag = { law = "beta", beta = "1e-3 N*m*s" }
balls = [{ count = 2, mass = "3 g", density = "7800 kg/m^3", start_angles = ["60 deg", "200 deg"] }]
"""
SOUGHT = {  # path: how far the true value may be from that of the rig, and bounds of the fit, as factors
    "rotor.stiffness": (0.02, 0.5, 2.0),
    "rotor.damping": (0.15, 0.3, 3.0),
    "unbalances[1].moment": (0.15, 0.3, 3.0),
    "balancers[1].races[1].drag.beta": (0.15, 0.3, 3.0),
}
NOISE, RATE = "40 dB", 1000.0  # of each sensor; Hz
FRAMES, SEEN = 10, np.radians(0.2)  # samples from one picture to the next; standard deviation of a ball angle, rad


def bench() -> list[dict[str, Any]]:
    """Share of the intervals that hold the true value."""
    held = circles(CASES)
    each = ", ".join(
        f"{name.split('.')[-1]} {100 * share:.1f}" for name, share in zip(SOUGHT, held.mean(axis=0), strict=True)
    )
    note = f"{CASES} rigs, {NOISE} noise, by parameter in %: {each}; at least 93 is wanted of intervals of 95 %"
    return [measured("closed_circle_coverage_percent", 100.0 * float(held.mean()), "%", note=note)]


def circles(cases: int, first: int = 0) -> np.ndarray:
    """Whether the interval of each parameter holds the true value, (cases, parameters)."""
    rig = ab.parse_machine(RIG)
    start = {path: parameter(rig, path) for path in SOUGHT}
    bounds = {path: (low * start[path], high * start[path]) for path, (_, low, high) in SOUGHT.items()}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RangeWarning)
        return np.array([circle(rig, start, bounds, seed) for seed in range(first, first + cases)])


def circle(rig: Machine, start: dict[str, float], bounds: dict[str, tuple[float, float]], seed: int) -> list[bool]:
    """One rig: drawn, run, measured, fitted."""
    random = generator(seed)
    true = {path: start[path] * (1.0 + SOUGHT[path][0] * random.uniform(-1.0, 1.0)) for path in SOUGHT}
    machine = rig
    for path, value in true.items():
        machine = ab.with_parameter(machine, path, value)
    run = ab.simulate(machine, save=ab.Samples(601), progress=False)
    sensors = [ab.measure.Sensor("displacement", direction=way, noise=NOISE) for way in ("x", "y")]
    signals = ab.measure.record(run, sensors, RATE, seed=seed)
    film = seen_by_a_camera(run.isel(time=slice(0, None, 2 * FRAMES)), random)
    found = ab.measure.fit_run_up(rig, [signals, film], bounds).data
    low, high = found["interval_low"].values, found["interval_high"].values
    return [bool(a <= value <= b) for a, value, b in zip(low, true.values(), high, strict=True)]


def seen_by_a_camera(run: xr.Dataset, random: np.random.Generator) -> xr.Dataset:
    """Ball angles with the noise of a camera, whole turns not counted."""
    angle = run["ball_angle_in_rotor"]
    seen = (angle.values + SEEN * random.standard_normal(angle.shape)) % (2.0 * np.pi)
    return xr.Dataset(
        {
            "ball_angle": (("time", "ball"), seen),
            "ball_angle_deviation": (("time", "ball"), np.full(angle.shape, SEEN)),
        },
        {"time": run["time"].values, "ball": run["ball"].values},
    )


def parameter(machine: Machine, path: str) -> float:
    """The number at a path."""
    from autobalancer.assembly.parameters import parameter_of

    return parameter_of(machine, path)
