"""Instants of samples: even ones as they are, rounded ones made even, uneven ones refused or resampled."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline

from autobalancer.errors import QuestionError
from autobalancer.measurement.signals.form import UNEVEN
from autobalancer.measurement.signals.formats import RawFile
from autobalancer.memory import refuse_what_does_not_fit
from autobalancer.results.signals.signals import BLOCK, LONG, Samples, pieces

Floats = NDArray[np.float64]
GAP = 1.5  # steps; a longer one is a gap
SAMPLE = 16.0  # bytes of a new sample: its instant, and what checks of it need
MARGIN = 64  # samples beside a piece, beyond which a spline of degree five forgets (0.43^64) where it began
NAMED = 5  # places that a message names


def instants(raw: RawFile, rate: float | None) -> Floats:
    """The instants of the samples, s; (time,).

    Raises
    ------
    QuestionError
        If neither the file nor the caller says them, or they do not ascend.
    """
    if raw.time is None or rate is not None:
        known = rate or raw.rate
        if known is None:
            why = raw.timeless or "no column of time"
            raise QuestionError(
                f"{raw.origin}: {why}; {'or ' * bool(raw.timeless)}give the rate of the samples, such as rate='2 kHz'"
            )
        size = next((column.values.size for column in raw.columns.values()), 0)
        start = 0.0 if raw.time is None or not np.isfinite(raw.time[:1]).all() else float(raw.time[0])
        refuse_what_does_not_fit(raw.origin, size, "samples", SAMPLE, "; use fewer, or a piece of the record")
        t = np.arange(size, dtype=np.float64)  # in place: of a long record no more arrays than needed
        t /= known
        t += start
        return t
    t = np.asarray(raw.time)
    for first, part in pieces(t):
        if not np.isfinite(part).all():
            bad = first + int(np.flatnonzero(~np.isfinite(part))[0]) + 1
            raise QuestionError(f"{raw.origin}: time: sample {bad} is not a number")
    back = np.concatenate([first + np.flatnonzero(np.diff(part) <= 0.0) for first, part in pieces(t, 1)])
    if back.size:
        after = t[back[0]]
        rounded = (np.diff(t) >= 0.0).all() and t[-1] > t[0]
        hint = f". {_overruled(t)}" if rounded else ""
        raise QuestionError(f"{raw.origin}: time must ascend; after {after:.9g} s comes {t[back[0] + 1]:.9g} s{hint}")
    return t


def _overruled(t: Floats) -> str:
    """The way out for times that a logger rounded too coarsely, with the rate that they have on average."""
    rate = (t.size - 1) / float(t[-1] - t[0])
    return f"If the samples are even and only their times are rounded, give their rate, such as rate='{rate:.5g} Hz'"


def rate_remarks(raw: RawFile, t: Floats, rate: float | None) -> list[str]:
    """What is to be said where a rate takes the place of a column of time."""
    if raw.time is None or rate is None or raw.time.size < 2:
        return []
    span, own = float(raw.time[-1] - raw.time[0]), float(t[-1] - t[0])
    apart = np.isfinite(span) and abs(span - own) > max(0.01 * own, 2.0 * raw.quantum)
    odd = f"; by it the file lasts {span:.4g} s, by the rate {own:.4g} s" if apart else ""
    return [f"the rate of {rate:.6g} Hz is used, not the column of time{odd}"]


def even(t: Floats, quantum: float, origin: str) -> Floats | None:
    """The same instants at exactly equal steps, if they differ from these no more than by the rounding of the file.

    ``None`` if they are not even.

    Raises
    ------
    QuestionError
        If there is a gap; the message says where.
    """
    every = -(-t.size // LONG)  # the median of a long record is that of evenly chosen steps
    step = float(np.median(t[1::every] - t[:-1:every]))
    gaps = np.concatenate(
        [first + np.flatnonzero(np.diff(part) > GAP * step + quantum) for first, part in pieces(t, 1)]
    )
    if gaps.size and gaps.size < 0.01 * t.size + 1:
        where = ", ".join(f"{t[i]:.6g} s ({t[i + 1] - t[i]:.3g} s)" for i in gaps[:NAMED])
        more = f" and {gaps.size - NAMED} more" if gaps.size > NAMED else ""
        raise QuestionError(
            f"{origin}: samples are missing after {where}{more}; the usual step is {step:.4g} s. Use the pieces between, "
            "with start and end"
        )
    allowed = max(UNEVEN * step, 0.75 * quantum if quantum < 0.6 * step else 0.0)
    mean = 0.5 * (t.size - 1)
    slope = sum(float(((first - mean + np.arange(part.size)) * part).sum()) for first, part in pieces(t))
    slope /= t.size * (t.size**2 - 1) / 12.0  # of the line of least squares, after that through both ends
    for span, count, start in ((t[-1] - t[0], 2.0 * mean, t[0]), (slope, 1.0, float(t.mean()) - slope * mean)):
        line = np.arange(t.size, dtype=np.float64)  # in place: of a long record no more arrays than needed
        line *= span
        line /= count
        line += start
        if all(np.abs(t[first : first + part.size] - part).max() <= allowed for first, part in pieces(line)):
            return line
    return None


def uneven_text(t: Floats, origin: str) -> str:
    """What is wrong with uneven instants, and what to do."""
    steps = np.diff(t)
    i = int(np.argmax(np.abs(steps - np.median(steps))))
    low, high = 1.0 / steps.max(), 1.0 / steps.min()
    return (
        f"{origin}: the samples are not evenly spaced: steps from {steps.min():.4g} s to {steps.max():.4g} s, the oddest "
        f"at {t[i]:.6g} s. Resample them, for example resample='{0.5 * (low + high):.4g} Hz'. {_overruled(t)}"
    )


def resampled(t: Floats, values: Floats | Samples, grid: Floats) -> Floats | Samples:
    """Values at other instants, by a spline of degree five; of a long record they are computed when they are asked for."""

    def piece(first: int, end: int) -> Floats:
        if end <= first:
            return np.empty(0)
        low, high = np.searchsorted(t, grid[[first, end - 1]])
        near = slice(max(0, low - MARGIN), high + MARGIN)
        held = np.asarray(values[near], np.float64)
        return np.asarray(make_interp_spline(t[near], held, k=min(5, held.size - 1))(grid[first:end]), np.float64)

    def blocks(first: int, end: int) -> Floats:
        return np.concatenate([piece(a, min(a + BLOCK, end)) for a in range(first, max(end, first + 1), BLOCK)])

    return Samples(grid.size, blocks) if grid.size > LONG else blocks(0, grid.size)


def grid_of(t: Floats, rate: float, origin: str) -> Floats:
    """Even instants of that rate within the measured ones.

    Raises
    ------
    QuestionError
        If a gap is longer than two of the steps asked for, or so many samples do not fit into the memory.
    """
    count = (t[-1] - t[0]) * rate
    refuse_what_does_not_fit(f"{origin}: resample", count, "samples", SAMPLE, "; take a lower rate")
    steps = np.diff(t)
    gap = int(np.argmax(steps))
    if steps[gap] > 2.0 / rate and steps[gap] > 3.0 * np.median(steps[:: -(-steps.size // LONG)]):
        raise QuestionError(
            f"{origin}: samples are missing from {t[gap]:.6g} s to {t[gap + 1]:.6g} s; use the pieces before or after"
        )
    return np.asarray(t[0] + np.arange(int(np.floor(count)) + 1) / rate, np.float64)
