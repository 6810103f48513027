"""Balls that stall near a critical speed: torque balance for any drag law, with rolling resistance.

Balls that circle in space in line at the speed v drive the rotor with v^2 sum s, s = m eps. Its whirl brakes each of them
and changes the force with which it is pressed to the race; with the receptance H(v) at the race, m/N, for forward whirl,

    T_brake = - s (sum s) v^4 Im H,    F_N = m v^2 (eps + (sum s) v^2 Re H).

The fluid, which turns with the rotor at W, and the race under the ball drag it on:

    T_drag(W - v) + mu_R F_N eps = T_brake.

Solved for W this is a curve W(v). It rises to a fold at a resonance, above which no ball can stall there: the release speed.
Beyond, it falls to a second fold, and rises again along W = v. Between both folds balls in line may either stall near the
resonance or turn nearly with the rotor.

Several balls stay in line only while the whirl draws them together, Re[(1 + i mu_R) H] > 0: a ball that gets ahead of the others
by delta feels -s v^2 sum s v^2 Re[...] delta and leaves the whirl as it is. So they part at the phase of the resonance, a little
before the fold; with linear drag and mu_R = 0 that is v = w_c and Spannan (2021), (4.73).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from autobalancer.arrays import Floats
from autobalancer.errors import QuestionError
from autobalancer.roots import least, root
from autobalancer.units import argument, field_arguments, list_argument, texts_argument

# What adherence holds on a race: the whirl below which no ball moves, and the residual unbalance that may stay.
#
# A ball at the angle phi of a race whose center runs a distance c beside the axis of rotation (both seen from the
# rotor, at constant speed w) is pushed along the race with m w^2 |Im(c e^-i phi)| and pressed on it with m w^2 (eps +
# Re(c e^-i phi)). It stays at rest while the first is below adherence times the second (Spannan 2021, section 4.2.3;
# conditions derived here).


STEP = 4e-3  # relative, of the residuals that are tried
TOGETHER = 50  # of them at once
_DIRECTIONS = np.linspace(-math.pi, math.pi, 180, endpoint=False)


def held_whirl(orbit_radius: float | str, adherence: float, *, weight: float | str = 0.0) -> float:
    """Distance of a race from the axis of rotation up to which a ball at rest stays at any angle, m.

    ``mu eps / sqrt(1 + mu^2) - g/w^2``: the force along the race is greatest, against what holds, where the ball stands
    ``90 deg - atan(mu)`` before the line of the whirl. It does not depend on mass or size of the ball.

    Parameters
    ----------
    orbit_radius
        m.
    adherence
        Greatest force that holds a ball at rest, over the wall force.
    weight
        Acceleration of gravity in the plane of the race over the square of the speed, g/w^2, m: on a horizontal axis
        it moves each ball back and forth once per revolution. A negative result means that this alone moves the balls.

    Raises
    ------
    QuestionError
        If a number is negative, or the orbit radius zero.
    """
    orbit_radius = argument("orbit_radius", orbit_radius, "m")
    weight = argument("weight", weight, "m")
    if not orbit_radius > 0.0:
        raise QuestionError(f"orbit_radius: given {orbit_radius:g} m; must be above zero")
    if adherence < 0.0 or weight < 0.0:
        raise QuestionError(f"adherence, weight: given {adherence:g}, {weight:g}; must not be below zero")
    return adherence * orbit_radius / math.sqrt(1.0 + adherence**2) - weight


def largest_held_residual(
    need: tuple[float, float], moments: Sequence[float], held: float, *, phase: float = math.pi
) -> float:
    """Largest residual unbalance at which the balls of one plane can stop on their way to balance, kg m.

    Up to ``held`` they may stand anywhere. Beyond it a ball rests only within ``asin(held/r)`` of the line of the whirl. So a
    residual r is possible if the unbalance to be balanced is that of r and of balls in these sectors, outwards or inwards.
    Residuals are gone through, from the least that the balls can leave, until one is not possible. Balls trapped near the
    line of the unbalance, where they balance nothing, are beyond that gap and not counted.

    Parameters
    ----------
    need
        Least and greatest size of the unbalance to be balanced, kg m.
    moments
        Of the balls of the plane, kg m.
    held
        Residual unbalance that makes the whirl which friction holds everywhere, kg m.
    phase
        Of the whirl against the residual, rad; pi well above the critical speed.

    Returns
    -------
    float
        At most the sum of the greatest need and all moments. A bound: sectors are taken with their chords.
    """
    most = need[1] + float(sum(moments))
    if held <= 0.0:
        return 0.0
    if held >= most:
        return most
    sides = _patterns(tuple(sorted(round(moment, 15) for moment in moments)))
    total, greatest = float(sum(moments)), max(moments)
    least = max(need[0] - total, 2.0 * greatest - total - need[1], 0.0)  # what the balls leave even without friction
    first = max(held, least * (1.0 - 1e-9))
    residuals = np.geomspace(first, most, math.ceil(math.log(most / first) / STEP) + 2)
    begun, nearest = least <= held, (math.inf, most)
    for part in np.array_split(residuals, math.ceil(residuals.size / TOGETHER)):
        low, high = _reach(part, phase, np.arcsin(np.minimum(held / part, 1.0)), sides)
        gap = np.maximum(low - need[1], need[0] - high).min(axis=1)
        possible = gap <= 1e-9 * most
        ended = ~possible & (begun | (np.cumsum(possible) > 0))
        if ended.any():
            return float(part[np.argmax(ended)])
        begun = begun or bool(possible.any())
        nearest = min(nearest, (float(gap.min()), float(part[np.argmin(gap)])))
    return most if begun else nearest[1]  # sectors narrower than a step: the residual that misses them least


@lru_cache(maxsize=32)
def _patterns(moments: tuple[float, ...]) -> Floats:
    """Sum of the moments of balls that stand outwards, and inwards, for all choices, (K, 2)."""
    if len(set(moments)) == 1:
        count = len(moments)
        outward = np.arange(count + 1.0) * moments[0]
        return np.column_stack([outward, outward[::-1]])
    if len(moments) > 12:
        shares = np.linspace(0.0, sum(moments), 25)
        return np.column_stack([shares, shares[::-1]])
    picks = product((0.0, 1.0), repeat=len(moments))
    chosen = {round(float(np.dot(pick, moments)), 15) for pick in picks}
    outward = np.array(sorted(chosen))
    return np.column_stack([outward, sum(moments) - outward])


def _reach(residuals: Floats, phase: float, half: Floats, sides: Floats) -> tuple[Floats, Floats]:
    """Least and greatest unbalance that each residual and balls in their sectors can be the sum of, (residuals, patterns)."""
    outward = _support(_DIRECTIONS - phase - math.pi, half)[:, None, :]
    inward = _support(_DIRECTIONS - phase, half)[:, None, :]
    # unbalance = residual - balls: support function of the set of its vectors, the residual along zero
    support = residuals[:, None, None] * np.cos(_DIRECTIONS) + sides[:, :1] * outward + sides[:, 1:] * inward
    return np.maximum((-support).max(axis=2), 0.0), support.max(axis=2)


def _support(angle: Floats, half: Floats) -> Floats:
    """How far arcs of the unit circle, each from -half to half, reach in directions, (arcs, directions)."""
    off = np.abs(np.angle(np.exp(1j * angle)))
    return np.asarray(np.cos(np.maximum(off - half[:, None], 0.0)), np.float64)


# Where adherence holds one ball on a race: near the place at which it balances, or near the heavy one it should leave.
#
# Planar rotor with isotropic supports, steady speed.


def rest_interval(
    unbalance: float | str,
    moment: float | str,
    orbit_radius: float | str,
    adherence: float,
    *,
    mass: float | str,
    stiffness: float | str,
    damping: float | str = 0.0,
    speed: float | str,
    heavy: bool = False,
) -> tuple[float, float]:
    """Both ends of the interval in which a ball at rest in the rotor stays, as angles from its place.

    The rotor whirls under unbalance and ball, z = (U + s e^(i phi)) w^2 H(w). A ball stays while the force along the race is
    below adherence times the wall force, ``|Im(z e^(-i phi))|`` <= mu (eps + Re(z e^(-i phi))). On an undamped rotor whose ball
    balances exactly this is, for small angles, ``mu eps |M w^2 - k|/(U w^2)`` to either side.

    Parameters
    ----------
    unbalance, moment
        Of the rotor, and effective mass of the ball times orbit radius, kg m.
    orbit_radius
        m.
    adherence
        Greatest force that holds a ball at rest, over the wall force.
    mass, stiffness, damping
        Of the rotor with the ball in it, kg, N/m, N s/m.
    speed
        rad/s.
    heavy
        Around the place of the unbalance, where a ball at rest adds to the unbalance above the critical speed; else around
        the place opposite to it.

    Returns
    -------
    tuple
        Angles in rad, negative and positive end; -pi or pi where adherence holds the ball all around.

    Raises
    ------
    QuestionError
        If a number is not above zero (damping: below zero), or no place within 90 degrees holds the ball.
    """
    unbalance = argument("unbalance", unbalance, "kg*m")
    moment = argument("moment", moment, "kg*m")
    orbit_radius = argument("orbit_radius", orbit_radius, "m")
    mass = argument("mass", mass, "kg")
    stiffness = argument("stiffness", stiffness, "N/m")
    damping = argument("damping", damping, "N*s/m")
    speed = argument("speed", speed, "rad/s")
    for name, value in (("unbalance", unbalance), ("moment", moment), ("orbit_radius", orbit_radius),
                        ("adherence", adherence), ("mass", mass), ("stiffness", stiffness), ("speed", speed)):  # fmt: skip
        if not value > 0.0:
            raise QuestionError(f"rest_interval: {name}: given {value:g}; must be above zero")
    if damping < 0.0:
        raise QuestionError(f"rest_interval: damping: given {damping:g}; must not be below zero")
    gain = speed**2 / complex(stiffness - mass * speed**2, damping * speed)

    ends = rest_ends(gain, unbalance, moment, orbit_radius, adherence, heavy=heavy)
    if ends is None:
        raise QuestionError(
            f"rest_interval: adherence {adherence:g} holds no ball {'near' if heavy else 'opposite to'} the unbalance"
        )
    return ends


def rest_ends(
    gain: complex, unbalance: float, moment: float, orbit_radius: float, adherence: float, *, heavy: bool = False
) -> tuple[float, float] | None:
    """The same for any rotor, ``gain`` being its whirl for an unbalance at the place of the ball, 1/kg; None without one.

    ``unbalance`` is that of the rotor and of all other balls in the plane.
    """
    toward = 1.0 if heavy else -1.0

    def excess(delta: Any) -> Any:
        seen = (moment + toward * unbalance * np.exp(-1j * delta)) * gain  # z in axes along the ball
        return np.abs(seen.imag) - adherence * (orbit_radius + seen.real)

    tried = np.linspace(-0.5 * math.pi, 0.5 * math.pi, 4001)
    held = tried[excess(tried) < 0.0]
    if not held.size:
        return None
    middle = float(held[np.argmin(np.abs(held))])
    ends = []
    for side in (-math.pi, math.pi):
        tried = np.linspace(middle, middle + side, 4001)
        over = np.flatnonzero(excess(tried) > 0.0)
        first = int(over[0]) if over.size else 0
        ends.append(root(excess, tried[first - 1], tried[first], xtol=1e-14) if first else side)
    return ends[0], ends[1]


Receptance = Callable[[Floats], NDArray[np.complex128]]
Torque = Callable[[Floats], Floats]

POINTS = 600  # on each side of a resonance
LOW, HIGH = 0.5, 9.0  # farthest points, in resonance speeds below and above it
STEPS = 60  # at most


@dataclass(frozen=True)
class StalledBall:
    """One of the balls that stall together.

    ``moment`` s = m eps with the effective mass (kg m) and ``total``, the sum over all that stall in line, N s for N equal
    ones; ``orbit_radius`` m; ``drag``, the torque (N m) against a slip (rad/s, of shape (n,)), which must not fall;
    ``rolling``, the coefficient mu_R of rolling resistance.
    """

    moment: float
    total: float
    orbit_radius: float
    drag: Torque
    rolling: float = 0.0

    def __post_init__(self) -> None:
        field_arguments(self, moment="kg*m", total="kg*m", orbit_radius="m")


@dataclass(frozen=True)
class StallBalance:
    """Terms of the balance against the whirl speed, arrays of one shape: rad/s, N m and N.

    ``excess`` is what rolling resistance leaves for the drag, at least 0; ``slip`` is W - v, infinite where no drag
    is enough; ``speed`` is W. Where ``excess`` is 0 the balls rest on the race.
    """

    whirl: Floats
    braking: Floats
    normal_force: Floats
    excess: Floats
    slip: Floats
    speed: Floats


@dataclass(frozen=True)
class StallRange:
    """The two folds of one resonance, rotor speeds and whirl speeds in rad/s.

    Balls can stall up to ``release``. In line, they can turn nearly with the rotor down to ``capture``; below, they fall
    back to the resonance.
    """

    release: float
    release_whirl: float
    capture: float
    capture_whirl: float


def planar_receptance(mass: float | str, stiffness: ArrayLike, damping: ArrayLike) -> Receptance:
    """Receptance of a planar rotor for forward whirl: the mean of both axes.

    ``mass`` in motion, balls included; ``stiffness`` and ``damping`` one number, or two along x and y; SI.
    """
    mass = argument("mass", mass, "kg")
    stiffness = texts_argument("stiffness", stiffness, "N/m")
    damping = texts_argument("damping", damping, "N*s/m")
    k, b = (np.atleast_1d(np.asarray(given, dtype=float)) for given in (stiffness, damping))

    def receptance(whirl: Floats) -> NDArray[np.complex128]:
        v = np.asarray(whirl, dtype=float)[..., None]
        return np.asarray((1.0 / (k - mass * v**2 + 1j * b * v)).mean(axis=-1))

    return receptance


def stall_balance(ball: StalledBall, receptance: Receptance, whirl: ArrayLike) -> StallBalance:
    """Torques on a stalled ``ball`` and the rotor speed that keeps it stalled, for ``whirl`` speeds (rad/s) of shape (n,).

    ``receptance`` (m/N, complex, over rad/s) is that of the rotor at the plane of the balls.
    """
    whirl = texts_argument("whirl", whirl, "rad/s")
    v = np.atleast_1d(np.asarray(whirl, dtype=float))
    response = ball.total * v**2 * receptance(v)
    braking = -ball.moment * v**2 * response.imag
    normal = ball.moment * v**2 * (1.0 + response.real / ball.orbit_radius)
    excess = np.maximum(braking - ball.rolling * ball.orbit_radius * np.maximum(normal, 0.0), 0.0)
    slip = _slip(ball.drag, excess)
    return StallBalance(v, braking, normal, excess, slip, v + slip)


def stall_ranges(
    ball: StalledBall, receptance: Receptance, resonances: Sequence[float | str]
) -> tuple[StallRange, ...]:
    """The folds at all resonances at which balls can stall, in the order of the release speeds; none if they never do.

    ``ball`` is one of all in line, ``receptance`` (m/N, complex, over rad/s) that of the rotor at their plane.

    ``resonances`` are the undamped critical speeds, near which folds are sought, rad/s. ``release`` is infinite if no drag
    is enough, ``capture`` nan if the curve does not turn again below ten times the highest resonance.
    """
    resonances = list_argument("resonances", resonances, "rad/s")
    near = np.geomspace(1e-7, LOW, POINTS)
    far = np.geomspace(1e-7, HIGH, 2 * POINTS)
    whirl = np.unique(np.concatenate([w * (1.0 + np.concatenate([-near, [0.0], far])) for w in resonances]))

    def curve(v: ArrayLike) -> Floats:
        return stall_balance(ball, receptance, v).speed

    speed = curve(whirl)
    if np.isinf(speed).all():
        return (StallRange(math.inf, float(max(resonances)), math.nan, math.nan),)
    inner = speed[1:-1]
    tops = 1 + np.flatnonzero((inner > speed[:-2]) & (inner >= speed[2:]))
    ends = 1 + np.flatnonzero((inner < speed[:-2]) & (inner <= speed[2:]))
    stall_ranges = []
    for top in tops:
        release_whirl, release = _fold(curve, whirl, int(top), 1.0)
        after = ends[ends > top]
        capture_whirl, capture = _fold(curve, whirl, int(after[0]), -1.0) if after.size else (math.nan, math.nan)
        stall_ranges.append(StallRange(release, release_whirl, capture, capture_whirl))
    return tuple(sorted(stall_ranges, key=lambda fold: fold.release))


def parting_speeds(
    ball: StalledBall, receptance: Receptance, resonances: Sequence[float]
) -> tuple[tuple[float, float], ...]:
    """Rotor speed and whirl speed (rad/s) at which several balls in line part, of each resonance at which they stall."""

    def drawn(v: ArrayLike) -> Floats:
        return np.asarray(((1.0 + 1j * ball.rolling) * receptance(np.atleast_1d(v))).real)

    near = np.geomspace(1e-7, LOW, POINTS)
    whirl = np.unique(np.concatenate([w * (1.0 + np.concatenate([-near, [0.0], near])) for w in resonances]))
    result = drawn(whirl)
    places = np.flatnonzero((result[:-1] > 0.0) & (result[1:] <= 0.0))
    roots = [root(lambda v: float(drawn(v)[0]), whirl[i], whirl[i + 1], xtol=1e-13 * whirl[i]) for i in places]
    at = stall_balance(ball, receptance, np.array(roots)) if roots else None
    if at is None:
        return ()
    stalls = (at.excess > 0.0) & np.isfinite(at.speed)
    return tuple(zip(at.speed[stalls].tolist(), at.whirl[stalls].tolist(), strict=True))


def _slip(drag: Torque, needed: Floats) -> Floats:
    """The slip at which the drag is what is needed; zero where nothing is, infinite where it is never enough."""
    high = np.ones_like(needed)
    for _ in range(60):
        short = drag(high) < needed
        if not short.any():
            break
        high = np.where(short, 4.0 * high, high)
    above = drag(high) - needed
    never = above < 0.0
    low, below, new = np.zeros_like(needed), drag(np.zeros_like(needed)) - needed, high
    for _ in range(STEPS):  # Ridders' method
        middle, before = 0.5 * (low + high), new
        at = drag(middle) - needed
        root = np.sqrt(np.maximum(at * at - below * above, 0.0))
        new = np.clip(middle - (middle - low) * np.divide(at, root, out=np.zeros_like(at), where=root > 0.0), low, high)
        for point, value in ((middle, at), (new, drag(new) - needed)):
            lower, upper = (value < 0.0) & (point > low), (value >= 0.0) & (point < high)
            low, below = np.where(lower, point, low), np.where(lower, value, below)
            high, above = np.where(upper, point, high), np.where(upper, value, above)
        if np.all(never | (np.abs(new - before) <= 1e-14 * new) | (needed <= 0.0)):
            break
    return np.where(never, math.inf, np.where(needed > 0.0, new, 0.0))


def _fold(curve: Callable[[ArrayLike], Floats], whirl: Floats, at: int, sign: float) -> tuple[float, float]:
    """Highest (sign 1) or lowest (sign -1) point of a curve between the neighbors of a point of the grid."""
    start = float(curve(whirl[at])[0])
    if not math.isfinite(start):
        return float(whirl[at]), start
    span = (float(whirl[at - 1]), float(whirl[at + 1]))
    speed, value = least(lambda v: -sign * float(curve(v)[0]), *span, xtol=1e-10 * span[1])
    best = max((start, float(whirl[at])), (-sign * value, speed), key=lambda pair: sign * pair[0])
    return best[1], best[0]
