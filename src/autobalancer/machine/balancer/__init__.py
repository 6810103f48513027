"""Balancers: races, the balls in them and the fluid around these."""

from autobalancer.machine.balancer.balls import Balls
from autobalancer.machine.balancer.contact import Contact, Friction, Harmonic, Partitions, Roundness
from autobalancer.machine.balancer.drag import BallInRace, Drag
from autobalancer.machine.balancer.fluid import Fluid
from autobalancer.machine.balancer.force import Force, PairForce
from autobalancer.machine.balancer.friction_law import FrictionLaw
from autobalancer.machine.balancer.race import Balancer, Race
from autobalancer.machine.balancer.resolved import ResolvedContact
from autobalancer.machine.balancer.shear import ShearLaw

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
