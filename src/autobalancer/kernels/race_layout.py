"""Rows of numbers behind the loads in ``System.rotor``: balls on real races, and what shakes the machine.

They are there only where something of this is asked for; ``BALL_ROWS`` of the header says where.
"""

from __future__ import annotations

# columns of a ball
(
    MASS_, STRETCH, ROLL, OWN_SPIN, ORBIT_, CENTER_X, CENTER_Y, PLACE_,
    ROLLING, ADHERENCE, MODE, NEED, NORMAL,
    VISCOUS, DRAG_CURVE, SLIPSTREAM, SHAPE, MODES, FIRST_MODE, MODE_NUMBERS, LAG_TABLE,
    RAW_PUSH, RAW_SPIN, RAW_LEAN_X, RAW_LEAN_Y, NORMAL_PUSH, NORMAL_TWIST, NORMAL_X, NORMAL_Y,
    RACE_COLUMNS,
) = range(30)  # fmt: skip
# MASS_ effective; STRETCH inertia of the ball angle over the square of the path per angle; ROLL and OWN_SPIN j m r and
# j m r^2; MODE +1 or -1 rolling that way, 0 at rest on the race; NEED torque that holds a ball at rest; NORMAL force on it;
# VISCOUS drag force over velocity; DRAG_CURVE, SLIPSTREAM, SHAPE, MODE_NUMBERS, LAG_TABLE places of further numbers, 0 if none

# a drag curve: first log velocity, step, count, then (log force, slope) pairs; slopes per step
CURVE_FIRST, CURVE_STEP, CURVE_COUNT, CURVE_VALUES = range(4)
# the shape of a race: number of harmonics, then cosine and sine amplitudes of its radius
# numbers of relaxation modes: rates, then gains
# a ball in a slipstream: Reynolds number per speed and its limit, diameters per angle and how many the fit reaches, number of
# the ball and of how many others there are, coefficients of the fit by powers of the Reynolds number, numbers of the others
LINE_SPEED_POWERS, LINE_DISTANCE_POWERS = 3, 6
LINE_PER_SPEED, LINE_REYNOLDS, LINE_PER_ANGLE, LINE_REACH, LINE_OWN, LINE_OTHERS, LINE_FIT = range(7)
LINE_FIRST = LINE_FIT + LINE_SPEED_POWERS * LINE_DISTANCE_POWERS
# a table over time: start, step, count, then (value, slope) pairs; slopes per step
TABLE_START, TABLE_STEP, TABLE_COUNT, TABLE_VALUES = range(4)

# excitations: count, then for each: kind, whether balls feel it (base motion), amplitude along x and y (real, imaginary
# part of e^(i w t)), frequency, whether the frequency counts in turns of the rotor, table of x, table of y, then the
# vectors of accelerations of the coordinates per unit along x and along y
HARMONIC, RECORDED = 0, 1
(SHAKE_KIND, FELT, AMP_XR, AMP_XI, AMP_YR, AMP_YI, SHAKE_FREQUENCY, BY_ANGLE, TABLE_X, TABLE_Y, SHAKE_VECTORS) = range(
    11
)
