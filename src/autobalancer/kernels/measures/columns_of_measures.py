"""The measures that compiled loops take from motions, and the numbers of a row of all measures, in their order.

A new measure of a motion is an entry here, in the table of its motion, and the line of a loop that fills it by name:
``rotor_measures``, ``ball_measures``, ``place_measures`` or ``impact_measures`` in ``record_series.py``. Runs, sweeps and the
documentation take it from here.
"""

from __future__ import annotations

import math
from collections import namedtuple
from typing import Any, NamedTuple

HERE = "the reference station"  # in a text; a run has the name of its own there
LATE_TURNS = "in the last revolutions"


class OfMotion(NamedTuple):
    """One of them. Of several numbers a sweep keeps the greatest, if ``of_all`` says what it is; ``known``: nan left out."""

    name: str
    unit: str
    text: str
    of_all: str = ""
    known: bool = False


OF_ROTOR = (  # from the envelope
    OfMotion("peak_deflection", "m", f"greatest deflection at {HERE}"),
    OfMotion("peak_speed", "rad/s", f"rotor speed at the greatest deflection at {HERE}"),
    OfMotion("peak_time", "s", f"time of the greatest deflection at {HERE}"),
    OfMotion("time_near_peak", "s", f"time with more than half of the greatest deflection at {HERE}"),
    OfMotion("time_at_resonance", "s", "time with a rotor speed within 10 % of a critical speed"),
)
OF_PLACES = (  # and of supports, whose forces are measured in the same way
    OfMotion(
        *("static_deflection", "m", f"static deflection {LATE_TURNS}"),
        f"greatest static deflection of all places {LATE_TURNS}",
    ),
    OfMotion(
        *("vibration", "m", "greatest distance from the mean position at the end of the run"),
        "greatest vibration of all places at the end of the run",
    ),
    OfMotion("vibration_rms", "m", f"root mean square of the vibration {LATE_TURNS}"),
    OfMotion(
        *("velocity_rms", "m/s", f"root mean square of the velocity {LATE_TURNS}"),
        f"greatest root mean square of the velocity of all places {LATE_TURNS}",
    ),
)
OF_BALLS = (
    OfMotion(
        *("break_away_speed", "rad/s", "break-away speed in the run"),
        "greatest break-away speed of a stalled ball",
        known=True,
    ),
    OfMotion(
        *("break_away_time", "s", "time in the run at which the stalled ball breaks away"),
        "time in the run at which the last stalled ball breaks away",
        known=True,
    ),
    OfMotion("stalled_time", "s", "time for which the ball is stalled", "longest time for which a ball is stalled"),
    OfMotion(
        *("greatest_ball_speed", "rad/s", "greatest speed of the ball in space"), "greatest speed of a ball in space"
    ),
)
OF_IMPACTS = (
    OfMotion("impacts", "", "impacts of balls on each other, partitions and walls"),
    OfMotion("impact_speed", "m/s", "mean speed of the impacts"),
    OfMotion("impact_power", "W", "mean power that impacts dissipate over the run"),
    OfMotion("greatest_impulse", "N s", "impulse of the hardest impact"),
    OfMotion("late_impact_rate", "1/s", "impacts a second at the end of the run"),
    OfMotion("late_impact_power", "W", "power that impacts dissipate at the end of the run"),
)

# A row: what is measured, then how the run ended: the stepper's word, time and speed, and what the verdict asks for.


OTHERS = (
    *("held_at_critical_speed", "residual_vibration", "vibration_without_balls"),
    *("residual_unbalance", "residual_share", "support_force"),
)
OTHERS_OF_BALLS = ("settling_time", "settled_at", "stalled_balls")
ENDED = (
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


def _names(*groups: tuple[OfMotion, ...]) -> tuple[str, ...]:
    return tuple(one.name for group in groups for one in group)


MEASURED = (*_names(OF_ROTOR, OF_PLACES), *OTHERS, *OTHERS_OF_BALLS, *_names(OF_BALLS, OF_IMPACTS))
COLUMNS = (*MEASURED, *ENDED)
WIDTH = len(COLUMNS)
# where a number stands, by name: ``COLUMN.peak_time`` in a row, the others in what the loops find of places and balls
by_name: Any = namedtuple  # which type checkers want to read
Column, Place, Ball = by_name("Column", COLUMNS), by_name("Place", _names(OF_PLACES)), by_name("Ball", _names(OF_BALLS))
COLUMN, PLACE, BALL = Column(*range(WIDTH)), Place(*range(len(OF_PLACES))), Ball(*range(len(OF_BALLS)))
KNOWN = tuple(one.known for one in OF_BALLS)


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
