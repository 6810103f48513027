"""Pictures of a rotor without balls: modes, critical speeds, response to unbalance."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import offset_copy
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline

from autobalancer.errors import QuestionError, one_of
from autobalancer.plots.answer import asked
from autobalancer.plots.style import (
    BALLS,
    CRITICAL,
    INK,
    SAME,
    UNBALANCE,
    End,
    heading,
    joint_name,
    label_point,
    legend,
    look,
    moved_apart,
    picture,
    plain_log_ticks,
    with_ignored,
    wrapped,
)
from autobalancer.results.display_units import AxisUnit, length_axis, length_text, significant, speed_axis
from autobalancer.results.run_argument import RunArgument

# The unbalance response: amplitude and phase over the speed (Bode), and in the complex plane (polar, Nyquist).


STYLES = ("-", (0, (5, 2)), (0, (1, 1.2)), (0, (6, 1.5, 1, 1.5)))


def response(
    found: RunArgument,
    *,
    speed_unit: str = "rpm",
    deflection_unit: str | None = None,
    log: bool = True,
    critical_speeds: Sequence[float] = (),
) -> Figure:
    """Draw the Bode diagram: above the amplitudes at each station along x and y, below the phases to the unbalance.

    Thick is the mean over the stations of the greatest deflections. Shaded are the speeds at which the whirl at a station is
    backward. Phases are within ±180 degrees.

    Parameters
    ----------
    found
        From ``ab.rotor.response``; with ``smooth=True`` there, every peak is drawn in full.
    speed_unit
        ``"rpm"``, ``"rad/s"`` or ``"Hz"``.
    deflection_unit
        ``"m"``, ``"mm"``, ``"um"``, ``"nm"``, with /s or /s² for velocities and accelerations; by default what suits.
    log
        Logarithmic amplitudes.
    critical_speeds
        Marked by vertical lines, rad/s.

    Raises
    ------
    QuestionError
        If ``found`` is no unbalance response, has fewer than two speeds, or a unit is unknown.
    """
    found = asked(found, "response")
    unit, size = _checked(found, "plot.response", speed_unit, deflection_unit)
    found = found.sortby("speed")
    speed = found["speed"].values * unit.factor
    with look():
        figure = picture(8.0, 6.0)
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=[1.7, 1.0])
        heading(figure, with_ignored(str(found.attrs.get("title", "")), found.attrs))
        mean = found["mean_of_greatest"].values * size.factor
        label = "mean of the greatest" if found.sizes["station"] > 1 else "greatest"
        above.plot(speed, mean, color=INK, lw=2.6, alpha=0.35, label=label)
        for number, name in enumerate(found["station"].values):
            station = found.isel(station=number)
            for style, letter in zip(STYLES, "xy", strict=False):
                line = np.hypot(station[f"{letter}_real"].values, station[f"{letter}_imag"].values) * size.factor
                color = BALLS[number % len(BALLS)]
                above.plot(speed, line, color=color, ls=style, label=f"{name}, {letter}")
                phase = wrapped(speed, np.unwrap(station[f"{letter}_phase"].values))
                below.plot(*phase, color=color, ls=style, label=f"{name}, {letter}")
            _underlay(above, speed, station["whirl"].values == "backward", number, f"{name}, backward whirl")
        for level in critical_speeds:
            for axes in (above, below):
                axes.axvline(level * unit.factor, color=CRITICAL, lw=0.9, ls=(0, (1, 2)))
        if log:
            above.set_yscale("log")
            plain_log_ticks(above, "y")
        above.set_ylabel(f"{found.attrs['quantity']} ({size.sign})")
        below.set(
            ylabel="phase to the unbalance (°)",
            yticks=np.arange(-180.0, 181.0, 90.0),
            xlabel=f"rotor speed ({unit.sign})",
            xlim=(speed[0], speed[-1]),
        )
        figure.legend(*above.get_legend_handles_labels(), loc="outside lower center", ncols=4)
        figure.align_ylabels([above, below])
    return figure


def polar_response(
    dataset: xr.Dataset, *, part: str = "forward", speed_unit: str = "rpm", deflection_unit: str | None = None
) -> Figure:
    """Draw the response in the complex plane of the rotor: every resonance is a loop, passed through clockwise.

    The unbalance points to the right; the rotor follows it at the start of the loop, and is opposite after it. Dots mark
    the peaks and both ends.

    Parameters
    ----------
    dataset
        From ``ab.rotor.response``.
    part
        ``"forward"``, ``"x"`` or ``"y"``.
    speed_unit, deflection_unit
        As for ``ab.plot.response``.

    Raises
    ------
    QuestionError
        If it has fewer than two speeds, or a unit or part is unknown.
    """
    unit, size = _checked(dataset, "plot.answer", speed_unit, deflection_unit)
    one_of("part", part, "forward", "x", "y")
    dataset = dataset.sortby("speed")
    speed = dataset["speed"].values
    with look():
        figure = picture(5.8, 5.9)
        axes = figure.subplots()
        axes.axhline(0.0, color=CRITICAL, lw=0.8)
        axes.axvline(0.0, color=CRITICAL, lw=0.8)
        for number, name in enumerate(dataset["station"].values):
            station = dataset.isel(station=number)
            if part == "forward":
                radius, angle = station["forward"].values, station["phase"].values
            else:
                radius = np.hypot(station[f"{part}_real"].values, station[f"{part}_imag"].values)
                angle = station[f"{part}_phase"].values
            curve = radius * size.factor * np.exp(1j * angle)
            color = BALLS[number % len(BALLS)]
            between = _between(speed, curve)
            axes.plot(between.real, between.imag, color=color, label=str(name))
            for place in _marked(curve):
                axes.plot(curve[place].real, curve[place].imag, "o", ms=4, color=color, label="_")
                shown = speed[place] * unit.factor
                text = significant(shown) if shown < 1e3 else f"{shown:.0f}"
                label_point(axes, text, curve[place].real, curve[place].imag, size=8.0)
        axes.set_aspect("equal", adjustable="datalim")
        where = "forward circle" if part == "forward" else f"{dataset.attrs['quantity']} along {part}"
        axes.set(
            xlabel=f"{where}, in the direction of the unbalance ({size.sign})",
            ylabel=f"{where}, 90° ahead of it ({size.sign})",
        )
        heading(
            figure,
            with_ignored(f"{dataset.attrs.get('title', '')}\nnumbers: rotor speed in {unit.sign}", dataset.attrs),
        )
        legend(axes)
    return figure


def _checked(
    dataset: xr.Dataset, owner: str, speed_unit: str, deflection_unit: str | None
) -> tuple[AxisUnit, AxisUnit]:
    if dataset["speed"].size < 2:
        raise QuestionError(f"{owner}: the result has one speed only; ask for several")
    plain = length_axis(deflection_unit, float(dataset["semi_major"].max()))
    rate = {"displacement": "", "velocity": "/s", "acceleration": "/s²"}[dataset.attrs["quantity"]]
    return speed_axis(speed_unit), AxisUnit(plain.sign + rate, plain.factor)


def _underlay(axes: Axes, speed: np.ndarray, backward: np.ndarray, number: int, label: str) -> None:
    ends = np.flatnonzero(np.diff(np.concatenate([[False], backward, [False]]).astype(np.int64)))
    for first, last in zip(ends[::2], ends[1::2], strict=True):
        color = BALLS[number % len(BALLS)]
        axes.axvspan(speed[first], speed[last - 1], color=color, alpha=0.12, lw=0, label=label)
        label = "_"


def _between(speed: np.ndarray, curve: np.ndarray) -> np.ndarray:
    """A smooth line through the values: a loop near a resonance is a circle, not a polygon."""
    fine = np.concatenate([np.linspace(a, b, 8, endpoint=False) for a, b in pairwise(speed)] + [speed[-1:]])
    return np.asarray(CubicSpline(speed, curve)(fine))


def _marked(curve: np.ndarray) -> list[int]:
    """Both ends and the places where the amplitude is greatest."""
    size = np.abs(curve)
    peaks = np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] >= size[2:])) + 1
    return sorted({0, curve.size - 1, *peaks[size[peaks] > 0.05 * size.max()].tolist()})


# The Campbell diagram.


WHIRL = {"forward": BALLS[0], "backward": BALLS[1], "mixed": BALLS[3], "straight": "#8A8A8A"}
THINNEST, THICKEST, WIDTH_OF_ALL = 1.0, 6.0, 0.2  # a damping ratio of 0.2 has the thickest line


def campbell(found: RunArgument, *, speed_unit: str = "rpm", frequency_unit: str = "Hz") -> Figure:
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
    found = asked(found, "campbell")
    across, up = speed_axis(speed_unit), speed_axis(frequency_unit)
    speed = found["speed"].values * across.factor
    with look():
        figure = picture(8.4, 5.2)
        axes = figure.subplots()
        heading(figure, with_ignored(str(found.attrs.get("title", "Campbell diagram")), found.attrs))
        room = 1.3 if "torsional_frequency" in found else 1.12  # for the legend
        top = room * _greatest(found) * up.factor
        for h in found.attrs.get("harmonics", [1.0]):
            line = found["speed"].values * h * up.factor
            axes.plot(speed, line, color=CRITICAL, lw=1.0, ls=(0, (5, 3)), label=f"harmonic {h:g}")
        for number in range(found["branch"].size):
            _branch(axes, found.isel(branch=number), speed, up)
        _coincident(axes, found, speed, up, top)
        ends = _ends(found, up) + _torsion(axes, found, speed, up, top)
        _end_labels(axes, float(speed[-1]), ends, top)
        axes.set(xlim=(speed[0], speed[-1]), ylim=(0.0, top))
        _crossings(axes, found, across, up)
        axes.set(xlabel=f"rotor speed ({across.sign})", ylabel=f"natural frequency ({up.sign})")
        # names of the colors
        drawn = found["whirl"].values[:, 1:]  # a piece of a branch has the color of its end
        words = [word for word in WHIRL if (drawn == word).any()]
        handles = [Line2D([], [], color=WHIRL[word], lw=2.0, label=word) for word in words]
        legend(axes, handles)
    return figure


NEED, SIZE = 0.045, 8.0  # of the axis, what a label needs; and its size in points

WIDEST = 48  # letters of a line; longer names have several lines, so that the axes keep their room

BESIDE, APART = 5.0, 26.0  # points from the end to its label, and where labels had to be moved


def _end_labels(axes: Axes, x: float, ends: Sequence[End], top: float) -> None:
    """Write names to the right of the ends at ``x`` on an axis from 0 to ``top``; thin lines lead to those that were moved."""
    groups = grouped_ends(sorted(ends), SAME * top)
    heights = np.array([np.mean([end.height for end in group]) for group in groups])
    texts = [in_lines(joint_name(group)) for group in groups]
    lines = np.array([text.count("\n") + 1 for text in texts])
    places = moved_apart(np.repeat(heights, lines), NEED * top)
    levels = np.array([part.mean() for part in np.split(places, np.cumsum(lines)[:-1])])
    moved = bool((np.abs(levels - heights) > 0.2 * NEED * top).any())
    for text, height, level in zip(texts, heights, levels, strict=True):
        axes.annotate(
            text,
            (x, float(height)),
            xytext=(1.0, float(level) / top),
            textcoords=offset_copy(axes.transAxes, axes.get_figure(root=True), x=APART if moved else BESIDE, units="points"),
            va="center",
            fontsize=SIZE,
            color=INK,
            annotation_clip=False,
            arrowprops={"arrowstyle": "-", "color": INK, "lw": 0.6, "shrinkA": 1.0, "shrinkB": 2.0, "relpos": (0.0, 0.5)}
            if moved
            else None,
        )  # fmt: skip


def grouped_ends(ends: Sequence[End], near: float) -> list[list[End]]:
    """Ascending ends in groups of those that are ``near`` to the one before."""
    groups: list[list[End]] = []
    for end in ends:
        if groups and end.height - groups[-1][-1].height <= near:
            groups[-1].append(end)
        else:
            groups.append([end])
    return groups


def in_lines(text: str) -> str:
    """A long text in lines that end at its commas."""
    first, *rest = text.split(", ")
    lines = [first]
    for part in rest:
        if len(lines[-1]) + len(part) + 2 > WIDEST:
            lines[-1] += ","
            lines.append(part)
        else:
            lines[-1] += f", {part}"
    return "\n".join(lines)


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


def _ends(dataset: xr.Dataset, unit: AxisUnit) -> list[End]:
    """The last known point of each branch with its name and damping ratio."""
    ends = []
    for number in range(dataset["branch"].size):
        frequency = dataset["frequency"].values[number]
        known = np.flatnonzero(np.isfinite(frequency))
        if known.size:
            ratio = 100.0 * float(dataset["damping_ratio"].values[number, known[-1]])
            height = float(frequency[known[-1]]) * unit.factor
            ends.append(End(height, str(dataset["name"].values[number]), f"{ratio:.2g} %"))
    return ends


def _greatest(dataset: xr.Dataset) -> float:
    """The greatest frequency to be seen, rad/s: of a branch, or of a torsional mode that the drawn lines meet."""
    met = [0.0]
    if "torsional_intersection_speed" in dataset:
        met += list((dataset["torsional_intersection_speed"] * dataset["torsional_intersection_harmonic"]).values)
    return float(max(np.nanmax(dataset["frequency"].values), *met))


def _torsion(axes: Axes, dataset: xr.Dataset, speed: np.ndarray, unit: AxisUnit, top: float) -> list[End]:
    """Torsional frequencies that fit into the picture, as dotted lines; their names."""
    if "torsional_frequency" not in dataset:
        return []
    ends: list[End] = []
    for rate, name in zip(dataset["torsional_frequency"].values, dataset["torsional_name"].values, strict=True):
        height = float(rate) * unit.factor
        if height < top:
            axes.plot(
                speed[[0, -1]], [height, height], color=INK, lw=1.4, ls=(0, (1, 1.6)), label="_" if ends else "torsion"
            )
            ends.append(End(height, f"{name}", "torsion"))
    return ends


def _coincident(axes: Axes, dataset: xr.Dataset, speed: np.ndarray, unit: AxisUnit, top: float) -> None:
    """Dashes of the color below where one branch hides another."""
    frequency, words = dataset["frequency"].values * unit.factor, dataset["whirl"].values
    for upper in range(1, dataset["branch"].size):
        for lower in range(upper):
            hidden = np.abs(frequency[upper] - frequency[lower]) < SAME * top
            hidden &= words[upper] != words[lower]
            if hidden.sum() < 2:
                continue
            for word in set(words[lower][hidden]):
                level = np.where(hidden & (words[lower] == word), frequency[lower], np.nan)
                axes.plot(speed, level, color=WHIRL[str(word)], lw=2.0, ls=(0, (4, 5)), label="_", zorder=2.1)


def _crossings(axes: Axes, dataset: xr.Dataset, across: AxisUnit, up: AxisUnit) -> None:
    speeds, harmonics = dataset["intersection_speed"].values, dataset["intersection_harmonic"].values
    if "torsional_intersection_speed" in dataset:
        speeds = np.append(speeds, dataset["torsional_intersection_speed"].values)
        harmonics = np.append(harmonics, dataset["torsional_intersection_harmonic"].values)
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


# Mode shapes along the axis.


def modes(found: RunArgument, *, frequency_unit: str = "Hz", modes: int = 6) -> Figure:
    """Draw the lowest mode shapes: deflection along x and y over the axis, at the instant of greatest deflection.

    Shaded is the greatest deflection in the course of a whirl, dots are the stations. Above each shape stand its name,
    natural frequency, damping ratio and direction of whirl.

    Parameters
    ----------
    found
        From ``ab.rotor.modes``.
    frequency_unit
        ``"Hz"``, ``"rad/s"`` or ``"rpm"``.
    modes
        How many.

    Raises
    ------
    QuestionError
        If ``found`` is no result of ``ab.rotor.modes``, or the unit is unknown.
    """
    found = asked(found, "modes")
    if modes < 1:
        raise QuestionError(f"modes: given {modes}; must be at least 1")
    unit = speed_axis(frequency_unit)
    count = min(modes, found["mode"].size)
    columns = min(2, count)
    rows = -(-count // columns)
    with look():
        figure = picture(4.4 * columns, 0.7 + 2.1 * rows)
        heading(figure, with_ignored(str(found.attrs.get("title", "Modes")), found.attrs))
        grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
        for number, axes in enumerate(grid.ravel()):
            if number >= count:
                axes.set_visible(False)
                continue
            _shape(axes, found.isel(mode=number))
            mode = found.isel(mode=number)
            axes.set_title(
                f"{_with_whirl(mode)}\n{mode['frequency'].item() * unit.factor:.4g} {unit.sign}, "
                f"damping {100.0 * mode['damping_ratio'].item():.2g} %",
                fontsize=8.5,
                color=INK,
            )
        grid[0, 0].set_ylim(-1.15, 1.15)
        for axes in grid[-1]:
            axes.set_xlabel("position along the axis (mm)")
        for axes in grid[:, 0]:
            axes.set_ylabel("deflection (relative)")
        handles, labels = grid[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=len(handles))
    return figure


def _with_whirl(mode: xr.Dataset) -> str:
    """The name of a mode, and its whirl where the name does not contain it."""
    name, whirl = str(mode["name"].item()), str(mode["whirl"].item())
    return name if whirl in name.split() else f"{name}, {whirl} whirl"


def _shape(axes: Axes, mode: xr.Dataset) -> None:
    x, y = (mode[f"{letter}_real"].values + 1j * mode[f"{letter}_imag"].values for letter in "xy")
    place = mode["place"].values * 1e3
    marker = "o" if place.size == 1 else ""
    greatest = np.abs(0.5 * (x + 1j * y)) + np.abs(0.5 * (x - 1j * y))
    top = int(np.argmax(greatest))
    instant = np.exp(-0.5j * np.angle(x[top] ** 2 + y[top] ** 2))
    axes.fill_between(place, -greatest, greatest, color="#E9EDF0", lw=0, label="greatest deflection in a whirl")
    axes.axhline(0.0, color=CRITICAL, lw=0.8)
    for letter, line, color in (("x", x, BALLS[0]), ("y", y, BALLS[2])):
        axes.plot(place, (line * instant).real, color=color, marker=marker, label=f"along {letter}")
        at = mode[f"station_{letter}_real"].values + 1j * mode[f"station_{letter}_imag"].values
        known = np.isfinite(mode["position"].values)
        dots = mode["position"].values[known] * 1e3, (at[known] * instant).real
        axes.plot(*dots, "o", ms=3.5, color=color, label="_stations")


# Whirl orbits at stations and along the axis.


STRINGS = 12  # lines from end to end through points of one instant


def whirl_orbits(found: xr.Dataset, *, deflection_unit: str | None = None, speed_unit: str = "rpm") -> Figure:
    """Draw the orbits at all stations to one scale, with their direction and the point at rotor angle zero.

    Parameters
    ----------
    found
        From :func:`~autobalancer.rotordynamics.response.whirl_orbits`.
    deflection_unit
        ``"m"``, ``"mm"``, ``"um"`` or ``"nm"``; by default what suits.
    speed_unit
        Of the title: ``"rpm"``, ``"rad/s"`` or ``"Hz"``.

    Raises
    ------
    QuestionError
        If a unit is unknown.
    """
    span = float(found["semi_major"].max())
    unit = length_axis(deflection_unit, span)
    count = found["station"].size
    columns = min(3, count)
    rows = -(-count // columns)
    with look():
        figure = picture(3.2 * columns + 0.4, 3.5 * rows + 0.7)
        figure.get_layout_engine().set(h_pad=0.1)  # type: ignore[union-attr, call-arg]
        heading(figure, _title(found, speed_unit))
        grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
        for number, axes in enumerate(grid.ravel()):
            if number >= count:
                axes.set_visible(False)
                continue
            station = found.isel(station=number)
            word = str(station["whirl"].item())
            x, y = station["x"].values * unit.factor, station["y"].values * unit.factor
            axes.set_aspect("equal")
            axes.plot(0.0, 0.0, "+", ms=8, color=CRITICAL, label="_rest")
            axes.plot(x, y, color=WHIRL[word], label="orbit")
            axes.plot(x[0], y[0], "o", ms=5, mfc="white", mec=UNBALANCE, mew=1.6, label="rotor angle 0")
            _arrow(axes, x, y, WHIRL[word])
            axes.set_title(f"{station['station'].item()}: {word}", color=WHIRL[word])
        reach = 1.12 * span * unit.factor or 1.0
        grid[0, 0].set(xlim=(-reach, reach), ylim=(-reach, reach))
        for axes in grid[-1]:
            axes.set_xlabel(f"x ({unit.sign})")
        for axes in grid[:, 0]:
            axes.set_ylabel(f"y ({unit.sign})")
    return figure


def whirl_along_axis(found: xr.Dataset, *, deflection_unit: str | None = None, speed_unit: str = "rpm") -> Figure:
    """Draw the orbits along the axis in space: the surface on which the axis runs, and the axis at rotor angle zero.

    Parameters
    ----------
    found, deflection_unit, speed_unit
        As for :func:`whirl_orbits`.

    Raises
    ------
    QuestionError
        If the rotor has one plane only, or a unit is unknown.
    """
    if found["place"].size < 2:
        raise QuestionError("plot.answer: the rotor has one plane only; draw its 'whirl_orbits'")
    place = found["place"].values * 1e3
    x, y = found["axis_x"].values, found["axis_y"].values
    unit = length_axis(deflection_unit, float(np.hypot(x, y).max()))
    x, y = x * unit.factor, y * unit.factor
    known = np.isfinite(found["position"].values)
    with look():
        figure = picture(8.2, 4.8)
        axes = figure.add_subplot(projection="3d")
        axes.set_box_aspect((2.4, 1.0, 1.0))
        step = max(1, (x.shape[1] - 1) // STRINGS)
        for i in range(0, x.shape[1] - 1, step):
            axes.plot(place, x[:, i], y[:, i], color=INK, lw=0.4, alpha=0.35)
        axes.plot(place, x[:, 0], y[:, 0], color=UNBALANCE, lw=1.8, label="rotor angle 0")
        axes.plot(place[[0, -1]], [0.0, 0.0], [0.0, 0.0], color=CRITICAL, lw=0.8, ls=(0, (5, 3)), label="at rest")
        named: set[str] = set()
        reach = float(np.hypot(x, y).max()) or 1.0
        for number in np.flatnonzero(known):
            station = found.isel(station=int(number))
            at = np.full(found["rotor_angle"].size, 1e3 * float(station["position"]))
            word = str(station["whirl"].item())
            ring = station["x"].values * unit.factor, station["y"].values * unit.factor
            name = f"{station['station'].item()}, {length_text(float(station['semi_major']))}"
            axes.plot(at, *ring, color=WHIRL[word], lw=1.6, label="_" if word in named else f"{word} whirl")
            named.add(word)
            axes.text(at[0], 0.0, 1.12 * reach, name, ha="center", fontsize=8.5, color=INK)
            head, tip = at.size // 12, at.size // 12 + max(1, at.size // 24)
            axes.quiver(
                at[0], ring[0][head], ring[1][head], 0.0, *(float(r[tip] - r[head]) for r in ring),
                color=WHIRL[word], arrow_length_ratio=1.0,
            )  # fmt: skip
        axes.set(ylim=(-reach, reach), zlim=(-reach, reach))
        axes.set_xlabel("position along the axis (mm)", labelpad=14)
        axes.set_ylabel(f"x ({unit.sign})", labelpad=8)
        axes.set_zlabel(f"y ({unit.sign})")
        for axis in (axes.yaxis, axes.zaxis):
            axis.set_major_locator(MaxNLocator(5))
        heading(figure, f"{_title(found, speed_unit)}\nnumbers: greatest deflection of the station")
        figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=5)
    return figure


def _title(dataset: xr.Dataset, speed_unit: str) -> str:
    unit = speed_axis(speed_unit)
    title = f"{dataset.attrs.get('title', '')} at {significant(dataset.attrs['speed'] * unit.factor)} {unit.sign}"
    return with_ignored(title, dataset.attrs)


def _arrow(axes: Axes, x: np.ndarray, y: np.ndarray, color: str) -> None:
    """An arrow head an eighth of a turn after the start."""
    i = max(1, x.size // 8)
    if np.hypot(x[i + 1] - x[i - 1], y[i + 1] - y[i - 1]) == 0.0:
        return
    axes.annotate(
        "",
        (x[i + 1], y[i + 1]),
        xytext=(x[i - 1], y[i - 1]),
        arrowprops={"arrowstyle": "-|>,head_length=0.8,head_width=0.35", "color": color, "shrinkA": 0, "shrinkB": 0},
    )


# The response of a rotor with rings of liquid, beside the rotor alone and one with balls.


def liquid_response(
    found: xr.Dataset, *, balls: tuple[ArrayLike, ArrayLike] | None = None, speed_unit: str = "rpm"
) -> Figure:
    """Draw the steady deflection over the speed: rotor alone, with frozen liquid, with liquid.

    Parameters
    ----------
    found
        From ``ab.rotor.liquid_response``.
    balls
        Speeds (rad/s) and deflections (m) of the same rotor with balls, drawn as points.
    speed_unit
        ``"rpm"``, ``"rad/s"`` or ``"Hz"``.

    Raises
    ------
    QuestionError
        If it has fewer than two speeds, or the unit is unknown.
    """
    if found["speed"].size < 2:
        raise QuestionError("plot.answer: the result has one speed only; ask for several")
    found, unit = found.sortby("speed"), speed_axis(speed_unit)
    speed, attrs = found["speed"].values * unit.factor, found.attrs
    with look():
        figure = picture(8.0, 4.8)
        axes = figure.subplots()
        heading(figure, with_ignored(str(attrs["title"]), attrs))
        axes.plot(speed, 1e3 * found["without_liquid"].values, color=INK, ls="--", lw=1.1, label="without liquid")
        axes.plot(speed, 1e3 * found["frozen"].values, color=BALLS[2], ls=":", lw=1.3, label="liquid frozen")
        axes.plot(speed, 1e3 * found["deflection"].values, color=BALLS[0], lw=1.8, label="liquid")
        if balls is not None:
            at, deflection = (np.asarray(part, float) for part in balls)
            axes.plot(at * unit.factor, 1e3 * deflection, "o", color=BALLS[1], ms=4.5, label="balls")
        limit = attrs["rotor_mass"] / (attrs["rotor_mass"] + attrs["full_mass"])
        if np.isfinite(attrs["unstable_from"]):
            band = [attrs[key] * unit.factor for key in ("unstable_from", "unstable_to")]
            axes.axvspan(*band, color=BALLS[0], alpha=0.1, lw=0.0, label="self-excited without damping")
        axes.set_yscale("log")
        plain_log_ticks(axes, "y")
        axes.set(xlim=(speed[0], speed[-1]), xlabel=f"rotor speed ({unit.sign})", ylabel="deflection (mm)")
        axes.set_title(f"far above resonance liquid leaves {100.0 * limit:.3g} %", fontsize=9.0)
        figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


# The torsional response of a drive train over the speed.


def torsional_response(found: xr.Dataset, *, speed_unit: str = "rpm") -> Figure:
    """Draw torque and twist of every link over the speed, each harmonic with a line style of its own.

    Parameters
    ----------
    found
        From ``ab.rotor.torsional_response``.
    speed_unit
        ``"rpm"``, ``"rad/s"`` or ``"Hz"``.

    Raises
    ------
    QuestionError
        If it has fewer than two speeds, or the unit is unknown.
    """
    if found["speed"].size < 2:
        raise QuestionError("plot.answer: the result has one speed only; ask for several")
    found, unit = found.sortby("speed"), speed_axis(speed_unit)
    speed = found["speed"].values * unit.factor
    with look():
        figure = picture(8.0, 6.0)
        above, below = figure.subplots(2, 1, sharex=True)
        heading(figure, with_ignored(str(found.attrs.get("title", "Torsional response")), found.attrs))
        for i, link in enumerate(found["link"].values):
            for j, harmonic in enumerate(found["harmonic"].values):
                at = found.isel(link=i, harmonic=j)
                drawn = {
                    "color": BALLS[i % len(BALLS)],
                    "ls": STYLES[j % len(STYLES)],
                    "label": f"{link}, harmonic {harmonic:g}",
                }
                above.plot(speed, at["link_torque"].values, **drawn)
                below.plot(speed, np.degrees(at["twist"].values), **drawn)
        for axes, text in ((above, "torque (N m)"), (below, "twist (°)")):
            axes.set_yscale("log")
            plain_log_ticks(axes, "y")
            axes.set_ylabel(text)
        below.set(xlabel=f"rotor speed ({unit.sign})", xlim=(speed[0], speed[-1]))
        figure.legend(*above.get_legend_handles_labels(), loc="outside lower center", ncols=3)
        figure.align_ylabels([above, below])
    return figure


# Picture of the planar oscillators of a rotor: receptances, and how far they hold.


def equivalent_planar(data: xr.Dataset, *, direction: str = "x", speed_unit: str = "rpm") -> Figure:
    """Receptance of rotor and oscillators over the speed, and the deviation with the tolerance.

    Parameters
    ----------
    data
        Of an :class:`~autobalancer.rotordynamics.equivalent_planar.EquivalentPlanar`.
    direction
        x or y.
    speed_unit
        rpm, rad/s or Hz.

    Raises
    ------
    QuestionError
        If there is no such direction.
    """
    one_of("direction", direction, "x", "y")
    unit, one = speed_axis(speed_unit), data.sel(direction=direction)
    speed = one["speed"].values
    with look():
        figure = picture(6.6, 5.0)
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=[1.6, 1.0])
        above.semilogy(unit.factor * speed, 1e6 * one["receptance"].values, color=INK, lw=2.0, label="rotor")
        for color, way in zip(BALLS, one["way"].values, strict=False):
            k, mass, b = (float(one[name].sel(way=way)) for name in ("stiffness", "mass", "damping"))
            own = 1.0 / np.abs(k - speed**2 * mass + 1j * speed * b)
            above.semilogy(unit.factor * speed, 1e6 * own, "--", color=color, label=f"oscillator, {way}")
            below.plot(unit.factor * speed, 100.0 * one["deviation"].sel(way=way).values, "--", color=color)
            first, last = (float(one[end].sel(way=way)) * unit.factor for end in ("valid_from", "valid_to"))
            if np.isfinite(first):
                below.axvspan(first, last, color=color, alpha=0.12, lw=0, label=f"{way}: valid")
        below.plot(
            unit.factor * speed,
            100.0 * one["other_modes_share"].values,
            ":",
            color=INK,
            label="other modes",
        )
        below.axhline(100.0 * data.attrs["tolerance"], color=CRITICAL, lw=0.8, label="tolerance")
        below.set_ylim(0.0, 400.0 * data.attrs["tolerance"])
        for axes in (above, below):
            axes.axvline(unit.factor * float(one["critical_speed"]), color=CRITICAL, lw=0.8, ls=(0, (2, 2)))
            legend(axes)
        heading(figure, with_ignored(f"{data.attrs['title']}, along {direction}", data.attrs))
        above.set(ylabel="receptance (µm/N)")
        below.set(xlabel=f"speed ({unit.sign})", ylabel="deviation (%)", xlim=(0.0, unit.factor * speed[-1]))
    return figure
