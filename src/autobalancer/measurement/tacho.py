"""Angle and speed of the rotor from a tacho or an encoder."""

from __future__ import annotations

import math
import shlex
from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy import sparse
from scipy.interpolate import BSpline
from scipy.linalg import cho_solve_banded, cholesky_banded

from autobalancer.arrays import Floats
from autobalancer.errors import QuestionError, RangeWarning, one_of, warn
from autobalancer.results.labels import LABELS
from autobalancer.results.signals import BLOCK, LONG, Samples, Signals, extremes, pieces
from autobalancer.roots import least
from autobalancer.units import argument

Held = Floats | Samples
LIKELY = ("puls", "phasor", "tach", "drehzahl", "trig", "once", "marke")  # in names of channels that may be a tacho


def with_rotor_angle(signals: xr.Dataset, **tacho: Any) -> xr.Dataset:
    """The signals with ``rotor_angle``, ``speed`` and ``rotor_angle_deviation``: of a tacho, or of an angle that was measured.

    A measured angle is taken as exact, its slope is the speed; raises as :func:`rotor_angle`.
    """
    if "rotor_angle" not in signals:
        return rotor_angle(signals, **tacho)
    if {"speed", "rotor_angle_deviation"} <= set(signals):
        return signals
    angle, time = signals["rotor_angle"].values, signals["time"].values
    missing = {
        "speed": ("time", np.gradient(angle, time), {"units": "rad/s", "quantity": "speed"}),
        "rotor_angle_deviation": ("time", np.zeros_like(angle), {"units": "rad", "quantity": "angle"}),
    }
    return signals.assign({name: entry for name, entry in missing.items() if name not in signals})


def rotor_angle(
    signals: xr.Dataset,
    tacho: str = "",
    *,
    pulses: int = 1,
    threshold: float | None = None,
    hysteresis: float | None = None,
    edge: str = "rising",
    tacho_angle: float | str | None = None,
    index: str = "",
    repair: bool = True,
) -> xr.Dataset:
    """Find angle and speed of the rotor, and add them to the signals.

    The instants of the pulses are those at which the signal crosses its threshold. A spline of degree five with little jerk
    is fitted to the angle over the time; cross-validation says how much it is smoothed, so that it follows a rotor that
    changes its speed quickly, and not the jitter of the pulses.

    Parameters
    ----------
    signals
        From ``ab.measure.load_signals`` or ``ab.measure.signals``.
    tacho
        Name of the channel; by default the only one with the quantity tacho. A channel with the quantity angle is taken as
        it is.
    pulses
        Marks on a turn, evenly spaced.
    threshold, hysteresis
        In the unit of the channel; by default the middle of the pulses and three tenths of their height.
    edge
        Which edge of a pulse counts: rising or falling.
    tacho_angle
        Direction in which the sensor looks at the shaft, from the x axis (rad, or a text such as "90 deg"); the zero mark is
        there when its pulse comes. By default the direction of its channel, else the x axis.
    index
        Channel with one pulse a turn, that of the zero mark, beside a tacho of several pulses. Without it none of these is
        known to be the zero mark: phases are then known up to multiples of a turn over the number of pulses, and a warning
        says so.
    repair
        Count on where a pulse is missing or comes twice; a warning says when. Otherwise such a signal is refused.

    Returns
    -------
    xarray.Dataset
        The signals between the first and the last pulse with ``rotor_angle`` (rad, from the x axis to the mark), ``speed``
        (rad/s) and ``rotor_angle_deviation`` (rad, one standard deviation) over ``time``. ``attrs``: ``pulse_jitter`` (s,
        one standard deviation), ``angle_bandwidth`` (Hz, of the spline), ``missing_pulses`` and ``extra_pulses`` (s).

    Raises
    ------
    QuestionError
        If there is no such channel, it has no pulses or too few, or more than a tenth of them is odd.
    """
    name = _chosen(signals, tacho)
    if signals[name].attrs["quantity"] == "angle":
        return _measured_angle(signals, name)
    if isinstance(pulses, bool) or not isinstance(pulses, (int, np.integer)) or pulses < 1:
        raise QuestionError(f"pulses: given {pulses!r}; must be a whole number from 1")
    one_of("edge", edge, "rising", "falling")
    # pulses, those that are missing or too many repaired, then a smooth angle through them
    t = signals["time"].values
    result = repaired(
        crossings(t, signals[name], threshold=threshold, hysteresis=hysteresis, falling=edge == "falling"),
        repair=repair,
    )
    smooth = smooth_angle(result.times, np.asarray(2.0 * math.pi / pulses * result.counts, np.float64))
    first, last = np.searchsorted(t, result.times[0]), np.searchsorted(t, result.times[-1], side="right")
    inside = signals.isel(time=slice(int(first), int(last)))
    time = inside["time"].values
    if time.size < 8:
        raise QuestionError("tacho: fewer than 8 samples between the first and the last pulse")
    # the speed, which must not pass zero: pulses do not tell the direction
    turning = smooth.spline.derivative()
    speed = _over(time, turning)
    for _, part in pieces(speed):
        if not (part > 0.0).all():
            _, i = min((float(one.min()), begin + int(one.argmin())) for begin, one in pieces(speed))
            raise QuestionError(
                f"tacho: the speed is not above zero at {time[i]:.6g} s; use a piece in which the rotor turns"
            )
    remarks = [*odd_remarks(result), *_left_out(t, result.times)]
    # where the angle is zero
    zero = 0.0
    if index:
        zero = _at_index(signals, index, smooth.spline, time)
    elif pulses > 1:
        remarks.append(
            f"tacho: none of its {pulses} pulses a turn is known to be the zero mark; phases are known up to multiples of "
            f"{360.0 / pulses:.4g} deg. Name a channel with one pulse a turn as index"
        )
    # what is said of the pulses, and how the angle was found
    for text in remarks:
        warn(text, RangeWarning)
    attrs = {
        "pulse_jitter": smooth.jitter,
        "pulses_of_a_turn": pulses,
        "angle_bandwidth": smooth.bandwidth,
        "missing_pulses": result.missing.tolist(),
        "extra_pulses": result.extra.tolist(),
    }
    start = _looks(signals[name]) if tacho_angle is None else argument("tacho_angle", tacho_angle, "rad")
    turned = _over(time, lambda at: start + (smooth.spline(at) - zero))
    return _with(inside, turned, speed, _over(time, smooth.deviation), remarks, attrs)


def _over(time: Floats, function: Callable[[Floats], Floats]) -> Floats | Samples:
    """A function of the time; of a long record its values are computed when they are asked for."""

    def piece(first: int, end: int) -> Floats:
        parts = [function(time[at : min(at + BLOCK, end)]) for at in range(first, max(end, first + 1), BLOCK)]
        return np.asarray(np.concatenate(parts), np.float64)

    return Samples(time.size, piece) if time.size > LONG else piece(0, time.size)


def _chosen(signals: xr.Dataset, tacho: str) -> str:
    signals = Signals.given(signals, "rotor_angle")
    if tacho and tacho in signals:
        return tacho
    by = {
        word: [str(n) for n, v in signals.data_vars.items() if v.attrs.get("quantity") == word]
        for word in ("tacho", "angle")
    }
    there = ", ".join(map(str, signals.data_vars))
    if tacho:
        raise QuestionError(f"tacho: no channel {tacho!r}; there are {there}")
    text = by["tacho"] or by["angle"]
    if len(text) != 1:
        what = f"several, {', '.join(text)}; choose one by tacho='{text[0]}'" if text else f"none; there are {there}"
        likely = next((str(n) for n, v in signals.data_vars.items() if _pulses(str(n), v)), "")
        if likely and not text:
            what += f". If {likely!r} is the tacho, say tacho='{likely}' (--tacho {shlex.quote(likely)})"
        raise QuestionError(f"tacho: of the channels with the quantity tacho or angle there is {what}")
    return text[0]


def _pulses(name: str, channel: xr.DataArray) -> bool:
    """Whether a channel is called like one with the pulses of a rotor, and may be one."""
    return channel.attrs.get("quantity") == "voltage" and any(word in name.lower() for word in LIKELY)


def _left_out(t: Floats, pulses: Floats) -> list[str]:
    """What of a record lies before the first or after the last pulse, where that is more than turns in which none was due."""
    ends = (
        (pulses[0] - t[0], pulses[1] - pulses[0], f"first pulse comes at {pulses[0]:.4g} s", "before"),
        (t[-1] - pulses[-1], pulses[-1] - pulses[-2], f"last pulse comes at {pulses[-1]:.4g} s", "after"),
    )
    whole = t[-1] - t[0]
    return [
        f"tacho: its {words}; the {gap:.4g} s {side} it, {100.0 * gap / whole:.3g} % of the record, are left out"
        for gap, turn, words, side in ends
        if gap > 2.0 * turn
    ]


def _at_index(signals: xr.Dataset, index: str, spline: BSpline, time: Floats) -> float:
    """Mean angle, within a turn, at which the pulses of the zero mark come, rad."""
    one_of("index: channel", index, *map(str, signals.data_vars))
    instants = crossings(signals["time"].values, signals[index])
    instants = instants[(instants >= time[0]) & (instants <= time[-1])]
    if not instants.size:
        raise QuestionError(f"index: no pulse of {index!r} while the tacho turns")
    places = np.exp(1j * spline(instants))
    if abs(places.mean()) < 0.9:
        raise QuestionError(
            f"index: the pulses of {index!r} come at many angles; is the number of pulses of the tacho right?"
        )
    return float(np.angle(places.mean()))


def _looks(channel: xr.DataArray) -> float:
    """Direction of a sensor from the x axis, rad; zero where it is not known."""
    direction = channel.attrs.get("direction", "")
    return 0.5 * math.pi * (direction == "y") if isinstance(direction, str) else math.radians(float(direction))


def _measured_angle(signals: xr.Dataset, name: str) -> xr.Dataset:
    """An angle that was measured itself, wrapped or not."""
    t, angle = signals["time"].values, np.unwrap(signals[name].values)
    speed = np.gradient(angle, t)
    if not (speed > 0.0).all():
        raise QuestionError(
            f"{name}: the angle does not grow at {t[int(np.argmin(speed))]:.6g} s; it must, in every step"
        )
    sure = float(signals[name].attrs.get("uncertainty", 0.0))
    return _with(signals.drop_vars([name]), angle, speed, np.full(t.size, sure), [], {})


def _with(
    signals: xr.Dataset, angle: Held, speed: Held, deviation: Held, remarks: list[str], attrs: dict[str, object]
) -> xr.Dataset:
    entries = {
        "rotor_angle": (angle, LABELS["rotor_angle"].long_name, "rad", "angle"),
        "speed": (speed, LABELS["speed"].long_name, "rad/s", "speed"),
        "rotor_angle_deviation": (deviation, "standard deviation of the rotor angle", "rad", "angle"),
    }
    added = {
        name: (
            "time",
            values.variable() if isinstance(values, Samples) else values,
            {"long_name": text, "units": unit, "quantity": quantity},
        )
        for name, (values, text, unit, quantity) in entries.items()
    }
    doubts = [text for text in (str(signals.attrs.get("warnings", "")), *remarks) if text]
    return Signals.of(signals.assign(added).assign_attrs(attrs | {"warnings": "\n".join(doubts)}))


# A smooth angle through the pulses of a tacho: a spline of degree five with little jerk, and how sure it is.


DEGREE, JERK = 5, 3
ROUGHEST, SMOOTHEST = -12.0, 9.0  # powers of ten of the weight of the jerk, time in mean intervals of the pulses
TRIED = 150  # pulses of which the leverage is computed, evenly chosen


class SmoothAngle(NamedTuple):
    """The angle as a function of the time.

    Attributes
    ----------
    spline
        rad over s.
    jitter
        Standard deviation of the instants of the pulses, s.
    times, share
        Instants (s), and of the variance of one pulse the share that the spline has there.
    bandwidth
        Hz; of the power of errors of the pulses at the frequency f the spline has the share 1/(1 + (f/bandwidth)^6).
    """

    spline: BSpline
    jitter: float
    times: Floats
    share: Floats
    bandwidth: float

    def deviation(self, t: Floats) -> Floats:
        """Standard deviation of the angle, rad."""
        speed = self.spline.derivative()(t)
        return np.asarray(self.jitter * speed * np.sqrt(np.interp(t, self.times, self.share)), np.float64)


def smooth_angle(times: Floats, angles: Floats) -> SmoothAngle:
    """Fit it: the squares of the jitter of the pulses in time, and of the jerk, with the weight of the least cross-validation.

    The spline has a knot at every pulse; generalized cross-validation (Craven and Wahba 1979) says how much it is smoothed.

    Parameters
    ----------
    times
        Instants of the pulses, s, ascending; at least four.
    angles
        Of the rotor there, rad.
    """
    unit = float(times[-1] - times[0]) / (times.size - 1)
    clock = (times - times[0]) / unit
    slope = np.gradient(angles, clock)
    fit = _Fit(clock, angles, 1.0 / slope)
    if times.size <= DEGREE:
        power = ROUGHEST
    else:
        grid = np.linspace(ROUGHEST, SMOOTHEST, 15)
        scores = [fit.score(power) for power in grid]
        best = int(np.argmin(scores))
        ends = (grid[max(0, best - 1)], grid[min(grid.size - 1, best + 1)])
        power, _ = least(fit.score, *ends, xtol=0.05)
    coefficients, leverage, rest = fit.solved(power)
    free = max(1.0, times.size * (1.0 - float(leverage.mean())))
    jitter = unit * math.sqrt(float((rest**2).sum()) / free)
    spline = BSpline(times[0] + unit * fit.knots, coefficients, DEGREE)
    slowest = (10.0**power * float(slope.mean()) ** 2) ** (-0.5 / JERK) / (2.0 * math.pi)
    return SmoothAngle(spline, jitter, times[fit.tried], leverage, min(slowest, 0.5) / unit)


class _Fit:
    """The matrices, made once for all weights of the jerk."""

    def __init__(self, clock: Floats, angles: Floats, weights: Floats) -> None:
        self.knots = np.concatenate([[clock[0]] * DEGREE, clock, [clock[-1]] * DEGREE])
        design = BSpline.design_matrix(clock, self.knots, DEGREE).tocsr()
        self.design = sparse.diags_array(weights) @ design
        self.target = weights * angles
        self.right = self.design.T @ self.target
        self.gram = (self.design.T @ self.design).tocsr()
        jerk = _derivative(self.knots, DEGREE, JERK)
        left = DEGREE - JERK + 1
        inner = self.knots[JERK:-JERK]
        spans = (inner[left:] - inner[:-left]) / left
        self.rough = (jerk.T @ sparse.diags_array(spans) @ jerk).tocsr()
        self.tried = np.unique(np.linspace(0, clock.size - 1, min(TRIED, clock.size)).astype(int))

    def solved(self, power: float) -> tuple[Floats, Floats, Floats]:
        """Coefficients, leverage of the pulses that are tried, residuals of all pulses in units of the clock."""
        # the lower band of the normal equations
        matrix = (self.gram + 10.0**power * self.rough).tocsr()
        band = np.zeros((DEGREE + 1, matrix.shape[0]))
        for k in range(DEGREE + 1):
            diagonal = matrix.diagonal(-k)
            band[k, : diagonal.size] = diagonal
        factor = cholesky_banded(band, lower=True)
        solution = cho_solve_banded((factor, True), self.right)
        rows = self.design[self.tried].toarray()
        leverage = (rows * cho_solve_banded((factor, True), rows.T).T).sum(axis=1)
        return solution, np.asarray(leverage, np.float64), np.asarray(self.design @ solution - self.target, np.float64)

    def score(self, power: float) -> float:
        """Generalized cross-validation."""
        try:
            _, leverage, rest = self.solved(power)
        except np.linalg.LinAlgError:
            return math.inf
        free = 1.0 - float(leverage.mean())
        return float((rest**2).mean()) / free**2 if free > 1e-3 else math.inf


def _derivative(knots: Floats, degree: int, times: int) -> sparse.csr_array:
    """Coefficients of a derivative of a spline from those of the spline."""
    count = knots.size - degree - 1
    total = sparse.eye_array(count, format="csr")
    for _ in range(times):
        spans = knots[degree + 1 : count + degree] - knots[1:count]
        steps = degree / spans
        one = sparse.diags_array([-steps, steps], offsets=[0, 1], shape=(count - 1, count))
        total = one @ total
        knots, degree, count = knots[1:-1], degree - 1, count - 1
    return total.tocsr()


# Pulses of a tacho: instants at which its signal crosses a threshold, and those that are missing or too many.


Whole = NDArray[np.int64]
HYSTERESIS = 0.3  # of the height of a pulse
LOOKED_AT = LONG  # samples, evenly chosen, of which the height of the pulses is taken
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
    # falling edges are rising ones of the other sign
    sign = -1.0 if falling else 1.0
    low, high = extremes(values)
    if low == high:
        raise QuestionError(f"tacho: the signal is constant, {low:.4g}; there are no pulses")
    least, most = sorted((sign * low, sign * high))
    middle, every = 0.5 * (least + most), -(-values.shape[0] // LOOKED_AT)
    # threshold half way between foot and top of the pulses, of samples spread over the record
    some = sign * np.concatenate([part[-first % every :: every] for first, part in pieces(values)])
    foot = float(np.median(some[some < middle])) if (some < middle).any() else least
    top = float(np.quantile(some[some >= middle], 0.9)) if (some >= middle).any() else most
    level = 0.5 * (foot + top) if threshold is None else sign * threshold
    half = 0.5 * (HYSTERESIS * (top - foot) if hysteresis is None else hysteresis)
    if not least < level - half or not most >= level + half:
        raise QuestionError(f"tacho: no pulse crosses the threshold; the signal is between {low:.4g} and {high:.4g}")
    state, up, crossings = (
        0,
        -1,
        [],
    )  # of the last sample that was clearly above or below, and the last step through the level
    # a crossing counts when the signal was clearly below before and is clearly above after; its instant is where the
    # last step through the level is, on a straight line
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
        crossings.append(t[at] + (t[at + 1] - t[at]) * (level - a) / (b - a))
        state, up = int(before[-1]), int(ups[-1])
    return np.concatenate(crossings)


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
    odd, lost = missing.size + extra.size, int(whole.sum()) - whole.size
    if odd and not repair:
        raise QuestionError(f"tacho: {_odd_text(missing, extra, lost)}; leave out repair=False to count on over them")
    if odd > max(2, MOST_ODD * times.size):
        raise QuestionError(
            f"tacho: of {times.size} pulses {_odd_text(missing, extra, lost)}; is the threshold right, and are the marks "
            "evenly spaced?"
        )
    return Pulses(kept, np.concatenate([[0], np.cumsum(whole)]), missing, extra)


def odd_remarks(pulses: Pulses) -> list[str]:
    """Sentences on what was repaired; none where nothing was."""
    if not pulses.missing.size + pulses.extra.size:
        return []
    lost = int(pulses.counts[-1] - pulses.counts[0]) + 1 - pulses.counts.size
    return [f"tacho: {_odd_text(pulses.missing, pulses.extra, lost)}; counted on over them"]


def _odd_text(missing: Floats, extra: Floats, lost: int) -> str:
    """Places with their instants; ``lost`` is the number of pulses that are missing there."""
    texts = []
    for times, count, word in ((missing, lost, "missing after"), (extra, extra.size, "too many at")):
        if times.size:
            some = ", ".join(f"{time:.6g} s" for time in times[:4])
            texts.append(f"{count} {word} {some}" + (f" and {times.size - 4} more" if times.size > 4 else ""))
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
