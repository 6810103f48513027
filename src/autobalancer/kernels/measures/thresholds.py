"""Numbers by which measures judge, and words of a row as numbers; no compiled code, so that whoever shows them loads none."""

from __future__ import annotations

import math

SETTLED = math.radians(2.0)  # a ball within this of the angle to which it goes has settled, rad
LAST = 0.05  # share of a run at its end in which the residual vibration is taken, and for which a settled ball has been there
STALL_MARGIN = 0.02  # a ball can be called stalled only this far (relative) above a whirl of the rotor
STALL_SHARE = 1.0 / 3.0  # and while it has come less than this share of the way from there to the rotor speed ...
STALL_LEAST = 0.5  # ... and has more than this share of the speed of the whirl
CONSTANT = 1e-3  # a speed that differs by less (relative) from its last value is constant
TREND = 0.2  # a mean that changes by less than this share of the spread of its values does not drift
LEAST_DRIFT = 1e-2  # a change of less than this share of the tolerance of a ball is none
LEAST_CHANGE = 1e-3  # the same of a vibration, of itself
LATE = 0.8  # share of a run after which its vibration is followed to where it goes
NEAR_CRITICAL = 0.1  # a rotor speed within this share of the critical speed is in its resonance
SAME_SPEED = 0.01  # relative change over the last twentieth of a run
SAME_VIBRATION = 1.2  # factor between the last two twentieths, and between the end of a run and where it goes
UNEVEN = 2.0  # the same where a ball goes round in the rotor, which is never even
LIMITS = (0.1, 0.9, 1.1)  # of the vibration with balls over that without: balanced, partly balanced, not balanced
SAME_MOTION = 1e-3  # relative singular value below which motions of two balls are one motion
FASTEST = 1e12  # rad/s; a run that came here is on its way out of all numbers

# from where the time of settling counts
NOWHERE, START, JUMP, RUN_UP, RELEASE = range(5)
# why there is no verdict
STEADY, SPEED_CHANGES, VIBRATION_CHANGES = range(3)
# verdicts; the first four in the order of LIMITS
BALANCED, PARTLY, NOT, WORSE, NO_VERDICT, NOT_SETTLED = range(6)
# how the motion of a machine with its balls held is found: not at all, from its matrices, by iteration in Python
UNKNOWN, LINEAR, ITERATED = range(3)
