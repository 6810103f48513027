"""Bifurcation diagrams: what states and motions there are along a parameter, and which of them are stable."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from autobalancer.errors import QuestionError
from autobalancer.plots.answer import asked
from autobalancer.plots.style import CRITICAL, INK, axis_label, look, picture, with_ignored
from autobalancer.results.display_units import AxisUnit, axis_unit, length_axis, speed_axis
from autobalancer.results.run_argument import RunArgument

COLORS = {
    "balanced": "#0072B2",
    "mixed": "#56B4E9",
    "coincident": "#E69F00",
    "in line": "#009E73",
    "spread": "#6A51A3",
    "swinging": "#CC79A7",
    "stalled": "#8A4F1D",
    "partly stalled": "#7B3294",
}
NAMES = {
    "swinging": "balls swing (thick: greatest, thin: least)",
    "stalled": "balls stall (thick: greatest, thin: least)",
    "partly stalled": "some balls stall (thick: greatest, thin: least)",
}
ROUNDING = 1e-15  # m; a deflection below it is zero
TOO_CLOSE = 0.02  # of the picture: marks nearer to each other are one
MARKS = {
    "supercritical": ("o", INK, "Hopf, supercritical"),
    "subcritical": ("o", "white", "Hopf, subcritical"),
    "pitchfork": ("D", INK, "pitchfork"),
    "branch point": ("D", "white", "branch point"),
    "fold": ("v", INK, "fold"),
    "period doubling": ("s", "white", "period doubling"),
    "torus": ("p", "white", "torus"),
    "infinite period": ("*", INK, "period grows without limit"),
}


def branches(
    branches: RunArgument,
    *,
    deflection_unit: str | None = None,
    speed_unit: str = "rpm",
) -> Figure:
    """Draw branches over their parameter: deflection, ball angles, and the speed of stalled balls.

    Stable states and motions are solid, unstable ones dashed, one color for each kind. Periodic motions, and steady states on
    anisotropic supports, are drawn by their greatest (thick) and least value (thin). Stalled balls have no line among the
    angles but one among the speeds. Marks are small where an unstable state stays unstable; of equal marks very close to each
    other one is drawn. A branch too narrow to be read has a letter and is drawn again below, enlarged; up to three of them.

    Parameters
    ----------
    branches
        From :func:`branches`.
    deflection_unit
        ``"m"``, ``"mm"``, ``"um"`` or ``"nm"``; by default the one that suits the greatest deflection.
    speed_unit
        ``"rpm"``, ``"rad/s"`` or ``"Hz"``.

    Returns
    -------
    matplotlib.figure.Figure
        Save it with ``savefig`` or :func:`save_picture`.

    Raises
    ------
    QuestionError
        If there is nothing to draw or a unit is not possible.
    """
    branches = asked(branches, "branches")
    if not branches.sizes.get("point"):
        raise QuestionError("branches: there is no point to draw")
    across = axis_unit(branches["parameter"], speed_unit)
    lengths = length_axis(deflection_unit, float(np.nanmax(branches["deflection_max"].values)))
    speeds = speed_axis(speed_unit)
    stalls = bool(np.isin(branches["name"].values, ["stalled", "partly stalled"]).any())
    angles = branches["ball_angle_in_rotor_max"].values
    with_angles = angles.size > 0 and bool(np.isfinite(angles).any())
    count = 1 + with_angles + stalls
    with look():
        narrow = close_ups(branches)
        figure = picture(8.0, 1.6 + 2.5 * (count + bool(narrow)))
        rows = figure.add_gridspec(count + bool(narrow), 1)
        panels = [figure.add_subplot(rows[0])]
        panels += [figure.add_subplot(rows[row], sharex=panels[0]) for row in range(1, count)]
        for panel in panels[:-1]:
            panel.tick_params(labelbottom=False)
        panels[0].set_title(with_ignored(str(branches.attrs.get("title", "Branches")), branches.attrs))
        _draw(panels[0], branches, across, lengths, "deflection_min", "deflection_max")
        which = "greatest deflection\nof all stations" if "station" in branches.dims else "deflection"
        panels[0].set_ylabel(f"{which} ({lengths.sign})")
        greatest = float(np.nanmax(branches["deflection_max"].values))
        top = greatest * lengths.factor if greatest > ROUNDING else 1.0
        panels[0].set_ylim(-0.03 * top, 1.05 * top)  # states without deflection stay visible
        if with_angles:
            degrees = AxisUnit("°", 180.0 / math.pi)
            _draw(panels[1], branches, across, degrees, "ball_angle_in_rotor_min", "ball_angle_in_rotor_max")
            panels[1].set_ylabel("ball angle in the rotor (°)")
            panels[1].yaxis.set_major_locator(MaxNLocator(nbins=7, steps=[1, 1.5, 3, 4.5, 6, 9, 10]))
            if stalls:
                text = "stalled balls circle in the rotor: no line here"
                panels[1].set_title(text, loc="right", size=8.0, weight="normal", color="#606060")
        if stalls:
            _draw(panels[-1], branches, across, speeds, "ball_speed_in_space", "ball_speed_in_space")
            panels[-1].set_ylabel(f"mean ball speed in space ({speeds.sign})")
        panels[-1].set_xlabel(axis_label(branches["parameter"], across))
        if narrow:
            mark(panels[0], narrow, across, float(np.ptp(branches["parameter"].values)))
            _enlarge(narrow, empty_panels(figure, rows[count], narrow, across), branches, across, deflection_unit)
        figure.align_ylabels(panels)
        handles = _explained(branches)
        figure.legend(handles=handles, loc="outside lower center", ncols=3, columnspacing=2.0)
    return figure


def _enlarge(
    narrow: list[CloseUp], panels: list[Axes], data: xr.Dataset, across: AxisUnit, deflection_unit: str | None
) -> None:
    """The deflection of each narrow branch in the panel of its range."""
    for one, axes in zip(narrow, panels, strict=True):
        own = length_axis(deflection_unit, one.top)
        _draw(axes, data, across, own, "deflection_min", "deflection_max", (one.high - one.low, one.top))
        fit(axes, one, own)
        axes.set(xlabel=axis_label(data["parameter"], across), ylabel=f"deflection ({own.sign})")


def _draw(
    axes: Axes,
    data: xr.Dataset,
    across: AxisUnit,
    unit: AxisUnit,
    low: str,
    high: str,
    part: tuple[float, float] | None = None,
) -> None:
    """All branches and special points in one panel; of a ``part`` of them its width and its height in deflection, SI."""
    x = across.shown(data["parameter"].values)
    for piece, stable, name in _pieces(data):
        moving = low != high and np.isfinite(data["period"].values[piece]).any()
        for quantity, width in [(high, 1.5), (low, 0.9)] if moving else [(high, 1.5)]:
            values = np.atleast_2d(data[quantity].values.T)[:, piece] * unit.factor
            for line in values:
                style = "-" if stable else (0, (4, 2.2))
                axes.plot(
                    x[piece], line, ls=style, lw=width, color=COLORS.get(name, INK), zorder=2.5 if stable else 2.2
                )
    for i in _apart(data, part):
        kind = _mark_of(data, i)
        marker, face, _ = MARKS[kind]
        place = across.shown(float(data["special_parameter"].values[i]))
        for value in np.unique(np.round(np.atleast_1d(data[f"special_{high}"].values[i]) * unit.factor, 9)):
            small = 0.45 if data["special_unstable_directions"].values[i] else 1.0
            size = 9.0 if marker == "*" else 5.5 * small
            axes.plot(place, value, marker, ms=size, mfc=face, mec=INK, mew=0.9 * small, zorder=2.6 + small)


def _mark_of(data: xr.Dataset, i: int) -> str:
    return str(data["criticality"].values[i]) or str(data["special_type"].values[i])


def _apart(data: xr.Dataset, part: tuple[float, float] | None) -> list[int]:
    """Special points that get a mark: of equal ones so close that their marks would be one blob, the first."""
    if not data.sizes.get("special"):
        return []
    whole = float(np.ptp(data["parameter"].values)), float(np.nanmax(data["deflection_max"].values))
    span, tall = (value or 1.0 for value in part or whole)
    place, height = data["special_parameter"].values, data["special_deflection_max"].values
    kept: list[int] = []
    for i in range(place.size):
        near = (
            j for j in kept
            if _mark_of(data, i) == _mark_of(data, j)
            and math.hypot((place[i] - place[j]) / span, (height[i] - height[j]) / tall) < TOO_CLOSE
        )  # fmt: skip
        if next(near, None) is None:
            kept.append(i)
    return kept


def _pieces(data: xr.Dataset) -> Iterator[tuple[slice, bool, str]]:
    """Stretches of one branch with one stability and one name: slice of points, stable, name.

    A branch has one name, that of most of its points; only balls that forces hold may balance on one side and not on the other.
    """
    branch, name = data["branch"].values, data["name"].values
    bad = data["verdict"].values == "unstable"
    for number in np.unique(branch):
        points = np.flatnonzero(branch == number)
        spread = name[points] == "spread"
        names, counts = np.unique(name[points][~spread] if not spread.all() else name[points], return_counts=True)
        own = np.where(spread, "spread", names[np.argmax(counts)])
        dashed = bad[points[:-1]] | bad[points[1:]]
        first = 0
        for i in range(1, dashed.size + 1):
            if i == dashed.size or dashed[i] != dashed[first] or own[i] != own[first]:
                yield slice(points[first], points[i] + 1), not dashed[first], str(own[first])
                first = i


def _explained(data: xr.Dataset) -> list[Line2D]:
    names = dict.fromkeys(name for _, _, name in _pieces(data))
    handles = [Line2D([], [], color=COLORS.get(name, INK), lw=1.8, label=NAMES.get(name, name)) for name in names]
    if np.isfinite(data["period"].values[data["kind"].values == "equilibrium"]).any():
        for width, which in ((1.5, "greatest"), (0.9, "least")):
            handles.append(Line2D([], [], color=INK, lw=width, label=f"{which} over half a turn"))
    if (data["verdict"].values != "unstable").any():
        handles.append(Line2D([], [], color=INK, label="stable"))
    if (data["verdict"].values == "unstable").any():
        handles.append(Line2D([], [], color=INK, ls=(0, (4, 2.2)), label="unstable"))
    special = (
        zip(data["criticality"].values, data["special_type"].values, strict=True) if data.sizes.get("special") else ()
    )
    for kind in dict.fromkeys(str(a) or str(b) for a, b in special):
        marker, face, text = MARKS[kind]
        size = 9.0 if marker == "*" else 5.5
        handles.append(Line2D([], [], ls="", marker=marker, ms=size, mfc=face, mec=INK, mew=0.9, label=text))
    return handles


# Branches too narrow to be read in a picture of a wide range: letters on it, and panels of their own.


NARROW = 0.02  # of the range of the picture: narrower branches are vertical strokes
TOGETHER = 0.03  # of it: letters nearer to each other stand in one place
MOST = 3  # panels in a row


class CloseUp(NamedTuple):
    """Where one branch lies, SI."""

    branch: int  # from 1
    letter: str
    low: float
    high: float
    bottom: float
    top: float


def close_ups(data: xr.Dataset) -> list[CloseUp]:
    """Of the branches that are too narrow, up to three: the widest, by their parameter."""
    parameter, branch = data["parameter"].values, data["branch"].values
    span, items = float(np.ptp(parameter)), []
    for number in np.unique(branch):
        here = branch == number
        low, high = float(parameter[here].min()), float(parameter[here].max())
        if 0.0 < high - low < NARROW * span:
            bottom, top = (
                float(data["deflection_min"].values[here].min()),
                float(data["deflection_max"].values[here].max()),
            )
            items.append(CloseUp(int(number), "", low, high, bottom, top))
    widest = sorted(items, key=lambda one: one.low - one.high)[:MOST]
    return [
        one._replace(letter=letter) for letter, one in zip("abc", sorted(widest, key=lambda w: w.low), strict=False)
    ]


def mark(axes: Axes, narrow: list[CloseUp], across: AxisUnit, span: float) -> None:
    """Letters above the places of the close-ups; those of neighbors stand together."""
    groups: list[list[CloseUp]] = []
    for one in narrow:
        if groups and one.low - groups[-1][-1].high < TOGETHER * span:
            groups[-1].append(one)
        else:
            groups.append([one])
    for group in groups:
        place = across.shown(0.5 * (group[0].low + group[-1].high))
        axes.axvline(place, color=CRITICAL, lw=0.6, ls=":", zorder=1.5)
        axes.annotate(
            ", ".join(one.letter for one in group), (place, 1.0), xycoords=("data", "axes fraction"), xytext=(3.0, -2.0),
            textcoords="offset points", va="top", fontweight="bold",
        )  # fmt: skip


def empty_panels(figure: Figure, row: SubplotSpec, narrow: list[CloseUp], across: AxisUnit) -> list[Axes]:
    """An empty panel for each with its range along the parameter, and its letter."""
    grid, empty_panels = row.subgridspec(1, len(narrow)), []
    for column, one in enumerate(narrow):
        axes = figure.add_subplot(grid[column])
        room = 0.12 * (one.high - one.low)
        axes.set_xlim(across.shown(one.low - room), across.shown(one.high + room))
        axes.xaxis.set_major_locator(MaxNLocator(3))
        axes.ticklabel_format(axis="x", useOffset=False)
        axes.set_title(f"{one.letter}: branch {one.branch}, enlarged", fontsize=9.0)
        empty_panels.append(axes)
    return empty_panels


def fit(axes: Axes, close_up: CloseUp, unit: AxisUnit) -> None:
    """The range of its deflection; after everything is drawn."""
    room = 0.08 * (close_up.top - close_up.bottom) or 0.05 * close_up.top or 1e-9
    axes.set_ylim((close_up.bottom - room) * unit.factor, (close_up.top + room) * unit.factor)
