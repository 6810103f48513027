"""The three border speeds, each under its own name.

*averaged border*: where the averaged equations lose stability (Spannan 2021, 4.74). *Exact border*: where the balanced
state really loses it. *Release speed*: where balls that stall at the critical speed during a slow run-up break away
(Ryzhik et al. 2001; Spannan 2021, 4.73).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from autobalancer.assembly.system import total_mass
from autobalancer.catalog.resolve import Ball, resolve
from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import load_machine
from autobalancer.machine import Machine
from autobalancer.stability.characteristic import PlanarBalancer, exact_border, worst_case_border
from autobalancer.stability.lateral import largest_unbalance

SEARCHED = 40.0  # the exact border is sought up to so many times the critical speed


@dataclass(frozen=True)
class Border:
    """One border speed: ``speed`` in rad/s, infinite for never, nan where it does not exist; ``note`` says why."""

    name: str
    speed: float
    note: str


def border_speeds(machine: Machine | str | Path, unbalance: float | None = None) -> tuple[Border, ...]:
    """All border speeds known for a machine.

    Parameters
    ----------
    machine
        A machine or the path of a machine file.
    unbalance
        kg m, for the exact border of two balls; by default the largest of the machine.

    Returns
    -------
    tuple of Border
        Averaged border, exact border (at this unbalance and in the worst case), release speed. Empty notes mean that
        the formula holds as it stands.

    Raises
    ------
    QuestionError
        If the machine is one for which none of them has a closed form: it needs isotropic supports, a vertical axis,
        one centric race, equal balls, damping.
    """
    if not isinstance(machine, Machine):
        machine = load_machine(machine)
    balls = resolve(machine)
    reason = why_not(machine, balls)
    if reason:
        raise QuestionError(f"border speeds: no closed form for this machine: {reason}")
    balancer = planar_balancer(machine, balls)
    critical, count = balancer.critical_speed, balancer.count
    share = 0.5 * count * balancer.sommerfeld_number
    averaged = critical * math.sqrt((1.0 + share) / (1.0 - share)) if share < 1.0 else math.inf
    worst = worst_case_border(balancer)
    found = [
        Border(
            "averaged border",
            averaged,
            "" if share < 1.0 else "never: S reaches its limit (Spannan 2021, 4.75)",
        ),
        Border(
            "exact border, worst case",
            worst,
            "" if math.isfinite(worst) else "never, for balls at right angles",
        ),
    ]
    size = largest_unbalance(machine) if unbalance is None else unbalance
    if count == 2:
        cosine = size / (2.0 * balancer.moment)
        if cosine <= 1.0:
            spread = 2.0 * abs(2.0 * cosine * cosine - 1.0)
            exact = exact_border(balancer, spread, SEARCHED * critical)
            note = "" if math.isfinite(exact) else f"none up to {SEARCHED:g} times the critical speed"
            found.append(Border("exact border", exact, note))
        else:
            found.append(Border("exact border", math.nan, "the balls cannot balance this unbalance"))
    found.append(Border("release speed", critical * (1.0 + 2.0 * share), "for a drag that is linear and no friction"))
    return tuple(found)


def why_not(machine: Machine, balls: tuple[Ball, ...]) -> str:
    """Why the closed forms do not hold for a machine; empty if they do."""
    if not balls:
        return "it has no balls"
    if not machine.rotor.isotropic:
        return "its supports are not isotropic"
    if machine.axis == "horizontal" and machine.gravity > 0.0:
        return "gravity acts in its plane"
    if len({(ball.balancer, ball.race) for ball in balls}) > 1:
        return "it has more than one race"
    if any(ball.eccentricity for ball in balls):
        return "its race is eccentric"
    if len({(ball.moment, ball.inertia, ball.drag) for ball in balls}) > 1:
        return "its balls are not equal"
    if len(balls) < 2:
        return "one ball alone can balance one unbalance only"
    if machine.rotor.damping_xy[0] == 0.0 or balls[0].drag == 0.0:
        return "its rotor or its balls are undamped"
    return ""


def planar_balancer(machine: Machine, balls: tuple[Ball, ...]) -> PlanarBalancer:
    """The numbers of the closed forms."""
    return PlanarBalancer(
        mass=total_mass(machine, balls),
        stiffness=machine.rotor.stiffness_xy[0],
        damping=machine.rotor.damping_xy[0],
        count=len(balls),
        moment=balls[0].moment,
        inertia=balls[0].inertia,
        drag=balls[0].drag,
    )
