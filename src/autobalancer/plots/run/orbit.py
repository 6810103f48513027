"""The orbits of the rotor center, or of several places on its axis."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from autobalancer.errors import QuestionError
from autobalancer.plots.drawing.style import INK, UNBALANCE, heading, look, picture
from autobalancer.plots.run.history import places, static_part
from autobalancer.results.display_units import AxisUnit, length_axis, length_text, significant, speed_axis, times_larger
from autobalancer.results.drawn import Complexes, Floats, cubic
from autobalancer.results.run_argument import Given, given_race_run
from autobalancer.units import optional_argument

POINTS_A_TURN = 8  # fewer do not draw an orbit, only points of it
NOTHING = 1e-11  # m; a vibration below it is none
COLUMNS = 3
QUIET = 0.1  # of the greatest orbit; a smaller one has its own scale


def orbit(
    run: Given,
    *,
    start: float | str | None = None,
    end: float | str | None = None,
    frame: Literal["space", "rotor"] = "space",
    place: str | None = None,
    deflection_unit: str | None = None,
    speed_unit: str = "rpm",
) -> Figure:
    """Draw the path of the rotor center about its static position, with start and direction.

    On a rotor that tilts or bends each plane of balancers and each station has its panel, all to one scale: a conical
    motion shows as starts on opposite sides. A place that moves less than a tenth as much as another is drawn larger, and
    says so. Where gravity gives the rotor a static deflection, the picture is centered on that position and states it. A
    vibration below 0.01 nm, or below what the tolerance of the run resolves, is a dot.

    Without ``start`` and ``end`` these are the last revolutions, if the run kept them (``LastRevolutions``), else the
    last twentieth of the samples. Fewer than eight samples per revolution are stroboscopic: in space they are
    drawn as points, because a line through them would not be the orbit; in the frame of the rotor, where the unbalance
    does not move, they are joined by a line.

    Parameters
    ----------
    run
        From :func:`simulate` or :func:`load_run`.
    start, end
        Interval in s.
    frame
        ``"space"``: axes that stand still; ``"rotor"``: axes that turn with the rotor.
    place
        Name of a balancer or station; by default all of them.
    deflection_unit
        ``"m"``, ``"mm"``, ``"um"`` or ``"nm"``; by default the one that suits the greatest vibration.
    speed_unit
        Unit of the speed in the title: ``"rpm"``, ``"rad/s"`` or ``"Hz"``.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    QuestionError
        If the run has neither samples nor last revolutions in the interval, has no such place, or a unit or frame is
        unknown.
    """
    run = given_race_run(run, "plot.orbit")
    start = optional_argument("start", start, "s")
    end = optional_argument("end", end, "s")
    if frame not in ("space", "rotor"):
        raise QuestionError(f"frame: given {frame!r}; must be 'space' or 'rotor'")
    speeds = speed_axis(speed_unit)
    paths = orbit_paths(run, start, end)
    if place is not None:
        known = [path.name for path in paths]
        paths = [path for path in paths if path.name == place]
        if not paths:
            raise QuestionError(f"place: given {place!r}; the run has {', '.join(map(repr, known))}")
    greatest = max(float(np.abs(path.deflection).max()) for path in paths)
    least = max(NOTHING, _resolved(run))
    with look():
        columns = min(len(paths), COLUMNS)
        rows = -(-len(paths) // columns)
        figure = picture(4.9 * columns + 0.5, 5.2 * rows + 0.9)
        figure.set_layout_engine("constrained", w_pad=0.12, h_pad=0.06)
        panels = figure.subplots(rows, columns, squeeze=False).ravel()
        for panel in panels[len(paths) :]:
            panel.set_axis_off()
        for panel, path in zip(panels, paths, strict=False):
            own = float(np.abs(path.deflection).max())
            larger = times_larger(own, greatest, QUIET) if own >= least else 1.0
            unit = length_axis(deflection_unit, greatest / larger)
            span = 1.15 * greatest / larger * unit.factor if greatest >= least else 1.0
            _draw(panel, path, unit, span, in_space=frame == "space", noise=own < least)
            if len(paths) > 1 or place is not None:
                panel.set_title(path.name if larger == 1.0 else f"{path.name}, drawn {larger:g} times larger")
        handles = {
            label: handle for panel in panels for handle, label in zip(*panel.get_legend_handles_labels(), strict=True)
        }
        figure.legend(handles=list(handles.values()), loc="outside lower center", ncols=4)
        heading(figure, _title(run, paths[0], speeds))
    return figure


def _draw(axes: Axes, path: OrbitPath, unit: AxisUnit, span: float, *, in_space: bool, noise: bool) -> None:
    turned = path.rotor_angle if in_space else np.zeros_like(path.rotor_angle)
    place = path.deflection * np.exp(1j * turned) * unit.factor
    rate = 2.0 * np.pi / max(float(np.abs(np.diff(path.rotor_angle)).max()), 1e-12)
    axes.set_aspect("equal")
    if noise:
        axes.plot(0.0, 0.0, "o", ms=5, color=INK, label="rotor center")
        size = length_text(float(np.abs(path.deflection).max()))
        axes.annotate(f"{size}: no vibration" if size.startswith("<") else f"{size}: below the tolerance of the run",
                      (0.0, 0.0), xytext=(0.0, 9.0), textcoords="offset points", ha="center", fontsize=8.5)  # fmt: skip
    else:
        if rate < POINTS_A_TURN:
            axes.plot(place.real, place.imag, ".", ms=3, color=INK, label=f"samples, {rate:.2g} a revolution")
        if rate >= POINTS_A_TURN or not in_space:
            line = path.between(in_space=in_space) * unit.factor
            axes.plot(line.real, line.imag, color=INK, lw=0.9, alpha=0.8, label="rotor center")
            _direction(axes, line)
        label = f"at {path.time[0]:.5g} s"
        axes.plot(place[0].real, place[0].imag, "o", ms=6, mfc="white", mec=UNBALANCE, mew=1.8, label=label)
    rest = "static position" if path.static else "not deflected"
    axes.plot(0.0, 0.0, "+", ms=9, mew=1.2, color="#808080", label=rest, zorder=1.5)
    axes.set_xlim(-span, span)
    axes.set_ylim(-span, span)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(6, steps=[1, 2, 2.5, 5, 10]))
    what = "vibration" if path.static else "deflection"
    where = "in space" if in_space else "in the rotor"
    axes.set_xlabel(f"{what} along x {where} ({unit.sign})")
    axes.set_ylabel(f"{what} along y {where} ({unit.sign})")
    if path.static:
        digits = 2 - int(np.floor(np.log10(abs(path.static) * 1e6)))
        rounded = (round(value * 1e6, digits) + 0.0 for value in (path.static.real, path.static.imag))
        x, y = (f"{value:g}".replace("-", "−") for value in rounded)
        axes.text(
            0.02, 0.98, f"static position x = {x} µm, y = {y} µm", transform=axes.transAxes, va="top", fontsize=8.5,
            bbox={"fc": "white", "ec": "none", "alpha": 0.8, "pad": 0.8},
        )  # fmt: skip


def _resolved(run: xr.Dataset) -> float:
    """Vibration (m) below which only the error of the integration is left to be drawn."""
    peaks = [float(np.nanmax(run[name].values)) for name in ("deflection", "envelope_high") if name in run]
    return float(run.attrs.get("tolerance", 0.0)) * max(peaks, default=0.0)


def _direction(axes: Axes, line: Complexes) -> None:
    """An arrow head on the line, a little after the start."""
    length = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(line)))])
    if length[-1] == 0.0:
        return
    reach = min(length[-1], np.pi * float(np.abs(line).max()))
    i = int(np.clip(np.searchsorted(length, 0.25 * reach), 1, line.size - 1))
    axes.annotate(
        "",
        (line[i].real, line[i].imag),
        xytext=(line[i - 1].real, line[i - 1].imag),
        arrowprops={"arrowstyle": "-|>,head_length=0.8,head_width=0.35", "color": INK, "shrinkA": 0, "shrinkB": 0},
    )


def _title(run: xr.Dataset, path: OrbitPath, unit: AxisUnit) -> str:
    name = run.attrs.get("machine_name", run.attrs.get("title", ""))
    speed = path.speed * unit.factor
    low, high = significant(float(speed.min())), significant(float(speed.max()))
    turns = abs(float(path.rotor_angle[-1] - path.rotor_angle[0])) / (2.0 * np.pi)
    rate = f"{high} {unit.sign}" if low == high else f"{low} to {high} {unit.sign}"
    return f"{name}\n{path.time[0]:.5g} s to {path.time[-1]:.5g} s, {turns:.3g} revolutions at {rate}"


# The paths that an orbit is drawn from: last revolutions or samples of each place on the axis.


class OrbitPath(NamedTuple):
    """Moments of one place as they were kept; the deflection is about the static position."""

    name: str
    time: Floats
    speed: Floats  # rad/s
    rotor_angle: Floats  # rad
    deflection: Complexes  # m, in the rotor
    static: complex  # m, in space

    def between(self, *, in_space: bool) -> Complexes:
        """The path with seven points between two samples, a cubic in the rotor."""
        count = self.time.size
        fine = np.interp(np.linspace(0.0, count - 1.0, 8 * (count - 1) + 1), np.arange(count), self.time)
        path = cubic(fine, self.time, self.deflection, np.gradient(self.deflection, self.time))
        if not in_space:
            return path
        angle = cubic(fine, self.time, self.rotor_angle, self.speed)
        return np.asarray(path * np.exp(1j * angle))


def orbit_paths(run: xr.Dataset, start: float | None, end: float | None) -> list[OrbitPath]:
    """The moments to draw of each place: the last revolutions, else samples.

    Raises
    ------
    QuestionError
        If the run has neither in the interval.
    """
    for prefix, dimension in (("turn_", "turn"), ("", "time")):
        needed = [f"{prefix}{name}" for name in ("time", "speed", "x", "y")]
        if not all(name in run for name in needed) or run[needed[0]].size < 2:
            continue
        time = np.asarray(run[needed[0]].values, np.float64)
        first, last = float(time[0]), float(time[-1])
        begin = start if start is not None else first if prefix else last - 0.05 * (last - first)
        final = last if end is None else end
        if prefix and (begin < first - 1e-9 or final > last + 1e-9) and "time" in run:
            continue  # the samples reach farther
        inside = np.flatnonzero((time >= begin - 1e-9) & (time <= final + 1e-9))
        if inside.size < 2:
            raise QuestionError(
                f"from {begin:g} s to {final:g} s: fewer than two samples; the run has {first:g} s to {last:g} s"
            )
        return _paths(run.isel({dimension: inside}), prefix)
    raise QuestionError("the run has no samples; save Samples() or LastRevolutions() with simulate(..., save=...)")


def _paths(part: xr.Dataset, prefix: str) -> list[OrbitPath]:
    time, speed = (np.asarray(part[f"{prefix}{name}"].values, np.float64) for name in ("time", "speed"))
    if f"{prefix}rotor_angle" in part:
        angle = np.asarray(part[f"{prefix}rotor_angle"].values, np.float64)
    else:  # measured: from the speed, counted from the first sample
        angle = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(time))])
    paths = []
    for place in places(part, prefix):
        static = static_part(part, time, angle, place.deflection, float(time[-1]), samples=time.size)
        moved = (place.deflection - static) * np.exp(-1j * angle)
        paths.append(OrbitPath(place.name, time, speed, angle, np.asarray(moved), static))
    return paths
