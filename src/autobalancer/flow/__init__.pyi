# written by tools/write_stubs.py from public_names.py

from autobalancer.flow.annulus import Annulus as Annulus
from autobalancer.flow.annulus import Walls as Walls
from autobalancer.flow.annulus import annulus_of as annulus_of
from autobalancer.flow.annulus_problem import annulus_flow as annulus_flow
from autobalancer.flow.ball_problem import Channel as Channel
from autobalancer.flow.ball_problem import ball_drag as ball_drag
from autobalancer.flow.relaxation import RelaxationModes as RelaxationModes
from autobalancer.flow.relaxation import SpinUp as SpinUp
from autobalancer.flow.relaxation import recorded_speed as recorded_speed
from autobalancer.flow.relaxation import relaxation_modes as relaxation_modes
from autobalancer.flow.relaxation import spin_up as spin_up

__all__ = [
    "Annulus",
    "Channel",
    "RelaxationModes",
    "SpinUp",
    "Walls",
    "annulus_flow",
    "annulus_of",
    "ball_drag",
    "recorded_speed",
    "relaxation_modes",
    "spin_up",
]
