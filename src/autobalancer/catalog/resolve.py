"""From words to numbers: materials and fluids looked up, sizes and masses worked out, fit checked."""

from __future__ import annotations

import cmath
import math
from collections.abc import Hashable, Iterable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from autobalancer.cache import remembered
from autobalancer.catalog.product_tables import ROOM, Bearing, fluid, material
from autobalancer.catalog.product_tables import bearing as find_bearing
from autobalancer.drag.race_geometry import AnnulusDrag
from autobalancer.errors import CatalogError, MachineError, Problem, QuestionError
from autobalancer.laws.drag_coefficient import (
    FASTEST,
    SLOWEST,
    UNNAMED,
    DragCurve,
    DragLaw,
    LinearLaw,
    Sheared,
    ShearedDragCurve,
    linear_drag,
    tried,
)
from autobalancer.laws.ring_of_liquid import Ring
from autobalancer.machine import Balls, Fluid, Machine, PlanarRotor, Race
from autobalancer.machine.balancer.fluid import BallInRace, Drag, ShearLaw
from autobalancer.machine.machine import LiquidRing
from autobalancer.machine.part import keys_noted
from autobalancer.machine.rotors.planar import DAMPERS, SPRINGS
from autobalancer.progress import returned


@dataclass(frozen=True)
class Ball:
    """One ball, roller or pendulum in its race, SI. ``diameter`` and ``volume`` are 0 where they are not known."""

    balancer: int
    race: int
    mass: float
    diameter: float
    volume: float
    displaced: float  # mass of the fluid displaced
    orbit_radius: float
    spin_ratio: float  # J / (m a^2), a the rolling radius: 2/5 rolling ball, 0 point, 1/2 to 1 roller
    virtual_mass: float  # coefficient
    drag: float  # beta, N m s
    eccentricity: complex  # race center in the rotor, m
    start_angle: float | None
    start_speed: float
    drag_curve: DragCurve | None = None  # over the whole range of Reynolds numbers; None where the drag is linear
    fluid_density: float = 0.0
    fluid_viscosity: float = 0.0  # kinematic; both 0 without a fluid
    slipstream: bool = False  # whether the balls of its race shield each other
    stokes: bool = False  # whether its drag is the linear range of a law, kept at any Reynolds number
    body: str = "ball"  # or "roller", "pendulum"
    rolling_resistance: float = 0.0  # torque against its motion over normal force times orbit radius
    adherence: float = 0.0  # the same of what holds it at rest
    given: tuple[tuple[str, float], ...] = ()  # further numbers that the equations have under these names

    @property
    def effective_mass(self) -> float:
        """Mass less the fluid displaced: what drives and balances."""
        return self.mass - self.displaced

    @property
    def radius(self) -> float:
        """Ball radius, m."""
        return 0.5 * self.diameter

    @property
    def rolling_radius(self) -> float:
        """a, m: the body turns against its rotor with -eps phi'/a, a ball that rolls with its radius.

        A pendulum turns with phi', as if it rolled on the negative orbit radius.
        """
        return -self.orbit_radius if self.body == "pendulum" else self.radius

    @property
    def own_inertia(self) -> float:
        """J about its own center, of what turns, kg m^2."""
        return self.spin_ratio * self.mass * self.rolling_radius**2

    @property
    def inertia(self) -> float:
        """Inertia of the ball angle: mass, virtual mass and rolling, kg m^2 (1 + j) m eps^2 without fluid."""
        return ((1.0 + self.spin_ratio) * self.mass + self.virtual_mass * self.displaced) * self.orbit_radius**2

    @property
    def moment(self) -> float:
        """Effective mass times orbit radius: the unbalance this ball can balance, kg m."""
        return self.effective_mass * self.orbit_radius


@remembered(8)
def resolve(machine: Machine) -> tuple[Ball, ...]:
    """All balls of a machine, race by race, in the order in which they stand in the file.

    Raises
    ------
    MachineError
        If a name is unknown, a ball does not fit, floats, or there are more balls than fit.
    """
    balls: list[Ball] = []
    problems: list[Problem] = []
    for b, balancer in enumerate(machine.balancers):
        for r, race in enumerate(balancer.races):
            items: list[Problem] = []
            balls += _race(race, b, r, items)
            problems += [(("balancers", b, "races", r, *keys), message) for keys, message in items]
    if problems:
        raise MachineError.of("Machine", problems)
    return tuple(balls)


def fluid_numbers(part: Fluid) -> tuple[float, float]:
    """Density (kg/m^3) and kinematic viscosity (m^2/s) of a fluid, looked up if it has a name."""
    if part.name is not None:
        state = fluid(part.name) if part.temperature is None else fluid(part.name, float(part.temperature))
        return state.density, state.viscosity
    return float(part.density or 0.0), float(part.viscosity or 0.0)


def _race(race: Race, balancer: int, number: int, problems: list[Problem]) -> list[Ball]:
    density, viscosity = 0.0, 0.0
    shear: Sheared | None = None
    if race.fluid is not None:
        try:
            density, viscosity = fluid_numbers(race.fluid)
        except CatalogError as error:
            problems.append((("fluid", "name"), str(error)))
            return []
        try:
            shear = sheared(race.fluid, viscosity)
        except (CatalogError, QuestionError) as error:
            problems.append((("fluid", "shear"), str(error)))
            return []
    try:
        ring = find_bearing(race.bearing) if race.bearing is not None else None
    except CatalogError as error:
        problems.append((("bearing",), str(error)))
        return []
    balls: list[Ball] = []
    for g, group in enumerate(race.balls):
        resolved = _group(race, group, ("balls", g), (balancer, number), ring, (density, viscosity, shear), problems)
        if resolved is None:
            return []
        balls += resolved
    _refuse_neighbors(race, balls, problems)
    return balls


def _group(
    race: Race,
    group: Balls,
    keys: tuple[str, int],
    place: tuple[int, int],
    ring: Bearing | None,
    fluid_in_race: tuple[float, float, Sheared | None],
    problems: list[Problem],
) -> list[Ball] | None:
    """The balls of a group, equal but for their starts; None where one cannot even be described."""
    density, viscosity, shear = fluid_in_race
    try:
        mass, diameter, volume = size_of(group, ring)
    except CatalogError as error:
        problems.append(((*keys, "material"), str(error)))
        return None
    orbit = _orbit_in(race, group, keys, ring, (mass, diameter, volume), density, problems)
    if orbit is None:
        return None
    if race.drag.needs_fluid and diameter == 0.0:
        problems.append((keys, f"the drag law {race.drag.word()!r} needs the size of the balls; give 'diameter'"))
    if race.slipstream and diameter == 0.0:
        problems.append((("slipstream",), "needs the size of the balls; give 'diameter', or leave it out"))
    # drag on the orbit, linear or a curve over the speed in the fluid
    try:
        beta, curve = ball_drag(race.drag, 0.5 * diameter, orbit, density, viscosity)
        if shear is not None and diameter:
            curve = sheared_curve(race, 0.5 * diameter, orbit, (density, viscosity), shear)
    except QuestionError as error:
        problems.append((("drag",), str(error)))
        return None
    rolling, adherence = friction_of(group, race, orbit)
    parts = [part for part in (race, group, race.friction, race.fluid) if part is not None]
    numbers = tuple((name, getattr(one, name) or 0.0) for one in parts for name in keys_noted(type(one), "of_ball"))
    return [
        Ball(
            balancer=place[0],
            race=place[1],
            mass=mass,
            diameter=diameter,
            volume=volume,
            displaced=density * volume,
            orbit_radius=orbit,
            spin_ratio=spin_ratio_of(group, mass, orbit),
            virtual_mass=float(race.fluid.virtual_mass) if race.fluid is not None else 0.0,
            drag=beta,
            eccentricity=race.eccentricity
            * complex(math.cos(race.eccentricity_angle), math.sin(race.eccentricity_angle)),
            start_angle=float(group.start_angles[i]) if group.start_angles is not None else None,
            start_speed=float(group.start_speeds[i]) if group.start_speeds is not None else 0.0,
            drag_curve=curve,
            fluid_density=density,
            fluid_viscosity=viscosity,
            slipstream=race.slipstream and race.ball_count > 1,
            stokes=curve is None and viscosity > 0.0 and race.drag.needs_fluid,
            body=group.body,
            rolling_resistance=rolling,
            adherence=adherence,
            given=numbers,
        )
        for i in range(group.count)
    ]


def _orbit_in(
    race: Race,
    group: Balls,
    keys: tuple[str, int],
    ring: Bearing | None,
    size: tuple[float, float, float],
    density: float,
    problems: list[Problem],
) -> float | None:
    """The orbit radius of the balls of a group; None where there is none. What does not fit or floats is named."""
    mass, diameter, volume = size
    radius = 0.5 * diameter
    if race.race_radius is not None and diameter == 0.0:
        problems.append((keys, "a ball on a race given by 'race_radius' needs a size; give 'diameter'"))
        return None
    if ring is not None and race.race_radius is None and diameter > ring.ball_diameter * (1.0 + 1e-9):
        problems.append((keys, _too_large(diameter, ring)))
        return None
    orbit = _orbit(race, ring, radius)
    if orbit <= radius:
        problems.append(
            (
                keys,
                f"a {group.body} of {_mm(diameter)} is larger than an orbit of {_mm(max(orbit, 0.0))} radius allows",
            )
        )
        return None
    along = float(group.length or 0.0) if group.body == "roller" else diameter
    for key, room, extent in (("width", race.width, diameter), ("height", race.height, along)):
        if room is not None and extent > room:
            problems.append((keys, f"a {group.body} of {_mm(extent)} does not fit into a chamber of {key} {_mm(room)}"))
    if race.width is not None and race.width > orbit + radius:
        problems.append(
            (
                ("width",),
                f"given {_mm(race.width)}; that leaves no inner wall within a radius of {_mm(orbit + radius)}",
            )
        )
    displaced = density * volume
    if displaced >= mass:
        problems.append(
            (keys, f"the {group.body} (mass {mass:.4g} kg) floats: it displaces {displaced:.4g} kg of fluid")
        )
    return orbit


def _refuse_neighbors(race: Race, balls: list[Ball], problems: list[Problem]) -> None:
    """Name what balls of one race cannot be together: unequal on one orbit, too many, or begin in one place."""
    on_the_wall = {ball.diameter for ball in balls if ball.diameter and ball.body != "pendulum"}
    if race.orbit_radius is not None and len(on_the_wall) > 1:
        problems.append((("orbit_radius",), "balls of unequal size have unequal orbits; give 'race_radius' instead"))
    elif race.slipstream and len({ball.diameter for ball in balls}) > 1:
        problems.append((("slipstream",), "supported for balls of equal size only; use equal balls, or leave it out"))
    elif not problems:
        occupied = occupied_angle(balls)
        if occupied > 2.0 * math.pi * (1.0 + 1e-12):
            problems.append(
                (
                    ("balls",),
                    f"{len(balls)} balls take {math.degrees(occupied):.1f} deg of 360 deg; take fewer or smaller ones",
                )
            )
    given = [ball for ball in balls if ball.start_angle is not None]
    if given and len(given) < len(balls):
        problems.append(
            (("balls",), "start_angles are given for some balls of this race; give them for all or for none")
        )
    for i, one in enumerate(given if race.collisions else ()):
        for other in given[i + 1 :]:
            apart = abs(math.remainder(float(one.start_angle or 0.0) - float(other.start_angle or 0.0), 2.0 * math.pi))
            needed = 0.5 * occupied_angle([one, other])
            if apart < needed * (1.0 - 1e-9):
                problems.append(
                    (
                        ("balls",),
                        f"start_angles put two balls {math.degrees(apart):.2f} deg apart; "
                        f"they need {math.degrees(needed):.2f} deg",
                    )
                )


def occupied_angle(balls: list[Ball]) -> float:
    """Angle that the balls of one race take when they touch, in their order around the race, rad."""
    if len(balls) == 1:
        return 2.0 * math.asin(min(balls[0].radius / balls[0].orbit_radius, 1.0))
    total = 0.0
    for ball, other in zip(balls, balls[1:] + balls[:1], strict=True):
        reach, apart = ball.radius + other.radius, ball.orbit_radius - other.orbit_radius
        share = (reach**2 - apart**2) / (4.0 * ball.orbit_radius * other.orbit_radius)  # squared sine of half the angle
        total += 2.0 * math.asin(math.sqrt(min(max(share, 0.0), 1.0)))
    return total


def _orbit(race: Race, ring: Bearing | None, radius: float) -> float:
    """Of the ball centers; smaller balls in the ring of a bearing run on the same wall."""
    if race.orbit_radius is not None:
        return float(race.orbit_radius)
    if race.race_radius is not None:
        return float(race.race_radius) - radius
    assert ring is not None
    return ring.orbit_radius + (0.5 * ring.ball_diameter - radius if radius else 0.0)


def _too_large(diameter: float, ring: Bearing) -> str:
    return (
        f"a ball of {_mm(diameter)} is larger than those of bearing {ring.designation}, {_mm(ring.ball_diameter)}, for which its "
        "groove is made; take smaller balls, or describe the race by 'race_radius'"
    )


def _mm(length: float) -> str:
    return f"{1e3 * length:.4g} mm"


# Size, mass and rotation of balls, rollers and pendulums.


SOLID_BALL, SOLID_CYLINDER = 0.4, 0.5  # J / (m r^2)


def size_of(group: Balls, ring: Bearing | None) -> tuple[float, float, float]:
    """Mass, diameter and volume of one body of a group; diameter and volume are 0 where they are not known.

    Raises
    ------
    CatalogError
        If the material is not in the catalog.
    """
    stuff = float(group.density) if group.density is not None else None
    if group.material is not None:
        stuff = float(material(group.material).density)
    if group.body == "ball":
        return _ball(group, ring, stuff)
    mass, diameter = float(group.mass or 0.0), float(group.diameter or 0.0)
    if group.body == "pendulum":
        return mass, diameter, 0.0
    if group.length is not None:
        volume = roller_face(group) * float(group.length)
        return mass or (stuff or 0.0) * volume, diameter, volume
    return mass, diameter, mass / stuff if stuff else 0.0


def roller_face(group: Balls) -> float:
    """Area of the end of a roller, without its bore, m^2."""
    return 0.25 * math.pi * (float(group.diameter or 0.0) ** 2 - float(group.inner_diameter or 0.0) ** 2)


def spin_ratio_of(group: Balls, mass: float, orbit: float) -> float:
    """J over mass times the square of the rolling radius: 2/5 of a ball, 1/2 to 1 of a roller; of a pendulum J/(m eps^2)."""
    if group.body == "pendulum":
        return float(group.inertia or 0.0) / (mass * orbit**2)
    if group.body == "roller":
        return SOLID_CYLINDER * (1.0 + (float(group.inner_diameter or 0.0) / float(group.diameter or 1.0)) ** 2)
    return SOLID_BALL if group.motion == "rolling" else 0.0


def friction_of(group: Balls, race: Race, orbit: float) -> tuple[float, float]:
    """What brakes one body and what holds it at rest: torque over its normal force, per orbit radius.

    A pendulum has the friction of its bearing at the radius of that, all others that of the race.
    """
    if race.friction is None:
        return 0.0, 0.0
    arm = float(group.bearing_radius or 0.0) / orbit if group.body == "pendulum" else 1.0
    return arm * float(race.friction.rolling_resistance), arm * race.friction.holding


def _ball(group: Balls, ring: Bearing | None, stuff: float | None) -> tuple[float, float, float]:
    diameter = float(group.diameter) if group.diameter is not None else None
    if group.unsized and ring is not None:
        diameter = ring.ball_diameter
    if diameter is not None:
        volume = math.pi / 6.0 * diameter**3
        return float(group.mass) if group.mass is not None else (stuff or 0.0) * volume, diameter, volume
    mass = float(group.mass or 0.0)
    diameter = (6.0 * mass / (math.pi * stuff)) ** (1.0 / 3.0) if stuff else 0.0
    return mass, diameter, math.pi / 6.0 * diameter**3


# From the drag law of a race to the numbers of a ball in it.


TRIED = np.geomspace(1e-6, 1e7, 2001)  # Reynolds numbers


def ball_drag(
    part: Drag, radius: float, orbit: float, density: float, viscosity: float
) -> tuple[float, DragCurve | None]:
    """beta (N m s) of the linear law, and the curve over all Reynolds numbers where the law is asked for as a whole.

    ``radius`` of the ball and ``orbit`` radius in m; ``density`` and kinematic ``viscosity`` of the fluid in SI.

    Raises
    ------
    QuestionError
        If the law is no law for this ball: it fails, or its drag is not finite, negative, or falls as a ball becomes faster.
    """
    ball = BallInRace(radius, orbit)
    if not part.needs_fluid:
        return _torque(part, ball), None
    if radius == 0.0:
        return 0.0, None
    law = law_of(part, ball)
    beta = linear_drag(law.cd_times_re, density, viscosity, radius, orbit)
    return beta, None if isinstance(law, LinearLaw) else DragCurve(law, density, viscosity, 2.0 * radius)


def _torque(part: Drag, ball: BallInRace) -> float:
    try:
        torque = returned(lambda: float(part.torque(ball)), f"the drag law {part.word()!r}")
    except Exception as reason:  # whatever a law of somebody else may raise
        raise QuestionError(_failed(part, reason)) from None
    if not (math.isfinite(torque) and torque >= 0.0):
        raise QuestionError(f"the drag law {part.word()!r} gives a torque of {torque:g} N m s; it must not be negative")
    return torque


@lru_cache(maxsize=256)
def law_of(part: Drag, ball: BallInRace) -> DragLaw:
    """The law of a ball, tried over all Reynolds numbers."""
    try:
        law = returned(lambda: part.curve(ball), f"the drag law {part.word()!r}")
    except QuestionError as reason:
        raise QuestionError(str(reason).replace(repr(UNNAMED), repr(part.word()))) from None
    except Exception as reason:  # whatever a law of somebody else may raise
        raise QuestionError(_failed(part, reason)) from None
    if not isinstance(law, DragLaw):
        raise QuestionError(
            f"the drag law {part.word()!r} gives {law!r}; its 'curve' must return what ab.laws.sampled_drag_law or "
            "ab.laws.linear_drag_law makes"
        )
    if law.name == UNNAMED:
        law = replace(law, name=part.word())
    product = law.product(TRIED)
    wrong = np.flatnonzero(~(np.isfinite(product) & (product > 0.0)))
    if wrong.size:
        re, value = TRIED[wrong[0]], product[wrong[0]]
        raise QuestionError(
            f"the drag law {part.word()!r} gives c_d Re = {value:g} at Re = {re:.4g}; it must be positive"
        )
    falls = np.flatnonzero(np.diff(product * TRIED) <= 0.0)
    if falls.size:
        re = TRIED[falls[0]]
        raise QuestionError(
            f"the drag law {part.word()!r} gives less drag as a ball becomes faster, about Re = {re:.4g}"
        )
    return law


def _failed(part: Drag, reason: Exception) -> str:
    return f"the drag law {part.word()!r} fails: {type(reason).__name__}: {reason}"


# From the shear law of a fluid to its numbers at the temperature of the fluid, and to the drag on a ball in it.


VELOCITIES = np.geomspace(SLOWEST, FASTEST, 1201)  # m/s


def sheared(part: Fluid, viscosity: float) -> Sheared | None:
    """The shear law of a fluid that has this kinematic ``viscosity`` (m^2/s) at rest; None if it has none.

    Raises
    ------
    CatalogError
        If the fluid is not available at the temperature of the measurement.
    QuestionError
        If the law is no viscosity.
    """
    law = part.shear
    if law is None:
        return None
    _tried(law)
    if law.measured_at is None or part.name is None:
        return Sheared(law)
    here, there = float(part.temperature or ROOM), float(law.measured_at)
    return Sheared(law, viscosity / fluid(part.name, there).viscosity * there / here)


def sheared_curve(
    race: Race, radius: float, orbit: float, numbers: tuple[float, float], shear: Sheared
) -> ShearedDragCurve:
    """Drag on a ball; ``numbers`` are density and viscosity at rest, SI.

    Raises
    ------
    QuestionError
        If the drag falls as a ball becomes faster.
    """
    assert race.fluid is not None
    assert race.fluid.shear is not None
    law = law_of(race.drag, BallInRace(radius, orbit))
    curve = ShearedDragCurve(law, *numbers, 2.0 * radius, shear, float(race.fluid.shear.at_ball or 0.0))
    falls = np.flatnonzero(np.diff(curve.force(VELOCITIES)) <= 0.0)
    if falls.size:
        raise QuestionError(
            f"fluid.shear gives less drag as a ball becomes faster, about {VELOCITIES[falls[0]]:.3g} m/s"
        )
    return curve


@lru_cache(maxsize=64)
def _tried(law: ShearLaw) -> None:
    tried(law, law.word())


# Springs and dampers of a planar rotor from what an engineer measures: its critical speed and its damping ratio.


WORDS = tuple(f"rotor.{key}" for key in (*SPRINGS[1:], *DAMPERS[1:]))
"""Paths of entries from which springs and dampers follow."""


def planar_rotor(machine: Machine) -> PlanarRotor:
    """The planar rotor of a machine with its stiffness and damping.

    A critical speed means w_c = sqrt(k/M), where the mass M in motion has the effective masses of the balls; a damping ratio
    means D = b / (2 sqrt(k M)), and a half-power bandwidth 2 D w_c, which is exact for light damping. Rubber has the stiffness
    and damping of small motions here.
    """
    rotor = machine.rotor
    assert isinstance(rotor, PlanarRotor)
    if rotor.settled:
        return rotor
    mass = float(rotor.mass) + sum(ball.effective_mass for ball in resolve(machine))
    stiffness, damping = (pair[0] if pair[0] == pair[1] else pair for pair in rotor.springs(mass))
    planar_rotor = {
        "mass": rotor.mass,
        "stiffness": rotor.stiffness or stiffness,
        "damping": rotor.damping,
        "inertia": rotor.inertia,
        "hardening": rotor.hardening,
    }
    if rotor.damping is None:
        planar_rotor["damping"] = damping
    return PlanarRotor(**{key: value for key, value in planar_rotor.items() if value is not None})  # type: ignore[arg-type]


def settled(machine: Machine, path: str = "") -> Machine:
    """A machine whose planar rotor has stiffness and damping, so that they stay when something else is changed.

    It is left as it is where ``path`` names what they follow from, because then that is what is changed.
    """
    if path in WORDS or not isinstance(machine.rotor, PlanarRotor):
        return machine
    if machine.rotor.settled or machine.rotor.rubber is not None:
        return machine
    return Machine(
        **{**{key: getattr(machine, key) for key in machine.model_fields_set}, "rotor": planar_rotor(machine)}
    )


# From the rings of liquid of a machine to their numbers.


def rings_of(machine: Machine) -> tuple[Ring, ...]:
    """The rings of a machine.

    Raises
    ------
    MachineError
        If a fluid is unknown, or a mass of liquid does not fit into its ring.
    """
    return tuple(_ring(part, number) for number, part in enumerate(machine.liquid_rings))


def _ring(part: LiquidRing, number: int) -> Ring:
    where = ("liquid_rings", number)
    try:
        density, _ = fluid_numbers(part.fluid)
    except CatalogError as error:
        raise MachineError.of("Machine", [((*where, "fluid", "name"), str(error))]) from None
    radius, height = float(part.radius), float(part.height)
    width = math.inf if part.width is None else float(part.width)
    if part.layer is not None:
        return Ring(radius, height, float(part.layer), density, width)
    liquid = float(part.liquid or 0.0)
    inner = max(radius - width, 0.0)
    most = math.pi * density * height * (radius**2 - inner**2)
    if liquid >= most:
        text = f"given {liquid:.4g} kg, but the ring holds {most:.4g} kg; must be less, because only a free surface balances"
        raise MachineError.of("Machine", [((*where, "liquid"), text)])
    surface = math.sqrt(radius**2 - liquid / (math.pi * density * height))
    return Ring(radius, height, radius - surface, density, width)


# What the balls of a race can balance at most: side by side, as they really can stand; kg m.


def race_capability(balls: list[Ball]) -> float:
    """Resultant of the balls of one race side by side, kg m; the best place for the gap in the row is taken.

    Of equal balls it is :func:`autobalancer.laws.capabilities.capability`; balls of unknown size are points. It holds for
    balls that a model lets pass through each other as well.
    """
    best = 0.0
    for first in range(len(balls)):
        row = balls[first:] + balls[:first]
        angle, total = 0.0, 0j
        for ball, after in zip(row, [*row[1:], row[0]], strict=True):
            total += cmath.rect(ball.moment, angle)
            angle += 0.5 * occupied_angle([ball, after])
        best = max(best, abs(total))
    return best


def capability_of(balls: Iterable[Ball]) -> float:
    """Sum over the races, kg m: each race adds its own, in the same direction."""
    races: dict[Hashable, list[Ball]] = {}
    for ball in balls:
        races.setdefault((ball.balancer, ball.race), []).append(ball)
    return sum(race_capability(row) for row in races.values())


# Sizes that are possible, but so odd beside each other that a unit may be wrong.


HIGH = 20.0  # height of a chamber over the diameter of its largest ball
NARROW, WIDE = 1e-3, 100.0  # clear width over ball radius


def odd_sizes(machine: Machine, balls: tuple[Ball, ...]) -> tuple[str, ...]:
    """Sentences about odd sizes, for ``check``."""
    odd_sizes = []
    for b, balancer in enumerate(machine.balancers):
        for r, race in enumerate(balancer.races):
            largest = max((ball.diameter for ball in balls if (ball.balancer, ball.race) == (b, r)), default=0.0)
            place = f"balancers[{b + 1}].races[{r + 1}]"
            if race.height is not None and 0.0 < largest * HIGH < race.height:
                odd_sizes.append(_odd(f"{place}.height", race.height, largest))
            drag = race.drag
            if isinstance(drag, AnnulusDrag) and not NARROW < 2.0 * drag.clear_width / max(largest, 1e-12) < WIDE:
                odd_sizes.append(_odd(f"{place}.drag.clear_width", drag.clear_width, largest))
    return tuple(odd_sizes)


def _odd(place: str, size: float, ball: float) -> str:
    return f"{place} is {1e3 * size:.4g} mm beside balls of {1e3 * ball:.4g} mm; is its unit right?"
