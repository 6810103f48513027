"""Balancers: races, the balls in them and the fluid around these."""

from autobalancer.machine.balancer.balls import Balls
from autobalancer.machine.balancer.drag import AnnulusDrag, CoefficientDrag, Drag, DragTorque, PlaneDrag
from autobalancer.machine.balancer.fluid import Fluid
from autobalancer.machine.balancer.race import Balancer, Race

__all__ = [
    "AnnulusDrag",
    "Balancer",
    "Balls",
    "CoefficientDrag",
    "Drag",
    "DragTorque",
    "Fluid",
    "PlaneDrag",
    "Race",
]
