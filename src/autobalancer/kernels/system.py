"""The numbers of a machine as the compiled equations see them, and the order of the state vector.

State of a rotor of R coordinates with n guided balls, length 2 + 2 R + 2 n::

    X, Y        deflection at the reference station         m        in the axes of the frame
    VX, VY      its velocity in space                       m/s      in the axes of the frame
    theta, w    rotor angle and speed                       rad, rad/s
    phi[n]      ball angles in the rotor                    rad
    phi'[n]     ball speeds in the rotor                    rad/s
    q[R - 2]    the other coordinates of the rotor          m        in the axes of the frame
    v[R - 2]    their velocities in space                   m/s      in the axes of the frame

On a planar rotor R = 2 and the reference station is the center of its races. Relaxation modes of fluids follow, then forces of
rubber elements (two each, N, in the axes of the frame), then twist and speed of each link of the drive train.

The frame is at rest, or it turns with the rotor (``rotating``), whichever makes the motion slow.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import typeof, types
from numpy.typing import NDArray

from autobalancer.kernels.compiler.numba_struct import passed_by_address, pointer_to, value_type
from autobalancer.kernels.records import (
    BALL,
    CONTACT,
    ELEMENT,
    FORCE,
    FREE,
    FREE_BALL,
    GUIDED,
    HARDENING,
    IMPACT,
    LINE,
    LINK,
    PARTITION,
    PLACE,
    POINT,
    PRESCRIBED,
    RELAXATION,
    RIPPLE,
    RUBBER_MOUNT,
    SEGMENT,
    SHAKE,
    SLIP,
    TABLE,
    TIE,
    TORQUE,
    TOUCH,
    WAVE,
)

X, Y, VX, VY, THETA, SPEED, BALLS = 0, 1, 2, 3, 4, 5, 6

Floats = NDArray[np.float64]
Matrix = NDArray[np.float64]
Integers = NDArray[np.int64]
Rows = Any  # of one of the records


class Drive(NamedTuple):
    """What turns the rotor, and its unbalance."""

    kind: int = PRESCRIBED  # or TORQUE
    damping: float = 0.0  # external damping torque over speed
    table: Matrix = np.zeros((0, 2))  # (q, 2) speed, torque; may be empty
    segments: Rows = SEGMENT.rows(0)
    now: Integers = np.zeros(1, np.int64)  # (1,) the segment in force
    breakdown_torque: float = 0.0  # of an asynchronous motor; 0: there is none
    synchronous_speed: float = 0.0
    breakdown_slip: float = 0.0  # as a difference of speeds
    motor: int = TORQUE  # PRESCRIBED: the speed of the motor behind the last link is given
    linked: int = 0  # 1: the rotor is driven by links or ripples
    links: Rows = LINK.rows(0)
    ripples: Rows = RIPPLE.rows(0)


class Planar(NamedTuple):
    """A rotor that moves in its plane only, for its own equations; on any other rotor all are 0."""

    mass: float = 0.0  # rotor and effective mass of all balls
    stiffness_x: float = 0.0
    stiffness_y: float = 0.0
    damping_x: float = 0.0
    damping_y: float = 0.0


class Host(NamedTuple):
    """Any other linear rotor: R coordinates in W places (whole lanes), S stations of two or four rows each, T speeds.

    Matrices over the coordinates stand column by column and are multiplied by M^-1 where that is said.
    """

    size: int = 0  # R
    width: int = 0  # W
    stations: int = 0  # S
    axial_gravity: float = 0.0  # acceleration along +z
    speeds: Floats = np.zeros(0)  # (T,) of the matrices
    gyroscopic: Matrix = np.zeros((0, 0))  # (W, W) M^-1 G
    damping: Any = np.zeros((0, 0, 0))  # (T, W, W) M^-1 C
    stiffness: Any = np.zeros((0, 0, 0))  # (T, W, W) M^-1 K
    spin: Matrix = np.zeros((0, 0))  # (W, W) G/2
    rows: Matrix = np.zeros((0, 0))  # (rows, W) B of all stations
    reach: Matrix = np.zeros((0, 0))  # (rows, W) B M^-1
    mobility: Matrix = np.zeros((0, 0))  # (rows, rows) H = B M^-1 B^T
    loads: Any = np.zeros((0, 8, 0))  # (segments, 8, W) M^-1 u (real, imaginary part), u, and the rates of all four


class Work(NamedTuple):
    """Work space of a linear rotor."""

    q: Floats = np.zeros(0)  # (W,) coordinates
    v: Floats = np.zeros(0)  # (W,) velocities
    f: Floats = np.zeros(0)  # (W,) q'' = f - w' g
    g: Floats = np.zeros(0)  # (W,)
    own_g: Floats = np.zeros(0)  # (W,) M g
    left: Matrix = np.zeros((0, 0))  # (rows, rows) 1 + H S
    one: Floats = np.zeros(0)  # (rows,) right-hand sides; then the accelerations of the stations
    two: Floats = np.zeros(0)  # (rows,)
    push: Floats = np.zeros(0)  # (rows,) forces R on the stations
    arm: Floats = np.zeros(0)  # (rows,) c: what w' adds to them
    turn: Floats = np.zeros(0)  # (rows,) what the accelerations of the stations add to the torque
    inert: Matrix = np.zeros((0, 0))  # (rows, rows of a station) S


class Fluid(NamedTuple):
    """What the fluids do, and all tables."""

    tables: Rows = TABLE.rows(0)
    points: Rows = POINT.rows(0)
    modes: Rows = RELAXATION.rows(0)
    lines: Rows = LINE.rows(0)
    others: Integers = np.zeros(0, np.int64)  # numbers of balls, for the lines
    fit: Matrix = np.zeros((0, 0))  # of the slipstream, by powers of Reynolds number and distance


class Rubber(NamedTuple):
    """Rubber that slides and relaxes, beside the springs of a linear rotor."""

    mounts: Rows = RUBBER_MOUNT.rows(0)
    elements: Rows = ELEMENT.rows(0)
    rows: Matrix = np.zeros((0, 0))  # (2 mounts, W) B: the stretch of each along x and y
    reach: Matrix = np.zeros((0, 0))  # (2 mounts, W) B M^-1


class Bearings(NamedTuple):
    """Bearings that become stiffer as they deflect."""

    springs: Rows = HARDENING.rows(0)
    rows: Matrix = np.zeros((0, 0))  # (2 bearings, W) B: the deflection in each along x and y
    reach: Matrix = np.zeros((0, 0))  # (2 bearings, W) B M^-1
    tables: Matrix = np.zeros(
        (0, 5)
    )  # (pieces, 5) distance where each begins; force by powers of the way from there, c3 to c0


class Rigid(NamedTuple):
    """Rigid contacts of guided balls, and work space for c of them at one instant; empty where contacts are soft."""

    bound: Integers = np.zeros(2, np.int64)  # (2,) how many balls are held by contacts now; changes at one instant
    margin: Floats = np.zeros(5)  # (5,) of contact torques: balls/rigid_torques.py
    kinds: Integers = np.zeros(0, np.int64)  # (c,) of the contacts that are closed: records.py
    balls: Integers = np.zeros(0, np.int64)  # (c,) number of the ball
    chosen: Integers = np.zeros(0, np.int64)  # (c,) 1: takes part
    active: Integers = np.zeros(0, np.int64)  # (c,) 1: presses
    before: Floats = np.zeros(0)  # (c,) rates of the gaps before an impact
    need: Floats = np.zeros(0)  # (c,)
    impulse: Floats = np.zeros(0)  # (c,)
    delassus: Matrix = np.zeros((0, 0))  # (c, c) acceleration of a gap over the torque of a contact
    left: Matrix = np.zeros((0, 0))  # (c, c + 1) work
    response: Matrix = np.zeros((0, 0))  # (c, w) what a torque of one does to the rates of the state
    base: Floats = np.zeros(0)  # (w,) rates
    middle: Floats = np.zeros(0)  # (w,) a state
    missed: Floats = np.zeros(0)  # (w,) by how much a guess of it was wrong


@passed_by_address
class System(NamedTuple):
    """Parameters of the equations of motion, SI, and their work space. What a machine does not have is empty."""

    rotating: int  # 1 if the frame turns with the rotor, else 0
    gravity_x: float  # acceleration in the plane
    gravity_y: float
    polar_inertia: float  # about the shaft: rotor, and of the balls what does not change
    ball_count: int
    drive: Drive
    planar: Planar = Planar()
    host: Host = Host()
    work: Work = Work()
    balls: Rows = BALL.rows(0)  # guided
    contacts: Rows = CONTACT.rows(0)
    guided: Rows = GUIDED.rows(0)
    ties: Rows = TIE.rows(0)  # of guided balls whose contacts are rigid, else empty
    rigid: Rigid = Rigid()
    free_balls: Rows = FREE_BALL.rows(0)  # resolved
    partitions: Rows = PARTITION.rows(0)
    free: Rows = FREE.rows(0)
    slips: Rows = SLIP.rows(0)  # of resolved balls
    rebounds: Floats = np.zeros(0)  # tables of contacts whose restitution depends on the speed of an impact
    pair_rebounds: Integers = np.zeros(0, np.int64)  # where that of two resolved balls begins, row by row; may be empty
    touches: Rows = TOUCH.rows(0)  # contacts whose impacts are noted
    impacts: Rows = IMPACT.rows(0)  # room for those that are noted
    impact_count: Integers = np.zeros(0, np.int64)  # (1,) how many there were, (0,) without touches
    friction_numbers: Floats = np.zeros(0)  # own numbers of all friction laws
    waves: Rows = WAVE.rows(0)
    fluid: Fluid = Fluid()
    places: Rows = PLACE.rows(0)  # of the balls, for forces
    forces: Rows = FORCE.rows(0)
    force_numbers: Floats = np.zeros(0)  # own numbers of all forces
    rubber: Rubber = Rubber()
    bearings: Bearings = Bearings()
    shakes: Rows = SHAKE.rows(0)
    shake_vectors: Matrix = np.zeros((0, 0))  # (2 excitations, W)


def own(value: Any) -> Any:
    """A tuple with arrays of its own, for another thread."""
    if isinstance(value, np.ndarray):
        return value.copy()
    return type(value)(*map(own, value)) if isinstance(value, tuple) else value


vector_type = types.Array(types.float64, 1, "C")
matrix_type = types.Array(types.float64, 2, "C")
integers_type = types.Array(types.int64, 1, "C")
KINDS = {
    "int": types.int64,
    "float": types.float64,
    "Floats": vector_type,
    "Matrix": matrix_type,
    "Integers": integers_type,
}


def tuple_type(kind: Any, **others: Any) -> Any:
    """What a signature calls a named tuple: by the words of its fields, or by the types of ``others`` with their names."""
    words = {name: word for part in kind.__mro__[::-1] for name, word in vars(part).get("__annotations__", {}).items()}
    own = [others.get(name) or KINDS[words[name].__forward_arg__] for name in kind._fields]
    return types.NamedTuple(own, kind)


system_type = typeof(System(0, 0.0, 0.0, 0.0, 0, Drive()))
numbers_type = types.CPointer(types.float64)
rhs_type = types.FunctionType(types.void(types.float64, numbers_type, numbers_type, types.voidptr))
system_at = pointer_to(value_type(system_type))
