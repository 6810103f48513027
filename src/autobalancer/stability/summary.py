"""What is known of a machine before a run."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from autobalancer.assembly.drive_train import highest_prescribed, largest_unbalance, unbalance_vector
from autobalancer.assembly.places import (
    OffCenter,
    gauges_of,
    off_center,
    places_of,
    plane_unbalances,
    turning_mass,
    without_balancing,
)
from autobalancer.assembly.quantities import changed_part
from autobalancer.assembly.reduced_rotor import rubbers
from autobalancer.assembly.rotors import lateral_model
from autobalancer.assembly.rotors.equivalent_stiffness import hardenings
from autobalancer.assembly.system import Assembly, assemble, total_mass
from autobalancer.assembly.terms import Theory, ignores, weightless
from autobalancer.catalog.resolve import (
    Ball,
    occupied_angle,
    odd_sizes,
    planar_rotor,
    race_capability,
    resolve,
    rings_of,
)
from autobalancer.errors import ENSEMBLE, LEAST_DRAG, LIQUID, MORE_MODES, SIMULATE, QuestionError
from autobalancer.files.machine_file import balls_in_races
from autobalancer.kernels.measures.thresholds import LIMITS
from autobalancer.kernels.measures.workspace import MeasureInputs
from autobalancer.laws.capabilities import balance_grade, grade_name
from autobalancer.machine import Machine
from autobalancer.progress import OutOfTime, question
from autobalancer.results.display_units import force_text, length_text, moment_text, significant, velocity_text
from autobalancer.simulation.fluid_lag import diffusing_lags
from autobalancer.simulation.remarks import input_notes
from autobalancer.stability.border import Border
from autobalancer.stability.friction import OF_RELEASED, HeldByFriction, held_by_friction
from autobalancer.stability.host.stations import (
    Stations,
    damping_ratio,
    is_planar,
    loads_at_corners,
    stations,
    without_forces,
)
from autobalancer.stability.maps.exact import BUDGET, NOT_FOUND, borders_of, smaller_noted
from autobalancer.stability.states.rest_states import described, required, service_speed
from autobalancer.tables import Described, rpm_and_si

# Masses, critical speeds and damping of the rotor in a machine, whatever its kind; and what each station has to
# balance.


SHARED = "; more planes than needed can share it in other ways, too"
SHOWN = 6  # critical speeds of a rotor that tilts or bends
FROM_A_RUN = (
    "a torque drives: known from a run only, and so is what unbalance does there without balls"  # the highest speed
)


@dataclass(frozen=True)
class StationSummary:
    """A plane of balancers: what its balls can balance, and what they have to so that all stations are at rest, kg m.

    ``required`` is the greatest over time of what this station needs, where unbalances change by a schedule; stations may
    need their greatest at different times. ``speed`` (rad/s) is that for which ``required`` holds; on a rigid rotor with
    two planes it holds for any. ``shared``: there are more planes than the rotor has coordinates, so that it can be shared by
    them in many ways; it is that of the way that takes the least share of the capabilities.
    """

    name: str
    capability: float
    required: float
    speed: float
    shared: bool = False


@dataclass(frozen=True)
class Frame:
    """Rotor and supports as a whole, SI."""

    rotor_mass: float
    total_mass: float
    critical_speeds: tuple[float, ...]  # undamped, with the balls on the rotor; a planar rotor: along x, y
    damping_ratios: tuple[float, ...]
    stations: tuple[StationSummary, ...] = ()


def frame_of(machine: Machine, highest: float | None) -> Frame:
    """The frame of a machine; ``highest`` is the speed for which its stations are asked."""
    if not is_planar(machine):
        return _spatial(machine, highest)
    mass = total_mass(machine, resolve(machine))
    model = lateral_model(machine)
    stiffness, damping = model.stiffness[0], model.damping[0]
    if stiffness[0, 1] != 0.0:  # it rests in its bearing between x and y
        axes = np.linalg.eigh(stiffness)[1]
        stiffness, damping = axes.T @ stiffness @ axes, axes.T @ damping @ axes
    pairs = list(zip(np.diag(stiffness).tolist(), np.diag(damping).tolist(), strict=True))
    if pairs[0] == pairs[1]:
        pairs = pairs[:1]
    return Frame(
        model.total_mass,
        mass,
        tuple(math.sqrt(k / mass) for k, _ in pairs),
        tuple(b / (2.0 * math.sqrt(k * mass)) for k, b in pairs),
    )


def rubber_texts(machine: Machine) -> tuple[str, ...]:
    """How soft each piece of softening rubber becomes, and what is counted with it; empty without any."""
    result = []
    for name, rubber in rubbers(machine):
        stiff, soft = (significant(1e-3 * one) for one in (rubber.initial_stiffness, float(rubber.stiffness)))
        result.append(f"{name}: {stiff} kN/m in small motions, {soft} kN/m in the largest, when all elements slide")
    if not result:
        return ()
    what = "critical speeds, borders and what friction holds are those of small motions"
    return (*result, f"{what}; release, capture and vibration without balancing know how far it moves")


def _spatial(machine: Machine, highest: float | None) -> Frame:
    guided = weightless(without_forces(machine)).model_copy(update={"tilting_races": "deflection"})
    st = stations(guided, largest=True)
    speeds = st.critical_speeds[:SHOWN]
    return Frame(
        lateral_model(machine).total_mass,
        st.model.total_mass,
        speeds,
        tuple(damping_ratio(st.model, speed) for speed in speeds),
        _needs(guided, st, highest),
    )


def _needs(machine: Machine, st: Stations, highest: float | None) -> tuple[StationSummary, ...]:
    if st.moment.size == 0:
        return ()
    speed = service_speed(st, highest)
    try:
        loads = [load for load, _ in loads_at_corners(machine, st.model)]
        needed = np.max([np.abs(required(replace(st, load=load), speed)) for load in loads], axis=0)
    except QuestionError:  # a critical speed of an undamped rotor
        needed = np.full(len(st.names), math.nan)
    shared = bool(np.linalg.matrix_rank(st.rows) < len(st.names))
    return tuple(
        StationSummary(name, float(have), float(need), float(speed), shared)
        for name, have, need in zip(st.names, st.capability, needed, strict=True)
    )


# What the rotor does at its service speed without balancing: the state of things before balls do anything.


LATE = 1e300  # a time after all schedules, s


@dataclass(frozen=True)
class Service:
    """At the highest speed of the drive, steady, with the balls spread evenly and held, after all schedules; SI.

    ``grade`` is G of ISO 21940-11, U W/M in mm/s, with the ``unbalance`` U (kg m) of the rotor in its
    plane; of several planes (``added_up``) with the sum of what each of them has to balance. ``vibration`` is the greatest at
    each place, ``force`` that on each support; empty where the machine is shaken from outside.
    """

    speed: float
    unbalance: float
    added_up: bool
    grade: float
    vibration: tuple[tuple[str, float], ...]
    force: tuple[tuple[str, float], ...]
    ignores: str = ""


def service_of(machine: Machine, assembly: Assembly, highest: float | None) -> Service | None:
    """The service of a machine; None where its drive does not say how fast it runs, or it has no unbalance."""
    if highest is None or not highest > 0.0:
        return None
    places = places_of(machine, assembly)
    gauges = gauges_of(assembly, places, centered=True)
    unbalance, several = _service_unbalance(machine, assembly, gauges, highest), len(places.planes) > 1
    if not (math.isfinite(unbalance) and unbalance > 0.0):
        return None
    grade = balance_grade(unbalance, turning_mass(places), highest)
    if machine.excitations:
        return Service(highest, unbalance, several, grade, (), ())
    vibration, force = (result.tolist() for result in without_balancing(assembly, places, gauges, LATE, highest))
    return Service(
        highest,
        unbalance,
        several,
        grade,
        tuple(zip(places.names, vibration, strict=True)),
        tuple(zip(places.supports, force, strict=True)),
        ignores(machine, Theory.ROTOR),
    )


def _service_unbalance(machine: Machine, assembly: Assembly, gauges: MeasureInputs, speed: float) -> float:
    if gauges.capability.size > 1:
        return float(np.abs(plane_unbalances(assembly, gauges, LATE, speed)).sum())
    return abs(unbalance_vector(machine, np.inf))


# What is known of a machine before a run.


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
    rotor_source: str = (
        ""  # of a rotor of matrices: their files, and how few coordinates stand for them up to which frequency
    )
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
        parts = {name: one.as_dict() if one is not None else None for name, one in held.items()}
        return {"balances": answer_of(self, rpm_and_si), **asdict(self), **parts}


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
    # what the machine has: a run that would be refused is refused here
    balls = resolve(machine)
    assembly = assemble(machine, lags=diffusing_lags(machine))  # refuses what a run would refuse
    places = sorted({(ball.balancer, ball.race) for ball in balls})
    races = tuple(
        _race([ball for ball in balls if (ball.balancer, ball.race) == place], ignores(machine, Theory.CAPABILITY))
        for place in places
    )
    # what it has to balance, and can
    unbalance, capability = abs(largest_unbalance(machine)), sum(race.capability for race in races)
    highest = highest_prescribed(machine)
    with question("the critical speeds", math.inf, say):
        frame = frame_of(machine, highest)
    critical = frame.critical_speeds
    # the border speeds, or why there are none
    borders: tuple[Border, ...] = ()
    reason = ""
    try:
        borders = smaller_noted(borders_of(machine, described(weightless(machine), None), seconds=seconds, say=say))
    except QuestionError as error:
        reason = str(error)
    # what friction holds at its service speed
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
        borders=borders,
        no_borders_because=reason,
        highest_speed=highest,
        warnings=input_notes(machine, None if machine.run is None else float(machine.run.duration))
        + _gravity_note(machine)
        + _pendulum_note(machine, balls)
        + _warnings(unbalance, capability, critical, highest, borders, bool(balls), is_planar(machine))
        + _short(frame.stations)
        + odd_sizes(machine, balls),
        rotor=machine.rotor.kind,
        rotor_source=getattr(machine.rotor, "source", ""),
        stations=frame.stations,
        service=service_of(machine, assembly, highest),
        friction=friction,
        friction_settled=_settled(held, friction, borders, critical),
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
    return (*held, f"all other rows are those without liquid{LIQUID}")


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
    # where a rotor rests beside the middle of a bearing that becomes stiffer, directions differ
    if len(kinds) != 1 or not is_planar(machine) or any(one.center != (0.0, 0.0) for *_, one in hardenings(machine)):
        return math.nan
    springs = planar_rotor(machine)
    if not springs.isotropic:
        return math.nan
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
    warnings = []
    if has_balls and unbalance > capability:
        warnings.append(
            f"the balls can balance {moment_text(capability, 4)} of {moment_text(unbalance, 4)}; take more or heavier balls"
        )
    if has_balls and highest is not None and highest < min(critical, default=0.0):
        warnings.append("the highest speed is below the critical speed; there the balls gather on the heavy side")
    elif has_balls and highest is not None and planar and highest < max(critical, default=0.0):
        warnings.append("the highest speed is below a critical speed; there the balls gather on the heavy side")
    exact = next((border for border in borders if border.name == "exact border"), None)
    if highest is None or highest <= (max if planar else min)(critical, default=0.0):
        return tuple(warnings)
    if exact is not None and exact.speed >= highest:
        warnings.append(_below(exact, highest, planar))
    release = [border.speed for border in borders if border.name == "release speed"]
    if release and release[0] > highest:
        warnings.append(
            "the highest speed is below the release speed: balls that stall at a resonance in a slow run-up stay there"
        )
    return tuple(warnings)


def _below(exact: Border, highest: float, planar: bool) -> str:
    """What it means that the highest speed is below the exact border."""
    if exact.best < highest:
        everywhere = "never" if math.isinf(exact.speed) else f"from {exact.speed:.4g} rad/s on"
        return (
            f"the balanced state is stable at the highest speed at some positions of the balls only: at the best ones from "
            f"{exact.best:.4g} rad/s on, at all of them {everywhere}; {ENSEMBLE} shows how often the balls find "
            f"stable ones; more drag, as of a thicker fluid, may make all of them stable{LEAST_DRAG}"
        )
    below = "the highest speed is below the exact border; "
    if exact.windows:
        return f"{below}there the balanced state is stable only in the ranges that the note of this border names"
    nowhere = " at any position of the balls" if not math.isnan(exact.best) else ""
    return (
        f"{below}the balanced state is not stable there{nowhere}; "
        f"{'take a thicker fluid' if planar else 'see the note on this border'}"
    )


# What is known of a machine, as rows of a table: a name and a text each, with speeds as ``said`` writes them.


LISTED = 4  # critical speeds that are shown
Row = tuple[str, str]
SpeedText = Callable[[float], str]


def summary_rows(summary: Summary, said: SpeedText) -> list[Row]:
    """Everything that ``check`` shows of a machine with races."""
    answer = answer_of(summary, said)
    return [
        *([("balances", answer)] if answer else []),
        ("axis", summary.axis),
        *([("rotor", f"{summary.rotor}: {summary.rotor_source}")] if summary.rotor_source else []),
        ("mass", f"{summary.total_mass:.6g} kg with balls, {summary.rotor_mass:.6g} kg without"),
        *_critical_speeds(summary, said),
        *([("rubber", "\n".join(summary.rubber))] if summary.rubber else []),
        *_unbalance(summary, said),
        *(_race_rows(race, summary) for race in summary.races),
        *([("rings of liquid", "\n".join(summary.liquid_rings))] if summary.liquid_rings else []),
        *_together(summary),
        *_planes(summary, said),
        *(friction_rows(summary.friction, said) if summary.friction is not None else ()),
        *(_settled_rows(summary.friction_settled, said) if summary.friction_settled is not None else ()),
        *_eccentricity(summary),
        *_borders(summary, said),
        ("highest speed", FROM_A_RUN if summary.highest_speed is None else said(summary.highest_speed)),
    ]


def answer_of(summary: Summary, said: SpeedText) -> str:
    """Whether the balls balance the rotor at its highest speed, what decides it, and what to change; empty without balls."""
    if not summary.races:
        return ""
    top, borders = summary.highest_speed, {border.name: border for border in summary.borders}
    exact, release = borders.get("exact border"), borders.get("release speed")
    # in the order in which things can fail: capability, border, speed of the drive, stall, friction
    needs = [(plane.capability, plane.required) for plane in summary.stations]
    for have, need in needs or [(summary.capability, summary.unbalance)]:
        if need - have > LIMITS[0] * need:  # a rotor with less is balanced by the rule of the verdict
            return f"only in part: the balls can balance {moment_text(have)} of {moment_text(need)}; take more or heavier balls"
    if exact is None or math.isnan(exact.speed):
        why = summary.no_borders_because or (exact.note if exact is not None else "no exact border")
        return f"not known before a run ({why}); {SIMULATE}"
    inside = top is not None and any(low < top < high for low, high in exact.windows)
    since = f"from {said(exact.speed)} on"
    if inside or math.isinf(exact.speed):
        since = f"{exact.ranges(said)} only" if exact.windows else exact.text(said)
    elif exact.windows:
        since = f"{exact.ranges(said)}, and {since}"
    stable = "the balanced state is never stable" if since == "never" else f"the balanced state is stable {since}"
    slow = ""
    if release is not None and not math.isnan(release.speed):
        when = f"are released at {said(release.speed)}" if math.isfinite(release.speed) else "are never released"
        slow = f", stalled balls {when}"
    if top is None:
        return f"if the drive gets there: {stable}{slow}; {SIMULATE}"
    at = f"at {said(top)}"
    lowest = (max if summary.rotor == "planar" else min)(summary.critical_speeds, default=0.0)
    if top < lowest:
        return f"no, not {at}: below the critical speed {said(lowest)} balls go to the heavy side; run above it"
    thicker = f"more drag, as of a thicker fluid, may help{LEAST_DRAG}"
    # several positions of the balls balance, and they are not stable from the same speed on
    if exact.best < top <= exact.speed:
        always = "at none" if math.isinf(exact.speed) else f"from {said(exact.speed)} on"
        return (
            f"{at} at some positions of the balls: at the best ones from {said(exact.best)} on, at all of them {always}; "
            f"{ENSEMBLE} shows how often; {thicker}"
        )
    if top <= exact.speed and not inside:
        cure = "run faster, or " if math.isfinite(exact.speed) else "run there, or " if exact.windows else ""
        return f"no, not {at}: {stable}; {cure}{thicker}"
    if release is not None and release.speed >= top:
        when = "never" if math.isinf(release.speed) else f"at {said(release.speed)} only"
        return f"{at} yes, but not after a slow run-up: balls that stall are released {when}; {thicker}, a faster run-up, too"
    held = summary.friction.planes if summary.friction is not None else ()
    if any(plane.holds for plane in held):
        moved = any(plane.largest_whirl > plane.held_whirl for plane in held if plane.holds)
        where = f"where the passage of the critical speed left them; {SIMULATE}" if moved else "where they are"
        word = "not known before a run" if moved else "no, not"
        return f"{word} {at}: friction holds the balls {where}; less friction helps"
    left = ", ".join(moment_text(plane.residual_95) for plane in held if plane.held_whirl > 0.0)
    kept = f"; friction leaves up to {left} {OF_RELEASED}" if left else ""
    share, surely, reasons = _left_over(summary, [need for _, need in needs] or [summary.unbalance])
    if share > LIMITS[0]:  # the rule of the verdict, for the vibration that is in proportion to what is left
        word = "only in part," if share <= LIMITS[1] else "no, not" if surely else "not surely,"
        return f"{word} {at}: {'; '.join(reasons)}; {stable}{slow}"
    return f"yes, {at}: {stable}{slow}{kept}"


def _left_over(summary: Summary, needs: list[float]) -> tuple[float, bool, list[str]]:
    """What is left over the unbalance of a plane, the greatest; whether at any start; and by what, where it is not balanced."""
    share, surely, reasons = 0.0, False, list[str]()
    off = [
        plane.residual if plane.given else 0.0 for plane in (summary.off_center.planes if summary.off_center else ())
    ]
    stuck = [
        plane.residual_95 if plane.held_whirl > 0.0 else 0.0
        for plane in (summary.friction.planes if summary.friction else ())
    ]
    for residuals, what, end in (
        (off, "the race eccentricity leaves", ", center the race better"),
        (stuck, "friction leaves up to", f" {OF_RELEASED}; less friction helps"),
    ):
        known = needs if len(needs) == len(residuals) else [summary.unbalance] * len(residuals)
        for residual, need in zip(residuals, known, strict=True):
            if need > 0.0 and residual > LIMITS[0] * need:
                share = max(share, residual / need)
                surely = surely or (residuals is off and residual > LIMITS[1] * need)
                reasons.append(f"{what} {moment_text(residual)} of {moment_text(need)}{end}")
    return share, surely, reasons


def friction_rows(held: HeldByFriction, said: SpeedText, *, brief: bool = False) -> list[Row]:
    """What friction holds: rows for each plane with balls, only the first of them if ``brief``, or that there is none."""
    rows = _plane_rows("friction", held, [plane.rows[: 1 if brief else None] for plane in held.planes], said)
    return [*rows, ("friction, theory" if rows else "friction", held.note)] if held.note else rows


def _eccentricity(summary: Summary) -> list[Row]:
    if summary.off_center is None or not summary.off_center.sentence:
        return []
    held = summary.friction is not None and any(plane.eccentric_residual > 0.0 for plane in summary.friction.planes)
    return [
        (
            "race eccentricity",
            summary.off_center.sentence + "; friction stops balls at worse places or better ones, see above" * held,
        )
    ]


def service_rows(service: Service, said: SpeedText) -> list[Row]:
    """What the rotor does without balancing: grade, vibration and forces."""
    grade = f"ISO 21940-11 {grade_name(service.grade)} ({velocity_text(1e-3 * service.grade)})"
    of = f", of {moment_text(service.unbalance)}, the needs of the planes added up" if service.added_up else ""
    ignored = f"; {service.ignores}" if service.ignores else ""
    rows = [("without balancing", f"{grade} at {said(service.speed)}{of}{ignored}")]
    for names, text, values in (("vibration", length_text, service.vibration), ("force", force_text, service.force)):
        known = [(name, value) for name, value in values if math.isfinite(value)]
        if known:
            shown = ", ".join(f"{name}: {text(value)}" if len(values) > 1 else text(value) for name, value in known)
            rows.append(("", f"{names} {shown}"))
    return rows


def _critical_speeds(summary: Summary, said: SpeedText) -> Iterator[Row]:
    names: tuple[str, ...] = ("along x and y, ",) if len(summary.critical_speeds) == 1 else ("along x, ", "along y, ")
    if summary.rotor != "planar":
        names = tuple("" for _ in summary.critical_speeds)
    rows = list(zip(names, summary.critical_speeds, summary.damping_ratios, strict=True))
    for name, speed, ratio in rows[:LISTED]:
        yield "critical speed", f"{said(speed)}, {name}damping ratio {100 * ratio:.3g} %"
    if len(rows) > LISTED:
        yield "", f"and {len(rows) - LISTED} more from {said(rows[LISTED][1])} on{MORE_MODES}"


def _most(summary: Summary) -> str:
    return " (greatest over time)" if summary.unbalance_varies else ""


def _unbalance(summary: Summary, said: SpeedText) -> Iterator[Row]:
    what = ", vector sum of the point unbalances" * summary.several_unbalances
    yield "unbalance", f"{moment_text(summary.unbalance, 5)}{what}{_most(summary)}"
    if summary.service is not None:
        yield from service_rows(summary.service, said)


def _race_rows(race: RaceSummary, summary: Summary) -> Row:
    enough = _enough(race.capability, summary) if len(summary.races) == 1 else ""
    enough += f"; {race.ignores}" if race.ignores else ""
    return (
        f"balancer {race.balancer}, race {race.race}",
        f"{race.balls} {race.bodies}{'s' * (race.balls > 1)}, "
        f"{race.ball_mass * 1e3:.5g} g ({race.effective_mass * 1e3:.5g} g effective), "
        f"taking {math.degrees(race.occupied_angle):.4g} deg\n"
        f"capability {moment_text(race.capability, 5)}{enough}\n"
        f"drag beta {', '.join(f'{beta:.4g}' for beta in race.drag)} N m s",
    )


def _together(summary: Summary) -> Iterator[Row]:
    if len(summary.races) > 1 and not summary.stations:
        yield "all races", f"capability {moment_text(summary.capability, 5)}{_enough(summary.capability, summary)}"


def _enough(capability: float, summary: Summary) -> str:
    return (
        f", {capability / summary.unbalance:.3g} times the unbalance"
        if summary.unbalance and not summary.stations
        else ""
    )


def _planes(summary: Summary, said: SpeedText) -> Iterator[Row]:
    why = f" ({summary.friction.chosen})" if summary.friction is not None and summary.friction.chosen else ""
    for plane in summary.stations:
        enough = f", {plane.capability / plane.required:.3g} times as much" if plane.required > 0.0 else ""
        yield (
            f"plane {plane.name}",
            f"needs {moment_text(plane.required, 5)}{_most(summary)} for rest at {said(plane.speed)}{why}, "
            f"capability {moment_text(plane.capability, 5)}{enough}" + SHARED * plane.shared,
        )


def _settled_rows(held: HeldByFriction, said: SpeedText) -> list[Row]:
    """The same of balls that settle at a lower speed."""
    rows = _plane_rows("  settled", held, [plane.settled_rows for plane in held.planes], said)
    return rows or [("  settled", held.note)]


def _plane_rows(title: str, held: HeldByFriction, planes: list[tuple[Row, ...]], said: SpeedText) -> list[Row]:
    rows: list[Row] = []
    for plane, (first, *others) in zip(held.planes, planes, strict=True):
        name = f"{title}, {plane.name}" if len(planes) > 1 else title
        indent = " " * (len(title) - len(title.lstrip()) + 2)
        rows += [(name, f"at {held.at(said)} {first[1]}"), *((indent + label, text) for label, text in others)]
    return rows


def _borders(summary: Summary, said: SpeedText) -> Iterator[Row]:
    if not summary.borders:
        yield "border speeds", f"none ({summary.no_borders_because.removeprefix('border speeds: ')})"
        return
    if not math.isnan(summary.sommerfeld_number):
        yield "Sommerfeld number S", f"{summary.sommerfeld_number:.4g}   (m eps w_c)^2 / (b beta)"
    for border in summary.borders:
        shown = border.text(said) + (f"   ({border.note})" if border.note else "")
        yield border.name, shown if border.known else f"not known: {border.note}"
