"""Pictures of stability: eigenvalues and borders over a parameter, curves of bifurcations, maps over two parameters."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any, Protocol

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from autobalancer.errors import QuestionError, one_of
from autobalancer.plots.answer import asked
from autobalancer.plots.style import (
    BALLS,
    CRITICAL,
    INK,
    UNBALANCE,
    QuantityAxis,
    heading,
    legend,
    legend_below,
    look,
    picture,
    plain_log_ticks,
    quantity_axis,
    with_ignored,
)
from autobalancer.results.display_units import AxisUnit, round_down, significant, speed_axis
from autobalancer.results.run_argument import RunArgument
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
    found: xr.Dataset, *, speed_unit: str = "rpm", highest: float | str | None = None, log_speed: bool = False
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
        If the unit is unknown.
    """
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
            x, speeds = _to_capability(found, dim, "exact_border")
            x, exact = axis.unit.shown(x), drawable(speeds * unit.factor, high)
            axes.fill_between(x, exact, 1e3 * high, lw=0, zorder=0.5, label="balanced state stable", color=STABLE)
            axes.fill_between(x, exact, low, lw=0, zorder=0.5, label="not stable", color=UNSTABLE)
        axes.plot(axis.values, critical, color=CRITICAL, lw=1.0, ls=(0, (5, 3)), label="critical speed")
        absent = []
        for name, style in BORDERS.items():
            if name in found:
                x, speeds = _to_capability(found, dim, name)
                absent += _line(axes, axis.unit.shown(x), speeds * unit.factor, high, style, f" {unit.sign}")
        title = with_ignored(str(found.attrs["title"]), found.attrs, _ignoring_subject(axes))
        if stalled := str(found.attrs.get("stalled_ignores", "")):
            title += f"\nrelease and capture speed ignore {stalled}"
        heading(figure, title)
        axes.set(xlabel=axis.label, ylabel=f"rotor speed ({unit.sign})")
        if axis.values.size > 1:
            axes.set_xlim(axis.values[0], axis.values[-1])
        _mark(axes, found, dim, axis.unit, "machine", "unbalance", -12)
        if "exact_border_at_capability" in found.attrs:
            _mark(axes, found, dim, axis.unit, "capability", "capability", -26)
        if axis.log:
            plain_log_ticks(axes, "x")
        legend_below(figure, axes.get_legend_handles_labels()[0], absent)
    return figure


def drawable(speeds: np.ndarray, high: float) -> np.ndarray:
    """Never is far above the picture; what does not exist stays a gap."""
    return np.where(np.isposinf(speeds), 1e3 * high, speeds)


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


def _ignoring_subject(axes: Axes) -> str:
    """Subject and verb of what the theory leaves out, of those drawn: release and capture speed have friction."""
    drawn = [str(line.get_label()) for line in axes.get_lines()]
    kinds = [kind for kind in ("averaged", "exact") if any(label.startswith(kind) for label in drawn)]
    return f"{' and '.join(kinds)} border {'ignore' if len(kinds) > 1 else 'ignores'}" if kinds else "ignores"


def _high(dataset: xr.Dataset, dim: str, log: bool, critical: float, unit: AxisUnit) -> float:
    """So that the exact border fills the picture but for narrow peaks, and others fit if they are near it."""
    x = np.log(dataset[dim].values) if log else dataset[dim].values

    def level(name: str, share: float) -> float:
        speeds = dataset[name].values * unit.factor
        known = np.isfinite(speeds)
        if not known.any():
            return critical
        even = np.interp(np.linspace(x[known][0], x[known][-1], 200), x[known], speeds[known])
        return float(np.quantile(even, share))

    others = [level(name, 0.5) - critical for name in BORDERS if name in dataset]
    base = level("exact_border", 0.85) - critical if "exact_border" in dataset else max(others) / 2.2
    top = max((value for value in others if value < 4.0 * base), default=base)
    return max(critical + max(2.2 * base, 1.4 * top), 1.15 * critical)


def _to_capability(dataset: xr.Dataset, dim: str, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Parameter and a border over it, which ends at the capability of the balls also where this lies between two values."""
    x, speeds, end = dataset[dim].values, dataset[name].values, dataset.attrs.get(f"{name}_at_capability")
    if end is None:
        return x, speeds
    capability = float(dataset.attrs["capability"])
    place = int(np.searchsorted(x, capability))
    return np.insert(x, place, capability), np.insert(speeds, place, float(end))


def _mark(axes: Axes, dataset: xr.Dataset, dim: str, unit: AxisUnit, text: str, name: str, below: int) -> None:
    """The unbalance of the machine itself, or the capability of its balls, where the parameter is the unbalance."""
    if dim != "unbalance" or not dataset.attrs.get(name):
        return
    own = unit.shown(float(dataset.attrs[name]))
    axes.axvline(own, color=CRITICAL, lw=0.9, ls=(0, (1, 2)))
    axes.annotate(
        f"{text}: {significant(own)} {unit.sign}",
        (own, 1.0),
        xycoords=("data", "axes fraction"),
        xytext=(-4, below),
        textcoords="offset points",
        ha="right",
        fontsize=8,
        color=CRITICAL,
    )


# Stability over the speed: growth rate and frequencies, and what moves in the leading mode.


STABLE, UNSTABLE, MARGINAL = "#DCEFE6", "#FBE3D6", "#EFEFEF"
MISSING = "#B0B0B0"  # frame of white in the legend
SHADES = {"stable": STABLE, "unstable": UNSTABLE, "marginal": MARGINAL}


def eigenvalues(found: xr.Dataset, *, speed_unit: str = "rpm", ranges: xr.Dataset | None = None) -> Figure:
    """Draw the eigenvalues of a steady state over the speed.

    The upper panel has the growth rate of the leading mode, with the speeds shaded by the verdict and the moving parts named
    where there is room. The lower panel has the frequency of every mode, seen in the rotor, against the speed: green
    where the mode decays, red where it grows.

    Parameters
    ----------
    found
        From :func:`autobalancer.stability.eigenvalues`.
    speed_unit
        ``"rpm"``, ``"rad/s"`` or ``"Hz"``, for speeds and frequencies.
    ranges
        From :func:`autobalancer.stability.ranges`: the shades then change at the speeds found there. Without it they change
        where the line of the growth rate is zero between two speeds.

    Raises
    ------
    QuestionError
        If it has fewer than two speeds, or the unit is unknown.
    """
    if found["speed"].size < 2:
        raise QuestionError("plot.answer: the result has one speed only; ask for several")
    unit = speed_axis(speed_unit)
    found = found.sortby("speed")
    speed, edges = found["speed"].values * unit.factor, _edges(found, ranges) * unit.factor
    with look():
        figure = picture(8.0, 6.2)
        upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=[1.0, 1.1])
        heading(figure, with_ignored(str(found.attrs.get("title", "Stability")), found.attrs))
        _shade(upper, speed, edges, [str(word) for word in found["verdict"].values], _gaps(found))
        if _gaps(found).size:
            upper.axvspan(np.nan, np.nan, fc="white", ec=MISSING, lw=0.8, label="no such state")
        _growth_panel(upper, found, speed, edges)
        _frequency_panel(lower, found, speed, unit)
        lower.set(xlabel=f"rotor speed ({unit.sign})", xlim=(speed[0], speed[-1]))
        figure.align_ylabels([upper, lower])
    return figure


LEADING = "leading mode: "  # what it is whose motion is named


def _growth_panel(axes: Axes, dataset: xr.Dataset, speed: np.ndarray, edges: np.ndarray) -> None:
    rate = dataset["growth_rate"].values
    axes.axhline(0.0, color=INK, lw=0.8)
    changes, gaps = _changes(dataset), _gaps(dataset)  # at a change the growth rate is zero
    places = np.concatenate([changes, gaps])
    x = np.insert(speed, places, np.concatenate([edges[changes], np.full(gaps.size, np.nan)]))
    y = np.insert(rate, places, np.concatenate([np.zeros(changes.size), np.full(gaps.size, np.nan)]))
    axes.plot(x, y, color=INK, lw=1.6, label="greatest real part")
    axes.set_ylabel("growth rate (1/s)")
    low, high = float(np.nanmin(rate)), float(np.nanmax(rate))
    room = 0.22 * (high - low) or 1.0
    axes.set_ylim(low - 0.3 * room, high + room)
    span = speed[-1] - speed[0]
    for start, end, text in _runs([str(word) for word in dataset["leading_motion"].values]):
        left, right = edges[start], edges[end + 1]
        room_for = (right - left) / (0.0088 * span)  # letters
        if room_for < len(text) or text.startswith("periodic state"):
            continue
        axes.annotate(
            f"{LEADING}{text}" if room_for >= len(LEADING) + len(text) else text,
            (0.5 * (left + right), 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(0, -12),
            textcoords="offset points",
            ha="center",
            fontsize=8,
            color=INK,
        )
        if start:
            axes.axvline(left, color=INK, lw=0.6, ls=(0, (1, 2)), zorder=1.4)
    legend(axes)


def _frequency_panel(axes: Axes, dataset: xr.Dataset, speed: np.ndarray, unit: AxisUnit) -> None:
    real, imag = dataset["eigenvalue_real"].values, dataset["eigenvalue_imag"].values * unit.factor
    across = np.broadcast_to(speed[:, None], real.shape)
    kept = imag >= 0.0
    if "Floquet" in str(dataset.attrs.get("theory", "")):  # what dies out within a revolution is noise
        kept &= real > -np.log(1e6) / (2.0 * np.pi) * dataset["speed"].values[:, None]
    margin = 1e-9 * np.abs(dataset["speed"].values)[:, None]
    groups = (
        (real < -margin, BALLS[2], "mode that decays", 6),
        (np.abs(real) <= margin, "#8A8A8A", "mode that does neither", 8),
        (real > margin, UNBALANCE, "mode that grows", 14),
    )
    for chosen, color, label, size in groups:
        chosen = chosen & kept
        if chosen.any():
            axes.scatter(across[chosen], imag[chosen], s=size, color=color, lw=0, label=label)
    axes.set(ylabel=f"frequency in the rotor ({unit.sign})", ylim=(0.0, None))
    legend(axes)


def _shade(axes: Axes, speed: np.ndarray, edges: np.ndarray, verdicts: list[str], gaps: np.ndarray) -> None:
    """Colors for the verdicts, none where there is no such state."""
    named: set[str] = set()
    ends = [0, *gaps.tolist(), speed.size]
    for first, last in pairwise(ends):
        for start, end, word in _runs(verdicts[first:last]):
            left = speed[first] if start == 0 else edges[first + start]
            right = speed[last - 1] if first + end + 1 == last else edges[first + end + 1]
            label = word if word not in named else "_"
            named.add(word)
            axes.axvspan(left, right, color=SHADES.get(word, MARGINAL), lw=0, zorder=0.5, label=label)


def _gaps(dataset: xr.Dataset) -> np.ndarray:
    """Places between two speeds at which there is no such state."""
    missing = np.atleast_1d(np.asarray(dataset.attrs.get("speeds_without_state", []), np.float64))
    places = np.unique(np.searchsorted(dataset["speed"].values, missing))
    return np.asarray(places[(places > 0) & (places < dataset["speed"].size)])


def _changes(dataset: xr.Dataset) -> np.ndarray:
    """Number of the speed before which the verdict changes, where the state exists in between."""
    verdict = dataset["verdict"].values
    changes = 1 + np.flatnonzero(verdict[1:] != verdict[:-1])
    return np.asarray(np.setdiff1d(changes, _gaps(dataset)), np.int64)


def _edges(dataset: xr.Dataset, ranges: xr.Dataset | None) -> np.ndarray:
    """Ends of what is true at each speed (rad/s): halfway to the next one, but at the border where the verdict changes."""
    speed, rate = dataset["speed"].values, dataset["growth_rate"].values
    edges = np.concatenate([[speed[0]], 0.5 * (speed[1:] + speed[:-1]), [speed[-1]]])
    for i in _changes(dataset):
        low, high = rate[i - 1], rate[i]
        if low * high < 0.0:
            edges[i] = speed[i - 1] + (speed[i] - speed[i - 1]) * low / (low - high)
    if ranges is not None:
        borders = ranges["from_speed"].values[1:]
        places = np.searchsorted(speed, borders)
        inside = (borders > speed[0]) & (borders < speed[np.minimum(places, speed.size - 1)])
        edges[places[inside]] = borders[inside]
    return edges


def _runs(words: list[str]) -> list[tuple[int, int, str]]:
    """(first, last, word) of every run of equal words."""
    runs: list[tuple[int, int, str]] = []
    for i, word in enumerate(words):
        if runs and runs[-1][2] == word:
            runs[-1] = (runs[-1][0], i, word)
        else:
            runs.append((i, i, word))
    return runs


# The border speeds of a machine side by side.


OF_STALLED = ("release speed", "capture speed")  # of balls that stall; the others are those of the balanced state


class BorderSpeed(Protocol):
    """One border speed, rad/s: infinite for never, nan for none; and its speed in words."""

    name: str
    speed: float

    def text(self, speed_text: Callable[[float], str]) -> str: ...


def borders(border_speeds: Sequence[BorderSpeed], *, speed_unit: str = "rpm", title: str = "Border speeds") -> Figure:
    """Draw border speeds, one below the other: blue those of the balanced state, orange those of stalled balls.

    Parameters
    ----------
    border_speeds
        From ``ab.stability.borders``, or the borders of ``ab.check``.
    speed_unit
        ``"rpm"``, ``"rad/s"`` or ``"Hz"``.
    title
        Above the picture.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    QuestionError
        If there is no border, or the unit is unknown.
    """
    if hasattr(border_speeds, "rotor"):
        raise QuestionError("plot.borders: given a machine; it draws a result of stability.borders")
    if (
        not isinstance(border_speeds, Sequence)
        or not border_speeds
        or not all(hasattr(border, "speed") for border in border_speeds)
    ):
        raise QuestionError("plot.borders: give the result of stability.borders")
    unit = speed_axis(speed_unit)

    def speed_text(speed: float) -> str:
        if not math.isfinite(speed):
            return "none" if math.isnan(speed) else "never"
        return f"{speed * unit.factor:.5g} {unit.sign}"

    speeds = [border.speed * unit.factor for border in border_speeds]
    far = max((speed for speed in speeds if math.isfinite(speed)), default=1.0)
    with look():
        figure = picture(7.2, 0.95 + 0.36 * len(border_speeds))
        axes = figure.subplots()
        axes.set_title(title)
        for row, (border, speed) in enumerate(zip(border_speeds, speeds, strict=True)):
            color = BALLS[1] if border.name in OF_STALLED else BALLS[0]
            if math.isfinite(speed):
                axes.plot([0.0, speed], [row, row], color=color, lw=1.2, alpha=0.45)
                axes.plot([speed], [row], "o", ms=7, color=color, mec=INK, mew=0.6)
            text = f"  {border.text(speed_text)}"
            at = speed if math.isfinite(speed) else 0.0
            axes.text(at, row, text, va="center", color=INK if math.isfinite(speed) else CRITICAL, fontsize=8.5)
        axes.set_yticks(range(len(border_speeds)), [border.name for border in border_speeds])
        axes.set(ylim=(len(border_speeds) - 0.4, -0.6), xlim=(0.0, 1.22 * far), xlabel=f"rotor speed ({unit.sign})")
        axes.grid(False, axis="y")
    return figure


# Curves of Hopf points or folds over two parameters.


def bifurcation_curves(curves: xr.Dataset, *, speed_unit: str = "rpm") -> Figure:
    """Draw curves of Hopf points or folds: the second parameter across, the first one upwards.

    A Hopf curve is solid where a small stable oscillation begins (supercritical), dashed where the balls jump (subcritical).

    Parameters
    ----------
    curves
        From :func:`bifurcation_curves`.
    speed_unit
        ``"rpm"``, ``"rad/s"`` or ``"Hz"``, for a parameter that is a speed.

    Returns
    -------
    matplotlib.figure.Figure
        Save it with ``savefig`` or :func:`save_picture`.

    Raises
    ------
    QuestionError
        If there is nothing to draw or the unit is unknown.
    """
    if not curves.sizes.get("point"):
        raise QuestionError("bifurcation curves: there is no point to draw")
    across, up = (quantity_axis(curves[name], speed_unit) for name in ("second_parameter", "parameter"))
    hopf = "criticality" in curves
    bad = curves["criticality"].values == "subcritical" if hopf else np.zeros(across.values.size, bool)
    with look():
        figure = picture(7.2, 4.6)
        axes = figure.add_subplot()
        axes.set_title(with_ignored(str(curves.attrs.get("title", "Bifurcation curves")), curves.attrs))
        named: set[str] = set()
        for number in np.unique(curves["curve"].values):
            points = np.flatnonzero(curves["curve"].values == number)
            for dashed in (False, True):
                wanted = bad[points] == dashed
                shown = np.where(wanted | np.roll(wanted, 1), up.values[points], np.nan)
                style = (0, (4, 2.2)) if dashed else "-"
                text = "Hopf, subcritical" if dashed else "Hopf, supercritical" if hopf else "fold"
                label = text if wanted.any() and text not in named else "_"
                named.add(label)
                axes.plot(across.values[points], shown, ls=style, lw=1.6, color=BALLS[0], label=label)
        for i, name in enumerate(curves["special_type"].values):
            place = (
                across.unit.shown(float(curves["special_second_parameter"].values[i])),
                up.unit.shown(float(curves["special_parameter"].values[i])),
            )
            text = f"{name} point" if name == "Bautin" else str(name)
            axes.plot(*place, "D", ms=6, mfc="white", mec=INK, label="_" if text in named else text)
            named.add(text)
        axes.set(xlabel=across.label, ylabel=up.label)
        if float(across.values.min()) > 0.0 and across.values.max() / across.values.min() > 20.0:
            axes.set_xscale("log")
        axes.legend(loc="best")
    return figure


# Stability maps: growth rate over two parameters, with the border speeds by their names.


COLORS = LinearSegmentedColormap.from_list(
    "growth",
    [
        (0.0, "#2F8F6B"),
        (0.35, "#A5D6C0"),
        (0.4999, "#EAF6F0"),
        (0.5001, "#FDEDE4"),
        (0.65, "#F5B999"),
        (1.0, "#C9501F"),
    ],
)


def map(
    found: RunArgument,
    *,
    speed_unit: str = "rpm",
    x: str | None = None,
    fluids: bool = True,
    title: str | None = None,
) -> Figure:
    """Draw a stability map: contours of the growth rate, border speeds, fluids and operating points.

    Green is stable, red unstable, gray where there is no balanced state. Each border has its own line and its name in
    the legend; one that lies outside is named above the keys. The exact one is the speed above which all is green; stable
    windows below it are green as well.

    Parameters
    ----------
    found
        From :func:`autobalancer.stability.map`.
    speed_unit
        ``"rpm"``, ``"rad/s"`` or ``"Hz"``.
    x
        Which parameter is along x, as a dimension of ``found``; by default the first.
    fluids
        Name fluids of the catalog along a viscosity.
    title
        By default that of ``found``.

    Raises
    ------
    QuestionError
        If ``found`` is no map, has fewer than two values along an axis, or ``x`` is no parameter of it.
    """
    found = asked(found, "map")
    speed_axis(speed_unit)
    dims = [str(dim) for dim in found["growth_rate"].dims]
    if x is not None:
        one_of("x", x, *dims)
    if min(found["growth_rate"].shape) < 2:
        raise QuestionError("plot.map: the map has one value along an axis; ask for several")
    if x is not None and x != dims[0]:
        dims = dims[::-1]
    found = found.sortby(dims)
    along = [quantity_axis(found[dim], speed_unit) for dim in dims]
    with look():
        figure = picture(8.4, 6.0)
        axes = figure.add_subplot()
        axes.grid(False)
        handles = _growth(figure, axes, found, dims, along)
        for axis, which in zip(along, ("x", "y"), strict=True):
            if axis.log:
                (axes.set_xscale if which == "x" else axes.set_yscale)("log")
                plain_log_ticks(axes, which)
        axes.set(xlabel=along[0].label, ylabel=along[1].label)
        absent: list[str] = []
        handles += borders_on_map(axes, found, dims, along, absent)
        handles += hatch_held(axes, found, dims, along, absent)
        handles += operating_points(axes, found, dims, along, absent)
        if fluids and "fluid" in found and "viscosity" in dims:
            fluid_names(axes, found, dims.index("viscosity"), along)
        axes.set(xlim=(along[0].values[0], along[0].values[-1]), ylim=(along[1].values[0], along[1].values[-1]))
        fixed = (
            f" at {found.attrs['speed'] * speed_axis(speed_unit).factor:.4g} {speed_unit}"
            if "speed" in found.attrs
            else ""
        )
        figure.suptitle(title or f"{found.attrs['title']}{fixed}", fontsize=10.5, weight="bold", x=0.02, ha="left")
        legend_below(figure, handles, absent)
    return figure


def _growth(figure: Figure, axes: Axes, dataset: xr.Dataset, dims: list[str], along: list[QuantityAxis]) -> list[Any]:
    """Filled contours with the same steps on both sides of zero, and a bar."""
    rates = dataset["growth_rate"].transpose(*dims).values
    known = rates[np.isfinite(rates)]
    handles: list[Any] = []
    if known.size < rates.size:
        axes.set_facecolor("#D5D5D5")
        handles.append(Patch(color="#D5D5D5", label="no balanced state"))
    if not known.size:
        return handles
    sides = [np.quantile(np.abs(side), 0.97) for side in (known[known < 0.0], known[known > 0.0]) if side.size]
    top = round_down(max(float(max(sides, default=1.0)), 1e-12))
    steps = top * np.array([0.05, 0.1, 0.2, 0.5, 1.0])
    levels = np.concatenate([-steps[::-1], [0.0], steps])
    drawn = axes.contourf(
        along[0].values,
        along[1].values,
        np.clip(rates, -10 * top, 10 * top).T,
        levels=levels,
        cmap=COLORS,
        norm=BoundaryNorm(levels, 256, extend="both"),
        extend="both",
    )
    drawn.set_rasterized(True)
    bar = figure.colorbar(drawn, ax=axes, pad=0.02, fraction=0.05, spacing="uniform")
    bar.set_ticks(list(levels))
    bar.set_ticklabels([f"{level:g}" for level in levels])
    ignored = dataset.attrs.get("ignores", "")
    bar.set_label("growth rate (1/s), stable below zero" + (f",\nignores {ignored}" if ignored else ""))
    bar.outline.set_visible(False)
    return handles


# Operating points and names of fluids on a stability map.


FAMILIES = ("silicone oil", "mineral oil", "water", "glycerol-water", "air")  # the first has the first choice of room


def operating_points(
    axes: Axes, dataset: xr.Dataset, dims: list[str], along: list[QuantityAxis], absent: list[str]
) -> list[Any]:
    """Marks with their keys; names of those outside go to ``absent``."""
    if "operating_point" not in dataset:
        return []
    markers, handles = "oDs^vP*X", []
    columns = [axis.unit.shown(dataset[f"operating_{dim}"].values) for dim, axis in zip(dims, along, strict=True)]
    for number, name in enumerate(dataset["operating_point"].values):
        px, py = float(columns[0][number]), float(columns[1][number])
        inside = all(a.values[0] <= v <= a.values[-1] for a, v in zip(along, (px, py), strict=True))
        if not inside:
            absent.append(f"{name} (outside)")
            continue
        style: dict[str, Any] = {
            "marker": markers[number % len(markers)],
            "ms": 7.5,
            "mfc": "white",
            "mec": INK,
            "mew": 1.5,
        }
        axes.plot(px, py, ls="none", zorder=5, clip_on=False, **style)
        handles.append(Line2D([], [], ls="none", **style, label=f"{name}"))
    return handles


def fluid_names(axes: Axes, dataset: xr.Dataset, place: int, along: list[QuantityAxis]) -> None:
    """Names on the side opposite to the viscosity's own numbers, as many as have room."""
    axis = along[place]
    low, high = (np.log(v) if axis.log else v for v in (axis.values[0], axis.values[-1]))
    need = 0.034 if place == 1 else 0.03
    taken: list[float] = []
    names, families = dataset["fluid"].values, [str(word) for word in dataset["fluid_family"].values]
    shown = dataset["fluid_viscosity"].values * axis.unit.factor
    order = sorted(
        range(len(names)),
        key=lambda i: (FAMILIES.index(families[i]) if families[i] in FAMILIES else 9, "(" in str(names[i])),
    )
    for i in order:
        value = float(shown[i])
        at = ((np.log(value) if axis.log else value) - low) / (high - low)
        if not 0.0 <= at <= 1.0 or any(abs(at - other) < need for other in taken):
            continue
        taken.append(at)
        name = str(names[i])
        if place == 1:
            axes.annotate(
                name,
                (1.0, value),
                xycoords=("axes fraction", "data"),
                xytext=(6, 0),
                textcoords="offset points",
                va="center",
                fontsize=7.5,
            )
            axes.plot(
                [1.0, 1.012], [value, value], transform=axes.get_yaxis_transform(), color=INK, lw=0.8, clip_on=False
            )
        else:
            axes.annotate(
                name,
                (value, 1.0),
                xycoords=("data", "axes fraction"),
                xytext=(0, 6),
                textcoords="offset points",
                ha="center",
                va="bottom",
                rotation=90,
                fontsize=7.5,
            )
            axes.plot(
                [value, value], [1.0, 1.014], transform=axes.get_xaxis_transform(), color=INK, lw=0.8, clip_on=False
            )


# The border curves on a stability map, and where friction holds balls.
#
# Each function draws, returns the keys of what it drew, and appends to ``absent`` in words what is not in the
# picture.


STALLED = ("release_speed", "capture_speed")


def borders_on_map(
    axes: Axes, dataset: xr.Dataset, dims: list[str], along: list[QuantityAxis], absent: list[str]
) -> list[Any]:
    """The border curves over the other axis; without the speed as an axis the zero of the growth rate."""
    if "speed" not in dims:
        limit = _limit(axes, dataset, dims, along, absent)
        return [*limit, *(one for name in STALLED for one in _stalled(axes, dataset, dims, along, name, absent))]
    place = dims.index("speed")
    other = dims[1 - place]
    coordinate = f"{other}_of_border"
    if coordinate not in dataset:
        return []
    values, unit = along[1 - place].unit.shown(dataset[coordinate].values), along[place].unit
    high = 1e3 * float(along[place].values[-1])
    handles: list[Any] = []
    lines = {"critical_speed": {"color": CRITICAL, "lw": 1.0, "ls": (0, (5, 3)), "label": "critical speed"}, **BORDERS}
    for name, style in lines.items():
        if name not in dataset or np.isnan(dataset[name].values).all():
            continue
        speeds = dataset[name].values * unit.factor
        drawn = np.where(np.isposinf(speeds), high, speeds)
        inside = np.isfinite(speeds) & (speeds >= along[place].values[0]) & (speeds <= along[place].values[-1])
        if not inside.any():
            absent.append(f"{style['label']} ({_where(speeds, along[place].values)})")
            continue
        axes.plot(*((drawn, values) if place == 0 else (values, drawn)), **style)
        handles.append(Line2D([], [], **style))
    return handles


def _limit(axes: Axes, dataset: xr.Dataset, dims: list[str], along: list[QuantityAxis], absent: list[str]) -> list[Any]:
    """The line on which the growth rate is zero."""
    rates = dataset["growth_rate"].transpose(*dims).values
    known = rates[np.isfinite(rates)]
    if not known.size or known.max() < 0.0 or known.min() > 0.0:
        if known.size:
            absent.append(f"limit of stability ({'stable' if known.max() < 0.0 else 'unstable'} everywhere)")
        return []
    axes.contour(along[0].values, along[1].values, rates.T, levels=[0.0], colors=INK, linewidths=2.0)
    return [Line2D([], [], color=INK, lw=2.0, label="limit of stability, full equations")]


def hatch_held(
    axes: Axes, dataset: xr.Dataset, dims: list[str], along: list[QuantityAxis], absent: list[str]
) -> list[Any]:
    """Hatched where the unbalance alone does not move balls that friction holds."""
    if "held_share" not in dataset:
        return []
    shares = dataset["held_share"].transpose(*(f"{dim}_of_friction" for dim in dims))
    text = "friction holds balls at rest"
    if (shares.values < 1.0).all():
        absent.append(f"where {text} (nowhere)")
        return []
    if min(shares.shape) > 1:
        x, y = (axis.unit.shown(shares[f"{dim}_of_friction"].values) for dim, axis in zip(dims, along, strict=True))
        over = np.log(np.clip(shares.values, 1e-6, 1e6)).T
        drawn = axes.contourf(x, y, over, levels=[0.0, 1e3], colors="none", hatches=["//"], zorder=3)
        drawn.set_edgecolor(INK)
        drawn.set_linewidth(0.0)
        axes.contour(x, y, over, levels=[0.0], colors=INK, linewidths=1.0, zorder=3)
    everywhere = ": everywhere" if (shares.values >= 1.0).all() else ""
    return [Patch(fc="none", ec=INK, lw=0.6, hatch="//", label=f"{text}{everywhere}")]


def _stalled(
    axes: Axes, dataset: xr.Dataset, dims: list[str], along: list[QuantityAxis], name: str, absent: list[str]
) -> list[Any]:
    """Where the speed of the map is that border of stalled balls; nan where no ball stalls."""
    if name not in dataset or "speed" not in dataset.attrs:
        return []
    speed, style = float(dataset.attrs["speed"]), BORDERS[name]
    rates = dataset[name].transpose(*(f"{dim}_of_border" for dim in dims))
    if np.isnan(rates.values).all():
        return []
    over = np.log(np.clip(np.nan_to_num(rates.values, nan=0.0, posinf=np.inf), 0.1 * speed, 10.0 * speed) / speed)
    label = f"{style['label']} as high as the speed of the map"
    if (over > 0.0).all() or (over <= 0.0).all():
        side = "above" if over.min() > 0.0 else "below"
        absent.append(f"{style['label']} ({side} the speed of the map everywhere)")
        return []
    x, y = (axis.unit.shown(rates[f"{dim}_of_border"].values) for dim, axis in zip(dims, along, strict=True))
    axes.contour(x, y, over.T, levels=[0.0], colors=style["color"], linewidths=style["lw"], linestyles=[style["ls"]])
    return [Line2D([], [], **{**style, "label": label})]


def _where(speeds: np.ndarray, shown: np.ndarray) -> str:
    finite = speeds[np.isfinite(speeds)]
    if not finite.size:
        return "never"
    return "above it" if finite.min() > shown[-1] else "below it"
