"""A sphere between planes, near a plane, behind another, and the lift on it, far from all other walls of a channel."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

from autobalancer.flow.ball_problem import ball_forces
from autobalancer.flow.finite_elements import Fineness, Flow, Shape, flow_with_inertia, slow_flow, spaces
from reproductions import Found, compared_all

FORCE, TORQUE = 6.0 * math.pi, 8.0 * math.pi


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Forces over those of a free sphere."""
    rows = compared_all("Happel and Brenner 1983", "7-4.28", [_between_planes()])
    rows += compared_all("Goldman, Cox and Brenner 1967", "expansions", _near_a_plane())
    rows += compared_all("Stimson and Jeffery 1926", "table", [_behind_another()])
    return rows + compared_all("Cox and Hsu 1977", "lift", [_lift()])


def _flow(shape: Shape, mesh: Fineness, spin: float = 0.0) -> Flow:
    return slow_flow(spaces(shape, mesh), spin)


def _between_planes() -> Found:
    k, mesh = 0.25, Fineness(0.2, 0.3, 3.5, 0.7)
    faxen = 1.0 / (1.0 - 1.004 * k + 0.418 * k**3 + 0.21 * k**4 - 0.169 * k**5)
    lengths = (48.0, 96.0)
    near, far = (ball_forces(_flow(Shape(8.0, n, 3.0, n / 2, n / 2), mesh)).along / FORCE for n in lengths)
    note = "two lengths of the planes, continued to infinite ones by their inverse square"
    quantity = "drag of a sphere midway between planes, radius over distance 0.25"
    return Found("closed form", quantity, "6 pi mu r U", faxen, far + (far - near) / 3.0, 0.01, note)


def _near_a_plane() -> list[Found]:
    gap, mesh = 0.02, Fineness(0.15, 0.35, 6.0, 0.5)
    log = math.log(1.0 / gap)
    shape = Shape(50.0, 50.0, gap, 30.0, 30.0)
    slides, rolls = (ball_forces(_flow(shape, mesh, spin)) for spin in (0.0, -1.0))
    drag = 8.0 / 15.0 * log + 0.9588 + 64.0 / 375.0 * gap * log
    tip = 1.0 / 10.0 * log - 0.1895 + 43.0 / 250.0 * gap * log
    turn = 2.0 / 5.0 * log + 0.3817 + 66.0 / 125.0 * gap * log
    note = "gap of 0.02 radii; with the terms in gap log gap"
    return [
        Found(
            "closed form",
            "drag of a sphere that slides along a plane",
            "6 pi mu r U",
            drag,
            slides.along / FORCE,
            0.03,
            note,
        ),
        Found("closed form", "its torque", "8 pi mu r^2 U", tip, -slides.torque / TORQUE, 0.01, note),
        Found(
            "closed form",
            "torque on a sphere that turns beside a plane",
            "8 pi mu r^2 U",
            turn,
            (rolls.torque - slides.torque) / TORQUE,
            0.02,
            note,
        ),
    ]


def _behind_another() -> Found:
    mesh, walls = Fineness(0.25, 0.3, 10.0, 0.7), 1.9 / 50.0
    shape = Shape(100.0, 100.0, 49.0, 60.0, 60.0)
    alone = ball_forces(_flow(shape, mesh)).along
    ratio = ball_forces(_flow(replace(shape, second=2.0 * 1.5431), mesh)).along / alone
    free = ratio / ((1.0 - walls) + 2.0 * ratio * walls)
    note = "walls 50 radii away, allowed for to first order"
    return Found(
        "closed form",
        "drag of two spheres in line 1.543 diameters apart over that of one",
        "1",
        0.7018,
        free,
        0.01,
        note,
    )


def _lift() -> Found:
    start = _flow(Shape(40.0, 40.0, 1.0, 25.0, 40.0), Fineness(0.25, 0.25, 4.0, 0.7))
    lift = ball_forces(flow_with_inertia(start, 0.2)).lift / 0.1
    quantity = "lift on a sphere that slides along a plane, gap of one radius, Re = 0.2"
    return Found("closed form", quantity, "rho U^2 r^2", 18.0 * math.pi / 32.0, lift, 0.05)
