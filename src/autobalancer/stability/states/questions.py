"""The two questions of every designer: which states are there, and which of them are stable."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
import xarray as xr

from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import load_machine, machine_text
from autobalancer.machine import Machine, PlanarRotor
from autobalancer.results.provenance import provenance
from autobalancer.stability.host.planar import Complexes, Plane, plane
from autobalancer.stability.ignored import ignored_at_rest
from autobalancer.stability.states.floquet import periodic_state
from autobalancer.stability.states.linear import eigensystem, matrices, motion_name
from autobalancer.stability.states.planar import Equilibrium, equilibria_of
from autobalancer.stability.states.station_results import station_eigenvalues, station_equilibria
from autobalancer.stability.states.verdicts import growth, verdict
from autobalancer.units import argument, list_argument, unbalance_argument

Progress = Callable[[int, int], None]
Kind = Literal["balanced", "mixed", "coincident", "in line"]


def equilibria(
    machine: Machine | str | Path, speed: float | str, *, unbalance: complex | float | str | None = None
) -> xr.Dataset:
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
        Along ``state``: name (*balanced*, *coincident*, *in line*), ball angles (rad), deflection (m; its forward part
        on orthotropic supports), residual unbalance, dimension of the continuum, eigenvalues (1/s; Floquet exponents on
        orthotropic supports), growth rate, verdict, and what moves in the leading mode. States that differ only by an
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
    if not isinstance(machine, Machine):
        machine = load_machine(machine)
    if not isinstance(machine.rotor, PlanarRotor):
        return station_equilibria(machine, speed, unbalance)
    p = plane(machine, unbalance)
    states = equilibria_of(p, speed)
    rows = [_judged(machine, p, speed, state) for state in states]
    n, modes = p.moment.size, 4 + 2 * p.moment.size
    angles = np.array([state.angles for state in states]).reshape(len(states), n)
    whirl = np.array([state.whirl for state in states])
    load = np.array([p.fixed_load + (p.moment * np.exp(1j * state.angles)).sum() for state in states])
    data = {
        "name": ("state", [state.name for state in states], "name of the state", ""),
        "ball_angle_in_rotor": (("state", "ball"), angles, "ball angle in the rotor", "rad"),
        "deflection": ("state", np.abs(whirl), "deflection", "m"),
        "deflection_angle_in_rotor": ("state", np.angle(whirl), "direction of the deflection in the rotor", "rad"),
        "residual_unbalance": ("state", np.abs(load), "resultant of unbalance and balls", "kg m"),
        "freedom": ("state", [state.freedom for state in states], "dimension of the continuum of such states", ""),
        "outward": ("state", [state.outward for state in states], "balls that stand outward", ""),
        "eigenvalue_real": (
            ("state", "mode"),
            np.array([v.real for v, _ in rows]),
            "real part of the eigenvalue",
            "1/s",
        ),
        "eigenvalue_imag": (("state", "mode"), np.array([v.imag for v, _ in rows]), "imaginary part", "rad/s"),
        "growth_rate": (
            "state",
            [growth(v, s.freedom) for (v, _), s in zip(rows, states, strict=True)],
            "growth rate",
            "1/s",
        ),
        "leading_motion": ("state", [text for _, text in rows], "what moves in the leading mode", ""),
    }
    found = xr.Dataset(coords={"mode": np.arange(1, modes + 1), "ball": np.arange(1, n + 1)})
    for name, (dims, values, text, unit) in data.items():
        found[name] = (dims, values, {"long_name": text, "units": unit})
    verdicts = [verdict(rate, speed) for rate in found["growth_rate"].values]
    found["verdict"] = ("state", verdicts, {"long_name": "stable, marginal or unstable"})
    found.attrs = _attributes(machine, p) | {"speed": speed, "title": f"Steady states of {machine.name}"}
    return found


def eigenvalues(
    machine: Machine | str | Path,
    speeds: Sequence[float | str],
    *,
    state: Kind = "balanced",
    outward: int | None = None,
    unbalance: complex | float | str | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
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
    if not isinstance(machine, Machine):
        machine = load_machine(machine)
    if not isinstance(machine.rotor, PlanarRotor):
        return station_eigenvalues(machine, speeds, state, outward, unbalance, progress)
    p = plane(machine, unbalance)
    rows, missing = [], []
    for number, speed in enumerate(speeds):
        states = [s for s in equilibria_of(p, float(speed)) if s.name == state and outward in (None, s.outward)]
        if states:
            judged = [(s, *_judged(machine, p, float(speed), s)) for s in states]
            rows.append((float(speed), *min(judged, key=lambda row: growth(row[1], row[0].freedom))))
        else:
            missing.append(float(speed))
        if progress is not None:
            progress(number + 1, len(speeds))
    if not rows:
        raise QuestionError(_why_none(p, state))
    values = np.array([row[2] for row in rows])
    rates = [growth(row[2], row[1].freedom) for row in rows]
    found = xr.Dataset(
        {
            "eigenvalue_real": (("speed", "mode"), values.real, {"long_name": "real part", "units": "1/s"}),
            "eigenvalue_imag": (("speed", "mode"), values.imag, {"long_name": "imaginary part", "units": "rad/s"}),
            "growth_rate": ("speed", rates, {"long_name": "growth rate", "units": "1/s"}),
            "verdict": ("speed", [verdict(rate, row[0]) for rate, row in zip(rates, rows, strict=True)]),
            "deflection": ("speed", [abs(row[1].whirl) for row in rows], {"long_name": "deflection", "units": "m"}),
            "leading_motion": ("speed", [row[3] for row in rows], {"long_name": "what moves in the leading mode"}),
        },
        {"speed": ("speed", [row[0] for row in rows], {"long_name": "rotor speed", "units": "rad/s"})},
    )
    extra = {"state": state, "speeds_without_state": missing, "title": f"Stability of {machine.name}, {state}"}
    found.attrs = _attributes(machine, p) | extra
    return found


def eigenvalues_of(machine: Machine, p: Plane, speed: float, state: Equilibrium) -> Complexes:
    """Exact eigenvalues of the full equations, or Floquet exponents on orthotropic supports, 1/s."""
    return _judged(machine, p, speed, state)[0]


def _judged(machine: Machine, p: Plane, speed: float, state: Equilibrium) -> tuple[Complexes, str]:
    if p.isotropic:
        values, vectors = eigensystem(*matrices(p, speed, state))
        return values, motion_name(vectors[:, 0], p, values[0], speed)
    return periodic_state(machine, p, speed, state).exponents, "periodic state: see the Floquet multipliers"


def _why_none(p: Plane, state: str) -> str:
    need, have = abs(p.unbalance) * 1e6, min(p.moment.sum(), p.capability) * 1e6
    if p.moment.size == 0:
        return "the machine has no balls; there is no such state"
    if state == "balanced" and need > have:
        return f"no balanced state: the balls can balance {have:.4g} g mm at most, the unbalance is {need:.4g} g mm"
    if state == "balanced" and p.moment.size == 1:
        return "no balanced state: one ball alone balances only an unbalance of exactly its own moment"
    return f"no state '{state}' at any of these speeds"


def _attributes(machine: Machine, p: Plane) -> dict[str, Any]:
    return {
        **provenance(),
        "machine": machine_text(machine),
        "machine_name": machine.name,
        "unbalance": abs(p.unbalance),
        "theory": "exact: full equations" + ("" if p.isotropic else ", Floquet exponents"),
        "ignores": ", ".join(ignored_at_rest(machine)),
    }
