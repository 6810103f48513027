# written by tools/write_stubs.py from public_names.py

from autobalancer.flow.annulus_problem import annulus_flow as annulus_flow
from autobalancer.flow.ball_problem import Channel as Channel
from autobalancer.flow.ball_problem import ball_drag as ball_drag
from autobalancer.flow.relaxation import recorded_speed as recorded_speed
from autobalancer.flow.relaxation import spin_up as spin_up

__all__ = [
    "Channel",
    "annulus_flow",
    "ball_drag",
    "recorded_speed",
    "spin_up",
]
