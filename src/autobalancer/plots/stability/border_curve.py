"""The border speeds over a parameter."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from autobalancer.plots.drawing.quantity_axis import plain_log_ticks, quantity_axis
from autobalancer.plots.drawing.style import (
    BALLS,
    CRITICAL,
    INK,
    UNBALANCE,
    heading,
    legend_below,
    look,
    picture,
    with_ignored,
)
from autobalancer.plots.stability.growth import STABLE, UNSTABLE
from autobalancer.results.display_units import AxisUnit, significant, speed_axis
from autobalancer.results.given import Given, result
from autobalancer.units import optional_argument

BORDERS: dict[str, dict[str, Any]] = {  # one look for each border in all pictures
    "exact_border": {"color": INK, "lw": 2.2, "label": "exact border"},
    "exact_border_best_case": {"color": INK, "lw": 1.1, "ls": "-", "label": "exact border, best case"},
    "exact_border_worst_case": {"color": INK, "lw": 1.4, "ls": (0, (1, 1.2)), "label": "exact border, worst case"},
    "averaged_border": {"color": BALLS[0], "lw": 1.6, "ls": (0, (6, 2)), "label": "averaged border"},
    "release_speed": {"color": UNBALANCE, "lw": 1.6, "ls": (0, (5, 1.5, 1, 1.5)), "label": "release speed"},
    "capture_speed": {"color": UNBALANCE, "lw": 1.3, "ls": (0, (2, 1.5)), "label": "capture speed"},
}


def border_curve(
    found: Given, *, speed_unit: str = "rpm", highest: float | str | None = None, log_speed: bool = False
) -> Figure:
    """Draw border speeds over a parameter, each in its own style.

    A border that is *never* leaves the picture at the top. One that is not in the picture at all has no key; a line above
    the keys names it. Above the exact border the
    balanced state is stable and the picture is green, below it is red. Both are for the unbalance of the machine; the border for
    the worst unbalance is a line of its own.

    Parameters
    ----------
    found
        From :func:`autobalancer.stability.border_curve`.
    speed_unit
        ``"rpm"``, ``"rad/s"`` or ``"Hz"``.
    highest
        Upper end of the speed axis, rad/s; by default so that the exact border fills the picture.
    log_speed
        Logarithmic speed axis, for borders that differ by factors.

    Raises
    ------
    QuestionError
        If ``found`` is no result of ``border_curve``, or the unit is unknown.
    """
    found = result(
        found,
        "plot.border_curve",
        "stability.border_curve",
        _is_curve,
    )
    highest = optional_argument("highest", highest, "rad/s")
    unit = speed_axis(speed_unit)
    dim = str(found["critical_speed"].dims[0])
    found = found.sortby(dim)
    axis = quantity_axis(found[dim], speed_unit)
    critical = found["critical_speed"].values * unit.factor
    low = 0.93 * float(critical.min())
    high = highest * unit.factor if highest is not None else _high(found, dim, axis.log, float(critical.max()), unit)
    with look():
        figure = picture(7.6, 5.0)
        axes = figure.add_subplot()
        if axis.log:
            axes.set_xscale("log")
        if log_speed:
            axes.set_yscale("log")
        axes.set_ylim(low, high)
        if "exact_border" in found:
            exact = drawable(found["exact_border"].values * unit.factor, high)
            axes.fill_between(
                axis.values, exact, 1e3 * high, lw=0, zorder=0.5, label="balanced state stable", color=STABLE
            )
            axes.fill_between(axis.values, exact, low, lw=0, zorder=0.5, label="not stable", color=UNSTABLE)
        axes.plot(axis.values, critical, color=CRITICAL, lw=1.0, ls=(0, (5, 3)), label="critical speed")
        absent = []
        for name, style in BORDERS.items():
            if name in found:
                absent += _line(axes, axis.values, found[name].values * unit.factor, high, style, f" {unit.sign}")
        title = with_ignored(str(found.attrs["title"]), found.attrs, _who_ignores(axes))
        if stalled := str(found.attrs.get("stalled_ignores", "")):
            title += f"\nrelease and capture speed ignore {stalled}"
        heading(figure, title)
        axes.set_xlabel(axis.label)
        axes.set_ylabel(f"rotor speed ({unit.sign})")
        if axis.values.size > 1:
            axes.set_xlim(axis.values[0], axis.values[-1])
        _mark_machine(axes, found, dim, axis.unit)
        if axis.log:
            plain_log_ticks(axes, "x")
        legend_below(figure, axes.get_legend_handles_labels()[0], absent)
    return figure


def drawable(speeds: np.ndarray, high: float) -> np.ndarray:
    """Never is far above the picture; what does not exist stays a gap."""
    return np.where(np.isposinf(speeds), 1e3 * high, speeds)


def _is_curve(found: xr.Dataset) -> bool:
    return "parameter" in found.attrs and any(name in found and found[name].ndim == 1 for name in BORDERS)


def _line(axes: Axes, x: np.ndarray, speeds: np.ndarray, high: float, style: dict[str, Any], sign: str) -> list[str]:
    """One border; if it leaves the picture everywhere it is not drawn, and where it is comes back in words."""
    if np.isnan(speeds).all():
        return []
    if np.isposinf(speeds[~np.isnan(speeds)]).all():
        return [f"{style['label']} (never)"]
    if np.nanmin(speeds) > high:
        finite = speeds[np.isfinite(speeds)]
        least = f"{'from ' if np.ptp(finite) > 1e-3 * high else ''}{significant(float(finite.min()))}{sign}"
        return [f"{style['label']} ({least})"]
    axes.plot(x, drawable(speeds, high), **style)
    return []


def _who_ignores(axes: Axes) -> str:
    """Subject and verb of what the theory leaves out, of those drawn: release and capture speed have friction."""
    drawn = [str(line.get_label()) for line in axes.get_lines()]
    kinds = [kind for kind in ("averaged", "exact") if any(label.startswith(kind) for label in drawn)]
    return f"{' and '.join(kinds)} border {'ignore' if len(kinds) > 1 else 'ignores'}" if kinds else "ignores"


def _high(found: xr.Dataset, dim: str, log: bool, critical: float, unit: AxisUnit) -> float:
    """So that the exact border fills the picture but for narrow peaks, and others fit if they are near it."""
    x = np.log(found[dim].values) if log else found[dim].values

    def level(name: str, share: float) -> float:
        speeds = found[name].values * unit.factor
        known = np.isfinite(speeds)
        if not known.any():
            return critical
        even = np.interp(np.linspace(x[known][0], x[known][-1], 200), x[known], speeds[known])
        return float(np.quantile(even, share))

    others = [level(name, 0.5) - critical for name in BORDERS if name in found]
    base = level("exact_border", 0.85) - critical if "exact_border" in found else max(others) / 2.2
    top = max((value for value in others if value < 4.0 * base), default=base)
    return max(critical + max(2.2 * base, 1.4 * top), 1.15 * critical)


def _mark_machine(axes: Axes, found: xr.Dataset, dim: str, unit: AxisUnit) -> None:
    """The unbalance of the machine itself, where the parameter is the unbalance."""
    if dim != "unbalance" or not found.attrs.get("unbalance"):
        return
    own = unit.shown(float(found.attrs["unbalance"]))
    axes.axvline(own, color=CRITICAL, lw=0.9, ls=(0, (1, 2)))
    axes.annotate(
        f"machine: {significant(own)} {unit.sign}",
        (own, 1.0),
        xycoords=("data", "axes fraction"),
        xytext=(-4, -12),
        textcoords="offset points",
        ha="right",
        fontsize=8,
        color=CRITICAL,
    )
