"""How far pieces of rubber are stretched in circles, so that their stiffness and the motion of the rotor suit each other.

With the receptance H between G groups of pieces, kappa of their elements and the stretches s_0 without them

    (1 + H kappa(|s|)) s = s_0 .
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from autobalancer.assembly.rotors.model import Complexes, Floats
from autobalancer.laws.rubber import Motion, RubberLaw

STEPS, EXACT = 60, 1e-15  # of the search for an amplitude
ROUNDS, SURE, NEAR = (
    300,
    1e-12,
    1e-8,
)  # over several pieces, until no amplitude changes by more; and by how much at the end
FARTHER = 0.3, 20.0  # least and most by which a change is carried on
NEWTON, HALVES = 25, 8  # steps of Newton's method, and how often one is halved
DIFFERENCE = 1e-7  # relative, of an amplitude

Laws = list[tuple[RubberLaw, Motion]]


def in_turns(laws: Laws, speeds: Floats, across: Complexes, free: Complexes) -> tuple[Floats, np.ndarray]:
    """Amplitudes of groups of rubber, (S, G), and the numbers of speeds without any: of each in turn.

    It has the stiffness of the others, until none changes.

    Where they creep, they are carried on in the direction in which they change (Irons and Tuck 1969).
    """
    if len(laws) == 1:
        return _root(laws[0], speeds, across[:, 0, 0], np.abs(free[:, 0]))[:, None], np.zeros(0, np.int64)
    amplitude = np.abs(free)
    left = np.arange(speeds.size)  # speeds at which amplitudes still change
    before = np.zeros_like(amplitude)
    ahead = np.ones(speeds.size)
    for number in range(ROUNDS):
        found = _in_turn(laws, speeds[left], across[left], free[left], amplitude[left])
        change = found - amplitude[left]
        moved = np.abs(change).max(axis=1) > SURE * found.max(axis=1)
        amplitude[left[~moved]] = found[~moved]
        if not moved.any():
            return amplitude, np.zeros(0, np.int64)
        left, found, change = left[moved], found[moved], change[moved]
        if number:
            bend = change - before[left]
            size = np.maximum((bend**2).sum(axis=1), 1e-300)
            ahead[left] = np.clip(-ahead[left] * (before[left] * bend).sum(axis=1) / size, *FARTHER)
        before[left] = change
        amplitude[left] = np.maximum(amplitude[left] + ahead[left, None] * change, 0.1 * found)
    return amplitude, left[np.abs(change).max(axis=1) > NEAR * found.max(axis=1)]


def _in_turn(laws: Laws, speeds: Floats, across: Complexes, free: Complexes, amplitude: Floats) -> Floats:
    """The amplitude of each group that suits those of the others, one after the other."""
    found = amplitude.copy()
    kappa = np.stack([_elements(law, found[:, g], speeds) for g, law in enumerate(laws)], axis=1)
    for g, law in enumerate(laws):
        h, s = _alone(g, across, free, kappa)
        found[:, g] = _root(law, speeds, h, np.abs(s))
        kappa[:, g] = _elements(law, found[:, g], speeds)
    return found


def _alone(g: int, across: Complexes, free: Complexes, kappa: Complexes) -> tuple[Complexes, Complexes]:
    """H and s_0 of one group where the others are springs."""
    rest = [other for other in range(kappa.shape[1]) if other != g]
    held = np.eye(len(rest)) + across[:, rest][:, :, rest] * kappa[:, None, rest]
    over = across[:, g, rest] * kappa[:, rest]
    h = across[:, g, g] - np.einsum("so,so->s", over, np.linalg.solve(held, across[:, rest, g, None])[..., 0])
    s = free[:, g] - np.einsum("so,so->s", over, np.linalg.solve(held, free[:, rest, None])[..., 0])
    return np.asarray(h), np.asarray(s)


def _elements(law: tuple[RubberLaw, Motion], amplitude: Floats, speeds: Floats) -> Complexes:
    return replace(law[0], elastic=0.0, viscous=0.0).stiffness(amplitude, speeds, law[1])


def _root(law: tuple[RubberLaw, Motion], speeds: Floats, h: Complexes, free: Floats) -> Floats:
    """The root of |1 + H kappa(a)| a = |s_0| at each speed, (S,), by Ridders' method."""

    elements, motion = replace(law[0], elastic=0.0, viscous=0.0), law[1]

    def miss(amplitude: Floats) -> Floats:
        return np.asarray(np.abs(1.0 + h * elements.stiffness(amplitude, speeds, motion)) * amplitude - free)

    low, below, high = np.zeros_like(free), -free, free.copy()
    above = miss(high)
    for _ in range(200):  # kappa falls with the amplitude, so that this ends
        short = above < 0.0
        if not short.any():
            break
        low, below, high = np.where(short, high, low), np.where(short, above, below), np.where(short, 2.0 * high, high)
        above = miss(high)
    new = high
    for _ in range(STEPS):
        middle, before = 0.5 * (low + high), new
        at = miss(middle)
        root = np.sqrt(np.maximum(at * at - below * above, 0.0))
        new = np.clip(
            middle + (middle - low) * np.divide(-at, root, out=np.zeros_like(at), where=root > 0.0), low, high
        )
        for point, value in ((middle, at), (new, miss(new))):
            lower, upper = (value < 0.0) & (point >= low), (value >= 0.0) & (point <= high)
            low, below = np.where(lower, point, low), np.where(lower, value, below)
            high, above = np.where(upper, point, high), np.where(upper, value, above)
        if np.all((np.abs(new - before) <= EXACT * new) | (high - low <= EXACT * high)):
            break
    return np.where(np.abs(above) <= np.abs(below), high, low)


def by_newton(laws: Laws, speeds: Floats, across: Complexes, free: Complexes) -> tuple[Floats, np.ndarray]:
    """The same by Newton's method, much faster for several groups; from the stiffest rubber, else from the softest."""
    if len(laws) == 1:
        return in_turns(laws, speeds, across, free)
    amplitude, left = np.abs(free), np.arange(speeds.size)
    for size in (0.0, np.inf):
        found, done = _newton(laws, speeds[left], across[left], free[left], size)
        amplitude[left[done]] = found[done]
        left = left[~done]
        if not left.size:
            break
    return amplitude, left


def _newton(laws: Laws, speeds: Floats, across: Complexes, free: Complexes, size: float) -> tuple[Floats, np.ndarray]:
    """Amplitudes, and at which speeds they were found, beginning as stiff as at one ``size``."""
    count = len(laws)
    begun = np.full(free.shape, min(size, 1e3 * float(np.abs(free).max(initial=0.0)) + 1.0))
    kappa = np.stack([_elements(law, begun[:, g], speeds) for g, law in enumerate(laws)], axis=1)
    begun_at = np.linalg.solve(np.eye(count) + across * kappa[:, None, :], free[..., None])[..., 0]
    s = np.asarray(begun_at, np.complex128)
    done, left = np.zeros(speeds.size, np.bool_), np.arange(speeds.size)

    def missed(which: np.ndarray, s: Complexes) -> tuple[Complexes, Complexes]:
        kappa = np.stack([_elements(law, np.abs(s[:, g]), speeds[which]) for g, law in enumerate(laws)], axis=1)
        return s + (across[which] @ (kappa * s)[..., None])[..., 0] - free[which], kappa

    for _ in range(NEWTON):
        here, h = s[left], across[left]
        miss, kappa = missed(left, here)
        size_of = np.abs(here)
        more = [_elements(law, size_of[:, g] * (1.0 + DIFFERENCE), speeds[left]) for g, law in enumerate(laws)]
        ahead = here / np.where(size_of > 0.0, size_of, 1.0)
        steeper = (np.stack(more, axis=1) - kappa) / DIFFERENCE * ahead
        # over real and imaginary parts of s, each (S, G)
        slopes = [across_of(h, kappa * part + steeper * along) for part, along in ((1.0, ahead.real), (1j, ahead.imag))]
        whole = np.concatenate([slopes[0] + np.eye(count), slopes[1] + 1j * np.eye(count)], axis=2)
        real = np.concatenate([whole.real, whole.imag], axis=1)
        step = -np.linalg.solve(real, np.concatenate([miss.real, miss.imag], axis=1)[..., None])[..., 0]
        change = step[:, :count] + 1j * step[:, count:]
        level, far = np.abs(miss).max(axis=1), np.arange(left.size)
        for _ in range(HALVES):
            worse = (
                np.abs(missed(left[far], np.asarray(here[far] + change[far], np.complex128))[0]).max(axis=1)
                > level[far]
            )
            far = far[worse & (np.abs(change[far]).max(axis=1) > NEAR * size_of[far].max(axis=1))]
            if not far.size:
                break
            change[far] *= 0.5
        s[left] = np.asarray(here + change, np.complex128)
        ended = np.abs(change).max(axis=1) <= SURE * size_of.max(axis=1)
        done[left[ended]] = True
        left = left[~ended]
        if not left.size:
            break
    return np.abs(s), done


def across_of(across: Complexes, column: Complexes) -> Complexes:
    """H times a diagonal matrix, (S, G, G)."""
    return np.asarray(across * column[:, None, :])
