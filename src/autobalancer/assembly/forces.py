"""Forces on balls: which acts on which, and whether each is what it says."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Iterator
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
from autobalancer.kernels.records import FORCE as FORCES_FORCE
from autobalancer.kernels.records import NONE, PLACE
from autobalancer.kernels.system import Floats
from autobalancer.machine import Force, Machine
from autobalancer.progress import returned

# Forces on balls as rows of kernels/records.py.


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
        made = compiled_force(force, path, its_balls, float(places[members[0]].gravity)) if tried else made_of(force)
        fields = {"address": made.force.address, "energy": made.energy.address if made.energy else 0}
        fields["first"] = len(numbers)
        numbers += force.numbers().values() or (0.0,)
        rows += [
            FORCES_FORCE.row(ball=i, other=j, wrap=wrap, **fields) for i, j, wrap in _acting(force, members, angles)
        ]
    return {"places": places, "forces": _array(rows), "force_numbers": np.array(numbers, np.float64)}


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


def _array(rows: list[Any]) -> Any:
    result = FORCES_FORCE.rows(len(rows))
    for i, row in enumerate(rows):
        result[i] = row
    return result


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


class Made(NamedTuple):
    """The compiled functions of a force."""

    force: CompiledFunction
    energy: CompiledFunction | None


class Where(NamedTuple):
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


def compiled_force(force: Force, path: str, balls: tuple[Ball, ...], gravity: float) -> Made:
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
def _tried(force: Force, orbit: float, mass: float, radius: float, gravity: float) -> Made:
    made = made_of(force)
    own = numbers_row(force.numbers())
    fixed = {"mass": mass, "radius": radius, "orbit": orbit, "gravity": gravity}
    balls = [PLACE.row(**fixed) for _ in range(2 if force.pairs else 1)]

    def rows(where: Where) -> list[Any]:
        angle = [cmath.phase(place) for place in where.places]
        ahead = math.fmod(angle[-1] - angle[0] + 4.0 * math.pi, 2.0 * math.pi)
        for row, place, velocity, side in zip(balls, where.places, where.velocities, (-ahead, ahead), strict=False):
            row["x"], row["y"], row["vx"], row["vy"] = place.real, place.imag, velocity.real, velocity.imag
            row["ahead"], row["speed"] = side, where.speed
        return balls

    def tries() -> list[tuple[Where, list[float]]]:
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


def made_of(force: Force) -> Made:
    """The compiled functions of a force, untried."""
    return Made(_made(force, "force"), _made(force, "energy") if force.conservative() else None)


def _made(force: Force, method: str) -> CompiledFunction:
    function, pair = getattr(type(force), method, None), bool(force.pairs)
    if function is None:
        raise MachineError(f"has no '{method}'; it is a static method that must {RETURNS[method][pair]}")
    requested = function, tuple(force.numbers()), CALLS[method][pair]
    try:
        return compile_function(*requested)
    except Exception as reason:
        said = in_words(reason, *requested)
        raise MachineError(f"does not compile: in {method!r}, {said}; it must {RETURNS[method][pair]}") from None


def _wheres(force: Force, orbit: float) -> Iterator[Where]:
    """A few dozen ordinary places: around the race on its wall and inside, at rest and in motion, at several speeds."""
    for number in range(ANGLES):
        away = cmath.rect(orbit * RADII[number % 2], 0.1 + number * 2.0 * math.pi / ANGLES)
        for speed in SPEEDS:
            for rate in (0.0, 0.3 * speed + 1.0, -0.1 * speed - 1.0):
                moving = away * complex(0.05, 1.0) * rate
                if force.pairs:
                    ahead = cmath.rect(orbit, cmath.phase(away) + 0.5 + 0.7 * number)
                    yield Where((away, ahead), (moving, -0.5j * rate * ahead), speed)
                else:
                    yield Where((away,), (moving,), speed)


def _refuse_false_energy(energy: Callable[[Where], float], tried: list[tuple[Where, list[float]]], step: float) -> None:
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
