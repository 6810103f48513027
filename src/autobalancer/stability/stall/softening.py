"""Balances of stalled balls on rubber that softens: the whirl that they make decides how stiff it is, and this the whirl.

At given phases the balls load the rotor with a circle at v, so that its steady motion is known, with all stiffness that suits it:
a circle, or an ellipse where x and y differ. The balances and their slopes, by differences, are those of
:mod:`autobalancer.stability.stall.states`. They are sought from those of linear rotors, as stiff as at several amplitudes.

Small motions about such a state change the stiffness, too. The forces of the elements are taken to follow the size and the
phase of the whirl at once, with the slopes of their first harmonic; a friction element forgets within a small part of a turn.

The loss of an elastoplastic element begins with the root of the amplitude beyond that at which it slides. There a branch has a
corner, which is stepped over; where no state is found beyond it the branch turns back there, as in a fold.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autobalancer.assembly.rotors.critical import natural_frequencies
from autobalancer.assembly.rotors.ellipses.forces import Elements
from autobalancer.assembly.rotors.ellipses.steady import FROM_CIRCLES, TO_CIRCLES, attempted, seen
from autobalancer.assembly.rotors.softened import Softened
from autobalancer.stability.host.planar import Complexes, Floats
from autobalancer.stability.host.stations import Stations
from autobalancer.stability.stall.groups import Loads
from autobalancer.stability.stall.states import Balance, States
from autobalancer.stability.stall.whirling import AllModes, Whirling

DIFFERENCE = 1e-6  # of log (slip over whirl), of phases and, relative, of amplitudes
SHORT = 1e-4  # step along a branch below which it is given up
CORNER = 5e-3  # relative distance of an amplitude from a breakaway amplitude, where a branch turns back in a corner
BEYOND, NEAR = (1e-4, 3e-4, 1e-3), 0.1  # how much faster the rotor is beyond a corner, and how far the state may move
RATIO = 2.5  # of neighboring amplitudes from whose stiffness balances are sought
WIDE = 2.0  # how far they go beyond the breakaway amplitudes


@dataclass(frozen=True)
class Softening(Balance):
    """A set of groups on softening rubber; ``rotor`` is that whose elements all slide.

    ``frozen`` are linear rotors as stiff as at some amplitudes, from the softest to the stiffest.
    """

    soft: Softened
    frozen: tuple[Whirling, ...]
    numbers = None
    shortest = SHORT

    def of(self, groups: tuple[int, ...]) -> Softening:
        """Some of the groups."""
        return replace(self, loads=self.loads.some(groups))

    def modes_of(self, speeds: Floats) -> AllModes | None:
        """None, since they depend on the amplitude."""
        return None

    def resonant(self, states: States) -> NDArray[np.bool_]:
        """As on the softest or on the stiffest rubber."""
        both = (rotor.hang(states.speed, states.whirl) for rotor in (self.frozen[0], self.frozen[-1]))
        return np.asarray(np.logical_or(*both))

    def found(self, speeds: Floats) -> list[States]:
        """All balances that are near one of a linear rotor, at each rotor speed."""
        begun = [one for rotor in self.frozen for one in Balance(rotor, self.loads).found(speeds)]
        return self.sorted(
            States(np.concatenate([one.speed for one in begun]), np.vstack([one.y for one in begun])), speeds
        )

    def turns(self, states: States) -> bool:
        """Whether an element is about to slide, where a branch has a corner."""
        stretch = self.stretches(states)[-1]
        limits = [np.array([limit for _, limit in law.friction]) for law in self.soft.laws]
        return any(bool((np.abs(a / limit - 1.0) < CORNER).any()) for a, limit in zip(stretch, limits, strict=True))

    def ahead(self, state: States) -> States | None:
        """The state beyond the corner, at a slightly higher speed; none if the branch turns back there."""
        for more in BEYOND:
            found = self.corrected(States(state.speed * (1.0 + more), state.y))
            if found.speed.size and np.abs(found.y - state.y).max() < NEAR:
                return found
        return None

    def stretches(self, states: States) -> Floats:
        """Amplitude of each piece of rubber, the major semi-axis of an ellipse, (n, M) m."""
        motion = self.motion(states)
        if self.rotor.isotropic:
            return np.abs(motion @ self.soft.rows.T)
        return np.asarray(np.abs(seen(self.soft, motion)).sum(axis=-1))

    def motion(self, states: States) -> Complexes:
        """Of the coordinates, (n, pairs) if they circle, (n, N) in ellipses; nan where none is found."""
        v, rows = states.whirl, self.rotor.st.rows[self.loads.station]
        load = v[:, None] ** 2 * ((self.loads.count * self.loads.moment * np.exp(1j * states.phases)) @ rows)
        over = states.speed / v
        known = np.isfinite(states.y).all(axis=1)
        found = np.full((v.size, self.rotor.load.shape[0]), np.nan, np.complex128)
        if not known.any():
            return found
        v, over, load = v[known], over[known], load[known]
        if self.rotor.isotropic:
            circles = self.soft.circles(v, load, over=over, attempted=True)
            assert circles is not None
            moved = circles.motion
        else:
            rest = np.zeros((v.size, self.soft.sliding.size - 2 * load.shape[1]))
            moved = attempted(self.soft, v, np.hstack([load, -1j * load, rest]), over=over).motion
        found[known] = moved
        return found

    def deflections(self, states: States) -> Complexes:
        """q h of each group, (n, G), m."""
        motion, rows = self.motion(states), self.rotor.st.rows[self.loads.station]
        n = rows.shape[1]
        if self.rotor.isotropic:
            place = motion @ rows.T
        else:
            place = 0.5 * (motion[:, :n] @ rows.T + 1j * motion[:, n : 2 * n] @ rows.T)
        return np.asarray((1.0 + 1j * self.rolling) * place * np.exp(-1j * states.phases))

    def misfit(self, states: States, modes: AllModes | None = None) -> tuple[Floats, Floats]:
        """Brake over need less one, (n, G), and its slopes over y, (n, G, G)."""
        n, groups = states.y.shape
        moved = np.concatenate([np.zeros((1, groups)), DIFFERENCE * np.eye(groups)])
        y = (states.y + moved[:, None, :]).reshape(-1, groups)
        every = States(np.tile(states.speed, groups + 1), y)
        v = every.whirl
        brake = -self.loads.moment * v[:, None] ** 2 * self.deflections(every).imag
        miss = (brake / self.needed(every.slip, v) - 1.0).reshape(groups + 1, n, groups)
        return miss[0], np.moveaxis((miss[1:] - miss[0]) / DIFFERENCE, 0, 2)

    def softening(self, states: States) -> Floats:
        """Accelerations of the rotor by what the elements add, over the real and imaginary parts of its deflections."""
        motion = self.motion(states)
        force = self._of_circles(motion, states) if self.rotor.isotropic else self._of_ellipses(motion, states)
        light = _real(self.rotor.lightness)
        return np.asarray(-light @ force)

    def _of_circles(self, motion: Complexes, states: States) -> Floats:
        rows, share = self.soft.rows, self.soft.shares
        stretch = motion @ rows.T
        size = np.abs(stretch)
        here, more = (self.soft.added(size * (1.0 + step), states.whirl) for step in (0.0, DIFFERENCE))
        ahead = stretch / np.where(size > 0.0, size, 1.0)
        seen = np.stack([_real(row[None]) for row in rows])  # (M, 2, 2 n)
        found = np.zeros((len(motion), *2 * (2 * rows.shape[1],)))
        for m, rows_of_one in enumerate(seen):
            steeper = (more[:, m] - here[:, m]) / DIFFERENCE * ahead[:, m]  # over the change of size
            inward = np.stack([ahead[:, m].real, ahead[:, m].imag], axis=-1)
            outward = np.stack([steeper.real, steeper.imag], axis=-1)
            slope = np.array([_real(np.array([[one]])) for one in here[:, m]])
            slope = slope + outward[:, :, None] * inward[:, None, :]
            found += share[m] * rows_of_one.T @ slope @ rows_of_one
        return found

    def _of_ellipses(self, motion: Complexes, states: States) -> Floats:
        found = np.zeros((len(motion), *2 * (2 * motion.shape[1],)))
        every = np.arange(len(motion))
        for law, mount in zip(self.soft.laws, self.soft.mounts, strict=True):
            circles = TO_CIRCLES @ mount.rows
            slope = Elements.of(law, every.size).on(every, motion @ circles.T, states.whirl).slope
            pair = [0, 2, 1, 3]  # real parts first
            slope = slope[:, pair][:, :, pair]
            found += _real(mount.rows.T @ FROM_CIRCLES) @ slope @ _real(circles)
        return found


def softening(soft: Softened, st: Stations, loads: Loads) -> Softening:
    """The balances of groups on the rubber of a machine with these stations."""
    sizes = [limit for law in soft.laws for _, limit in law.friction] or [1.0]
    low, high = min(sizes) / WIDE, max(sizes) * WIDE
    amplitudes = np.geomspace(high, low, 2 + round(np.log(high / low) / np.log(RATIO)))
    speed = float(natural_frequencies(soft.sliding)[0])
    frozen = tuple(Whirling(replace(st, model=soft.at_amplitude(size, speed))) for size in amplitudes)
    load = np.asarray(speed**2 * (loads.count * loads.moment) @ st.rows[loads.station], np.complex128)
    probe = soft.circles(np.array([speed]), load[None])
    return Softening(Whirling(replace(st, model=soft.sliding), apart=probe is None), loads, soft, frozen)


def _real(matrix: Any) -> Any:
    """A complex linear map as one of real and imaginary parts."""
    return np.block([[matrix.real, -matrix.imag], [matrix.imag, matrix.real]])
