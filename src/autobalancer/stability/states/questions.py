"""The two questions of every designer: which states are there, and which of them are stable."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations
from pathlib import Path
from typing import Any, Literal

import numpy as np
import xarray as xr

from autobalancer.arrays import Complexes
from autobalancer.assembly.terms import Theory
from autobalancer.catalog.resolve import resolve
from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import balls_in_races
from autobalancer.machine import Machine
from autobalancer.results.answers.answer import Answer
from autobalancer.results.answers.forms import verdict_ranges
from autobalancer.results.labels import labeled
from autobalancer.stability.border import attributes
from autobalancer.stability.host.reduction import reduced
from autobalancer.stability.host.stations import Stations, station_form
from autobalancer.stability.states.linearized import exponents_of, growth, in_mean, modes, motion_name, verdict
from autobalancer.stability.states.rest_states import (
    StationState,
    balanced_of,
    required,
    states_of,
    why_no_state,
    without_exchanges,
)
from autobalancer.units import argument, list_argument, unbalance_argument

Progress = Callable[[int, int], None]
Kind = Literal["balanced", "mixed", "coincident", "in line", "spread"]
TOUCH = 1e-9  # of the distance at which balls touch
PERIODIC = "periodic state: see the Floquet multipliers"


def equilibria(
    machine: Machine | str | Path, speed: float | str, *, unbalance: complex | float | str | None = None
) -> Answer:
    """All states in which the balls rest in the rotor at a constant speed, with their stability.

    Parameters
    ----------
    machine
        A machine or the path of a machine file.
    speed
        Rotor speed, rad/s.
    unbalance
        kg m, complex for one off the zero mark; by default that of the machine after all its schedules. On rotors that
        tilt or bend it replaces the machine's unbalance if there is only one.

    Returns
    -------
    xarray.Dataset
        Along ``state``: name (*balanced*, *coincident*, *in line*), whether balls of their size would be ``overlapping``,
        ball angles (rad), deflection (m; its forward part on orthotropic supports), residual unbalance, dimension of the
        continuum, eigenvalues (1/s; Floquet exponents on orthotropic supports), growth rate, verdict, and what moves in the
        leading mode. States that differ only by an
        exchange of equal balls are listed once. Where the rotor tilts or bends also ``deflection_at_station`` and
        ``required_moment`` (kg m, what the balls of each station have to add up to so that no station vibrates), and
        *mixed* states, in which some stations rest and others do not; ``deflection`` is that of the first balancer.

    Raises
    ------
    QuestionError
        At standstill, at an undamped critical speed, or with gravity in the plane.
    """
    speed = argument("speed", speed, "rad/s")
    unbalance = unbalance_argument(unbalance)
    machine = balls_in_races(machine)
    st = host_of(machine, unbalance, speed)
    # all states, and what the linear equations say of each
    states = [in_mean(st, speed, state) for state in without_exchanges(st, states_of(st, speed))]
    rows = [judged(st, speed, state) for state in states]
    n, places = st.moment.size, len(st.names)
    modes = rows[0][0].size if rows else 0
    angles = np.array([state.angles for state in states]).reshape(len(states), n)
    whirl = np.array([state.whirl for state in states]).reshape(len(states), places)
    # what is left of the unbalance, and the table
    load = st.unbalance + (st.ball_mass * st.offset).sum() + (st.moment * np.exp(1j * angles)).sum(axis=1)
    first = whirl[:, 0] if places else np.zeros(len(states), np.complex128)
    values = np.array([row[0] for row in rows]).reshape(len(states), modes)
    rates = [_rate(row[0], state) for row, state in zip(rows, states, strict=True)]
    where = _place_text(st)
    verdicts = ["not found" if np.isnan(rate) else verdict(rate, speed) for rate in rates]
    data: dict[str, tuple[Any, ...]] = {
        "name": ("state", [state.name for state in states], "name of the state", ""),
        "ball_angle_in_rotor": (("state", "ball"), angles, "ball angle in the rotor", "rad"),
        "deflection": ("state", np.abs(first), f"deflection{where}", "m"),
        "deflection_angle_in_rotor": ("state", np.angle(first), "direction of the deflection in the rotor", "rad"),
        "residual_unbalance": ("state", np.abs(load), "resultant of unbalance and balls", "kg m"),
        "freedom": ("state", [state.freedom for state in states], "dimension of the continuum of such states", ""),
        "outward": ("state", [state.outward for state in states], "balls that stand outward", ""),
        "eigenvalue_real": (("state", "mode"), values.real, "real part of the eigenvalue", "1/s"),
        "eigenvalue_imag": (("state", "mode"), values.imag, "imaginary part", "rad/s"),
        "overlapping": ("state", overlapping(machine, states), "balls of their size would overlap in it", ""),
        "growth_rate": ("state", rates, "growth rate", "1/s"),
        "leading_motion": ("state", [text for _, text in rows], "what moves in the leading mode", ""),
    }
    if where:
        needed = required(st, speed) if n else np.zeros(0, np.complex128)
        data |= {
            "deflection_at_station": (("state", "station"), np.abs(whirl), "deflection at the stations", "m"),
            "required_moment": ("station", np.abs(needed), "what the balls of a station have to add up to", "kg m"),
            "required_moment_angle": ("station", np.angle(needed), "direction of that in the rotor", "rad"),
        }
    data["verdict"] = ("state", verdicts, "stable, marginal or unstable")
    result = labeled(data, None, _attributes(machine, st, f"Steady states of {machine.name}") | {"speed": speed})
    result = result.assign_coords({"mode": np.arange(1, modes + 1), "ball": np.arange(1, n + 1)} | _station_names(st))
    return Answer.of(result, "Equilibria")


def eigenvalues(
    machine: Machine | str | Path,
    speeds: Sequence[float | str],
    *,
    state: Kind = "balanced",
    outward: int | None = None,
    unbalance: complex | float | str | None = None,
    progress: Progress | None = None,
) -> Answer:
    """Eigenvalues of one kind of steady state over the speed.

    Parameters
    ----------
    machine
        A machine or the path of a machine file.
    speeds
        Rotor speeds, rad/s.
    state, outward
        Which state: its name, and for *in line* or *coincident* how many balls are on the outward side. Of several states of
        one kind the most stable one is used.
    unbalance
        As for :func:`equilibria`.
    progress
        Called with (speeds done, speeds in all).

    Returns
    -------
    xarray.Dataset
        ``eigenvalue_real`` and ``eigenvalue_imag`` over ``speed`` and ``mode``; ``growth_rate``, ``verdict``. Speeds at
        which there is no such state are left out and listed in ``attrs["speeds_without_state"]``.

    Raises
    ------
    QuestionError
        If there is no such state at any of the speeds; the message says why.
    """
    speeds = list_argument("speeds", speeds, "rad/s")
    unbalance = unbalance_argument(unbalance)
    machine = balls_in_races(machine)
    st = host_of(machine, unbalance, max(map(float, speeds), default=0.0))
    rows: list[tuple[float, StationState, Complexes, str]] = []
    missing = []
    for number, speed in enumerate(map(float, speeds)):
        every = balanced_of(st, speed) if state == "balanced" and st.moment.size else states_of(st, speed)
        wanted = [s for s in without_exchanges(st, every) if s.name == state and outward in (None, s.outward)]
        states = [in_mean(st, speed, s) for s in wanted]
        items = [(speed, s, *judged(st, speed, s)) for s in states]
        items = [row for row in items if not np.isnan(row[2]).any()]
        if items:
            rows.append(min(items, key=lambda row: _rate(row[2], row[1])))
        else:
            missing.append(speed)
        if progress is not None:
            progress(number + 1, len(speeds))
    if not rows:
        why = f"no state {state!r} at any of these speeds" if state != "balanced" else why_no_state(st)
        raise QuestionError(why if st.moment.size else "the machine has no balls; there is no such state")
    values = np.array([row[2] for row in rows])
    rates = [_rate(row[2], row[1]) for row in rows]
    whirl = np.abs(np.array([row[1].whirl for row in rows]))
    where = _place_text(st)
    both = ("speed", "mode")
    data: dict[str, tuple[Any, ...]] = {
        "eigenvalue_real": (both, values.real, "real part", "1/s"),
        "eigenvalue_imag": (both, values.imag, "imaginary part", "rad/s"),
        "growth_rate": ("speed", rates, "growth rate", "1/s"),
        "verdict": ("speed", [verdict(rate, row[0]) for rate, row in zip(rates, rows, strict=True)]),
        "deflection": ("speed", whirl[:, 0], f"deflection{where}", "m"),
        "leading_motion": ("speed", [row[3] for row in rows], "what moves in the leading mode"),
    }
    if where:
        data["deflection_at_station"] = (("speed", "station"), whirl, "deflection", "m")
    result = labeled(
        data,
        {"speed": ("speed", [row[0] for row in rows], "rotor speed", "rad/s")},
        _attributes(machine, st, f"Stability of {machine.name}, {state}")
        | {"state": state, "speeds_without_state": missing},
    ).assign_coords(_station_names(st))
    return Answer.of(result, "Eigenvalues")


def host_of(machine: Machine, unbalance: complex | float | None, highest: float) -> Stations:
    """The stations of any machine; a planar one is a single station. Anisotropic rotors have fewer coordinates, up to a speed."""
    st = station_form(machine, unbalance)
    return st if st.planar or st.isotropic or not highest > 0.0 else reduced(st, highest)


def judged(st: Stations, speed: float, state: StationState) -> tuple[Complexes, str]:
    """Eigenvalues, or Floquet exponents on anisotropic supports (nan if there is no such state), and what moves."""
    if st.isotropic:
        values, vectors = modes(st, speed, state)
        return values, motion_name(vectors[:, 0], st, values[0], speed)
    try:
        return exponents_of(st, speed, state), PERIODIC
    except QuestionError:
        count = 2 * (st.moment.size + (st.model.size if st.plain else 2 * st.model.pairs))
        return np.full(count, np.nan, np.complex128), "no periodic state near this one"


def overlapping(machine: Machine, states: Sequence[StationState]) -> list[bool]:
    """Whether balls of the size that they have, which do not pass through each other, would have to overlap in each state.

    Of a continuum it is not known: others of it may have room.
    """
    balls, races = resolve(machine), [balancer.races for balancer in machine.balancers]
    pairs = [
        (i, j)
        for i, j in combinations(range(len(balls)), 2)
        if (balls[i].balancer, balls[i].race) == (balls[j].balancer, balls[j].race)
        and races[balls[i].balancer][balls[i].race].collisions
    ]
    orbit, radius = np.array([[ball.orbit_radius, ball.radius] for ball in balls]).reshape(-1, 2).T
    result = []
    for state in states:
        place = orbit * np.exp(1j * state.angles)
        touches = [abs(place[i] - place[j]) < (radius[i] + radius[j]) * (1.0 - TOUCH) for i, j in pairs]
        result.append(any(touches) and state.freedom == 0)
    return result


def _place_text(st: Stations) -> str:
    """What a deflection is of, on rotors with more than one plane."""
    return "" if st.planar else " at the first balancer"


def _rate(values: Complexes, state: StationState) -> float:
    return float("nan") if np.isnan(values).any() else growth(values, state.freedom)


def _attributes(machine: Machine, st: Stations, title: str) -> dict[str, Any]:
    return attributes(machine, title, Theory.AT_REST) | {
        "unbalance": abs(st.unbalance),
        "theory": "exact: full equations" + ("" if st.isotropic else ", Floquet exponents"),
    }


def _station_names(st: Stations) -> dict[str, Any]:
    """As a coordinate, on rotors with more than one plane."""
    return {} if st.planar else {"station": ("station", list(st.names))}


# Ranges of speed with one verdict, their ends found by bisection.


CLOSE = 1e-7  # of a speed: how closely a change of the verdict is located


def ranges(machine: Machine | str | Path, found: xr.Dataset, unbalance: complex | float | str | None = None) -> Answer:
    """Ranges of speed in which a state keeps its verdict.

    Parameters
    ----------
    machine
        The machine of ``found``.
    found
        From :func:`~autobalancer.stability.states.questions.eigenvalues`. Where the verdict changes between two of its speeds,
        the speed of the change is sought by bisection; a range that lies between two speeds of ``found`` is not seen.
    unbalance
        As it was given there.

    Returns
    -------
    xarray.Dataset
        Along ``range``: ``from_speed``, ``to_speed`` (rad/s), ``verdict``, the greatest ``growth_rate`` at the speeds of
        ``found`` (1/s), and the ``leading_motion`` there.
    """
    machine, unbalance = balls_in_races(machine), unbalance_argument(unbalance)
    result = verdict_ranges(found)
    starts, ends = (result[name].values for name in ("from_speed", "to_speed"))
    for k, before in enumerate(result["verdict"].values[:-1]):
        low, high = float(ends[k]), float(starts[k + 1])
        change = None if result["gap"][k + 1] else _change(machine, found.attrs["state"], unbalance, low, high, before)
        if change is not None:
            ends[k] = starts[k + 1] = change
    return result.drop_vars("gap")


def _change(
    machine: Machine, state: Any, unbalance: complex | float | None, low: float, high: float, before: str
) -> float | None:
    """The speed at which the verdict of the lower range ends; ``None`` where there is no state in between."""
    while high - low > CLOSE * high:
        middle = 0.5 * (low + high)
        try:
            at = eigenvalues(machine, [middle], state=state, unbalance=unbalance)
        except QuestionError:
            return None
        low, high = (middle, high) if at["verdict"].values[0] == before else (low, middle)
    return 0.5 * (low + high)
