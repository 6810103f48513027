"""The numbers of a machine as the compiled equations see them, and the order of the state vector.

State of a rotor of R coordinates with n guided balls, length 2 + 2 R + 2 n::

    X, Y        deflection at the reference station         m        in the axes of the frame
    VX, VY      its velocity in space                       m/s      in the axes of the frame
    theta, w    rotor angle and speed                       rad, rad/s
    phi[n]      ball angles in the rotor                    rad
    phi'[n]     ball speeds in the rotor                    rad/s
    q[R - 2]    the other coordinates of the rotor          m        in the axes of the frame
    v[R - 2]    their velocities in space                   m/s      in the axes of the frame

On a planar rotor R = 2 and the reference station is the center of its races.

The frame is at rest, or it turns with the rotor (``rotating``), whichever makes the motion slow.
"""

from typing import NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

X, Y, VX, VY, THETA, SPEED, BALLS = 0, 1, 2, 3, 4, 5, 6

# columns of System.balls; from CONTACT on they are work space of the equations
(
    MASS, MOMENT, INERTIA, SPIN, DRAG, OFFSET_X, OFFSET_Y, ORBIT, STATION,
    NEXT, WRAP, TOUCH, HARD, SOFT, WALL_LOW, WALL_HIGH, WALL_HARD, WALL_SOFT, RUB, GRIP, ARM, ARM_NEXT, OUT, OUT_NEXT,
    CONTACT, OUTWARD, LEAN_X, LEAN_Y, LEAN_U, LEAN_V, PUSH, TWIST,
    BALL_COLUMNS,
) = range(33)  # fmt: skip
# columns of System.segments; DRIVE and UNBALANCE are the first of four each
START, KIND, DRIVE, UNBALANCE, SEGMENT_COLUMNS = 0, 1, 2, 6, 10

PRESCRIBED, TORQUE = 0, 1
LINEAR, HILL = 0, 1

Floats = NDArray[np.float64]
Matrix = NDArray[np.float64]
Integers = NDArray[np.int64]


class System(NamedTuple):
    """Parameters of the equations of motion, SI.

    Few arrays, because every array in a tuple costs some nanoseconds at every call.
    """

    rotating: float  # 1.0 if the frame turns with the rotor, else 0.0
    mass: float  # rotor and effective mass of all balls
    stiffness_x: float
    stiffness_y: float
    damping_x: float
    damping_y: float
    gravity_x: float  # acceleration in the plane
    gravity_y: float
    polar_inertia: float  # about the shaft: rotor, and of the balls what does not change
    drive: int  # PRESCRIBED or TORQUE
    torque_damping: float  # external damping torque over speed
    balls: Matrix  # (n, 32): effective mass; times orbit radius; inertia of the angle (mass, virtual mass, rolling);
    #               coupling with the rotor angle at E = 0; drag torque over speed; race center E in the rotor;
    #               orbit radius; number of its station; the next ball of its race (-1: none) with what to add to its
    #               angle and the angle between them when they touch; stiffness and damping of their contact (torque);
    #               the angles of partitions between which it runs, and stiffness and damping there;
    #               of contact with the next ball, laws/touching_balls.py:
    #               friction, sharpness of its onset, arms of it and of the next, and what presses both on the wall (1/m)
    torque_table: Matrix  # (q, 2) speed, torque; may be empty
    segments: Matrix  # (s, 10): start time; kind; speed or torque, linear (value, rate) or
    #               Hill (end, half time, exponent, begin); unbalance Ux, Uy in the rotor and their rates
    now: Integers  # (1,) the segment in force
    rotor: Floats  # a rotor with more than a plane, laid out in kernels/stations.py; empty for a planar one


vector_type = types.Array(types.float64, 1, "C")
matrix_type = types.Array(types.float64, 2, "C")
integers_type = types.Array(types.int64, 1, "C")
system_type = types.NamedTuple(
    [types.float64] * 9 + [types.int64, types.float64] + [matrix_type] * 3 + [integers_type, vector_type], System
)
numbers_type = types.CPointer(types.float64)
rhs_type = types.FunctionType(types.void(types.float64, numbers_type, numbers_type, types.CPointer(system_type)))
