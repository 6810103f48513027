"""Tables that cannot be rubber: stiffness that rises with amplitude, holes, and points that contradict each other."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from autobalancer.errors import QuestionError
from autobalancer.results.answers.rubber_points import RubberPoints

SAME = 1e-3  # relative difference of frequencies and amplitudes that count as one
SURE = 3.0  # standard deviations
WIDEST = 12.0  # ratio of neighboring amplitudes beyond which what lies between is not known


def refuse_impossible(points: RubberPoints) -> None:
    """Refuse what no rubber of this kind can do.

    Raises
    ------
    QuestionError
        It names the points.
    """
    amplitudes = _distinct(points.amplitude)
    if len(amplitudes) < 2:
        raise QuestionError(
            f"rubber: all {len(points)} points have one amplitude, {1e3 * amplitudes[0]:.4g} mm; softening needs at least two, "
            "better four or more"
        )
    for low, high in pairwise(amplitudes):
        if high > WIDEST * low:
            raise QuestionError(
                f"rubber: nothing was measured between {1e3 * low:.4g} and {1e3 * high:.4g} mm, a hole of a factor "
                f"{high / low:.3g}; measure in between, at most a factor {WIDEST:g} apart"
            )
    _refuse_holes(points)
    _refuse_contradictions(points)
    _refuse_rises(points)


def _distinct(values: np.ndarray) -> list[float]:
    found: list[float] = []
    for value in np.sort(values).tolist():
        if not found or value > found[-1] * (1.0 + SAME):
            found.append(value)
    return found


def _refuse_holes(points: RubberPoints) -> None:
    """Loops at several frequencies and amplitudes must have all combinations."""
    loops = [i for i, kind in enumerate(points.kind) if kind == "loop"]
    for motion in sorted({points.motion[i] for i in loops}):
        rows = [i for i in loops if points.motion[i] == motion]
        w, x = _distinct(points.frequency[rows]), _distinct(points.amplitude[rows])
        there = {(_nearest(w, points.frequency[i]), _nearest(x, points.amplitude[i])) for i in rows}
        missing = [(a, b) for a in range(len(w)) for b in range(len(x)) if (a, b) not in there]
        if missing:
            texts = [f"{w[a] / (2.0 * np.pi):.4g} Hz at {1e3 * x[b]:.4g} mm" for a, b in missing]
            more = f" and {len(texts) - 3} more" if len(texts) > 3 else ""
            raise QuestionError(
                f"rubber: the table of loops has holes: {', '.join(texts[:3])}{more}; measure them, or leave out their "
                "frequency or amplitude altogether"
            )


def _nearest(values: list[float], value: float) -> int:
    return int(np.argmin(np.abs(np.log(np.array(values) / value))))


def _refuse_contradictions(points: RubberPoints) -> None:
    for i in range(len(points)):
        for j in range(i + 1, len(points)):
            same = all(
                abs(getattr(points, name)[i] - getattr(points, name)[j]) <= SAME * getattr(points, name)[i]
                for name in ("frequency", "amplitude")
            )
            if not same or points.motion[i] != points.motion[j]:
                continue
            for name in ("stiffness", "loss"):
                one, other = getattr(points, name)[[i, j]]
                spread = float(np.hypot(*getattr(points, f"{name}_uncertainty")[[i, j]]))
                if abs(one - other) > SURE * spread:
                    raise QuestionError(
                        f"rubber: {points.names[i]} and {points.names[j]} contradict each other: {name} {one:.4g} and "
                        f"{other:.4g} N/m at one frequency and amplitude; leave one out, or give a larger uncertainty"
                    )


def _refuse_rises(points: RubberPoints) -> None:
    """Stiffness must not rise with the amplitude, nor fall with the frequency, beyond its uncertainty."""
    for along, other, text in (
        ("amplitude", "frequency", "stiffness rises with the amplitude"),
        ("frequency", "amplitude", "stiffness falls with the frequency"),
    ):
        sign = 1.0 if along == "amplitude" else -1.0
        for i in range(len(points)):
            for j in range(len(points)):
                fixed = getattr(points, other)
                # the frequency of a resonance follows from its amplitude
                alike = abs(fixed[i] - fixed[j]) <= SAME * fixed[i] or (
                    along == "amplitude" and points.kind[i] == points.kind[j] == "resonance"
                )
                if not alike or points.motion[i] != points.motion[j] or points.kind[i] != points.kind[j]:
                    continue
                if getattr(points, along)[j] <= getattr(points, along)[i] * (1.0 + SAME):
                    continue
                spread = float(np.hypot(*points.stiffness_uncertainty[[i, j]]))
                if sign * (points.stiffness[j] - points.stiffness[i]) > SURE * spread:
                    raise QuestionError(
                        f"rubber: the {text}: {points.stiffness[i]:.4g} N/m in {points.names[i]}, "
                        f"{points.stiffness[j]:.4g} N/m in {points.names[j]}; no rubber of these elements does. Check the two, "
                        "or give a larger uncertainty"
                    )
