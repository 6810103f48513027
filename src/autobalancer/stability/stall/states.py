"""Stalled states of a set of groups at one speed of the rotor: all angles between the planes that balance.

The groups g of a set stall together at the whirl speed v. With E = n s e^(i psi), h = v^2 e^(-i psi) H E and q = 1 + i mu
(rolling resistance mu) each is in balance where

    - s v^2 Im(q h) = T_drag(W - v) + mu s eps v^2 .

The phase between planes is free: it is neither 0 nor pi but what balances. For two groups the first balance, at a given v,
is solved for the phase in closed form (two arcs), and the second has a sign along each arc; so no state is missed but where
two nearly meet. Of more groups states are sought by Newton's method from the angles that one mode alone would set.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from autobalancer.arrays import Complexes, Floats, Matrix
from autobalancer.catalog.resolve import Ball, resolve
from autobalancer.machine import Machine
from autobalancer.progress import check_deadline
from autobalancer.stability.host.stations import Stations

# The balls of a machine that can stall, in groups of equal balls of one station, and what drives and brakes them.
#
# Torques as in :mod:`autobalancer.laws.stall`, here at several stations P. Balls of the group g at the angle psi_g in
# space, all at the speed v, load station p with v^2 S_p, S_p = sum n s e^(i psi); with the forward receptance H(v; W)
# of the rotor that runs at W the race of a ball whirls with zeta_p = v^2 sum_q H_pq S_q, so that
#
#     T_brake = - s v^2 Im(e^(-i psi) zeta_p),    F_N = s v^2 (1 + Re(e^(-i psi) zeta_p)/eps).


EQUAL = 1e-3  # relative difference up to which balls count as equal


@dataclass(frozen=True)
class StalledGroup:
    """``count`` equal balls of one race, in line; ``moment`` is m eps of one of them, kg m."""

    station: int
    count: int
    ball: Ball
    rolling: float
    members: tuple[int, ...] = ()  # numbers of the balls in the machine, from 0

    @cached_property
    def moment(self) -> float:
        """Effective mass times orbit radius of one ball, kg m."""
        return self.ball.moment

    @property
    def plain(self) -> bool:
        """Whether its drag is linear and nothing else resists."""
        return self.ball.drag_curve is None and self.rolling == 0.0

    @property
    def carries(self) -> bool:
        """Whether anything drives it along with the rotor."""
        return self.rolling > 0.0 or self.ball.drag_curve is not None or self.ball.drag > 0.0

    def drag(self, slip: Floats) -> Floats:
        """Torque of the fluid on one ball against its slip (rad/s), N m."""
        if self.ball.drag_curve is None:
            return np.asarray(self.ball.drag * slip)
        return self.ball.drag_curve.torque(slip, self.ball.orbit_radius)

    def carried(self, slip: Floats, whirl: Floats, radial: Floats) -> Floats:
        """Torque that drives one ball: drag and rolling resistance; ``radial`` is Re(e^(-i psi) zeta), m."""
        pressed = self.moment * whirl**2 * (1.0 + radial / self.ball.orbit_radius)
        pressed = np.abs(pressed) if self.ball.body == "pendulum" else np.maximum(pressed, 0.0)
        return np.asarray(self.drag(slip) + self.rolling * self.ball.orbit_radius * pressed)


def stalled_groups(machine: Machine, station: list[int]) -> tuple[StalledGroup, ...]:
    """Groups of balls of one station that are equal to ``EQUAL``; ``station`` of each ball.

    Balls between partitions are carried along and are left out.
    """

    def alike(ball: Ball, other: Ball) -> bool:
        """Whether they stall like equal ones; those of a lot differ by some 1e-4."""
        if (ball.drag_curve is None) != (
            other.drag_curve is None
        ) or ball.rolling_resistance != other.rolling_resistance:
            return False
        first, second = ((ball.moment, ball.orbit_radius, ball.drag, ball.inertia) for ball in (ball, other))
        return bool(np.allclose(first, second, rtol=EQUAL, atol=0.0))

    result: list[StalledGroup] = []
    for number, (place, ball) in enumerate(zip(station, resolve(machine), strict=True)):
        if machine.balancers[ball.balancer].races[ball.race].partitions is not None:
            continue
        for g, group in enumerate(result):
            if group.station == place and alike(group.ball, ball):
                result[g] = replace(group, count=group.count + 1, members=(*group.members, number))
                break
        else:
            result.append(StalledGroup(place, 1, ball, ball.rolling_resistance, (number,)))
    return tuple(result)


@dataclass(frozen=True)
class Loads:
    """The groups as arrays over g."""

    groups: tuple[StalledGroup, ...]

    def some(self, chosen: tuple[int, ...]) -> Loads:
        """Of some of the groups."""
        return Loads(tuple(self.groups[g] for g in chosen))

    @cached_property
    def station(self) -> NDArray[np.int64]:
        """Of each group."""
        return np.array([group.station for group in self.groups], np.int64)

    @cached_property
    def count(self) -> Floats:
        """Balls of each group."""
        return np.array([group.count for group in self.groups], float)

    @cached_property
    def moment(self) -> Floats:
        """Of one ball of each group, kg m."""
        return np.array([group.moment for group in self.groups])

    def whirl(self, receptance: Complexes, speed: Floats, phases: Floats) -> Complexes:
        """e^(-i psi) zeta at each group, (n, g), from receptances (n, P, P) at whirl speeds (n,); phases (g,) or (n, g)."""
        turned = np.exp(1j * np.broadcast_to(phases, (speed.size, self.count.size)))
        among = receptance[:, self.station[:, None], self.station]
        answer = (among @ (self.count * self.moment * turned)[:, :, None])[:, :, 0]
        return np.asarray(speed[:, None] ** 2 * answer / turned)

    def braking(self, whirl: Complexes, speed: Floats) -> Floats:
        """Torque that brakes one ball of each group, (n, g)."""
        return np.asarray(-self.moment * speed[:, None] ** 2 * whirl.imag)

    def carried(self, slip: Floats, whirl: Complexes, speed: Floats) -> Floats:
        """Torque that drives one ball of each group at slips (n,), (n, g)."""
        result = np.empty(whirl.shape)
        for g, group in enumerate(self.groups):
            result[:, g] = group.carried(slip, speed, whirl[:, g].real)
        return result


# A rotor that runs at W, under loads that circle forward at another speed v: receptance at its stations and modes.
#
# Gyroscopic terms are those of W. So are tables of supports, which mean the frequency of the load but are taken at the
# speed of the rotor everywhere, in simulations too. On anisotropic supports the forward component of the answer
# counts, H = (H_xx + H_yy + i (H_yx - H_xy))/2; the backward one turns against the balls and averages out.


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

    def _supports(self, speeds: Floats) -> tuple[Complexes, Complexes]:
        """Damping and stiffness at rotor speeds (s,), one for all where they have no tables."""
        if self.st.model.speeds.size == 1:
            return self._held
        damping, stiffness = zip(*(self._at(float(speed)) for speed in speeds), strict=True)
        return np.stack(damping), np.stack(stiffness)

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
        damping, stiffness = self._supports(w if np.ndim(speed) else w[:1])
        v, w = v[:, None, None], w[:, None, None]
        dynamic = stiffness + 1j * v * (damping + w * self._turning) - v**2 * self._mass
        return np.asarray(self.read @ np.linalg.solve(dynamic, self.load[None]))

    def free_motion(self, speeds: Floats) -> tuple[Complexes, Complexes, Complexes]:
        """S of (z, z')' = S (z, z') + P f at rotor speeds, (s, 2 n, 2 n), P (2 n, P), and R z'' by f at once, (P, P)."""
        n = self._mass.shape[0]
        damping, stiffness = self._supports(speeds)
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
        result = []
        for speed, whirl in zip(speeds.tolist(), whirls.tolist(), strict=True):
            modes = self.modes(speed)
            result.append(bool(((modes.frequency < speed) & (modes.frequency + PAST * modes.decay > whirl)).any()))
        return np.array(result, np.bool_)

    def all_modes(self, speeds: Floats) -> AllModes:
        """Every mode at rotor speeds (s,)."""
        result = [self._known(float(speed)) for speed in speeds]
        return AllModes(*(np.stack(parts) for parts in zip(*result, strict=True)))

    def _known(self, speed: float) -> Known:
        """Poles (K,), and what the stations see and feel of them, (K, P)."""
        key = 0.0 if self._fixed else speed
        if key not in self._all:
            damping, stiffness = self._at(key)
            n, load = self._mass.shape[0], self.load
            by_mass = np.linalg.solve(self._mass, np.hstack([stiffness, damping + key * self._turning, load]))
            whole = np.zeros((2 * n, 2 * n), np.complex128)
            whole[:n, n:] = np.eye(n)
            whole[n:] = -by_mass[:, : 2 * n]
            poles, vectors = np.linalg.eig(whole)
            left = np.linalg.lstsq(vectors, np.vstack([np.zeros_like(load), by_mass[:, 2 * n :]]), rcond=None)[0]
            self._all[key] = poles, np.asarray((self.read @ vectors[:n]).T), left
        return self._all[key]


SLIPS = np.geomspace(1e-5, 0.75, 160)  # shares of the rotor speed by which balls may lag
SLOWEST, SLOW = 0.25, 32  # whirl over the lowest resonance from which on one looks; how many where balls lag further
AROUND = np.concatenate([-np.geomspace(60.0, 0.02, 24), [0.0], np.geomspace(0.02, 60.0, 24)])  # decay rates from a mode
OFFS = np.array(
    [-6.0, -3.0, -2.0, -1.2, -0.8, -0.4, -0.15, 0.0, 0.15, 0.4, 0.8, 1.2, 2.0, 3.0, 6.0, 12.0]
)  # of three groups
ROUNDS, CLOSE = 25, 1e-10  # of Newton's method; its last step
SAME = 1e-6  # states nearer than this are one
LONGEST = 1e3  # slip over whirl
STEEP = 1e-6  # relative difference for slopes


@dataclass(frozen=True)
class States:
    """n balances of G groups: ``y`` holds log((W - v)/v), slip over whirl, and the phases of all groups but the first."""

    speed: Floats  # (n,) of the rotor, rad/s
    y: Floats  # (n, G)

    @property
    def whirl(self) -> Floats:
        """Speed of the balls, rad/s, (n,)."""
        return np.asarray(self.speed / (1.0 + np.exp(self.y[:, 0])))

    @property
    def slip(self) -> Floats:
        """By how much they are slower than the rotor, rad/s, (n,)."""
        return np.asarray(self.whirl * np.exp(self.y[:, 0]))

    @property
    def phases(self) -> Floats:
        """Of the groups, that of the first zero, (n, G)."""
        return np.hstack([np.zeros((self.speed.size, 1)), self.y[:, 1:]])

    def some(self, chosen: Indices) -> States:
        """Some of them."""
        return States(self.speed[chosen], self.y[chosen])


@dataclass(frozen=True)
class Balance:
    """A set of groups on a rotor."""

    rotor: Whirling
    loads: Loads
    shortest: ClassVar[float] = 1e-7  # step along a branch below which it is given up

    @cached_property
    def rolling(self) -> Floats:
        """Coefficient of rolling resistance of each group."""
        return np.array([group.rolling for group in self.loads.groups])

    @cached_property
    def orbit(self) -> Floats:
        """Orbit radius of each group, m."""
        return np.array([group.ball.orbit_radius for group in self.loads.groups])

    @cached_property
    def numbers(self) -> tuple[Any, ...] | None:
        """Of :func:`autobalancer.kernels.stalled.branch_point`; none where drag is not linear, or supports have tables."""
        rotor, loads = self.rotor.matrices, self.loads
        if rotor is None or any(group.ball.drag_curve is not None for group in loads.groups):
            return None
        from autobalancer.kernels.stalled import GROUP

        n, count = self.rotor.load.shape[0], len(loads.groups)
        rows = GROUP.rows(count)
        rows.total, rows.moment, rows.rolling = loads.count * loads.moment, loads.moment, self.rolling
        rows.drag, rows.pressed = [group.ball.drag for group in loads.groups], self.rolling * loads.moment * self.orbit
        push = np.ascontiguousarray(self.rotor.load[:, loads.station])
        seen = np.ascontiguousarray(self.rotor.read[loads.station])
        stack = np.zeros((7, n, n), np.complex128)
        stack[:4] = rotor
        before, after = (np.zeros(shape, np.complex128) for shape in ((count, n), (n, count)))
        slopes, lower = np.zeros((count, count + 1)), np.zeros((count + 1, count))
        return stack, push, seen, rows, before, after, slopes, lower

    def modes_of(self, speeds: Floats) -> AllModes | None:
        """Modes of the rotor for :meth:`misfit`; none where it has none that do not depend on the state."""
        return self.rotor.all_modes(speeds)

    def softening(self, states: States) -> Floats | None:
        """Accelerations of the rotor by rubber that softens, over its deflections, (n, 2 c, 2 c); none without any."""
        return None

    def turns(self, states: States) -> bool:
        """Whether a branch that cannot be followed beyond a state has a corner there."""
        return False

    def ahead(self, state: States) -> States | None:
        """The state beyond the corner, at a slightly higher speed; none if the branch turns back there."""
        return None

    def resonant(self, states: States) -> NDArray[np.bool_]:
        """Of each state, whether a resonance that the rotor has passed is ahead of the balls or just behind them, (n,)."""
        return self.rotor.hang(states.speed, states.whirl)

    def drag(self, slip: Floats) -> Floats:
        """Torque of the fluid on one ball of each group, (n, G), N m."""
        return np.stack([group.drag(slip) for group in self.loads.groups], axis=-1)

    def needed(self, slip: Floats, whirl: Floats) -> Floats:
        """Right side of the balance, (n, G)."""
        pressed = self.rolling * self.loads.moment * self.orbit * whirl[..., None] ** 2
        return np.asarray(self.drag(slip) + pressed)

    def answers(self, modes: AllModes, whirl: Floats) -> tuple[Complexes, Complexes]:
        """H between the groups and its slope over v at one whirl speed for each of n rotor speeds, (n, G, G)."""
        place = self.loads.station
        right, left = modes.right[:, :, place], modes.left[:, :, place]
        gain = 1.0 / (1j * whirl[:, None] - modes.pole)
        turned = np.swapaxes(right, 1, 2)
        return turned * gain[:, None, :] @ left, turned * (-1j * gain**2)[:, None, :] @ left

    def deflections(self, states: States) -> Complexes:
        """q h of each group, (n, G), m."""
        host = self.rotor.receptance(states.whirl, states.speed)[:, self.loads.station][:, :, self.loads.station]
        turned = np.exp(1j * states.phases)
        load = self.loads.count * self.loads.moment * turned
        whirl = states.whirl[:, None] ** 2 * (host @ load[:, :, None])[:, :, 0] / turned
        return np.asarray((1.0 + 1j * self.rolling) * whirl)

    def misfit(self, states: States, modes: AllModes | None = None) -> tuple[Floats, Floats]:
        """Brake over need less one, (n, G), and its slopes over y, (n, G, G)."""
        modes = self.rotor.all_modes(states.speed) if modes is None else modes
        loads, v, slip = self.loads, states.whirl, states.slip
        host, slope = self.answers(modes, v)
        turned = np.exp(1j * states.phases)
        load = loads.count * loads.moment * turned
        factor = (1.0 + 1j * self.rolling) * (-loads.moment) * v[:, None] ** 4 / turned
        parts = factor[:, :, None] * host * load[:, None, :]
        whole = parts.sum(axis=2)
        brake, need = whole.imag, self.needed(slip, v)
        steeper = self.needed(slip * (1.0 + STEEP), v - STEEP * slip)
        over_slip = -slip[:, None] * (
            4.0 * whole / v[:, None] + (factor[:, :, None] * slope * load[:, None, :]).sum(axis=2)
        )
        by_slip = (over_slip.imag - brake * ((steeper - need) / STEEP) / need) / need
        by_slip *= (v / states.speed)[:, None]  # of log (slip over whirl)
        by_phase = ((1j * parts).imag - np.eye(loads.count.size) * (1j * whole).imag[:, :, None]) / need[:, :, None]
        return brake / need - 1.0, np.concatenate([by_slip[:, :, None], by_phase[:, :, 1:]], axis=2)

    def corrected(self, states: States) -> States:
        """By Newton's method, those that converge."""
        if not states.speed.size:
            return states
        modes = self.modes_of(states.speed)
        y, done = states.y.copy(), np.zeros(states.speed.size, bool)
        active = np.arange(states.speed.size)
        for _ in range(ROUNDS):
            check_deadline()
            miss, jacobian = self.misfit(States(states.speed[active], y[active]), modes and modes.at(active))
            change = _solved(jacobian, -miss)
            size = np.abs(change).max(axis=1)
            y[active] += change * np.minimum(1.0, 0.5 / np.maximum(size, 1e-12))[:, None]
            done[active] = size < CLOSE
            lost = ~np.isfinite(size) | (y[active, 0] > math.log(LONGEST))
            y[active[lost]] = np.nan
            active = active[~lost & (size >= CLOSE)]
            if not active.size:
                break
        return States(states.speed[done], y[done])

    def found(self, speeds: Floats) -> list[States]:
        """All balances at each rotor speed, those that lag least first."""
        if len(self.loads.groups) > 2:
            return self.sorted(self._guessed(speeds), speeds)
        # where the last balance changes its sign along the arcs on which the first one holds
        modes = self.rotor.all_modes(speeds)
        whirl = self._whirls(speeds, modes)
        lag, arcs = np.log((speeds[:, None] - whirl) / whirl), self.arcs(speeds, modes, whirl)
        starts = [crossings(speeds, lag, rest, phase) for rest, phase in arcs]
        if len(arcs) == 2:
            starts += joints(speeds, lag, arcs)
        y = np.vstack([y[:, : len(self.loads.groups)] for _, y in starts])
        return self.sorted(States(np.concatenate([one for one, _ in starts]), y), speeds)

    def sorted(self, begun: States, speeds: Floats) -> list[States]:
        """Balances near some states, at each rotor speed those that lag least first."""
        known = self.corrected(begun)
        order = np.lexsort((*known.y.T[::-1], known.speed))
        known = known.some(order)
        return [_distinct(known.some(np.flatnonzero(known.speed == speed))) for speed in speeds]

    def arcs(self, speeds: Floats, modes: AllModes, whirl: Floats) -> list[tuple[Floats, Floats]]:
        """Of one or two groups: surplus of the last brake over the need where the first are equal, and the phase, (s, n).

        nan where no phase makes them equal.
        """
        loads, count, place = self.loads, len(self.loads.groups), self.loads.station
        # what a group feels of the motion that it and the other one make
        slip = speeds[:, None] - whirl
        gain = 1.0 / (1j * whirl[:, :, None] - modes.pole[:, None])
        left, right = modes.left[:, None][..., place], modes.right[:, None][..., place]
        need = self.needed(slip.ravel(), whirl.ravel()).reshape(*slip.shape, count)
        power = -(whirl**4)[:, :, None] * loads.moment * (1.0 + 1j * self.rolling)
        strength = loads.count * loads.moment

        def host(p: int, q: int) -> Complexes:
            return np.asarray((gain * right[..., p] * left[..., q]).sum(axis=2) * power[:, :, p] * strength[q])

        if count == 1:
            return [(host(0, 0).imag - need[:, :, 0], np.zeros_like(whirl))]
        # of two groups: the phases at which the first is in balance, two of them, and what the second then lacks
        across, own = host(0, 1), host(0, 0)
        result = []
        with np.errstate(invalid="ignore", divide="ignore"):
            lag = np.arcsin((need[:, :, 0] - own.imag) / np.abs(across))
            for angle in (lag, np.pi - lag):
                phase = angle - np.angle(across)
                rest = (host(1, 1) + host(1, 0) * np.exp(-1j * phase)).imag - need[:, :, 1]
                result.append((rest, phase))
        return result

    def _whirls(self, speeds: Floats, modes: AllModes) -> Floats:
        """Whirl speeds at which to look, ascending, (s, n)."""
        seen = (np.abs(modes.right[:, :, self.loads.station]) * np.abs(modes.left[:, :, self.loads.station])).max(
            axis=2
        )
        ahead = (modes.pole.imag > 0.0) & (modes.pole.imag < speeds[:, None])
        ahead &= seen * modes.pole.imag > SEEN * (seen * modes.pole.imag).max(axis=1, keepdims=True)
        lowest = SLOWEST * np.where(ahead, modes.pole.imag, speeds[:, None]).min(axis=1)
        far = np.geomspace(np.minimum(1.0 - SLIPS[-1], lowest / speeds), 1.0 - SLIPS[-1], SLOW, endpoint=False, axis=1)
        slips = speeds[:, None] * np.hstack([np.broadcast_to(SLIPS, (speeds.size, SLIPS.size)), 1.0 - far[:, ::-1]])
        order = np.argsort(np.where(ahead, modes.pole.imag, np.inf), axis=1)[:, : int(ahead.sum(axis=1).max(initial=0))]
        pole = np.where(ahead, modes.pole, 0.0)[np.arange(speeds.size)[:, None], order]
        near = pole.imag[:, :, None] - pole.real[:, :, None] * AROUND
        slip = np.hstack([slips, (speeds[:, None, None] - near).reshape(speeds.size, -1)])
        slip = np.clip(slip, slips[:, :1], slips[:, -1:])
        return np.asarray(speeds[:, None] - np.sort(slip, axis=1)[:, ::-1])

    def _guessed(self, speeds: Floats) -> States:
        """The angles at which a mode alone would balance, a little off its resonance."""
        found_speed, found_y = [], []
        loads = self.loads
        for speed in speeds.tolist():
            modes = self.rotor.modes(speed)
            for k in np.flatnonzero(modes.frequency < speed):
                at = modes.frequency[k] + OFFS * modes.decay[k]
                at = at[(at < speed) & (at > SLOWEST * modes.frequency[0])]
                carried = self.needed(speed - at, at)
                strength = loads.moment * np.sqrt(np.abs(modes.right[k] * modes.left[k]))[loads.station]
                gain = at[:, None] ** 4 / max(float(modes.decay[k]), 1e-300)
                sines = carried / (strength * np.sqrt(gain * (loads.count * carried).sum(axis=1)[:, None]))
                theta = np.arcsin(np.minimum(sines, 1.0))
                phases = theta - np.angle(modes.left[k])[loads.station]
                found_y.append(np.column_stack([np.log((speed - at) / at), (phases - phases[:, :1])[:, 1:]]))
                found_speed.append(np.full(at.size, speed))
        if not found_y:
            return States(np.zeros(0), np.zeros((0, loads.count.size)))
        return States(np.concatenate(found_speed), np.vstack(found_y))


def _solved(matrices: Floats, right: Floats) -> Floats:
    """Solutions (n, G), nan where there is none."""
    good = np.flatnonzero(np.isfinite(matrices).all(axis=(1, 2)) & np.isfinite(right).all(axis=1))
    good = good[np.abs(np.linalg.det(matrices[good])) > 1e-300]
    result = np.full(right.shape, np.nan)
    result[good] = np.linalg.solve(matrices[good], right[good][:, :, None])[:, :, 0]
    return result


def _distinct(states: States) -> States:
    """Each once."""
    kept: list[int] = []
    for i in range(states.speed.size):
        turned = [float(np.abs(np.exp(1j * (states.y[i, 1:] - states.y[k, 1:])) - 1.0).max(initial=0.0)) for k in kept]
        near = [abs(float(states.y[i, 0] - states.y[k, 0])) for k in kept]
        if not any(max(a, b) < SAME for a, b in zip(turned, near, strict=True)):
            kept.append(i)
    return states.some(np.array(kept, np.int64))


# Where the balance of a second group changes its sign along the arcs on which that of the first one holds.


Starts = tuple[Floats, Floats]


def crossings(speeds: Floats, lag: Floats, rest: Floats, phase: Floats) -> Starts:
    """Where a balance changes its sign between two whirl speeds."""
    at, k = np.nonzero(rest[:, 1:] * rest[:, :-1] <= 0.0)
    share = rest[at, k] / (rest[at, k] - rest[at, k + 1] + 1e-300)
    turn = np.angle(np.exp(1j * (phase[at, k + 1] - phase[at, k])))
    first = lag[at, k] + share * (lag[at, k + 1] - lag[at, k])
    return speeds[at], np.column_stack([first, phase[at, k] + share * turn])


def joints(speeds: Floats, lag: Floats, arcs: list[tuple[Floats, Floats]]) -> list[Starts]:
    """Where it changes its sign from one arc to the other, at an end at which both meet between two whirl speeds."""
    (one, phase), (other, far) = arcs
    known = np.isfinite(one) & np.isfinite(other)
    turn = np.angle(np.exp(1j * (far - phase)))
    result = []
    for here, beyond in ((slice(None, -1), slice(1, None)), (slice(1, None), slice(None, -1))):
        at, k = np.nonzero(known[:, here] & ~known[:, beyond] & (one[:, here] * other[:, here] <= 0.0))
        k = k if here.stop == -1 else k + 1
        y = np.column_stack([lag[at, k], phase[at, k] + 0.5 * turn[at, k]])
        result.append((speeds[at], y))
    return result
