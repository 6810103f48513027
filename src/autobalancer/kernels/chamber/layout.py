"""Where the numbers of chambers, balls and body are in their arrays. Axes: x along the rotor, y, z across it."""

from __future__ import annotations

from numba import types

# a row of ``balls``: position, velocity, spin, force, moment, rates of velocity and spin at the last evaluation
POS, VEL, SPIN, FORCE, MOMENT, ACC, SPIN_ACC = 0, 3, 6, 9, 12, 15, 18
RADIUS, MASS, INERTIA, KIND, CHAMBER = 21, 22, 23, 24, 25
TOUCHES = 26  # race, wall at +x, wall at -x, inner wall: 1 in contact
K_RACE, K_FLAT, K_INNER = 30, 31, 32  # N/m^1.5
BALL_COLUMNS = 34

# ``springs``: stretch of the tangential springs at race, walls and inner wall, three numbers each
WALL_SPRINGS = 12

# a row of ``chambers``: position along the rotor, radius, half depth, drag per speed and per speed squared, radius of the
# inner wall (minus infinity without one)
CENTER, WALL_RADIUS, HALF_DEPTH, DRAG, SQUARE_DRAG, INNER_RADIUS = range(6)
CHAMBER_COLUMNS = 6

# ``host``: body displacement and rotation, rotor angle (7); their rates; second rates in use and new
Q, V, A, NEW = 0, 7, 14, 21
P1, P2 = 28, 31  # forces of the bearings on the rotor, N
CONSTRAINT = 34  # forces and moments that hold locked coordinates, about the rotor's middle (6)
TORQUE, BEARING_TORQUE = 40, 41  # on the rotor, of the drive and against the bearings
CONTACT = 42  # sums over the balls: force (3), moment about the axis of the rotor, about y, about z
HOST = 48

# ``number``: everything constant
(
    STEP, GRAVITY_X, GRAVITY_Y, GRAVITY_Z, FRICTION, RESTITUTION_SQUARED, ROLLING_ARM, SLOW, LAW, DAMPING_RATIO,
    SHEAR_RATIO, DRIVEN, RATED, OVERLOAD, SYNCHRONOUS, BREAKDOWN, NECK, BEARING_1, BEARING_2, ROTOR_MASS, POLAR,
    TRANSVERSE, U_C, U_S, COUPLE_C, COUPLE_S, SKIN, ROTOR_DAMPING,
) = range(28)  # fmt: skip
NUMBERS = 28
RESTITUTION, HISTORY = 0.0, 1.0  # LAW

# ``power``: what is lost per second, and the energy stored in contacts now
(
    P_MOTOR, P_CONTACT, P_FRICTION, P_ROLLING, P_SUPPORTS, P_BEARINGS, P_DRAG, STORED,
) = range(8)  # fmt: skip
POWERS = 8

# ``counts``
BEGUN_BALL, BEGUN_WALL, PAIRS, PIECE, STEPS_DONE, REBUILDS, OVERFLOW = range(7)
COUNTS = 8

# ``greatest``: contact force since the last sample, way of the fastest ball since the pairs were listed
FORCE_SEEN, WAY = 0, 1

vector = types.float64[::1]
matrix = types.float64[:, ::1]
whole = types.int64[::1]
short = types.int32[::1]
