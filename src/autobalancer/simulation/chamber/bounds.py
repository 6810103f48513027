"""What a deep chamber can do at best, from closed forms that cost nothing."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from autobalancer.assembly.chamber.machine import profile_rows
from autobalancer.errors import QuestionError
from autobalancer.files.given import balls_in_chambers
from autobalancer.laws.chamber_capability import chamber_capability
from autobalancer.laws.deep_chamber import pick_up, settling
from autobalancer.laws.held_by_friction import held_whirl
from autobalancer.laws.hertz import greatest_pressure, reduced_modulus
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.machine.drive import AsynchronousMotor
from autobalancer.results.number_text import couple_text, force_text, length_text, moment_text
from autobalancer.shown import Described, rpm_and_si
from autobalancer.simulation.chamber.critical_speeds import (
    body_without_balancing,
    chamber_critical_speeds,
    vibrations_without_balancing,
)
from autobalancer.simulation.chamber.packing import balls_beside

SPEEDS = 400  # at which the shaking of the run-up is looked at


@dataclass(frozen=True, repr=False)
class ChamberBounds(Described):
    """What the balls of one chamber can do at best, and how well that bounds a run. SI.

    ``least_`` and ``greatest_`` values are those that no run gets below or above. ``axial_rows`` says in how many
    rows along the axis the balls lie at the bottom before the start. nan where something is not known.
    """

    name: str
    speed: float
    critical_speed: float
    unbalance: float
    capability: float
    least_residual: float
    swung_residual: float
    held_residual: float
    vibration_without_balls: float
    least_vibration: float
    friction: float
    drag_ratio: float
    least_friction: float
    axial_rows: int
    shaking: float
    run_up_time: float
    decay_rate: float
    best_decay_rate: float
    least_settling_time: float
    drag: float
    best_drag: float
    race_force: float
    race_pressure: float
    greatest_couple: float
    couple_bearing_force: float
    least_bearing_force: float
    warnings: tuple[str, ...] = ()

    def rows(self, said: Callable[[float], str] = rpm_and_si) -> list[tuple[str, str]]:
        """A name and a text each, with speeds as ``said`` writes them."""
        return bounds_rows(self, said)

    def as_dict(self) -> dict[str, Any]:
        """Plain numbers and texts, e.g. for JSON."""
        return asdict(self)


def bounds(machine: ChamberMachine | str | Path) -> ChamberBounds:
    """What the equal balls of a machine with one deep chamber can do at best, from closed forms.

    Capability by :func:`~autobalancer.laws.chamber_capability.chamber_capability`; pick-up, settling and swing by the
    derivations in ``autobalancer.laws.deep_chamber``; pressure by Hertz.

    Raises
    ------
    QuestionError
        If the machine has several chambers or groups of balls, cylinders, no unbalance, nothing that turns it, or a fixed body.
    """
    machine = balls_in_chambers(machine)
    if len(machine.chambers) != 1 or len(machine.chambers[0].balls) != 1:
        raise QuestionError(
            "machine: has several chambers or groups of balls; bounds are of one chamber with equal balls"
        )
    if machine.chambers[0].balls[0].body != "ball":
        raise QuestionError(
            "machine: its chamber has cylinders; these bounds hold for balls only; check and simulate take cylinders"
        )
    chamber, contact = machine.chambers[0], machine.contact
    group = chamber.balls[0]
    mass, radius, count = group.ball_mass, group.radius, group.count
    path = float(chamber.radius) - radius
    speed = final_speed(machine)
    if not speed > 0.0:
        raise QuestionError("drive: the rotor does not turn at the end; bounds need a speed")
    gravity = math.hypot(*machine.gravity[1:])
    size = float(abs(sum(part.vector for part in machine.unbalances)))
    if not size > 0.0:
        raise QuestionError("unbalances: the rotor has none to balance; give one")
    without = body_without_balancing(machine, speed)
    if not without > 0.0:
        raise QuestionError(
            "body: does not move with the unbalance at the final speed, so no ball feels it; free the body"
        )
    moved = size / without
    capability = chamber_capability(float(chamber.radius), chamber.inner_depth, [(count, radius, mass)])
    lacking = abs(size - mass * path) if count == 1 else max(size - capability, 0.0)
    roll = float(contact.rolling_arm) / radius * speed**2 * path  # rolling resistance over the mass
    swung = settling.swung_residual(count * mass, settling.swing(gravity, speed, roll))
    drag, square = float(chamber.drag), float(chamber.square_drag)
    slip = speed * path
    ratio = (drag + square * slip) * slip / (mass * gravity) if gravity > 0.0 else math.inf
    critical = max(chamber_critical_speeds(machine)[0], default=math.nan)
    passed = time_to(machine, critical)
    best = settling.best_decay_rate(drag, mass, count, moved, speed)
    smoothed = settling.smoothed_drag(roll, gravity, speed) if roll > 0.0 else 0.0
    force = mass * speed**2 * path
    span = abs(machine.rotor.bearings[0] - machine.rotor.bearings[1])
    couple = count * mass * path * (0.5 * chamber.inner_depth - radius)
    return ChamberBounds(
        name=machine.name,
        speed=speed,
        critical_speed=critical,
        unbalance=size,
        capability=capability,
        least_residual=max(lacking, swung if lacking == 0.0 else 0.0),
        swung_residual=swung,
        held_residual=moved * max(held_whirl(path, roll / (speed**2 * path), weight=gravity / speed**2), 0.0),
        vibration_without_balls=without,
        least_vibration=without * lacking / size,
        friction=float(contact.friction),
        drag_ratio=ratio,
        least_friction=pick_up.least_friction(ratio),
        axial_rows=math.ceil(count / balls_beside(chamber.inner_depth, radius)),
        shaking=_shaking(machine, speed, gravity),
        run_up_time=passed,
        decay_rate=settling.decay_rate(drag + mass * smoothed, mass, count, moved, speed)
        if smoothed < math.inf
        else 0.0,
        best_decay_rate=best,
        least_settling_time=passed + 1.0 / best,
        drag=drag,
        best_drag=settling.best_drag(mass, count, moved, speed),
        race_force=force,
        race_pressure=_pressure(machine, force, radius, float(chamber.radius)),
        greatest_couple=couple,
        couple_bearing_force=couple * speed**2 / span,
        least_bearing_force=0.5 * gravity * (float(machine.rotor.mass) + count * mass),
    )


def final_speed(machine: ChamberMachine) -> float:
    """Speed at the end of the run-up (rad/s); that of a motor without load."""
    if isinstance(machine.drive, AsynchronousMotor):
        return float(machine.drive.synchronous_speed)
    return float(profile_rows(machine).speed[-1])


def time_to(machine: ChamberMachine, speed: float) -> float:
    """Least time (s) after which the rotor has a ``speed``: that of a motor that turns the rotor alone, without losses."""
    drive = machine.drive
    if math.isnan(speed):
        return 0.0
    if not isinstance(drive, AsynchronousMotor):
        rows = profile_rows(machine)
        above = np.flatnonzero(rows.speed >= speed)
        if not above.size:
            return math.inf
        last = int(above[0])
        return float(np.interp(speed, rows.speed[last - 1 : last + 1], rows.time[last - 1 : last + 1])) if last else 0.0
    width = drive.synchronous_speed * drive.breakdown_slip
    first, end = drive.synchronous_speed - float(machine.start.speed), drive.synchronous_speed - speed
    if end <= 0.0:
        return math.inf
    if end >= first:
        return 0.0
    work = width**2 * math.log(first / end) + 0.5 * (first**2 - end**2)
    return float(machine.rotor.polar_inertia * work / (2.0 * drive.rated_torque * drive.overload * width))


def pressure_between_balls(machine: ChamberMachine, force: float) -> float:
    """Greatest pressure (Pa) of a contact with this force (N) between two balls, the hardest there is; nan without a material."""
    return _pressure(machine, force, 0.5 * machine.chambers[0].balls[0].radius, math.inf)


def _pressure(machine: ChamberMachine, force: float, radius: float, wall: float) -> float:
    contact = machine.contact
    if contact.youngs_modulus is None:
        return math.nan
    modulus = reduced_modulus(float(contact.youngs_modulus), float(contact.poisson_ratio))
    return greatest_pressure(force, modulus, radius, wall)


def _shaking(machine: ChamberMachine, highest: float, gravity: float) -> float:
    speeds = np.linspace(highest / SPEEDS, highest, SPEEDS)
    whirls = vibrations_without_balancing(machine, speeds)
    return max(pick_up.shaking(float(w), float(s), gravity) for w, s in zip(whirls, speeds, strict=True) if w == w)


# What a deep chamber can do at best, as rows of a table: a name and a text each.


def bounds_rows(found: ChamberBounds, said: Callable[[float], str]) -> list[tuple[str, str]]:
    """Everything that is shown of it, with speeds as ``said`` writes them."""
    calm = "calm: balls stay in touch with the bottom" if found.shaking < 1.0 else "balls hop at the bottom"
    one = "one row along the axis, which acts as one ball"
    lying = one if found.axial_rows == 1 else f"{found.axial_rows} rows along the axis"
    pressure = "" if math.isnan(found.race_pressure) else f", {1e-6 * found.race_pressure:.4g} MPa"
    held = moment_text(found.held_residual) if found.held_residual else "nothing, for gravity keeps the balls moving"
    rate = f"{found.decay_rate:.3g} 1/s, at best {found.best_decay_rate:.3g} 1/s with a drag of {found.best_drag:.3g} N s/m"
    return [
        ("speed", f"{said(found.speed)}, highest critical speed {said(found.critical_speed)}"),
        ("unbalance", f"{moment_text(found.unbalance)}; the balls can balance {moment_text(found.capability)}"),
        ("residual", f"at least {moment_text(found.least_residual)}; rolling resistance can hold {held}"),
        (
            "vibration",
            f"{length_text(found.vibration_without_balls)} without balls; at least {length_text(found.least_vibration)}",
        ),
        (
            "pick-up",
            f"one sliding ball needs a friction of {found.least_friction:.3g} on a calm rotor and has {found.friction:g}\n"
            f"the balls lie in {lying}\n"
            f"the rotor shakes with {found.shaking:.3g} g at most, {calm}",
        ),
        ("run-up", f"critical speed passed after {found.run_up_time:.3g} s or later"),
        ("small motions", f"decay with {rate}"),
        ("settling", f"takes {found.least_settling_time:.3g} s or longer"),
        ("ball on the race", f"{force_text(found.race_force)}{pressure}"),
        (
            "couple of the balls",
            f"at most {couple_text(found.greatest_couple)}, {force_text(found.couple_bearing_force)} on each bearing",
        ),
        ("bearings", f"the more loaded one bears {force_text(found.least_bearing_force)} or more"),
    ]
