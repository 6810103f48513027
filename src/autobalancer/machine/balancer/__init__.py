"""Balancers: races, the balls in them and the fluid around these."""

from autobalancer.machine.balancer.fluid import BallInRace, Drag, Fluid, ShearLaw
from autobalancer.machine.balancer.force import Force, PairForce
from autobalancer.machine.balancer.race import Balancer, Balls, Race
from autobalancer.machine.balancer.resolved import (
    Contact,
    Friction,
    FrictionLaw,
    Harmonic,
    Partitions,
    ResolvedContact,
    Roundness,
)

__all__ = [
    "Balancer",
    "BallInRace",
    "Balls",
    "Contact",
    "Drag",
    "Fluid",
    "Force",
    "Friction",
    "FrictionLaw",
    "Harmonic",
    "PairForce",
    "Partitions",
    "Race",
    "ResolvedContact",
    "Roundness",
    "ShearLaw",
]
