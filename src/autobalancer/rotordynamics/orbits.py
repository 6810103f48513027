"""Whirl orbits at one speed, at stations and along the whole axis."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from autobalancer.errors import QuestionError
from autobalancer.machine import Machine
from autobalancer.results.answers.labeled import Labeled
from autobalancer.rotordynamics.question import along_axis, attributes, checked_speeds, chosen_places, rotor_of
from autobalancer.rotordynamics.response import amplitudes
from autobalancer.rotordynamics.rubber import rubber_of
from autobalancer.rotordynamics.unbalance import Given, load_of
from autobalancer.rotordynamics.whirl import turning, whirl
from autobalancer.units import argument, list_argument, unbalance_argument


def whirl_orbits(
    machine: Machine | str | Path,
    speed: float | str,
    stations: Sequence[str | float] | str | float | None = None,
    unbalance: Given | str = None,
    *,
    balls: bool = False,
    ball_angles: Sequence[float | str] | None = None,
    points: int = 181,
) -> xr.Dataset:
    """Paths of the axis over one revolution under unbalance at a speed.

    Parameters
    ----------
    machine, stations, unbalance, balls, ball_angles
        As for :func:`~autobalancer.rotordynamics.response.response`.
    speed
        Rotor speed, rad/s.
    points
        Number of points of an orbit; the last one equals the first one.

    Returns
    -------
    xarray.Dataset
        Over ``station`` and ``rotor_angle`` (rad, from 0 to a full turn) ``x`` and ``y`` (m); ``whirl``, ``semi_major``,
        ``semi_minor`` (m) and ``inclination`` (rad) over ``station``; ``axis_x`` and ``axis_y`` over ``place`` along the
        axis and ``rotor_angle``.

    Raises
    ------
    QuestionError
        As for :func:`~autobalancer.rotordynamics.response.response`, and for fewer than 9 points.
    """
    ball_angles = None if ball_angles is None else list_argument("ball_angles", ball_angles, "rad")
    speed = argument("speed", speed, "rad/s")
    unbalance = unbalance_argument(unbalance)
    owner = "whirl_orbits"
    machine, model = rotor_of(machine, balls=balls or ball_angles is not None)
    omega = checked_speeds(speed, model, owner)
    if points < 9:
        raise QuestionError(f"{owner}: points: given {points}; must be at least 9")
    at, axis = chosen_places(machine, model, stations, owner), along_axis(machine, model)
    load = load_of(machine, model, unbalance, ball_angles, owner)
    soft = rubber_of(machine, model)
    angle = np.linspace(0.0, 2.0 * np.pi, points)
    here, everywhere = (whirl(*(part[0] for part in amplitudes(model, omega[:1], load, p, soft))) for p in (at, axis))
    orbit, line = turning(here, angle), turning(everywhere, angle)
    result = xr.Dataset(
        coords={
            "rotor_angle": ("rotor_angle", angle, {"long_name": "rotor angle", "units": "rad"}),
            "station": ("station", np.array(at.names, dtype=object), {"long_name": "station"}),
            "position": ("station", at.positions, {"long_name": "position along the axis", "units": "m"}),
            "place": ("place", axis.positions, {"long_name": "position along the axis", "units": "m"}),
        }
    )
    for name, dims, numbers, text, unit in (
        ("x", ("station", "rotor_angle"), orbit.real, "deflection along x", "m"),
        ("y", ("station", "rotor_angle"), orbit.imag, "deflection along y", "m"),
        ("axis_x", ("place", "rotor_angle"), line.real, "deflection of the axis along x", "m"),
        ("axis_y", ("place", "rotor_angle"), line.imag, "deflection of the axis along y", "m"),
        ("whirl", "station", here.direction, "direction of whirl", ""),
        ("semi_major", "station", here.semi_major, "greatest deflection, major semi-axis", "m"),
        ("semi_minor", "station", np.abs(here.semi_minor), "least deflection, minor semi-axis", "m"),
        ("inclination", "station", here.inclination, "angle of the major axis from x", "rad"),
    ):
        result[name] = (dims, numbers, {"long_name": text, "units": unit})
    result.attrs = attributes(machine, f"Whirl orbits of {machine.name}", balls=balls or ball_angles is not None) | {
        "speed": float(omega[0])
    }
    return Labeled.of(result)
