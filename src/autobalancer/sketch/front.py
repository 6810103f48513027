"""The races of a machine from above, with their balls where they start."""

from __future__ import annotations

import numpy as np

from autobalancer.catalog.resolve import Ball, occupied_angle
from autobalancer.machine import Machine
from autobalancer.results.drawn.motion import Moments, Races


def races_at_start(machine: Machine, balls: tuple[Ball, ...]) -> tuple[Races, Moments]:
    """Races and balls at rest: each ball at its start angle, those without one side by side from the zero mark."""
    planes = [balancer.station for balancer in machine.balancers]
    plane = [planes.index(planes[ball.balancer]) for ball in balls]
    diameters = np.array([ball.diameter for ball in balls])
    races = Races(
        np.array([ball.orbit_radius for ball in balls]),
        diameters,
        np.array([ball.moment for ball in balls]),
        np.array([ball.eccentricity for ball in balls], np.complex128),
        np.array([ball.balancer + 1 for ball in balls]),
        np.array([ball.race + 1 for ball in balls]),
        np.array(plane),
        np.array([ball.body for ball in balls], dtype=object),
        np.maximum(diameters, [_channel(machine, ball) for ball in balls]),
    )
    none, zero = np.zeros(1), np.zeros(1, np.complex128)
    angles = np.array(_angles(balls))[None]
    still = np.zeros((1, len(planes)), np.complex128)
    moments = Moments(none, none, none, zero, angles, np.zeros((1, len(balls))), zero, still, still, zero)
    return races, moments


def drawn_at_random(balls: tuple[Ball, ...]) -> bool:
    """Whether some balls have no start angle of their own."""
    return any(ball.start_angle is None for ball in balls)


def _angles(balls: tuple[Ball, ...]) -> list[float]:
    angles: list[float] = []
    ends: dict[tuple[int, int], float] = {}
    for ball in balls:
        half = 0.5 * occupied_angle([ball]) or 0.1
        place = (ball.balancer, ball.race)
        begin = ends.get(place, 0.0)
        angles.append(begin + half if ball.start_angle is None else float(ball.start_angle))
        ends[place] = begin + 2.1 * half
    return angles


def _channel(machine: Machine, ball: Ball) -> float:
    """From wall to wall, where resolved balls have room."""
    race = machine.balancers[ball.balancer].races[ball.race]
    return float(race.width or 0.0) if race.resolved is not None else 0.0
