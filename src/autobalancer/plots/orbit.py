"""The orbit of the rotor center."""

from __future__ import annotations

from typing import Literal

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from autobalancer.errors import QuestionError
from autobalancer.plots.axis_units import length_axis, significant, speed_axis
from autobalancer.plots.motion import Complexes, Floats, Moments, cubic
from autobalancer.plots.style import INK, UNBALANCE, look, picture

POINTS_A_TURN = 8  # fewer do not draw an orbit, only points of it


def plot_orbit(
    run: xr.Dataset,
    *,
    start: float | None = None,
    end: float | None = None,
    frame: Literal["space", "rotor"] = "space",
    deflection_unit: str | None = None,
    speed_unit: str = "rpm",
) -> Figure:
    """Draw the path of the rotor center, with its start and direction.

    Without ``start`` and ``end`` these are the last revolutions, if the run kept them (``LastRevolutions``), else the
    last twentieth of the samples. Samples with fewer than eight to a revolution are stroboscopic: in space they are
    drawn as points, because a line through them would be no orbit; in the frame of the rotor, where the unbalance
    stands still, they make a line.

    Parameters
    ----------
    run
        From :func:`simulate` or :func:`load_run`.
    start, end
        Interval in s.
    frame
        ``"space"``: axes that stand still; ``"rotor"``: axes that turn with the rotor.
    deflection_unit
        ``"m"``, ``"mm"``, ``"um"`` or ``"nm"``; by default the one that suits the greatest deflection.
    speed_unit
        Unit of the speed in the title: ``"rpm"``, ``"rad/s"`` or ``"Hz"``.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    QuestionError
        If the run has neither samples nor last revolutions in the interval, or a unit or frame is unknown.
    """
    if frame not in ("space", "rotor"):
        raise QuestionError(f"frame: given {frame!r}; must be 'space' or 'rotor'")
    speeds = speed_axis(speed_unit)
    path = _path(run, start, end)
    time, turned = path.time, path.rotor_angle
    z = path.deflection_in_space if frame == "space" else path.deflection_in_rotor
    unit = length_axis(deflection_unit, float(np.abs(z).max()))
    x, y = z.real * unit.factor, z.imag * unit.factor
    rate = 2.0 * np.pi / max(float(np.abs(np.diff(turned)).max()), 1e-12)
    strobe = rate < POINTS_A_TURN
    with look():
        figure = picture(5.4, 5.9)
        axes = figure.subplots()
        axes.set_aspect("equal")
        if strobe:
            axes.plot(x, y, ".", ms=3, color=INK, label=f"samples, {rate:.2g} a revolution")
        if not strobe or frame == "rotor":
            line = _between(path) * unit.factor if frame == "rotor" else x + 1j * y
            axes.plot(line.real, line.imag, color=INK, lw=0.9, alpha=0.8, label="rotor center")
            _direction(axes, line.real, line.imag)
        axes.plot(x[0], y[0], "o", ms=6, mfc="white", mec=UNBALANCE, mew=1.8, label=f"start, {time[0]:.5g} s")
        axes.plot(0.0, 0.0, "+", ms=9, mew=1.2, color="#808080", label="at rest", zorder=1.5)
        span = max(float(np.abs(z).max()) * unit.factor, 1e-300)
        axes.set_xlim(-1.15 * span, 1.15 * span)
        axes.set_ylim(-1.15 * span, 1.15 * span)
        where = "in space" if frame == "space" else "in the rotor"
        axes.set_xlabel(f"deflection along x {where} ({unit.sign})")
        axes.set_ylabel(f"deflection along y {where} ({unit.sign})")
        if _is_noise(run, float(np.abs(z).max())):
            axes.set_title(
                "smaller than the tolerance of the run resolves", fontsize=8.5, weight="normal", color="#606060"
            )
        figure.suptitle(
            _title(run, time, turned, path.speed * speeds.factor, speeds.sign), fontsize=10.5, weight="bold"
        )
        figure.legend(loc="outside lower center", ncols=2 if strobe else 3)
    return figure


def _path(run: xr.Dataset, start: float | None, end: float | None) -> Moments:
    """The moments to draw, as they were kept."""
    names = ("time", "rotor_angle", "speed", "x", "y")
    turns = ("turn_time", "turn_rotor_angle", "turn_speed", "turn_x", "turn_y")
    for kind in (turns, names):
        if not all(name in run for name in kind) or run[kind[0]].size < 2:
            continue
        time, angle, speed, x, y = (np.asarray(run[name].values, np.float64) for name in kind)
        first, last = float(time[0]), float(time[-1])
        begin = start if start is not None else first if kind is turns else last - 0.05 * (last - first)
        final = last if end is None else end
        if kind is turns and (begin < first - 1e-9 or final > last + 1e-9) and "time" in run:
            continue  # the samples reach farther
        inside = (time >= begin - 1e-9) & (time <= final + 1e-9)
        if inside.sum() < 2:
            raise QuestionError(
                f"from {begin:g} s to {final:g} s: fewer than two samples; the run has {first:g} s to {last:g} s"
            )
        in_rotor = (x + 1j * y) * np.exp(-1j * angle)
        return Moments(
            time[inside], speed[inside], angle[inside], in_rotor[inside], np.empty((0, 0)), np.empty(0, np.complex128)
        )
    raise QuestionError("the run has no samples; save Samples() or LastRevolutions() with simulate(..., save=...)")


def _between(path: Moments) -> Complexes:
    """The path in the rotor with seven points between two samples."""
    count = path.time.size
    fine = np.interp(np.linspace(0.0, count - 1.0, 8 * (count - 1) + 1), np.arange(count), path.time)
    slope = np.gradient(path.deflection_in_rotor, path.time)
    return cubic(fine, path.time, path.deflection_in_rotor, slope)


def _is_noise(run: xr.Dataset, greatest: float) -> bool:
    """Whether the balls balance so well that only the error of the integration is left to be drawn."""
    peaks = [float(np.nanmax(run[name].values)) for name in ("deflection", "envelope_high") if name in run]
    return greatest < float(run.attrs.get("tolerance", 0.0)) * max(peaks, default=0.0)


def _direction(axes: Axes, x: Floats, y: Floats) -> None:
    """An arrow head on the line, a little after the start."""
    length = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])
    if length[-1] == 0.0:
        return
    reach = min(length[-1], np.pi * float(np.hypot(x, y).max()))
    i = int(np.clip(np.searchsorted(length, 0.25 * reach), 1, x.size - 1))
    axes.annotate(
        "",
        (x[i], y[i]),
        xytext=(x[i - 1], y[i - 1]),
        arrowprops={"arrowstyle": "-|>,head_length=0.8,head_width=0.35", "color": INK, "shrinkA": 0, "shrinkB": 0},
    )


def _title(run: xr.Dataset, time: Floats, turned: Floats, speed: Floats, sign: str) -> str:
    name = run.attrs.get("machine_name", run.attrs.get("title", ""))
    low, high = significant(float(speed.min())), significant(float(speed.max()))
    turns = abs(float(turned[-1] - turned[0])) / (2.0 * np.pi)
    rate = f"{high} {sign}" if low == high else f"{low} to {high} {sign}"
    return f"{name}\n{time[0]:.5g} s to {time[-1]:.5g} s, {turns:.3g} revolutions at {rate}"
