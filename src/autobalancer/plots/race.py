"""The race seen from above: where the balls are, and what is left of the unbalance."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyArrowPatch
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.plots.axis_units import AxisUnit, length_text, moment_text, round_down, significant, speed_axis
from autobalancer.plots.motion import Floats, Moments, Motion, Races, races_of
from autobalancer.plots.style import ALL_BALLS, INK, RACE, UNBALANCE, ball_color, look, picture


def plot_race(
    run: xr.Dataset, *, time: float | None = None, balancer: int | None = None, speed_unit: str = "rpm"
) -> Figure:
    """Draw balls, races and the vectors of unbalance at one moment, in the frame of the rotor.

    Balls and races are to scale (mm); a point ball is a small ring. Arrows from the rotor center, all to one scale,
    are the unbalance of the rotor, what the balls contribute, and the resultant of both; a resultant too small to be
    drawn is a dot. The triangle outside the races points where the rotor is deflected to: with the unbalance below a
    critical speed, opposite to it above. The eccentricity of a race is drawn larger than it is, as the picture says.

    Parameters
    ----------
    run
        From :func:`simulate` or :func:`load_run`, with samples.
    time
        Moment in s, within the samples; by default their end.
    balancer
        Counted from 1; by default each balancer has its own panel.
    speed_unit
        Unit of the speed in the title: ``"rpm"``, ``"rad/s"`` or ``"Hz"``.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    QuestionError
        If the run has no balls or no samples, or no such time or balancer.
    """
    speeds, motion, races = speed_axis(speed_unit), Motion(run), races_of(run)
    if not races.orbit_radius.size or not (races.orbit_radius > 0.0).all():
        raise QuestionError("the run has no balls in races, so there is nothing to draw; try plot_run_up or plot_orbit")
    present = sorted(set(races.balancer.tolist()))
    if balancer is not None and balancer not in present:
        raise QuestionError(f"balancer: given {balancer}; the run has {', '.join(map(str, present))}")
    moments = motion.at(np.array([motion.time[-1] if time is None else float(time)]))
    chosen = present if balancer is None else [balancer]
    with look():
        figure = picture(5.6 * len(chosen), 6.1)
        panels = figure.subplots(1, len(chosen), squeeze=False)[0]
        for panel, number in zip(panels, chosen, strict=True):
            _draw(panel, races, moments, np.flatnonzero(races.balancer == number))
            if len(present) > 1:
                panel.set_title(f"balancer {number}")
        handles, _ = panels[0].get_legend_handles_labels()
        figure.legend(handles=handles, loc="outside lower center", ncols=3)
        figure.suptitle(_title(run, moments, speeds), fontsize=10.5, fontweight="bold")
    return figure


def _title(run: xr.Dataset, moments: Moments, unit: AxisUnit) -> str:
    name = run.attrs.get("machine_name", run.attrs.get("title", ""))
    speed = significant(float(moments.speed[0]) * unit.factor)
    return f"{name}, {moments.time[0]:.6g} s, {speed} {unit.sign}"


def _draw(axes: Axes, races: Races, moments: Moments, balls: NDArray[np.intp]) -> None:
    """One balancer; lengths in mm."""
    radius, diameter = races.orbit_radius[balls] * 1e3, races.ball_diameter[balls] * 1e3
    outside = float((radius + 0.5 * diameter).max())
    eccentric = float(np.abs(races.center[balls]).max()) * 1e3
    exaggeration = max(1.0, round_down(0.06 * outside / eccentric)) if eccentric else 1.0
    center = races.center[balls] * 1e3 * exaggeration
    reach = outside + float(np.abs(center).max())
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.set_xlim(-1.3 * reach, 1.3 * reach)
    axes.set_ylim(-1.52 * reach, 1.26 * reach)
    _protractor(axes, reach)
    for r, d, c in sorted({*zip(radius, diameter, center, strict=True)}, key=lambda race: -race[0]):
        _race(axes, r, d, c)
    angle = moments.ball_angle_in_rotor[0, balls]
    least = 0.03 * outside
    for i, place in enumerate(center + radius * np.exp(1j * angle)):
        _ball(axes, place, diameter[i], int(balls[i]), least)
    inside = radius - np.maximum(0.5 * diameter, least) - 2.2 * least
    for i, place in enumerate(center + inside * np.exp(1j * _apart(angle, 0.12))):
        axes.text(
            place.real, place.imag, f"{balls[i] + 1}", ha="center", va="center", fontsize=8.5, color=INK, zorder=5
        )
    _vectors(axes, races, moments, 0.72 * float(radius.min()))
    axes.plot(0.0, 0.0, "+", ms=9, mew=1.3, color=INK)
    deflection = complex(moments.deflection_in_rotor[0])
    if abs(deflection) > 1e-11:
        side = deflection / abs(deflection) * 1.06 * reach
        turned = (3, 0, np.rad2deg(np.angle(deflection)) - 90.0)
        axes.plot(side.real, side.imag, marker=turned, ms=10, color=INK, clip_on=False)
    sizes = [f"orbit radius {r:.4g} mm" for r in sorted({*radius})]
    sizes += [f"ball {d:.4g} mm" if d > 0.0 else "point balls" for d in sorted({*diameter})]
    away = f"▲ rotor deflected {length_text(abs(deflection))} this way" if abs(deflection) > 1e-11 else "rotor at rest"
    notes = [", ".join(sizes), away]
    if eccentric:
        direction = np.rad2deg(np.angle(races.center[balls][np.argmax(np.abs(races.center[balls]))]))
        drawn = f", drawn {exaggeration:g} times larger (×)" if exaggeration > 1.0 else " (×)"
        notes.append(f"eccentricity {length_text(eccentric * 1e-3)} at {direction:.0f}°{drawn}")
    axes.text(0.0, -1.52 * reach, "\n".join(notes), ha="center", va="bottom", fontsize=8.5)


def _protractor(axes: Axes, reach: float) -> None:
    """Angles from the zero mark of the rotor."""
    for degrees in range(0, 360, 30):
        ray = np.exp(1j * np.deg2rad(degrees))
        axes.plot(*_line(1.12 * reach * ray), color="#E3E3E3", lw=0.7, zorder=0)
        shown = degrees if degrees <= 180 else degrees - 360
        place = 1.19 * reach * ray
        weight = "bold" if degrees == 0 else "normal"
        axes.text(
            place.real, place.imag, f"{shown}°", ha="center", va="center", fontsize=8.5, weight=weight, color="#606060"
        )


def _race(axes: Axes, radius: float, diameter: float, center: complex) -> None:
    """The walls of a race, or the circle on which point balls move."""
    place = (center.real, center.imag)
    if diameter > 0.0:
        axes.add_patch(Circle(place, radius + 0.5 * diameter, fc=RACE, ec="#8A949C", lw=1.0, zorder=1.0))
        axes.add_patch(Circle(place, radius - 0.5 * diameter, fc="white", ec="#8A949C", lw=1.0, zorder=1.1))
    axes.add_patch(Circle(place, radius, fc="none", ec="#8A949C", lw=0.7, ls=(0, (6, 4)), zorder=1.2))
    if center:
        axes.plot(*place, "x", ms=6, mew=1.2, color="#8A949C")


def _ball(axes: Axes, place: complex, diameter: float, number: int, least: float) -> None:
    """A ball to scale, or a ring for a point."""
    spot, color = (place.real, place.imag), ball_color(number)
    if diameter > 0.0:
        axes.add_patch(Circle(spot, 0.5 * diameter, fc=color, ec=INK, lw=0.8, alpha=0.9, zorder=4))
    else:
        axes.add_patch(Circle(spot, least, fc="white", ec=color, lw=2.2, alpha=0.9, zorder=4))


def _apart(angle: Floats, gap: float) -> Floats:
    """Angles for numbers: those of the balls, pushed apart to ``gap`` (rad) where balls are close."""
    if angle.size * gap >= 2.0 * np.pi:
        return angle
    placed = angle % (2.0 * np.pi)
    for _ in range(50):
        order = np.argsort(placed)
        ring = np.append(placed[order], placed[order[0]] + 2.0 * np.pi)
        lacking = np.maximum(gap - np.diff(ring), 0.0)
        if lacking.max() < 1e-3 or angle.size < 2:
            break
        placed[order] += 0.5 * (np.roll(lacking, 1) - lacking)
    return placed


def _vectors(axes: Axes, races: Races, moments: Moments, length: float) -> None:
    """Unbalance, balls and resultant, the longest of them ``length`` long."""
    unbalance = complex(moments.unbalance_in_rotor[0])
    resultant = complex(races.resultant(moments)[0])
    balls = resultant - unbalance
    scale = length / (max(abs(unbalance), abs(balls), abs(resultant)) or 1.0)
    arrows = (("unbalance", unbalance, UNBALANCE), ("balls", balls, ALL_BALLS), ("resultant", resultant, INK))
    for name, vector, color in arrows:
        tip = vector * scale
        if abs(tip) > 0.05 * length:
            axes.add_patch(
                FancyArrowPatch(
                    (0.0, 0.0),
                    (tip.real, tip.imag),
                    arrowstyle="-|>,head_length=7,head_width=3.2",
                    color=color,
                    lw=2.2,
                    shrinkA=0,
                    shrinkB=0,
                    zorder=3,
                )
            )
        else:
            axes.plot(tip.real, tip.imag, "o", ms=4, color=color, zorder=3.5)
        axes.plot([], [], color=color, lw=2.6, label=f"{name} {moment_text(abs(vector))}")


def _line(tip: complex) -> tuple[list[float], list[float]]:
    return [0.0, tip.real], [0.0, tip.imag]
