"""The loop over the balls of a linear rotor, whatever they are.

A ball model gives three functions:

``prepare(time, y, p, motion)``                         forces among balls, into its rows
``gather(time, y, p, motion, b, kind)``                 the force of ball b on its station, into the work space of the rotor;
                                                        returns its torque and inertia there
``recover(y, dy, p, motion, b, acceleration, kind)``    the rates of ball b, once the accelerations of the stations
                                                        (``work.one``) and of the rotor are known; whether it was taken wrongly

Rows of guided balls that rigid contacts join come in between.
"""

from __future__ import annotations

from autobalancer.kernels.balls.rigid_torques import bind, press
from autobalancer.kernels.compiler.flags import INLINE, njit
from autobalancer.kernels.compiler.numba_struct import deref
from autobalancer.kernels.host.external_forces import add_external_forces
from autobalancer.kernels.host.linear import solve_coupled, solve_free, write_rotor
from autobalancer.kernels.host.shaft_train import turn_links
from autobalancer.kernels.laws.curves import relax
from autobalancer.kernels.system import system_at


@njit(**INLINE)
def rates_of(time, y, dy, system, prepare, gather, recover, kind) -> bool:  # type: ignore[no-untyped-def]
    """Time derivative ``dy`` of the state ``y``; ``kind`` goes to the functions. Whether any ball was taken wrongly."""
    p = deref(system_at(system))
    # the rotor alone: q'' = f - w' g, with excitation, rubber and hardening bearings if there are any
    motion = solve_free(time, y, system)
    if p.shakes.shape[0] + p.rubber.mounts.shape[0] + p.bearings.springs.shape[0] > 0:
        motion = add_external_forces(time, y, dy, system, motion)
    # the balls, one after the other, into the rows of their stations; rows joined by rigid contacts come last
    prepare(time, y, p, motion)
    torque, inertia = motion.torque, p.polar_inertia
    if p.drive.linked == 1:
        torque += turn_links(time, y, dy, system)
    for b in range(p.ball_count):
        its_torque, its_inertia = gather(time, y, p, motion, b, kind)
        torque += its_torque
        inertia += its_inertia
    if p.rigid.bound[0] > 0:
        its_torque, its_inertia = bind(y, system, motion.acceleration)
        torque += its_torque
        inertia += its_inertia
    # the stations' small system, then w', then everything from them
    acceleration = solve_coupled(system, motion.acceleration, torque, inertia)
    write_rotor(y, dy, system, motion.speed, acceleration)
    wrong = False
    for b in range(p.ball_count):
        wrong |= recover(y, dy, p, motion, b, acceleration, kind)
    if p.rigid.bound[0] > 0:
        wrong |= press(y, dy, system, acceleration)
    relax(y, dy, p.fluid, acceleration)
    return wrong
