"""What pictures draw of a machine, beside the arrays of a run."""

from __future__ import annotations

import tomllib
from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.arrays import Complexes, Floats
from autobalancer.errors import MachineError, QuestionError
from autobalancer.machine import Force
from autobalancer.machine.plugins import find
from autobalancer.units import argument

# The motion between the samples of a run.
#
# In the frame of the rotor a balanced or stalled machine is nearly at rest, so the deflection is interpolated there
# and turned into space afterwards; angles follow their known speeds. Both are cubic and pass through every sample.


class Moments(NamedTuple):
    """States at some times; complex numbers are x + i y."""

    time: Floats
    speed: Floats  # rad/s
    rotor_angle: Floats  # rad, in space
    deflection_in_rotor: Complexes  # m
    ball_angle_in_rotor: Floats  # rad, not wrapped; balls are the second axis
    ball_inside: Floats  # m, distance of a resolved ball from its wall; 0 of guided ones
    unbalance_in_rotor: Complexes  # kg m
    plane_deflection_in_rotor: Complexes  # m; planes are the second axis
    plane_unbalance_in_rotor: Complexes  # kg m
    couple_in_rotor: Complexes  # kg m^2


class Motion:
    """The samples of a run, and what happened between them."""

    def __init__(self, run: xr.Dataset) -> None:
        missing = [name for name in ("time", "speed", "rotor_angle", "x", "y") if name not in run]
        if missing or run["time"].size < 2:
            what = ", ".join(missing) if missing else "times (it has fewer than two)"
            raise QuestionError(f"the run lacks samples of {what}; save Samples() with simulate(..., save=...)")
        self.time = np.asarray(run["time"].values, np.float64)
        self.speed = np.asarray(run["speed"].values, np.float64)
        self.rotor_angle = np.asarray(run["rotor_angle"].values, np.float64)
        z = run["x"].values + 1j * run["y"].values
        self.deflection_in_rotor = z * np.exp(-1j * self.rotor_angle)
        rows = (self.time.size, run.sizes.get("ball", 0))
        self.ball_angle = _known(run, "ball_angle_in_rotor", rows)
        self.ball_slip = _known(run, "ball_speed_in_rotor", rows)
        if "ball_speed_in_rotor" not in run and self.ball_angle.size:
            self.ball_slip = np.asarray(np.gradient(self.ball_angle, self.time, axis=0))
        self.ball_inside = np.maximum(_known(run, "ball_gap", rows), 0.0)
        size, side = _known(run, "unbalance", rows[:1]), _known(run, "unbalance_angle_in_rotor", rows[:1])
        self.unbalance_in_rotor = size * np.exp(1j * side)
        turned = np.exp(-1j * self.rotor_angle)
        self.plane_deflection_in_rotor = self.deflection_in_rotor[:, None]
        self.plane_unbalance_in_rotor = self.unbalance_in_rotor[:, None]
        if "plane_unbalance" in run:
            planes = run["plane_x"].values + 1j * run["plane_y"].values
            self.plane_deflection_in_rotor = np.asarray(planes * turned[:, None])
            side = run["plane_unbalance_angle_in_rotor"].values
            self.plane_unbalance_in_rotor = np.nan_to_num(run["plane_unbalance"].values * np.exp(1j * side))
        couple = _known(run, "couple_unbalance_angle_in_rotor", rows[:1])
        self.couple_in_rotor = _known(run, "couple_unbalance", rows[:1]) * np.exp(1j * couple)

    def at(self, time: Floats) -> Moments:
        """States at ``time`` (s).

        Raises
        ------
        QuestionError
            If one of the times is outside the samples.
        """
        first, last = float(self.time[0]), float(self.time[-1])
        if time.size and not (first - 1e-9 <= time.min() and time.max() <= last + 1e-9):
            given = f"{time.min():g} s" + (f" to {time.max():g} s" if time.size > 1 else "")
            raise QuestionError(f"time: given {given}; the samples go from {first:g} s to {last:g} s")
        slope = np.gradient(self.deflection_in_rotor, self.time)
        planes = self.plane_deflection_in_rotor
        return Moments(
            time,
            np.interp(time, self.time, self.speed),
            cubic(time, self.time, self.rotor_angle, self.speed),
            cubic(time, self.time, self.deflection_in_rotor, slope),
            cubic(time, self.time, self.ball_angle, self.ball_slip),
            _interpolated(time, self.time, self.ball_inside),
            np.interp(time, self.time, self.unbalance_in_rotor),
            cubic(time, self.time, planes, np.gradient(planes, self.time, axis=0)),
            _interpolated(time, self.time, self.plane_unbalance_in_rotor),
            np.interp(time, self.time, self.couple_in_rotor),
        )


def _interpolated(at: Floats, time: Floats, values: NDArray[Any]) -> NDArray[Any]:
    """Each column of the values, linear in between."""
    columns = [np.interp(at, time, column) for column in values.T]
    return np.column_stack(columns) if columns else np.zeros((at.size, 0))


def cubic(at: Floats, time: Floats, value: NDArray[Any], slope: NDArray[Any]) -> NDArray[Any]:
    """Hermite's cubic through values with slopes, at the times ``at``."""
    i = np.clip(np.searchsorted(time, at, side="right") - 1, 0, time.size - 2)
    across = (slice(None),) + (None,) * (value.ndim - 1)
    step = (time[i + 1] - time[i])[across]
    s = (at - time[i])[across] / step
    rise = value[i + 1] - value[i]
    a, b = slope[i] * step - rise, rise - slope[i + 1] * step
    return np.asarray(value[i] + s * rise + s * (1.0 - s) * (a * (1.0 - s) + b * s))


class Races(NamedTuple):
    """What does not move: one entry a ball."""

    orbit_radius: Floats  # m
    ball_diameter: Floats  # m, 0 if not given
    ball_moment: Floats  # kg m
    center: Complexes  # race center in the rotor, m
    balancer: NDArray[np.int64]  # from 1
    race: NDArray[np.int64]  # from 1, within its balancer
    plane: NDArray[np.int64]  # from 0
    body: NDArray[np.object_]  # "ball", "roller" or "pendulum"
    channel: Floats  # m, from wall to wall: the ball diameter of guided balls

    def vectors(self, moments: Moments) -> Complexes:
        """What each ball contributes, kg m, in the frame of the rotor: (times, balls)."""
        mass = np.divide(
            self.ball_moment, self.orbit_radius, out=np.zeros_like(self.orbit_radius), where=self.orbit_radius > 0.0
        )
        around = (self.ball_moment - mass * moments.ball_inside) * np.exp(1j * moments.ball_angle_in_rotor)
        return np.asarray(around + mass * self.center)

    def resultant(self, moments: Moments) -> Complexes:
        """Unbalance with all balls, kg m, in the frame of the rotor."""
        return np.asarray(moments.unbalance_in_rotor + self.vectors(moments).sum(axis=-1))

    def of(self, balls: NDArray[np.intp]) -> Races:
        """Some balls alone."""
        return self._replace(**{name: column[balls] for name, column in self._asdict().items()})


def races_of(run: xr.Dataset) -> Races:
    """The balls and races of a run; lengths that a result does not know are 0, counts 1."""
    count = run.sizes.get("ball", 0)
    return Races(
        _known(run, "orbit_radius", (count,)),
        _known(run, "ball_diameter", (count,)),
        _known(run, "ball_moment", (count,)),
        _known(run, "race_center_x", (count,)) + 1j * _known(run, "race_center_y", (count,)),
        _known(run, "balancer", (count,), 1.0).astype(np.int64),
        _known(run, "race", (count,), 1.0).astype(np.int64),
        _known(run, "ball_plane", (count,), 1.0).astype(np.int64) - 1,
        bodies_of(run),
        np.maximum(_known(run, "ball_diameter", (count,)), resolved_widths(run)),
    )


def bodies_of(run: xr.Dataset) -> NDArray[np.object_]:
    """What each ball of a run is: "ball", "roller" or "pendulum"."""
    if "ball_body" in run:
        return np.asarray(run["ball_body"].values, dtype=object)
    return np.full(run.sizes.get("ball", 0), "ball", dtype=object)


def _known(run: xr.Dataset, name: str, shape: tuple[int, ...], otherwise: float = 0.0) -> Floats:
    return np.asarray(run[name].values, np.float64) if name in run else np.full(shape, otherwise)


# How wide pictures draw the races of resolved balls.


def resolved_widths(run: xr.Dataset) -> NDArray[np.float64]:
    """From the outer to the inner wall, m, for each ball; 0 for guided balls, which never leave the outer one."""
    widths = np.zeros(run.sizes.get("ball", 0))
    if "ball_gap" not in run:
        return widths
    for b, balancer in enumerate(tomllib.loads(run.attrs.get("machine", "")).get("balancers", []), 1):
        for r, race in enumerate(balancer.get("races", []), 1):
            if "resolved" in race and "width" in race:
                here = (run["balancer"].values == b) & (run["race"].values == r)
                widths[here] = argument("width", race["width"], "m")
    return widths


# What pictures draw of the forces on the balls of a run: lines in the axes of each race.


ForcesOfRaces = dict[tuple[int, int], list[Force]]


def forces_of(run: xr.Dataset) -> ForcesOfRaces:
    """The forces of each race, by the numbers of its balancer and itself from 1; those that are not known here are left out."""
    text = run.attrs.get("machine", "")
    result: ForcesOfRaces = {}
    if "forces" not in text:
        return result
    for b, balancer in enumerate(tomllib.loads(text).get("balancers", []), 1):
        for r, race in enumerate(balancer.get("races", []), 1):
            forces = race.get("forces", [])
            for table in forces if isinstance(forces, list) else [forces]:
                with suppress(MachineError):
                    result.setdefault((b, r), []).append(_leaf(table))
    return result


def _leaf(table: dict[str, Any]) -> Force:
    leaf = find(Force, table.get("kind"))(**table)
    assert isinstance(leaf, Force)
    return leaf


def lines_of(forces: list[Force], orbit: float, places: list[complex], speed: float) -> list[list[complex]]:
    """All lines of the forces of one race with balls at these places from its center, m, at a ``speed`` of the rotor, rad/s."""
    return [line for force in forces for line in force.drawn(orbit, places, speed)]
