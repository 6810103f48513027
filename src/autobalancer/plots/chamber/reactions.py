"""Reactions that hold a body in planar motion, and what it would do without: Pakuła (2021), figures 13 and 14."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from autobalancer.plots.drawing.style import BALLS, INK, heading, legend, look, picture
from autobalancer.results.chamber.unconstrained import LooseBody, unconstrained_motion
from autobalancer.results.display_units import length_axis
from autobalancer.results.given import Given, given_chamber_run
from autobalancer.units import optional_argument


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
