"""Balancers: races, the balls in them and the fluid around these."""

from autobalancer.machine.balancer.balls import Balls
from autobalancer.machine.balancer.contact import Contact, Friction, Harmonic, Partitions, Roundness
from autobalancer.machine.balancer.drag import (
    AnnulusDrag,
    CoefficientDrag,
    DiscoidalDrag,
    Drag,
    DragTorque,
    FreeSphereDrag,
    PlaneDrag,
    TableDrag,
)
from autobalancer.machine.balancer.fluid import Fluid
from autobalancer.machine.balancer.force import Force, PairForce
from autobalancer.machine.balancer.race import Balancer, Race
from autobalancer.machine.balancer.resolved import ResolvedContact

__all__ = [
    "AnnulusDrag",
    "Balancer",
    "Balls",
    "CoefficientDrag",
    "Contact",
    "DiscoidalDrag",
    "Drag",
    "DragTorque",
    "Fluid",
    "Force",
    "FreeSphereDrag",
    "Friction",
    "Harmonic",
    "PairForce",
    "Partitions",
    "PlaneDrag",
    "Race",
    "ResolvedContact",
    "Roundness",
    "TableDrag",
]
