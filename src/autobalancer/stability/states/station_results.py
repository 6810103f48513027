"""Steady states and eigenvalues of rotors that tilt or bend, as labelled arrays; the ways in are in ``questions``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import machine_text
from autobalancer.machine import Machine
from autobalancer.results.provenance import provenance
from autobalancer.stability.host.planar import Complexes
from autobalancer.stability.host.stations import Stations, stations
from autobalancer.stability.ignored import ignored_at_rest
from autobalancer.stability.states.described import why_no_state
from autobalancer.stability.states.exchanges import without_exchanges
from autobalancer.stability.states.linear import eigensystem
from autobalancer.stability.states.station_floquet import exponents_of
from autobalancer.stability.states.station_linear import station_matrices, station_motion
from autobalancer.stability.states.stations import StationState, balanced_of, required, states_of
from autobalancer.stability.states.verdicts import growth, verdict

PERIODIC = "periodic state: see the Floquet multipliers"


def judged(st: Stations, speed: float, state: StationState) -> tuple[Complexes, str]:
    """Eigenvalues, or Floquet exponents on anisotropic supports (nan if there is no such state), and what moves."""
    if st.isotropic:
        values, vectors = eigensystem(*station_matrices(st, speed, state))
        return values, station_motion(vectors[:, 0], st, values[0], speed)
    try:
        return exponents_of(st, speed, state), PERIODIC
    except QuestionError:
        return np.full(2 * (st.model.size + st.moment.size), np.nan, np.complex128), "no periodic state near this one"


def station_equilibria(machine: Machine, speed: float, unbalance: complex | float | None) -> xr.Dataset:
    """:func:`autobalancer.equilibria` of a rotor that tilts or bends."""
    st = stations(machine, unbalance)
    states = without_exchanges(st, states_of(st, speed))
    rows = [judged(st, speed, state) for state in states]
    n, places = st.moment.size, len(st.names)
    modes = rows[0][0].size if rows else 0
    angles = np.array([state.angles for state in states]).reshape(len(states), n)
    whirl = np.array([state.whirl for state in states]).reshape(len(states), places)
    load = st.unbalance + (st.ball_mass * st.offset).sum() + (st.moment * np.exp(1j * angles)).sum(axis=1)
    needed = required(st, speed) if n else np.zeros(0, np.complex128)
    first = whirl[:, 0] if places else np.zeros(len(states), np.complex128)
    values = np.array([row[0] for row in rows]).reshape(len(states), modes)
    rates = [_rate(row[0], state) for row, state in zip(rows, states, strict=True)]
    data: dict[str, tuple[Any, Any, str, str]] = {
        "name": ("state", [state.name for state in states], "name of the state", ""),
        "ball_angle_in_rotor": (("state", "ball"), angles, "ball angle in the rotor", "rad"),
        "deflection": ("state", np.abs(first), "deflection at the first balancer", "m"),
        "deflection_angle_in_rotor": ("state", np.angle(first), "direction of the deflection in the rotor", "rad"),
        "deflection_at_station": (("state", "station"), np.abs(whirl), "deflection at the stations", "m"),
        "required_moment": ("station", np.abs(needed), "what the balls of a station have to add up to", "kg m"),
        "required_moment_angle": ("station", np.angle(needed), "direction of that in the rotor", "rad"),
        "residual_unbalance": ("state", np.abs(load), "resultant of point unbalances and balls", "kg m"),
        "freedom": ("state", [state.freedom for state in states], "dimension of the continuum of such states", ""),
        "outward": ("state", [state.outward for state in states], "balls that stand outward", ""),
        "eigenvalue_real": (("state", "mode"), values.real, "real part of the eigenvalue", "1/s"),
        "eigenvalue_imag": (("state", "mode"), values.imag, "imaginary part", "rad/s"),
        "growth_rate": ("state", rates, "growth rate", "1/s"),
        "leading_motion": ("state", [text for _, text in rows], "what moves in the leading mode", ""),
    }
    found = xr.Dataset(
        coords={"mode": np.arange(1, modes + 1), "ball": np.arange(1, n + 1), "station": ("station", list(st.names))}
    )
    for name, (dims, entries, text, unit) in data.items():
        found[name] = (dims, entries, {"long_name": text, "units": unit})
    verdicts = ["not found" if np.isnan(rate) else verdict(rate, speed) for rate in rates]
    found["verdict"] = ("state", verdicts, {"long_name": "stable, marginal or unstable"})
    found.attrs = _attributes(machine, st) | {"speed": speed, "title": f"Steady states of {machine.name}"}
    return found


def station_eigenvalues(
    machine: Machine,
    speeds: Sequence[float],
    state: str,
    outward: int | None,
    unbalance: complex | float | None,
    progress: Callable[[int, int], None] | None,
) -> xr.Dataset:
    """:func:`autobalancer.eigenvalues` of a rotor that tilts or bends."""
    st = stations(machine, unbalance)
    rows: list[tuple[float, StationState, Complexes, str]] = []
    missing = []
    for number, speed in enumerate(map(float, speeds)):
        every = balanced_of(st, speed) if state == "balanced" and st.moment.size else states_of(st, speed)
        states = [s for s in without_exchanges(st, every) if s.name == state and outward in (None, s.outward)]
        found = [(speed, s, *judged(st, speed, s)) for s in states]
        found = [row for row in found if not np.isnan(row[2]).any()]
        if found:
            rows.append(min(found, key=lambda row: _rate(row[2], row[1])))
        else:
            missing.append(speed)
        if progress is not None:
            progress(number + 1, len(speeds))
    if not rows:
        if st.moment.size == 0:
            raise QuestionError("the machine has no balls; there is no such state")
        raise QuestionError(why_no_state(st) if state == "balanced" else f"no state {state!r} at any of these speeds")
    values = np.array([row[2] for row in rows])
    rates = [_rate(row[2], row[1]) for row in rows]
    whirl = np.abs(np.array([row[1].whirl for row in rows]))
    result = xr.Dataset(
        {
            "eigenvalue_real": (("speed", "mode"), values.real, {"long_name": "real part", "units": "1/s"}),
            "eigenvalue_imag": (("speed", "mode"), values.imag, {"long_name": "imaginary part", "units": "rad/s"}),
            "growth_rate": ("speed", rates, {"long_name": "growth rate", "units": "1/s"}),
            "verdict": ("speed", [verdict(rate, row[0]) for rate, row in zip(rates, rows, strict=True)]),
            "deflection": ("speed", whirl[:, 0], {"long_name": "deflection at the first balancer", "units": "m"}),
            "deflection_at_station": (("speed", "station"), whirl, {"long_name": "deflection", "units": "m"}),
            "leading_motion": ("speed", [row[3] for row in rows], {"long_name": "what moves in the leading mode"}),
        },
        {
            "speed": ("speed", [row[0] for row in rows], {"long_name": "rotor speed", "units": "rad/s"}),
            "station": ("station", list(st.names)),
        },
    )
    extra = {"state": state, "speeds_without_state": missing, "title": f"Stability of {machine.name}, {state}"}
    result.attrs = _attributes(machine, st) | extra
    return result


def _rate(values: Complexes, state: StationState) -> float:
    return float("nan") if np.isnan(values).any() else growth(values, state.freedom)


def _attributes(machine: Machine, st: Stations) -> dict[str, Any]:
    return {
        **provenance(),
        "machine": machine_text(machine),
        "machine_name": machine.name,
        "unbalance": abs(st.unbalance),
        "theory": "exact: full equations" + ("" if st.isotropic else ", Floquet exponents"),
        "ignores": ", ".join(ignored_at_rest(machine)),
    }
