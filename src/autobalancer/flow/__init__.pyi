# written by tools/write_stubs.py from public_names.py

from autobalancer.flow.annulus import Annulus as Annulus
from autobalancer.flow.annulus import Walls as Walls
from autobalancer.flow.annulus import annulus_of as annulus_of
from autobalancer.flow.question import annulus_flow as annulus_flow
from autobalancer.flow.relaxation import RelaxationModes as RelaxationModes
from autobalancer.flow.relaxation import relaxation_modes as relaxation_modes
from autobalancer.flow.speed import recorded_speed as recorded_speed
from autobalancer.flow.spinning_up import SpinUp as SpinUp
from autobalancer.flow.spinning_up import spin_up as spin_up

__all__ = [
    "Annulus",
    "RelaxationModes",
    "SpinUp",
    "Walls",
    "annulus_flow",
    "annulus_of",
    "recorded_speed",
    "relaxation_modes",
    "spin_up",
]
