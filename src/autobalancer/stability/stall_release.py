"""The rotor speeds at which balls can hang at each resonance of any rotor.

The search over the speed of the rotor takes the balance of :mod:`autobalancer.stability.stall_holds`, that of the mode
alone. The end of a range is refined in :mod:`autobalancer.stability.stall_fold`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autobalancer.stability.stall_fold import Fold
from autobalancer.stability.stall_holds import holds, members
from autobalancer.stability.stalled_groups import Loads
from autobalancer.stability.whirling import Whirling

ABOVE = (1e-4, 1e-3, 5e-3, 0.02, 0.08)  # shares above a critical speed at which stalling is asked for
RATIO = 1.12  # of neighboring speeds
ALIKE = 1e-6
JUMP = 0.05  # a margin that ends at more than this does not end: two modes have changed places


@dataclass(frozen=True)
class HangingRange:
    """Rotor speeds between which balls can hang at one resonance, rad/s, and their ``whirl`` speed at the end.

    ``end`` is infinite if they still do at the highest speed that was asked for. ``closed``: balls break away there;
    ``refined``: it is a fold of the whole balance, not of that of the mode alone.
    """

    mode: int  # of those with forward whirl that the stations see, from 0
    begin: float
    end: float
    whirl: float
    closed: bool = True
    refined: bool = True

    def holds(self, speed: float) -> bool:
        """Whether a rotor speed is in the range."""
        return self.begin <= speed <= self.end

    def same(self, other: HangingRange) -> bool:
        """Whether both end in one fold, as they do where modes lie close to each other."""
        near = abs(self.end - other.end) <= ALIKE * self.end if np.isfinite(self.end) else self.end == other.end
        return near and abs(self.whirl - other.whirl) <= ALIKE * self.whirl


def hanging_ranges(rotor: Whirling, loads: Loads, top: float, limit: float = np.inf) -> list[HangingRange]:
    """All ranges up to the rotor speed ``top`` (rad/s), resonance by resonance; not refined if they begin above ``limit``."""
    critical = rotor.st.critical_speeds
    start = 0.98 * min(
        [*critical, *rotor.modes(0.0).frequency[:1], top]
    )  # below, no forward whirl is slower than the rotor
    even = np.geomspace(start, top, max(int(np.log(top / start) / np.log(RATIO)), 2))
    near = [w * (1.0 + share) for w in critical[:6] if w <= limit for share in ABOVE]
    speeds = np.unique([w for w in (*even, *near) if w <= top])
    found = [holds(loads, rotor.modes(speed), speed) for speed in speeds]
    result = []
    for k in range(max(margin.size for margin in found)):
        hangs = np.array([k < margin.size and margin[k] > 0.0 for margin in found])
        edges = np.flatnonzero(np.diff(np.concatenate([[False], hangs, [False]])))
        for first, after in edges.reshape(-1, 2):
            begin = float(speeds[first])
            if first and k < found[first - 1].size and np.isfinite(found[first - 1][k]):
                begin = _edge(rotor, loads, k, float(speeds[first - 1]), begin)
            if after == speeds.size:
                result.append(HangingRange(k, begin, np.inf, float(rotor.modes(top).frequency[k])))
                continue
            end = _edge(rotor, loads, k, float(speeds[after - 1]), float(speeds[after]))
            result += (
                [HangingRange(k, begin, end, float(rotor.modes(end).frequency[k]))]
                if begin > limit
                else _ended(rotor, loads, k, begin, end)
            )
    return [one for i, one in enumerate(result) if not any(one.same(other) for other in result[:i])]


def reached(ranges: list[HangingRange], critical: tuple[float, ...]) -> list[HangingRange]:
    """The ranges into which a slow run-up leads: from a critical speed, or out of another one that ends in it."""
    found = [
        one for one in ranges if any(one.begin <= w * (1.0 + 2.0 * ABOVE[-1]) <= 1.2 * one.begin for w in critical)
    ]
    for one in found:  # grows as it is walked through
        found += [other for other in ranges if other not in found and other.holds(one.end) and other.whirl > one.whirl]
    return found


def _margin(rotor: Whirling, loads: Loads, k: int, speed: float) -> float:
    found = holds(loads, rotor.modes(speed), speed)
    return float(np.clip(found[k], -1.0, None)) if k < found.size else -1.0


def _edge(rotor: Whirling, loads: Loads, k: int, low: float, high: float) -> float:
    """Between a speed at which balls hang at mode k and one at which they do not."""
    from scipy.optimize import brentq

    return float(brentq(lambda speed: _margin(rotor, loads, k, speed), low, high, xtol=1e-8 * high))


def _ended(rotor: Whirling, loads: Loads, k: int, begin: float, end: float) -> list[HangingRange]:
    """The range with its end refined; none if balls pass the resonance without a fold."""
    low = end if _margin(rotor, loads, k, end) > 0.0 else end * (1.0 - 1e-7)
    modes = rotor.modes(low)
    whirl = float(modes.frequency[k])
    if _margin(rotor, loads, k, low) > JUMP:
        return [HangingRange(k, begin, low, whirl, closed=False)]
    fold = Fold(rotor, loads.some(members(loads, modes, low, k)), k, low)
    top = fold.found()
    if fold.passed:
        return []
    return [HangingRange(k, begin, *(top or (low, whirl)), refined=top is not None)]
