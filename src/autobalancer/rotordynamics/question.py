"""What every question of this package starts with: the rotor, its places and the speeds, checked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from autobalancer.assembly.rotors import LateralModel, Rows, lateral_model, reference, rows_at, with_ball_mass
from autobalancer.assembly.rotors.model import Floats
from autobalancer.assembly.rotors.rigid import Point
from autobalancer.assembly.terms import Theory, unknown
from autobalancer.errors import QuestionError
from autobalancer.files.given import balls_in_races
from autobalancer.files.machine_file import machine_text
from autobalancer.machine import Machine
from autobalancer.results.provenance import provenance

FEWEST = 21  # places along the axis, so that a shape is drawn as a shape


@dataclass(frozen=True)
class Places:
    """Places across the rotor: names, positions along the axis (m, nan where there is none) and rows."""

    names: list[str]
    positions: Floats
    deflection: Floats  # (places, pairs)


def rotor_of(machine: Machine | str | Path, *, balls: bool) -> tuple[Machine, LateralModel]:
    """The machine and its model, with the masses of the balls on the rotor or without balls."""
    machine = balls_in_races(machine)
    model = lateral_model(machine)
    return machine, with_ball_mass(machine, model) if balls else model


def checked_speeds(speeds: Sequence[float] | Floats | float, model: LateralModel, owner: str) -> Floats:
    """Finite speeds from zero to the end of the tables, ascending or not, (S,).

    Raises
    ------
    QuestionError
        If there is none, one is negative or not finite, or the tables of the rotor do not reach it.
    """
    array = np.atleast_1d(np.asarray(speeds, np.float64))
    if array.ndim != 1 or array.size == 0:
        raise QuestionError(f"{owner}: speeds: given none; give at least one, in rad/s")
    wrong = array[~np.isfinite(array) | (array < 0.0)]
    if wrong.size:
        raise QuestionError(
            f"{owner}: speeds: given {wrong[0]:g} rad/s; must be finite and not negative (backward whirl has its own sign)"
        )
    if array.max() > model.top_speed * (1.0 + 1e-12):
        raise QuestionError(
            f"{owner}: speeds: given up to {array.max():g} rad/s, but the tables of the rotor end at "
            f"{model.top_speed:g} rad/s; ask for less, or extend them"
        )
    return array


def chosen_places(
    machine: Machine, model: LateralModel, stations: Sequence[str | float] | str | float | None, owner: str
) -> Places:
    """The places asked for: names of stations or positions (m); ``None`` is all stations, else the reference place.

    Raises
    ------
    QuestionError
        If the list is empty, or a station is unknown.
    MachineError
        If a position is not on the rotor.
    """
    if stations is None:
        stations = [station.name for station in machine.stations]
        if not stations:
            name, rows = reference(machine, model)
            return Places([name], np.array([np.nan]), rows.deflection[None])
    wanted = [stations] if isinstance(stations, (str, int, float)) else list(stations)
    if not wanted:
        raise QuestionError(f"{owner}: stations: given none; name at least one, or leave them out for all")
    known = {station.name: float(station.position) for station in machine.stations}
    names, positions, rows_found = [], [], []
    for place in wanted:
        if isinstance(place, str) and place not in known:
            there = ", ".join(map(repr, known)) or "none"
            raise QuestionError(f"{owner}: stations: no station is named {place!r}; there is {there}")
        names.append(place if isinstance(place, str) else f"z = {float(place):g} m")
        positions.append(known[place] if isinstance(place, str) else float(place))
        rows_found.append(rows_at(machine, model, place, "stations").deflection)
    return Places(names, np.array(positions), np.array(rows_found))


def along_axis(machine: Machine, model: LateralModel) -> Places:
    """Places from end to end, planes of stations and balancers that overhang included.

    A rotor that tilts on one support is shown to a radius of gyration on both sides of it.
    """
    line = [(z, rows.deflection) for z, rows in model.axis.line()]
    low, high = min(z for z, _ in line), max(z for z, _ in line)
    if model.pairs > 1 and not isinstance(model.axis, Point):  # the modes of a rotor at one plane have no length
        if low == high:
            reach = float(np.sqrt(model.mass[1, 1] / model.mass[0, 0]))
            line += [(z, model.axis.rows(z, None).deflection) for z in (low - reach, low + reach)]
        line += [(z, rows.deflection) for z, rows in _overhanging(machine, model) if not low <= z <= high]
    line.sort(key=lambda entry: entry[0])
    positions, deflection = np.array([z for z, _ in line]), np.array([row for _, row in line])
    if 1 < positions.size < FEWEST:
        finer = np.union1d(np.linspace(positions[0], positions[-1], FEWEST), positions)
        deflection = np.array([np.interp(finer, positions, column) for column in deflection.T]).T
        positions = finer
    return Places([f"{z:g}" for z in positions], positions, deflection)


def _overhanging(machine: Machine, model: LateralModel) -> list[tuple[float, Rows]]:
    known = {station.name: station for station in machine.stations}
    found: list[tuple[float, Rows]] = []
    for place in [*known, *(balancer.station for balancer in machine.balancers)]:
        if isinstance(place, str) and known[place].body is None:
            found.append((float(known[place].position), rows_at(machine, model, place, "stations")))
        elif isinstance(place, float):
            found.append((float(place), rows_at(machine, model, place, "balancers")))
    return found


def attributes(machine: Machine, title: str, *, balls: bool, theory: Theory = Theory.ROTOR) -> dict[str, Any]:
    """What every result of this package carries."""
    return {
        "title": title,
        **provenance(),
        "machine": machine_text(machine),
        "machine_name": machine.name,
        "balls": "their mass is on the rotor" if balls else "none",
        "ignores": ", ".join(unknown(machine, theory)),
    }
