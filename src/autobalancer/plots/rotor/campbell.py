"""The Campbell diagram."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from autobalancer.plots.drawing.end_labels import SAME, End, end_labels
from autobalancer.plots.drawing.labels import label_point
from autobalancer.plots.drawing.style import BALLS, CRITICAL, INK, look, picture, with_ignored
from autobalancer.results.display_units import AxisUnit, significant, speed_axis
from autobalancer.results.given import Given, result

WHIRL = {"forward": BALLS[0], "backward": BALLS[1], "mixed": BALLS[3], "straight": "#8A8A8A"}
THINNEST, THICKEST, WIDTH_OF_ALL = 1.0, 6.0, 0.2  # a damping ratio of 0.2 has the thickest line


def campbell(found: Given, *, speed_unit: str = "rpm", frequency_unit: str = "Hz") -> Figure:
    """Draw natural frequencies over the speed: color is the direction of whirl, width the damping ratio.

    Dashed are the lines of the harmonics; the intersections with them, the critical speeds, are circled and named.
    Dotted lines are torsional frequencies, where the drive train twists. Written at the end of each branch are its name and
    damping ratio. Branches on one another have one name, and dashes in both colors.

    Parameters
    ----------
    found
        From :func:`~autobalancer.rotordynamics.campbell.campbell`.
    speed_unit, frequency_unit
        ``"rpm"``, ``"rad/s"`` or ``"Hz"``.

    Raises
    ------
    QuestionError
        If ``found`` is no Campbell diagram, or a unit is unknown.
    """
    found = result(
        found, "plot.campbell", "rotor.campbell", lambda it: "intersection_speed" in it and "branch" in it.dims
    )
    across, up = speed_axis(speed_unit), speed_axis(frequency_unit)
    speed = found["speed"].values * across.factor
    with look():
        figure = picture(8.4, 5.2)
        axes = figure.subplots()
        axes.set_title(with_ignored(str(found.attrs.get("title", "Campbell diagram")), found.attrs))
        room = 1.3 if "torsional_frequency" in found else 1.12  # for the legend
        top = room * _greatest(found) * up.factor
        for h in found.attrs.get("harmonics", [1.0]):
            line = found["speed"].values * h * up.factor
            axes.plot(speed, line, color=CRITICAL, lw=1.0, ls=(0, (5, 3)), label=f"harmonic {h:g}")
        for number in range(found["branch"].size):
            _branch(axes, found.isel(branch=number), speed, up)
        _coincident(axes, found, speed, up, top)
        ends = _ends(found, up) + _torsion(axes, found, speed, up, top)
        end_labels(axes, float(speed[-1]), ends, top)
        axes.set_xlim(speed[0], speed[-1])
        axes.set_ylim(0.0, top)
        _crossings(axes, found, across, up)
        axes.set_xlabel(f"rotor speed ({across.sign})")
        axes.set_ylabel(f"natural frequency ({up.sign})")
        _explain(axes, found)
    return figure


def _branch(axes: Axes, branch: xr.Dataset, speed: np.ndarray, unit: AxisUnit) -> None:
    frequency = branch["frequency"].values * unit.factor
    points = np.column_stack([speed, frequency])
    pieces = np.stack([points[:-1], points[1:]], axis=1)
    there = np.isfinite(pieces).all(axis=(1, 2))
    share = np.clip(np.abs(branch["damping_ratio"].values) / WIDTH_OF_ALL, 0.0, 1.0)
    widths = THINNEST + (THICKEST - THINNEST) * share[1:]
    words = branch["whirl"].values[1:]
    axes.add_collection(
        LineCollection(
            [piece for piece, keep in zip(pieces, there, strict=True) if keep],
            colors=[WHIRL[str(word)] for word in words[there]],
            linewidths=widths[there].tolist(),
        )
    )


def _ends(found: xr.Dataset, unit: AxisUnit) -> list[End]:
    """The last known point of each branch with its name and damping ratio."""
    ends = []
    for number in range(found["branch"].size):
        frequency = found["frequency"].values[number]
        known = np.flatnonzero(np.isfinite(frequency))
        if known.size:
            ratio = 100.0 * float(found["damping_ratio"].values[number, known[-1]])
            height = float(frequency[known[-1]]) * unit.factor
            ends.append(End(height, str(found["name"].values[number]), f"{ratio:.2g} %"))
    return ends


def _greatest(found: xr.Dataset) -> float:
    """The greatest frequency to be seen, rad/s: of a branch, or of a torsional mode that the drawn lines meet."""
    met = [0.0]
    if "torsional_intersection_speed" in found:
        met += list((found["torsional_intersection_speed"] * found["torsional_intersection_harmonic"]).values)
    return float(max(np.nanmax(found["frequency"].values), *met))


def _torsion(axes: Axes, found: xr.Dataset, speed: np.ndarray, unit: AxisUnit, top: float) -> list[End]:
    """Torsional frequencies that fit into the picture, as dotted lines; their names."""
    if "torsional_frequency" not in found:
        return []
    ends: list[End] = []
    for rate, name in zip(found["torsional_frequency"].values, found["torsional_name"].values, strict=True):
        height = float(rate) * unit.factor
        if height < top:
            axes.plot(
                speed[[0, -1]], [height, height], color=INK, lw=1.4, ls=(0, (1, 1.6)), label="_" if ends else "torsion"
            )
            ends.append(End(height, f"{name}", "torsion"))
    return ends


def _coincident(axes: Axes, found: xr.Dataset, speed: np.ndarray, unit: AxisUnit, top: float) -> None:
    """Dashes of the color below where one branch hides another."""
    frequency, words = found["frequency"].values * unit.factor, found["whirl"].values
    for upper in range(1, found["branch"].size):
        for lower in range(upper):
            hidden = np.abs(frequency[upper] - frequency[lower]) < SAME * top
            hidden &= words[upper] != words[lower]
            if hidden.sum() < 2:
                continue
            for word in set(words[lower][hidden]):
                level = np.where(hidden & (words[lower] == word), frequency[lower], np.nan)
                axes.plot(speed, level, color=WHIRL[str(word)], lw=2.0, ls=(0, (4, 5)), label="_", zorder=2.1)


def _crossings(axes: Axes, found: xr.Dataset, across: AxisUnit, up: AxisUnit) -> None:
    speeds, harmonics = found["intersection_speed"].values, found["intersection_harmonic"].values
    if "torsional_intersection_speed" in found:
        speeds = np.append(speeds, found["torsional_intersection_speed"].values)
        harmonics = np.append(harmonics, found["torsional_intersection_harmonic"].values)
    top, written = axes.get_ylim()[1], list[tuple[float, float]]()
    for w, h in zip(speeds, harmonics, strict=True):
        if h * w * up.factor > top:
            continue
        axes.plot(w * across.factor, h * w * up.factor, "o", ms=6, mfc="white", mec=INK, mew=1.4, zorder=4, label="_")
        if any(h == other and abs(w - before) < SAME * w for before, other in written):
            continue  # forward and backward at the same place
        written.append((w, h))
        text = significant(w * across.factor) if w * across.factor < 1e3 else f"{w * across.factor:.0f}"
        label_point(axes, text, w * across.factor, h * w * up.factor, size=8.0)


def _explain(axes: Axes, found: xr.Dataset) -> None:
    drawn = found["whirl"].values[:, 1:]  # a piece of a branch has the color of its end
    words = [word for word in WHIRL if (drawn == word).any()]
    handles = [Line2D([], [], color=WHIRL[word], lw=2.0, label=word) for word in words]
    lines = [line for line in axes.get_lines() if not str(line.get_label()).startswith("_")]
    axes.legend(handles=[*handles, *lines], loc="upper left", ncols=2, frameon=True, framealpha=0.85, edgecolor="none")
