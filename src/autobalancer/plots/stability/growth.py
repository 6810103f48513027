"""Stability over the speed: growth rate and frequencies, and what moves in the leading mode."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from autobalancer.errors import QuestionError
from autobalancer.plots.drawing.style import BALLS, INK, UNBALANCE, heading, legend, look, picture, with_ignored
from autobalancer.results.display_units import AxisUnit, speed_axis
from autobalancer.results.given import Given, result

STABLE, UNSTABLE, MARGINAL = "#DCEFE6", "#FBE3D6", "#EFEFEF"
MISSING = "#B0B0B0"  # frame of white in the legend
SHADES = {"stable": STABLE, "unstable": UNSTABLE, "marginal": MARGINAL}


def eigenvalues(found: Given, *, speed_unit: str = "rpm", ranges: xr.Dataset | None = None) -> Figure:
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
        If ``found`` is no result of ``eigenvalues``, has fewer than two speeds, or the unit is unknown.
    """
    found = result(
        found, "plot.eigenvalues", "stability.eigenvalues", lambda it: "eigenvalue_real" in it and "speed" in it.dims
    )
    if found["speed"].size < 2:
        raise QuestionError("plot.eigenvalues: the result has one speed only; ask for several")
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
        lower.set_xlabel(f"rotor speed ({unit.sign})")
        lower.set_xlim(speed[0], speed[-1])
        figure.align_ylabels([upper, lower])
    return figure


LEADING = "leading mode: "  # what it is whose motion is named


def _growth_panel(axes: Axes, found: xr.Dataset, speed: np.ndarray, edges: np.ndarray) -> None:
    rate = found["growth_rate"].values
    axes.axhline(0.0, color=INK, lw=0.8)
    changes, gaps = _changes(found), _gaps(found)  # at a change the growth rate is zero
    places = np.concatenate([changes, gaps])
    x = np.insert(speed, places, np.concatenate([edges[changes], np.full(gaps.size, np.nan)]))
    y = np.insert(rate, places, np.concatenate([np.zeros(changes.size), np.full(gaps.size, np.nan)]))
    axes.plot(x, y, color=INK, lw=1.6, label="greatest real part")
    axes.set_ylabel("growth rate (1/s)")
    low, high = float(np.nanmin(rate)), float(np.nanmax(rate))
    room = 0.22 * (high - low) or 1.0
    axes.set_ylim(low - 0.3 * room, high + room)
    span = speed[-1] - speed[0]
    for start, end, text in _runs([str(word) for word in found["leading_motion"].values]):
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


def _frequency_panel(axes: Axes, found: xr.Dataset, speed: np.ndarray, unit: AxisUnit) -> None:
    real, imag = found["eigenvalue_real"].values, found["eigenvalue_imag"].values * unit.factor
    across = np.broadcast_to(speed[:, None], real.shape)
    kept = imag >= 0.0
    if "Floquet" in str(found.attrs.get("theory", "")):  # what dies out within a revolution is noise
        kept &= real > -np.log(1e6) / (2.0 * np.pi) * found["speed"].values[:, None]
    margin = 1e-9 * np.abs(found["speed"].values)[:, None]
    groups = (
        (real < -margin, BALLS[2], "mode that decays", 6),
        (np.abs(real) <= margin, "#8A8A8A", "mode that does neither", 8),
        (real > margin, UNBALANCE, "mode that grows", 14),
    )
    for chosen, color, label, size in groups:
        chosen = chosen & kept
        if chosen.any():
            axes.scatter(across[chosen], imag[chosen], s=size, color=color, lw=0, label=label)
    axes.set_ylabel(f"frequency in the rotor ({unit.sign})")
    axes.set_ylim(bottom=0.0)
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


def _gaps(found: xr.Dataset) -> np.ndarray:
    """Places between two speeds at which there is no such state."""
    missing = np.atleast_1d(np.asarray(found.attrs.get("speeds_without_state", []), np.float64))
    places = np.unique(np.searchsorted(found["speed"].values, missing))
    return np.asarray(places[(places > 0) & (places < found["speed"].size)])


def _changes(found: xr.Dataset) -> np.ndarray:
    """Number of the speed before which the verdict changes, where the state exists in between."""
    verdict = found["verdict"].values
    changes = 1 + np.flatnonzero(verdict[1:] != verdict[:-1])
    return np.asarray(np.setdiff1d(changes, _gaps(found)), np.int64)


def _edges(found: xr.Dataset, ranges: xr.Dataset | None) -> np.ndarray:
    """Ends of what is true at each speed (rad/s): halfway to the next one, but at the border where the verdict changes."""
    speed, rate = found["speed"].values, found["growth_rate"].values
    edges = np.concatenate([[speed[0]], 0.5 * (speed[1:] + speed[:-1]), [speed[-1]]])
    for i in _changes(found):
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
    found: list[tuple[int, int, str]] = []
    for i, word in enumerate(words):
        if found and found[-1][2] == word:
            found[-1] = (found[-1][0], i, word)
        else:
            found.append((i, i, word))
    return found
