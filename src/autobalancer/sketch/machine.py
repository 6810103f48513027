"""The drawing of a machine: the public function."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure, SubFigure

from autobalancer.assembly.profile import unbalance_factor
from autobalancer.catalog.resolve import Ball, resolve
from autobalancer.files.given import any_machine
from autobalancer.machine import Machine, PlanarRotor
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.plots.drawing.style import UNBALANCE, ball_color, heading, look, picture
from autobalancer.plots.run.race_panel import WIDTH, RacePanel
from autobalancer.plots.run.race_vectors import Vector
from autobalancer.results.display_units import moment_text
from autobalancer.sketch.front import drawn_at_random, races_at_start
from autobalancer.sketch.layout import chamber_layout, layout_of
from autobalancer.sketch.side import side_view

COLUMNS = 3  # balancers side by side
SIDE = 3.9  # inches of the view from the side
LEAST = 7.0  # of the whole width


def machine(machine: Machine | ChamberMachine | str | Path, *, title: str | None = None) -> Figure:
    """Draw a machine: bodies, supports, stations and races along its axis, and each balancer from above.

    All lengths are to scale, in mm. A shaft has its own outline; a rigid rotor, a disk and a body of a rig are drawn dashed as
    the solid cylinder of their mass and inertias, and a planar rotor, which has no length, as a disc. Below the axis are the
    springs of the supports. From above, each ball is at its start angle; balls without one lie side by side. Arrows are the
    unbalances at time zero, to a scale of their own.

    Parameters
    ----------
    machine
        A machine with balls in races or deep chambers, or without balls; or the path of its file.
    title
        Above the picture; by default the name of the machine.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    MachineError
        If the file cannot be read, or its parts do not fit.
    """
    given = any_machine(machine)
    if isinstance(given, ChamberMachine):
        with look():
            figure = picture(LEAST, SIDE)
            heading(figure, given.name if title is None else title)
            side_view(figure.subplots(), chamber_layout(given), ())
        return figure
    balls = resolve(given)
    layout = layout_of(given, balls)
    count = len(given.balancers)
    columns = min(count, COLUMNS)
    rows = -(-count // max(columns, 1))
    with look():
        figure = picture(max(WIDTH * columns, LEAST), SIDE)
        heading(figure, given.name if title is None else title)
        if not count:
            side_view(figure.subplots(), layout, balls)
            return figure
        side, fronts = figure.subfigures(2, 1, squeeze=False, height_ratios=[SIDE, 6.0 * rows]).ravel()
        side_view(side.subplots(), layout, balls)
        height = _fronts(fronts, given, balls, rows, columns)
        figure.set_size_inches(figure.get_figwidth(), SIDE + height * rows + 0.35)
    return figure


def _fronts(figure: SubFigure, given: Machine, balls: tuple[Ball, ...], rows: int, columns: int) -> float:
    """Each balancer from above; returns the height of one in inches."""
    races, moments = races_at_start(given, balls)
    colors = [ball_color(k) for k in range(len(balls))]
    vectors = _unbalances(given)
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    drawn = []
    for number, axes in enumerate(panels):
        mine = np.flatnonzero(races.balancer == number + 1)
        if not mine.size:
            axes.set_axis_off()
            continue
        drawn.append(RacePanel(axes, races, moments, mine, colors, {}))
        drawn[-1].arrows(vectors, max((abs(one.value) for one in vectors), default=1.0))
        at_random = drawn_at_random(tuple(balls[k] for k in mine))
        drawn[-1].notes(["a run begins with balls at random places" if at_random else ""])
        if len(given.balancers) > 1:
            drawn[-1].title(given.balancers[number].name or f"balancer {number + 1}")
    lines = max(panel.lines for panel in drawn)
    return max(panel.room(lines) for panel in drawn)


def _unbalances(given: Machine) -> list[Vector]:
    """The point unbalances at time zero, each with its place."""
    found = []
    for one in given.unbalances:
        if one.is_couple:
            continue
        value = one.vector * unbalance_factor(one, 0.0)
        where = "" if isinstance(given.rotor, PlanarRotor) or one.station is None else f" at {_named(one.station)}"
        found.append(Vector(value, f"unbalance{where} {moment_text(abs(value))}", UNBALANCE))
    return found


def _named(station: float | str) -> str:
    return station if isinstance(station, str) else f"{1e3 * float(station):.4g} mm"
