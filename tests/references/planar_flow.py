"""The vector field of a planar machine integrated in time by the compiled equations: checks orbits independently."""

from __future__ import annotations

import numpy as np

from autobalancer.arrays import Floats, Matrix
from autobalancer.assembly.contact import contact_rows
from autobalancer.assembly.system import Assembly, steady
from autobalancer.errors import QuestionError
from autobalancer.kernels.integrators import tableau as tableaus
from autobalancer.kernels.integrators.runge_kutta import FINISHED, advance
from autobalancer.kernels.records import BALL, GUIDED
from autobalancer.kernels.system import BALLS, SPEED, VX, VY, Planar, System, X, Y
from autobalancer.simulation.record import SampleTimes, record_for
from autobalancer.simulation.steppers import PLANAR, memory_for
from autobalancer.stability.host.vector_field import Field

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
    if advance(*PLANAR, assembly.system, pair, record, run, 100_000_000) != FINISHED:
        raise QuestionError("branches: a motion from which an orbit was to start grows without limit")
    found = np.concatenate([record.samples[:, KEPT], record.samples[:, BALLS:]], -1)
    if times[0] == 0.0:
        found[0] = state
    return np.asarray(found)


def _system(field: Field) -> System:
    p, model = field.host, field.host.model
    stiffness, damping = float(model.stiffness[0][0, 0]), float(model.damping[0][0, 0])
    balls = BALL.rows(field.balls)
    balls.mass, balls.moment, balls.inertia, balls.drag = p.ball_mass, p.moment, p.inertia, p.drag
    balls.center_x, balls.center_y = p.offset.real, p.offset.imag
    return System(
        rotating=1,
        gravity_x=0.0,
        gravity_y=0.0,
        polar_inertia=1.0,
        ball_count=field.balls,
        drive=steady(field.speed, complex(p.unbalance)),
        planar=Planar(float(model.mass[0, 0]), stiffness, stiffness, damping, damping),
        balls=balls,
        contacts=contact_rows(field.balls),
        guided=GUIDED.rows(field.balls),
    )
