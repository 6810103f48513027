"""States at the start, and the sizes of motions for tolerances."""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from autobalancer.catalog.resolve import Ball, occupied_angle
from autobalancer.kernels.system import BALLS, SPEED, THETA, VX, VY, Floats, System, X, Y
from autobalancer.machine import Machine


def start_angles(balls: tuple[Ball, ...], random: np.random.Generator, *, given: bool = True) -> list[float]:
    """Given angles, or (always if not ``given``) random ones at which the balls of a race do not overlap."""
    angles: list[float] = []
    places = sorted({(ball.balancer, ball.race) for ball in balls})
    for place in places:
        race = [ball for ball in balls if (ball.balancer, ball.race) == place]
        if given and race[0].start_angle is not None:
            angles += [float(ball.start_angle or 0.0) for ball in race]
            continue
        gaps = random.dirichlet(np.ones(len(race))) * (2.0 * math.pi - occupied_angle(race))
        angle = random.uniform(0.0, 2.0 * math.pi)
        for number, ball in enumerate(race):
            angles.append(angle)
            angle += gaps[number] + 0.5 * occupied_angle([ball, race[(number + 1) % len(race)]])
    return angles


def planar_start(machine: Machine, balls: tuple[Ball, ...], system: System, speed: float, angles: Floats) -> Floats:
    """State of a planar rotor and its balls at time 0."""
    n = len(balls)
    state = np.zeros(BALLS + 2 * n)
    angle = float(machine.start.rotor_angle)
    back = cmath.exp(-1j * angle) if system.rotating else 1.0
    place = complex(*machine.start.deflection) * back
    velocity = complex(*machine.start.velocity) * back
    state[[X, Y, VX, VY, THETA, SPEED]] = place.real, place.imag, velocity.real, velocity.imag, angle, speed
    state[BALLS : BALLS + n] = angles
    state[BALLS + n :] = [ball.start_speed for ball in balls]
    return state


def planar_scales(machine: Machine, balls: tuple[Ball, ...], system: System) -> tuple[Floats, Floats]:
    """Size of each component of such a state, and 1 where the tolerance grows with the component."""
    length, velocity, frequency = planar_sizes(machine, balls, system, [one.size for one in machine.unbalances])
    scale, growing = np.ones(BALLS + 2 * len(balls)), np.zeros(BALLS + 2 * len(balls))
    scale[[X, Y]] = length
    scale[[VX, VY]] = velocity
    scale[SPEED] = frequency
    scale[BALLS + len(balls) :] = frequency
    growing[[X, Y, VX, VY]] = 1.0
    return scale, growing


def planar_sizes(
    machine: Machine, balls: tuple[Ball, ...], system: System, unbalances: Sequence[Any]
) -> tuple[Any, Any, float]:
    """Sizes of motions of a planar rotor with unbalances of these moments, kg m.

    A moment may be an array over many machines that differ in it; the sizes are arrays over them then.

    Returns
    -------
    deflection, velocity, frequency
        m, m/s, rad/s.
    """
    rotor = system.planar
    frequency = math.sqrt(max(rotor.stiffness_x, rotor.stiffness_y) / rotor.mass)
    drives = sum(unbalances) + sum(ball.moment for ball in balls)
    length = drives / rotor.mass + max((abs(ball.eccentricity) for ball in balls), default=0.0)
    length = np.maximum(length, max(abs(complex(*machine.start.deflection)), 1e-9))
    return length, length * frequency, frequency
