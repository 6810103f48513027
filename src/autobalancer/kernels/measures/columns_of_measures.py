"""The numbers of a row of measures, in their order: those of the table of measures by name, then what judges the run."""

from __future__ import annotations

import math

COLUMNS = (
    "peak_deflection",
    "peak_speed",
    "peak_time",
    "time_near_peak",
    "time_at_resonance",
    "residual_vibration",
    "static_deflection",
    "vibration",
    "vibration_without_balls",
    "velocity_rms",
    "residual_unbalance",
    "residual_share",
    "support_force",
    "settling_time",
    "settled_at",
    "break_away_speed",
    "break_away_time",
    "stalled_time",
    "stalled_balls",
    "greatest_ball_speed",
    "impacts",
    "impact_speed",
    "impact_power",
    "greatest_impulse",
    "late_impact_rate",
    "late_impact_power",
    # how the run ended: the stepper's word, time and speed, and what the verdict asks for
    "status",
    "verdict",
    "end_time",
    "end_speed",
    "speed_changes",
    "goes_round",
    "vibration_before",
    "vibration_after",
    "creeps",
    "vibration_to_come",  # change, over its mean at the end
    "settling_since_release",  # settling_time, counted from the last release
)
WIDTH = len(COLUMNS)
(
    PEAK, PEAK_SPEED, PEAK_TIME, NEAR_PEAK, AT_RESONANCE, RESIDUAL, STATIC, VIBRATION, WITHOUT, VELOCITY, LEFT, SHARE, FORCE,
    SETTLING, SETTLED_AT, BREAK_AWAY_SPEED, BREAK_AWAY_TIME, STALLED, STALLED_BALLS, BALL_SPEED,
    IMPACTS, IMPACT_SPEED, IMPACT_POWER, IMPULSE, LATE_RATE, LATE_POWER,
    STATUS, VERDICT, END, END_SPEED, CHANGES, ROUND, BEFORE, AFTER, CREEPS, TO_COME, SINCE_RELEASE,
) = range(WIDTH)  # fmt: skip


# Numbers by which measures judge; no compiled code, so that whoever shows them loads none.


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
# places among the measures of impacts
OF_COUNT, OF_SPEED, OF_POWER, OF_IMPULSE, OF_LATE_RATE, OF_LATE_POWER, OF_IMPACTS = range(7)
