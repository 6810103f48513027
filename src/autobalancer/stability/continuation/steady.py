"""Steady states as points of a curve: the equations F(x, parameter) = 0 in scaled unknowns, of balls merged in groups."""

from __future__ import annotations

import copy
from typing import Self

import numpy as np
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.stability.continuation.family import Family
from autobalancer.stability.continuation.symmetry import Groups, expanded, gathered, in_two_bundles
from autobalancer.stability.host.cycle import Cycle, Equations
from autobalancer.stability.host.damping import damping_ratio
from autobalancer.stability.host.planar import Complexes, Floats, Matrix
from autobalancer.stability.host.series import Numbers
from autobalancer.stability.host.stations import Stations
from autobalancer.stability.host.vector_field import Field
from autobalancer.stability.states.state import StationState, state_vector

DIFFERENCE = 1e-4  # of a parameter; with differences of fourth order its derivatives are good to 1e-11

LARGEST_RESONANCE = 100.0
CONTINUUM = 1e-9  # singular value, over the greatest, that counts as zero along a continuum of states
NEARLY = 1e-6  # on a race that tilts or does not quite run true, where a continuum is one up to the square of that
SWINGING, ACROSS = 3.0, 0.5  # see nearly_true_races
TRUE_RACE = 1e-8  # distance of a race center from the axis, in units of the size of deflections


class Range:
    """The free parameter between its ends, and the sizes in which states are counted."""

    def __init__(self, family: Family, start: float, end: float, others: tuple[float, ...] = ()) -> None:
        self.family, self.start, self.end, self.others = family, start, end, others
        host = family(start, *others).host
        self.frequency = host.scale_speed
        self.length = size(host)
        heavy = np.tile(np.diag(host.model.mass)[: host.model.pairs], 2)
        self.sizes = self.length * np.sqrt(host.model.total_mass / heavy)  # of equal energy, (2 pairs,)

    def moved(self, *others: float) -> Range:
        """The same range at other values of the further parameters of the family."""
        span = copy.copy(self)
        span.others = others
        return span

    def value(self, share: float) -> float:
        """The parameter at a share of the range."""
        return self.start + (self.end - self.start) * share

    def share(self, value: float) -> float:
        """Where in the range a value lies, 0 to 1."""
        return (value - self.start) / (self.end - self.start)

    @property
    def count(self) -> int:
        """Harmonics of a state: one where it rests in the rotor."""
        return self.family.count

    def field(self, share: float, groups: Groups) -> Equations:
        """The vector field there, of balls in groups."""
        return self.family.merged(groups, self.value(share), *self.others)

    def whole(self, share: float) -> Equations:
        """The vector field there, of all balls."""
        return self.family(self.value(share), *self.others)

    @property
    def rotor(self) -> int:
        """Components of a state in front of the ball angles."""
        return 2 * self.sizes.size

    def scale(self, balls: int) -> Floats:
        """Size of each component of a state."""
        w, z = self.frequency, self.sizes
        return np.tile(np.concatenate([z, z * w, np.ones(balls), np.full(balls, w)]), self.count)

    def offsets(self, share: float) -> tuple[Floats, Floats]:
        """Shares at which a derivative by the parameter takes its values, and with which weights."""
        step = DIFFERENCE * (abs(self.value(share)) or abs(self.end - self.start)) / abs(self.end - self.start)
        if self.value(share) == 0.0:  # an entry of a machine may refuse to be negative
            way = step if self.end > self.start else -step
            return share + way * np.arange(5.0), np.array([-25.0, 48.0, -36.0, 16.0, -3.0]) / (12.0 * way)
        return share + step * np.array([-2.0, -1.0, 1.0, 2.0]), np.array([1.0, -8.0, 8.0, -1.0]) / (12.0 * step)


def size(host: Stations) -> float:
    """A length that suits the deflections of a machine at resonance, m."""
    drives = abs(host.unbalance) + float(host.moment.sum())
    length = drives / host.model.total_mass + float(np.abs(host.offset).max(initial=0.0))
    ratio = damping_ratio(host.model, host.scale_speed)
    length *= min(max(1.0, 0.5 / max(ratio, 1e-300)), LARGEST_RESONANCE)
    if length == 0.0:
        raise QuestionError("branches: the machine has neither unbalance nor balls; nothing can be followed")
    return length


def true_races(field: Equations, state: Floats, length: float) -> NDArray[np.bool_]:
    """Whether the race of each ball runs true, (n,); where it tilts, up to what the shorter reach of a ball makes of it."""
    allowed = _allowed(field, state, length)
    return np.asarray(np.max(_off_axis(field, state), 0) < allowed)


def nearly_true_races(field: Equations, state: Floats, length: float) -> NDArray[np.bool_]:
    """The same, up to what a swing of the balls makes of it on anisotropic supports: there no race need run true.

    A ball that swings while its race whirls backward feels a mean torque of the second order; where a race whirls forward no more
    than this makes up for, and balls do not stand along this whirl, they balance it.
    """
    (center, backward), allowed = _off_axis(field, state), _allowed(field, state, length)
    if field.count == 1:
        return np.asarray(center < allowed)
    parts = state.reshape(field.count, -1)
    angles = parts[:, field.rotor : field.rotor + field.balls]
    place = centers_of(field.host.plain_at(field.speed), parts[0])
    across = np.abs((np.exp(-1j * angles[0]) * place).imag)
    swing = np.sqrt((angles[1:] ** 2).sum(0))
    same = field.host.station[:, None] == field.host.station
    free, moves = (np.where(same, one, 0.0).max(1) for one in (across, swing))
    return np.asarray((center < allowed) | ((center < SWINGING * moves * backward) & (free > ACROSS * center)))


def _allowed(field: Equations, state: Floats, length: float) -> Floats:
    """How far from the axis the race of each ball may be and count as true, (n,) m."""
    host, allowed = field.host, np.full(field.balls, TRUE_RACE * length)
    if host.slopes is not None:
        pairs = host.model.pairs
        lean = host.slopes @ (state[:pairs] + 1j * state[pairs : 2 * pairs])
        allowed += 2.0 * np.abs(lean[host.station]) ** 2 * host.orbit
    return allowed


def _off_axis(field: Equations, state: Floats) -> tuple[Floats, Floats]:
    """Distances of the race center of each ball from the axis, in the mean over half a turn and about it, (n,) m."""
    host, parts = field.host.plain_at(field.speed), state.reshape(field.count, -1)
    whirl = _whirl(host, parts[1:])[..., host.station]
    return np.abs(centers_of(host, parts[0])), np.sqrt((np.abs(whirl) ** 2).sum(0))


def running_true(field: Equations, state: Floats, length: float) -> int | None:
    """Dimension of the continuum of a state in which races run true; ``None`` if none of them does, or forces hold the balls."""
    host, true = field.host, nearly_true_races(field, state, length)
    if host.forces is not None or not true.any():
        return None
    races = list(zip(host.station.tolist(), host.offset.tolist(), strict=True))
    standing = [race for race, runs in zip(races, true, strict=True) if runs]
    stations = len({station for station, _ in standing})
    more = 2 * max(stations - host.model.pairs, 0)  # moments of so many stations move nothing
    return sum(max(standing.count(race) - 2, 0) for race in set(standing)) + more


def bundled_angles(field: Equations, state: StationState, kind: list[tuple[float, ...]]) -> Floats:
    """Ball angles of a state of rest; of a continuum those of the member in two bundles, if there is one."""
    host = field.host
    if not state.freedom:
        return state.angles
    resting = Field(host, field.speed)
    true = true_races(resting, state_vector(host, field.speed, state.angles), size(host))
    bundled = in_two_bundles(state.angles, host, kind, true)
    return state.angles if bundled is None else bundled


def centers_of(host: Stations, state: Floats) -> Complexes:
    """Race center of each ball in the rotor, from the axis of rotation, (n,) m; on anisotropic supports its mean."""
    return np.asarray(_whirl(host, state)[..., host.station] + host.offset, np.complex128)


def _whirl(host: Stations, states: Floats) -> Complexes:
    """Deflections of the stations in the rotor, (..., P) m."""
    pairs = host.model.pairs
    return np.asarray((states[..., :pairs] + 1j * states[..., pairs : 2 * pairs]) @ host.rows.T, np.complex128)


class Steady:
    """Unknowns: scaled state of the merged balls, then the share of the parameter's range.

    ``loose``: the states are a continuum even in the merged balls; the curve goes across it by the shortest way.
    """

    def __init__(self, span: Range, groups: Groups, loose: bool = False) -> None:
        self.span, self.groups, self.loose = span, groups, loose
        self.scale = span.scale(len(groups))
        self.weight = np.ones(self.scale.size + 1)
        self.first = span.rotor  # number of the first ball angle
        self._known: dict[bytes, Complexes] = {}  # eigenvalues at the points asked last

    @property
    def slack(self) -> float:
        """Singular value, over the greatest, that counts as zero along a continuum of states."""
        return CONTINUUM if self.count == 1 and self.span.whole(0.0).host.slopes is None else NEARLY

    @property
    def count(self) -> int:
        """Harmonics of a state: one where it rests in the rotor."""
        return self.span.count

    @property
    def angles(self) -> slice:
        """Where the angles of the merged balls are, their mean on anisotropic supports."""
        return slice(self.first, self.first + len(self.groups))

    def field(self, u: Floats) -> Equations:
        """The vector field at a point."""
        return self.span.field(float(u[-1]), self.groups)

    def residual(self, u: Floats) -> Floats:
        return np.asarray(self.field(u)(u[:-1] * self.scale) / (self.scale * self.span.frequency))

    def jacobian(self, u: Floats) -> Matrix:
        """Derivative of the scaled field with respect to the scaled state."""
        return np.asarray(
            self.field(u).jacobian(u[:-1] * self.scale) * self.scale / self.scale[:, None] / self.span.frequency
        )

    def slope(self, u: Floats) -> Floats:
        """Derivative of the residual with respect to the parameter's share."""
        shares, weights = self.span.offsets(float(u[-1]))
        return np.asarray(sum(w * self.residual(np.append(u[:-1], s)) for s, w in zip(shares, weights, strict=True)))

    def bordered(self, u: Floats, row: Floats) -> Matrix:
        """Derivative with respect to all unknowns, and ``row`` below."""
        return np.vstack([np.column_stack([self.jacobian(u), self.slope(u)]), row])

    def solve(self, u: Floats, row: Floats, right: Floats, last: float) -> Floats:
        matrix, sides = self.bordered(u, row), np.append(right, last)
        if self.loose:
            return np.asarray(np.linalg.lstsq(matrix, sides, rcond=self.slack)[0])
        return np.asarray(np.linalg.solve(matrix, sides))

    def renewed(self, u: Floats, tangent: Floats) -> tuple[Self, Floats, Floats]:
        return self, u, tangent

    def state(self, u: Floats) -> Floats:
        """The state of all balls, SI, harmonic after harmonic."""
        parts = (u[:-1] * self.scale).reshape(self.count, -1)
        return expanded(parts, self.groups, self.span.rotor).ravel()

    def gathered(self, state: Floats) -> Floats:
        """Unknowns but the last for a state of all balls, SI."""
        return gathered(state.reshape(self.count, -1), self.groups, self.first).ravel() / self.scale

    def tail(self, u: Floats) -> float:
        """Size of the highest harmonic; zero of a state at rest."""
        return float(np.abs(u[:-1].reshape(self.count, -1)[-2:]).max()) if self.count > 1 else 0.0

    def freedom_or_none(self, u: Floats) -> int | None:
        """Dimension of the continuum of balanced states of the merged balls; ``None`` where no race runs true."""
        return running_true(self.field(u), u[:-1] * self.scale, self.span.length)

    def eigenvalues(self, u: Floats) -> Complexes:
        """Of the merged balls, 1/s, greatest real part first; on anisotropic supports exponents of multipliers."""
        key = u.tobytes()
        if key not in self._known:  # the end of a step is the begin of the next one
            self._known = {**dict([*self._known.items()][-1:]), key: self._eigenvalues(u)}
        return self._known[key]

    def _eigenvalues(self, u: Floats) -> Complexes:
        field = self.field(u)
        if isinstance(field, Cycle):
            return field.exponents(u[:-1] * self.scale)
        values = np.linalg.eigvals(self.jacobian(u)) * self.span.frequency
        return np.asarray(values[np.argsort(-values.real, kind="stable")], np.complex128)

    def all_eigenvalues(self, u: Floats) -> Complexes:
        """Of all balls, 1/s: those of the merged balls and of groups that fall apart."""
        whole = self.span.whole(float(u[-1]))
        if isinstance(whole, Cycle):
            return whole.exponents(self.state(u))
        scale = self.span.scale(whole.balls)
        values = np.linalg.eigvals(whole.jacobian(self.state(u)) * scale / scale[:, None])
        return np.asarray(values[np.argsort(-values.real, kind="stable")], np.complex128)

    def second(self, u: Floats, a: Numbers, b: Numbers) -> Numbers:
        """Second derivatives of the scaled field along scaled directions."""
        found = self.field(u).second(u[:-1] * self.scale, a * self.scale, b * self.scale)
        return np.asarray(found / (self.scale * self.span.frequency))

    def bent(self, u: Floats, a: Numbers) -> Numbers:
        """The matrix of the second derivatives along ``a`` and any other scaled direction."""
        found = self.field(u).bent(u[:-1] * self.scale, a * self.scale)
        return np.asarray(found * self.scale / (self.scale[:, None] * self.span.frequency))

    def third(self, u: Floats, a: Numbers, b: Numbers) -> Numbers:
        """Third derivatives C(a, a, b) of the scaled field."""
        found = self.field(u).third(u[:-1] * self.scale, a * self.scale, b * self.scale)
        return np.asarray(found / (self.scale * self.span.frequency))
