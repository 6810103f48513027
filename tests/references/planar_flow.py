"""The vector field of a planar machine integrated in time by the compiled equations: checks orbits independently."""

from __future__ import annotations

import numpy as np

from autobalancer.assembly.system import Assembly
from autobalancer.errors import QuestionError
from autobalancer.kernels.guided_balls import planar
from autobalancer.kernels.integrators import tableau as tableaus
from autobalancer.kernels.integrators.runge_kutta import FINISHED, advance
from autobalancer.kernels.system import (
    BALL_COLUMNS,
    BALLS,
    DRAG,
    DRIVE,
    INERTIA,
    MASS,
    MOMENT,
    OFFSET_X,
    OFFSET_Y,
    PRESCRIBED,
    SEGMENT_COLUMNS,
    SPEED,
    UNBALANCE,
    VX,
    VY,
    System,
    X,
    Y,
)  # fmt: skip
from autobalancer.simulation.fresh import memory_for
from autobalancer.simulation.record import record_for
from autobalancer.simulation.sampling import SampleTimes
from autobalancer.stability.continuation.vector_field import Field
from autobalancer.stability.host.planar import Floats, Matrix

KEPT = [X, Y, VX, VY]


def flow(field: Field, state: Floats, times: Floats, tolerance: float = 1e-10) -> Matrix:
    """States at ascending times from 0 on, (len(times), 4 + 2 n), by the compiled kernel in the frame of the rotor.

    Raises
    ------
    QuestionError
        If the motion leaves all bounds.
    """
    n = field.balls
    full = np.zeros(BALLS + 2 * n)
    full[KEPT], full[BALLS:], full[SPEED] = state[:4], state[4:], field.speed
    scale, growing = np.ones(full.size), np.zeros(full.size)
    p, frequency = field.host, field.host.scale_speed
    length = (abs(p.fixed_load[0]) + p.moment.sum()) / p.model.total_mass
    scale[[X, Y]], scale[[VX, VY]], scale[BALLS + n :] = length, length * frequency, frequency
    growing[KEPT] = 1.0
    pair = tableaus.dormand_prince_8()
    assembly = Assembly(_system(field), full, scale, growing, ())
    end = float(times[-1])
    record = record_for([SampleTimes(times.tolist())], (), assembly, end)
    run = memory_for(assembly, end, tolerance, pair)
    if advance(planar, assembly.system, pair, record, run, 100_000_000) != FINISHED:
        raise QuestionError("branches: a motion from which an orbit was to start grows without limit")
    found = np.concatenate([record.samples[:, KEPT], record.samples[:, BALLS:]], -1)
    if times[0] == 0.0:
        found[0] = state
    return np.asarray(found)


def _system(field: Field) -> System:
    p, model = field.host, field.host.model
    stiffness, damping = float(model.stiffness[0][0, 0]), float(model.damping[0][0, 0])
    balls = np.zeros((field.balls, BALL_COLUMNS))
    for column, values in (
        (MASS, p.ball_mass), (MOMENT, p.moment), (INERTIA, p.inertia), (DRAG, p.drag), (OFFSET_X, p.offset.real),
        (OFFSET_Y, p.offset.imag),
    ):  # fmt: skip
        balls[:, column] = values
    segments = np.zeros((1, SEGMENT_COLUMNS))
    segments[0, DRIVE] = field.speed
    segments[0, UNBALANCE : UNBALANCE + 2] = p.unbalance.real, p.unbalance.imag
    return System(
        rotating=1.0,
        mass=float(model.mass[0, 0]),
        stiffness_x=stiffness,
        stiffness_y=stiffness,
        damping_x=damping,
        damping_y=damping,
        gravity_x=0.0,
        gravity_y=0.0,
        polar_inertia=1.0,
        drive=PRESCRIBED,
        torque_damping=0.0,
        balls=balls,
        torque_table=np.zeros((0, 2)),
        segments=segments,
        now=np.zeros(1, np.int64),
        rotor=np.zeros(0),
    )
