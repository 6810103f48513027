"""The stalled-ball (Sommerfeld) solutions: balls that hang at a resonance while the rotor runs faster.

Ryzhik et al. (2001). In the frame of the rotor each is a periodic orbit on which the balls lose one revolution per period. It
is far from every state of rest. It begins from the torque balance of :mod:`autobalancer.stability.stall.states`: balls that
circle at a steady speed v, and a rotor that whirls with them at v and with its unbalance at W.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from autobalancer.arrays import Complexes, Floats, Matrix
from autobalancer.catalog.resolve import Ball
from autobalancer.roots import root
from autobalancer.stability.bifurcations import NoConvergence, at_parameter
from autobalancer.stability.host.stations import Stations
from autobalancer.stability.host.vector_field import Equations, Field
from autobalancer.stability.periodic_orbits import Mesh, Orbits
from autobalancer.stability.stall.branch import stable
from autobalancer.stability.stall.states import Balance, Loads, StalledGroup, Whirling
from autobalancer.stability.states.linearized import deciding_eigenvalues, eigensystem, matrices, modes
from autobalancer.stability.states.rest_states import StationState, states_of, without_exchanges
from autobalancer.stability.steady_curves import Groups, Range, bundled_angles, coincident


def stalled_orbits(span: Range, groups: Groups, share: float, intervals: int) -> Iterator[tuple[Orbits, Floats]]:
    """Problem and orbit for each resonance at which all balls can hang together at a share of the range."""
    field = span.field(share, groups)
    if (field.host.drag <= 0.0).any():
        return
    mesh = Mesh(np.linspace(0.0, 1.0, intervals + 1))
    rotor = Whirling(field.host)
    # the merged balls as groups of one
    p, stalled = field.host, []
    for i in range(len(groups)):
        orbit = float(p.moment[i] / p.ball_mass[i])
        spin = float(p.inertia[i] / (p.moment[i] * orbit)) - 1.0
        ball = Ball(0, 0, float(p.ball_mass[i]), 0.0, 0.0, 0.0, orbit, spin, 0.0, float(p.drag[i]), 0j, None, 0.0)
        stalled.append(StalledGroup(int(p.station[i]), 1, ball, 0.0))
    balance = Balance(rotor, Loads(tuple(stalled)))
    (result,) = stable(balance, balance.found(np.array([field.speed])))
    for whirl, phases, hanging in zip(result.whirl.tolist(), result.phases, balance.resonant(result), strict=True):
        if not hanging:
            continue
        period = 2.0 * math.pi / (field.speed - whirl)
        states = _guess(field, whirl, phases, mesh.nodes) / span.scale(len(groups))
        problem = Orbits(span, groups, (-1,) * len(groups), mesh, period, states)
        try:
            u = at_parameter(problem, np.append(states.ravel(), [0.0, share]), share)
        except (NoConvergence, np.linalg.LinAlgError):
            continue
        if 0.5 < problem.period(u) / period < 2.0:
            yield problem, u


def _guess(field: Equations, whirl: float, phases: Floats, times: Floats) -> Matrix:
    """States over one period (unit time) with the balls at these angles at time zero, circling steadily."""
    p, speed = field.host, field.speed
    back = np.exp(-2j * np.pi * times)[:, None]  # what turns with the balls, in the frame of the rotor
    mass, turning, stiffness = p.model.complex_matrices(speed)
    dynamic = stiffness + 1j * whirl * turning - whirl**2 * mass
    driven = whirl**2 * np.linalg.solve(dynamic, p.rows.T @ p.moments(phases))
    still = speed**2 * (p.compliance(speed) @ p.fixed_load)
    q = still + driven * back
    v = 1j * speed * still + 1j * whirl * driven * back
    angles = phases - 2.0 * np.pi * times[:, None]
    rates = np.full((times.size, phases.size), whirl - speed)
    return np.hstack([q.real, q.imag, v.real, v.imag, angles, rates])


# Orbits on which one group of balls hangs at a resonance while all others stay in the rotor.
#
# The whirl of those that hang passes the resting ones at the slip and makes them swing. They answer in first order, so
# that the rotor seen by those that hang is not the one with rigid balls: the torque balance is solved with it. The
# swing has a mean torque of second order, beta slip a^2/2 for an amplitude a, which drags resting balls backward; the
# unbalance must hold them against it. So the orbit is found with hardly any drag of the resting balls first, which is
# then raised to its value. Where that ends in a fold before, they are not held but drift around the rotor, and the
# motion is not periodic.


AROUND = np.geomspace(1e-4, 0.2, 24)  # distance from a resonance at which the balance is looked at, over the speed
SLIPS = np.concatenate(
    [np.geomspace(1e-3, 0.75, 200), 1.0 - np.geomspace(0.25, 0.02, 40)]
)  # and everywhere, over the speed
LARGEST_SWING = 1.0  # rad, of resting balls; with more they go around
FIRST_DRAG = 1e-3  # share of the drag of resting balls
RAISED, LEAST_RAISED = 4.0, 1.2  # by how much it is raised at once, and where that is given up


@dataclass(frozen=True)
class Hanging:
    """One group ``hung`` (merged) of a machine in which all other balls rest in a state; ``rest`` has those balls only."""

    whole: Stations  # with the hung group as one ball, the first; all others by themselves
    rest: Stations
    state: StationState
    speed: float

    @cached_property
    def _matrices(self) -> tuple[Floats, Floats, Floats]:
        return matrices(self.rest, self.speed, self.state)

    @cached_property
    def _row(self) -> Floats:
        return np.asarray(self.whole.rows[self.whole.station[0]])

    def answer(self, whirl: Floats) -> Complexes:
        """Small motions (Q_x, Q_y, phi...) e^(-i slip t) of rotor and resting balls for whirl speeds (k,)."""
        m, c, k = self._matrices
        slip, pairs = (self.speed - whirl)[:, None, None], self.whole.model.pairs
        load = (whirl**2)[:, None] * self.whole.moment[0] * self._row
        force = np.zeros((whirl.size, m.shape[0]), np.complex128)
        force[:, :pairs], force[:, pairs : 2 * pairs] = load, -1j * load
        return np.asarray(np.linalg.solve(-(slip**2) * m - 1j * slip * c + k, force[:, :, None])[:, :, 0])

    def surplus(self, whirl: Floats) -> Floats:
        """Torque that brakes those that hang less that which drives them, (k,) N m."""
        moved, pairs = self.answer(whirl), self.whole.model.pairs
        forward = 0.5 * (moved[:, :pairs] + 1j * moved[:, pairs : 2 * pairs]) @ self._row
        brake = -self.whole.moment[0] * whirl**2 * forward.imag
        return np.asarray(brake - self.whole.drag[0] * (self.speed - whirl))

    def whirls(self) -> list[float]:
        """Speeds at which those that hang are in balance, and return to it; the resting ones swing little."""
        values, _ = eigensystem(*self._matrices)
        resonances = self.speed - np.unique(np.abs(values.imag))
        near = (resonances[:, None] + self.speed * np.concatenate([-AROUND, AROUND])).ravel()
        at = np.unique(np.concatenate([self.speed * (1.0 - SLIPS), near]))
        at = at[(at > 0.019 * self.speed) & (at < 0.999 * self.speed)]
        here = self.surplus(at)
        rising = np.flatnonzero((here[:-1] < 0.0) & (here[1:] >= 0.0))

        def one(whirl: float) -> float:
            return float(self.surplus(np.array([whirl]))[0])

        result = [root(one, at[i], at[i + 1], xtol=1e-10 * self.speed) for i in rising]
        first = 2 * self.whole.model.pairs
        return [v for v in result if np.abs(self.answer(np.array([v]))[0, first:]).max(initial=0.0) < LARGEST_SWING]


class Eased(Range):
    """A range whose resting balls, all but the first merged one, have a share of their drag."""

    def __init__(self, span: Range, share: float) -> None:
        self.__dict__.update(span.__dict__)
        self.drag_share = share

    def field(self, share: float, groups: Groups) -> Field:
        """The vector field there, of balls in groups."""
        whole = super().field(share, groups)
        drag = whole.host.drag * np.append(1.0, np.full(len(groups) - 1, self.drag_share))
        return Field(replace(whole.host, drag=drag), whole.speed)


def partly_stalled_orbits(
    span: Range, kind: list[tuple[float, ...]], hung: tuple[int, ...], share: float, intervals: int
) -> Iterator[tuple[Orbits, Floats]]:
    """Problem and orbit for each resonance at which the ``hung`` balls hang alone at a share of the range.

    One for each stable state in which the other balls may rest, of which those that differ by an exchange count once.
    """
    field = span.whole(share)
    others = np.array([ball for ball in range(field.balls) if ball not in hung])
    if not others.size or (field.host.drag <= 0.0).any():
        return
    rest = _with(replace(field.host, forces=None), others)
    own = [kind[ball] for ball in others]
    for state in without_exchanges(rest, states_of(rest, field.speed)):
        values, _ = modes(rest, field.speed, state)
        if not deciding_eigenvalues(values, state.freedom).real.max() < 0.0:
            continue
        angles = bundled_angles(Field(rest, field.speed), state, own)
        resting = coincident(angles, own)
        groups = (hung, *(tuple(int(others[i]) for i in group) for group in resting))
        merged = replace(span.field(share, groups).host, slopes=None, forces=None)  # a guess may leave them out
        at_rest = StationState(state.name, angles[[g[0] for g in resting]], state.whirl, 0, 0)
        hanging = Hanging(merged, _with(merged, np.arange(1, len(groups))), at_rest, field.speed)
        for whirl in hanging.whirls():
            orbits = _raised(span, groups, share, hanging, whirl, intervals)
            if orbits is not None:
                yield orbits


def _raised(
    span: Range, groups: Groups, share: float, hanging: Hanging, whirl: float, intervals: int
) -> tuple[Orbits, Floats] | None:
    """The orbit near a guess, with the drag of the resting balls raised from hardly any; none if they are not held."""
    mesh, slip = Mesh(np.linspace(0.0, 1.0, intervals + 1)), hanging.speed - whirl
    states = _partly_stalled_guess(hanging, whirl, mesh.nodes) / span.scale(len(groups))
    winding = (-1, *(0 for _ in groups[1:]))
    problem = Orbits(span, groups, winding, mesh, 2.0 * np.pi / slip, states)
    u, reached, factor = np.append(states.ravel(), [0.0, share]), 0.0, RAISED
    while reached < 1.0:
        wanted = min(FIRST_DRAG if reached == 0.0 else factor * reached, 1.0)
        problem.span = Eased(span, wanted)
        try:
            u, reached = at_parameter(problem, u, share), wanted
        except (NoConvergence, np.linalg.LinAlgError):
            factor = np.sqrt(factor)
            if reached == 0.0 or factor < LEAST_RAISED:
                return None
    problem.span = span
    return (problem, u) if 0.5 < problem.period(u) * slip / (2.0 * np.pi) < 2.0 else None


def _partly_stalled_guess(hanging: Hanging, whirl: float, times: Floats) -> Matrix:
    """States over one period (unit time): balls that hang at angle zero at time zero, the others swinging about rest."""
    p, speed, slip, pairs = hanging.whole, hanging.speed, hanging.speed - whirl, hanging.whole.model.pairs
    moved = hanging.answer(np.array([whirl]))[0] * np.exp(-2j * np.pi * times)[:, None]
    way, rate = moved.real, (-1j * slip * moved).real
    resting = p.rows.T @ p.moments(np.append(0.0, hanging.state.angles))
    resting = resting - p.moment[0] * p.rows[p.station[0]]
    still = speed**2 * (p.compliance(speed) @ (p.fixed_load + resting))
    q = still + way[:, :pairs] + 1j * way[:, pairs : 2 * pairs]
    v = 1j * speed * q + rate[:, :pairs] + 1j * rate[:, pairs : 2 * pairs]
    angles = np.column_stack([-2.0 * np.pi * times, hanging.state.angles + way[:, 2 * pairs :]])
    rates = np.column_stack([np.full(times.size, -slip), rate[:, 2 * pairs :]])
    return np.hstack([q.real, q.imag, v.real, v.imag, angles, rates])


def _with(st: Stations, balls: np.ndarray) -> Stations:
    """The machine with some of its balls, and the stations of these; the mass of the others stays on the rotor."""
    places = sorted(set(st.station[balls].tolist()))
    columns = ("ball_mass", "moment", "inertia", "drag", "race", "offset")
    return replace(
        st,
        names=tuple(st.names[p] for p in places),
        rows=st.rows[places],
        capability=st.capability[places],
        slopes=None if st.slopes is None else st.slopes[places],
        station=np.array([places.index(p) for p in st.station[balls]], np.int64),
        **{name: getattr(st, name)[balls] for name in columns},
    )
