"""How many steps a run will take, looked at before it begins: explicit steps cannot be much longer than its fastest decay.

Long steps solve for drag, damping and vibration exactly, so that only gravity and unequal supports can make them many.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from autobalancer.assembly.spatial import top_speed
from autobalancer.assembly.system import Assembly
from autobalancer.catalog.resolve_springs import planar_rotor
from autobalancer.machine import Machine, PlanarRotor

REACH = 5.0  # step times rate that an explicit pair of order eight bears
TURN = 0.3  # rad of rotor angle in a step, where gravity or unequal supports act once a revolution
PACE = 4e5  # steps in a second, measured with a few balls on a usual computer
LONG = 60.0  # s of computing from which on it is said


def slow_because(machine: Machine, assembly: Assembly, duration: float, *, long_steps: bool = False) -> str:
    """A sentence about a run of ``duration`` (s) that will take long, with the cause; empty if it will not.

    An estimate from drag at rest, damping and stiffness of planar rotors, linear walls and the greatest speed.
    """
    rates = [*_turns(machine, assembly)] if long_steps else [*_decays(machine, assembly), *_turns(machine, assembly)]
    steps, cause = max(((duration * rate, cause) for rate, cause in rates), default=(0.0, ""))
    if steps / PACE < LONG:
        return ""
    return (
        f"this run is stiff: {cause}, so {duration:.3g} s take about {steps:.1g} steps, {_spoken(steps / PACE)} on a usual "
        "computer. If that value is meant, shorten the run; a limit of steps ends it with the outcome 'budget spent'"
    )


def _decays(machine: Machine, assembly: Assembly) -> Iterator[tuple[float, str]]:
    """Explicit steps in a second of the run, and the decay or vibration that asks for them."""
    for number, ball in enumerate(assembly.balls, 1):
        if ball.drag > 0.0:
            rate = ball.drag / ball.inertia
            yield rate / REACH, f"drag brakes ball {number} with a time constant of {1.0 / rate:.2g} s"
        resolved = machine.balancers[ball.balancer].races[ball.race].resolved
        if resolved is not None and resolved.stiffness is not None:
            rate = math.sqrt(resolved.stiffness / ball.mass)
            yield rate / REACH, f"ball {number} bounces on its wall within {1.0 / rate:.2g} s"
    if isinstance(machine.rotor, PlanarRotor):
        rotor = planar_rotor(machine)
        for stiffness, damping in zip(rotor.stiffness_xy, rotor.damping_xy, strict=True):
            rate = damping / machine.rotor.mass
            if rate > 0.0:
                yield rate / REACH, f"damping brakes the rotor with a time constant of {1.0 / rate:.2g} s"
            rate = math.sqrt(stiffness / machine.rotor.mass)
            yield rate / REACH, f"the rotor vibrates at {rate:.2g} rad/s"


def _turns(machine: Machine, assembly: Assembly) -> Iterator[tuple[float, str]]:
    """Steps in a second of the run where they have to follow each turn."""
    speed = top_speed(machine)
    if speed and not assembly.system.rotating:
        yield speed / TURN, f"the rotor turns at {speed:.3g} rad/s"


def _spoken(seconds: float) -> str:
    for unit, length in (("years", 3.156e7), ("days", 86400.0), ("hours", 3600.0)):
        if seconds >= 2.0 * length:
            return f"{seconds / length:.2g} {unit}"
    return f"{seconds / 60.0:.2g} minutes"
