"""What unbalances a rotor in a question: the machine's own unbalance or another, and balls at rest in it."""

from __future__ import annotations

import cmath
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from autobalancer.assembly.parameters import with_value_at
from autobalancer.assembly.profile import unbalance_factor
from autobalancer.assembly.rotors import LateralModel, balancer_rows, reference, unbalance_load
from autobalancer.assembly.rotors.model import Complexes
from autobalancer.catalog.resolve import resolve
from autobalancer.errors import QuestionError
from autobalancer.machine import Machine, Unbalance

Given = complex | float | Unbalance | Sequence[Unbalance] | None


@dataclass(frozen=True)
class Load:
    """Forces are w^2 Re, Im (load e^(i theta)); ``direction`` is the angle in the rotor that phases count from, rad."""

    load: Complexes  # (pairs,)
    direction: float


def load_of(
    machine: Machine,
    model: LateralModel,
    unbalance: Given,
    ball_angles: Sequence[float] | None,
    owner: str,
) -> Load:
    """The load of the unbalance and of balls at given angles in the rotor.

    The direction is that of the resultant point unbalance; of the resultant couple if there is no point unbalance.

    Raises
    ------
    QuestionError
        If there is no unbalance at all, or there are more or fewer angles than balls.
    """
    moments, couples = 0j, 0j
    if isinstance(unbalance, (int, float, complex, np.number)):
        moments = complex(unbalance)
        if not cmath.isfinite(moments):
            raise QuestionError(f"{owner}: unbalance: given {unbalance!r}; must be finite, in kg m")
        load = np.asarray(moments * reference(machine, model)[1].deflection, np.complex128)
    else:
        if unbalance is not None:
            parts = [unbalance] if isinstance(unbalance, Unbalance) else list(unbalance)
            machine = with_value_at(machine, "unbalances", tuple(parts))
        load = unbalance_load(machine, model)
        for part in machine.unbalances:
            factor = unbalance_factor(part, np.inf)
            moments += factor * part.vector
            couples += factor * cmath.rect(part.couple or part.misalignment or 0.0, part.angle)
    if ball_angles is not None:
        balls = resolve(machine)
        if len(ball_angles) != len(balls):
            raise QuestionError(
                f"{owner}: ball_angles: given {len(ball_angles)} for {len(balls)} balls; give one for each, in rad"
            )
        rows = balancer_rows(machine, model)
        for ball, angle in zip(balls, ball_angles, strict=True):
            arm = ball.eccentricity + ball.orbit_radius * cmath.exp(1j * float(angle))
            load = load + ball.effective_mass * arm * rows[ball.balancer].deflection
    if not np.any(load):
        raise QuestionError(f"{owner}: the rotor has no unbalance and would not move; give one with 'unbalance'")
    return Load(load, cmath.phase(moments) if moments else cmath.phase(couples))
