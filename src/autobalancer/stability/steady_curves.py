"""Steady states as points of a curve: the equations F(x, parameter) = 0 in scaled unknowns, of balls merged in groups."""

from __future__ import annotations

import copy
import math
import re
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from autobalancer.arrays import Complexes, Floats, Matrix
from autobalancer.assembly.guided_balls import has_forces
from autobalancer.assembly.quantities import si_value, value_of, with_quantity
from autobalancer.catalog.resolve import resolve
from autobalancer.errors import QuestionError
from autobalancer.machine import Machine, PrescribedSpeed
from autobalancer.machine.drive import Constant
from autobalancer.machine.path import QUANTITIES, axis_attributes, parts_of, si_unit_of
from autobalancer.stability.host.reduction import basis_for, projected
from autobalancer.stability.host.stations import (
    Numbers,
    Plane,
    Stations,
    damping_ratio,
    is_planar,
    of_plane,
    plane,
    refuse_motion_along_the_axis,
    station_form,
)
from autobalancer.stability.host.vector_field import Cycle, Equations, Field
from autobalancer.stability.states.ball_positions import close_polygon
from autobalancer.stability.states.rest_states import StationState, state_vector
from autobalancer.units import to_si
from autobalancer.units.quantity import ends, example, is_range

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
            values = self.field(u).exponents(u[:-1] * self.scale, self.scale)
            self._known = {**dict([*self._known.items()][-1:]), key: values}
        return self._known[key]

    def all_eigenvalues(self, u: Floats) -> Complexes:
        """Of all balls, 1/s: those of the merged balls and of groups that fall apart."""
        whole = self.span.whole(float(u[-1]))
        return whole.exponents(self.state(u), self.span.scale(whole.balls))

    def second(self, u: Floats, a: Numbers, b: Numbers) -> Numbers:
        """Second derivatives of the scaled field along scaled directions."""
        result = self.field(u).second(u[:-1] * self.scale, a * self.scale, b * self.scale)
        return np.asarray(result / (self.scale * self.span.frequency))

    def bent(self, u: Floats, a: Numbers) -> Numbers:
        """The matrix of the second derivatives along ``a`` and any other scaled direction."""
        result = self.field(u).bent(u[:-1] * self.scale, a * self.scale)
        return np.asarray(result * self.scale / (self.scale[:, None] * self.span.frequency))

    def third(self, u: Floats, a: Numbers, b: Numbers) -> Numbers:
        """Third derivatives C(a, a, b) of the scaled field."""
        result = self.field(u).third(u[:-1] * self.scale, a * self.scale, b * self.scale)
        return np.asarray(result / (self.scale * self.span.frequency))


# A machine with one or several of its numbers free: the vector field as a function of parameters.
#
# A parameter is ``speed``, a name of :data:`autobalancer.machine.path.QUANTITIES` but ``count``, ``plateau``
# and ``rolling_resistance``, or several joined by ``&``, or a path such as
# ``"balancers[1].races[1].balls[1].diameter"``.


FIXED = ("count", "plateau", "rolling_resistance")  # no number that varies, or without effect where balls move slowly
QUICK = ("unbalance", "drag")  # changed without going through the description of the machine
QUICK_IN_PLANE = (*QUICK, "damping", "stiffness", "viscosity", "ball_mass")
FIRST_COUNT = 9  # harmonics of a state on anisotropic supports, until more are needed
SMOOTH = ("speed", *(name for name in QUANTITIES if name not in FIXED))


class Family:
    """Vector fields of a machine at values of its free parameters, SI.

    Parameters
    ----------
    machine
        With any rotor, without gravity across its axis.
    parameters
        Names or paths; every later call gives one value for each.
    speed
        Rotor speed where it is not a parameter; by default that of a machine with a prescribed constant speed.

    Raises
    ------
    QuestionError
        For an unknown parameter, one that has no effect or is no number, a missing speed, gravity, or anisotropic supports that
        push along the axis or turn the rotor about it, too.
    """

    def __init__(self, machine: Machine, parameters: Sequence[str], speed: float | None = None) -> None:
        self.machine, self.parameters = machine, tuple(parameters)
        self._plane = plane(machine) if is_planar(machine) and not has_forces(machine) else None
        self._base = station_form(machine)
        self._basis: Matrix | None = None
        self.count = 1 if self._base.isotropic else FIRST_COUNT  # of harmonics of a state
        if self.count > 1:
            refuse_motion_along_the_axis(self._base.model)
        for part in (part for name in self.parameters for part in parts_of(name)):
            self._check(part)
        if "speed" not in self.parameters:
            drive = machine.drive
            if speed is None and isinstance(drive, PrescribedSpeed) and isinstance(drive.profile, Constant):
                speed = float(drive.profile.speed)
            if speed is None:
                raise QuestionError("speed: the machine has no constant prescribed speed; give one, in rad/s")
            if not (math.isfinite(speed) and speed > 0.0):
                raise QuestionError(f"speed: given {speed!r}; must be greater than zero, in rad/s")
        self._speed = speed
        self._at = lru_cache(maxsize=64)(self._build)
        self.merged = lru_cache(maxsize=64)(self._merged)

    def __call__(self, *values: float) -> Equations:
        """The field at these values."""
        return self._at(tuple(float(value) for value in values))

    def reduce(self, highest: float) -> None:
        """Take fewer coordinates of a rotor that has many, for speeds up to ``highest``, rad/s."""
        self._basis = basis_for(self._base, highest)
        self._forget()

    def refine(self, count: int) -> None:
        """Count so many harmonics of a state."""
        self.count = count
        self._forget()

    def _forget(self) -> None:
        self._at.cache_clear()
        self.merged.cache_clear()

    def _merged(self, groups: Groups, *values: float) -> Equations:
        """The field at these values with every group of balls as one ball."""
        whole = self(*values)
        return self._equations(merged(whole.host, groups), whole.speed)

    def _equations(self, host: Stations, speed: float) -> Equations:
        if self.count > 1:
            return Cycle(host, speed, self.count)
        if not host.isotropic:
            raise QuestionError(
                "branches: the supports become different along x and y on the way; begin with a machine on which they differ"
            )
        return Field(host, speed)

    def read(self, index: int, value: float | str) -> float:
        """A value of parameter ``index`` in SI; texts have a unit."""
        name = self.parameters[index]
        return float(to_si(value, "rad/s") if name == "speed" else si_value(self.machine, name, value))

    def ends(self, index: int, start: float | str, end: float | str | None) -> tuple[float, float]:
        """Both ends of the range of a parameter in SI; without ``end`` the first is a text with both."""
        name = self.parameters[index]
        if end is not None:
            return self.read(index, start), self.read(index, end)
        if not is_range(start):
            raise QuestionError(
                f"{name}: given {start!r} only; give the other end too, or both as {example(si_unit_of(name))}"
            )
        first, last = ends(name, str(start), si_unit_of(name))
        return self.read(index, first), self.read(index, last)

    def now(self, index: int) -> float:
        """The value that the machine itself has; nan if it has none, or not one for all."""
        if self._plane is None and self.parameters[index] == "unbalance":
            return abs(self._base.unbalance)
        return value_of(self.machine, self.parameters[index])

    def attributes(self, index: int) -> dict[str, str]:
        """Long name, SI unit and symbol of a parameter."""
        return axis_attributes(self.parameters[index])

    def _build(self, values: tuple[float, ...]) -> Equations:
        machine, speed = self.machine, self._speed
        quick: dict[str, float] = {}
        for name, value in zip(self.parameters, values, strict=True):
            if name == "speed":
                speed = value
            elif name in (QUICK if self._plane is None else QUICK_IN_PLANE):
                quick[name] = value
            else:
                machine = with_quantity(machine, name, value)
        assert speed is not None
        if self._plane is not None:
            p = self._plane if machine is self.machine else plane(machine)
            for name, value in quick.items():
                p = _changed(p, machine, name, value)
            return self._equations(of_plane(p), speed)
        host = self._base if machine is self.machine else station_form(machine)
        for name, value in quick.items():
            if name == "drag":
                host = replace(host, drag=np.full(host.moment.size, value))
                continue
            if host.unbalance == 0.0:
                raise QuestionError(
                    "parameter 'unbalance': the unbalances of this machine have no resultant; give the path of one of them, "
                    "such as 'unbalances[1].moment'"
                )
            share = value / abs(host.unbalance)  # all unbalances keep their proportions
            host = replace(host, load=host.load * share, unbalance=host.unbalance * share)
        return self._equations(host if self._basis is None else projected(host, self._basis), speed)

    def _check(self, name: str) -> None:
        if name != "speed" and "." not in name and name not in SMOOTH:
            raise QuestionError(
                f"parameter: given {name!r}; must be one of {', '.join(SMOOTH)}, or a path like 'rotor.mass'"
            )
        if re.match(r"(drive|start|run)\b", name):
            raise QuestionError(
                f"parameter {name!r}: has no effect on steady states; for the rotor speed write 'speed'"
            )
        if name == "speed":
            return
        try:
            value = value_of(self.machine, name)
        except (AttributeError, IndexError):
            with_quantity(self.machine, name, 1.0)  # says what there is
            raise
        if name in ("stiffness", "damping") and math.isnan(value) and self._base.planar:
            raise QuestionError(
                f"parameter {name!r}: would make x and y alike, and those of this machine differ; give the path of one of them, "
                f"'rotor.{name}[1]', or both in proportion, 'rotor.{name}[1] & rotor.{name}[2]'"
            )
        if name in ("viscosity", "ball_diameter"):
            with_quantity(self.machine, name, 1e-3 if math.isnan(value) else value)  # says why it cannot change
        if name.endswith(".count"):
            raise QuestionError(f"parameter {name!r}: must be a number that can change smoothly")


def _changed(p: Plane, machine: Machine, name: str, value: float) -> Plane:
    """What ``with_quantity`` would give, without going through the description of the machine."""
    if name == "unbalance":
        size = abs(p.unbalance)
        return replace(p, unbalance=value * (p.unbalance / size if size else 1.0))
    if name == "damping":
        return replace(p, damping=(value, value))
    if name == "stiffness":
        return replace(p, stiffness=(value, value))
    if name == "drag":
        return replace(p, drag=np.full(p.moment.size, value))
    if name == "viscosity":
        now = value_of(machine, "viscosity")
        if math.isnan(now):
            return plane(with_quantity(machine, name, value), p.unbalance)
        return replace(p, drag=p.drag * value / now)
    balls = resolve(machine)
    mass = np.array([value - ball.displaced for ball in balls])
    orbit = np.array([ball.orbit_radius for ball in balls])
    kept = [ball.mass / value if ball.body == "pendulum" else 1.0 for ball in balls]  # whose own inertia stays
    spin = np.array([ball.spin_ratio * share for ball, share in zip(balls, kept, strict=True)])
    fluid = np.array([ball.virtual_mass * ball.displaced for ball in balls])
    inertia = ((1.0 + spin) * value + fluid) * orbit**2
    whole = p.mass + float(mass.sum() - p.ball_mass.sum())
    return replace(p, mass=whole, ball_mass=mass, moment=mass * orbit, inertia=inertia)


# Equal balls can be exchanged: balls that coincide move as one, and states that differ by an exchange are the same.
#
# Balls that stand in one place stay there together, so a group of k coincident equal balls is one ball of k times the
# mass, inertia and drag. In these reduced coordinates (the fixed-point space of the exchanges) a state that is
# singular only because the group may fall apart is a regular one; the falling apart is a scalar equation, I d'' + beta
# d' + r d = 0, for each group. Where r passes zero new states branch off in which the group has split in two
# (equivariant branching lemma: Golubitsky et al. 1988, XIII.3).


Groups: TypeAlias = tuple[tuple[int, ...], ...]
TOGETHER = 1e-7  # rad: nearer balls count as coincident


def kinds(hosts: list[Stations]) -> list[tuple[float, ...]]:
    """For each ball what it shares with its equals, in all of these hosts."""
    if hosts[0].forces is not None and hosts[0].forces.pairs:  # a ball that changes places gets other neighbors
        return [(float(ball),) for ball in range(hosts[0].moment.size)]
    rows = [np.stack([h.race, h.ball_mass, h.moment, h.inertia, h.drag, h.offset.real, h.offset.imag]) for h in hosts]
    return [tuple(column) for column in np.concatenate(rows).T.tolist()] if hosts[0].moment.size else []


def coincident(angles: Floats, kind: list[tuple[float, ...]]) -> Groups:
    """Equal balls at one place, by their first ball."""
    groups: list[list[int]] = []
    for ball in range(angles.size):
        for group in groups:
            first = group[0]
            if (
                kind[first] == kind[ball]
                and abs(math.remainder(angles[ball] - angles[first], 2.0 * math.pi)) < TOGETHER
            ):
                group.append(ball)
                break
        else:
            groups.append([ball])
    return tuple(tuple(group) for group in groups)


def merged(p: Stations, groups: Groups) -> Stations:
    """The stations at which every group is one ball."""
    if len(groups) == p.moment.size:
        return p
    first = [group[0] for group in groups]

    def total(values: Floats) -> Floats:
        return np.array([values[list(group)].sum() for group in groups])

    return replace(
        p,
        race=p.race[first],
        station=p.station[first],
        offset=p.offset[first],
        ball_mass=total(p.ball_mass),
        moment=total(p.moment),
        inertia=total(p.inertia),
        drag=total(p.drag),
        forces=None if p.forces is None else p.forces.merged(groups),
    )


def expanded(states: Floats, groups: Groups, rotor: int) -> Floats:
    """States of the merged balls as states of all balls, behind ``rotor`` components; last axis rotor + 2 n."""
    place = np.zeros(sum(len(group) for group in groups), np.int64)
    for number, group in enumerate(groups):
        place[list(group)] = rotor + number
    return np.concatenate([states[..., :rotor], states[..., place], states[..., len(groups) + place]], -1)


def gathered(states: Floats, groups: Groups, rotor: int) -> Floats:
    """States of the merged balls for states of all balls; the last axis counts components."""
    n = (states.shape[-1] - rotor) // 2
    first = rotor + np.array([group[0] for group in groups], np.int64)
    return np.concatenate([states[..., :rotor], states[..., first], states[..., n + first]], -1)


def restoring(equations: Equations, state: Floats) -> Floats:
    """r of every ball, over I w^2: falls below zero where balls at this place no longer stay together.

    Where it varies over half a turn, the constant one that does the same.
    """
    field, here = equations.field, equations.around(state)
    p, first = field.host, field.rotor
    half, turned = first // 2, np.zeros_like(here)
    turned[..., first : first + field.balls] = (
        1.0  # the torque on a ball depends on no other ball but through the rotor
    )
    matrices, right = field.series(here, turned, 1)
    whole = field.accelerations(here, field(here))
    torque = right[1][..., half:] - (matrices[1][..., half:, :half] @ whole[..., None])[..., 0]
    stiffness = np.asarray(-torque / (p.inertia * field.speed**2))
    if equations.count == 1:
        return stiffness
    slowed = np.roll(turned, field.balls, -1)
    return equations.held(stiffness, -field.series(here, slowed, 1)[1][1][..., half:] / (p.inertia * field.speed))


def splittings(groups: Groups) -> list[tuple[Groups, Floats]]:
    """Ways in which one group falls apart in two: the new groups, and in which direction each of them moves at first."""
    result = []
    for number, group in enumerate(groups):
        for part in range(1, len(group) // 2 + 1):
            new = (*groups[:number], group[:part], group[part:], *groups[number + 1 :])
            way = np.zeros(len(new))
            way[number], way[number + 1] = (len(group) - part) / len(group), -part / len(group)
            result.append((new, way))
    return result


def in_two_bundles(
    angles: Floats, p: Stations, kind: list[tuple[float, ...]], true: NDArray[np.bool_]
) -> Floats | None:
    """Ball angles with the same resultants in which the balls of each race that runs true stand in two bundles.

    The bundles are as even as possible. In the merged balls the state is no continuum any more. ``true``: whether the race
    of each ball runs true. ``None`` if the balls of such a station are not all equal, or no two bundles close.
    """
    new = np.array(angles)
    for station in sorted(set(p.station[true].tolist())):
        balls = np.flatnonzero(true & (p.station == station))
        count = balls.size
        if len({kind[ball] for ball in balls}) != 1:
            return None
        if count < 3:
            continue
        target, one = complex((p.moment[balls] * np.exp(1j * angles[balls])).sum()), p.moment[balls[0]]
        parts = range(count // 2, 0, -1)
        closed = [(part, close_polygon(one * np.array([float(count - part), float(part)]), target)) for part in parts]
        part, pairs = next(((part, pairs) for part, pairs in closed if pairs), (0, []))
        if not pairs:
            return None
        new[balls] = np.repeat(pairs[0], [count - part, part])
    return new


def signature(p: Stations, state: Floats) -> Floats:
    """Numbers that no exchange of equal balls alters, nor, of one station, the mirror image of a rotor at rest."""
    pairs, first, total = p.model.pairs, 4 * p.model.pairs, p.moment.sum() or 1.0
    loads = p.rows @ p.load
    values: list[float] = []
    for station, load in enumerate(loads):
        heavy = load / abs(load) if load else 1.0
        balls = np.flatnonzero(p.station == station)
        angle = state[first + balls] - np.angle(heavy)
        whirl = complex(p.rows[station] @ (state[:pairs] + 1j * state[pairs : 2 * pairs])) * np.conj(heavy)
        sums = [complex((p.moment[balls] * np.exp(1j * k * angle)).sum()) / total for k in (1, 2, 3)]
        numbers = [whirl * p.model.total_mass / (abs(p.unbalance) + total), *sums]
        values += [n.real for n in numbers] + [abs(n.imag) if loads.size == 1 else n.imag for n in numbers]
    return np.array(values)
