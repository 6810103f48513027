"""What happens to the balls of a film: impacts, release and capture, under the names that runs use."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
SURE = 4.0  # standard deviations


class Contacts(NamedTuple):
    """Impacts between balls in the order of time."""

    time: Floats  # s
    speed: Floats  # m/s, at which they approached
    ball: NDArray[np.int64]  # from 1
    partner: NDArray[np.int64]


def impacts(time: Floats, angle: Floats, deviation: Floats, contact: float, orbit: float) -> Contacts:
    """Where neighbors that approach each other are found farther apart than this would lead them.

    From the last two pictures before, the gap is followed to the contact angle; an impact is where it gets there before the next
    picture, and the gap of this picture is wider than it would be without.
    """
    n = angle.shape[1]
    rows: list[tuple[float, float, int, int]] = []
    for i in range(n if n > 2 else n - 1):
        j = (i + 1) % n
        both = np.flatnonzero(np.isfinite(angle[:, i]) & np.isfinite(angle[:, j]))
        t = time[both]
        gap = (angle[both, j] - angle[both, i]) % (2.0 * np.pi)
        if n == 2:
            gap = np.minimum(gap, 2.0 * np.pi - gap)
        spread = np.hypot(deviation[both, i], deviation[both, j])
        before = -2  # number of the picture before the last impact: the slope over an impact is none
        for k in range(1, both.size - 1):
            step, after = t[k] - t[k - 1], t[k + 1] - t[k]
            slope = (gap[k] - gap[k - 1]) / step
            unsure = np.hypot(spread[k], spread[k - 1]) / step
            if k == before + 1 or slope > -max(SURE * unsure, 1e-6):
                continue
            until = (contact - gap[k]) / slope
            ahead = gap[k] + slope * after
            if -step < until <= after and gap[k + 1] - ahead > SURE * np.hypot(spread[k + 1], unsure * after):
                rows.append((t[k] + max(until, 0.0), -slope * orbit, i + 1, j + 1))
                before = k
    rows.sort()
    columns = list(zip(*rows, strict=True)) or [(), (), (), ()]
    return Contacts(
        np.array(columns[0], np.float64),
        np.array(columns[1], np.float64),
        np.array(columns[2], np.int64),
        np.array(columns[3], np.int64),
    )


def stalls(time: Floats, speed: Floats, rate: Floats, critical: float) -> list[tuple[float, str]]:
    """Times at which balls are captured at the critical speed, and released from it.

    A ball is stalled while its speed in space is three times nearer to the critical speed than to the rotor speed, at least
    2 % above the critical speed, the rule of ``release_speed``; it is captured where that begins after it ran with the rotor,
    and released where it runs with the rotor again.
    """
    found: list[tuple[float, str]] = []
    for i in range(rate.shape[1]):
        known = np.flatnonzero(np.isfinite(rate[:, i]) & np.isfinite(speed))
        w, own = speed[known], speed[known] + rate[known, i]
        stalled = (w > 1.02 * critical) & (3.0 * np.abs(own - critical) < np.abs(own - w))
        with_rotor = np.abs(rate[known, i]) < 0.05 * np.abs(w)
        state = ""
        for k, row in enumerate(known):
            if stalled[k]:
                if state == "with":
                    found.append((float(time[row]), f"ball {i + 1} captured at the critical speed"))
                state = "stalled"
            elif with_rotor[k]:
                if state == "stalled":
                    found.append((float(time[row]), f"ball {i + 1} released"))
                state = "with"
    return sorted(found)
