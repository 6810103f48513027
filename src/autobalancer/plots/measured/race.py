"""Races and balls from measurements: roundness, and where balls came to rest."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.plots.drawing.style import (
    BALLS,
    CRITICAL,
    FILL,
    INK,
    UNBALANCE,
    ball_color,
    ball_label,
    heading,
    legend,
    look,
    picture,
)
from autobalancer.results.display_units import length_axis, speed_axis
from autobalancer.results.run_argument import Given, refusal, result

BINS = 72


def race_shape(found: Given) -> Figure:
    """Draw a measured race: at the left around the circle, enlarged, at the right its waves with their standard deviations.

    Parameters
    ----------
    found
        From ``ab.measure.race_shape``.

    Raises
    ------
    QuestionError
        If it is something else.
    """
    found = result(found, "plot.race_shape", "measure.race_shape", lambda one: "crest" in one and "profile" in one)
    unit = length_axis(None, float(np.abs(found["profile"]).max()))
    phi, profile = found["angle"].values, unit.factor * found["profile"].values
    fine = np.linspace(0.0, 2.0 * np.pi, 721)
    waves = unit.factor * (
        found["amplitude"].values * np.cos(found["order"].values * (fine[:, None] - found["crest"].values))
    ).sum(axis=1)
    middle = 2.5 * float(np.abs(profile).max())
    with look():
        figure = picture(9.4, 4.6)
        left: Any = figure.add_subplot(1, 2, 1, projection="polar")
        right = figure.add_subplot(1, 2, 2)
        left.plot(fine, np.full(fine.size, middle), "--", color=CRITICAL, lw=1.0, label="circle")
        left.plot(phi, middle + profile, ".", color=INK, ms=3.0, label="measured")
        left.plot(fine, middle + waves, "-", color=BALLS[0], label=f"waves up to {int(found['order'].values[-1])}")
        left.set_rlim(0.0, 1.45 * middle)
        left.set_rticks([middle - middle / 2.5, middle, middle + middle / 2.5])
        edge = middle / 2.5
        left.set_yticklabels([f"{-edge:.3g}", f"0 {unit.sign}", f"+{edge:.3g}"], fontsize=7.5)
        left.legend(loc="upper left", bbox_to_anchor=(-0.16, 1.14))
        order = found["order"].values
        right.bar(order, unit.factor * found["amplitude"].values, color=FILL, ec=INK, lw=0.7)
        right.errorbar(
            order,
            unit.factor * found["amplitude"].values,
            unit.factor * found["amplitude_deviation"].values,
            fmt="none",
            ecolor=INK,
            lw=0.9,
        )
        right.set_xlabel("undulations per revolution")
        right.set_ylabel(f"amplitude ({unit.sign})")
        gone = "" if found.attrs["center"] == "axis" else " of the setup"
        away = float(found.attrs["eccentricity"])
        size = length_axis(None, away)
        heading(
            figure,
            f"Shape of a race, without its circle and an eccentricity{gone} of {size.factor * away:.3g} {size.sign}",
        )
    return figure


def rests(result: Any) -> Figure:
    """Draw where a ball came to rest: a polar histogram around the balanced place, with the interval that friction holds.

    Parameters
    ----------
    result
        From ``ab.measure.rest_friction``.

    Raises
    ------
    QuestionError
        If it is something else.
    """
    if not hasattr(result, "adherence") or not hasattr(result, "angles"):
        raise refusal(result, "plot.rests", "a result of measure.rest_friction")
    angles = np.array(result.angles)
    edges = np.linspace(-np.pi, np.pi, BINS + 1)
    counts, _ = np.histogram(angles, edges)
    with look():
        figure = picture(5.6, 5.2)
        axes: Any = figure.add_subplot(projection="polar")
        axes.set_theta_zero_location("N")
        axes.bar(edges[:-1], counts / angles.size, width=np.diff(edges), align="edge", color=FILL, ec=INK, lw=0.7)
        top = 1.12 * float(counts.max()) / angles.size
        for side in (-0.5, 0.5):
            axes.plot([result.middle + side * result.width] * 2, [0.0, top], "--", color=BALLS[0], lw=1.4)
        axes.plot([np.pi, np.pi], [0.0, 0.6 * top], "-", color=UNBALANCE, lw=2.0)
        axes.text(np.pi, 0.72 * top, "unbalance", color=UNBALANCE, ha="center", va="center")
        axes.set_rlim(0.0, top)
        axes.set_rlabel_position(110)
        axes.yaxis.set_major_locator(MaxNLocator(4))
        axes.yaxis.set_major_formatter(lambda value, _: f"{100.0 * value:.0f} %")
        heading(
            figure,
            f"Rests of a ball in {angles.size} run-ups, 0° opposite the unbalance\n"
            f"held between the dashed lines by an adherence\n"
            f"of {result.adherence:.3g} ({result.low:.3g} to {result.high:.3g} with 95 %)",
        )
    return figure


# Balls of a film: their angles over time, a picture seen from above, and where they come to rest.


Floats = NDArray[np.float64]
SURE = 1.96  # standard deviations of a 95 % band


def ball_film(found: Given, *, speed_unit: str = "rpm") -> Figure:
    """Angles of the balls in the rotor over time with their 95 % bands, impacts and events; below, the speeds.

    Parameters
    ----------
    found
        From ``ab.measure.track_balls``.
    speed_unit
        rpm, rad/s or Hz.

    Raises
    ------
    QuestionError
        If ``found`` is no such result or the unit is not known.
    """
    found = result(found, "plot.ball_film", "measure.track_balls", lambda it: "ball_angle" in it and "seen" in it)
    unit, time = speed_axis(speed_unit), found["time"].values
    angle, deviation = np.degrees(found["ball_angle"].values), np.degrees(found["ball_angle_deviation"].values)
    with look():
        figure = picture(8.4, 5.4)
        upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(2.2, 1.0))
        for i in range(angle.shape[1]):
            color, name = ball_color(i), ball_label(i, angle.shape[1])
            upper.plot(time, angle[:, i], color=color, label=name, marker="." if time.size < 60 else "", ms=4)
            low, high = angle[:, i] - SURE * deviation[:, i], angle[:, i] + SURE * deviation[:, i]
            upper.fill_between(time, low, high, color=color, alpha=0.3, lw=0)
            lower.plot(time, unit.factor * found["ball_speed"].values[:, i], color=color, lw=1.0)
        if found.sizes.get("impact", 0):
            first, at = found["impact_ball"].values - 1, found["impact_time"].values
            second = found["impact_partner"].values - 1
            places = [[_at(t, time, angle[:, i]) for t, i in zip(at, one, strict=True)] for one in (first, second)]
            away = (np.subtract(places[1], places[0]) + 180.0) % 360.0 - 180.0
            upper.plot(at, np.add(places[0], 0.5 * away), "x", color=INK, ms=5, mew=1.0, label="impact")
        faults = [t for t, text in zip(time, found["fault"].values, strict=True) if text]
        if faults:
            bottom = np.full(len(faults), 0.01)
            upper.plot(
                faults,
                bottom,
                "|",
                color=CRITICAL,
                ms=8,
                transform=upper.get_xaxis_transform(),
                label="picture with a fault",
            )
        for at, name in zip(found["event_time"].values, found["event_name"].values, strict=True):
            for axes in (upper, lower):
                axes.axvline(at, color=UNBALANCE, lw=0.8, ls=(0, (2, 2)))
            upper.annotate(
                str(name), (at, 0.98), xycoords=("data", "axes fraction"), rotation=90, va="top", ha="right", fontsize=8
            )
        upper.set_ylabel("ball angle in the rotor (°)")
        lower.set(xlabel="time (s)", ylabel=f"ball speed\nin the rotor ({unit.sign})", xlim=(time[0], time[-1]))
        legend(upper)
        median = float(np.nanmedian(deviation)) if np.isfinite(deviation).any() else float("nan")
        upper.annotate(
            f"95 % bands: ± {SURE * median:.2g}° (median)",
            (0.01, 0.02 + 0.03 * bool(faults)),
            xycoords="axes fraction",
            fontsize=8.5,
        )
        figure.align_ylabels([upper, lower])
    return figure


def _at(moment: float, time: Floats, values: Floats) -> float:
    known = np.isfinite(values)
    return float(np.interp(moment, time[known], values[known]))


def rectified_picture(found: Given) -> Figure:
    """A picture of a film seen from straight above, with orbit and balls as they were found.

    Parameters
    ----------
    found
        From ``ab.measure.rectified_picture``.

    Raises
    ------
    QuestionError
        If ``found`` is no such result.
    """
    requested = "plot.rectified_picture"
    found = result(found, requested, "measure.rectified_picture", lambda it: "brightness" in it and "ball_x" in it)
    x, y = 1e3 * found["x"].values, 1e3 * found["y"].values
    radius = 1e3 * float(found.attrs["orbit_radius"])
    with look():
        figure = picture(5.6, 5.6)
        axes = figure.subplots()
        axes.imshow(
            found["brightness"].values, cmap="gray", vmin=0, vmax=255, extent=(x[0], x[-1], y[0], y[-1]), origin="lower"
        )
        axes.add_patch(Circle((0.0, 0.0), radius, fill=False, color=BALLS[4], lw=0.8, ls=(0, (4, 3))))
        for u, v in zip(1e3 * found["ball_x"].values, 1e3 * found["ball_y"].values, strict=True):
            axes.add_patch(
                Circle((u, v), 500.0 * float(found.attrs["ball_diameter"]), fill=False, color=UNBALANCE, lw=1.2)
            )
            away = 1.0 + 1.1e3 * float(found.attrs["ball_diameter"]) / radius
            axes.annotate(
                f"{np.degrees(np.arctan2(v, u)):.1f}°",
                (away * u, away * v),
                ha="center",
                va="center",
                color="white",
                fontsize=8.5,
            )
        axes.set(xlabel="x (mm)", ylabel="y (mm)", aspect="equal", title=str(found.attrs.get("title", "")))
        axes.grid(visible=False)
    return figure


def rest_histogram(found: Given, *, unbalance: float | None = None) -> Figure:
    """Where balls come to rest, as a polar histogram.

    Parameters
    ----------
    found
        From ``ab.measure.rest_histogram``.
    unbalance
        Direction of the unbalance from the reference, rad, to be marked.

    Raises
    ------
    QuestionError
        If ``found`` is no such result.
    """
    found = result(found, "plot.rest_histogram", "measure.rest_histogram", lambda it: "count" in it and "angle" in it)
    angle, count = found["angle"].values, found["count"].values
    if not count.sum():
        raise QuestionError("plot.rest_histogram: no balls were counted")
    with look():
        figure = picture(5.0, 5.0)
        axes = figure.add_subplot(projection="polar")
        wide = 2.0 * np.pi / angle.size
        axes.bar(
            angle,
            count,
            width=0.94 * wide,
            color=BALLS[0],
            edgecolor="white",
            lw=0.6,
            yerr=found["count_deviation"].values,
            ecolor=INK,
        )
        if unbalance is not None:
            axes.plot([unbalance] * 2, [0.0, 1.05 * count.max()], color=UNBALANCE, lw=1.6, label="unbalance")
            axes.legend(loc="lower left", bbox_to_anchor=(0.9, 0.0))
        axes.set_yticks(range(0, int(count.max()) + 1, max(1, int(count.max()) // 4)))
        axes.set_title(str(found.attrs.get("title", "")))
    return figure
