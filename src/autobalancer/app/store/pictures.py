"""Pictures for the page: Matplotlib's figures as SVG or PNG, one at a time, as Matplotlib is not made for several threads."""

from __future__ import annotations

import io
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from html import escape
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.machine import Machine
from autobalancer.plots.stability_map import map as draw_map
from autobalancer.plots.style import DRAWING, quantity_axis
from autobalancer.results.display_units import side_text
from autobalancer.tables import border_cell


def svg_of(draw: Callable[[], Any], about: str) -> str:
    """A figure as SVG for a page, with ``about`` for those who do not see it."""
    with DRAWING:
        buffer = io.StringIO()
        draw().savefig(buffer, format="svg")
    text = buffer.getvalue()
    words = escape(about, quote=True)
    fluid = f'<svg role="img" aria-label="{words}" class="drawn" '
    body = text[text.index("<svg ") + 5 :]
    head, rest = body.split(">", 1)
    return fluid + re.sub(r'\b(width|height)="[^"]*"', "", head) + ">" + rest


def file_of(draw: Callable[[], Any], kind: str) -> bytes:
    """A figure as the bytes of a PNG, SVG or PDF file."""
    with DRAWING:
        buffer = io.BytesIO()
        draw().savefig(buffer, format=kind, dpi=150)
    return buffer.getvalue()


# A point that is moved over a stability map: where it is in the picture, and what is known of the machine there.


STABLE, UNSTABLE, AT_BORDER, NO_STATE, OUTSIDE = "stable", "unstable", "at the border", "no balanced state", "outside"
VERDICT_TEXTS = {
    NO_STATE: "the balls cannot balance the rotor here",
    OUTSIDE: "outside of the map",
    AT_BORDER: "at the border of stability",
}
DIGITS = 4  # of a value that a point has


@dataclass(frozen=True)
class Scale:
    """An axis of a picture: which quantity stands at which share of its length, from the left or from below."""

    name: str
    label: str
    sign: str
    factor: float  # shown over SI
    low: float  # shown
    high: float
    log: bool

    def share(self, value: float) -> float:
        """Where a value (SI) stands; below 0 or above 1 outside, nan for none."""
        shown, low, high = value * self.factor, self.low, self.high
        if self.log:
            return math.log(shown / low) / math.log(high / low) if shown > 0.0 else math.nan
        return (shown - low) / (high - low)

    def value(self, share: float) -> float:
        """The value (SI) at a share within the axis, with few digits in the unit of the axis."""
        share = min(max(share, 0.0), 1.0)
        low, high = self.low, self.high
        shown = low * (high / low) ** share if self.log else low + (high - low) * share
        return float(f"{shown:.{DIGITS}g}") / self.factor

    @property
    def short(self) -> str:
        """A short name, with the unit."""
        name = self.name.replace("_", " ") if "." not in self.name else self.label
        return f"{name} ({self.sign})" if self.sign else name

    def text(self, value: float) -> str:
        """A value (SI) with its unit."""
        return f"{value * self.factor:.{DIGITS}g} {self.sign}".rstrip()


@dataclass(frozen=True)
class MapPicture:
    """The picture of a map, its size, and in this the left, top, width and height of what the axes enclose."""

    svg: str
    size: tuple[float, float]
    area: tuple[float, float, float, float]
    x: Scale
    y: Scale

    def values(self, share_x: float, share_y: float) -> dict[str, float]:
        """The quantities (SI) at a place of the picture."""
        return {self.x.name: self.x.value(share_x), self.y.name: self.y.value(share_y)}

    def knows(self, values: Mapping[str, float]) -> bool:
        """Whether a point is one of this picture."""
        return {self.x.name, self.y.name} == {*values} and self.shares(values) is not None

    def shares(self, values: Mapping[str, float]) -> tuple[float, float] | None:
        """The place of a point; none outside of the picture."""
        both = self.x.share(values[self.x.name]), self.y.share(values[self.y.name])
        return both if all(-1e-9 <= share <= 1.0 + 1e-9 for share in both) else None


@dataclass
class PointStatement:
    """What is known at a point."""

    verdict: str
    rate: float = math.nan  # 1/s
    borders: dict[str, float] = field(default_factory=dict)  # rad/s, infinite for never; those that there are
    exact: bool = False  # computed there, not between points of the map

    def words(self) -> str:
        """In a sentence."""
        if self.verdict in VERDICT_TEXTS:
            return VERDICT_TEXTS[self.verdict]
        how = "a small disturbance dies away" if self.verdict == STABLE else "a small disturbance grows"
        return f"{self.verdict}: {how} with {abs(self.rate):.3g} 1/s" + (
            "" if self.exact else ", between points of the map"
        )

    def rows(self, speed: float) -> list[tuple[str, str, str, bool]]:
        """Of each border name, speed, how far the point is from it, and whether it is the nearest."""
        away = {name: abs(speed - at) for name, at in self.borders.items() if math.isfinite(at)}
        nearest = min(away, key=lambda name: away[name], default="")
        best = {"exact border": self.borders.get("exact border, best case", math.nan)}
        return [
            (name, _rpm(at, best.get(name, math.nan)), _side(speed, at), name == nearest)
            for name, at in self.borders.items()
        ]


def map_picture(found: xr.Dataset, about: str) -> MapPicture:
    """Draw a map over speed and another quantity, without the machine as a point, which the page marks itself."""
    bare = found.drop_dims("operating_point") if "operating_point" in found.dims else found
    figure: Any = draw_map(bare)
    svg = svg_of(lambda: figure, about)
    place = figure.axes[0].get_position()
    width, height = (72.0 * float(inches) for inches in figure.get_size_inches())
    area = (place.x0 * width, (1.0 - place.y1) * height, place.width * width, place.height * height)
    x, y = (_scale(found, str(dim)) for dim in found["growth_rate"].dims)
    return MapPicture(svg, (width, height), area, x, y)


def statement_from_map(found: xr.Dataset, values: Mapping[str, float]) -> PointStatement:
    """What a map says at a point, straight between its own points."""
    names = list(found.attrs["parameters"])
    dims = [str(dim) for dim in found["growth_rate"].dims]
    axes = [found[dim].values for dim in dims]
    place = [values[name] for name in names]
    if not all(axis.min() <= one <= axis.max() for axis, one in zip(axes, place, strict=True)):
        return PointStatement(OUTSIDE)
    rates = found["growth_rate"].values
    at = [float(np.interp(one, axis, np.arange(axis.size))) for axis, one in zip(axes, place, strict=True)]
    i, j = (min(int(one), axis.size - 2) for one, axis in zip(at, axes, strict=True))
    a, b = at[0] - i, at[1] - j
    weights = np.array([[(1 - a) * (1 - b), (1 - a) * b], [a * (1 - b), a * b]])
    corners = rates[i : i + 2, j : j + 2]
    rate = float(np.where(weights > 0.0, weights * corners, 0.0).sum())
    return _statement(rate, values["speed"], _borders_on(found, dims[1], place[1]))


def exact_statement(machine: Machine, values: Mapping[str, float], *, borders: bool) -> PointStatement:
    """What the full equations say at a point: its growth rate, and its border speeds if they are wanted, which take longer.

    Raises
    ------
    MachineError
        If the values make no possible machine.
    """
    from autobalancer.stability.maps.curve import rates_over, with_values
    from autobalancer.stability.maps.exact import borders_of

    one = {name: np.array([value]) for name, value in values.items()}
    rate = float(rates_over(machine, one, math.nan, True, 1, None)[0, 0])
    found: dict[str, float] = {}
    if borders:
        other = {name: value for name, value in values.items() if name != "speed"}
        changed, p = with_values(machine, other)
        found = {border.name: border.speed for border in borders_of(changed, p) if not math.isnan(border.speed)}
    seen = _statement(rate, values["speed"], found)
    seen.exact = True
    return seen


def _statement(rate: float, speed: float, borders: dict[str, float]) -> PointStatement:
    from autobalancer.stability.states.linearized import verdict

    if math.isnan(rate):
        return PointStatement(NO_STATE, rate, borders)
    word = verdict(rate, speed)
    return PointStatement(AT_BORDER if word == "marginal" else word, rate, borders)


def _borders_on(found: xr.Dataset, dim: str, value: float) -> dict[str, float]:
    """The border curves of a map at a value of its other axis; where one ends, the nearest value that it has."""
    along = f"{dim}_of_border"
    if along not in found:
        return {}
    x = found[along].values
    borders = {}
    for name, curve in found.data_vars.items():
        if curve.dims == (along,) and name != "critical_speed":
            speeds = curve.values
            near = speeds[int(np.abs(x - value).argmin())]
            line = float(np.interp(value, x, speeds)) if np.isfinite(speeds).all() else math.nan
            speed = line if math.isfinite(line) else float(near)
            if not math.isnan(speed):
                borders[str(curve.attrs.get("long_name", name))] = speed
    return borders


def _scale(found: xr.Dataset, dim: str) -> Scale:
    axis = quantity_axis(found.sortby(dim)[dim], "rpm")
    name = str(found.attrs["parameters"][list(found["growth_rate"].dims).index(dim)])
    ends = float(axis.values[0]), float(axis.values[-1])
    return Scale(name, str(found[dim].attrs["long_name"]), axis.unit.sign, axis.unit.factor, *ends, axis.log)


def _rpm(speed: float, best: float) -> str:
    cell = border_cell(speed, 30.0 / math.pi, best)
    return cell if isinstance(cell, str) else f"{cell:.4g} rpm"


def _side(speed: float, border: float) -> str:
    return side_text(speed, border) if math.isfinite(border) else ""
