"""A rotor that runs at W, under loads that circle forward at another speed v: receptance at its stations and modes.

Gyroscopic terms are those of W. So are tables of supports, which mean the frequency of the load but are taken at the speed of
the rotor everywhere, in simulations too. On anisotropic supports the forward component of the answer counts,
H = (H_xx + H_yy + i (H_yx - H_xy))/2; the backward one turns against the balls and averages out.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from autobalancer.stability.host.planar import Complexes, Floats, Matrix
from autobalancer.stability.host.stations import Stations

Indices = NDArray[np.int64]

PAST = 12.0  # decay rates beyond a resonance at which balls may still hang at it
SEEN = 1e-7  # least share of a mode in the whirl at the stations at which balls can hang at it


@dataclass(frozen=True)
class ForwardModes:
    """Modes with forward whirl at one rotor speed, k of them, ascending; H = sum of right left/(i v - pole)."""

    frequency: Floats  # (k,) rad/s
    decay: Floats  # (k,) 1/s
    right: Complexes  # (k, P)
    left: Complexes  # (k, P)


@dataclass(frozen=True)
class AllModes:
    """Every mode at each of s rotor speeds, K of them: H = sum of right left/(i v - pole) at whirl speeds v."""

    pole: Complexes  # (s, K) 1/s
    right: Complexes  # (s, K, P)
    left: Complexes  # (s, K, P)

    def at(self, speeds: Indices) -> AllModes:
        """Of some of the rotor speeds, by their numbers."""
        return AllModes(self.pole[speeds], self.right[speeds], self.left[speeds])


Known = tuple[Complexes, Complexes, Complexes]


@lru_cache(maxsize=8)
def _remembered(isotropic: bool, pairs: int, numbers: bytes) -> dict[float, Known]:
    """Modes by the speed, of the last few rotors: rows of a map often differ in their drag only."""
    return {}


class Whirling:
    """Answers of a rotor at its stations; remembers the modes of speeds that were asked.

    Where x and y are alike its coordinates are x + i y, unless they are to be kept ``apart``.
    """

    def __init__(self, st: Stations, *, apart: bool = False) -> None:
        model = st.model
        self.st, self.isotropic = st, st.isotropic and not apart
        self._fixed = model.speeds.size == 1 and not model.gyroscopic.any()
        self._modes: dict[float, ForwardModes] = {}
        self._mass, self._turning = self._seen(model.mass), self._seen(model.gyroscopic)
        numbers = (model.mass, model.gyroscopic, model.speeds, model.damping, model.stiffness, st.rows)
        self._all = _remembered(self.isotropic, model.pairs, b"".join(part.tobytes() for part in numbers))
        self._lightness = np.linalg.inv(self._mass)
        self._held = self._at(0.0)
        if self.isotropic:
            self.load, self.read = st.rows.T.astype(complex), st.rows.astype(complex)
        else:
            both, count = model.both(st.rows), st.rows.shape[0]
            x, y = both[:count], both[count:]
            self.load, self.read = (x - 1j * y).T / np.sqrt(2.0), (x + 1j * y) / np.sqrt(2.0)

    def _seen(self, matrix: Matrix) -> Complexes:
        """Of an isotropic rotor over z = q_x + i q_y, else over all coordinates."""
        n = self.st.model.pairs
        joined = matrix[:n, :n] + 1j * matrix[n : 2 * n, :n] if self.isotropic else matrix
        return np.asarray(joined, np.complex128)

    def _at(self, speed: float) -> tuple[Complexes, Complexes]:
        """Damping and stiffness of the supports while the rotor runs at ``speed``."""
        return self._seen(self.st.model.damping_at(speed)), self._seen(self.st.model.stiffness_at(speed))

    @property
    def matrices(self) -> tuple[Complexes, ...] | None:
        """K, C, G and M of the whirl, (n, n); none if supports have tables over the speed."""
        damping, stiffness = self._held
        return None if self.st.model.speeds.size > 1 else (stiffness, damping, self._turning, self._mass)

    @property
    def lightness(self) -> Complexes:
        """Inverse of the mass matrix of the whirl, (n, n)."""
        return np.asarray(self._lightness, np.complex128)

    def receptance(self, whirl: Floats, speed: Floats | float) -> Complexes:
        """Forward receptance between the stations at whirl speeds (n,) and one rotor speed or one each, (n, P, P), m/N."""
        v, w = np.broadcast_arrays(np.asarray(whirl, float), np.asarray(speed, float))
        damping, stiffness = self._held
        if self.st.model.speeds.size > 1:
            parts = [self._at(float(one)) for one in (w if np.ndim(speed) else w[:1])]
            damping, stiffness = (np.stack(matrices) for matrices in zip(*parts, strict=True))
        v, w = v[:, None, None], w[:, None, None]
        dynamic = stiffness + 1j * v * (damping + w * self._turning) - v**2 * self._mass
        return np.asarray(self.read @ np.linalg.solve(dynamic, self.load[None]))

    def free_motion(self, speeds: Floats) -> tuple[Complexes, Complexes, Complexes]:
        """S of (z, z')' = S (z, z') + P f at rotor speeds, (s, 2 n, 2 n), P (2 n, P), and R z'' by f at once, (P, P)."""
        n = self._mass.shape[0]
        damping, stiffness = self._held
        if self.st.model.speeds.size > 1:
            parts = [self._at(float(one)) for one in speeds]
            damping, stiffness = (np.stack(matrices) for matrices in zip(*parts, strict=True))
        whole = np.zeros((speeds.size, 2 * n, 2 * n), np.complex128)
        whole[:, :n, n:] = np.eye(n)
        whole[:, n:, :n] = -(self._lightness @ stiffness)
        whole[:, n:, n:] = -(self._lightness @ (damping + speeds[:, None, None] * self._turning))
        pushed = self._lightness @ self.load
        return whole, np.vstack([np.zeros_like(pushed), pushed]), np.asarray(self.read @ pushed)

    def modes(self, speed: float) -> ForwardModes:
        """Modes with forward whirl that the stations see."""
        key = 0.0 if self._fixed else speed
        if key not in self._modes:
            poles, right, left = self._known(speed)
            share = (np.abs(right) * np.abs(left)).max(axis=1) * np.abs(poles.imag)
            forward = (poles.imag > 0.0) & (share > SEEN * share.max(initial=0.0))
            order = np.flatnonzero(forward)[np.argsort(poles.imag[forward])]
            self._modes[key] = ForwardModes(poles.imag[order], -poles.real[order], right[order], left[order])
        return self._modes[key]

    def hang(self, speeds: Floats, whirls: Floats) -> NDArray[np.bool_]:
        """Whether a resonance that the rotor has passed is ahead of balls that whirl so fast, or just behind them, (n,)."""
        found = []
        for speed, whirl in zip(speeds.tolist(), whirls.tolist(), strict=True):
            modes = self.modes(speed)
            found.append(bool(((modes.frequency < speed) & (modes.frequency + PAST * modes.decay > whirl)).any()))
        return np.array(found, np.bool_)

    def all_modes(self, speeds: Floats) -> AllModes:
        """Every mode at rotor speeds (s,)."""
        found = [self._known(float(speed)) for speed in speeds]
        return AllModes(*(np.stack(parts) for parts in zip(*found, strict=True)))

    def _known(self, speed: float) -> Known:
        key = 0.0 if self._fixed else speed
        if key not in self._all:
            self._all[key] = self._decomposed(key)
        return self._all[key]

    def _decomposed(self, speed: float) -> Known:
        """Poles (K,), and what the stations see and feel of them, (K, P)."""
        damping, stiffness = self._at(speed)
        n = self._mass.shape[0]
        load, read = self.load, self.read
        by_mass = np.linalg.solve(self._mass, np.hstack([stiffness, damping + speed * self._turning, load]))
        whole = np.zeros((2 * n, 2 * n), np.complex128)
        whole[:n, n:] = np.eye(n)
        whole[n:] = -by_mass[:, : 2 * n]
        poles, vectors = np.linalg.eig(whole)
        left = np.linalg.lstsq(vectors, np.vstack([np.zeros_like(load), by_mass[:, 2 * n :]]), rcond=None)[0]
        return poles, np.asarray((read @ vectors[:n]).T), left
