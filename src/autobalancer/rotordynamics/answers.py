"""What the questions about the rotor answer, as tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from autobalancer.results.answers.answer import Answer, at_speed
from autobalancer.results.display_units import length_axis, speed_axis
from autobalancer.shown import Column, rpm_and_si

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
        found = [self.scaled("critical_speed", "critical speed", unit), self.texts("whirl", "whirl")]
        if np.any(self["harmonic"].values != 1.0):
            found.append(Column("frequency over speed", self["harmonic"].values, form="g"))
        return [*found, self.texts("name", "mode")]


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
    found = []
    if third > 0.0:
        found.append(
            "rubber in ellipses: first harmonic of its force; the third, left out, would move it by "
            f"{100.0 * third:.2g} % at most"
        )
    if len(beyond):
        found.append(
            f"rubber of {', '.join(beyond)}: moves farther than its largest breakaway amplitude; its loss force no longer grows "
            "there, as that of real rubber probably does. Give it a further element"
        )
    return tuple(found)


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
        one = self[[*self.needed, "critical_speed"]].stack(one=("way", "direction"))
        speeds = (
            ("critical_speed", "critical speed", ".5g"),
            ("valid_from", "holds from", ".4g"),
            ("valid_to", "holds to", ".4g"),
        )
        shown = speed_axis(unit or self.shown_in)
        return [
            Column("way", [str(way) for way in one["way"].values]),
            Column("along", [str(direction) for direction in one["direction"].values]),
            Column("stiffness", one["stiffness"].values, "N/m"),
            Column("mass", one["mass"].values, "kg", ".4g"),
            Column("damping", one["damping"].values, "N s/m", ".4g"),
            *(Column(head, one[name].values * shown.factor, shown.sign, form) for name, head, form in speeds),
        ]

    def has_table(self) -> bool:
        """Both directions must be there, too."""
        return super().has_table() and "direction" in self["stiffness"].dims

    def remarks(self) -> Sequence[str]:
        """Which way was taken, and what to be careful about."""
        taken = [f"taken: {self.attrs['chosen']}"] if "chosen" in self.attrs else []
        return [*super().remarks(), *taken, *map(str, self.attrs.get("notes", ()))]
