"""The angle at which the ball of a slowly turned machine stands, against the speed: by statics and by simulation."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from autobalancer.assembly.parameters import with_value_at
from autobalancer.catalog.resolve import Ball, resolve
from autobalancer.errors import QuestionError
from autobalancer.files.given import balls_in_races
from autobalancer.laws.drag_coefficient import DragLaw, linear_drag_law
from autobalancer.laws.liquid.sheared_drag import ShearedDragCurve
from autobalancer.machine import Machine
from autobalancer.measurement.angle.statics import Floats, TurnedRace, equilibrium_angles
from autobalancer.results.answers.labeled import Labeled
from autobalancer.results.provenance import provenance
from autobalancer.simulation.run import simulate_races
from autobalancer.simulation.sampling import SampleTimes
from autobalancer.units import argument, texts_argument

STEEPEST = math.radians(85.0)  # end of the speeds that are taken where none are given
COUNT, SLOWEST = 60, 0.02  # how many, and the first as a share of the last
DURATION = 300.0  # s, of the run-up in the source
MEANINGS = {
    "angle": ("angle from the lowest point, statics", "rad"),
    "angle_with_pressure": ("angle from the lowest point, statics with the pressure of the turning fluid", "rad"),
    "simulated_angle": ("angle from the lowest point, simulated", "rad"),
    "reynolds": ("Reynolds number", "1"),
    "drag_coefficient": ("drag coefficient of the law", "1"),
    "speed": ("rotor speed", "rad/s"),
}


@dataclass(frozen=True)
class AngleMachine:
    """What the experiment needs of a machine; ``pressure`` is 1 + c of the force that (6.6) leaves out."""

    machine: Machine
    race: TurnedRace
    law: DragLaw
    rolling: float
    pressure: float
    path: str  # of the balls

    @property
    def pressed(self) -> TurnedRace:
        """The race with the pressure of the turning fluid."""
        return replace(self.race, pressure=self.pressure)


def angle_machine(machine: Machine | str | Path) -> AngleMachine:
    """Ball, race, fluid, drag law and rolling resistance of a machine with one ball on a horizontal axis.

    Raises
    ------
    QuestionError
        If the axis is vertical, there is not exactly one ball, no fluid or no drag, or the race is not round.
    """
    machine = balls_in_races(machine)
    balls = resolve(machine)
    if machine.axis != "horizontal":
        raise QuestionError(
            f"equilibrium angle: the axis is {machine.axis}; the experiment needs a horizontal one: axis = 'horizontal'"
        )
    if len(balls) != 1:
        raise QuestionError(f"equilibrium angle: the machine has {len(balls)} balls; the experiment needs exactly one")
    ball = balls[0]
    race = machine.balancers[ball.balancer].races[ball.race]
    where = f"balancers[{ball.balancer + 1}].races[{ball.race + 1}]"
    if ball.body != "ball":
        raise QuestionError(f"equilibrium angle: {where} has a {ball.body}; the experiment is one with a ball")
    if ball.fluid_viscosity <= 0.0 or ball.diameter <= 0.0:
        raise QuestionError(f"equilibrium angle: {where} needs a fluid, and its ball a size")
    if isinstance(ball.drag_curve, ShearedDragCurve):
        raise QuestionError(
            f"equilibrium angle: {where}.fluid.shear: a drag coefficient over the Reynolds number needs a constant viscosity; "
            "leave 'shear' out"
        )
    if ball.drag <= 0.0:
        raise QuestionError(f"equilibrium angle: {where}.drag: the ball has no drag; give a drag law")
    if ball.eccentricity or race.harmonics or race.roundness is not None:
        raise QuestionError(
            f"equilibrium angle: {where} is not circular and centered on the axis, which the balance of forces requires"
        )
    turned = TurnedRace(
        ball.diameter,
        ball.mass,
        ball.orbit_radius,
        ball.fluid_density,
        ball.fluid_viscosity,
        0.0,
        float(machine.gravity),
    )
    rolling = float(race.friction.rolling_resistance) if race.friction is not None else 0.0
    return AngleMachine(machine, turned, _law(ball), rolling, 1.0 + ball.virtual_mass, f"{where}.balls[1]")


def _law(ball: Ball) -> DragLaw:
    if ball.drag_curve is not None:
        return ball.drag_curve.law
    viscous = math.pi / 8.0 * ball.fluid_density * ball.fluid_viscosity * ball.diameter
    return linear_drag_law(ball.drag / (viscous * ball.orbit_radius**2), "linear range of the drag law of the machine")


def equilibrium_angle(
    machine: Machine | str | Path,
    speeds: ArrayLike | None = None,
    *,
    simulation: bool = False,
    duration: float | str = DURATION,
) -> xr.Dataset:
    """The angle of the ball from the lowest point over the speed, with Reynolds number and drag coefficient.

    Parameters
    ----------
    machine
        With one ball on a horizontal axis; its drive is ignored.
    speeds
        rad/s, ascending from above zero; by default up to the speed at which the ball rests at 85 degrees.
    simulation
        Whether to simulate as well: the rotor is brought from the first to the last speed in ``duration`` (s), so slowly that
        the ball nearly stands at any time, and follows late only where the angle grows steeply near 90 degrees.

    Returns
    -------
    xarray.Dataset
        ``angle`` and ``angle_with_pressure`` by statics, rad, nan where none up to 90 degrees holds the ball;
        ``simulated_angle`` if asked for; ``reynolds`` and ``drag_coefficient`` over ``speed``.

    Raises
    ------
    QuestionError
        If the machine does not fit (:func:`angle_machine`), or the speeds or the duration are not as said.
    """
    speeds = texts_argument("speeds", speeds, "rad/s")
    duration = argument("duration", duration, "s")
    given = angle_machine(machine)
    w = _speeds(given) if speeds is None else np.atleast_1d(np.asarray(speeds, dtype=float))
    if w.size == 0 or not (w[0] > 0.0 and (np.diff(w) > 0.0).all()):
        raise QuestionError("equilibrium angle: speeds must ascend from above zero")
    data = {
        "angle": equilibrium_angles(given.race, given.law, w, given.rolling),
        "angle_with_pressure": equilibrium_angles(given.pressed, given.law, w, given.rolling),
        "reynolds": given.race.reynolds(w),
        "drag_coefficient": given.law.coefficient(given.race.reynolds(w)),
    }
    if simulation:
        data["simulated_angle"] = _simulated(given, w, duration, float(data["angle"][0]))
    found = xr.Dataset({name: ("speed", values) for name, values in data.items()}, {"speed": w})
    for name in found.variables:
        found[name].attrs = dict(zip(("long_name", "units"), MEANINGS[str(name)], strict=True))
    found.attrs = {"title": f"Equilibrium angle: {given.machine.name}", **provenance(), **attributes(given)}
    return Labeled.of(found)


def attributes(given: AngleMachine) -> dict[str, str | float]:
    """What a result says of its machine, SI."""
    return {
        "machine_name": given.machine.name,
        "drag_law": given.law.name,
        "drag_source": given.law.source,
        "rolling_resistance": given.rolling,
        "pressure": given.pressure,
        "fluid_density": given.race.fluid_density,
        "viscosity": given.race.viscosity,
    }


def _speeds(given: AngleMachine) -> Floats:
    grid = np.geomspace(1e-4, 1e4, 8001)
    held = equilibrium_angles(given.race, given.law, grid, given.rolling) < STEEPEST
    if not held[0] or held[-1]:
        raise QuestionError("equilibrium angle: no speed from 1e-4 to 1e4 rad/s holds the ball at 85 deg; give speeds")
    top = float(grid[np.argmin(held)])
    return np.linspace(SLOWEST * top, top, COUNT)


def _simulated(given: AngleMachine, w: Floats, duration: float, first: float) -> Floats:
    if w.size < 2 or not duration > 0.0:
        raise QuestionError("equilibrium angle: a simulation needs two speeds or more, and a duration above zero")
    if not math.isfinite(first):
        raise QuestionError(
            f"equilibrium angle: at {w[0]:.4g} rad/s the ball has no equilibrium; start the simulation at a lower speed"
        )
    machine = given.machine
    for path, value in (
        ("start.speed", 0.0),
        ("drive", {"kind": "speed", "profile": {"kind": "ramp", "start": w[0], "end": w[-1], "duration": duration}}),
        (f"{given.path}.start_angles", [first - 0.5 * math.pi]),
        (f"{given.path}.start_speeds", [-w[0]]),
    ):
        machine = with_value_at(machine, path, value)
    times = (w - w[0]) / (w[-1] - w[0]) * duration
    run = simulate_races(machine, duration=duration, save=SampleTimes(times.tolist()))
    angle = (run["rotor_angle"] + run["ball_angle_in_rotor"][:, 0]).values + 0.5 * math.pi
    return np.where(angle <= 0.5 * math.pi, angle, np.nan)
