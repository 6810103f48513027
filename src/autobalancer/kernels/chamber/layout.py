"""Where the numbers of chambers, balls and body are in their arrays. Axes: x along the rotor, y, z across it."""

from __future__ import annotations

from numba import types

# a row of ``balls``: what the search for contacts reads comes first; force, moment, rates are those of the last evaluation
RADIUS, POS, VEL, SPIN = 0, 1, 4, 7
MASS, INERTIA, KIND, CHAMBER = 10, 11, 12, 13
INVERSE_MASS, INVERSE_INERTIA = 14, 15
FORCE, MOMENT, ACC, SPIN_ACC = 16, 19, 22, 25
K_RACE, K_FLAT = 28, 29  # N/m^1.5
TOUCHES = 30  # sum of 1 at the race, 2 at the wall at +x, 4 at the wall at -x, 8 at the inner wall
K_INNER = 31  # N/m^1.5
BALL_COLUMNS = 32

# ``block``: contacts that are evaluated at once, one to a column, so that vector registers take several of them
BLOCK = 32
LINE = 0  # from the ball to its partner, of any length (3)
OFFSET, TAKEN = 3, 4  # overlap is OFFSET + TAKEN times the length of LINE
STIFFNESS, LIGHTNESS, ROLL_RADIUS = 5, 6, 7  # N/m^1.5, sum of inverse masses, radius that rolls
SHRINK = 8  # arms shrink by this times the overlap
RATE, TURN, ROLL = 9, 12, 15  # relative velocity of the middles, sum of radius times spin, relative spin (3 each)
STRETCH = 18  # of the tangential spring (3)
PUSH, TWIST, RESIST = 21, 24, 27  # force, normal times force, rolling moment on the ball (3 each)
ARM = 30  # over the radius
LOST, SLID, ROLLED, HELD, NORMAL = 31, 32, 33, 34, 35  # losses, energy, normal force
ONE, TWO, PLACE = 36, 37, 38  # ball; its partner, -1 for a wall; number of the pair or wall
BLOCK_ROWS = 39

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
TOO_DENSE, LOST_BALLS = 1, 2  # OVERFLOW: more pairs than there is room for, balls far outside

# ``greatest``: contact force since the last sample, way of the fastest ball since the pairs were listed
FORCE_SEEN, WAY = 0, 1

vector = types.float64[::1]
matrix = types.float64[:, ::1]
whole = types.int64[::1]
short = types.int32[::1]
