"""The unbalance of the rig by the four-run method without phase, section 4: at 4000 rpm, a washer on alternate screws.

The rig without balls has the unbalance and the misalignment of table 2 for three washers; amplitudes are those of its steady
motion with 1 % of noise. Read is the plane of the disk, which the sensors at both bearing housings give together. A correction
in one plane can remove what moves this plane; what it leaves is the misalignment.
"""

from __future__ import annotations

import cmath
from pathlib import Path
from typing import Any

import numpy as np

import autobalancer as ab
from autobalancer.files.examples import rig
from autobalancer.machine import Machine, Unbalance
from autobalancer.measure import BalanceRun, Reading, TrialMass, four_run
from autobalancer.plots.style import save_picture
from autobalancer.random_numbers import generator
from reproductions import Found, compared_all, said
from reproductions.rodrigues2011.rig import BEARINGS, RPM

SPEED, WASHER, NOISE = 4000.0 * RPM, 12.4e-6, 0.01
PLACES = (None, 0.0, 120.0, 240.0)
LEFT = 6e-6  # kg m, what the source reached


def reproduce(out: Path) -> list[dict[str, Any]]:
    """What is left after balancing with the result of four runs."""
    machine = rig("rodrigues_rig")
    found = four_run(runs(machine, "disk"), deviation=NOISE)
    save_picture(ab.plot.answer(found), out / "four_runs.png")
    left, housing = (unbalance_left(machine, station) for station in ("disk", "B1"))
    note = (
        f"from the bearing housing B1 alone {1e6 * housing:.2g} g mm would be left: there the misalignment counts more"
    )
    whole, couple = (vibration(machine, correction(machine, "disk"), only) for only in (False, True))
    rows = [
        said(f"unbalance left by the four-run method, {1e6 * left:.2g} g mm, is below 6 g mm", left < LEFT, note),
        said(f"what is left is mainly the couple: {couple / whole:.0%} of the vibration alone", couple > 0.5 * whole),
    ]
    own = abs(complex(machine.unbalances[0].vector))
    rows.append(
        Found("internal", "unbalance of three washers, by four runs of the simulated rig", "g mm", 37.2,
              1e6 * abs(correction(machine, "disk")), 0.05 * 37.2, f"its model has {1e6 * own:.4g} g mm", "table 2")
    )  # fmt: skip
    return compared_all("Rodrigues 2011", "section 4", rows)


def runs(machine: Machine, station: str) -> list[BalanceRun]:
    """Four runs with their amplitudes along x."""
    rng, found = generator(4), []
    for place in PLACES:
        mass = () if place is None else (Unbalance(moment=WASHER, angle=np.radians(place), station="disk"),)
        seen = ab.rotor.response(machine, [SPEED], [station], (*machine.unbalances, *mass)).isel(speed=0, station=0)
        size = abs(complex(float(seen.x_real), float(seen.x_imag))) * (1.0 + NOISE * rng.standard_normal())
        on = [] if place is None else [TrialMass("disk", f"{WASHER} kg*m", f"{place} deg")]
        found.append(BalanceRun("original" if place is None else f"washer at {place:g} deg", [Reading(size)], on))
    return found


def correction(machine: Machine, station: str) -> complex:
    """As four runs read at a station say, kg m."""
    found = four_run(runs(machine, station), deviation=NOISE)
    return cmath.rect(float(found.correction[0, 0]), float(found.correction_angle[0, 0]))


def unbalance_left(machine: Machine, station: str) -> float:
    """Static unbalance after the correction, kg m."""
    return float(abs(complex(machine.unbalances[0].vector) + correction(machine, station)))


def vibration(machine: Machine, mass: complex, only_couple: bool) -> float:
    """Mean of the greatest deflections of both bearings, as the source measures, after the correction; or of its couple alone."""
    added = Unbalance(moment=abs(mass), angle=cmath.phase(mass), station="disk")
    parts = (*machine.unbalances, added)
    if only_couple:
        static = complex(machine.unbalances[0].vector) + mass
        parts = (*parts, Unbalance(moment=abs(static), angle=cmath.phase(-static), station=0.0))
    return float(ab.rotor.response(machine, [SPEED], BEARINGS, parts)["mean_of_greatest"][0])
