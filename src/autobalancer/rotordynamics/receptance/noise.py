"""How much noise a measured receptance has at each frequency: variances of known shapes that add, sized by the data.

The noise of a sensor is even over the frequency in what it measures. An accelerance is divided by the square of the
frequency, so that its noise grows without limit towards zero. A share of each value and five powers of the
frequency describe this, what drifts, and a blow that is weak at its end; the likelihood decides which are there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from autobalancer.errors import QuestionError

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
Noise = Literal["estimated", "relative", "absolute"]
POWERS = (-2, 0, 1, 2, 3)  # of 1/frequency: a weak blow, deflection, velocity, acceleration, a drift of the latter
STEPS = 300  # tens are enough, except where a part of the noise vanishes
ROUNDED = 1e-12  # a line of which the fit leaves no more than this has no voice
COHERENCE = (1e-3, 1.0 - 1e-4)  # beyond them its own error, of few averages and rounding in files, is all there is
SETTLED = 1e-4  # change of the variances in a step below which they are found


@dataclass(frozen=True)
class NoiseShapes:
    """What the noise of a measurement may be made of; frequencies scaled so that their middle is one."""

    noise: Noise
    frequency: Floats
    values: Complexes
    coherence: Floats | None = None

    def __post_init__(self) -> None:
        if self.noise not in ("estimated", "relative", "absolute"):
            raise QuestionError(f"noise: given {self.noise!r}; must be 'estimated', 'relative' or 'absolute'")

    def only(self, kept: NDArray[np.bool_]) -> NoiseShapes:
        """The same of some of the lines."""
        coherence = None if self.coherence is None else self.coherence[kept]
        return NoiseShapes(self.noise, self.frequency[kept], self.values[kept], coherence)

    @cached_property
    def start(self) -> Floats:
        """The variances by the scatter of the values alone, before anything is fitted."""
        return self.variances(smoothed(self.values), scatter(self.values))

    def shapes(self, fitted: Complexes) -> Floats:
        """One row for each part of the noise, its variance up to a factor, given the values without noise."""
        ones = np.ones(self.frequency.size)
        doubt = ones
        if self.coherence is not None:
            clipped = np.clip(self.coherence, *COHERENCE)
            doubt = (1.0 - clipped) / clipped
        if self.noise == "relative":
            return np.asarray(doubt * np.abs(self.values) ** 2)[None]
        if self.noise == "absolute":
            return np.asarray(doubt)[None]
        rows = [np.abs(fitted) ** 2, *(self.frequency ** (-2.0 * power) for power in POWERS)]
        if self.coherence is not None:
            own = doubt * np.abs(self.values) ** 2
            rows.append(np.maximum(own, smoothed(own).real))  # few averages leave the coherence itself uncertain
        return np.array(rows)

    def variances(self, fitted: Complexes, squares: Floats, taken: Floats | float = 0.0) -> Floats:
        """The variance at each frequency that makes these squares of deviations likeliest.

        Each factor is multiplied by a root that is one at the greatest likelihood, which rises in every step
        (Févotte and Idier 2011, Itakura-Saito divergence). ``taken`` is the share of each value that the fit takes up,
        its leverage: of a square only 1 - ``taken`` is to be expected, so the likelihood is the restricted one
        (Patterson and Thompson 1971). Without it a fit through the only line on a narrow peak seems to be free of noise.
        """
        rows = self.shapes(fitted)
        least = 1e-30 * float(np.abs(self.values).max()) ** 2
        factors = float(squares.mean() + least) / rows.mean(axis=1) / len(rows)
        found, left = factors @ rows, np.broadcast_to(np.maximum(1.0 - taken, ROUNDED), squares.shape)
        for _ in range(STEPS):
            factors = factors * np.sqrt((rows @ (squares / found**2)) / (rows @ (left / found)))
            before, found = found, factors @ rows + least
            if np.abs(found / before - 1.0).max() < SETTLED:
                break
        return np.asarray(found)


def scatter(values: Complexes) -> Floats:
    """Squares of what each value deviates from the parabola through its neighbours: noise, before anything is fitted."""
    weights = np.array([-1.0, 3.0, -3.0, 1.0])
    third = np.convolve(values, weights, mode="valid") / math.sqrt(20.0)
    between = np.concatenate([third[:1], third, third[-1:], third[-1:]])
    ahead = np.concatenate([third[:1], third[:1], third, third[-1:]])
    return np.asarray(0.5 * (np.abs(between) ** 2 + np.abs(ahead) ** 2))


def smoothed(values: Complexes | Floats) -> Complexes:
    """Mean over five neighbours, fewer at the ends."""
    ones = np.ones(5)
    count = np.convolve(np.ones(values.size), ones, mode="same")
    return np.asarray(np.convolve(values, ones, mode="same") / count, np.complex128)
