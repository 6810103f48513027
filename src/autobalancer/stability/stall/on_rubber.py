"""Release and capture on rubber that softens with the amplitude: the whirl that stalled balls make decides how stiff it is.

N balls in line at the speed v load the rotor with the circle v^2 S, S = N m eps, whatever their phase. So the deflection that
suits the stiffness is a function of v alone, and the torque balance of :mod:`autobalancer.laws.stall` holds with

    H(v) = z(v) / (v^2 S),    K(|z|, v).

The unbalance of the rotor whirls at another speed and is left out, as it is on linear supports. On rubber it changes what the
balls feel, too, which only a run knows. Gyroscopic terms are taken with the speed of the rotor at release.

Balls of several planes or kinds: :mod:`autobalancer.stability.stall.borders`.

Where x and y differ the rotor moves in an ellipse, of which the forward circle makes the mean torque of a turn, as on linear
supports. It is found at some hundred speeds and interpolated.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from autobalancer.assembly.rotors import balancer_rows, lateral_model, with_ball_mass
from autobalancer.assembly.rotors.critical import critical_speeds, natural_frequencies
from autobalancer.assembly.rotors.ellipses.steady import Ellipses, ellipses
from autobalancer.assembly.rotors.softened import Softened, softened
from autobalancer.errors import QuestionError
from autobalancer.laws.stall import Receptance, StalledBall, StallRange, stall_ranges
from autobalancer.machine import Machine
from autobalancer.patience import still_time
from autobalancer.stability.border import Border
from autobalancer.stability.host.planar import Complexes, Floats
from autobalancer.stability.stall.groups import StalledGroup
from autobalancer.stability.stall.notes import CAPTURE, DRAGLESS, HOW, RELEASE, never
from autobalancer.stability.stall.one_plane import caught, parted

ON_RUBBER = f"{HOW}, rubber as stiff as at the deflection that they make"
BEYOND = "they move the rubber {0:.3g} mm, beyond its largest breakaway amplitude"
TURN = ", mean torque of a turn, its pulsation left out"
NONE_MET = "no resonance is met"
MOVED = 1e-3  # relative change of a resonance of the rubber, from small to large motions
FARTHEST = 3.0  # whirl over the highest of these resonances
NEAR, FINE, COARSE = (
    0.5,
    0.005,
    0.03,
)  # in the logarithm of the whirl speed: range around the resonances, steps in it and beyond
BELOW, ABOVE = -0.75, 2.35  # the whole range
PASSES = 2  # the second with the rotor as fast as the first says


def rubber_under_balls(machine: Machine) -> Softened | None:
    """The softening rubber of a machine with the masses of its balls; none without any."""
    bare = lateral_model(machine)
    return softened(machine, bare, with_ball_mass(machine, bare))


def on_rubber(
    machine: Machine, soft: Softened, groups: tuple[StalledGroup, ...], capture: bool, limit: float
) -> tuple[Border, ...]:
    """*release speed* and *capture speed* of equal balls of one plane, at resonances up to ``limit``, rad/s."""
    group = groups[0]
    if not group.carries:
        return never(DRAGLESS, capture)
    total = group.count * group.moment
    row = balancer_rows(machine, lateral_model(machine))[group.ball.balancer].deflection
    ball = StalledBall(group.moment, total, group.ball.orbit_radius, group.drag, group.rolling)
    resonances = [speed for speed in _resonances(soft) if speed <= limit]
    limit = min(limit, FARTHEST * max(resonances, default=0.0))
    if not resonances:
        found = (Border(RELEASE, math.nan, NONE_MET), Border(CAPTURE, math.nan, NONE_MET))
        return found if capture else found[:1]
    over = 1.0
    folds: tuple[StallRange, ...] = ()
    for _ in range(PASSES):
        still_time()
        try:
            receptance = whirl_receptance(soft, row, total, over, resonances)
            folds = tuple(fold for fold in stall_ranges(ball, receptance, resonances) if not fold.release_whirl > limit)
        except QuestionError as refused:
            found = (Border(RELEASE, math.nan, str(refused), False), Border(CAPTURE, math.nan, str(refused), False))
            return found if capture else found[:1]
        if not folds or math.isinf(folds[-1].release) or not soft.sliding.gyroscopic.any():
            break
        over = folds[-1].release / folds[-1].release_whirl
    if folds and math.isinf(folds[-1].release):
        return never("no drag is enough at a resonance", capture)
    how = ON_RUBBER + ("" if soft.sliding.isotropic else TURN) + _beyond(soft, row, total, folds, over)
    released = parted(ball, receptance, resonances, folds, group.count, how)
    if not capture:
        return (released,)
    return released, caught(folds, released)


def whirl_receptance(
    soft: Softened, row: Floats, total: float, over: float = 1.0, resonances: Sequence[float] = (1.0,)
) -> Receptance:
    """Deflection over force at the place with this ``row`` under the load v^2 ``total`` (kg m) there, m/N over rad/s.

    Where x and y differ that of the forward circle, between half the lowest and ten times the highest of the ``resonances``.
    """
    if _motion(soft, row, total, np.array([resonances[0]]), over)[0] is None:
        return _in_ellipses(soft, row, total, over, resonances)

    def receptance(whirl: Floats) -> Complexes:
        v = np.atleast_1d(np.asarray(whirl, dtype=float))
        found = soft.steady(v, np.outer(total * v**2, row).astype(np.complex128), "release speed", over=over)
        return np.asarray(found.motion @ row / (total * v**2))

    return receptance


def _in_ellipses(soft: Softened, row: Floats, total: float, over: float, resonances: Sequence[float]) -> Receptance:
    from scipy.interpolate import CubicSpline

    low, high = math.log(min(resonances)), math.log(max(resonances))
    near, far = np.arange(low - NEAR, high + NEAR, FINE), np.arange(low + BELOW, high + ABOVE, COARSE)
    log = np.concatenate([far[far < near[0] - 0.5 * COARSE], near, far[far > near[-1] + 0.5 * COARSE]])
    v = np.exp(log)
    motion, n = _ellipses(soft, row, total, v, over).motion, soft.sliding.pairs
    spline = CubicSpline(log, 0.5 * (motion[:, :n] @ row + 1j * motion[:, n : 2 * n] @ row) / (total * v**2))

    def receptance(whirl: Floats) -> Complexes:
        return np.asarray(spline(np.log(np.atleast_1d(np.asarray(whirl, dtype=float)))), np.complex128)

    return receptance


def _ellipses(soft: Softened, row: Floats, total: float, v: Floats, over: float) -> Ellipses:
    load = np.concatenate([row, -1j * row, np.zeros(soft.sliding.size - 2 * row.size)])
    return ellipses(soft, v, np.outer(total * v**2, load), "release speed", over=over)


def _motion(
    soft: Softened, row: Floats, total: float, v: Floats, over: float
) -> tuple[Complexes | None, Floats | None]:
    """Motion in circles and amplitudes of the rubber; none in ellipses."""
    found = soft.circles(v, np.outer(total * v**2, row).astype(np.complex128), over=over)
    return (None, None) if found is None else (found.motion, found.amplitude)


def _resonances(soft: Softened) -> list[float]:
    """Critical speeds of small and of large motions, rad/s, of those that the rubber moves."""
    sizes = sorted({limit for law in soft.laws for _, limit in law.friction})
    tried = [0.5 * sizes[0], 2.0 * sizes[-1]] if sizes else [1e-6]
    first = float(natural_frequencies(soft.sliding)[0])
    every = [critical_speeds(soft.at_amplitude(size, first)) for size in tried]
    still = set(every[0]) if len(every) == 1 else set()
    moved = {
        speed for one, other in pairwise(every) for speed in one if all(abs(speed - w) > MOVED * speed for w in other)
    }
    moved |= {speed for speed in every[-1] if all(abs(speed - w) > MOVED * speed for w in every[0])}
    return sorted(moved | still) or list(every[0])


def _beyond(soft: Softened, row: Floats, total: float, folds: tuple[StallRange, ...], over: float) -> str:
    if not folds:
        return ""
    v = np.array([folds[-1].release_whirl])
    size = _motion(soft, row, total, v, over)[1]
    size = _ellipses(soft, row, total, v, over).amplitude if size is None else size
    sizes = [float(one) for one, law in zip(size[0], soft.laws, strict=True) if one > law.largest_amplitude]
    return f"; {BEYOND.format(1e3 * max(sizes))}" if sizes else ""
