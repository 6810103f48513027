"""Friction laws of resolved balls: compiled, tried, and put into the rows of the balls."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np

from autobalancer.catalog.resolve import Ball
from autobalancer.errors import MachineError
from autobalancer.kernels.called import FRICTION, Called, compiled, in_words, numbers_row
from autobalancer.kernels.records.friction import SLIP
from autobalancer.kernels.system import Rows, System
from autobalancer.machine import FrictionLaw, Machine, ResolvedContact
from autobalancer.machine.leaves import find
from autobalancer.patience import returned

SLIPS = np.geomspace(1e-6, 10.0, 29)  # m/s, at which a law is tried in both directions
PRESSED = (1e-2, 1.0, 1e3)  # N
REST = 1e-6  # share of the greatest coefficient that a law may have without slip


def friction_rows(machine: Machine, balls: tuple[Ball, ...], rows: Rows) -> dict[str, Any]:
    """Slips and numbers of friction laws as fields of a system; the laws go into the ``rows`` of the balls.

    Raises
    ------
    MachineError
        If a law cannot be used; the message says which one, and why.
    """
    slips = SLIP.rows(len(balls))
    numbers: list[float] = []
    for row, slip, ball in zip(rows, slips, balls, strict=True):
        contact, law = _law(machine, ball)
        slip.sliding, slip.slip_speed, slip.radius = contact.sliding_friction, contact.slip_speed, ball.radius
        try:
            row.friction = _tried(law, float(slip.sliding), float(slip.slip_speed), ball.radius).address
        except MachineError as reason:
            where = f"balancers[{ball.balancer + 1}].races[{ball.race + 1}].resolved.friction_law"
            raise MachineError(f"{where}: the friction law {law.word()!r} {reason}") from None
        row.first_number = len(numbers)
        numbers += law.numbers().values() or (0.0,)
    return {"slips": slips, "friction_numbers": np.array(numbers, np.float64)}


def friction_at_fault(machine: Machine, balls: tuple[Ball, ...], system: System) -> str:
    """Which friction law was not a number during a run, and where; empty if none was."""
    wrong = np.flatnonzero(system.slips.wrong)
    if not wrong.size:
        return ""
    number = int(wrong[0])
    at, word = system.slips[number], _law(machine, balls[number])[1].word()
    return (
        f"the friction law {word!r} was not a number on ball {number + 1} at a slip of {at.wrong_slip:.6g} m/s on a wall that "
        f"pressed with {at.wrong_pressed:.4g} N"
    )


def _law(machine: Machine, ball: Ball) -> tuple[ResolvedContact, FrictionLaw]:
    contact = machine.balancers[ball.balancer].races[ball.race].resolved
    assert contact is not None
    law = contact.friction_law or find(FrictionLaw, "coulomb")()
    assert isinstance(law, FrictionLaw)
    return contact, law


@lru_cache(maxsize=256)
def _tried(law: FrictionLaw, sliding: float, slip_speed: float, radius: float) -> Called:
    """The compiled law of a ball: a number everywhere, against the slip, and nothing without it."""
    function = getattr(type(law), "coefficient", None)
    if function is None:
        raise MachineError("has no 'coefficient'; write it as a static method: coefficient(at, own) -> float")
    asked = function, tuple(law.numbers()), FRICTION
    try:
        made = compiled(*asked)
    except Exception as reason:
        raise MachineError(f"does not compile: {in_words(reason, *asked)}") from None
    returned(lambda: _refuse_driving(law, made, sliding, slip_speed, radius), f"the friction law {law.word()!r}")
    return made


def _refuse_driving(law: FrictionLaw, made: Called, sliding: float, slip_speed: float, radius: float) -> None:
    """Refuse a law that is not a number somewhere, or drives a ball."""
    own, greatest = numbers_row(law.numbers()), 0.0
    for pressed in PRESSED:
        for slip in (*SLIPS, *-SLIPS, 0.0):
            at = SLIP.row(slip=slip, pressed=pressed, sliding=sliding, slip_speed=slip_speed, radius=radius)
            value = float(made.function(at, own))
            where = f"at a slip of {slip:.4g} m/s on a wall that presses with {pressed:g} N"
            if not math.isfinite(value):
                raise MachineError(f"is not a number {where}: it returned {value:g}")
            greatest = max(greatest, abs(value))
            if slip == 0.0 and abs(value) > REST * greatest:
                raise MachineError(
                    f"drives a ball that does not slip, with the coefficient {value:.4g}; it must be zero there"
                )
            if value * slip < 0.0:
                raise MachineError(
                    f"drives the ball {where}: its coefficient is {value:.4g}; it must have the sign of the slip, against "
                    "which friction acts"
                )
