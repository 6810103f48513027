"""The twist of a drive train over a run."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from autobalancer.errors import QuestionError
from autobalancer.plots.drawing.labels import label_point
from autobalancer.plots.drawing.style import BALLS, INK, heading, legend, look, picture
from autobalancer.plots.run.history import SAVE_MORE, span_of
from autobalancer.results.display_units import AxisUnit, significant, speed_axis
from autobalancer.results.given import Given, given_race_run
from autobalancer.results.series import crests
from autobalancer.units import optional_argument

STATOR = "stator"  # the name of a mount in every run
CHANGING = 0.02  # of its greatest value by which the speed changes where torque over speed is worth a panel


def drive_train(
    run: Given, *, speed_unit: str = "rpm", start: float | str | None = None, end: float | str | None = None
) -> Figure:
    """Draw how the drive train of a run twists: speeds, torque and twist of every link over time.

    Where the speed changes, the torque is drawn over the speed as well. The greatest torque of each link has its number, as in
    ``ab.measures(run)["peak_torque"]``.

    Parameters
    ----------
    run
        From :func:`simulate` or :func:`load_run`, with samples, of a machine whose drive has couplings or a mount.
    speed_unit
        ``"rpm"``, ``"rad/s"`` or ``"Hz"``.
    start, end
        Part of the run to be drawn, s; by default all of it.

    Raises
    ------
    QuestionError
        If the drive has no link or the run no samples, a unit is unknown, or the interval is outside the run.
    """
    run, unit = given_race_run(run, "plot.drive_train"), speed_axis(speed_unit)
    first, last = span_of(run, optional_argument("start", start, "s"), optional_argument("end", end, "s"))
    if "link_torque" not in run:
        raise QuestionError(
            f"plot.drive_train: this run has no twist; give its drive 'couplings' or a 'mount', and {SAVE_MORE}"
        )
    run = run.sel(time=slice(first - 1e-9, last + 1e-9))
    if run.sizes["time"] < 2:
        raise QuestionError(
            f"plot.drive_train: fewer than two samples from {first:g} s to {last:g} s; ask for a longer part"
        )
    speed = run["speed"].values * unit.factor
    with look():
        changes = float(np.ptp(speed)) > CHANGING * float(np.abs(speed).max())
        figure = picture(8.0, 8.4 if changes else 6.4)
        panels = list(figure.subplots(3 + changes, 1))
        _speeds(panels[0], run, unit)
        _links(panels[1], run["time"].values, run["link_torque"], "torque (N m)", peaks=True)
        _links(panels[2], run["time"].values, run["twist"] * (180.0 / np.pi), "twist (°)")
        for axes in panels[:3]:
            axes.set_xlim(first, last)
            axes.tick_params(labelbottom=axes is panels[2])
        panels[2].set_xlabel("time (s)")
        if changes:
            _links(panels[3], speed, run["link_torque"], "torque (N m)")
            panels[3].set_xlabel(f"rotor speed ({unit.sign})")
        figure.align_ylabels(panels)
        heading(figure, str(run.attrs.get("title", "Run")))
    return figure


def _speeds(axes: Axes, run: xr.Dataset, unit: AxisUnit) -> None:
    axes.plot(run["time"], run["speed"] * unit.factor, color=INK, lw=3.2, alpha=0.35, label="rotor")
    for i, link in enumerate(run["link"].values):
        if link != STATOR:
            axes.plot(
                run["time"], run["link_speed"][:, i] * unit.factor, color=_color(i), lw=0.9, label=str(link), zorder=3.0
            )
    axes.ticklabel_format(axis="y", useOffset=False)
    axes.set_ylabel(f"speed ({unit.sign})")
    legend(axes)


def _links(axes: Axes, along: np.ndarray, values: xr.DataArray, text: str, peaks: bool = False) -> None:
    for i, link in enumerate(values["link"].values):
        its = values.isel(link=i).values
        axes.plot(along, its, color=_color(i), lw=0.8, label=str(link))
        if peaks:
            (at,), (top,) = crests(along, its[:, None])
            axes.plot(at, top, "o", ms=3.5, color=_color(i))
            label_point(axes, f"{significant(top)} N m".replace("-", "\N{MINUS SIGN}"), at, top, color=_color(i))
    axes.set_ylabel(text)
    if peaks:
        legend(axes)


def _color(number: int) -> str:
    return BALLS[number % len(BALLS)]
