"""Rows of numbers behind the loads in ``System.rotor`` for contact-resolved balls, and their part of the state vector.

The header's ``BALL_ROWS`` says where the rows begin. Behind the state of kernels/system.py each ball has

    x, y        position of its center from the center of the race     m        in the rotor
    vx, vy      velocity as seen from the rotor                        m/s      in the rotor
    spin        as seen from the rotor                                 rad/s
    hold        deflection of the spring of adherence                  m

and then come the relaxation modes of the fluids. The ball angles and speeds among the first states follow from x and y;
they are carried along for whoever reads these.
"""

from __future__ import annotations

BALL_X, BALL_Y, BALL_VX, BALL_VY, BALL_SPIN, HOLD, BALL_STATES = range(7)

# columns of a ball
(
    MASS_, EXTRA, SPIN_INERTIA, RADIUS, ORBIT_, CENTER_X, CENTER_Y, PLACE_, RACE_,
    GAP, HERTZ, WALL_STIFFNESS, WALL_DAMPING, INNER_STIFFNESS, INNER_DAMPING, BALL_STIFFNESS, BALL_DAMPING,
    SLIDING, PEAK, SLIP_SPEED, PEAK_SPEED, ROLLING_ARM, REST_SPEED, ADHERENCE, HOLD_STIFFNESS, HOLD_DAMPING,
    FLOOR, WEIGHT, BALL_SLIDING,
    VISCOUS, DRAG_CURVE, SLIPSTREAM, MODES, FIRST_MODE, MODE_NUMBERS, LAG_TABLE, SHAPE, PARTITIONS,
    FORCE_X, FORCE_Y, SPIN_TORQUE, HOLD_RATE,
    RESOLVED_COLUMNS,
) = range(43)  # fmt: skip
# MASS_ effective; EXTRA the mass by which its inertia in motion relative to the chamber exceeds it; RACE_ number of its race,
# -1 where balls pass through each other; GAP from inner to outer wall for the ball center, infinite without inner wall;
# HERTZ 1 or 0; BALL_STIFFNESS with Hertz for a pair of unit radius, BALL_DAMPING per square root of stiffness times mass;
# ROLLING_ARM a of the wall force; WEIGHT on the floor; VISCOUS drag force over velocity; SHAPE and
# SLIPSTREAM as in race_layout.py; PARTITIONS place of the following; from FORCE_X on work space

# the partitions between which a ball runs: the angle between them, then for the one behind and the one ahead of it the normal
# towards the ball, then stiffness and damping of both
PART_MIDDLE, PART_BEHIND, PART_AHEAD, PART_STIFFNESS, PART_DAMPING, PART_NUMBERS = 0, 1, 3, 5, 6, 7
