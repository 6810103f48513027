"""Balls in one race on the rotor's axis, and where they stand: all that stability from a receptance needs of them."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autobalancer.assembly.terms import Theory, unknown
from autobalancer.catalog.resolve import resolve
from autobalancer.errors import QuestionError
from autobalancer.files.given import balls_in_races
from autobalancer.machine import Machine
from autobalancer.results.number_text import moment_text
from autobalancer.stability.states.polygon import directions
from autobalancer.units import argument

Floats = NDArray[np.float64]
LEVELS = 9  # so many ways of standing are gone through for the worst case


@dataclass(frozen=True)
class RaceBalls:
    """Balls in one race, each array of shape (n,), SI."""

    mass: Floats  # effective: what moves with the rotor
    moment: Floats  # effective mass x orbit radius
    inertia: Floats  # of the ball angle
    drag: Floats  # beta, N m s
    ignores: str = ""  # what this theory does not know of their machine

    def __post_init__(self) -> None:
        positive = {"mass": self.mass, "moment": self.moment, "inertia": self.inertia, "drag": self.drag}
        for name, values in positive.items():
            if values.size == 0 or not (np.isfinite(values) & (values > 0.0)).all():
                raise QuestionError(f"balls: {name} = {values.tolist()}; give one ball or more, all values above zero")

    @property
    def count(self) -> int:
        """Number of balls."""
        return int(self.moment.size)

    def with_drag(self, factor: float) -> RaceBalls:
        """The same balls with so many times the drag."""
        return replace(self, drag=factor * self.drag)


def equal_balls(
    count: int, mass: float | str, orbit_radius: float | str, drag: float | str, *, spin_ratio: float
) -> RaceBalls:
    """``count`` equal balls without buoyancy: ``mass`` (kg), ``orbit_radius`` (m), ``drag`` beta of each (N m s).

    ``spin_ratio`` is 2/5 for rolling balls, 0 for points.
    """
    mass = argument("mass", mass, "kg")
    orbit_radius = argument("orbit_radius", orbit_radius, "m")
    drag = argument("drag", drag, "N*m*s")
    ones = np.ones(count)
    inertia = (1.0 + spin_ratio) * mass * orbit_radius**2
    return RaceBalls(mass * ones, mass * orbit_radius * ones, inertia * ones, drag * ones)


def balls_of(machine: Machine | str | Path) -> RaceBalls:
    """The balls of a machine with one race on its axis; the rotor of the machine is ignored.

    Raises
    ------
    QuestionError
        If there are no balls, several races, or the race is off the axis.
    """
    machine = balls_in_races(machine)
    balls = resolve(machine)
    if len({(ball.balancer, ball.race) for ball in balls}) != 1:
        raise QuestionError("stability from a receptance: the machine must have one race with balls")
    if any(ball.eccentricity for ball in balls):
        raise QuestionError("stability from a receptance: the race is off the axis; this method is for one on the axis")
    mass, moment = np.array([b.effective_mass for b in balls]), np.array([b.moment for b in balls])
    inertia, drag = np.array([b.inertia for b in balls]), np.array([b.drag for b in balls])
    return RaceBalls(mass, moment, inertia, drag, ", ".join(unknown(machine, Theory.LOOP)))


def positions(balls: RaceBalls, unbalance: float | None, angles: Floats | None) -> list[Floats]:
    """Ball angles in the balanced state; several, from evenly spread to all in line, if nothing is given.

    Raises
    ------
    QuestionError
        If the balls cannot balance the unbalance, or there are more than two and no angles.
    """
    if angles is not None:
        given = np.asarray(angles, np.float64)
        if given.shape != balls.moment.shape:
            raise QuestionError(f"ball angles: given {given.size} for {balls.count} balls")
        return [given]
    if unbalance is None:
        weight = balls.moment**2
        least = max(0.0, 2.0 * float(weight.max()) - float(weight.sum()))
        doubled = [directions(weight, complex(level)) for level in np.linspace(least, weight.sum(), LEVELS)]
        return [0.5 * found for found in doubled if found is not None]
    if balls.count > 2:
        raise QuestionError(
            f"unbalance: {balls.count} balls can balance it in many ways; give their angles, or nothing: the worst case"
        )
    found = directions(balls.moment, complex(-abs(unbalance)))
    if found is None:
        raise QuestionError(
            f"unbalance: the balls cannot balance {moment_text(abs(unbalance), 4)}; "
            f"they can balance up to {moment_text(balls.moment.sum(), 4)}"
        )
    return [found]


def spread(balls: RaceBalls, angles: Floats) -> float:
    """|sum c e^(2 i phi)| / sum c with c = (m eps)^2: 0 for balls evenly spread over directions, 1 in line."""
    weight = balls.moment**2
    return float(abs((weight * np.exp(2j * angles)).sum()) / weight.sum())


def degrees(angles: Floats) -> list[float]:
    """Angles in degrees within ±180, for messages."""
    return [round(math.degrees(math.remainder(angle, 2.0 * math.pi)), 1) for angle in angles.tolist()]
