"""Rubber whose stiffness falls with amplitude: complex stiffness of elastic, viscous, Maxwell and friction elements.

The force of an isotropic rubber on z = x + i y is k z + c z' + sum g + sum f, with Maxwell elements g' = k z' - g/tau and one of
two rate-independent elements with two states each, whose force stays below k a_c:

    elastoplastic   f' = k [z' - f <Re(conj(f) z')> / (k a_c)^2],    <p> = max(p, 0),
    endochronic     f' = k z' - |z'| f / a_c.

With one period of the motion F = K a e^(i w t) in its first harmonic, K = K' + i K''. A friction element has K = k h(a / a_c).
In a circle its force turns with z and h is exact. Inserting f = k a h e^(i w t) gives

    elastoplastic   h = 1  for x <= 1,    h = 1/x^2 + i sqrt(1 - 1/x^2) / x  for x > 1,
    endochronic     h = (1 + i x) / (1 + x^2).

In a line, from the loop between two reversals (t, the force at them over k a_c; W, the area):

    elastoplastic   t = tanh u, u = 2 x - t;  W = 2 k a_c^2 (ln cosh u - t^2 / 2);  h' by quadrature over the loop,
    endochronic     h' = 2 I_1(x) / (x cosh x),   h'' = 4 (1 - tanh(x) / x) / (pi x).

The loss of a line is pi a^2 K'' in a cycle, of a circle 2 pi a^2 K''. Elements of one k at equal steps of ln a_c soften by
s = -dK'/d ln a = k / step; then K''/s is pi/4 in a circle and 0.700 in a line (elastoplastic), pi/2 and 1.086 (endochronic), and
2/pi in a line for Jenkins elements: loss follows from softening.

Own derivation. The elastoplastic element is a smooth Jenkins element (Iwan 1966), the endochronic one that of Dahl (1968).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from autobalancer.arrays import Complexes, Floats
from autobalancer.errors import QuestionError, one_of
from autobalancer.units import field_arguments

Friction = Literal["elastoplastic", "endochronic"]
Motion = Literal["circle", "line"]

SELDOM, WIDE = 50, 1e3  # numbers at once; ratio beyond which nobody asks often
SERIES = 1e-2  # below it a difference of nearly equal numbers is a series
PIECES = (0.0, 0.5, 1.0, 2.0, 4.0, 8.0, 20.0)  # of a loop, in units of a_c from where the force changes sign
NODES = 12  # in each piece


def friction_stiffness(ratio: ArrayLike, law: Friction = "elastoplastic", motion: Motion = "circle") -> Complexes:
    """Complex stiffness of a friction element over its stiffness k, at amplitudes over its a_c, of the shape of ``ratio``.

    Raises
    ------
    QuestionError
        If the law or the motion is unknown, or a ratio is negative or not finite.
    """
    x = np.asarray(ratio, dtype=float)
    one_of("law", law, *get_args(Friction))
    one_of("motion", motion, *get_args(Motion))
    if not (np.isfinite(x).all() and (x >= 0.0).all()):
        raise QuestionError("ratio: amplitudes over a_c must be finite and not negative")
    if motion == "circle":
        return _elastoplastic_circle(x) if law == "elastoplastic" else np.asarray((1.0 + 1j * x) / (1.0 + x * x))
    return _tabled_line(x) if law == "elastoplastic" else _endochronic_line(x)


@dataclass(frozen=True)
class RubberLaw:
    """Numbers of an isotropic rubber, SI.

    ``elastic`` k (N/m), ``viscous`` c (N s/m), ``friction`` pairs of stiffness k (N/m) and amplitude a_c (m), ``maxwell`` pairs
    of stiffness k (N/m) and relaxation time tau (s).
    """

    elastic: float
    viscous: float = 0.0
    friction: tuple[tuple[float, float], ...] = ()
    maxwell: tuple[tuple[float, float], ...] = ()
    law: Friction = "elastoplastic"

    def __post_init__(self) -> None:
        field_arguments(self, elastic="N/m", viscous="N*s/m")
        for name, pairs in (("friction", self.friction), ("maxwell", self.maxwell)):
            for number, (k, other) in enumerate(pairs, 1):
                if not (math.isfinite(k) and k >= 0.0 and math.isfinite(other) and other > 0.0):
                    raise QuestionError(
                        f"{name}[{number}]: given {k:g}, {other:g}; must be not negative, and above zero"
                    )

    def stiffness(self, amplitude: ArrayLike, speed: ArrayLike, motion: Motion = "circle") -> Complexes:
        """K (N/m) at amplitudes (m) and angular frequencies (rad/s), which broadcast."""
        a, w = np.broadcast_arrays(np.asarray(amplitude, dtype=float), np.asarray(speed, dtype=float))
        total = self.elastic + 1j * self.viscous * w
        for k, tau in self.maxwell:
            total = total + k * 1j * w * tau / (1.0 + 1j * w * tau)
        if self.friction:
            k_all, limits = np.array(self.friction).T
            total = total + friction_stiffness(a[..., None] / limits, self.law, motion) @ k_all
        return np.asarray(total, np.complex128)

    @cached_property
    def elements(self) -> RubberLaw:
        """The same without spring and damper, which no amplitude changes."""
        return replace(self, elastic=0.0, viscous=0.0)

    def loss(self, amplitude: ArrayLike, speed: ArrayLike, motion: Motion = "circle") -> Floats:
        """Energy that a cycle costs, J."""
        a = np.asarray(amplitude, dtype=float)
        return np.asarray((2.0 if motion == "circle" else 1.0) * np.pi * a**2 * self.stiffness(a, speed, motion).imag)

    def at_rest(self, speed: float = 0.0) -> complex:
        """K of the smallest motions, the stiffest of all; at a frequency if there are Maxwell elements."""
        return complex(self.stiffness(0.0, speed))

    @property
    def largest_amplitude(self) -> float:
        """The largest a_c, m, beyond which the loss of friction is bounded; infinite without friction."""
        return max((limit for _, limit in self.friction), default=math.inf)


def _elastoplastic_circle(x: Floats) -> Complexes:
    inverse = 1.0 / np.maximum(x, 1.0)
    return np.asarray(inverse**2 + 1j * inverse * np.sqrt(1.0 - inverse**2))


def _endochronic_line(x: Floats) -> Complexes:
    from scipy.special import i1e

    safe = np.maximum(x, SERIES)
    real = 4.0 * i1e(safe) / (safe * (1.0 + np.exp(-2.0 * safe)))
    imaginary = 4.0 / (np.pi * safe) * (1.0 - np.tanh(safe) / safe)
    near = 1.0 - 3.0 * x**2 / 8.0 + 1j * 4.0 * x / (3.0 * np.pi) * (1.0 - 0.4 * x**2)
    return np.where(x < SERIES, near, real + 1j * imaginary)


def _tabled_line(x: Floats) -> Complexes:
    """The quadrature where it is asked for seldom, else a spline through it, which agrees to 1e-12."""
    if x.size <= SELDOM:
        return _elastoplastic_line(x)
    inside, above = (x > SERIES) & (x < WIDE), x >= WIDE
    small_line = _small_line(x)
    small_line[inside] = _line_spline()(np.log(x[inside]))
    small_line[above] = _elastoplastic_line(x[above])
    return small_line


def _small_line(x: Floats) -> Complexes:
    return np.asarray(1.0 - x**2 / 8.0 + 1j * x**2 / (2.0 * np.pi))


@cache
def _line_spline() -> Callable[[Floats], Complexes]:
    from scipy.interpolate import CubicSpline

    log = np.linspace(math.log(SERIES), math.log(WIDE), 4001)
    return CubicSpline(log, _elastoplastic_line(np.exp(log)))  # type: ignore[no-any-return]


def _elastoplastic_line(x: Floats) -> Complexes:
    safe = np.maximum(x, SERIES)
    t = _tip(safe)
    u = 2.0 * safe - t
    area = 2.0 * (u + np.log1p(np.exp(-2.0 * u)) - math.log(2.0) - 0.5 * t**2)
    far = _over_loop(safe, t) + 1j * area / (np.pi * safe**2)
    return np.where(x < SERIES, _small_line(x), far)


def _tip(x: Floats) -> Floats:
    """t = tanh(2 x - t), the force at a reversal over k a_c."""
    t = np.tanh(x)
    for _ in range(60):
        tangent = np.tanh(2.0 * x - t)
        step = (t - tangent) / (2.0 - tangent**2)
        t = t - step
        if np.all(np.abs(step) < 1e-15):
            break
    return np.asarray(t)


def _over_loop(x: Floats, t: Floats) -> Floats:
    """h' of half a loop, force -t at its start: -s before the force changes sign, tanh s after it; Gauss in pieces of angle."""
    end = 2.0 * x - t
    marks = np.stack([-t, *(np.minimum(mark, end) for mark in PIECES), end], axis=-1)
    angles = np.arccos(np.clip(1.0 - (marks + t[..., None]) / x[..., None], -1.0, 1.0))
    angles[..., 0], angles[..., -1] = 0.0, np.pi
    half = 0.5 * np.diff(angles, axis=-1)
    node, weight = np.polynomial.legendre.leggauss(NODES)
    angle = angles[..., :-1, None] + half[..., None] * (1.0 + node)
    s = x[..., None, None] * (1.0 - np.cos(angle)) - t[..., None, None]
    total = -(half[..., None] * weight * np.where(s < 0.0, s, np.tanh(s)) * np.cos(angle)).sum(axis=(-2, -1))
    return np.asarray(2.0 / (np.pi * x) * total)
