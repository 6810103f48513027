"""Balls as an element of a rotor that something else moves, such as another program.

With the accelerations a = (A of all rows of the stations, w') the element is two linear forms,

    F = force - mass a,    phi'' = push - lean a,

F the forces on the rows of the stations and, last, the torque on the rotor. Rows of a station: deflection along x and y;
where balls move with the tilt of their race, the slopes dx/dz and dy/dz too, and F has their moments. All is in axes at rest,
F contains the weight of the balls, ``mass`` their mass. It is symmetric where balls do not rub.
"""

from __future__ import annotations

from numba import float64, void

from autobalancer.kernels.balls.ball_forces import push_guided
from autobalancer.kernels.balls.guided import touch
from autobalancer.kernels.balls.on_stations import gather
from autobalancer.kernels.compiler.flags import COMPILED, njit
from autobalancer.kernels.compiler.numba_struct import data
from autobalancer.kernels.host.linear import Motion
from autobalancer.kernels.system import BALLS, Floats, Matrix, System, matrix_type, system_type, vector_type
from autobalancer.kernels.trigonometry import sine_cosine


@njit(
    void(
        float64, vector_type, vector_type, vector_type, system_type,
        vector_type, matrix_type, vector_type, matrix_type,
    ),
    **COMPILED,
)  # fmt: skip
def element(
    time: float,
    shaft: Floats,
    rotor: Floats,
    balls: Floats,
    system: System,
    force: Floats,
    mass: Matrix,
    push: Floats,
    lean: Matrix,
) -> None:
    """Both forms at an instant, written into the last four.

    Parameters
    ----------
    time
        s; only what is tabled over time needs it.
    shaft
        (2 R,) the R rows of all stations, then their rates.
    rotor
        (2,) angle and speed.
    balls
        (2 n,) angles in the rotor, then their speeds there.
    system
        The balls, on a rotor whose coordinates are these rows, and whose speed is free; ``rigid.middle`` has room for a state.
    force, mass
        (R + 1,), (R + 1, R + 1).
    push, lean
        (n,), (n, R + 1).
    """
    p, work = system, system.work
    count, rows, each = p.ball_count, p.host.size, p.work.inert.shape[1]
    q, v, y = data(work.q), data(work.v), data(p.rigid.middle)
    # the motion as the balls look for it, and room for what they give
    for i in range(rows):
        q[i], v[i] = shaft[i], shaft[rows + i]
        work.push[i], work.arm[i], work.turn[i] = 0.0, 0.0, 0.0
        for j in range(each):
            work.inert[i, j] = 0.0
    for i in range(2 * count):
        y[BALLS + i] = balls[i]
    sine, cosine = sine_cosine(rotor[0])
    motion = Motion(rotor[1], 0.0, sine, cosine, p.gravity_x, p.gravity_y, 0.0)
    touch(y, p)
    push_guided(y, p, motion.speed)
    torque, inertia = 0.0, 0.0
    for b in range(count):
        its_torque, its_inertia = gather(time, y, p, motion, b, (each, True, False))
        torque += its_torque
        inertia += its_inertia
    # forces: the stations do not feel each other but by the rotor
    mass[:, :] = 0.0
    for i in range(rows):
        first = (i // each) * each
        force[i], mass[i, rows], mass[rows, i] = work.push[i], work.arm[i], work.turn[i]
        for j in range(each):
            mass[i, first + j] = work.inert[i, j]
    force[rows], mass[rows, rows] = torque, inertia
    # balls: their rows as they were solved
    lean[:, :] = 0.0
    for b in range(count):
        moving, at = p.guided[b], p.balls[b].station * each
        push[b], lean[b, rows] = moving.push, moving.twist
        lean[b, at], lean[b, at + 1] = moving.lean_x, moving.lean_y
        if each == 4:
            lean[b, at + 2], lean[b, at + 3] = moving.lean_u, moving.lean_v
