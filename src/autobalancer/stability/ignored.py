"""What a machine has and a theory of its stability does not know, so that every answer can say so in its own line."""

from __future__ import annotations

from autobalancer.assembly.bearings.hardening import has_hardening
from autobalancer.assembly.rubber import has_rubber
from autobalancer.assembly.torsion.links import is_linked
from autobalancer.catalog.resolve import resolve
from autobalancer.machine import Machine, PlanarRotor


def ignored_at_rest(machine: Machine) -> tuple[str, ...]:
    """What steady states, their growth rates, averaged and exact border leave out."""
    races = [race for balancer in machine.balancers for race in balancer.races]
    return _there(
        {
            "friction": any(race.friction is not None for race in races),
            "drag that is not linear": any(ball.drag_curve is not None for ball in resolve(machine)),
            "partitions": any(race.partitions is not None for race in races),
            "softening of the rubber (stiffness of small motions)": has_rubber(machine),
        }
        | _by_all(machine)
    )


def ignored_by_stalled(machine: Machine) -> tuple[str, ...]:
    """What the torque balances of release and capture speed leave out; they know rolling resistance and any drag."""
    races = [race for balancer in machine.balancers for race in balancer.races]
    adheres = any(race.friction is not None and race.friction.adherence is not None for race in races)
    forced = any(race.forces for race in races)
    tilts = machine.tilting_races == "full" and not isinstance(machine.rotor, PlanarRotor)
    return _there(
        {
            "adherence": adheres,
            "tilt of the races": tilts,
            "forces on the balls": forced,
            "softening of the rubber by the unbalance": has_rubber(machine),
        }
        | _by_all(machine)
    )


def weightless(machine: Machine) -> Machine:
    """The machine without the weight across a horizontal axis, with which nothing rests in the rotor; others as they are."""
    return machine.model_copy(update={"gravity": 0.0}) if _weighs(machine) else machine


def _weighs(machine: Machine) -> bool:
    return bool(machine.axis == "horizontal" and machine.gravity > 0.0)


def without(names: tuple[str, ...]) -> str:
    """In words, for a note; empty if nothing is left out."""
    return f"ignores {', '.join(names)}" if names else ""


def _by_all(machine: Machine) -> dict[str, bool]:
    races = [race for balancer in machine.balancers for race in balancer.races]
    return {
        "gravity in the plane": _weighs(machine),
        "waves of the race": any(race.harmonics or race.roundness is not None for race in races),
        "resolved contact": any(race.resolved is not None for race in races),
        "excitations": bool(machine.excitations),
        "hardening of the bearings (stiffness at rest)": has_hardening(machine),
        "torsion of the drive": is_linked(machine),
        "slipstream": any(race.slipstream for race in races),
        "friction between balls": any(race.contact is not None and race.contact.friction > 0.0 for race in races),
    }


def _there(parts: dict[str, bool]) -> tuple[str, ...]:
    return tuple(name for name, there in parts.items() if there)
