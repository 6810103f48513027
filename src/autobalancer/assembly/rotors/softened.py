"""A rotor on rubber that softens with the amplitude, turning steadily in circles: stiffness and motion that suit each other.

With z = q_x + i q_y = Z e^(i w t) the stretch of a piece of rubber m is s_m = r_m Z, and its elements add the stiffness
kappa_m(|s_m|, w). With D of the rotor whose elements all slide

    (D(w) + sum_m c_m kappa_m r_m^H r_m) Z = F,        c_m = 1 for rubber with two directions, 1/2 for one.

A circle is exact. Rubber that is stretched along one line only, such as bushings on a circle when the rotor tilts, counts with
its first harmonic; several of them act alike in all directions together, which is checked. Solved for the stretches:

    (1 + H kappa) s = s_0,    H = r D^-1 r^H c,    s_0 = r D^-1 F.

One piece has the scalar equation |1 + H kappa(a)| a = |s_0|. Its left side only grows with a, so that there is one motion at each
speed and the curve of the response never folds, however much the rubber softens. For an elastoplastic chain, with real E for the
rest, the left side is |E + K| a, and with sums over the elements that slip, which have x_j = a/a_j > 1,

    |E + K|^2 a^2 = (E a + P/a)^2 + S^2,    P = sum k_j a_j^2,    S = sum k_j a_j (1 - a_j^2/a^2)^(1/2),

whose slope is 2 E^2 a - 2 P^2/a^3 + 2 S S' >= 2 E^2 a, because S S' >= P^2/a^3 by Cauchy and Schwarz. The loss that comes with
the softening prevents the fold that softening alone would make. Damping only helps; endochronic elements do the same.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from autobalancer.assembly.rotors.ellipses.amplitudes import by_newton, in_turns
from autobalancer.assembly.rotors.model import Complexes, Floats, LateralModel
from autobalancer.assembly.rotors.mounts import Mount, mounts, sliding_model
from autobalancer.errors import QuestionError
from autobalancer.laws.rubber import Motion, RubberLaw
from autobalancer.machine import Machine, Rubber

SAME = 1e-9  # relative difference of two places that count as one
ALIKE = 1e-6  # relative difference of x and y that counts as none
NO_CIRCLE = "rubber: no steady circle was found at {0:.5g} rad/s; simulate the machine there, or leave the speed out"
ELLIPSES = (
    "{0}: the rubber of this machine softens with the amplitude, and its x and y differ, so that it moves in ellipses; this is "
    "known for circles only. Simulate the machine, or give it a stiffness and damping in place of rubber"
)


@dataclass(frozen=True)
class Steady:
    """Circles at S speeds: ``motion`` Z (S, n), and of each piece of rubber ``amplitude`` (m) and ``stiffness`` K (N/m)."""

    motion: Complexes
    amplitude: Floats
    stiffness: Complexes


@dataclass(frozen=True)
class Softened:
    """The rubber of a rotor, and the rotor when all of it slides, with what mass it was asked with."""

    sliding: LateralModel
    mounts: tuple[Mount, ...]
    laws: tuple[RubberLaw, ...]

    @property
    def rows(self) -> Complexes:
        """r, (M, n)."""
        n = self.sliding.pairs
        return np.array([mount.rows[0, :n] - 1j * mount.rows[0, n : 2 * n] for mount in self.mounts])

    @property
    def shares(self) -> Floats:
        """c, (M,)."""
        return np.array([1.0 if motion == "circle" else 0.5 for motion in self.motions])

    @property
    def motions(self) -> tuple[Motion, ...]:
        """In which each piece moves while the rotor circles: one with a single direction in a line."""
        return tuple("circle" if mount.rows[1].any() else "line" for mount in self.mounts)

    def added(self, amplitude: Floats, speed: Floats) -> Complexes:
        """kappa (..., M) at amplitudes (..., M) and speeds (...,)."""
        found = np.zeros(amplitude.shape, np.complex128)
        for law, motion in dict.fromkeys(zip(self.laws, self.motions, strict=True)):
            same = [m for m, one in enumerate(zip(self.laws, self.motions, strict=True)) if one == (law, motion)]
            elements = replace(law, elastic=0.0, viscous=0.0)
            found[..., same] = elements.stiffness(amplitude[..., same], np.asarray(speed)[..., None], motion)
        return found

    def steady(self, speeds: Floats, force: Complexes, owner: str, *, over: float = 1.0) -> Steady:
        """Circles under a ``force`` F at each of the whirl ``speeds``, (S, n).

        The rotor turns ``over`` times as fast as it whirls.

        Raises
        ------
        QuestionError
            If the machine moves in ellipses; ``owner`` is who asks.
        """
        found = self.circles(speeds, force, over=over)
        if found is None:
            raise QuestionError(ELLIPSES.format(owner))
        return found

    def circles(
        self, speeds: Floats, force: Complexes, *, over: float | Floats = 1.0, attempted: bool = False
    ) -> Steady | None:
        """The same; none where the machine moves in ellipses. ``over`` may differ from speed to speed.

        If it is only ``attempted``, the motion is nan where no amplitude was found.
        """
        if not self.sliding.isotropic:
            return None
        dynamic = _dynamics(self.sliding, speeds, np.asarray(over * speeds))
        r, c = self.rows, self.shares
        one, group = self._alike(r)
        weight = np.array([c[group == g].sum() for g in range(len(one))])
        inverse = np.linalg.inv(dynamic)
        free = np.einsum("mi,sij,sj->sm", r[one], inverse, force)
        across = np.einsum("mi,sij,kj->smk", r[one], inverse, r[one].conj()) * weight
        laws = [(self.laws[m], self.motions[m]) for m in one]
        amplitude, wrong = (by_newton if attempted else in_turns)(laws, speeds, across, free)
        if wrong.size and not attempted:
            raise QuestionError(NO_CIRCLE.format(speeds[wrong[0]]))
        amplitude = amplitude[:, group]
        kappa = self.added(amplitude, speeds)
        if not self._in_circles(kappa):
            return None
        whole = dynamic + np.einsum("mi,sm,mj->sij", r.conj(), c * kappa, r)
        motion = np.linalg.solve(whole, force[..., None])[..., 0]
        motion[wrong] = np.nan
        elastic = np.array([law.elastic for law in self.laws]) + 1j * np.outer(
            speeds, [law.viscous for law in self.laws]
        )
        return Steady(np.asarray(motion, np.complex128), amplitude, np.asarray(kappa + elastic))

    def _alike(self, rows: Complexes) -> tuple[list[int], np.ndarray]:
        """The first of each group of pieces that always move alike, and the group of each piece."""
        one: list[int] = []
        group = np.zeros(len(rows), int)
        for m, row in enumerate(rows):
            for g, first in enumerate(one):
                same = abs(np.vdot(rows[first], row)) >= (1.0 - SAME) * np.linalg.norm(rows[first]) * np.linalg.norm(
                    row
                )
                as_far = abs(np.linalg.norm(rows[first]) - np.linalg.norm(row)) <= SAME * np.linalg.norm(row)
                if same and as_far and (self.laws[m], self.motions[m]) == (self.laws[first], self.motions[first]):
                    group[m] = g
                    break
            else:
                group[m] = len(one)
                one.append(m)
        return one, group

    def at_amplitude(self, amplitude: ArrayLike, speed: float, motion: Motion = "circle") -> LateralModel:
        """The rotor with the stiffness K' and damping K''/w that its rubber has at amplitudes (m) and a frequency w (rad/s).

        One amplitude, or one of each piece; pieces with one direction always move in a line.
        """
        stiffness, damping = self.sliding.stiffness, self.sliding.damping
        sizes = np.broadcast_to(np.asarray(amplitude, dtype=float), (len(self.mounts),))
        for law, mount, own, size in zip(self.laws, self.mounts, self.motions, sizes, strict=True):
            how = own if own == "line" else motion
            more = complex(replace(law, elastic=0.0, viscous=0.0).stiffness(size, speed, how))
            square = mount.rows.T @ mount.rows
            stiffness = stiffness + more.real * square
            damping = damping + more.imag / speed * square
        return replace(self.sliding, stiffness=stiffness, damping=damping)

    def _in_circles(self, kappa: Complexes) -> bool:
        """Whether pieces with two directions act alike along x and y, those with one together, and none on other motions."""
        n = self.sliding.pairs
        squares = np.array([mount.rows.T @ mount.rows for mount in self.mounts])
        lines = [m for m, motion in enumerate(self.motions) if motion == "line"]
        every = [squares[m] for m in range(len(self.mounts)) if m not in lines]
        every += [np.einsum("m,mij->ij", one[lines], squares[lines]) for one in kappa] if lines else []
        others = np.einsum("sm,mij->sij", kappa, squares)[:, : 2 * n, 2 * n :]
        apart = np.abs(others).max(initial=0.0) > ALIKE * np.abs(kappa).max()
        return not apart and not any(_uneven(one, n) for one in every)


def _uneven(matrix: Complexes, n: int) -> bool:
    """Whether x and y differ."""
    xx, xy, yx, yy = matrix[:n, :n], matrix[:n, n : 2 * n], matrix[n : 2 * n, :n], matrix[n : 2 * n, n : 2 * n]
    return bool(max(np.abs(xx - yy).max(), np.abs(xy + yx).max()) > ALIKE * np.abs(matrix).max())


def softened(machine: Machine, bare: LateralModel, model: LateralModel | None = None) -> Softened | None:
    """The softening rubber of a machine with its ``bare`` model, and the mass of ``model`` if given; none without any."""
    found = mounts(machine, bare)
    if not found:
        return None
    sliding = sliding_model(machine, bare, found)
    sliding = sliding if model is None else replace(sliding, mass=model.mass)
    return Softened(sliding, found, tuple(law_of(mount.rubber) for mount in found))


def law_of(rubber: Rubber) -> RubberLaw:
    """Rubber in numbers."""
    friction, maxwell = rubber.friction, rubber.maxwell
    return RubberLaw(
        float(rubber.stiffness),
        float(rubber.damping),
        () if friction is None else tuple(zip(friction.stiffness, friction.breakaway_amplitude, strict=True)),
        () if maxwell is None else tuple(zip(maxwell.stiffness, maxwell.relaxation_time, strict=True)),
        "elastoplastic" if friction is None else friction.law,
    )


def _dynamics(model: LateralModel, whirls: Floats, speeds: Floats) -> Complexes:
    """D at whirl speeds of a rotor that turns at ``speeds``, (S, n, n)."""
    if model.speeds.size == 1:
        mass, damping, stiffness = model.complex_matrices(0.0)
        turning = model.complex_matrices(1.0)[1] - damping
        v, w = whirls[:, None, None], speeds[:, None, None]
        return np.asarray(stiffness + 1j * v * (damping + w * turning) - v**2 * mass)
    found = []
    for v, w in zip(whirls.tolist(), speeds.tolist(), strict=True):
        mass, damping, stiffness = model.complex_matrices(w)
        found.append(stiffness + 1j * v * damping - v**2 * mass)
    return np.array(found)
