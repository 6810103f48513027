"""Balancing jobs: readings and corrections in polar diagrams, circles of runs without phase, fits of a run-down."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from autobalancer.plots.drawing.axes import panels_of_units, wrapped
from autobalancer.plots.drawing.labels import label_point
from autobalancer.plots.drawing.style import BALLS, CRITICAL, INK, UNBALANCE, heading, legend, look, picture
from autobalancer.results.display_units import speed_axis
from autobalancer.results.run_argument import Given, result
from autobalancer.tables import whole_degrees

UNITS = {"kg": ("g", 1e3), "kg m": ("g mm", 1e6), "m": ("µm", 1e6), "m/s": ("mm/s", 1e3), "m/s^2": ("m/s²", 1.0)}
FEW = 4  # channels that are drawn run by run


def balancing(found: Given) -> Figure:
    """Draw a balancing job: at the left readings of all runs and what should remain, at the right trial masses and corrections.

    Thin lines lead from the original reading to those with trial masses; rings are one standard deviation of what remains. With
    more than four readings in a run, or several speeds, a third panel compares before and after.

    Parameters
    ----------
    found
        From ``ab.measure.balance``.

    Raises
    ------
    QuestionError
        If it is something else.
    """
    found = result(found, "plot.balancing", "measure.balance", lambda one: "influence" in one and "correction" in one)
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


def four_run(found: Given, channel: int = 0) -> Figure:
    """Draw the circles of runs without phase: each around the place of its trial mass; they meet where the correction goes.

    Parameters
    ----------
    found
        From ``ab.measure.four_run``.
    channel
        Which sensor and speed, counted from 0.

    Raises
    ------
    QuestionError
        If it is something else.
    """
    found = result(found, "plot.four_run", "measure.four_run", lambda one: "sensitivity" in one and "trial_mass" in one)
    one = found.isel(channel=channel)
    sign, factor = UNITS[str(found["trial_mass"].attrs["units"])]
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
        edge = 1.06 * max((np.abs(places) + radii).max(), np.nanmax(np.abs(meeting)))
        axes.set_xlim(-edge, edge)
        axes.set_ylim(-edge, edge)
        axes.set_aspect("equal")
        axes.set_xlabel(f"mass towards the zero mark ({sign})")
        axes.set_ylabel(f"mass at 90° from it ({sign})")
        legend(axes)
        heading(
            figure,
            f"Runs without phase, sensor {one['sensor'].item()}\ncircles around the trial masses meet at the correction",
        )
    return figure


def run_down(found: Given, *, speed_unit: str = "rpm") -> Figure:
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
        If it is something else, or the unit is unknown.
    """
    found = result(
        found, "plot.run_down", "measure.unbalance_from_run_down", lambda one: "fitted" in one and "unbalance" in one
    )
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
    sign, factor = UNITS.get(str(dataset["original"].attrs["units"]), (str(dataset["original"].attrs["units"]), 1.0))
    readings = factor * dataset["reading"].values * np.exp(1j * dataset["reading_phase"].values)
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
    sign, factor = UNITS[str(dataset["correction"].attrs["units"])]
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
    axes.set_xlabel(f"mass towards the zero mark ({sign})")
    axes.set_ylabel(f"mass at 90° from it ({sign})")
    axes.set_title("corrections (•) and trial masses (□)", fontsize=9.0, pad=20.0)


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


def _before_and_after(axes: Axes, dataset: xr.Dataset) -> None:
    sign, factor = UNITS.get(str(dataset["original"].attrs["units"]), (str(dataset["original"].attrs["units"]), 1.0))
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
