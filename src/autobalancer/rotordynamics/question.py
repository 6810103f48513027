"""What every question of this package starts with: the rotor, its places and the speeds, checked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from autobalancer.assembly.rotors import LateralModel, Rows, lateral_model, reference, rows_at, with_ball_mass
from autobalancer.assembly.rotors.lateral_model import Floats
from autobalancer.assembly.rotors.rigid import Point
from autobalancer.assembly.terms import Theory, unknown
from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import balls_in_races, machine_text
from autobalancer.machine import Machine
from autobalancer.results.answers.answer import Answer, at_speed
from autobalancer.results.display_units import length_axis, speed_axis
from autobalancer.results.provenance import provenance
from autobalancer.tables import Column, rpm_and_si

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
    overhanging: list[tuple[float, Rows]] = []
    for place in [*known, *(balancer.station for balancer in machine.balancers)]:
        if isinstance(place, str) and known[place].body is None:
            overhanging.append((float(known[place].position), rows_at(machine, model, place, "stations")))
        elif isinstance(place, float):
            overhanging.append((float(place), rows_at(machine, model, place, "balancers")))
    return overhanging


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


# What the questions about the rotor answer, as tables.


RATES = {"displacement": "", "velocity": "/s", "acceleration": "/s²"}


class Modes(Answer):
    """Natural frequencies at one speed."""

    __slots__ = ()
    drawn_by = "modes"
    row_of, needed, shown_in = "mode", ("name", "frequency", "damping_ratio", "whirl"), "Hz"

    def columns(self, unit: str = "") -> list[Column]:
        """Name, frequency in ``unit``, damping ratio and whirl of each mode."""
        return [
            self.texts("name", "mode"),
            self.scaled("frequency", "frequency", unit),
            Column("damping ratio", 100.0 * self["damping_ratio"].values, "%", ".3g"),
            self.texts("whirl", "whirl"),
        ]

    def remarks(self) -> Sequence[str]:
        """What is said where there is none, and what is left out."""
        return (*(() if self.sizes["mode"] else ("nothing oscillates",)), *super().remarks())

    def heading(self) -> str:
        """Whose they are, and at which speed."""
        return f"{self.attrs.get('machine_name', 'rotor')}: natural frequencies {at_speed(self)}"


class CriticalSpeeds(Answer):
    """Critical speeds of a rotor."""

    __slots__ = ()
    row_of, needed = "critical", ("critical_speed", "harmonic", "whirl", "name")

    def columns(self, unit: str = "") -> list[Column]:
        """Speed, whirl and shape; the harmonic if there is one that is not the speed itself."""
        columns = [self.scaled("critical_speed", "critical speed", unit), self.texts("whirl", "whirl")]
        if np.any(self["harmonic"].values != 1.0):
            columns.append(Column("frequency over speed", self["harmonic"].values, form="g"))
        return [*columns, self.texts("name", "mode")]


class Campbell(Answer):
    """Natural frequencies over the speed; the table has the intersections with the lines of the speed."""

    __slots__ = ()
    drawn_by = "campbell"
    row_of, needed = "intersection", ("intersection_speed", "intersection_harmonic", "intersection_branch")

    def columns(self, unit: str = "") -> list[Column]:
        """Where a branch meets a multiple of the speed."""
        names = self["name"].values[self["intersection_branch"].values - 1]
        return [
            self.scaled("intersection_speed", "meets at", unit),
            Column("frequency over speed", self["intersection_harmonic"].values, form="g"),
            self.texts("intersection_whirl", "whirl"),
            Column("branch", [str(name) for name in names], wraps=True),
        ]

    def has_table(self) -> bool:
        """Branches must be there too."""
        return super().has_table() and "branch" in self["name"].dims

    def remarks(self) -> Sequence[str]:
        """How many branches there are, over which speeds."""
        low, high = (rpm_and_si(float(self["speed"].values[place])) for place in (0, -1))
        nothing = () if self.sizes["intersection"] else ("no branch meets the speed in this range",)
        return (*super().remarks(), *nothing, f"{self.sizes['branch']} branches from {low} to {high}")


class Response(Answer):
    """The response to unbalance over the speed; the table has the greatest of each station."""

    __slots__ = ()
    drawn_by = "response"
    row_of, needed = "speed", ("semi_major",)

    def columns(self, unit: str = "") -> list[Column]:
        """Each station at the speed at which it moves most."""
        size = self["semi_major"].transpose("station", "speed").values
        place = size.argmax(axis=1)
        length = length_axis(None, float(np.nanmax(size, initial=0.0)))
        quantity = str(self.attrs.get("quantity", "displacement"))
        at = self.isel(speed=place)
        return [
            self.texts("station", "station"),
            Column(f"greatest {quantity}", size.max(axis=1) * length.factor, length.sign + RATES.get(quantity, "")),
            at.scaled("speed", "at", unit),
        ]

    def remarks(self) -> Sequence[str]:
        """What rubber that softens with the amplitude does to the curve, and what is left out."""
        return (*rubber_remarks(self.attrs), *super().remarks())

    def has_table(self) -> bool:
        """Several speeds and stations must be there."""
        return "semi_major" in self and set(self["semi_major"].dims) == {"speed", "station"} and self.sizes["speed"] > 0


def rubber_remarks(attrs: Mapping[str, Any]) -> tuple[str, ...]:
    """Where rubber moves farther than its elements, and what its first harmonic leaves out."""
    beyond, third = attrs.get("rubber_beyond_its_elements", ()), attrs.get("rubber_third_harmonic", 0.0)
    rubber_remarks = []
    if third > 0.0:
        rubber_remarks.append(
            "rubber in ellipses: first harmonic of its force; the third, left out, would move it by "
            f"{100.0 * third:.2g} % at most"
        )
    if len(beyond):
        rubber_remarks.append(
            f"rubber of {', '.join(beyond)}: moves farther than its largest breakaway amplitude; its loss force no longer grows "
            "there, as that of real rubber probably does. Give it a further element"
        )
    return tuple(rubber_remarks)


class ResponsePeaks(Answer):
    """Peaks of the response to unbalance."""

    __slots__ = ()
    row_of, needed = "peak", ("peak_speed", "peak_amplitude")

    def columns(self, unit: str = "") -> list[Column]:
        """Speed and height of each."""
        size = self["peak_amplitude"].values
        length = length_axis(None, float(np.nanmax(size, initial=0.0)))
        sign = length.sign + RATES.get(str(self.attrs.get("quantity", "displacement")), "")
        return [self.scaled("peak_speed", "peak at", unit), Column("amplitude", size * length.factor, sign)]

    def remarks(self) -> Sequence[str]:
        """What is said where there is none."""
        return [*super().remarks(), *([] if self.sizes["peak"] else ["no peak in this range"])]


class PlanarOscillators(Answer):
    """Oscillators that stand for a rotor at a place: one in each direction, found in two ways."""

    __slots__ = ()
    row_of, needed = "way", ("stiffness", "mass", "damping", "valid_from", "valid_to")

    def columns(self, unit: str = "") -> list[Column]:
        """Constants of each, its critical speed, and the speeds between which it holds."""
        matrix = self[[*self.needed, "critical_speed"]].stack(one=("way", "direction"))
        speeds = (
            ("critical_speed", "critical speed", ".5g"),
            ("valid_from", "holds from", ".4g"),
            ("valid_to", "holds to", ".4g"),
        )
        shown = speed_axis(unit or self.shown_in)
        return [
            Column("way", [str(way) for way in matrix["way"].values]),
            Column("along", [str(direction) for direction in matrix["direction"].values]),
            Column("stiffness", matrix["stiffness"].values, "N/m"),
            Column("mass", matrix["mass"].values, "kg", ".4g"),
            Column("damping", matrix["damping"].values, "N s/m", ".4g"),
            *(Column(head, matrix[name].values * shown.factor, shown.sign, form) for name, head, form in speeds),
        ]

    def has_table(self) -> bool:
        """Both directions must be there, too."""
        return super().has_table() and "direction" in self["stiffness"].dims

    def remarks(self) -> Sequence[str]:
        """Which way was taken, and what to be careful about."""
        taken = [f"taken: {self.attrs['chosen']}"] if "chosen" in self.attrs else []
        for direction in self["direction"].values if taken else ():
            ends = self.sel(way=self.attrs["chosen"], direction=direction)
            if np.isnan(ends["valid_from"]) or np.isnan(ends["valid_to"]):
                taken.append(
                    f"along {direction} it does not hold anywhere near its critical speed; look at its picture"
                )
        return [*super().remarks(), *taken, *map(str, self.attrs.get("notes", ()))]
