"""What is wrong with measured channels: each finding with its time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.results.signals.signals import Samples, extremes, pieces

Floats = NDArray[np.float64]
GREATEST = {"displacement": 0.05, "velocity": 50.0, "acceleration": 1e5, "speed": 2e4}  # SI, from peak to peak
LEAST = {"displacement": 1e-10, "velocity": 1e-9, "acceleration": 1e-7}
SMALLER = {"displacement": "mm or um", "velocity": "mm/s", "acceleration": "mm/s^2", "speed": "rpm"}
NAMED = 4  # places that a message names
PLATEAU = 3  # equal samples at an extreme


def refuse_missing(name: str, t: Floats, values: Floats | Samples) -> None:
    """Refuse samples that are no numbers.

    Raises
    ------
    QuestionError
        With their times.
    """
    bad = np.concatenate([first + np.flatnonzero(~np.isfinite(part)) for first, part in pieces(values)])
    if bad.size:
        raise QuestionError(
            f"channel {name!r}: {bad.size} of {values.size} samples are no numbers, {_times(t, bad)}; "
            "use the pieces between, with start and end, or leave this channel out"
        )


def refuse_implausible(name: str, quantity: str, values: Floats | Samples) -> None:
    """Refuse a vibration that is a thousand times too large, as of numbers in mm that are called m.

    Raises
    ------
    QuestionError
        With the unit that is probably meant.
    """
    if quantity not in GREATEST:
        return
    low, high = extremes(values)
    if (span := high - low) > GREATEST[quantity]:
        unit = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s^2", "speed": "rad/s"}[quantity]
        raise QuestionError(
            f"channel {name!r}: a {quantity} of {span:.4g} {unit} from peak to peak; is its unit {SMALLER[quantity]}? "
            "Say the unit of the column; if it is right, implausible=True takes it"
        )


def doubts(name: str, quantity: str, t: Floats, values: Floats | Samples) -> list[str]:
    """Sentences on a channel that is constant, clipped or a thousand times too small."""
    low, high = extremes(values)
    span = high - low
    if span == 0.0:
        return [f"channel {name!r} is constant, {low:.4g} at every sample; is the sensor connected?"]
    found = []
    if quantity in LEAST and span < LEAST[quantity]:
        found.append(f"channel {name!r}: only {span:.3g} (SI) from peak to peak; is its unit right?")
    if quantity != "tacho":
        clipped = clipped_samples(values)
        if clipped.size:
            found.append(
                f"channel {name!r} is clipped: {clipped.size} samples stand at its least or greatest value, "
                f"{_times(t, clipped)}; amplitudes there are too small"
            )
    return found


def clipped_samples(values: Floats | Samples) -> NDArray[np.int64]:
    """Indices of samples on plateaus at the extremes that the signal enters steeply, as no smooth peak does.

    A peak that is merely rounded to the last digit q enters a plateau of L samples with at most q (4/L + 12/L²) a step.
    """
    size, quantum = values.size, np.inf
    for _, part in pieces(values, 1):
        steps = np.abs(np.diff(part))
        quantum = min(quantum, float(steps.min(where=steps > 0.0, initial=np.inf)))
    if not np.isfinite(quantum):
        return np.array([], np.int64)

    def step(k: int) -> float:
        """From one sample to the next, without a sign."""
        return float(np.abs(np.diff(np.asarray(values[k : k + 2], np.float64)))[0])

    found = []
    for extreme in extremes(values)[::-1]:
        at = np.zeros(size + 2, np.int8)  # with a place before the first sample and one behind the last
        for first, part in pieces(values):
            at[first + 1 : first + 1 + part.size] = np.abs(part - extreme) <= 1e-12 * max(abs(extreme), quantum)
        edges = np.flatnonzero(np.diff(at))
        for first, end in zip(edges[::2], edges[1::2], strict=True):
            length = int(end - first)
            if length < PLATEAU:
                continue
            before = step(first - 2) if first >= 2 else 0.0
            after = step(end) if end < size - 1 else 0.0
            if max(before, after) > 1.5 * quantum * (4.0 / length + 12.0 / length**2):
                found.append(np.arange(first, end))
    return np.sort(np.concatenate(found)) if found else np.array([], np.int64)


def _times(t: Floats, indices: NDArray[np.int64]) -> str:
    """First instants of separate groups of samples: ``at 0.12 s, 0.31 s to 0.33 s``."""
    parts = np.split(indices, np.flatnonzero(np.diff(indices) > 1) + 1)
    texts = [f"{t[p[0]]:.6g} s" + (f" to {t[p[-1]]:.6g} s" if p.size > 1 else "") for p in parts[:NAMED]]
    more = f" and {len(parts) - NAMED} places more" if len(parts) > NAMED else ""
    return f"at {', '.join(texts)}{more}"
