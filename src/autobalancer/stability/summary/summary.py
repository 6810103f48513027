"""What is known of a machine before a run."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from autobalancer.assembly.bearings.hardening import off_middle
from autobalancer.assembly.changed_parts import changed_part
from autobalancer.assembly.off_center import OffCenter, off_center
from autobalancer.assembly.places import places_of
from autobalancer.assembly.profile import highest_prescribed, largest_unbalance
from autobalancer.assembly.system import assemble
from autobalancer.assembly.terms import Theory, ignores, weightless
from autobalancer.catalog.odd_sizes import odd_sizes
from autobalancer.catalog.race_capability import race_capability
from autobalancer.catalog.resolve import Ball, occupied_angle, resolve
from autobalancer.catalog.resolve_rings import rings_of
from autobalancer.catalog.resolve_springs import planar_rotor
from autobalancer.errors import QuestionError
from autobalancer.files.given import balls_in_races
from autobalancer.machine import Machine, PlanarRotor
from autobalancer.patience import OutOfTime, question
from autobalancer.results.number_text import moment_text
from autobalancer.shown import Described, rpm_and_si
from autobalancer.simulation.fluid_lag import diffusing_lags
from autobalancer.simulation.remarks.input_text import input_notes
from autobalancer.stability.friction.held import held_by_friction
from autobalancer.stability.friction.held_values import HeldByFriction
from autobalancer.stability.maps.speeds import BUDGET, NOT_FOUND, Border, borders_of
from autobalancer.stability.states.described import described
from autobalancer.stability.summary.rotor import StationSummary, frame_of, rubber_texts
from autobalancer.stability.summary.rows import SpeedText, summary_rows
from autobalancer.stability.summary.service import Service, service_of

ABOVE = 1.05  # of the highest border speed: where balls that settle are held least
SMALL = 0.01  # share of the own inertia of a pendulum below which nobody needs to know of it


@dataclass(frozen=True)
class RaceSummary:
    """One race with its balls, SI."""

    balancer: int
    race: int
    balls: int
    ball_mass: float
    effective_mass: float
    occupied_angle: float
    capability: float
    drag: tuple[float, ...]
    bodies: str = "ball"  # what they are
    ignores: str = ""  # what its capability does not know


@dataclass(frozen=True, repr=False)
class Summary(Described):
    """Masses, critical speeds, capability, drag, S, border speeds, and what looks wrong. SI."""

    name: str
    axis: str
    rotor_mass: float
    ball_mass: float
    total_mass: float
    critical_speeds: tuple[float, ...]
    damping_ratios: tuple[float, ...]
    unbalance: float
    unbalance_varies: bool
    races: tuple[RaceSummary, ...]
    capability: float
    sommerfeld_number: float
    borders: tuple[Border, ...]
    no_borders_because: str
    highest_speed: float | None
    warnings: tuple[str, ...]
    rotor: str = "planar"
    stations: tuple[StationSummary, ...] = ()
    service: Service | None = None  # None where the drive names no speed, or without unbalance
    friction: HeldByFriction | None = None  # None without balls, or where nothing is known of it
    friction_settled: HeldByFriction | None = None  # just above all borders, if the machine runs faster
    several_unbalances: bool = False
    rubber: tuple[str, ...] = ()  # how soft each piece of softening rubber becomes, and what the other rows count with
    liquid_rings: tuple[str, ...] = ()  # what they hold; all other rows are those of the rotor without liquid
    off_center: OffCenter | None = None  # what races off the axis leave; None without balls

    def rows(self, said: SpeedText = rpm_and_si) -> list[tuple[str, str]]:
        """A name and a text each, with speeds as ``said`` writes them."""
        return summary_rows(self, said)

    def as_dict(self) -> dict[str, Any]:
        """Plain numbers and texts, e.g. for JSON."""
        held = {name: getattr(self, name) for name in ("friction", "friction_settled")}
        return {**asdict(self), **{name: one.as_dict() if one is not None else None for name, one in held.items()}}


def summary(
    machine: Machine | str | Path, say: Callable[[str], None] | None = None, seconds: float = BUDGET
) -> Summary:
    """What is known of a machine before a run.

    Critical speeds are undamped and with the balls on the rotor: sqrt(k/M) along x and y, or of a rotor that tilts or
    bends the lowest ones that an unbalance excites. For these ``unbalance`` is the resultant of the point unbalances, and
    ``stations`` gives what each plane has to balance, including couples. Borders and friction have some ``seconds`` of computing
    each; what is not found by then says so. ``say`` is told what takes over a second.

    Raises
    ------
    MachineError
        If the machine is not possible as described.
    """
    machine = balls_in_races(machine, rings=True)
    if machine.liquid_rings:
        return replace(summary(changed_part(machine, liquid_rings=()), say, seconds), liquid_rings=_rings(machine))
    balls = resolve(machine)
    assembly = assemble(machine, lags=diffusing_lags(machine))  # refuses what a run would refuse
    places = sorted({(ball.balancer, ball.race) for ball in balls})
    races = tuple(
        _race([ball for ball in balls if (ball.balancer, ball.race) == place], ignores(machine, Theory.CAPABILITY))
        for place in places
    )
    unbalance, capability = abs(largest_unbalance(machine)), sum(race.capability for race in races)
    highest = highest_prescribed(machine)
    with question("the critical speeds", math.inf, say):
        frame = frame_of(machine, highest)
    critical = frame.critical_speeds
    found: tuple[Border, ...] = ()
    reason = ""
    try:
        found = borders_of(machine, described(weightless(machine), None), seconds=seconds, say=say)
    except QuestionError as error:
        reason = str(error)
    service = highest or 3.0 * max(critical, default=0.0)

    def held(speed: float | None) -> HeldByFriction:
        try:
            with question("what friction holds", seconds, say):
                return held_by_friction(machine, speed)
        except OutOfTime:
            note = NOT_FOUND.format(seconds, "ab.stability.held_by_friction")
            return HeldByFriction(speed or service, 0, (), note)

    friction = held(None) if balls else None
    service = friction.speed if friction is not None else service
    return Summary(
        name=machine.name,
        axis=machine.axis,
        rotor_mass=frame.rotor_mass,
        ball_mass=sum(ball.mass for ball in balls),
        total_mass=frame.total_mass,
        critical_speeds=critical,
        damping_ratios=frame.damping_ratios,
        unbalance=unbalance,
        rubber=rubber_texts(machine),
        several_unbalances=len(machine.unbalances) > 1 or any(part.is_couple for part in machine.unbalances),
        unbalance_varies=any(part.schedule is not None for part in machine.unbalances),
        races=races,
        capability=capability,
        sommerfeld_number=_sommerfeld_number(machine, balls, frame.total_mass),
        borders=found,
        no_borders_because=reason,
        highest_speed=highest,
        warnings=input_notes(machine, None if machine.run is None else float(machine.run.duration))
        + _gravity_note(machine)
        + _pendulum_note(machine, balls)
        + _warnings(
            unbalance, capability, critical, highest, found, bool(balls), isinstance(machine.rotor, PlanarRotor)
        )
        + _short(frame.stations)
        + odd_sizes(machine, balls),
        rotor=machine.rotor.kind,
        stations=frame.stations,
        service=service_of(machine, assembly, highest),
        friction=friction,
        friction_settled=_settled(held, friction, found, critical),
        off_center=off_center(places_of(machine, assembly), balls, service),
    )


def _settled(
    held_at: Callable[[float], HeldByFriction],
    held: HeldByFriction | None,
    borders: tuple[Border, ...],
    critical: tuple[float, ...],
) -> HeldByFriction | None:
    """What friction holds a little above the exact border and the release speed; None where the machine is not faster."""
    if held is None or not held.planes:
        return None
    decisive = {border.name: border.speed for border in borders if border.name in ("exact border", "release speed")}
    known = [speed for speed in decisive.values() if not math.isnan(speed)]
    if not known or not all(math.isfinite(speed) for speed in known):
        return None
    reached = [speed for speed in critical if speed < held.speed]
    at = ABOVE * max(*known, *reached)
    return held_at(at) if at < held.speed else None


def _rings(machine: Machine) -> tuple[str, ...]:
    held = [
        f"{ring.mass:.4g} kg of liquid in a layer of {1e3 * ring.layer:.4g} mm; moves with the rotor like {ring.full_mass:.4g} kg"
        for ring in rings_of(machine)
    ]
    return (*held, "all other rows are those without liquid; see autobalancer liquid-response")


def _short(planes: tuple[StationSummary, ...]) -> tuple[str, ...]:
    return tuple(
        f"the balls at {plane.name!r} can balance {moment_text(plane.capability, 4)} of the {moment_text(plane.required, 4)} "
        f"that this plane needs at {plane.speed:.4g} rad/s; take more or heavier balls there"
        for plane in planes
        if plane.required > plane.capability
    )


def _sommerfeld_number(machine: Machine, balls: tuple[Ball, ...], mass: float) -> float:
    """S = (m eps w_c)^2 / (b beta) of equal balls on a planar rotor with isotropic supports; nan for others."""
    kinds = {(ball.moment, ball.drag) for ball in balls}
    rotor = machine.rotor
    if len(kinds) != 1 or not isinstance(rotor, PlanarRotor) or not rotor.isotropic or off_middle(machine):
        return math.nan
    springs = planar_rotor(machine)
    (moment, drag), damping = kinds.pop(), springs.damping_xy[0]
    if damping * drag == 0.0:
        return math.inf
    return moment**2 * springs.stiffness_xy[0] / mass / (damping * drag)


def _race(balls: list[Ball], ignored: str) -> RaceSummary:
    return RaceSummary(
        balancer=balls[0].balancer + 1,
        race=balls[0].race + 1,
        balls=len(balls),
        ball_mass=sum(ball.mass for ball in balls),
        effective_mass=sum(ball.effective_mass for ball in balls),
        occupied_angle=occupied_angle(balls),
        capability=race_capability(balls),
        drag=tuple(sorted({ball.drag for ball in balls})),
        ignores=ignored,
        bodies=balls[0].body if len({ball.body for ball in balls}) == 1 else "ball",
    )


def _pendulum_note(machine: Machine, balls: tuple[Ball, ...]) -> tuple[str, ...]:
    """That the own inertia of pendulums is left out where it counts."""
    share = max((ball.spin_ratio for ball in balls if ball.body == "pendulum"), default=0.0)
    if machine.tilting_races != "full" or share < SMALL:
        return ()
    return (
        f"the inertia of a pendulum about its own center is {share:.2g} of m eps^2; it turns with the pendulum but is left out "
        "where the race tilts (tilting_races = 'full')",
    )


def _gravity_note(machine: Machine) -> tuple[str, ...]:
    """That weight acts on balls in tilting races, which nobody wrote down."""
    if machine.tilting_races != "full" or machine.axis != "vertical" or machine.gravity == 0.0 or not machine.balancers:
        return ()
    return (
        f"gravity of {float(machine.gravity):g} m/s^2 acts along the axis, as tilting_races = 'full' has it: a race "
        "that tilts drives its balls downhill; gravity = 0 leaves it out",
    )


def _warnings(
    unbalance: float,
    capability: float,
    critical: tuple[float, ...],
    highest: float | None,
    borders: tuple[Border, ...],
    has_balls: bool,
    planar: bool,
) -> tuple[str, ...]:
    found = []
    if has_balls and unbalance > capability:
        found.append(
            f"the balls can balance {moment_text(capability, 4)} of {moment_text(unbalance, 4)}; take more or heavier balls"
        )
    if has_balls and highest is not None and highest < min(critical, default=0.0):
        found.append("the highest speed is below the critical speed; there the balls gather on the heavy side")
    elif has_balls and highest is not None and planar and highest < max(critical, default=0.0):
        found.append("the highest speed is below a critical speed; there the balls gather on the heavy side")
    exact = [border.speed for border in borders if border.name == "exact border"]
    windows = any("stable also" in border.note for border in borders if border.name == "exact border")
    if (
        highest is not None
        and exact
        and highest > (max if planar else min)(critical, default=0.0)
        and exact[0] >= highest
    ):
        found.append(
            "the highest speed is below the exact border; "
            + ("there the balanced state is stable only in the ranges that the note of this border names" if windows
               else "the balanced state is not stable there; "
               f"{'take a thicker fluid' if planar else 'see the note on this border'}")
        )  # fmt: skip
    release = [border.speed for border in borders if border.name == "release speed"]
    if (
        highest is not None
        and release
        and highest > (max if planar else min)(critical, default=0.0)
        and release[0] > highest
    ):
        found.append(
            "the highest speed is below the release speed: balls that stall at a resonance in a slow run-up stay there"
        )
    return tuple(found)
