"""The force of rubber whose deflection is an ellipse: first harmonic, its slopes, and the third harmonic that is left out.

With z = x + i y the deflection is z = f e^(i v t) + b e^(-i v t), here as u = (f, conj b), and the force alike. Turning the axes
or beginning at another time turns f and b only, so that the sizes |f| and |b| decide everything,

    F_f = e^(i arg f) Phi_f(|f|, |b|),    F_b = e^(i arg b) Phi_b(|f|, |b|),

and four slopes of two complex functions give all. Phi is found by the method of alternating frequency and time domain: one
period of every element, see :mod:`autobalancer.kernels.laws.sliding`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from autobalancer.assembly.rotors.model import Complexes, Floats
from autobalancer.laws.rubber import RubberLaw

ROUND = 1e-7  # of an ellipse: a circle so small against the other counts as none
THIN = 1e-3  # ratio of the axes of an ellipse that stands for a line


@dataclass(frozen=True)
class Forces:
    """Of the elements of one piece of rubber on n ellipses."""

    force: Complexes  # (n, 2) first harmonic, N
    slope: Floats  # (n, 4, 4) of its real and imaginary parts over those of u, N/m
    third: Complexes  # (n, 2) third harmonic, N
    miss: Floats  # (n,) of the forces of the elements: what is left until they are periodic


@dataclass
class Elements:
    """The sliding and the relaxing elements of one piece of rubber; it remembers what they were at the last ellipses."""

    law: RubberLaw
    starts: Floats  # (S, 2 e) force of each element at the tip of the ellipse, of S speeds

    @classmethod
    def of(cls, law: RubberLaw, speeds: int) -> Elements:
        """Elements at a number of speeds, nothing remembered."""
        return cls(law, np.zeros((speeds, 2 * len(law.friction))))

    def at_rest(self, speed: Floats) -> Complexes:
        """Stiffness of small motions that the elements add, N/m."""
        return self.relaxing(speed) + sum(k for k, _ in self.law.friction)

    def relaxing(self, speed: Floats) -> Complexes:
        """Stiffness of the Maxwell elements, N/m."""
        return replace(self.law, elastic=0.0, viscous=0.0, friction=()).stiffness(0.0, speed)

    def on(self, which: np.ndarray, motion: Complexes, speed: Floats, sloped: bool = True) -> Forces:
        """On ellipses u (n, 2), m, at the speeds (n,) whose numbers are ``which``."""
        from autobalancer.kernels.laws.sliding import (
            COLUMNS,
            FORCE,
            MISS,
            ORDER,
            OVER_BACKWARD,
            OVER_FORWARD,
            THIRD,
            forces_on_ellipses,
        )

        size = np.ascontiguousarray(np.abs(motion))
        elements = np.array([(limit, k) for k, limit in self.law.friction]).reshape(-1, 2)
        starts, out = self.starts[which], np.zeros((size.shape[0], COLUMNS))
        always = self.law.law == "endochronic"
        forces_on_ellipses(size, elements, always, starts, np.zeros((ORDER + 1, 5)), np.zeros(8), out, sloped)
        self.starts[which] = starts
        relaxing = np.broadcast_to(self.relaxing(speed), size.shape[:1])[:, None]
        turned = np.where(size > 0.0, motion / np.where(size > 0.0, size, 1.0), 1.0)  # e^(i arg u)
        radial = _pairs(out, FORCE)
        slopes = np.stack([_pairs(out, OVER_FORWARD), _pairs(out, OVER_BACKWARD)], axis=-1) if sloped else None
        force = turned * radial + relaxing * motion
        slope = np.zeros((size.shape[0], 4, 4))
        if slopes is not None:
            slope = _slopes(turned, size, radial, slopes, relaxing)
        third = _pairs(out, THIRD) * _third_turn(turned)
        return Forces(force, slope, third, out[:, MISS])


def alike_springs(law: RubberLaw, stretch: Complexes, amplitude: float, speed: float) -> Complexes:
    """The stiffness, (2, 2) complex and symmetric, of springs that act on an ellipse as the elements of a law do.

    ``stretch`` (2,) along x and y has the shape of the ellipse, ``amplitude`` (m) is its major semi-axis, ``speed`` rad/s. The
    springs act along the axes of the ellipse; across a line they have the stiffness of a thin ellipse.
    """
    x, y = stretch
    f, b = 0.5 * (x + 1j * y), 0.5 * np.conj(x - 1j * y)
    if min(abs(f), abs(b)) <= ROUND * (abs(f) + abs(b)):
        return np.eye(2) * replace(law, elastic=0.0, viscous=0.0).stiffness(amplitude, speed)
    size = amplitude / (abs(f) + abs(b))
    minor = size * (abs(f) - abs(b))
    minor = minor if abs(minor) > THIN * amplitude else np.copysign(THIN * amplitude, minor)
    motion = np.array([[0.5 * (amplitude + minor), 0.5 * (amplitude - minor)]], np.complex128)
    forward, backward = Elements.of(law, 1).on(np.zeros(1, np.int64), motion, np.array([speed]), False).force[0]
    lean = 0.5 * np.angle(f * b)
    axes = np.array([[np.cos(lean), -np.sin(lean)], [np.sin(lean), np.cos(lean)]])
    along = np.diag([(forward + backward) / amplitude, (forward - backward) / minor])
    return np.asarray(axes @ along @ axes.T, np.complex128)


def _pairs(out: Floats, column: int) -> Complexes:
    """(F_f, conj F_b) of four numbers, (n, 2)."""
    part = out[:, column : column + 4]
    return np.stack([part[:, 0] + 1j * part[:, 1], part[:, 2] - 1j * part[:, 3]], axis=-1)


def _third_turn(turned: Complexes) -> Complexes:
    """The phases of (f, conj b) of the third harmonic: with f at p and b at q they are 2 p - q and q - 2 p, doubled less."""
    p, minus_q = turned[:, 0], turned[:, 1]
    return np.stack([p * p * minus_q, p * minus_q * minus_q], axis=-1)


def _slopes(turned: Complexes, size: Floats, radial: Complexes, slopes: Complexes, relaxing: Complexes) -> Floats:
    """(n, 4, 4) of (Re, Im) of both circles."""
    near = size <= ROUND * size.sum(axis=1, keepdims=True)
    own = np.stack([slopes[:, 0, 0], slopes[:, 1, 1]], axis=-1)
    around = 1j * np.where(near, own, radial / np.where(near, 1.0, size))  # over a turn of its own phase
    found = np.zeros((size.shape[0], 4, 4))
    for i in range(2):
        for j in range(2):
            for part, direction in enumerate((1.0, 1j)):
                change: Complexes = direction * turned[:, j].conj()
                # a circle that is nothing changes the other one to its size, whatever its phase
                cross = np.where(near[:, j] & (i != j), 0j, slopes[:, i, j])
                force = np.asarray(turned[:, i] * (cross * change.real), np.complex128)
                if i == j:
                    force = force + turned[:, i] * around[:, i] * change.imag + relaxing[:, 0] * direction
                found[:, 2 * i, 2 * j + part], found[:, 2 * i + 1, 2 * j + part] = force.real, force.imag
    return found
