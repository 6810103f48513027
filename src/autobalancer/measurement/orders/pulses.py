"""Pulses of a tacho: instants at which its signal crosses a threshold, and those that are missing or too many."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.results.signals.signals import LONG, extremes, pieces

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]
HYSTERESIS = 0.3  # of the height of a pulse
LEAST_CONTRAST = 6.0  # height of the pulses over the scatter at their feet
NEIGHBORS = 4  # intervals on each side from which the length of one is foreseen
EXTRA, MISSING = 0.6, 1.5  # pulses in an interval, as foreseen, below and above which it is not one
MOST_ODD = 0.1  # share of odd intervals above which the number of pulses a turn is probably wrong
LEAST = 4  # pulses


@dataclass(frozen=True, eq=False)
class Pulses:
    """Pulses that are kept.

    Attributes
    ----------
    times
        Instants, s; (pulse,).
    counts
        Number of each, counted from 0; where a pulse is missing, a number is left out.
    missing, extra
        Instants after which pulses are missing, and of pulses that were dropped, s.
    """

    times: Floats
    counts: Whole
    missing: Floats
    extra: Floats


def crossings(
    t: Floats, values: Any, *, threshold: float | None = None, hysteresis: float | None = None, falling: bool = False
) -> Floats:
    """Instants at which a signal rises through a threshold (or falls), between samples on a straight line.

    Parameters
    ----------
    t, values
        Even instants (s) and samples, an array or a channel. Of a long record the foot and the top of the pulses are those of
        evenly chosen samples.
    threshold
        By default the middle between the foot and the top of the pulses.
    hysteresis
        So far must the signal have been on either side, in all; by default three tenths of the height.
    falling
        Take falling edges.

    Raises
    ------
    QuestionError
        If there are no pulses.
    """
    sign = -1.0 if falling else 1.0
    low, high = extremes(values)
    if low == high:
        raise QuestionError(f"tacho: the signal is constant, {low:.4g}; there are no pulses")
    least, most = sorted((sign * low, sign * high))
    middle, every = 0.5 * (least + most), -(-values.shape[0] // LONG)
    some = sign * np.concatenate([part[-first % every :: every] for first, part in pieces(values)])
    foot = float(np.median(some[some < middle])) if (some < middle).any() else least
    top = float(np.quantile(some[some >= middle], 0.9)) if (some >= middle).any() else most
    level = 0.5 * (foot + top) if threshold is None else sign * threshold
    half = 0.5 * (HYSTERESIS * (top - foot) if hysteresis is None else hysteresis)
    if not least < level - half or not most >= level + half:
        raise QuestionError(f"tacho: no pulse crosses the threshold; the signal is between {low:.4g} and {high:.4g}")
    state, up, found = (
        0,
        -1,
        [],
    )  # of the last sample that was clearly above or below, and the last step through the level
    for first, part in pieces(values, 1):
        v = sign * part
        own = v if first + v.size == values.shape[0] else v[:-1]
        now = np.where(own >= level + half, 1, np.where(own < level - half, -1, 0))
        known = np.flatnonzero(now)
        before = np.concatenate([[state], now[known]])
        rises = known[(before[1:] == 1) & (before[:-1] == -1)]
        ups = np.flatnonzero((v[:-1] < level) & (v[1:] >= level)) + first
        ups = np.concatenate([[up], ups]).astype(np.int64)
        at = ups[np.searchsorted(ups, rises + first, side="left") - 1]
        inside = at[at >= first] - first
        steps = [(v[inside], v[inside + 1])]
        if inside.size < at.size:  # the step stands in a piece before
            steps.insert(0, tuple(sign * np.asarray(values[int(at[0]) : int(at[0]) + 2], np.float64)[:, None]))
        a, b = (np.concatenate(side) for side in zip(*steps, strict=True))
        found.append(t[at] + (t[at + 1] - t[at]) * (level - a) / (b - a))
        state, up = int(before[-1]), int(ups[-1])
    return np.concatenate(found)


def repaired(times: Floats, *, repair: bool = True) -> Pulses:
    """Count pulses; where one is missing, count on, and drop those that are too many.

    The speed in an interval is foreseen from its four neighbors on each side: the median of the straight lines through all
    pairs of them. This tells a missing pulse from a rotor that just gathers speed.

    Raises
    ------
    QuestionError
        If there are fewer than four pulses, too many odd ones, or any and ``repair`` is false.
    """
    if times.size < LEAST:
        raise QuestionError(f"tacho: {times.size} pulses; at least {LEAST} are needed")
    kept, extra = _without_extra(times)
    shares = _shares(kept)
    whole = np.maximum(1, np.where(shares > MISSING, np.rint(shares), 1.0)).astype(np.int64)
    for _ in range(2):  # once more with the speeds of the intervals whose numbers are now known
        shares = _shares(kept, whole)
        whole = np.maximum(1, np.where(shares > MISSING, np.rint(shares), 1.0)).astype(np.int64)
    missing = kept[:-1][whole > 1]
    odd = missing.size + extra.size
    if odd and not repair:
        raise QuestionError(f"tacho: {_odd_text(missing, extra)}; leave out repair=False to count on over them")
    if odd > max(2, MOST_ODD * times.size):
        raise QuestionError(
            f"tacho: of {times.size} pulses {_odd_text(missing, extra)}; is the threshold right, and are the marks evenly spaced?"
        )
    return Pulses(kept, np.concatenate([[0], np.cumsum(whole)]), missing, extra)


def odd_remarks(pulses: Pulses) -> list[str]:
    """Sentences on what was repaired; none where nothing was."""
    if not pulses.missing.size + pulses.extra.size:
        return []
    return [f"tacho: {_odd_text(pulses.missing, pulses.extra)}; counted on over them"]


def _odd_text(missing: Floats, extra: Floats) -> str:
    texts = []
    for times, word in ((missing, "missing after"), (extra, "too many at")):
        if times.size:
            some = ", ".join(f"{time:.6g} s" for time in times[:4])
            texts.append(f"{times.size} {word} {some}" + (f" and {times.size - 4} more" if times.size > 4 else ""))
    return ", ".join(texts)


def _without_extra(times: Floats) -> tuple[Floats, Floats]:
    """Pulses without those between which the rotor would have turned much faster than before and after."""
    kept, dropped = times, []
    for _ in range(times.size):
        shares = _shares(kept)
        short = np.flatnonzero(shares < EXTRA)
        if not short.size or kept.size <= LEAST:
            break
        i = int(short[np.argmin(shares[short])])
        sides = [  # the pulse before or after the short interval, and what its neighbor would become without it
            (abs(shares[i] + shares[j] - np.rint(shares[i] + shares[j])), end)
            for j, end in ((i - 1, i), (i + 1, i + 1))
            if 0 <= j < shares.size
        ]
        _, end = min(sides)
        dropped.append(float(kept[end]))
        kept = np.delete(kept, end)
    return kept, np.array(sorted(dropped))


def _shares(times: Floats, whole: Whole | None = None) -> Floats:
    """How many pulses fit into each interval at the speed that its neighbors foresee."""
    steps = np.diff(times)
    speeds = (np.ones(steps.size) if whole is None else whole) / steps
    middles = times[:-1] + 0.5 * steps
    offsets = [o for o in range(-NEIGHBORS, NEIGHBORS + 1) if o]
    foreseen = []
    index = np.arange(steps.size)
    for first, second in combinations(offsets, 2):
        i, j = index + first, index + second
        there = (i >= 0) & (j >= 0) & (i < steps.size) & (j < steps.size)
        a, b = np.clip(i, 0, steps.size - 1), np.clip(j, 0, steps.size - 1)
        with np.errstate(divide="ignore", invalid="ignore"):
            line = speeds[a] + (speeds[b] - speeds[a]) * (middles - middles[a]) / (middles[b] - middles[a])
        foreseen.append(np.where(there, line, np.nan))
    speed = np.nanmedian(foreseen, axis=0)
    slowest = 0.2 * np.array([np.median(speeds[max(0, k - NEIGHBORS) : k + NEIGHBORS + 1]) for k in index])
    return np.asarray(np.maximum(speed, slowest) * steps, np.float64)
