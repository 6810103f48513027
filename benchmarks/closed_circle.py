"""From a machine to its signals and back: how often intervals of 95 % hold the true values of a simulated rig.

A case draws a rig at random, runs it up, measures it with two noisy displacement sensors, films its balls with a camera that
turns with the rotor, follows them in the film, and fits the rig to signals and film. The fit begins at the same machine in each
case and knows of the true one only the signals, the film, the drive and where the balls start.
"""

from __future__ import annotations

import warnings
from concurrent.futures import ProcessPoolExecutor
from typing import Any

import numpy as np
import xarray as xr

import autobalancer as ab
from autobalancer.errors import RangeWarning
from autobalancer.machine import Machine
from autobalancer.random_numbers import generator
from benchmarks import measured

CASES = 1000
FEW = 50  # cases that are not worth more processes
RIG = """name = "small rig"
axis = "vertical"
rotor = { kind = "planar", mass = "10 kg", stiffness = "1 MN/m", damping = "300 N*s/m" }
drive = { kind = "speed", profile = { kind = "ramp", start = "150 rad/s", end = "600 rad/s", duration = "0.25 s" } }
unbalances = [{ moment = "400 g*mm" }]
run = { duration = "0.3 s" }
[[balancers]]
[[balancers.races]]
orbit_radius = "100 mm"
drag = { law = "viscous", damping = "1e-3 N*m*s" }
balls = [{ count = 2, mass = "3 g", density = "7800 kg/m^3", start_angles = ["60 deg", "200 deg"] }]
"""
SOUGHT = {  # path: how far the true value may be from that of the rig, and bounds of the fit, as factors
    "rotor.stiffness": (0.02, 0.5, 2.0),
    "rotor.damping": (0.15, 0.3, 3.0),
    "unbalances[1].moment": (0.15, 0.3, 3.0),
    "balancers[1].races[1].drag.damping": (0.15, 0.3, 3.0),
}
NOISE, RATE = "40 dB", 1000.0  # of each sensor; Hz
SIZE = (320, 240)  # of a picture: a ball is 9 pixels across
BEGIN, END = 0.05, 0.2  # of the film, s
EXPOSURE = ab.measure.Exposure(frame_rate=100.0, time=5e-5, noise=0.01)
SLIP = -25.0  # of the balls when the film begins, rad/s: that of the rotor grows by 1800 rad/s^2, and they take 0.03 s
TRUTH, OF_FILM = 2, 1_000_000  # random numbers that no sensor uses


def bench() -> list[dict[str, Any]]:
    """Share of the intervals that hold the true value."""
    held = circles(CASES)
    each = ", ".join(
        f"{name.split('.')[-1]} {100 * share:.1f}" for name, share in zip(SOUGHT, held.mean(axis=0), strict=True)
    )
    note = f"{CASES} rigs, {NOISE} noise, films, by parameter in %: {each}; at least 93 is wanted of intervals of 95 %"
    return [measured("closed_circle_coverage_percent", 100.0 * float(held.mean()), "%", note=note)]


def circles(cases: int, first: int = 0) -> np.ndarray:
    """Whether the interval of each parameter holds the true value, (cases, parameters); on all cores."""
    seeds = range(first, first + cases)
    if cases < FEW:
        return np.array([circle(seed) for seed in seeds])
    with ProcessPoolExecutor() as pool:
        return np.array(list(pool.map(circle, seeds, chunksize=5)))


def circle(seed: int) -> list[bool]:
    """One rig: drawn, run, measured, filmed, fitted."""
    rig, random = ab.parse_machine(RIG), generator(seed, TRUTH)
    start = {path: parameter(rig, path) for path in SOUGHT}
    bounds = {path: (low * start[path], high * start[path]) for path, (_, low, high) in SOUGHT.items()}
    true = {path: start[path] * (1.0 + SOUGHT[path][0] * random.uniform(-1.0, 1.0)) for path in SOUGHT}
    machine = rig
    for path, value in true.items():
        machine = ab.with_parameter(machine, path, value)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RangeWarning)
        run = ab.simulate(machine, save=ab.Samples(601), progress=False)
        found = ab.measure.fit_run_up(rig, measurements(run, seed), bounds).data
    low, high = found["interval_low"].values, found["interval_high"].values
    return [bool(a <= value <= b) for a, value, b in zip(low, true.values(), high, strict=True)]


def measurements(run: xr.Dataset, seed: int) -> list[xr.Dataset]:
    """Signals of two sensors, and the balls of a film as they are found in it."""
    sensors = [ab.measure.Sensor("displacement", direction=way, noise=NOISE) for way in ("x", "y")]
    signals = ab.measure.record(run, sensors, RATE, seed=seed)
    camera = ab.measure.film_camera(run, width=SIZE[0], height=SIZE[1], turning=True)
    film = ab.measure.render_film(
        run, camera=camera, exposure=EXPOSURE, start=BEGIN, end=END, seed=OF_FILM + seed, progress=False
    )
    balls = ab.measure.track_balls(film, ab.measure.film_setup(run, camera), first_ball_speed=SLIP, progress=False)
    return [signals, balls]


def parameter(machine: Machine, path: str) -> float:
    """The number at a path."""
    from autobalancer.assembly.quantities import parameter_of

    return parameter_of(machine, path)
