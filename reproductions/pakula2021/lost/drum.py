"""Runs made for the mechanism: one ball in a fixed drum, and chambers with another depth, arrangement or body."""

from __future__ import annotations

import math
import tomllib
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.files.machine_file import machine_text
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.simulation.chamber import simulate_chamber
from reproductions.pakula2021.lost.candidate import Candidate


def changed(machine: ChamberMachine, **tables: dict[str, Any]) -> ChamberMachine:
    """A machine with keys of some of its tables replaced; ``chamber`` and ``balls`` are its only ones."""
    data: dict[str, Any] = tomllib.loads(machine_text(machine))
    chamber = data["chambers"][0] if isinstance(data["chambers"], list) else data["chambers"]
    group = chamber["balls"][0] if isinstance(chamber["balls"], list) else chamber["balls"]
    places = {"chamber": chamber, "balls": group}
    for name, keys in tables.items():
        place = places.get(name, data.setdefault(name, {}) if name not in places else {})
        place.update(keys)
    data["chambers"], chamber["balls"] = [chamber], [group]
    return ChamberMachine(**data)


def one_ball(candidate: Candidate, friction: float, times: list[float], speeds: list[float]) -> xr.Dataset:
    """One ball, a quarter of the mass, at the bottom of the chamber in a body that does not move; no rolling resistance."""
    machine = candidate.machine(balls=4, friction=friction)
    radius = candidate.ball_radius(4)
    data = tomllib.loads(machine_text(machine))
    data["body"], data["supports"], data["unbalances"] = {"freedom": "fixed"}, [], []
    data["chambers"][0]["balls"] = [
        {
            "count": 1, "density": candidate.density, "mass": candidate.ball_mass / 4.0,
            "positions": [[0.0, 0.0, -(candidate.radius - radius)]],
        }
    ]  # fmt: skip
    data["contact"]["rolling_arm"] = 0.0
    data["drive"] = {"kind": "speed", "profile": {"kind": "table", "time": times, "speed": speeds}}
    return simulate_chamber(ChamberMachine(**data), duration=times[-1], sample=5e-4)


def slip(run: xr.Dataset, candidate: Candidate) -> np.ndarray:
    """Speed of the wall less that of the ball at their contact, m/s, over time."""
    place, velocity = run["ball_position"].values[:, 0], run["ball_velocity"].values[:, 0]
    outwards = place * [0.0, 1.0, 1.0]
    outwards /= np.linalg.norm(outwards, axis=1)[:, None]
    around = np.stack([0.0 * outwards[:, 0], -outwards[:, 2], outwards[:, 1]], axis=1)
    ball = candidate.ball_radius(4)
    own = (velocity * around).sum(axis=1) + ball * run["ball_spin"].values[:, 0, 0]
    return np.asarray(run["speed"].values * candidate.radius - own)


def angle(run: xr.Dataset) -> np.ndarray:
    """Angle of the ball from the bottom in the sense of rotation, rad, unwound."""
    place = run["ball_position"].values[:, 0]
    return np.unwrap(np.arctan2(place[:, 1], -place[:, 2]))


def steady_moment(run: xr.Dataset, friction: float) -> float:
    """Greatest moment about y (N m) of balls that keep their last places in the rotor and slide along the axis either way.

    The source lets friction act in full at all times with a sign that changes at nearly every step, so all signs occur.
    """
    last = run.isel(time=-1)
    place = last["ball_position"].transpose("ball", "axis").values
    radius = np.hypot(place[:, 1], place[:, 2])
    normal = last["ball_mass"].values * radius * float(last["speed"]) ** 2
    turned = np.arctan2(place[:, 2], place[:, 1]) + np.linspace(0.0, 2.0 * math.pi, 361)[:, None]
    sliding = (friction * normal * radius * np.abs(np.sin(turned))).sum(axis=1)
    couple = np.abs((normal * place[:, 0] * np.sin(turned)).sum(axis=1))
    return float((sliding + couple).max())
