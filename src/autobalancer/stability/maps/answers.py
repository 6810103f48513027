"""Border curves and stability maps as a few lines."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
import xarray as xr

from autobalancer.results.answers.answer import Answer
from autobalancer.results.display_units import axis_unit, speed_axis
from autobalancer.results.number_text import share_text, significant
from autobalancer.shown import Column, rpm_and_si

OF_BORDER = "_of_border"  # ending of the axes along which a map has border speeds


class BorderCurve(Answer):
    """Border speeds over a parameter."""

    __slots__ = ()
    drawn_by = "border_curve"
    most = 10

    def columns(self, unit: str = "") -> list[Column]:
        """The parameter, and each border."""
        shown, across = speed_axis(unit or self.shown_in), self[self._across()]
        axis = axis_unit(across, unit or self.shown_in)
        speeds = [
            Column(self._called(name), [_speed(w, shown.factor) for w in self[name].values], shown.sign, ".6g")
            for name in self._borders()
        ]
        return [Column(str(across.attrs.get("long_name", across.name)), axis.shown(across.values), axis.sign), *speeds]

    def remarks(self) -> Sequence[str]:
        """Where the exact border is highest, and what all borders ignore."""
        return [*self._highest(), *super().remarks()]

    def has_table(self) -> bool:
        """One parameter, and a border over it, must be there."""
        return len(self.dims) == 1 and self._across() in self.coords and bool(self._borders())

    def _across(self) -> str:
        return str(next(iter(self.dims)))

    def _called(self, name: str) -> str:
        return str(self[name].attrs.get("long_name", name))

    def _borders(self) -> list[str]:
        return [str(name) for name, entry in self.data_vars.items() if entry.attrs.get("units") == "rad/s"]

    def _highest(self) -> Iterator[str]:
        if "exact_border" not in self or not np.isfinite(self["exact_border"].values).any():
            return
        speeds = np.where(np.isfinite(self["exact_border"].values), self["exact_border"].values, -np.inf)
        place, across = int(np.argmax(speeds)), self[self._across()]
        never = int(np.isposinf(self["exact_border"].values).sum())
        text = f"exact border: highest {rpm_and_si(float(speeds[place]))} at {_value(across, float(across[place]))}"
        yield text + (f", never stable at {never} of {speeds.size} values" if never else "")


class StabilityMap(Answer):
    """Growth rate of the balanced state over two parameters."""

    __slots__ = ()
    drawn_by = "map"

    def facts(self) -> list[tuple[str, str]]:
        """Both axes, the stable share, borders and operating points."""
        axes = [(f"{name} axis", _span(self[dim])) for name, dim in zip("xy", self["growth_rate"].dims, strict=True)]
        return [*axes, ("stability", self.stable_text()), *self._speeds(), *self._held(), *self._points()]

    def stable_text(self) -> str:
        """How much of the map has a balanced state, and a stable one."""
        rates = self["growth_rate"].values
        known = rates[np.isfinite(rates)]
        stable = (
            f"{share_text(float((known < 0.0).mean()))} of them stable" if known.size else "no balanced state anywhere"
        )
        return f"{rates.size} points, {known.size} with a balanced state, {stable}"

    def held_text(self) -> str:
        """Where friction holds balls at rest; empty without friction."""
        if "held_share" not in self:
            return ""
        share = share_text(float((self["held_share"] >= 1.0).mean()))
        return f"the unbalance alone does not move balls at rest in {share} of the map"

    def has_table(self) -> bool:
        """Growth rates over two axes must be there."""
        if "growth_rate" not in self:
            return False
        dims = self["growth_rate"].dims
        return len(dims) == 2 and all(dim in self.coords for dim in dims)

    def _speeds(self) -> Iterator[tuple[str, str]]:
        for name, entry in self.data_vars.items():
            if (
                entry.attrs.get("units") == "rad/s"
                and entry.dims
                and all(str(d).endswith(OF_BORDER) for d in entry.dims)
            ):
                known = entry.values[np.isfinite(entry.values)]
                if known.size:
                    low, high = rpm_and_si(float(known.min())), rpm_and_si(float(known.max()))
                    never = ", in places never" if np.isposinf(entry.values).any() else ""
                    yield str(entry.attrs.get("long_name", name)), (low if low == high else f"{low} to {high}") + never

    def _held(self) -> Iterator[tuple[str, str]]:
        if text := self.held_text():
            yield "friction", text

    def _points(self) -> Iterator[tuple[str, str]]:
        dims = [str(dim) for dim in self["growth_rate"].dims]
        for k, name in enumerate(self["operating_point"].values if "operating_point" in self.coords else ()):
            values = {dim: float(self[f"operating_{dim}"].values[k]) for dim in dims}
            at = ", ".join(_value(self[dim], value) for dim, value in values.items())
            yield f"point {k + 1}", f"{name}: {at}; {self._there(values)}"

    def _there(self, values: dict[str, float]) -> str:
        inside = all(self[dim].values.min() <= value <= self[dim].values.max() for dim, value in values.items())
        if not inside:
            return "outside of the map"
        near = self["growth_rate"].isel(
            {d: int(np.abs(self[d].values - value).argmin()) for d, value in values.items()}
        )
        rate = float(near)
        if math.isnan(rate):
            return "no balanced state at the nearest point of the map"
        return f"{'stable' if rate < 0.0 else 'unstable'} at the nearest point of the map, growth rate {rate:.3g} 1/s"


def _speed(speed: float, factor: float) -> float | str | None:
    """What a table shows of a border: *never* is a statement, too."""
    if math.isnan(speed):
        return None
    return "never" if math.isinf(speed) else float(f"{speed * factor:.10g}")


def _value(axis: xr.DataArray, value: float) -> str:
    unit = axis_unit(axis, "rpm")
    return f"{axis.attrs.get('long_name', axis.name)} {significant(unit.shown(value), 4)} {unit.sign}".rstrip()


def _span(axis: xr.DataArray) -> str:
    unit, values = axis_unit(axis, "rpm"), axis.values
    ends = " to ".join(significant(float(unit.shown(end)), 4) for end in (values.min(), values.max()))
    return f"{axis.attrs.get('long_name', axis.name)}, {ends} {unit.sign}".rstrip() + f" ({axis.size} values)"
