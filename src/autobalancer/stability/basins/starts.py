"""The starts of a basin: axes with their values, or random ball angles."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from autobalancer.assembly.starts import start_angles
from autobalancer.errors import QuestionError
from autobalancer.kernels.system import BALLS, SPEED, THETA, VX, VY, Floats, Matrix, X, Y
from autobalancer.memory import refuse_what_does_not_fit
from autobalancer.random_numbers import generator
from autobalancer.stability.basins.end_states import Question

START_ANGLE = {"long_name": "ball angle at the start", "units": "rad", "frame": "rotor"}


def unit_of_axis(name: str) -> str:
    """SI unit of an axis over starts; empty if there is no such axis."""
    return {"ball_angle": "rad", "ball_speed": "rad/s", "acceleration": "rad/s^2"}.get(name.partition("[")[0], "")


def starts_of(
    question: Question, axes: Mapping[str, Sequence[float]], random: int, seed: int, acceleration: float | None
) -> tuple[Matrix, Floats, tuple[int, ...]]:
    """States (k, size), rates of a ramp from rest (k,), 0 without one, and the shape of the map."""
    n, speed = question.st.moment.size, question.speed
    values = [np.asarray(v, np.float64) for v in axes.values()]
    if any(v.ndim != 1 or v.size == 0 or not np.all(np.isfinite(v)) for v in values):
        raise QuestionError("basin: each axis needs a list of finite numbers")
    shape = tuple(v.size for v in values) if axes else (random,)
    count = math.prod(shape)
    refuse_what_does_not_fit("basin", count, "starts", 16.0 * question.assembly.state.size + 400.0, "; ask for fewer")
    first = question.assembly.state.copy()
    first[[X, Y, VX, VY, THETA]] = 0.0
    if question.assembly.general:
        first[BALLS + 2 * n : 2 + 2 * question.assembly.places.shape[2] + 2 * n] = 0.0  # the other coordinates
    first[SPEED] = 0.0 if acceleration or "acceleration" in axes else speed
    starts, rates = np.tile(first, (count, 1)), np.full(count, acceleration or 0.0)
    if not axes:
        drawn = generator(seed)
        balls = question.assembly.balls
        starts[:, BALLS : BALLS + n] = [start_angles(balls, drawn, given=False) for _ in range(count)]
    for name, grid in zip(axes, np.meshgrid(*values, indexing="ij"), strict=True):
        column = grid.ravel()
        kind, _, ball = name.partition("[")
        if kind == "acceleration" and not ball:
            if column.min() <= 0.0:
                raise QuestionError("basin: an acceleration must be greater than zero")
            rates[:] = column
        elif kind == "ball_speed" and not ball:
            starts[:, BALLS + n : BALLS + 2 * n] = column[:, None]
        elif kind in ("ball_angle", "ball_speed") and ball.rstrip("]").isdecimal() and 1 <= int(ball.rstrip("]")) <= n:
            starts[:, BALLS + n * (kind == "ball_speed") + int(ball.rstrip("]")) - 1] = column
        else:
            raise QuestionError(
                f"basin: no axis {name!r}; there are ball_angle[1] to ball_angle[{n}], ball_speed[i], ball_speed, "
                "acceleration"
            )
    return starts, rates, shape


def axis_name(path: str) -> str:
    """An axis in words."""
    kind, _, ball = path.partition("[")
    if kind == "acceleration":
        return "acceleration of the run-up"
    which = f"ball {ball.rstrip(']')}" if ball else "all balls"
    return f"start {kind.removeprefix('ball_')} of {which} in the rotor"
