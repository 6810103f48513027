"""From words to numbers: materials and fluids looked up, sizes and masses worked out, fit checked."""

from __future__ import annotations

import math
from dataclasses import dataclass

from autobalancer.catalog.bearing_table import Bearing
from autobalancer.catalog.bearing_table import bearing as find_bearing
from autobalancer.catalog.fluid_table import fluid
from autobalancer.catalog.resolve_bodies import friction_of, size_of, spin_ratio_of
from autobalancer.catalog.resolve_drag import ball_drag
from autobalancer.catalog.resolve_shear import sheared, sheared_curve
from autobalancer.errors import CatalogError, QuestionError
from autobalancer.laws.drag_curve import DragCurve
from autobalancer.laws.liquid.sheared_drag import Sheared
from autobalancer.machine import Fluid, Machine, Race
from autobalancer.machine.part import ImpossiblePart, Problem
from autobalancer.remembered import remembered


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
    ImpossiblePart
        If a name is unknown, a ball does not fit, floats, or there are more balls than fit.
    """
    balls: list[Ball] = []
    problems: list[Problem] = []
    for b, balancer in enumerate(machine.balancers):
        for r, race in enumerate(balancer.races):
            found: list[Problem] = []
            balls += _race(race, b, r, found)
            problems += [(("balancers", b, "races", r, *keys), message) for keys, message in found]
    if problems:
        raise ImpossiblePart("Machine", problems)
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
        keys = ("balls", g)
        try:
            mass, diameter, volume = size_of(group, ring)
        except CatalogError as error:
            problems.append(((*keys, "material"), str(error)))
            return []
        radius = 0.5 * diameter
        if race.race_radius is not None and diameter == 0.0:
            problems.append((keys, "a ball on a race given by 'race_radius' needs a size; give 'diameter'"))
            return []
        if ring is not None and race.race_radius is None and diameter > ring.ball_diameter * (1.0 + 1e-9):
            problems.append((keys, _too_large(diameter, ring)))
            return []
        orbit = _orbit(race, ring, radius)
        if orbit <= radius:
            problems.append(
                (
                    keys,
                    f"a {group.body} of {_mm(diameter)} is larger than an orbit of {_mm(max(orbit, 0.0))} radius allows",
                )
            )
            return []
        along = float(group.length or 0.0) if group.body == "roller" else diameter
        for key, room, size in (("width", race.width, diameter), ("height", race.height, along)):
            if room is not None and size > room:
                problems.append(
                    (keys, f"a {group.body} of {_mm(size)} does not fit into a chamber of {key} {_mm(room)}")
                )
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
        if race.drag.needs_fluid and diameter == 0.0:
            problems.append((keys, f"the drag law {race.drag.word()!r} needs the size of the balls; give 'diameter'"))
        if race.slipstream and diameter == 0.0:
            problems.append((("slipstream",), "needs the size of the balls; give 'diameter', or leave it out"))
        try:
            beta, curve = ball_drag(race.drag, radius, orbit, density, viscosity)
            if shear is not None and diameter:
                curve = sheared_curve(race, radius, orbit, (density, viscosity), shear)
        except QuestionError as error:
            problems.append((("drag",), str(error)))
            return []
        rolling, adherence = friction_of(group, race, orbit)
        for i in range(group.count):
            balls.append(
                Ball(
                    balancer=balancer,
                    race=number,
                    mass=mass,
                    diameter=diameter,
                    volume=volume,
                    displaced=displaced,
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
                )
            )
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
    for i, one in enumerate(() if race.coincidence else given):
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
    return balls


def occupied_angle(balls: list[Ball]) -> float:
    """Angle that the balls of one race take when they touch, in their order around the race, rad."""
    if len(balls) == 1:
        return 2.0 * math.asin(min(balls[0].radius / balls[0].orbit_radius, 1.0))
    total = 0.0
    for one, other in zip(balls, balls[1:] + balls[:1], strict=True):
        reach, apart = one.radius + other.radius, one.orbit_radius - other.orbit_radius
        share = (reach**2 - apart**2) / (4.0 * one.orbit_radius * other.orbit_radius)  # squared sine of half the angle
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
