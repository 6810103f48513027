"""Balancing jobs: readings and corrections in polar diagrams, circles of runs without phase, fits of a run-down."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from matplotlib.ticker import MaxNLocator

from autobalancer.arrays import Floats
from autobalancer.errors import QuestionError
from autobalancer.plots.style import (
    BALLS,
    CRITICAL,
    FILL,
    INK,
    UNBALANCE,
    ball_color,
    ball_label,
    heading,
    label_point,
    legend,
    look,
    panels_of_units,
    picture,
    wrapped,
)
from autobalancer.results.answers.forms import channel_unit, shown_unit
from autobalancer.results.display_units import length_axis, speed_axis
from autobalancer.tables import whole_degrees

FEW = 4  # channels that are drawn run by run


def balancing(found: xr.Dataset) -> Figure:
    """Draw a balancing job: at the left readings of all runs and what should remain, at the right trial masses and corrections.

    Thin lines lead from the original reading to those with trial masses; rings are one standard deviation of what remains. With
    more than four readings in a run, or several speeds, a third panel compares before and after.

    Parameters
    ----------
    found
        From ``ab.measure.balance``.
    """
    count = found.sizes["channel"]
    many = count > FEW or np.unique(found["speed"].values[np.isfinite(found["speed"].values)]).size > 1
    with look():
        figure = picture(12.0 if many else 8.4, 4.4)
        panels = figure.subplots(1, 3 if many else 2)
        _readings(panels[0], found)
        _masses(panels[1], found)
        if many:
            _before_and_after(panels[2], found)
        heading(figure, str(found.attrs.get("title", "")))
    return figure


def four_run(found: xr.Dataset, channel: int = 0) -> Figure:
    """Draw the circles of runs without phase: each around the place of its trial mass; they meet where the correction goes.

    Parameters
    ----------
    found
        From ``ab.measure.four_run``.
    channel
        Which sensor and speed, counted from 0.
    """
    one = found.isel(channel=channel)
    sign, factor = shown_unit(str(found["trial_mass"].attrs["units"]))
    places = factor * found["trial_mass"].values * np.exp(1j * found["trial_angle"].values)
    meeting = factor * one["correction"].values * np.exp(1j * one["correction_angle"].values)
    radii = factor * one["amplitude"].values / float(one["sensitivity"].values[0])
    with look():
        figure = picture(6.4, 5.9)
        axes = figure.subplots()
        for n, (place, radius) in enumerate(zip(places, radii, strict=True)):
            color = INK if place == 0 else BALLS[(n - 1) % len(BALLS)]
            axes.add_patch(Circle((place.real, place.imag), radius, fill=False, ec=color, lw=1.3))
            axes.plot(place.real, place.imag, "+", color=color, ms=8.0, mew=1.5, label=str(found["run"].values[n]))
        for n, at in enumerate(meeting[np.isfinite(meeting)]):
            name = "correction" if n == 0 else "does equally well"
            axes.plot([0.0, at.real], [0.0, at.imag], "-", color=UNBALANCE, lw=1.6)
            axes.plot(
                at.real,
                at.imag,
                "o" if n == 0 else "s",
                color=UNBALANCE,
                ms=6.0,
                mfc=UNBALANCE if n == 0 else "white",
                label=name,
            )
            text = f"{abs(at):.3g} {sign}, {whole_degrees(np.angle(at))}°"
            label_point(axes, text, float(at.real), float(at.imag), color=UNBALANCE)
            if "part_of" in found:
                names = list(dict.fromkeys(found["part_of"].values))  # over all channels, and their answers
                before = np.isfinite(found["correction"].values[:channel]).sum()
                _mark_parts(axes, found, names[before + n], color=UNBALANCE)
        edge = 1.06 * max((np.abs(places) + radii).max(), np.nanmax(np.abs(meeting)))
        axes.set_xlim(-edge, edge)
        axes.set_ylim(-edge, edge)
        axes.set_aspect("equal")
        axes.set_xlabel(f"mass towards the zero mark ({sign})")
        axes.set_ylabel(f"mass at 90° from it ({sign})")
        legend(axes)
        heading(
            figure,
            f"Runs without phase, sensor {one['sensor'].item()}\ncircles around the trial masses meet at the correction"
            + "; parts in holes (△), their sum (+)" * ("part_of" in found),
        )
    return figure


def run_down(found: xr.Dataset, *, speed_unit: str = "rpm") -> Figure:
    """Draw amplitude and phase of a run-down with those of the model and its unbalances, and the unbalances themselves.

    Each unit has a panel of amplitudes.

    Parameters
    ----------
    found
        From ``ab.measure.unbalance_from_run_down``.
    speed_unit
        ``"rpm"``, ``"rad/s"`` or ``"Hz"``.

    Raises
    ------
    QuestionError
        If the unit is unknown.
    """
    unit = speed_axis(speed_unit)
    found = found.sortby("speed")
    speed = found["speed"].values * unit.factor
    kinds = {"displacement": ("µm", 1e6), "velocity": ("mm/s", 1e3), "acceleration": ("m/s²", 1.0)}
    shown = [kinds[str(quantity)] for quantity in found["quantity"].values]
    signs = [sign for sign, _ in shown]
    with look():
        figure = picture(11.0, 5.0 + 1.8 * (len(set(signs)) - 1))
        grid = figure.add_gridspec(1, 2, width_ratios=[1.7, 1.0])
        *panels, below = panels_of_units(figure, signs, grid[0, 0])
        right = figure.add_subplot(grid[0, 1])
        for c, (sign, factor) in enumerate(shown):
            one, color = found.isel(channel=c), BALLS[c % len(BALLS)]
            above = panels[list(dict.fromkeys(signs)).index(sign)]
            above.set(ylabel=f"amplitude ({sign})")
            name = f"{one['place'].item()}, {_way(float(one['direction']))}".strip(", ")
            above.plot(speed, factor * one["measured"].values, "o", color=color, ms=3.0, mfc="white", mew=0.8)
            above.plot(speed, factor * one["fitted"].values, "-", color=color, label=name)
            below.plot(speed, np.degrees(one["measured_phase"].values), "o", color=color, ms=2.5, mfc="white", mew=0.7)
            below.plot(*wrapped(speed, np.unwrap(one["fitted_phase"].values)), "-", color=color)
        below.set_ylabel("lead over the mark (°)")
        below.set_yticks(np.arange(-180.0, 181.0, 90.0))
        below.set_xlabel(f"rotor speed ({unit.sign})")
        for above in panels:
            legend(above)
        values = 1e6 * found["unbalance"].values * np.exp(1j * found["unbalance_angle"].values)
        _vectors(
            right,
            values,
            [str(name) for name in found["plane"].values],
            "g mm",
            1e6 * found["unbalance_deviation"].values,
        )
        right.set_xlabel("unbalance towards the zero mark (g mm)")
        right.set_ylabel("unbalance at 90° from it (g mm)")
        heading(figure, f"{found.attrs.get('title', '')}\nmeasured (points) and model with these unbalances")
    return figure


def _readings(axes: Axes, dataset: xr.Dataset) -> None:
    sign, factor = _units(dataset)
    readings = factor * dataset["reading"].values * np.exp(1j * dataset["reading_phase"].values)
    surface = readings[dataset["run"].values == "run-out"].sum(axis=0)
    readings = readings[dataset["states"].values[:, 0] > 0.0] - surface  # not those of earlier jobs
    left = factor * dataset["residual"].values * np.exp(1j * dataset["residual_phase"].values)
    original = factor * dataset["original"].values * np.exp(1j * dataset["original_phase"].values)
    sure = factor * dataset["residual_deviation"].values
    few = dataset.sizes["channel"] <= FEW
    sensors = list(dict.fromkeys(map(str, dataset["sensor"].values)))
    told: set[str] = set()
    for c, name in enumerate(map(str, dataset["sensor"].values)):
        color = BALLS[(c if few else sensors.index(name)) % len(BALLS)]
        if few:
            for reading in readings[:, c]:
                ends = [original[c].real, reading.real], [original[c].imag, reading.imag]
                axes.plot(*ends, "-", color=color, lw=0.8, alpha=0.7)
                axes.plot(reading.real, reading.imag, "o", color=color, ms=4.0, mfc="white", mew=1.0)
        label = name if few or name not in told else "_"
        told.add(name)
        axes.plot([0.0, original[c].real], [0.0, original[c].imag], "-", color=color, lw=1.4, label=label)
        axes.plot(original[c].real, original[c].imag, "o", color=color, ms=5.0)
        axes.plot(left[c].real, left[c].imag, "x", color=color, ms=6.0, mew=1.6)
        if np.isfinite(sure[c]):
            axes.add_patch(Circle((left[c].real, left[c].imag), sure[c], fill=False, ec=color, lw=0.8))
    _square(axes, np.concatenate([readings.ravel() if few else original, left, original]))
    axes.set_xlabel(f"in phase with the mark ({sign})")
    axes.set_ylabel(f"90° {'ahead of' if dataset.attrs['phase'] == 'lead' else 'behind'} it ({sign})")
    legend(axes)
    axes.set_title("readings (o) and what remains (x)", fontsize=9.0, pad=20.0)


def _masses(axes: Axes, dataset: xr.Dataset) -> None:
    sign, factor = shown_unit(str(dataset["correction"].attrs["units"]))
    values = factor * dataset["correction"].values * np.exp(1j * dataset["correction_angle"].values)
    names = [str(name) for name in dataset["plane"].values]
    trial = factor * dataset["run_mass"].values * np.exp(1j * dataset["run_mass_angle"].values)
    for n, name in enumerate(names):
        column = trial[:, [str(one) for one in dataset["all_planes"].values].index(name)]
        for at in np.unique(np.round(column[np.abs(column) > 0.0], 12)):
            axes.plot(at.real, at.imag, "s", color=BALLS[n % len(BALLS)], ms=5.0 + 3.0 * n, mfc="none", mew=1.0)
    _vectors(
        axes,
        values,
        [f"plane {name}" for name in names],
        sign,
        factor * dataset["correction_deviation"].values,
        trial.ravel(),
    )
    for n, name in enumerate(names):
        _mark_parts(axes, dataset, f"correction in plane {name}", color=BALLS[n % len(BALLS)])
    axes.set_xlabel(f"mass towards the zero mark ({sign})")
    axes.set_ylabel(f"mass at 90° from it ({sign})")
    split = "\nparts in holes (△) and their sums (+)" if "part_of" in dataset else ""
    axes.set_title(f"corrections (•) and trial masses (□){split}", fontsize=9.0, pad=20.0)


def _mark_parts(axes: Axes, dataset: xr.Dataset, name: str, *, color: str) -> None:
    """The masses in holes in place of one (triangles), and what they make together (a cross)."""
    if "part_of" in dataset:
        parts = dataset["part_mass"].values * np.exp(1j * dataset["part_angle"].values)
        parts = shown_unit(dataset["part_mass"].attrs["units"])[1] * parts[dataset["part_of"].values == name]
        axes.plot(parts.real, parts.imag, "^", color=color, ms=5.0, mfc="none", mew=1.0)
        axes.plot(parts.sum().real, parts.sum().imag, "+", color=color, ms=10.0, mew=1.6)


def _vectors(axes: Axes, values: Any, names: list[str], sign: str, sure: Any, more: Any = ()) -> None:
    for n, (value, name) in enumerate(zip(values, names, strict=True)):
        color = BALLS[n % len(BALLS)]
        axes.plot([0.0, value.real], [0.0, value.imag], "-", color=color, lw=1.6, label=name)
        axes.plot(value.real, value.imag, "o", color=color, ms=6.0)
        if np.isfinite(sure[n]):
            axes.add_patch(Circle((value.real, value.imag), sure[n], fill=False, ec=color, lw=0.8))
        text = f"{abs(value):.3g} {sign}, {whole_degrees(np.angle(value))}°"
        label_point(axes, text, float(value.real), float(value.imag), color=color)
    _square(axes, np.concatenate([np.asarray(values), np.asarray(more, complex)]))
    legend(axes)


def _square(axes: Axes, values: Any) -> None:
    edge = 1.15 * float(np.abs(values).max())
    axes.axhline(0.0, color=CRITICAL, lw=0.7)
    axes.axvline(0.0, color=CRITICAL, lw=0.7)
    axes.set_xlim(-edge, edge)
    axes.set_ylim(-edge, edge)
    axes.set_aspect("equal")


def _units(dataset: xr.Dataset) -> tuple[str, Any]:
    """The unit of all readings, and the factor of each sensor, (C,); of several units each is shown over its greatest reading."""
    signs, factors = zip(*(channel_unit(dataset.isel(channel=c)) for c in range(dataset.sizes["channel"])), strict=True)
    if len(set(signs)) == 1:
        return signs[0], np.array(factors)
    greatest = {sign: dataset["original"].values[[other == sign for other in signs]].max() for sign in signs}
    return f"of the greatest in {' and in '.join(greatest)}", np.array([1.0 / greatest[sign] for sign in signs])


def _before_and_after(axes: Axes, dataset: xr.Dataset) -> None:
    sign, factor = _units(dataset)
    before, after = factor * dataset["original"].values, factor * dataset["residual"].values
    sure = factor * dataset["residual_deviation"].values
    speeds = dataset["speed"].values * 30.0 / np.pi
    for name in dict.fromkeys(map(str, dataset["sensor"].values)):
        rows = [str(one) == name for one in dataset["sensor"].values]
        color = BALLS[list(dict.fromkeys(map(str, dataset["sensor"].values))).index(name) % len(BALLS)]
        x = speeds[rows] if np.isfinite(speeds).all() else np.flatnonzero(rows) + 1.0
        axes.plot(x, before[rows], "o-", color=color, mfc="white", lw=1.0, label=f"{name}, before")
        axes.errorbar(x, after[rows], np.nan_to_num(sure[rows]), fmt="x--", color=color, lw=1.0, label=f"{name}, after")
    axes.set_ylim(0.0)
    axes.set_xlabel("rotor speed (rpm)" if np.isfinite(speeds).all() else "reading")
    axes.set_ylabel(f"vibration ({sign})")
    legend(axes)


def _way(direction: float) -> str:
    return {0: "x", 90: "y"}.get(round(np.degrees(direction)), f"{np.degrees(direction):.0f}°")


# Races and balls from measurements: roundness, and where balls came to rest.


BINS = 72


def race_shape(found: xr.Dataset) -> Figure:
    """Draw a measured race: at the left around the circle, enlarged, at the right its waves with their standard deviations.

    Parameters
    ----------
    found
        From ``ab.measure.race_shape``.
    """
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
    """
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


SURE = 1.96  # standard deviations of a 95 % band


def ball_film(found: xr.Dataset, *, speed_unit: str = "rpm") -> Figure:
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
        If the unit is not known.
    """
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


def rectified_picture(found: xr.Dataset) -> Figure:
    """A picture of a film seen from straight above, with orbit and balls as they were found.

    Parameters
    ----------
    found
        From ``ab.measure.rectified_picture``.
    """
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


def rest_histogram(found: xr.Dataset, *, unbalance: float | None = None) -> Figure:
    """Where balls come to rest, as a polar histogram.

    Parameters
    ----------
    found
        From ``ab.measure.rest_histogram``.
    unbalance
        Direction of the unbalance from the reference, rad, to be marked.
    """
    angle, count = found["angle"].values, found["count"].values
    if not count.sum():
        raise QuestionError("plot.answer: no balls were counted")
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
