"""A run of a deep chamber over time: speed, vibration, balls; and where its energy went."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import matplotlib
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from autobalancer.errors import QuestionError, one_of
from autobalancer.plots.run.history import FEW, BallLook, History, ball_looks, critical_speeds_of
from autobalancer.plots.run.run_up import speed_panel
from autobalancer.plots.style import (
    ALL_BALLS,
    BALLS,
    INK,
    UNBALANCE,
    QuantityAxis,
    ball_color,
    heading,
    legend,
    look,
    picture,
    plain_log_ticks,
    quantity_axis,
)
from autobalancer.results.chamber_measures import (
    ball_places_in_rotor,
    bodies_of,
    collision_statistics,
    residual_of_balls,
    unbalance_of,
)
from autobalancer.results.display_units import AxisUnit, length_axis, speed_axis
from autobalancer.results.run_argument import RunArgument, load_chamber_run
from autobalancer.results.unconstrained_body import LooseBody, unconstrained_motion
from autobalancer.units import optional_argument

LEDGER = {
    "loss_contact": ("collisions", BALLS[0]),
    "loss_friction": ("sliding friction", BALLS[1]),
    "loss_rolling": ("rolling resistance", BALLS[2]),
    "loss_supports": ("supports", BALLS[3]),
    "loss_bearings": ("bearings", BALLS[4]),
    "loss_drag": ("fluid", BALLS[5]),
}
STORED = {"energy_kinetic": "motion", "energy_potential": "height and springs", "energy_contact": "contacts"}
POINTS = 4000  # of a curve, more cannot be told apart in print


@contextmanager
def _over_time(
    run: xr.Dataset, size: tuple[float, float], title: str | None, rows: int, columns: int = 1, **shape: Any
) -> Iterator[tuple[Figure, Any]]:
    """A figure with panels over the time of a run, (rows, columns), or (rows,) of one column; ``title`` stands above it."""
    with look():
        figure = picture(*size)
        panels = figure.subplots(rows, columns, sharex=True, **shape)
        yield figure, panels
        for panel in np.atleast_1d(panels[-1]):
            panel.set_xlabel("time (s)")
            panel.set_xlim(run["time"].values[[0, -1]])
        figure.align_ylabels()
        _titled(figure, run, title)


def _titled(figure: Figure, result: xr.Dataset, title: str | None, name: str = "machine_name") -> None:
    heading(figure, title if title is not None else str(result.attrs.get(name, "")))


def chamber_run(
    run: RunArgument, *, speed_unit: str = "rpm", deflection_unit: str | None = None, title: str | None = None
) -> Figure:
    """Rotor speed, displacement of the body, angles of the balls in the rotor, residual unbalance over time of a ``run``.

    ``speed_unit`` is ``"rpm"``, ``"rad/s"`` or ``"Hz"``, ``deflection_unit`` a length such as ``"mm"``, by default one that
    fits; ``title`` stands above the picture.

    Raises
    ------
    QuestionError
        If a unit is unknown.
    """
    run = load_chamber_run(run, "plot.chamber_run")
    unit = speed_axis(speed_unit)
    time = run["time"].values
    with _over_time(run, (7.2, 7.2), title, 4) as (figure, (speed, body, balls, left)):
        rotor = History(
            time, run["speed"].values, np.empty((time.size, 0)), np.empty((time.size, 0)), np.empty((time.size, 0))
        )
        speed_panel(speed, rotor, critical_speeds_of(run), unit, [])
        _body(body, run, deflection_unit)
        _angles(balls, run)
        _left(left, run)
    return figure


def chamber_energy(run: xr.Dataset, *, title: str | None = None) -> Figure:
    """Where the work of the motor went: losses and stored energy stacked over time, and the error of the balance.

    The stack reaches the line of the motor's work where the balance of the ``run`` closes; ``title`` stands above it.
    """
    time = run["time"].values
    with _over_time(run, (7.2, 5.4), title, 2, height_ratios=[3.0, 1.0]) as (figure, (ledger, error)):
        there = [name for name in LEDGER if name in run and np.abs(run[name].values).max(initial=0.0) > 0.0]
        kinds = [(name, *LEDGER[name]) for name in there]
        layers = [run[name].values for name, _, _ in kinds]
        kept = sum(run[name].values - run[name].values[0] for name in STORED)
        ledger.stackplot(
            time, kept, *layers, labels=["motion, height, springs", *[text for _, text, _ in kinds]],
            colors=["#B9C3CC", *[color for _, _, color in kinds]], alpha=0.85, linewidth=0.0,
        )  # fmt: skip
        ledger.plot(time, run["work_motor"].values, color=INK, lw=1.2, label="work of the motor")
        ledger.set_ylabel("energy (J)")
        ledger.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, borderaxespad=0.1)
        error.plot(time, run["energy_error"].values, color=INK)
        error.set_ylabel("error (J)")
    return figure


def chamber_collisions(run: xr.Dataset, *, title: str | None = None) -> Figure:
    """Rates (1/s) of contacts of a ``run`` that begin, the power they dissipate (W), the hardest (N), below a ``title``."""
    from matplotlib.ticker import SymmetricalLogLocator

    statistics = collision_statistics(run)
    with _over_time(run, (7.2, 5.8), title, 3) as (figure, (rates, power, force)):
        time = statistics["part_time"].values
        for panel, name, color, label in (
            (rates, "contacts_ball_rate", BALLS[0], f"between {bodies_of(run)}"),
            (rates, "contacts_wall_rate", BALLS[1], "with the chamber"),
            (power, "impact_power", INK, None),
            (force, "greatest_force", INK, None),
        ):
            panel.step(time, statistics[name].values, where="mid", color=color, label=label)
        rates.set_ylabel("contacts begun (1/s)")
        rates.set_yscale("symlog", linthresh=10.0)
        rates.yaxis.set_major_locator(SymmetricalLogLocator(base=10.0, linthresh=10.0, subs=(1.0, 2.0, 5.0)))
        rates.yaxis.set_major_formatter("{x:g}")
        legend(rates)
        power.set(ylabel="lost in impacts (W)", ylim=(0.0, None))
        force.set_ylabel("hardest contact (N)")
    return figure


def _body(axes: Axes, run: xr.Dataset, wanted: str | None) -> None:
    body = run["body_position"].values - run["body_position"].values.mean(axis=0)
    unit = length_axis(wanted, float(np.abs(body[:, 1:]).max(initial=0.0)))
    for column, name, color in ((1, "horizontal", BALLS[1]), (2, "vertical", BALLS[0])):
        axes.plot(run["time"].values, body[:, column] * unit.factor, color=color, lw=0.7, label=name)
    axes.set_ylabel(f"displacement ({unit.sign})")
    legend(axes)


def _angles(axes: Axes, run: xr.Dataset) -> None:
    """Angles from the unbalance within ±180 degrees, in dots, for balls may slip around."""
    thin = run.isel(time=slice(None, None, max(1, run.sizes["time"] // POINTS)))
    place = ball_places_in_rotor(thin).values
    unbalance = unbalance_of(run)
    heavy = np.angle(unbalance[0]) if unbalance is not None else 0.0
    angle = np.rad2deg(np.angle((place[:, :, 1] + 1j * place[:, :, 2]) * np.exp(-1j * heavy)))
    axes.axhline(0.0, color=UNBALANCE, lw=1.2, ls="--", label="unbalance")
    for side, label in ((180.0, "opposite"), (-180.0, "_")):
        axes.axhline(side, color=UNBALANCE, lw=1.2, ls=":", label=label)
    count, looks = angle.shape[1], ball_looks(run)
    for i in range(count):
        shown = BallLook(ALL_BALLS, f"{count} {bodies_of(run)}" if i == 0 else "_") if count > FEW else looks[i]
        axes.plot(thin["time"].values, angle[:, i], ".", ms=0.9, color=shown.color, alpha=0.6, label=shown.label)
    axes.set(ylim=(-186.0, 186.0), yticks=[-180, -90, 0, 90, 180], ylabel="from unbalance (°)")
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=8, markerscale=8.0, borderaxespad=0.1)


def _left(axes: Axes, run: xr.Dataset) -> None:
    static, couple = unbalance_of(run) or (0.0 + 0.0j, 0.0 + 0.0j)
    residual = residual_of_balls(run, static, couple)
    unit = _moment_axis(float(np.nanmax(residual["static"].values, initial=abs(static))))
    axes.plot(
        residual["time"].values,
        unit.factor * residual["static"].values,
        color=INK,
        lw=0.8,
        label=f"with the {bodies_of(run)}",
    )
    if abs(static) > 0.0:
        axes.axhline(unit.factor * abs(static), color=UNBALANCE, lw=1.0, ls="--", label="of the rotor alone")
    legend(axes)
    axes.set(ylabel=f"unbalance ({unit.sign})", ylim=(0.0, None))


def _moment_axis(greatest: float) -> AxisUnit:
    """The unit of an axis of unbalance up to ``greatest`` (kg m)."""
    return AxisUnit("g mm", 1e6) if greatest < 0.01 else AxisUnit("kg mm", 1e3)


# Reactions that hold a body in planar motion, and what it would do without: Pakuła (2021), figures 13 and 14.


def chamber_reactions(
    run: xr.Dataset, body: LooseBody | None = None, *, until: float | str | None = None, title: str | None = None
) -> Figure:
    """Force along the axis and moments about y and z over time; beside them, with ``body``, the motion of a released body.

    Parameters
    ----------
    run
        From ``simulate`` or an archive.
    body
        The body that is released under these reactions; without it only the reactions are drawn.
    until
        Reactions after this time (s) do not act on the released body.
    title
        Above the picture; by default the name of the machine.
    """
    until = optional_argument("until", until, "s")
    time = run["time"].values
    loads = (
        ("axial force (N)", run["constraint_force"].isel(axis=0).values),
        ("moment about y (N m)", run["constraint_moment"].isel(axis=1).values),
        ("moment about z (N m)", run["constraint_moment"].isel(axis=2).values),
    )
    columns = 1 if body is None else 2
    size = 3.8 + 3.6 * (columns - 1) + 2.6 * (columns == 1), 6.0
    with _over_time(run, size, title, 3, columns, squeeze=False) as (figure, axes):
        for panel, (text, values) in zip(axes[:, 0], loads, strict=True):
            panel.plot(time, values, color=INK, lw=0.6)
            panel.set_ylabel(text)
        if body is not None:
            moved = unconstrained_motion(run, body, until)
            unit = length_axis(None, float(np.abs(moved["x"].values).max(initial=0.0)))
            motions = (
                (f"axial motion x ({unit.sign})", moved["x"].values * unit.factor),
                ("rotation about y (°)", np.rad2deg(moved["rotation_y"].values)),
                ("rotation about z (°)", np.rad2deg(moved["rotation_z"].values)),
            )
            for panel, (text, values) in zip(axes[:, 1], motions, strict=True):
                panel.plot(time, values, color=BALLS[0], lw=0.6)
                panel.set_ylabel(text)
            axes[0, 0].set_title("Reactions")
            axes[0, 1].set_title("Released body")
    return figure


def chamber_bearing_forces(run: xr.Dataset, *, title: str | None = None) -> Figure:
    """Radial forces (N) of the bearings of a ``run`` over time, and the axial one of the bearing that guides.

    ``title`` stands above the picture.
    """
    time = run["time"].values
    force = run["bearing_force"].transpose("time", "bearing", "axis").values
    with _over_time(run, (7.2, 4.4), title, 2) as (figure, (radial, axial)):
        for i in range(force.shape[1]):
            size = np.hypot(force[:, i, 1], force[:, i, 2])
            radial.plot(
                time,
                size,
                color=BALLS[i],
                lw=0.6,
                alpha=0.75,
                label=f"bearing {i + 1}" + ", guides along the axis" * (i == 1),
            )
            axial.plot(time, force[:, i, 0], color=BALLS[i], lw=0.6)
        radial.set_ylabel("radial force (N)")
        axial.set_ylabel("axial force (N)")
        legend(radial)
    return figure


# Pictures of studies of a deep chamber, and of the catalogue of an archive.


COLORS = "viridis"  # of curves in the order of a number
NAMES = {"deep": "deep chamber", "single": "single layer"}


def chamber_amplitudes(study: xr.Dataset, *, measure: str = "vertical_amplitude", title: str | None = None) -> Figure:
    """Amplitude over the number of balls, a curve for each friction, a panel for each chamber (Pakuła 2021, figure 10).

    With several seeds the mean is drawn, with bars from the least to the greatest value. ``title`` stands above the panels.

    Raises
    ------
    QuestionError
        If the study has no such measure.
    """
    one_of("measure", measure, *sorted(map(str, study.data_vars)))
    layers = [str(layer) for layer in study["layers"].values]
    unit = length_axis(None, float(np.nanmax(study[measure].values, initial=0.0)))
    with look():
        figure = picture(3.9 * len(layers), 3.6)
        axes = figure.subplots(1, len(layers), squeeze=False, sharey=True)[0]
        for panel, layer in zip(axes, layers, strict=True):
            for i, friction in enumerate(study["friction"].values):
                values = study[measure].sel(layers=layer, friction=friction) * unit.factor
                _curve(panel, study["balls"], values, ball_color(i), f"friction {friction:g}")
            panel.set_title(NAMES.get(layer, layer), pad=20.0)
            panel.set_xlabel("number of balls")
            panel.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
            panel.set_yscale("log")
            plain_log_ticks(panel, "y")
        axes[0].set_ylabel(f"{measure.replace('_', ' ')} ({unit.sign})")
        legend(axes[-1])
        _titled(figure, study, title)
    return figure


def chamber_carried(study: xr.Dataset, *, title: str | None = None) -> Figure:
    """Share of the balls of a ``study`` that go around with the rotor over friction, a curve for each number of balls.

    A curve rises at the least friction that carries so many balls up from the bottom; the lowest curve that reaches
    the top belongs to the least number of balls. ``title`` stands above the picture.
    """
    layers = [str(layer) for layer in study["layers"].values]
    with look():
        figure = picture(3.9 * len(layers), 3.4)
        axes = figure.subplots(1, len(layers), squeeze=False, sharey=True)[0]
        for panel, layer in zip(axes, layers, strict=True):
            held = study["share_carried"].sel(layers=layer)
            # a number of balls that was asked for at one friction only makes no curve
            requested = held.notnull().any("seed") if "seed" in held.dims else held.notnull()
            several = study["balls"].values[requested.sum("friction").values > 1]
            shown = several if several.size else study["balls"].values
            beside = 0.02 * float(np.ptp(study["friction"].values)) / max(len(shown) - 1, 1)
            for i, balls in enumerate(shown):
                # side by side, for most are at one end or the other
                friction = study["friction"] + (i - 0.5 * (len(shown) - 1)) * beside
                color = matplotlib.colormaps[COLORS](0.9 * i / max(len(shown) - 1, 1))
                _curve(panel, friction.rename("friction"), 100.0 * held.sel(balls=balls), color, f"{balls} balls")
            panel.set(title=NAMES.get(layer, layer), xlabel="friction", ylim=(-4.0, 104.0))
            panel.legend(loc="best")
        axes[0].set_ylabel("balls carried (%)")
        _titled(figure, study, title)
    return figure


def _curve(panel: Axes, x: xr.DataArray, values: xr.DataArray, color: Any, label: str) -> None:
    """Values over ``x``; with a dimension ``seed`` their means and ranges."""
    if "seed" not in values.dims:
        values = values.expand_dims("seed")
    there = values.notnull().any("seed").values
    if not there.any():
        return
    kept = values.isel({str(x.name): there})
    mean = kept.mean("seed", skipna=True).values
    away = np.stack([mean - kept.min("seed", skipna=True).values, kept.max("seed", skipna=True).values - mean])
    bars = {"yerr": np.maximum(away, 0.0), "capsize": 2.0, "elinewidth": 0.8} if values.sizes["seed"] > 1 else {}
    panel.errorbar(x.values[there], mean, fmt="o-", ms=4, color=color, label=label, **bars)


def chamber_optimal_means(means: xr.Dataset, *, measure: str = "vertical_amplitude", title: str = "") -> Figure:
    """Mean amplitudes of both chambers beside each other for each friction (Pakuła 2021, figure 12).

    ``means`` are those of :func:`optimal_means`, ``measure`` is one of their amplitudes, ``title`` stands above the picture.
    Bars show the spread over the seeds, where there are several.
    """
    one_of("measure", measure, *sorted(map(str, means.data_vars)))
    layers = [str(layer) for layer in means["layers"].values]
    unit = length_axis(None, float(np.nanmax(means[measure].values, initial=0.0)))
    place = np.arange(means.sizes["friction"])
    width = 0.8 / len(layers)
    with look():
        figure = picture(5.0, 3.4)
        panel = figure.subplots()
        for i, layer in enumerate(layers):
            values = means[measure].sel(layers=layer).values * unit.factor
            at = place + (i - 0.5 * (len(layers) - 1)) * width
            spread = means.get(f"{measure}_spread")
            error = None if spread is None else spread.sel(layers=layer).values * unit.factor
            bars = panel.bar(at, values, width, color=BALLS[i], label=NAMES.get(layer, layer), yerr=error, capsize=2.0)
            panel.bar_label(bars, fmt="%.3g", fontsize=8)
        panel.set_xticks(place, [f"{value:g}" for value in means["friction"].values])
        panel.set(xlabel="friction", ylabel=f"mean amplitude ({unit.sign})")
        panel.grid(False, axis="x")
        legend(panel)
        heading(figure, title)
    return figure


def chamber_step_size(study: xr.Dataset, *, title: str = "Central elastic collision") -> Figure:
    """Range and root mean square of the energy error over the step; the dashed line grows with the step to the power 2.5.

    Parameters
    ----------
    study
        From :func:`~autobalancer.chamber.step_size`, or the path of its file.
    title
        Above the picture.

    Returns
    -------
    matplotlib.figure.Figure
    """
    steps = study["step"].values
    speeds = study["relative_speed"].values
    beside = (
        np.linspace(-0.5, 0.5, len(speeds)) if len(speeds) > 1 else np.zeros(1)
    )  # errors of all speeds are much alike
    apart = 0.12 * float(np.log10(steps.max() / steps.min())) / max(len(steps) - 1, 1)
    with look():
        figure = picture(6.4, 4.6)
        panel = figure.subplots()
        for i, speed in enumerate(speeds):
            chosen, color = study.sel(relative_speed=speed), ball_color(i)
            shown = steps * 10.0 ** (2.0 * apart * beside[i])
            panel.plot(steps, 100.0 * chosen["typical_root_mean_square"], "--", lw=0.9, color=color)
            low, high = (100.0 * np.abs(chosen[bound].values) for bound in ("least", "greatest"))
            panel.plot(shown, 100.0 * chosen["root_mean_square"], "o", ms=4, color=color, label=f"{speed:g} m/s")
            panel.plot(shown, high, "^", ms=4, mfc="none", color=color)
            panel.plot(shown, low, "v", ms=4, mfc="none", color=color)
        panel.set(
            xscale="log", yscale="log", xlabel="step (s), points of one step side by side", ylabel="energy error (%)"
        )
        panel.plot([], [], "o", color=INK, ms=4, label="root mean square")
        panel.plot([], [], "^", color=INK, mfc="none", ms=4, label="greatest gain")
        panel.plot([], [], "v", color=INK, mfc="none", ms=4, label="greatest loss")
        panel.plot([], [], "--", color=INK, lw=0.9, label="theory, step to the power 2.5")
        panel.legend(loc="upper left")
        heading(figure, title)
    return figure


def chamber_archive(
    table: xr.Dataset, x: str = "balls", y: str = "vertical_amplitude", by: str | None = None, *, log: bool = False
) -> Figure:
    """One value of the runs of an archive over another, in one color for each value of a third.

    Parameters
    ----------
    table
        From ``ab.chamber.Archive(folder).runs()``, or the path of its file.
    x, y, by
        Names of the values along both axes, and of the one that has its own colors.
    log
        Logarithmic scale of ``y``.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    QuestionError
        If the table has no such value, or it is no number.
    """
    for name in (x, y, *([by] if by else [])):
        one_of("catalogue", name, *sorted(map(str, table.data_vars)))
    for name in (x, y):
        if table[name].dtype == object:
            raise QuestionError(f"catalogue: {name!r} is a text; choose a number for an axis")
    with look():
        figure = picture(6.0, 4.0)
        panel = figure.subplots()
        along, up = _axis_of(table[x]), _axis_of(table[y])
        groups = [None] if by is None else sorted(set(table[by].values.tolist()), key=str)
        for i, group in enumerate(groups):
            mine = np.ones(table.sizes["run"], bool) if group is None else table[by].values == group
            order = np.argsort(along.values[mine])
            name = "" if by is None else by.replace("_", " ")
            label = None if group is None else f"{name} {group:g}" if isinstance(group, float) else f"{name} {group}"
            panel.plot(along.values[mine][order], up.values[mine][order], "o-", ms=4, color=ball_color(i), label=label)
        panel.set(xlabel=along.label, ylabel=up.label)
        for axis, shown in ((panel.xaxis, along), (panel.yaxis, up)):
            if np.array_equal(shown.values, np.round(shown.values)) and not log:
                axis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
        if log:
            panel.set_yscale("log")
            plain_log_ticks(panel, "y")
        legend(panel)
        heading(figure, str(table.attrs.get("title", "")))
    return figure


def _axis_of(values: xr.DataArray) -> QuantityAxis:
    """Values and label of an axis; lengths in the unit that suits them."""
    if values.attrs.get("units") != "m":
        shown = quantity_axis(values, "rpm")
    else:
        unit = length_axis(None, float(np.nanmax(np.abs(values.values), initial=0.0)))
        shown = QuantityAxis(values.values * unit.factor, f"{values.name} ({unit.sign})", unit, False)
    return shown._replace(label=shown.label.replace("_", " "))
