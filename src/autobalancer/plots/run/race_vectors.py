"""The vectors of unbalance in the plane of a balancer."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from autobalancer.plots.drawing.style import ALL_BALLS, INK, UNBALANCE
from autobalancer.plots.run.ball_looks import Planes
from autobalancer.results.display_units import couple_text, moment_text
from autobalancer.results.drawn.motion import Moments, Races


class Vector(NamedTuple):
    """An arrow in the frame of the rotor."""

    value: complex  # kg m
    label: str
    color: str
    dashed: bool = False


def vectors_of(races: Races, moments: Moments, planes: Planes, plane: int) -> list[Vector]:
    """Unbalance, balls and resultant of one plane at the first of the ``moments``; before them what a couple puts there."""
    met = complex(moments.plane_unbalance_in_rotor[0, plane])
    balls = complex(races.vectors(moments)[0, races.plane == plane].sum())
    where = " in this plane" if len(planes.names) > 1 else ""
    here = races.plane == plane
    bodies = set(races.body[here].tolist())
    whose = f"{bodies.pop()}s" if len(bodies) == 1 else "balls"
    whose += " of all balancers" if len(set(races.balancer[here].tolist())) > 1 else ""
    return [
        *_couple(moments, planes, plane),
        Vector(met, f"unbalance{where} {moment_text(abs(met))}", UNBALANCE),
        Vector(balls, f"{whose} {moment_text(abs(balls))}", ALL_BALLS),
        Vector(met + balls, f"resultant {moment_text(abs(met + balls))}", INK),
    ]


def _couple(moments: Moments, planes: Planes, plane: int) -> list[Vector]:
    """The share of a couple unbalance: in two planes a pair of opposite vectors; the part at greater z is that of the couple."""
    couple = complex(moments.couple_in_rotor[0])
    away = float(np.ptp(planes.position)) if len(planes.names) == 2 else np.nan
    if not couple or not away > 0.0:
        return []
    sign = 1.0 if planes.position[plane] == planes.position.max() else -1.0
    share = sign * couple / away
    return [Vector(share, f"of which couple {moment_text(abs(share))} ({couple_text(abs(couple))})", UNBALANCE, True)]


def couple_note(moments: Moments, planes: Planes) -> str:
    """A couple unbalance in words, where it cannot be drawn as a pair of vectors."""
    couple = complex(moments.couple_in_rotor[0])
    if not couple or len(planes.names) == 2:
        return ""
    return f"◇ couple unbalance {couple_text(abs(couple))}, at greater z towards {np.rad2deg(np.angle(couple)):.0f}°"
