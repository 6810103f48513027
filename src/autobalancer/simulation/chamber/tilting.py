"""Whether cylinders, which a run holds parallel to the rotor, would stay so."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from autobalancer.machine.chamber import Chamber, ChamberMachine, FreeBalls

MUCH = math.radians(5.0)  # tilt between the flat walls beyond which a run is doubtful


def tilt_between_walls(length: float, diameter: float, gap: float) -> float:
    """How far a cylinder can tilt between flat walls that are ``gap`` apart, rad; pi/2 where it can turn over.

    Its corners meet the walls where L cos a + D sin a is the gap.
    """
    diagonal = math.hypot(length, diameter)
    if gap >= diagonal:
        return 0.5 * math.pi
    return max(math.atan2(diameter, length) - math.acos(min(gap / diagonal, 1.0)), 0.0)


def tilt_left(chamber: Chamber, group: FreeBalls) -> float | None:
    """How far the flat walls let a cylinder tilt that is alone between them, rad; ``None`` of a ball."""
    if group.length is None:
        return None
    return tilt_between_walls(float(group.length), 2.0 * group.radius, chamber.inner_depth)


def tilting_warnings(machine: ChamberMachine) -> list[str]:
    """What lets cylinders tilt, as sentences."""
    found, friction = [], float(machine.contact.friction)
    for number, chamber in enumerate(machine.chambers, 1):
        for group in chamber.balls:
            if group.length is None:
                continue
            length, diameter = float(group.length), 2.0 * group.radius
            size = f"{1e3 * diameter:.4g} mm by {1e3 * length:.4g} mm"
            tilt = tilt_left(chamber, group) or 0.0
            if tilt > MUCH:
                room = "turn over" if tilt > 1.57 else f"tilt by {math.degrees(tilt):.3g} degrees"
                found.append(
                    f"chamber {number} is {1e3 * chamber.inner_depth:.4g} mm deep: a cylinder of {size} could {room} there, and "
                    "the run holds it parallel to the rotor; look at 'tilting' of the run, or take a chamber little deeper "
                    "than the cylinders are long"
                )
            if friction * length > diameter:
                found.append(
                    f"friction of {friction:g} at a flat wall can tip a cylinder of {size} (its length times friction is more "
                    "than its diameter); the run holds it parallel to the rotor"
                )
            if friction * diameter > length:
                found.append(
                    f"friction of {friction:g} at the race can tip a cylinder of {size} (its diameter times friction is more "
                    "than its length); the run holds it parallel to the rotor"
                )
    return found


def tilting_note(run: xr.Dataset) -> str:
    """How far the contacts of a run press its cylinders to tilt; empty for balls."""
    if "tilting" not in run:
        return ""
    tilting = run["tilting"].values
    most, over = float(tilting.max(initial=0.0)), 100.0 * float(np.mean(tilting > 1.0))
    if over == 0.0:
        return f"the cylinders stay parallel: what would tilt one is at most {most:.2g} of what its contacts can bear"
    at = float(run["time"].values[int(np.argmax(tilting))])
    return (
        f"the cylinders are held parallel to the rotor; in {over:.2g} % of the samples a contact would tilt one, with up to "
        f"{most:.2g} times what its contacts can bear (at {at:.4g} s)"
    )
