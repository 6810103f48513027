"""Guided balls as rows of kernels/records.py."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from autobalancer.assembly.contact import ring
from autobalancer.catalog.resolve import Ball
from autobalancer.errors import MachineError
from autobalancer.kernels.compiler.callbacks import (
    ENERGY,
    FORCE,
    PAIR_ENERGY,
    PAIR_FORCE,
    CompiledFunction,
    compile_function,
    in_words,
    numbers_row,
)
from autobalancer.kernels.records import BALL, GUIDED, LINE, NONE, PLACE, POINT, RELAXATION, TABLE, WAVE
from autobalancer.kernels.records import FORCE as FORCE_RECORD
from autobalancer.kernels.system import Floats, Fluid, Matrix, Rows
from autobalancer.laws.drag_coefficient import DISTANCE, FIT, REYNOLDS
from autobalancer.machine import Force, Machine, Race
from autobalancer.progress import returned


def is_real(machine: Machine, balls: tuple[Ball, ...], lags: Lags | None = None) -> bool:
    """Whether the machine needs more than linear drag on smooth circular races."""
    races = [race for balancer in machine.balancers for race in balancer.races]
    rough = any(race.friction is not None or race.harmonics or race.roundness is not None for race in races)
    curved = any(ball.drag_curve is not None or ball.slipstream for ball in balls)
    return bool(rough or curved or machine.excitations or lags)


def ball_inertia(ball: Ball) -> float:
    """Inertia of a ball about the shaft, its own spin included, kg m^2."""
    return ball.own_inertia + ball.effective_mass * (abs(ball.eccentricity) ** 2 + ball.orbit_radius**2)


def ball_rows(balls: tuple[Ball, ...]) -> Rows:
    """Balls on smooth circles with linear drag."""
    rows = BALL.rows(len(balls))
    for row, ball in zip(rows, balls, strict=True):
        roll = ball.spin_ratio * ball.mass * ball.rolling_radius
        row.station, row.orbit = ball.balancer, ball.orbit_radius
        row.mass, row.moment, row.inertia = ball.effective_mass, ball.moment, ball.inertia
        row.stretch = ball.inertia / ball.orbit_radius**2
        row.spin = ball.moment * ball.orbit_radius - roll * ball.orbit_radius
        row.roll, row.own_spin = roll, ball.own_inertia
        row.drag, row.viscous = ball.drag, ball.drag / ball.orbit_radius**2
        row.center_x, row.center_y = ball.eccentricity.real, ball.eccentricity.imag
        for name, value in ball.given:
            row[name] = value
    rows.drag_curve = rows.slipstream = rows.lag_table = NONE
    return rows


def moving_rows(balls: tuple[Ball, ...]) -> Rows:
    """What the equations find of each ball, before they found anything: all roll."""
    rows = GUIDED.rows(len(balls))
    rows.mode = 1.0
    return rows


def put_on_races(machine: Machine, balls: tuple[Ball, ...], rows: Rows, moving: Rows, fluids: FluidRows) -> WaveRows:
    """Give balls the friction, drag and shape of their races; returns the waves of these."""
    waves = WaveRows(machine)
    for number, (row, now, ball) in enumerate(zip(rows, moving, balls, strict=True)):
        if ball.adherence > 0.0:
            row.rolling, row.adherence = ball.rolling_resistance, ball.adherence
            row.pulls = 1.0 if ball.body == "pendulum" else 0.0
            now.mode = math.copysign(1.0, ball.start_speed) if ball.start_speed else 0.0
        waves.fill(row, ball)
        fluids.fill(row, number)
    return waves


# What balls of every kind need of their fluid: drag curves, slipstream, lags; and tables over time.


LONGEST_TABLE = 400_000


@dataclass(frozen=True)
class Lag:
    """How the fluid at the orbit lags behind its chamber: W_f = w - lag.

    Either relaxation modes, lag = sum c_k, c_k' = gain_k w' - rate_k c_k, or a table over time (uniform steps).
    """

    rates: Floats = field(default_factory=lambda: np.zeros(0))
    gains: Floats = field(default_factory=lambda: np.zeros(0))
    times: Floats = field(default_factory=lambda: np.zeros(0))
    values: Floats = field(default_factory=lambda: np.zeros(0))


Lags = Mapping[tuple[int, int], Lag]  # by numbers of balancer and race, from 0


@dataclass(frozen=True)
class UniformTable:
    """A curve over a uniform grid."""

    start: float
    step: float
    values: Floats
    slopes: Floats  # per step


class FluidRows:
    """Collects curves, modes, lines and tables, each once, and writes into the row of a ball which are its own.

    The states of the modes begin at ``first_state``.
    """

    def __init__(self, balls: tuple[Ball, ...], lags: Lags, first_state: int) -> None:
        self.balls, self.lags, self.first_state = balls, lags, first_state
        self.tables: list[UniformTable] = []
        self.modes: list[tuple[float, float]] = []
        self.lines: list[tuple[Ball, int, list[int]]] = []
        self.known: dict[object, int] = {}

    def fill(self, row: Any, number: int) -> None:
        """Fill the fields of the ball of this ``number`` that name curves, modes, lines and tables."""
        ball = self.balls[number]
        place = ball.balancer, ball.race
        row.drag_curve = row.slipstream = row.lag_table = NONE
        if ball.drag_curve is not None:
            row.drag_curve = self._once(ball.drag_curve, lambda: self.add_table(_curve(ball)))
        if ball.slipstream:
            row.slipstream = len(self.lines)
            mates = [i for i, b in enumerate(self.balls) if (b.balancer, b.race) == place and i != number]
            self.lines.append((ball, number, mates))
        lag = self.lags.get(place, Lag())
        if lag.rates.size:
            row.modes = lag.rates.size
            row.first_mode = self._once(("modes", place), lambda: self._add_modes(lag))
        if lag.times.size:
            row.lag_table = self._once(("lag", place), lambda: self.add_table(uniform_table(lag.times, lag.values)))

    def add_table(self, table: UniformTable) -> int:
        """The number of a further table."""
        self.tables.append(table)
        return len(self.tables) - 1

    def _once(self, key: object, add: Any) -> int:
        if key not in self.known:
            self.known[key] = add()
        return self.known[key]

    def _add_modes(self, lag: Lag) -> int:
        self.modes += zip(lag.rates.tolist(), lag.gains.tolist(), strict=True)
        return len(self.modes) - int(lag.rates.size)

    @property
    def fluid(self) -> Fluid:
        """All of it."""
        tables, lines, modes = (
            TABLE.rows(len(self.tables)),
            LINE.rows(len(self.lines)),
            RELAXATION.rows(len(self.modes)),
        )
        points = POINT.rows(sum(table.values.size for table in self.tables))
        first = 0
        for row, table in zip(tables, self.tables, strict=True):
            row.start, row.step, row.count, row.first = table.start, table.step, table.values.size, first
            points[first : first + row.count].value, points[first : first + row.count].slope = (
                table.values,
                table.slopes,
            )
            first += int(row.count)
        others: list[int] = []
        for row, (ball, number, mates) in zip(lines, self.lines, strict=True):
            row.ball, row.first, row.others = number, len(others), len(mates)
            row.per_speed, row.per_angle = ball.diameter / ball.fluid_viscosity, ball.orbit_radius / ball.diameter
            row.greatest, row.reach = REYNOLDS[1], DISTANCE[1]
            others += mates
        for number, (row, (rate, gain)) in enumerate(zip(modes, self.modes, strict=True)):
            row.state, row.rate, row.gain = self.first_state + number, rate, gain
        return Fluid(tables, points, modes, lines, np.array(others, np.int64), np.array(FIT, np.float64))


def _curve(ball: Ball) -> UniformTable:
    """The drag curve of a ball: log force over log velocity."""
    assert ball.drag_curve is not None
    velocities, forces, slopes = ball.drag_curve.points()
    step = (velocities[-1] - velocities[0]) / (velocities.size - 1)
    return UniformTable(float(velocities[0]), float(step), forces, slopes)


def uniform_table(times: Floats, values: Floats) -> UniformTable:
    """A uniform table through these points, monotone between them; zero slope where it ends."""
    from scipy.interpolate import PchipInterpolator  # only where needed: it takes a tenth of a second to load

    step = float(np.diff(times).min())
    count = round((times[-1] - times[0]) / step) + 1
    if count > LONGEST_TABLE:
        raise MachineError(f"a record of {count} equal steps is too long; give at most {LONGEST_TABLE}")
    grid = np.linspace(times[0], times[-1], max(count, 2))
    curve = PchipInterpolator(times, values)
    step = float(grid[1] - grid[0])
    return UniformTable(float(grid[0]), step, curve(grid), step * curve.derivative()(grid))


# The waves of races that are not round.


def race_harmonics(race: Race) -> Matrix:
    """Deviation of the orbit radius as (order, cosine, sine amplitudes), (H, 2) from order 1 on, m."""
    if race.roundness is not None:
        values = np.array([float(v) for v in race.roundness.deviations])
        count, first = values.size, float(race.roundness.angle)
        spectrum = np.fft.rfft(values) / count
        orders = np.arange(1, race.roundness.harmonics + 1)
        turned = 2.0 * spectrum[orders] * np.exp(-1j * orders * first)
        return np.column_stack([turned.real, -turned.imag])
    if not race.harmonics:
        return np.zeros((0, 2))
    race_harmonics = np.zeros((max(h.order for h in race.harmonics), 2))
    for h in race.harmonics:
        turn = h.order * float(h.angle)
        race_harmonics[h.order - 1] += float(h.amplitude) * np.array([math.cos(turn), math.sin(turn)])
    return race_harmonics


class WaveRows:
    """Collects the waves of races, those of each once, and writes into the row of a ball which are its own."""

    def __init__(self, machine: Machine) -> None:
        self.machine = machine
        self.amplitudes = np.zeros((0, 2))
        self.places: dict[tuple[int, int], tuple[int, int]] = {}

    def fill(self, row: Any, ball: Ball) -> None:
        """Fill the fields of a ball that say how many waves its race has, and where they are."""
        place = ball.balancer, ball.race
        if place not in self.places:
            harmonics = race_harmonics(self.machine.balancers[ball.balancer].races[ball.race])
            self.places[place] = harmonics.shape[0], self.amplitudes.shape[0]
            self.amplitudes = np.concatenate([self.amplitudes, harmonics])
        row.waves, row.first_wave = self.places[place]

    @property
    def rows(self) -> Rows:
        """All of them."""
        rows = WAVE.rows(self.amplitudes.shape[0])
        rows.cosine, rows.sine = self.amplitudes.T
        return rows


# Forces on balls as rows of kernels/records.py: which acts on which, and whether each is what it says.


def has_forces(machine: Machine) -> bool:
    """Whether any race has forces on its balls."""
    return any(race.forces for balancer in machine.balancers for race in balancer.races)


def force_rows(machine: Machine, balls: tuple[Ball, ...], angles: Floats, *, tried: bool = True) -> dict[str, Any]:
    """Forces and the places of balls as fields of a system; ``angles`` at the start give the order of the balls.

    ``tried`` is ``False`` for a machine whose forces were tried before, with other numbers.

    Raises
    ------
    MachineError
        If a force cannot be used; the message says which one, and why.
    """
    if not has_forces(machine):
        return {}
    places = PLACE.rows(len(balls))
    for row, ball in zip(places, balls, strict=True):
        row.mass, row.radius, row.orbit = ball.effective_mass, ball.radius, ball.orbit_radius
        row.gravity = float(machine.gravity) if machine.axis == "vertical" else 0.0
    rows: list[Any] = []
    numbers: list[float] = []
    for path, force, members in forces_in(machine, balls):
        its_balls = tuple(balls[i] for i in members)
        made = (
            compiled_force(force, path, its_balls, float(places[members[0]].gravity)) if tried else compile_force(force)
        )
        fields = {"address": made.force.address, "energy": made.energy.address if made.energy else 0}
        fields["first"] = len(numbers)
        numbers += force.numbers().values() or (0.0,)
        rows += [
            FORCE_RECORD.row(ball=i, other=j, wrap=wrap, **fields) for i, j, wrap in _acting(force, members, angles)
        ]
    return {
        "places": places,
        "forces": np.array(rows, FORCE_RECORD.dtype).view(np.recarray),
        "force_numbers": np.array(numbers, np.float64),
    }


def forces_in(machine: Machine, balls: tuple[Ball, ...]) -> Iterator[tuple[str, Force, list[int]]]:
    """Each force of a machine: its path, itself, the numbers of the balls of its race."""
    for b, balancer in enumerate(machine.balancers):
        for r, race in enumerate(balancer.races):
            members = [i for i, ball in enumerate(balls) if (ball.balancer, ball.race) == (b, r)]
            for f, force in enumerate(race.forces):
                yield f"balancers[{b + 1}].races[{r + 1}].forces[{f + 1}]", force, members


def _acting(force: Force, members: list[int], angles: Floats) -> list[tuple[int, int, float]]:
    if force.pairs == "":
        return [(i, NONE, 0.0) for i in members]
    if force.pairs == "neighbors":
        return [link for link in ring(members, angles) if link[0] != link[1]]
    return [ring(pair, angles)[0] for pair in combinations(members, 2)]


# A force is compiled and tried at places around its race before it is used: it must be a number, and what it says it
# is.


STEP = 1e-5  # of the orbit radius, in differences of the energy
CLOSE = 1e-5  # by which force and gradient may differ, over the greatest force that was found
SPEEDS = (0.0, 30.0, 300.0)  # rad/s, of the rotor
RADII = (1.0, 0.97)  # of the orbit radius
ANGLES = 8
CALLS = {"force": (FORCE, PAIR_FORCE), "energy": (ENERGY, PAIR_ENERGY)}
RETURNS = {  # what each method must do, for one ball and for two
    "force": (
        "return 2 numbers: force(at, own) -> (fx, fy)",
        "return 4 numbers: force(at, next, own) -> (fx, fy, fx_next, fy_next)",
    ),
    "energy": ("return a number: energy(at, own)", "return a number: energy(at, next, own)"),
}


class CompiledForce(NamedTuple):
    """The compiled functions of a force."""

    force: CompiledFunction
    energy: CompiledFunction | None


class TrialPlace(NamedTuple):
    """Where a force is tried: places and velocities of one ball or two, m and m/s, and the speed of the rotor, rad/s."""

    places: tuple[complex, ...]
    velocities: tuple[complex, ...]
    speed: float

    def __str__(self) -> str:
        place, velocity = self.places[0], self.velocities[0]
        other = (
            f", the next ball at x = {self.places[1].real:.4g} m, y = {self.places[1].imag:.4g} m"
            if self.places[1:]
            else ""
        )
        return (
            f"x = {place.real:.4g} m, y = {place.imag:.4g} m{other}, at a velocity of {velocity.real + 0.0:.4g} and "
            f"{velocity.imag + 0.0:.4g} m/s and a rotor speed of {self.speed:g} rad/s"
        )


def compiled_force(force: Force, path: str, balls: tuple[Ball, ...], gravity: float) -> CompiledForce:
    """The compiled functions of a force at this ``path`` that acts on these balls of one race.

    Raises
    ------
    MachineError
        If it does not compile, is not a number somewhere, or its energy does not match.
    """
    ball = balls[0]
    try:
        return _tried(force, ball.orbit_radius, ball.effective_mass, ball.radius, gravity)
    except MachineError as reason:
        raise MachineError(f"{path}: the force {force.word()!r} {reason}") from None


@lru_cache(maxsize=256)
def _tried(force: Force, orbit: float, mass: float, radius: float, gravity: float) -> CompiledForce:
    made = compile_force(force)
    own = numbers_row(force.numbers())
    fixed = {"mass": mass, "radius": radius, "orbit": orbit, "gravity": gravity}
    balls = [PLACE.row(**fixed) for _ in range(2 if force.pairs else 1)]

    def rows(where: TrialPlace) -> list[Any]:
        angle = [cmath.phase(place) for place in where.places]
        ahead = math.fmod(angle[-1] - angle[0] + 4.0 * math.pi, 2.0 * math.pi)
        for row, place, velocity, side in zip(balls, where.places, where.velocities, (-ahead, ahead), strict=False):
            row["x"], row["y"], row["vx"], row["vy"] = place.real, place.imag, velocity.real, velocity.imag
            row["ahead"], row["speed"] = side, where.speed
        return balls

    def tries() -> list[tuple[TrialPlace, list[float]]]:
        wheres = _wheres(force, orbit)
        return [(where, [float(part) for part in made.force.function(*rows(where), own)]) for where in wheres]

    tried = returned(tries, f"the force {force.word()!r}")
    for where, parts in tried:
        if len(parts) != (4 if force.pairs else 2):
            raise MachineError(f"returns {len(parts)} numbers; it must {RETURNS['force'][bool(force.pairs)]}")
        if not all(map(math.isfinite, parts)):
            raise MachineError(f"is not a number at {where}: it returned {_listed(parts)}")
    energy = made.energy
    if energy is not None:
        returned(
            lambda: _refuse_false_energy(lambda where: float(energy.function(*rows(where), own)), tried, STEP * orbit),
            f"the energy of the force {force.word()!r}",
        )
    return made


def compile_force(force: Force) -> CompiledForce:
    """The compiled functions of a force, untried."""
    return CompiledForce(
        _compiled_method(force, "force"), _compiled_method(force, "energy") if force.conservative() else None
    )


def _compiled_method(force: Force, method: str) -> CompiledFunction:
    function, pair = getattr(type(force), method, None), bool(force.pairs)
    if function is None:
        raise MachineError(f"has no '{method}'; it is a static method that must {RETURNS[method][pair]}")
    requested = function, tuple(force.numbers()), CALLS[method][pair]
    try:
        return compile_function(*requested)
    except Exception as reason:
        said = in_words(reason, *requested)
        raise MachineError(f"does not compile: in {method!r}, {said}; it must {RETURNS[method][pair]}") from None


def _wheres(force: Force, orbit: float) -> Iterator[TrialPlace]:
    """A few dozen ordinary places: around the race on its wall and inside, at rest and in motion, at several speeds."""
    for number in range(ANGLES):
        away = cmath.rect(orbit * RADII[number % 2], 0.1 + number * 2.0 * math.pi / ANGLES)
        for speed in SPEEDS:
            for rate in (0.0, 0.3 * speed + 1.0, -0.1 * speed - 1.0):
                moving = away * complex(0.05, 1.0) * rate
                if force.pairs:
                    ahead = cmath.rect(orbit, cmath.phase(away) + 0.5 + 0.7 * number)
                    yield TrialPlace((away, ahead), (moving, -0.5j * rate * ahead), speed)
                else:
                    yield TrialPlace((away,), (moving,), speed)


def _refuse_false_energy(
    energy: Callable[[TrialPlace], float], tried: list[tuple[TrialPlace, list[float]]], step: float
) -> None:
    """Refuse an energy whose negative gradient is not the force; at a bend of the energy, that of either side will do."""
    greatest = max((abs(part) for _, parts in tried for part in parts), default=0.0)
    for where, parts in tried:
        here, standing = energy(where), energy(where._replace(speed=0.0))
        if not math.isfinite(here):
            raise MachineError(f"has an energy that is not a number at {where}: it is {here:g}")
        if abs(here - standing) > CLOSE * (greatest * step / STEP + abs(here)):
            raise MachineError(
                f"has an energy that depends on the speed of the rotor: {here:.6g} J at {where}, {standing:.6g} J at standstill. "
                "Such a force is not conservative; leave 'energy' out"
            )
        slopes = [
            [
                -(energy(where._replace(places=_moved(where.places, number, by))) - here) / (by / way).real
                for by in (-step * way, step * way)
            ]
            for number in range(len(where.places))
            for way in (1.0, 1j)
        ]
        far = CLOSE * greatest
        if not all(min(both) - far <= part <= max(both) + far for part, both in zip(parts, slopes, strict=True)):
            raise MachineError(
                f"says it is conservative, but its energy does not match: at {where} the force is {_listed(parts)} N and the "
                f"negative gradient of the energy {_listed([0.5 * sum(both) for both in slopes])} N. Correct one of them, or "
                "leave 'energy' out"
            )


def _moved(places: tuple[complex, ...], number: int, by: complex) -> tuple[complex, ...]:
    return tuple(place + by if i == number else place for i, place in enumerate(places))


def _listed(parts: list[float]) -> str:
    return f"({', '.join(f'{part:.6g}' for part in parts)})"
