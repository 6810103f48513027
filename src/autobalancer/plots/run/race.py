"""The race seen from above: where the balls are, and what is left of the unbalance."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from autobalancer.errors import QuestionError
from autobalancer.plots.drawing.style import heading, look, picture
from autobalancer.plots.run.ball_looks import balancer_name, ball_looks, planes_of
from autobalancer.plots.run.race_panel import WIDTH, RacePanel, deflected
from autobalancer.plots.run.race_vectors import couple_note, vectors_of
from autobalancer.plots.run.static import static_part
from autobalancer.results.display_units import AxisUnit, length_text, significant, speed_axis, times_larger
from autobalancer.results.drawn.forces import forces_of
from autobalancer.results.drawn.motion import Moments, Motion, Races, races_of
from autobalancer.results.given import Given, given_race_run
from autobalancer.units import optional_argument

COLUMNS = 3  # panels side by side


def race(
    run: Given, *, time: float | str | None = None, balancer: int | None = None, speed_unit: str = "rpm"
) -> Figure:
    """Draw balls, races and the vectors of unbalance at one moment, in the frame of the rotor, a panel for each balancer.

    Balls and races are to scale (mm); a point ball is a small ring, a roller has a chamfer, a pendulum its rod; springs, magnets,
    pins and the like are thin lines. Arrows from the rotor center, to one scale but for a plane where they would be too short to
    read, which says how much longer they are there,
    are the unbalance that the balls of this plane have to balance, what they contribute, and the resultant of both; a
    resultant too small to be drawn is a dot. On a rotor that tilts or bends the unbalance of each plane is its share of
    unbalance and couple together; dashed is what the couple puts there, opposite in the other plane. The triangle outside
    the races points where this plane is deflected to: with the unbalance below a critical speed, opposite to it above.
    If gravity also gives a static deflection, the triangle shows the vibration, and the static deflection is written beside it.
    The eccentricity of a race is drawn larger than it is; the picture gives the factor.

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
        If the run has no balls or no samples, or the time or balancer does not exist.
    """
    run = given_race_run(run, "plot.race")
    time = optional_argument("time", time, "s")
    speeds, motion, races = speed_axis(speed_unit), Motion(run), races_of(run)
    if not races.orbit_radius.size or not (races.orbit_radius > 0.0).all():
        raise QuestionError("the run has no balls in races, so there is nothing to draw; try plot.run_up or plot.orbit")
    present = sorted(set(races.balancer.tolist()))
    if balancer is not None and balancer not in present:
        raise QuestionError(f"balancer: given {balancer}; the run has {', '.join(map(str, present))}")
    moments = motion.at(np.array([motion.time[-1] if time is None else float(time)]))
    chosen = present if balancer is None else [balancer]
    colors = [ball.color for ball in ball_looks(run)]
    planes, forces = planes_of(run), forces_of(run)
    vectors = {number: vectors_of(races, moments, planes, _plane(races, number)) for number in chosen}
    longest = {number: max(abs(vector.value) for vector in each) for number, each in vectors.items()}
    loudest = max(chosen, key=lambda number: longest[number])
    with look():
        columns = min(len(chosen), COLUMNS)
        rows = -(-len(chosen) // columns)
        figure = picture(WIDTH * columns, 6.3 * rows)
        panels = figure.subplots(rows, columns, squeeze=False).ravel()
        for panel in panels[len(chosen) :]:
            panel.set_axis_off()
        drawn = []
        for panel, number in zip(panels, chosen, strict=False):
            mine = np.flatnonzero(races.balancer == number)
            plane = _plane(races, number)
            drawn.append(RacePanel(panel, races, moments, mine, colors, forces))
            longer = times_larger(longest[number], longest[loudest])
            drawn[-1].arrows(vectors[number], longest[loudest] / longer)
            still = _static(run, motion, moments, plane)
            turned = np.exp(-1j * float(moments.rotor_angle[0]))
            vibration = complex(moments.plane_deflection_in_rotor[0, plane]) - still * turned
            drawn[-1].triangle(vibration)
            words = couple_note(moments, planes)
            if words:
                drawn[-1].couple(complex(moments.couple_in_rotor[0]))
            what = "plane" if len(planes.names) > 1 else "rotor"
            scale = f"arrows {longer:g} times as long as for {balancer_name(run, loudest)}" if longer > 1.0 else ""
            drawn[-1].notes([scale, words, deflected(vibration, still, what), *_eccentric(races, moments, mine, plane)])
            if len(present) > 1:
                drawn[-1].title(balancer_name(run, number))
        lines = max(each.lines for each in drawn)
        height = max(each.room(lines) for each in drawn)
        figure.set_size_inches(WIDTH * columns, height * rows + 0.35)
        heading(figure, _title(run, moments, speeds))
    return figure


def _title(run: xr.Dataset, moments: Moments, unit: AxisUnit) -> str:
    name = run.attrs.get("machine_name", run.attrs.get("title", ""))
    speed = significant(float(moments.speed[0]) * unit.factor)
    return f"{name}, at {moments.time[0]:.6g} s, {speed} {unit.sign}"


def _plane(races: Races, balancer: int) -> int:
    """The plane of a balancer, from 0."""
    return int(races.plane[np.flatnonzero(races.balancer == balancer)[0]])


def _static(run: xr.Dataset, motion: Motion, moments: Moments, plane: int) -> complex:
    in_space = motion.plane_deflection_in_rotor[:, plane] * np.exp(1j * motion.rotor_angle)
    return static_part(run, motion.time, motion.rotor_angle, in_space, float(moments.time[0]))


def _eccentric(races: Races, moments: Moments, balls: np.ndarray, plane: int) -> list[str]:
    """Why a resultant is left where balls balance a race that is off center."""
    center = races.center[balls][int(np.argmax(np.abs(races.center[balls])))]
    if not center:
        return []
    off = complex(moments.plane_deflection_in_rotor[0, plane]) + complex(center)
    if abs(off) > 0.05 * abs(center):
        return []
    return [
        f"the balls balance the race, so its center (×) does not move: the rotor stays {length_text(abs(center))} off,",
        "and the resultant is what holds it there",
    ]
