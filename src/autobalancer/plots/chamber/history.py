"""A run of a deep chamber over time: speed, vibration, balls; and where its energy went."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from autobalancer.plots.drawing.style import ALL_BALLS, BALLS, INK, UNBALANCE, heading, legend, look, picture
from autobalancer.plots.run.history import FEW, BallLook, History, ball_looks, critical_speeds_of
from autobalancer.plots.run.run_up import speed_panel
from autobalancer.results.chamber_measures import ball_places_in_rotor, collision_statistics, residual_of_balls
from autobalancer.results.chamber_shape import bodies_of, unbalance_of
from autobalancer.results.display_units import length_axis, moment_axis, speed_axis
from autobalancer.results.run_argument import Given, given_chamber_run
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


def chamber_run(
    run: Given, *, speed_unit: str = "rpm", deflection_unit: str | None = None, title: str | None = None
) -> Figure:
    """Rotor speed, displacement of the body, angles of the balls in the rotor, residual unbalance over time of a ``run``.

    ``speed_unit`` is ``"rpm"``, ``"rad/s"`` or ``"Hz"``, ``deflection_unit`` a length such as ``"mm"``, by default one that
    fits; ``title`` stands above the picture.

    Raises
    ------
    QuestionError
        If a unit is unknown.
    """
    run = given_chamber_run(run, "plot.chamber_run")
    unit = speed_axis(speed_unit)
    time = run["time"].values
    with look():
        figure = picture(7.2, 7.2)
        speed, body, balls, left = figure.subplots(4, 1, sharex=True)
        rotor = History(
            time, run["speed"].values, np.empty((time.size, 0)), np.empty((time.size, 0)), np.empty((time.size, 0))
        )
        speed_panel(speed, rotor, critical_speeds_of(run), unit, [])
        _body(body, run, deflection_unit)
        _angles(balls, run)
        _left(left, run)
        left.set_xlabel("time (s)")
        left.set_xlim(time[0], time[-1])
        figure.align_ylabels()
        heading(figure, title if title is not None else str(run.attrs.get("machine_name", "")))
    return figure


def chamber_energy(run: Given, *, title: str | None = None) -> Figure:
    """Where the work of the motor went: losses and stored energy stacked over time, and the error of the balance.

    The stack reaches the line of the motor's work where the balance of the ``run`` closes; ``title`` stands above it.
    """
    run = given_chamber_run(run, "plot.chamber_energy")
    time = run["time"].values
    with look():
        figure = picture(7.2, 5.4)
        ledger, error = figure.subplots(2, 1, sharex=True, height_ratios=[3.0, 1.0])
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
        error.set_xlabel("time (s)")
        error.set_xlim(time[0], time[-1])
        figure.align_ylabels()
        heading(figure, title if title is not None else str(run.attrs.get("machine_name", "")))
    return figure


def chamber_collisions(run: Given, *, title: str | None = None) -> Figure:
    """Rates (1/s) of contacts of a ``run`` that begin, the power they dissipate (W), the hardest (N), below a ``title``."""
    from matplotlib.ticker import SymmetricalLogLocator

    run = given_chamber_run(run, "plot.chamber_collisions")
    statistics = collision_statistics(run)
    with look():
        figure = picture(7.2, 5.8)
        rates, power, force = figure.subplots(3, 1, sharex=True)
        time = statistics["part_time"].values
        rates.step(
            time,
            statistics["contacts_ball_rate"].values,
            where="mid",
            color=BALLS[0],
            label=f"between {bodies_of(run)}",
        )
        rates.step(time, statistics["contacts_wall_rate"].values, where="mid", color=BALLS[1], label="with the chamber")
        rates.set_ylabel("contacts begun (1/s)")
        rates.set_yscale("symlog", linthresh=10.0)
        rates.yaxis.set_major_locator(SymmetricalLogLocator(base=10.0, linthresh=10.0, subs=(1.0, 2.0, 5.0)))
        rates.yaxis.set_major_formatter("{x:g}")
        legend(rates)
        power.step(time, statistics["impact_power"].values, where="mid", color=INK)
        power.set_ylabel("lost in impacts (W)")
        power.set_ylim(bottom=0.0)
        force.step(time, statistics["greatest_force"].values, where="mid", color=INK)
        force.set_ylabel("hardest contact (N)")
        force.set_xlabel("time (s)")
        force.set_xlim(run["time"].values[[0, -1]])
        figure.align_ylabels()
        heading(figure, title if title is not None else str(run.attrs.get("machine_name", "")))
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
    axes.set_ylim(-186.0, 186.0)
    axes.set_yticks([-180, -90, 0, 90, 180])
    axes.set_ylabel("from unbalance (°)")
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=8, markerscale=8.0, borderaxespad=0.1)


def _left(axes: Axes, run: xr.Dataset) -> None:
    static, couple = unbalance_of(run) or (0.0 + 0.0j, 0.0 + 0.0j)
    residual = residual_of_balls(run, static, couple)
    unit = moment_axis(float(np.nanmax(residual["static"].values, initial=abs(static))))
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
    axes.set_ylabel(f"unbalance ({unit.sign})")
    axes.set_ylim(bottom=0.0)


# Reactions that hold a body in planar motion, and what it would do without: Pakuła (2021), figures 13 and 14.


def chamber_reactions(
    run: Given, body: LooseBody | None = None, *, until: float | str | None = None, title: str | None = None
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
    run = given_chamber_run(run, "plot.chamber_reactions")
    until = optional_argument("until", until, "s")
    time = run["time"].values
    loads = (
        ("axial force (N)", run["constraint_force"].isel(axis=0).values),
        ("moment about y (N m)", run["constraint_moment"].isel(axis=1).values),
        ("moment about z (N m)", run["constraint_moment"].isel(axis=2).values),
    )
    with look():
        columns = 1 if body is None else 2
        figure = picture(3.8 + 3.6 * (columns - 1) + 2.6 * (columns == 1), 6.0)
        axes = figure.subplots(3, columns, sharex=True, squeeze=False)
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
        for panel in axes[-1]:
            panel.set_xlabel("time (s)")
            panel.set_xlim(time[0], time[-1])
        figure.align_ylabels()
        heading(figure, title if title is not None else str(run.attrs.get("machine_name", "")))
    return figure


def chamber_bearing_forces(run: Given, *, title: str | None = None) -> Figure:
    """Radial forces (N) of the bearings of a ``run`` over time, and the axial one of the bearing that guides.

    ``title`` stands above the picture.
    """
    run = given_chamber_run(run, "plot.chamber_bearing_forces")
    time = run["time"].values
    force = run["bearing_force"].transpose("time", "bearing", "axis").values
    with look():
        figure = picture(7.2, 4.4)
        radial, axial = figure.subplots(2, 1, sharex=True)
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
        axial.set_xlabel("time (s)")
        axial.set_xlim(time[0], time[-1])
        legend(radial)
        figure.align_ylabels()
        heading(figure, title if title is not None else str(run.attrs.get("machine_name", "")))
    return figure
