"""What is known of a machine with chambers before a run."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from autobalancer.assembly.chamber_assembly import contact_time
from autobalancer.files.machine_file import balls_in_chambers
from autobalancer.laws.capabilities import chamber_capability
from autobalancer.machine.chamber import Chamber, ChamberMachine
from autobalancer.machine.keys import bare_numbers
from autobalancer.results.display_units import moment_text
from autobalancer.simulation.chamber.bounds import (
    chamber_critical_speeds,
    fill,
    filling_sites,
    highest_speed,
    tilt_clearance,
    tilting_warnings,
)
from autobalancer.simulation.chamber.chamber_run import default_step
from autobalancer.tables import Described, rpm_and_si

FREEDOM = {"fixed": "fixed", "planar": "moves in its plane", "free": "free"}


@dataclass(frozen=True)
class ChamberFilling:
    """One chamber with its balls, SI. ``room`` is the number of balls of its largest size that the filling finds places for.

    ``tilt`` is how far the flat walls let a cylinder tilt that is alone between them.
    """

    chamber: int
    balls: int
    ball_mass: float
    smallest_diameter: float
    largest_diameter: float
    depth: float
    room: int
    capability: float
    body: str
    longest: float | None  # cylinder
    tilt: float | None

    def text(self, unbalance: float) -> str:
        """Its balls, its room and its capability, beside an ``unbalance`` (kg m)."""
        small, large = 1e3 * self.smallest_diameter, 1e3 * self.largest_diameter
        size = f"{large:.4g} mm" if math.isclose(small, large) else f"{small:.4g} to {large:.4g} mm"
        size += f" by {1e3 * self.longest:.4g} mm" if self.longest is not None else ""
        enough = f", {self.capability / unbalance:.3g} times the unbalance" if unbalance else ""
        several, together = ("s", " together") if self.balls != 1 else ("", "")
        # balls of mixed sizes may be more than there is room for of the largest
        share = "" if self.balls > self.room else f": {100 * self.balls / self.room:.3g} % filled"
        tilts = ""
        if self.tilt is not None:
            free = f", which lets one tilt by {math.degrees(self.tilt):.3g} degrees"
            tilts = ", so that one could turn over" if self.tilt > 1.57 else free
        return (
            f"{self.balls} {self.body}{several} of {size}, {self.ball_mass:.4g} kg{together}\n"
            f"{1e3 * self.depth:.4g} mm deep, room for {self.room} of {large:.4g} mm{share}{tilts}\n"
            f"capability {moment_text(self.capability, 5)}{enough}"
        )


@dataclass(frozen=True, repr=False)
class ChamberSummary(Described):
    """Masses, critical speeds, unbalance, capability, filling, contact time and step, and what looks wrong. SI."""

    name: str
    freedom: str
    total_mass: float
    rotor_mass: float
    ball_mass: float
    critical_speeds: tuple[float, ...]
    damping_ratios: tuple[float, ...]
    unbalance: float
    couple_unbalance: float
    capability: float
    chambers: tuple[ChamberFilling, ...]
    friction: float
    ball_friction: float | None  # between balls, if it is another one
    contact_time: float
    step: float
    duration: float | None
    highest_speed: float
    warnings: tuple[str, ...]

    def rows(self, said: Callable[[float], str] = rpm_and_si) -> list[tuple[str, str]]:
        """A name and a text each, with speeds as ``said`` writes them."""
        couple = f", couple {self.couple_unbalance * 1e9:.5g} g mm²" if self.couple_unbalance else ""
        steps = f", {self.duration / self.step:.3g} steps in {self.duration:g} s" if self.duration else ""
        between = "" if self.ball_friction is None else f", {self.ball_friction:g} between balls"
        # a contact along a line takes the same time at any speed
        at = "" if self.chambers[0].body == "cylinder" else " at 4 m/s"
        those = f"{self.chambers[0].body}s"
        modes = zip(self.critical_speeds, self.damping_ratios, strict=True)
        return [
            ("body", FREEDOM[self.freedom]),
            ("mass", f"{self.total_mass:.6g} kg with balls, rotor {self.rotor_mass:.6g} kg"),
            *(("critical speed", f"{said(speed)}, damping ratio {100 * ratio:.3g} %") for speed, ratio in modes),
            ("unbalance", f"{moment_text(self.unbalance, 5)}{couple}"),
            *((f"chamber {filling.chamber}", filling.text(self.unbalance)) for filling in self.chambers),
            (
                "friction",
                f"{self.friction:g}{between}; with too little friction, or too few {those}, they stay at the bottom",
            ),
            ("shortest contact", f"{1e6 * self.contact_time:.4g} us{at}"),
            ("step", f"{1e6 * self.step:.4g} us{steps}"),
            ("highest speed", said(self.highest_speed)),
        ]


def chamber_summary(machine: ChamberMachine | str | Path, say: Callable[[str], None] | None = None) -> ChamberSummary:
    """What is known of a machine with chambers before a run.

    Critical speeds are undamped and with the balls at rest in the chambers. ``contact_time`` is that of the shortest contact
    at 4 m/s, ``step`` the default one of :func:`simulate_chamber`. ``couple_unbalance`` counts from the middle of the rotor.
    Nothing of it takes long, so ``say`` is told nothing.

    Raises
    ------
    MachineError
        If the machine is not possible as described, or its balls do not fit.
    """
    machine = balls_in_chambers(machine)
    fill(machine)
    fillings = tuple(_filling(number, chamber) for number, chamber in enumerate(machine.chambers, 1))
    unbalance = float(abs(sum(part.vector for part in machine.unbalances)))
    couple = float(abs(sum(part.vector * part.position for part in machine.unbalances)))
    balls = sum(filling.ball_mass for filling in fillings)
    capability = sum(filling.capability for filling in fillings)
    critical, ratios = chamber_critical_speeds(machine)
    highest = highest_speed(machine)
    return ChamberSummary(
        name=machine.name,
        freedom=machine.body.freedom,
        total_mass=float(machine.body.mass or 0.0) + float(machine.rotor.mass) + balls,
        rotor_mass=float(machine.rotor.mass),
        ball_mass=balls,
        critical_speeds=critical,
        damping_ratios=ratios,
        unbalance=unbalance,
        couple_unbalance=couple,
        capability=capability,
        chambers=fillings,
        friction=float(machine.contact.friction),
        ball_friction=None if machine.contact.ball_friction is None else float(machine.contact.ball_friction),
        contact_time=contact_time(machine),
        step=default_step(machine),
        duration=float(machine.run.duration) if machine.run is not None else None,
        highest_speed=highest,
        warnings=bare_numbers(machine) + _warnings(machine, unbalance, couple, capability, critical, highest),
    )


def _filling(number: int, chamber: Chamber) -> ChamberFilling:
    groups = chamber.balls
    largest, widest = max(group.radius for group in groups), max(group.half_width for group in groups)
    lengths = [float(group.length) for group in groups if group.length is not None]
    tilts = [tilt for group in groups if (tilt := tilt_clearance(chamber, group)) is not None]
    return ChamberFilling(
        chamber=number,
        balls=sum(group.count for group in groups),
        ball_mass=sum(group.count * group.ball_mass for group in groups),
        smallest_diameter=2.0 * min(group.radius for group in groups),
        largest_diameter=2.0 * largest,
        depth=chamber.inner_depth,
        room=len(
            filling_sites(float(chamber.radius), chamber.inner_depth, largest, float(chamber.inner_radius), widest)
        ),
        capability=chamber_capability(
            float(chamber.radius),
            chamber.inner_depth,
            [(group.count, group.radius, group.ball_mass, group.half_width) for group in groups],
        ),
        body=groups[0].body,
        longest=max(lengths) if lengths else None,
        tilt=max(tilts) if tilts else None,
    )


def _warnings(
    machine: ChamberMachine,
    unbalance: float,
    couple: float,
    capability: float,
    critical: tuple[float, ...],
    highest: float,
) -> tuple[str, ...]:
    warnings = tilting_warnings(machine)
    if unbalance > capability:
        warnings.append(
            f"the balls can balance {moment_text(capability, 4)} of {moment_text(unbalance, 4)}; take more, heavier or, in a "
            "single layer, fewer and larger balls"
        )
    if machine.body.freedom == "fixed":
        warnings.append("the body is fixed: the unbalance has no effect on the balls, so they do not balance it")
    elif critical and highest < critical[0]:
        warnings.append("the highest speed is below the critical speeds; there the balls gather on the heavy side")
    elif critical and highest < critical[-1]:
        warnings.append("the highest speed is below a critical speed; there the balls gather on the heavy side")
    if couple > 1e-12 and machine.body.freedom == "planar":
        warnings.append("a planar body does not feel the couple unbalance; only a free one lets the balls balance it")
    return tuple(warnings)
