"""When a machine counts as balanced: one rule for balls in races, deep chambers, runs and studies.

The vibration with balls, at the place where it is greatest, is compared with the vibration of the same machine with its
balls spread evenly and held, where that is greatest. Up to a tenth of it is *balanced*, up to nine tenths *partly
balanced*, up to eleven tenths *not balanced*; more is *worse than without balls*. There is no verdict on a run that has
not come to its end, whose speed changes by more than a hundredth in its last twentieth, or whose vibration in the last two
twentieths differs by more than a fifth, or by a factor of two where a ball goes round in the rotor. Below a tenth of that
without balls it may change.
"""

from __future__ import annotations

import numpy as np
import xarray as xr

BALANCED, PARTLY, NOT, WORSE = "balanced", "partly balanced", "not balanced", "worse than without balls"
NO_VERDICT = "no verdict"
LIMITS = ((0.1, BALANCED), (0.9, PARTLY), (1.1, NOT))
SAME_SPEED = 0.01  # relative change over the last twentieth of a run
SAME_VIBRATION = 1.2  # factor between the last two twentieths
UNEVEN = 2.0  # the same where a ball goes round in the rotor, which is never even


def verdict_word(ratio: float) -> str:
    """The word for the vibration with balls over that without; ``"no verdict"`` for nan."""
    if np.isnan(ratio):
        return NO_VERDICT
    return next((word for limit, word in LIMITS if ratio <= limit), WORSE)


def changing_because(run: xr.Dataset, without_balls: float) -> str:
    """Why a run has no verdict: it did not finish, or its speed or vibration still changes; else an empty text.

    Parameters
    ----------
    run
        A run of balls in races.
    without_balls
        Greatest vibration without balls (m): below a tenth of it a vibration may change.
    """
    if run.attrs.get("outcome", "finished") != "finished":
        return f"the run did not finish: {run.attrs.get('outcome_text', run.attrs['outcome'])}"
    end = float(run.attrs["end_time"])
    time, speed = next(
        (
            (run[t].values, run[s].values)
            for t, s in (("time", "speed"), ("envelope_time", "envelope_speed"))
            if s in run
        ),
        (run["turn_time"].values, run["turn_speed"].values),
    )
    late = speed[time >= 0.95 * end]
    if late.size and np.ptp(late) > SAME_SPEED * np.abs(late).max():
        return "the speed still changes in the last twentieth of the run; run longer"
    before, after = (_vibration(run, begin * end, (begin + 0.05) * end) for begin in (0.9, 0.95))
    greater, smaller = max(before, after), min(before, after)
    uneven = _ball_goes_round(run, 0.95 * end)
    if greater > LIMITS[0][0] * without_balls and greater > (UNEVEN if uneven else SAME_VIBRATION) * smaller:
        return "the vibration still changes in the last tenth of the run; run longer"
    return ""


def _ball_goes_round(run: xr.Dataset, begin: float) -> bool:
    """Whether a ball makes a turn in the rotor from a time to the end."""
    for time, angle in (("time", "ball_angle_in_rotor"), ("envelope_time", "envelope_ball_angle_in_rotor")):
        if angle in run:
            late = run[angle].values[run[time].values >= begin]
            return bool(late.size and (np.abs(late[-1] - late[0]) > 2.0 * np.pi).any())
    return False


def _vibration(run: xr.Dataset, begin: float, end: float) -> float:
    """Vibration at the reference station between two times from the envelope, m; nan without one."""
    if "envelope_high" not in run:
        return np.nan
    inside = (run["envelope_time"].values > begin) & (run["envelope_time"].values <= end)
    if not inside.any():
        return np.nan
    high, low = float(run["envelope_high"].values[inside].max()), float(run["envelope_low"].values[inside].min())
    return high if run.attrs.get("axis", "vertical") == "vertical" else 0.5 * (high - low)
