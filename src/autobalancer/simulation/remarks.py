"""What must be said of a run in words. A new remark is a function of an ended run, and a place in the list at the end."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np

from autobalancer.assembly.drive_train import corners, highest_prescribed
from autobalancer.assembly.places import Places, in_frame, off_center
from autobalancer.assembly.reduced_rotor import has_hardening, has_rubber
from autobalancer.assembly.rotors import balancer_rows, lateral_model
from autobalancer.assembly.rotors.equivalent_stiffness import central_force
from autobalancer.assembly.rotors.reduction import AIM
from autobalancer.assembly.system import Assembly, equal_groups
from autobalancer.catalog.product_tables import NONE_GIVEN
from autobalancer.catalog.resolve import Ball, resolve
from autobalancer.kernels.integrators.integrator_state import NEXT_BIN, NEXT_SAMPLE, NEXT_TURN, Memory
from autobalancer.kernels.integrators.recording import Record
from autobalancer.kernels.measures.thresholds import FASTEST
from autobalancer.kernels.system import BALLS, SPEED, THETA, Floats, Matrix, X, Y
from autobalancer.laws.stall import held_whirl
from autobalancer.machine import Machine, MatricesRotor, ModalRotor, PrescribedSpeed
from autobalancer.machine.drive import Hill
from autobalancer.machine.keys import USUAL, bare_numbers
from autobalancer.results.display_units import length_text, significant
from autobalancer.tables import rpm_and_si
from autobalancer.units import WrittenFloat

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class Ended:
    """A run that has ended: its machine, duration (s) and numbers, what it kept, and its result with all but its remarks."""

    machine: Machine
    duration: float
    assembly: Assembly
    places: Places
    record: Record
    state: Memory
    run: xr.Dataset

    @property
    def balls(self) -> tuple[Ball, ...]:
        """Those that move; none where they are held."""
        return self.assembly.balls if "ball" in self.run.sizes else ()


# Whether a bearing moved farther than the table of its force is known for, in words.


def beyond_table(e: Ended) -> str:
    """Which bearings moved beyond their table, where its last slope goes on."""
    assembly = e.assembly
    reach = [central_force(place.hardening).reach for place in assembly.hard]
    if not np.isfinite(reach).any():
        return ""
    middle = np.array([place.hardening.center for place in assembly.hard], float)
    moved = greatest_stretch(assembly.system.bearings.rows, middle, e)
    far = [
        f"{place.name} moved {length_text(way)} from its middle, its table ends at {length_text(limit)}"
        for place, way, limit in zip(assembly.hard, moved, reach, strict=True)
        if way > limit
    ]
    if not far:
        return ""
    return f"bearings: {'; '.join(far)}; beyond it the force goes on with its last slope, add the forces there"


# Whether rubber moved farther than its friction elements are known for, in words.


def greatest_stretch(rows: Matrix, middle: Matrix, e: Ended) -> Floats:
    """Greatest distances from ``middle`` (M, 2) of places with ``rows`` (2 M, R) in the states that a run kept, (M,) m."""
    record, state = e.record, e.state
    seen = (
        record.samples[: int(state.counts[NEXT_SAMPLE])],
        record.bin_states[: int(state.counts[NEXT_BIN])],
        record.turn_states[: int(state.counts[NEXT_TURN]), 1:],
        state.state[None],
    )
    states = np.concatenate([part[np.isfinite(part).all(axis=1)] for part in seen])
    q = in_frame(states, e.assembly)[0]
    stretch = (q @ rows[:, : q.shape[1]].T).reshape(len(states), -1, 2) - middle
    return np.asarray(np.hypot(stretch[..., 0], stretch[..., 1]).max(axis=0, initial=0.0))


def beyond_breakaway(e: Ended) -> str:
    """Which rubber moved farther than its largest breakaway amplitude, beyond which its loss force no longer grows."""
    assembly = e.assembly
    if not any(mount.rubber.friction for mount in assembly.mounts):
        return ""
    far = []
    middle = np.zeros((len(assembly.mounts), 2))
    stretches = greatest_stretch(assembly.system.rubber.rows, middle, e)
    for mount, moved in zip(assembly.mounts, stretches, strict=True):
        limit = mount.rubber.largest_amplitude
        if mount.rubber.friction and moved > limit:
            far.append(
                f"{mount.name} moved {length_text(moved)}, its largest breakaway amplitude is {length_text(limit)}"
            )
    if not far:
        return ""
    more = "beyond it all friction elements slide, and their force stays the same; add one with a larger amplitude"
    return f"rubber: {'; '.join(far)}; {more}"


# Whether the balls of a run kept to the range in which their drag law and slipstream are known.


# What races off the axis leave at the end of a run, in words.


def off_axis(e: Ended) -> str:
    """The residual of the races off the axis at the last speed; empty without balls.

    Of races whose eccentricity is not given, only where a typical one matters beside the vibration without balls: a smaller one
    still leaves the machine balanced.
    """
    from autobalancer.results.verdict import LIMITS  # labeled arrays, which the check of a machine does not need

    run, speed = e.run, float(e.state.state[SPEED])
    if not 0.0 < abs(speed) < FASTEST:
        return ""
    center = off_center(e.places, e.assembly.balls, speed)
    if center is None or not center.sentence:
        return ""
    if not any(plane.given and plane.eccentricity > 0.0 for plane in center.planes):
        without = run["vibration_without_balls"].values if "vibration_without_balls" in run else [math.nan]
        if not center.greatest >= LIMITS[0][0] * max(without):
            return ""
        size = length_text(center.greatest)
        return f"race eccentricity: not given; a typical {size} would leave that much vibration (see check)"
    return f"race eccentricity: {center.sentence}"


# Until when resolved balls lie on the floor of their annulus, in words.


def on_floor(e: Ended) -> str:
    """Of all balls that a run with samples shows on a floor: until when, or from which speed on their wall would carry them."""
    from autobalancer.results.time_series import lifted_from

    run, machine = e.run, e.machine
    if "ball_floor_force" not in run or run["time"].size == 0:
        return ""
    force = run["ball_floor_force"].values
    seconds, speeds = (lifted_from(run[name].values, force) for name in ("time", "speed"))
    messages = []
    for number in np.flatnonzero(force.max(axis=0) > 0.0):
        name = f"ball {number + 1}"
        if np.isfinite(seconds[number]):
            messages.append(f"{name} until {significant(seconds[number])} s ({significant(speeds[number])} rad/s)")
            continue
        ball = e.balls[number]
        contact = machine.balancers[ball.balancer].races[ball.race].resolved
        assert contact is not None
        sliding = float(contact.sliding_friction)
        if sliding > 0.0:
            needed = math.sqrt(float(machine.gravity) / (sliding * ball.orbit_radius))
            carried = f"friction of its wall carries it from {significant(needed)} rad/s on"
        else:
            carried = "its wall without friction never carries it"
        messages.append(f"{name} up to the end; {carried}")
    return f"on the floor of the annulus: {', '.join(messages)}" if messages else ""


# What friction means for the end of a run, in words.


def held_by_friction(e: Ended) -> str:
    """The whirl below which balls at rest do not move at its last speed, of all races with balls; or that there is no friction.

    Without balls the text is empty.
    """
    machine = e.machine
    if not e.balls:
        return ""
    weight = machine.gravity / max(_last_speed(e.run) ** 2, 1e-300) if machine.axis == "horizontal" else 0.0
    kinds = {(ball.orbit_radius, ball.adherence) for ball in e.balls if ball.adherence > 0.0}
    held = [held_whirl(orbit, adherence, weight=weight) for orbit, adherence in sorted(kinds)]
    if not held:
        return NONE_GIVEN
    if max(held) < 0.0:
        return "the weight of the balls moves them in each turn at the last speed; friction does not hold them at rest"
    low, high = max(min(held), 0.0), max(held)
    span = length_text(high) if math.isclose(low, high) else f"{length_text(low)} to {length_text(high)}"
    text = f"friction holds balls at rest while their race is less than {span} off the axis of rotation"
    if not any(race.eccentricity for balancer in machine.balancers for race in balancer.races):
        return text
    return (
        text + "; an eccentric race can be farther off, and balls near the line of its whirl are held, too (see check)"
    )


def _last_speed(run: xr.Dataset) -> float:
    for name in ("turn_speed", "speed", "envelope_speed"):
        if name in run and run[name].size:
            return float(run[name].values[-1])
    return 0.0


# Balls that lie in one place although that state is unstable.


TOGETHER = 1e-6  # rad; balls this near lie in one place
LATE = 0.05  # share of a run, at its end, that is looked at

CURE = (
    "Identical balls at one place never separate, real ones do: set mass_spread above 0, give the balls a size (diameter), "
    "or start them at different angles"
)


def free_groups(machine: Machine) -> list[list[int]]:
    """Numbers of equal balls, from 0, that may lie in one place and that friction does not hold there."""
    balls = resolve(machine)

    def held(number: int) -> bool:
        friction = machine.balancers[balls[number].balancer].races[balls[number].race].friction
        return friction is not None and friction.holding > 0.0

    return [members for members in equal_groups(machine, balls) if not held(members[0])]


def pairs_together(groups: list[list[int]], angles: Floats) -> list[tuple[int, int]]:
    """Those balls of each group that lie in one place, two by two."""
    return [
        (one, other)
        for members in groups
        for one, other in combinations(members, 2)
        if abs(math.remainder(float(angles[one] - angles[other]), 2.0 * math.pi)) < TOGETHER
    ]


def parting_rate(ball: Ball, speed: float, outward: float) -> float:
    """Rate at which the distance of two balls in one place grows, 1/s; not above zero if they stay together.

    The rotor does not feel it when two balls part, so their distance d obeys J d'' + beta d' + m R w^2 s d = 0 with the mean
    deflection s of the race center in the direction of the balls: balls on the side to which the rotor is deflected are held
    together, those on the other side are driven apart.

    Parameters
    ----------
    ball
        One of them.
    speed
        Of the balls in space, rad/s.
    outward
        The deflection s, m.
    """
    pull = ball.moment * speed**2 * outward
    half = 0.5 * ball.drag / ball.inertia
    return float(np.sqrt(complex(half**2 - pull / ball.inertia)).real) - half


def in_one_place(e: Ended) -> str:
    """A sentence if balls lie in one place at the end and are driven apart; else empty."""
    assembly, n = e.assembly, len(e.assembly.balls)
    if not n:
        return ""
    states = np.vstack([e.record.samples[: int(e.state.counts[NEXT_SAMPLE])], e.state.state])
    late = states[-max(1, round(LATE * states.shape[0])) :]
    angles = late[:, BALLS : BALLS + n]
    rates = {}
    for one, other in pairs_together(free_groups(e.machine), angles[-1]):
        ball = assembly.balls[one]
        centers = _race_centers(assembly, ball, late)
        in_space = angles[:, one] + (0.0 if assembly.system.rotating else late[:, THETA])
        speed = float(np.mean(late[:, SPEED] + late[:, BALLS + n + one]))
        rates[one, other] = parting_rate(ball, speed, float(np.mean((centers * np.exp(-1j * in_space)).real)))
    return parting_text(rates)


def parting_text(rates: dict[tuple[int, int], float]) -> str:
    """What a result says of balls in one place that are driven apart; empty if none are."""
    driven = {pair: rate for pair, rate in rates.items() if rate > 0.0}
    if not driven:
        return ""
    one, other = max(driven, key=lambda pair: driven[pair])
    return (
        f"balls {one + 1} and {other + 1} lie in one place although this state is unstable: their distance would grow at "
        f"{driven[one, other]:.3g} 1/s. {CURE}"
    )


def _race_centers(assembly: Assembly, ball: Ball, states: Matrix) -> Floats:
    """Deflection of the race center in the frame of the integration, x + i y, (times,)."""
    z = states[:, X] + 1j * states[:, Y]
    if assembly.places.shape[0]:
        row, rest = assembly.places[ball.balancer], BALLS + 2 * len(assembly.balls)
        coordinates = np.column_stack([states[:, [X, Y]], states[:, rest : rest + row.shape[1] - 2]])
        z = coordinates @ (row[0] + 1j * row[1])
    turn = 1.0 if assembly.system.rotating else np.exp(1j * states[:, THETA])
    return np.asarray(z + ball.eccentricity * turn)


# What is odd in the description of a machine and the length of its run, in words.


REACHED = 0.95  # of the last speed of an S-shaped run-up, which never ends: a run that comes so far is long enough
SMALLEST_SHIFT = 2e-7  # m: balls that move the center of mass by less balance nothing that can be measured


def input_notes(machine: Machine, end: float | None) -> tuple[str, ...]:
    """Sentences on numbers that were hardly meant in SI, and on a run of ``end`` seconds that ends before its speed profile."""
    return (
        bare_numbers(machine)
        + _too_heavy(machine)
        + _of_matrices(machine)
        + _of_modes(machine)
        + (() if end is None else _ends_early(machine, end))
    )


def _too_heavy(machine: Machine) -> tuple[str, ...]:
    """A mass without a unit, or that of matrices, beside which the balls of the machine are nothing."""
    mass = getattr(machine.rotor, "mass", None)
    able = sum(ball.moment for ball in resolve(machine))
    if not isinstance(mass, float) or isinstance(mass, WrittenFloat) or not 0.0 < able < SMALLEST_SHIFT * mass:
        return ()
    little = f"beside it the balls can move the center of mass by {1e6 * able / mass:.2g} um at most"
    if isinstance(machine.rotor, MatricesRotor):
        return (f"the rotor has {mass:.4g} kg; {little}. Look at the unit of its matrices (rotor.files.mass_unit)",)
    if mass > USUAL["kg"][1]:
        return ()
    return (
        f"rotor.mass = {mass:.10g} was read in kg, since a number without a unit is SI; {little}. "
        f'Write the mass with its unit, "{mass:.10g} g" if that is meant',
    )


HEAVY = 0.1  # balls over the mass of a rotor of matrices, beyond which their unit is in doubt


def _of_matrices(machine: Machine) -> tuple[str, ...]:
    """A rotor of matrices beyond the frequency for which its coordinates stand, and one that is light beside its balls."""
    rotor, notes = machine.rotor, []
    if not isinstance(rotor, MatricesRotor):
        return ()
    top, balls = highest_prescribed(machine), sum(ball.mass for ball in resolve(machine))
    if top is not None and rotor.valid_to is not None and top > float(rotor.valid_to):
        notes.append(
            f"the machine turns at up to {rpm_and_si(top)}, and its few coordinates stand for all rows of the matrices up to "
            f"{rpm_and_si(float(rotor.valid_to))} only; keep more 'modes' (rotor.files)"
        )
    if balls > HEAVY * rotor.mass:
        notes.append(
            f"the balls are {100.0 * balls / rotor.mass:.3g} % of the mass of the rotor, {rotor.mass:.4g} kg; look at the "
            "units of the matrices (rotor.files.mass_unit) if it is heavier"
        )
    return tuple(notes)


LEFT_OUT = 0.02  # of the static deflection of a station; what the highest mode brings of it says what others would


def _of_modes(machine: Machine) -> tuple[str, ...]:
    """What modes that are not known may cost a rotor of modes with shapes."""
    rotor, notes = machine.rotor, []
    if not isinstance(rotor, ModalRotor) or rotor.one_plane:
        return ()
    top, speed = max(rotor.resonances, key=lambda mode: float(mode.frequency)), highest_prescribed(machine)
    highest = f"the highest of its modes, at {rpm_and_si(float(top.frequency))},"
    if speed is not None and speed > 0.5 * float(top.frequency):
        notes.append(f"the machine turns at up to {rpm_and_si(speed)}; {highest} should be at twice that or above")
    if rotor.total_mass is not None and rotor.knows_whole and rotor.carried < (1.0 - LEFT_OUT) * rotor.mass:
        notes.append(
            f"its modes carry {100.0 * rotor.carried / rotor.mass:.3g} % of the mass of the rotor, the rest is left out"
        )
    model, named = lateral_model(machine), {station.name: station.position for station in machine.stations}
    for place, balancer in zip(balancer_rows(machine, model), machine.balancers, strict=True):
        row, at = (
            model.both(place.deflection[None])[0],
            float(named.get(str(balancer.station), balancer.station) or 0.0),
        )
        number = int(np.abs(np.array(rotor.positions) - at).argmin())
        whole = float(row @ np.linalg.solve(model.stiffness_at(0.0), row)) * top.modal_mass * float(top.frequency) ** 2
        if len(rotor.resonances) > 1 and (share := top.shape[number] ** 2) > LEFT_OUT * whole > 0.0:
            notes.append(
                f"{highest} brings {100.0 * share / whole:.2g} % of the static deflection under a force at {1e3 * at:.4g} mm; "
                "modes that were left out may bring as much"
            )
    return tuple(notes)


def _ends_early(machine: Machine, end: float) -> tuple[str, ...]:
    if not isinstance(machine.drive, PrescribedSpeed):
        return ()
    profile = machine.drive.profile
    if isinstance(profile, Hill):
        last = float(profile.half_time) * (REACHED / (1.0 - REACHED)) ** (1.0 / float(profile.exponent))
        what = f"has come {100.0 * REACHED:.0f} % of its way"
    else:
        last, what = corners(profile)[-1][0], "ends"
    if end >= last * (1.0 - 1e-9):
        return ()
    return (
        f"the run lasts {end:.5g} s, but the speed profile {what} at {last:.5g} s only; run longer (run.duration) to reach its "
        "last speed",
    )


# Critical speeds as a result notes them, and of which motions they are.


def critical_attributes(machine: Machine, assembly: Assembly) -> dict[str, Any]:
    """Critical speeds (rad/s) and their gyroscopic shares; that they are those of small motions where the stiffness changes."""
    attributes: dict[str, Any] = {"critical_speeds": list(assembly.critical_speeds)}
    if assembly.gyroscopic_shares:
        attributes["gyroscopic_shares"] = list(assembly.gyroscopic_shares)
    if has_rubber(machine) or has_hardening(machine):
        attributes["critical_speeds_of"] = "small motions"
    return attributes


# What was odd before the run, in its race, and in the flow of its fluid.


def of_input(e: Ended) -> str:
    """Numbers that were hardly meant in SI, and a run that ends before its speed profile; a line each."""
    return "\n".join(input_notes(e.machine, e.duration))


def left_the_race(e: Ended) -> str:
    """Guided balls at which their race had to pull, which it cannot."""
    said = e.run.attrs
    if "left_race_ball" not in said:
        return ""
    end, count = said["left_race_end"], said["left_race_balls"]
    until = f"to {end:.5g} s" if end < float(e.run["time"][-1]) else "to the end of the run"
    return (
        f"from {said['left_race_time']:.5g} s {until}, {count} {'ball' if count == 1 else 'balls'} (first ball "
        f"{said['left_race_ball']}) would have left the race at times: the normal force is negative. Guided balls cannot leave "
        "it; simulate with 'resolved' balls to see it"
    )


def of_few_modes(e: Ended) -> str:
    """What the modes of the rotor that a run left out change, if it is more than they may."""
    said = e.run.attrs
    if not said.get("reduction_error", 0.0) > AIM:
        return ""
    return (
        f"{said['modes_kept']} of {said['modes_in_all']} modes of the rotor were kept; without the others a deflection under a "
        f"force differs by up to {100.0 * said['reduction_error']:.2g} % (rotor.modes; without it, as many as are needed)"
    )


def of_flow(e: Ended) -> str:
    """How far the speed of an unsteady flow is certain, and whether it agrees with that of the rotor; a line each."""
    said, told = e.run.attrs, []
    if share := said.get("flow_uncertainty", 0.0):
        much = f"by up to {share:.1%}" if math.isfinite(share) else "by an unknown share"
        told.append(
            f"the flow in the race is unsteady: on two grids the fluid's speed at the orbit differs {much} of the greatest speed"
        )
    if not said.get("flow_converged", 1):
        told.append(
            f"the flow in the race and the speed of the rotor did not agree after {said['flow_passes']} passes: the last one "
            f"changed the speed by {said['flow_change']:.1e} of its greatest value, {said['flow_tolerance']:.0e} is wanted; take "
            "fluid.lag = 'modes', or prescribe the speed"
        )
    return "\n".join(told)


REMARKS: tuple[Callable[[Ended], str], ...] = (
    of_input, of_few_modes, left_the_race, held_by_friction, on_floor, off_axis, beyond_breakaway, beyond_table, of_flow,
    in_one_place,
)  # fmt: skip


def remarks(ended: Ended) -> list[str]:
    """All that must be said of a run, in the order of the list."""
    return [line for remark in REMARKS for line in remark(ended).splitlines()]
