"""Elliptic whirl: forward and backward circle, semi-axes, inclination, direction.

A harmonic motion x = Re(X e^(i v t)), y = Re(Y e^(i v t)) with v > 0 is the sum of two circles,
x + i y = F e^(i v t) + B e^(-i v t) with F = (X + i Y)/2 and B = conj(X - i Y)/2: an ellipse with the semi-axes
|F| + |B| and ||F| - |B||, inclined by (arg F + arg B)/2, passed through in the sense of the greater circle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autobalancer.assembly.rotors.model import Complexes, Floats

STRAIGHT = 1e-6  # a smaller ratio of the semi-axes is no ellipse but a line


@dataclass(frozen=True)
class Whirl:
    """Ellipses of any shape of array."""

    forward: Complexes
    backward: Complexes

    @property
    def semi_major(self) -> Floats:
        """Greatest deflection, max over time of sqrt(x^2 + y^2)."""
        return np.asarray(np.abs(self.forward) + np.abs(self.backward))

    @property
    def semi_minor(self) -> Floats:
        """Least deflection, positive where the whirl is forward, negative where it is backward."""
        return np.asarray(np.abs(self.forward) - np.abs(self.backward))

    @property
    def inclination(self) -> Floats:
        """Angle of the major axis from x, in (-pi/2, pi/2]; 0 for circles."""
        angle = 0.5 * np.angle(self.forward * self.backward)
        round_ = np.minimum(np.abs(self.forward), np.abs(self.backward)) <= 1e-12 * self.semi_major
        return np.asarray(np.where(round_, 0.0, np.where(angle <= -0.5 * np.pi, angle + np.pi, angle)))

    @property
    def sense(self) -> np.ndarray:
        """1 forward, -1 backward, 0 on a line or at rest."""
        level = self.semi_minor
        return np.asarray(np.where(np.abs(level) > STRAIGHT * self.semi_major, np.sign(level), 0.0).astype(np.int64))

    @property
    def direction(self) -> np.ndarray:
        """``forward``, ``backward`` or ``straight``, as texts."""
        return np.asarray(np.array(["backward", "straight", "forward"], dtype=object)[self.sense + 1])


def whirl(x: Complexes, y: Complexes) -> Whirl:
    """The ellipse of two complex amplitudes."""
    return Whirl(np.asarray(0.5 * (x + 1j * y)), np.asarray(0.5 * np.conj(x - 1j * y)))


def whole_direction(ellipses: Whirl) -> str:
    """One word for ellipses along a rotor: ``mixed`` where some run forward and others backward."""
    size = ellipses.semi_major
    seen = set(ellipses.sense[size > 1e-3 * size.max(initial=0.0)].tolist()) - {0}
    return "mixed" if len(seen) == 2 else {1: "forward", -1: "backward"}.get(next(iter(seen), 0), "straight")


def turning(ellipses: Whirl, angle: Floats) -> Complexes:
    """x + i y at phases ``angle`` = v t, (..., angles)."""
    turn = np.exp(1j * angle)
    return np.asarray(ellipses.forward[..., None] * turn + ellipses.backward[..., None] / turn)


def mean_of_greatest(ellipses: Whirl) -> Floats:
    """Mean over the last axis (stations) of the greatest deflections: Rodrigues et al. 2011, (3)."""
    return np.asarray(ellipses.semi_major.mean(axis=-1))


def greatest_mean(ellipses: Whirl, samples: int = 128) -> Floats:
    """Maximum over time of the mean over the last axis (stations) of the momentary deflections sqrt(x^2 + y^2)."""
    size = (np.abs(ellipses.forward) ** 2 + np.abs(ellipses.backward) ** 2)[..., None]
    product = (2.0 * ellipses.forward * np.conj(ellipses.backward))[..., None]

    def mean_radius(angle: Floats) -> Floats:
        square = size + (product * np.exp(2j * angle)).real
        return np.asarray(np.sqrt(np.maximum(square, 0.0)).mean(axis=-2))

    coarse = np.arange(samples) * np.pi / samples
    best = coarse[np.argmax(mean_radius(np.broadcast_to(coarse, (*product.shape[:-2], 1, samples))), axis=-1)]
    step = np.pi / samples
    for _ in range(4):  # zoom in on the best sample; each pass is ten times finer
        fine = best[..., None] + np.linspace(-1.0, 1.0, 21) * step
        best = np.take_along_axis(fine, np.argmax(mean_radius(fine[..., None, :]), axis=-1)[..., None], -1)[..., 0]
        step *= 0.1
    return np.asarray(mean_radius(best[..., None, None])[..., 0])
