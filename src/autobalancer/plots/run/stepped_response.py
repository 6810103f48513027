"""A stepped frequency response as a picture: amplitude over the speed, and where the balls were."""

from __future__ import annotations

import math
from typing import Any, Literal

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MultipleLocator

from autobalancer.errors import QuestionError
from autobalancer.plots.answer import asked
from autobalancer.plots.run.history import ball_looks, critical_speeds_of
from autobalancer.plots.style import (
    ALL_BALLS,
    CRITICAL,
    INK,
    UNBALANCE,
    heading,
    legend_width,
    look,
    picture,
    plain_log_ticks,
)
from autobalancer.results.display_units import AxisUnit, length_axis, length_text, round_down, speed_axis
from autobalancer.results.run_argument import RunArgument
from autobalancer.results.time_series import wrapped

WIDE = 500.0  # points that a legend may take
COLORS = {"at rest": INK, "swinging": "#9AA0A6", "stalled": "#7B3294"}  # none of a ball
JUMP = 2.0  # neighbors whose amplitudes differ by a greater factor are not joined
DEEP = 1e-5  # of the greatest amplitude; a logarithmic axis begins here, and lower marks stand on its edge
MARKERS = {"up": "^", "down": "v", "fixed": "o"}
WAYS = {"up": "upwards", "down": "downwards", "fixed": "each from the start state"}


def stepped_response(
    found: RunArgument,
    *,
    quantity: Literal["amplitude", "greatest_mean_deflection"] = "amplitude",
    speed_unit: str = "rpm",
    deflection_unit: str | None = None,
    log: bool = True,
    zero: float = 0.0,
) -> Figure:
    """Amplitude over the rotor speed, colored by what the balls do, and below it the range of each ball angle.

    Parameters
    ----------
    found
        From :func:`autobalancer.stepped_response`.
    quantity
        ``amplitude``, the mean over the stations of their greatest deflections, or ``greatest_mean_deflection``.
    speed_unit
        rpm, rad/s or Hz.
    deflection_unit
        m, mm, um or nm; by default what suits the greatest value.
    log
        Whether the amplitude axis is logarithmic.
    zero
        Direction in the rotor, rad, from which ball angles are counted, such as that of the light side.

    Returns
    -------
    matplotlib.figure.Figure
        Upward triangles upwards, downward ones downwards; dashed what was measured without balls. Neighbors
        between which the amplitude jumps, or the balls begin to
        move otherwise, are not joined. On a logarithmic axis values below 1e-5 of the greatest stand on the lower edge. A
        ball that moves is a bar over its range, a stalled one a
        pale line over all angles.

    Raises
    ------
    QuestionError
        If nothing was reached.
    """
    found = asked(found, "stepped_response")
    if not np.isfinite(found[quantity].values).any():
        raise QuestionError("plot.stepped_response: no speed was measured")
    legs = list(_legs(found))
    speeds = speed_axis(speed_unit)
    greatest = float(np.nanmax(found[quantity].values))
    floor = round_down(DEEP * greatest) if log and greatest > 0.0 else -np.inf
    lengths = length_axis(deflection_unit or ("um" if log else None), greatest)
    balls = found.sizes.get("ball", 0)
    with look():
        figure = picture(8.0, 5.6 if balls else 3.4)
        heights = [1.4, 1.0][: 1 + (balls > 0)]
        panels = figure.subplots(len(heights), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0]
        heading(figure, str(found.attrs["title"]))
        # critical speeds behind all curves
        for critical in np.atleast_1d(found.attrs.get("critical_speeds", [])):
            if found["speed"].values[0] < critical < found["speed"].values[-1]:
                for panel in panels:
                    panel.axvline(critical * speeds.factor, color=CRITICAL, lw=0.9, ls=(0, (1, 2)), zorder=1.0)
        for name, leg in legs:
            if (still := f"{quantity}_without_balls") in leg:
                y = np.maximum(leg[still].values, floor) * lengths.factor
                dashes = (0, (5, 2)) if name != "down" else (0, (1, 1))
                panels[0].plot(leg["speed"].values * speeds.factor, y, color=UNBALANCE, lw=1.1, ls=dashes, zorder=1.4)
            _amplitudes(panels[0], name, leg, quantity, speeds, lengths, floor, hollow=name == "down")
            if balls:
                _angles(panels[-1], leg, speeds, zero, hollow=name == "down")
        panels[0].set_yscale("log" if log else "linear")
        low = bool((found[quantity].values < floor).any())
        if low:
            panels[0].set_ylim(bottom=floor * lengths.factor)
        if log:
            plain_log_ticks(panels[0], "y")
        panels[0].set_ylabel(f"{'mean deflection' if quantity != 'amplitude' else 'amplitude'} ({lengths.sign})")
        handles = _handles(found, [name for name, _ in legs], balls)
        if low:
            marker = MARKERS[legs[0][0]]
            text = f"on the lower edge: below {length_text(floor)}"
            handles.append(Line2D([], [], ls="", marker=marker, mec="#404040", mfc="none", alpha=0.5, label=text))
        _above(panels[0], handles)
        if balls:
            panels[-1].set_ylabel(
                "ball angle in the rotor (°)" if zero == 0.0 else "ball angle from the zero given (°)"
            )
            panels[-1].set_ylim(-180.0, 180.0)
            panels[-1].yaxis.set_major_locator(MultipleLocator(90.0))
            handles = [
                Line2D([], [], color=ball.color, marker="o", ls="", ms=4, label=ball.label)
                for ball in ball_looks(found)
                if ball.label != "_"
            ]
            for name, width, pale in (("range of a ball that moves", 1.6, 0.55), ("ball goes round", 0.8, 0.35)):
                handles.append(
                    Line2D([], [], color="#606060", marker="|", ms=8, mew=width, ls="", alpha=pale, label=name)
                )
            _above(panels[-1], handles)
        panels[-1].set_xlabel(f"rotor speed ({speeds.sign})")
        figure.align_ylabels(panels)
    return figure


def _above(panel: Axes, handles: list[Line2D]) -> None:
    """A legend above a panel, in as few rows as fit."""
    labels, columns = [str(handle.get_label()) for handle in handles], len(handles)
    while columns > 1 and legend_width(labels, columns) > WIDE:
        columns -= 1
    panel.legend(handles=handles, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=columns, borderaxespad=0.1)


def _legs(dataset: xr.Dataset) -> list[tuple[str, xr.Dataset]]:
    if dataset.attrs.get("start") == "fixed":
        return [("fixed", dataset)]
    if "direction" in dataset.dims:
        return [(str(name), dataset.sel(direction=name)) for name in dataset["direction"].values]
    return [(str(dataset["direction"].values), dataset)]


def _amplitudes(
    panel: Axes,
    name: str,
    leg: xr.Dataset,
    quantity: str,
    speeds: AxisUnit,
    lengths: AxisUnit,
    floor: float,
    *,
    hollow: bool,
) -> None:
    """Marks, joined where they belong together; values below ``floor`` (m) stand on it."""
    x, y = leg["speed"].values * speeds.factor, np.maximum(leg[quantity].values, floor) * lengths.factor
    joined = np.where(_jumps(y, leg["motion"].values if "motion" in leg else np.zeros(y.size)), np.nan, y[:-1])
    for i in np.flatnonzero(np.isfinite(joined)):
        panel.plot(x[i : i + 2], y[i : i + 2], color="#B0B0B0", lw=0.7, zorder=1.5)
    for number, motion in enumerate(COLORS) if "motion" in leg else [(0, "")]:
        here = leg["motion"].values == number if motion else np.isfinite(y)
        color = COLORS.get(motion, ALL_BALLS)
        face = "white" if hollow else color
        marks = panel.plot(
            x[here],
            y[here],
            ls="",
            marker=MARKERS[name],
            ms=4.2,
            mec=color,
            mfc=face,
            mew=0.9,
            zorder=2.0,
            clip_on=False,
        )
        marks[0].set_in_layout(False)  # before the panels have their size they would seem to reach far out of them


def _jumps(y: np.ndarray, motion: np.ndarray) -> np.ndarray:
    """Between which neighbors the amplitude jumps, or the balls do something else."""
    size = np.log(np.maximum(np.abs(y), 1e-300))
    return np.asarray((np.abs(np.diff(size)) > np.log(JUMP)) | (np.diff(motion) != 0))


def _angles(panel: Axes, leg: xr.Dataset, speeds: AxisUnit, zero: float, *, hollow: bool) -> None:
    x, looks = leg["speed"].values * speeds.factor, ball_looks(leg)
    for ball in range(leg.sizes["ball"]):
        low = leg["least_ball_angle_in_rotor"].values[:, ball] - zero
        high = leg["greatest_ball_angle_in_rotor"].values[:, ball] - zero
        stalled = leg["ball_motion"].values[:, ball] == 2
        color = looks[ball].color
        panel.vlines(x[stalled], -180.0, 180.0, color=color, lw=0.8, alpha=0.25, zorder=1.2)
        moving = ~stalled & np.isfinite(low)
        middle = wrapped(0.5 * (low + high))
        for place in np.flatnonzero(moving):
            # a range across ±180° is drawn at both ends of the axis
            half = 0.5 * min(high[place] - low[place], 2.0 * math.pi)
            for turn in (-2.0 * math.pi, 0.0, 2.0 * math.pi):
                ends = np.degrees(
                    np.clip([middle[place] - half + turn, middle[place] + half + turn], -math.pi, math.pi)
                )
                if ends[1] > ends[0]:
                    panel.plot([x[place]] * 2, ends, color=color, lw=1.6, alpha=0.55, zorder=1.8)
        face = "white" if hollow else color
        size = 4.6 if ball == 0 else 2.8  # coincident balls stay visible
        look_of: dict[str, Any] = {
            "ls": "",
            "marker": "o",
            "ms": size,
            "mec": color,
            "mfc": face,
            "mew": 0.8,
            "zorder": 2.0,
        }
        panel.plot(x[moving], np.degrees(middle[moving]), **look_of)


def _handles(dataset: xr.Dataset, names: list[str], balls: int) -> list[Line2D]:
    handles = [
        Line2D([], [], ls="", marker=MARKERS[name], mec="#404040", mfc="white" if name == "down" else "#404040", label=WAYS[name])
        for name in names
    ]  # fmt: skip
    handles.append(Line2D([], [], color="#B0B0B0", lw=1.0, label="joined: no jump, same motion"))
    critical = np.atleast_1d(dataset.attrs.get("critical_speeds", []))
    if ((dataset["speed"].values[0] < critical) & (critical < dataset["speed"].values[-1])).any():
        handles.append(
            Line2D(
                [], [], color=CRITICAL, lw=0.9, ls=(0, (1, 2)), label=f"critical speed{critical_speeds_of(dataset).of}"
            )
        )
    if "amplitude_without_balls" in dataset:
        handles.append(Line2D([], [], color=UNBALANCE, lw=1.1, ls=(0, (5, 2)), label="without balls"))
    if balls:
        there = set(np.unique(dataset["motion"].values))
        handles += [
            Line2D([], [], ls="", marker="s", color=color, label=f"balls {motion}")
            for number, (motion, color) in enumerate(COLORS.items())
            if number in there
        ]
    return handles
