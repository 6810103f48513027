"""The chart of a run-up: speeds, deflection and ball angles over one time axis."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from autobalancer.errors import QuestionError
from autobalancer.plots.drawing.style import CRITICAL, heading, look, picture
from autobalancer.plots.run.ball_looks import ball_looks, planes_of
from autobalancer.plots.run.history import (
    SAVE_MORE,
    CriticalSpeeds,
    History,
    critical_speeds_of,
    deflections_of,
    history_of,
    passages,
    quiet,
    span_of,
)
from autobalancer.plots.run.panels import angle_panel, deflection_panel, speed_panel
from autobalancer.results.display_units import EACH_ITS_OWN, length_axis, speed_axis
from autobalancer.results.given import Given, given_race_run
from autobalancer.units import optional_argument


def run_up(
    run: Given,
    *,
    speed_unit: str = "rpm",
    deflection_unit: str | None = None,
    log_deflection: bool | None = None,
    start: float | str | None = None,
    end: float | str | None = None,
    held: xr.Dataset | None = None,
) -> Figure:
    """Draw a run over time: speeds of rotor and balls, deflection of the rotor, and ball angles.

    The upper panel has the rotor speed and the absolute speed of each ball, so that balls stalled at the critical
    speed leave the line of the rotor. The middle one shades the deflection between the least and the greatest value of
    each bin of the envelope. On a rotor that tilts or bends it also has the deflection of the other planes of balancers
    and stations, from samples; under gravity the vibration about the static deflection. The lower ones, one for each
    plane, have the ball angles in the rotor from its zero mark, within ±180 degrees, with the unbalance in this plane and
    its opposite; while a ball circles in the rotor its line is pale. Critical speeds are drawn if
    ``run.attrs["critical_speeds"]`` (rad/s) has them, dotted where they are passed; the label says so if they
    are those of small motions, because the stiffness depends on the deflection.

    Parameters
    ----------
    run
        From :func:`simulate` or :func:`load_run`, with samples, an envelope, or both.
    speed_unit
        ``"rpm"``, ``"rad/s"`` or ``"Hz"``.
    deflection_unit
        ``"m"``, ``"mm"``, ``"um"`` or ``"nm"``; by default the one that suits the greatest deflection; on a logarithmic
        axis each tick has its own.
    log_deflection
        Whether the deflection axis is logarithmic, which shows how well the balls balance in the end; by default where
        the end is below 5 % of the greatest deflection.
    start, end
        Part of the run to be drawn, s; by default all of it.
    held
        The same machine without balancing, from ``simulate(machine, hold_balls=True)``, drawn dashed. Without it the
        dashed line is its vibration at the last speed.

    Returns
    -------
    matplotlib.figure.Figure
        Save it with ``savefig`` or show it in a notebook.

    Raises
    ------
    QuestionError
        If the run has nothing to be drawn, a unit is unknown, or the interval is outside the run.
    """
    run = given_race_run(run, "plot.run_up")
    start = optional_argument("start", start, "s")
    end = optional_argument("end", end, "s")
    speeds = speed_axis(speed_unit)
    first, last = span_of(run, start, end)
    history, deflections = history_of(run, first, last), deflections_of(run, first, last, held)
    if history is not None and not history.time.size:
        history = None
    if deflections is not None and not deflections.time.size:
        deflections = None
    if history is None and deflections is None:
        raise QuestionError(f"the run has neither speed nor deflection between {first:g} s and {last:g} s; {SAVE_MORE}")
    greatest = float(np.nanmax(deflections.high, initial=0.0)) if deflections is not None else 0.0
    logarithmic = deflections is not None and (quiet(deflections) if log_deflection is None else log_deflection)
    lengths = EACH_ITS_OWN if logarithmic and not deflection_unit else length_axis(deflection_unit, greatest)
    planes = _planes_with_balls(run) if history is not None and history.ball_angle_in_rotor.shape[1] else []
    heights = [1.0] * (history is not None) + [1.0] * (deflections is not None) + [0.9] * len(planes)
    with look():
        figure = picture(8.0, 0.5 + 2.3 * sum(heights))
        panels = list(figure.subplots(len(heights), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0])
        critical, looks = critical_speeds_of(run), ball_looks(run)
        if history is not None:
            _passages(panels, history, critical)
            speed_panel(panels[0], history, critical, speeds, looks)
        if deflections is not None:
            deflection_panel(panels[1 if history is not None else 0], deflections, lengths, log=logarithmic)
        for panel, (plane, name, balls) in zip(panels[len(panels) - len(planes) :], planes, strict=True):
            assert history is not None
            angle_panel(panel, history, looks, plane=plane, balls=balls, name=name)
        panels[-1].set_xlabel("time (s)")
        panels[-1].set_xlim(first, last)
        figure.align_ylabels(panels)
        heading(figure, str(run.attrs.get("title", "Run")))
    return figure


def _passages(panels: list[Axes], history: History, critical: CriticalSpeeds) -> None:
    """Dotted lines where critical speeds are passed."""
    moments = [moment for level in critical.levels for moment in passages(history.time, history.speed, level)]
    for number, moment in enumerate(moments):
        for panel in panels:
            label = f"critical speed{critical.of} passed" if panel is panels[0] and number == 0 else "_passed"
            panel.axvline(moment, color=CRITICAL, lw=0.9, ls=(0, (1, 2)), zorder=1.5, label=label)


def _planes_with_balls(run: xr.Dataset) -> list[tuple[int, str, list[int]]]:
    """Number, name and balls of each plane; one without a name if all balls are in one."""
    count = run.sizes["ball"]
    where = run["ball_plane"].values - 1 if "ball_plane" in run else np.zeros(count, np.int64)
    names = planes_of(run).names
    if len(names) == 1:
        return [(0, "", list(range(count)))]
    return [
        (plane, name, np.flatnonzero(where == plane).tolist()) for plane, name in enumerate(names) if plane in where
    ]
