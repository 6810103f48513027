"""The chart of a run-up: speeds, deflection and ball angles over one time axis."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from autobalancer.errors import QuestionError
from autobalancer.plots.axis_units import length_axis, speed_axis
from autobalancer.plots.history import (
    SAVE_MORE,
    critical_speeds_of,
    deflections_of,
    history_of,
    passages,
    span_of,
)
from autobalancer.plots.panels import angle_panel, deflection_panel, speed_panel
from autobalancer.plots.style import CRITICAL, look, picture


def plot_run_up(
    run: xr.Dataset,
    *,
    speed_unit: str = "rpm",
    deflection_unit: str | None = None,
    log_deflection: bool = False,
    start: float | None = None,
    end: float | None = None,
) -> Figure:
    """Draw a run over time: who turns how fast, how far the rotor deflects, where the balls are.

    The upper panel has the rotor speed and the absolute speed of each ball, so that balls that hang at the critical
    speed leave the line of the rotor. The middle one shades the deflection between the least and the greatest value of
    each bin of the envelope. The lower one has the ball angles in the rotor from its zero mark, within ±180 degrees,
    with the unbalance and its opposite; where a ball slips round and round its line is pale. Critical speeds are drawn
    if ``run.attrs["critical_speeds"]`` (rad/s) has them.

    Parameters
    ----------
    run
        From :func:`simulate` or :func:`load_run`, with samples, an envelope, or both.
    speed_unit
        ``"rpm"``, ``"rad/s"`` or ``"Hz"``.
    deflection_unit
        ``"m"``, ``"mm"``, ``"um"`` or ``"nm"``; by default the one that suits the greatest deflection.
    log_deflection
        If true, the deflection axis is logarithmic: shows how well the balls balance in the end.
    start, end
        Part of the run to be drawn, s; by default all of it.

    Returns
    -------
    matplotlib.figure.Figure
        Save it with ``savefig`` or look at it in a notebook.

    Raises
    ------
    QuestionError
        If the run has nothing to be drawn, a unit is unknown, or the interval is outside the run.
    """
    speeds = speed_axis(speed_unit)
    first, last = span_of(run, start, end)
    history, deflections = history_of(run, first, last), deflections_of(run, first, last)
    if history is not None and not history.time.size:
        history = None
    if deflections is not None and not deflections.time.size:
        deflections = None
    if history is None and deflections is None:
        raise QuestionError(f"the run has neither speed nor deflection between {first:g} s and {last:g} s; {SAVE_MORE}")
    greatest = float(np.nanmax(deflections.high, initial=0.0)) if deflections is not None else 0.0
    lengths = length_axis(deflection_unit, greatest)
    with_balls = history is not None and history.ball_angle_in_rotor.shape[1] > 0
    heights = [1.0] * (history is not None) + [1.0] * (deflections is not None) + [0.9] * with_balls
    with look():
        figure = picture(8.0, 0.5 + 2.3 * sum(heights))
        panels = list(figure.subplots(len(heights), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0])
        panels[0].set_title(str(run.attrs.get("title", "Run")))
        critical = critical_speeds_of(run)
        if history is not None:
            for level in critical:
                for moment in passages(history.time, history.speed, level):
                    for panel in panels:
                        panel.axvline(moment, color=CRITICAL, lw=0.9, ls=(0, (1, 2)), zorder=1.5)
            speed_panel(panels[0], history, critical, speeds)
        if deflections is not None:
            deflection_panel(panels[1 if history is not None else 0], deflections, lengths, log=log_deflection)
        if with_balls and history is not None:
            angle_panel(panels[-1], history)
        panels[-1].set_xlabel("time (s)")
        panels[-1].set_xlim(first, last)
        figure.align_ylabels(panels)
    return figure
