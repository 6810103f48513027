"""The Campbell diagram: natural frequencies over the rotor speed, branch by branch."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from scipy.optimize import brentq

from autobalancer.assembly.rotors import LateralModel
from autobalancer.assembly.rotors.model import Floats
from autobalancer.errors import QuestionError
from autobalancer.machine import Machine
from autobalancer.machine.drive import twists
from autobalancer.rotordynamics.answers import Campbell
from autobalancer.rotordynamics.eigenproblem import FreeMotions, correlation, decay_rates, free_motions
from autobalancer.rotordynamics.modes import check_count
from autobalancer.rotordynamics.question import along_axis, attributes, checked_speeds, rotor_of
from autobalancer.rotordynamics.shapes import ellipses_of, mode_names
from autobalancer.rotordynamics.torsion.lines import torsional_lines
from autobalancer.rotordynamics.tracking import Branches, tracked
from autobalancer.rotordynamics.whirl import Whirl, whole_direction
from autobalancer.units import list_argument


def campbell(
    machine: Machine | str | Path,
    speeds: Sequence[float | str] | Floats,
    *,
    balls: bool = True,
    modes: int = 10,
    harmonics: Sequence[float] = (1.0,),
    damped: bool = True,
) -> Campbell:
    """Natural frequencies over the speed; each branch is followed by its mode shape, also where it crosses another.

    Parameters
    ----------
    machine
        A machine or the path of a machine file.
    speeds
        Rotor speeds, ascending, rad/s, at least two.
    balls
        Whether the effective masses of the balls are added to the rotor.
    modes
        How many branches, the lowest ones at the first speed.
    harmonics
        Multiples h of the speed; the intersections with the lines h w are found. 1 is the synchronous line.
    damped
        Whether damping is included.

    Returns
    -------
    xarray.Dataset
        Over ``branch`` and ``speed``: ``frequency`` (rad/s), ``damping_ratio``, ``decay_rate`` (1/s), ``whirl``; nan and
        ``none`` where a branch does not oscillate. ``name`` over ``branch``, from the shape at the first speed. Over
        ``intersection``, by ascending speed: ``intersection_speed`` (rad/s), ``intersection_harmonic``,
        ``intersection_branch``, ``intersection_whirl``. Of a drive train that twists
        ``torsional_frequency`` and ``torsional_name``
        over ``torsion``, without damping, and over ``torsional_intersection`` its speed and harmonic.

    Raises
    ------
    QuestionError
        If the speeds do not ascend, are negative, fewer than two or outside the tables of the rotor.
    MachineError
        If the rotor is not possible as described.
    """
    speeds = list_argument("speeds", speeds, "rad/s")
    machine, model = rotor_of(machine, balls=balls)
    omega = checked_speeds(speeds, model, "campbell")
    if omega.size < 2 or np.any(np.diff(omega) <= 0.0):
        raise QuestionError(f"campbell: speeds: given {omega.size}; give at least two, ascending")
    check_count(modes, "campbell")
    lines = checked_harmonics(harmonics, "campbell")
    motions = cache(lambda speed: free_motions(model, speed, damped=damped))
    branches = tracked(motions, omega, model.mass, modes)
    axis = along_axis(machine, model)
    ellipses = ellipses_of(model, branches.vector, axis)
    count = branches.eigenvalue.shape[0]
    words = np.full(branches.eigenvalue.shape, "none", dtype=object)
    for place in zip(*np.nonzero(~np.isnan(branches.eigenvalue)), strict=True):
        words[place] = whole_direction(Whirl(ellipses.forward[place], ellipses.backward[place]))
    values = branches.eigenvalue
    lacking = np.isnan(values)
    result = xr.Dataset(
        coords={
            "branch": ("branch", np.arange(1, count + 1), {"long_name": "branch, counted from 1"}),
            "speed": ("speed", omega, {"long_name": "rotor speed", "units": "rad/s"}),
        }
    )
    both, decay = ("branch", "speed"), decay_rates(values)
    data: dict[str, tuple[Any, Any, str, str]] = {
        "name": (
            "branch",
            np.array(mode_names(model, branches.vector[:, 0], axis), dtype=object),
            "name of the branch, from its shape at the first speed",
            "",
        ),
        "frequency": (both, np.where(lacking, np.nan, values.imag), "natural frequency", "rad/s"),
        "damping_ratio": (both, np.where(lacking, np.nan, decay / np.abs(values)), "damping ratio", ""),
        "decay_rate": (both, np.where(lacking, np.nan, decay), "decay rate", "1/s"),
        "whirl": (both, words, "direction of whirl", ""),
    }
    crossed = intersections(model, branches, omega, lines, motions)
    at = "intersection"
    data["intersection_speed"] = (at, [c[0] for c in crossed], "speed of the intersection", "rad/s")
    data["intersection_harmonic"] = (at, [c[1] for c in crossed], "frequency over speed", "")
    data["intersection_branch"] = (at, np.array([c[2] + 1 for c in crossed], np.int64), "branch", "")
    nearest = [words[c[2], int(np.argmin(np.abs(omega - c[0])))] for c in crossed]
    data["intersection_whirl"] = (at, np.array(nearest, dtype=object), "direction of whirl", "")
    for key, (dims, numbers, text, unit) in data.items():
        result[key] = (dims, numbers, {"long_name": text, "units": unit})
    if twists(machine.drive):
        result = result.assign(torsional_lines(machine, lines, float(omega[0]), float(omega[-1])))
    result.attrs = attributes(machine, f"Campbell diagram of {machine.name}", balls=balls) | {
        "theory": "damped natural frequencies" if damped else "natural frequencies without damping",
        "harmonics": [float(h) for h in lines],
    }
    return Campbell.of(result)


def checked_harmonics(harmonics: Sequence[float], owner: str) -> list[float]:
    """Positive multiples of the speed."""
    lines = [float(h) for h in harmonics]
    if not lines or not all(np.isfinite(h) and h > 0.0 for h in lines):
        raise QuestionError(f"{owner}: harmonics: given {list(harmonics)!r}; give at least one, greater than zero")
    return lines


def intersections(
    model: LateralModel, branches: Branches, speeds: Floats, harmonics: Sequence[float], motions: Any
) -> list[tuple[float, float, int]]:
    """(speed, harmonic, branch) where a branch has the frequency h w, refined between the speeds, ascending."""
    found = []
    for h in harmonics:
        above = branches.eigenvalue.imag - h * speeds
        for b, i in zip(*np.nonzero(above[:, :-1] * above[:, 1:] < 0.0), strict=True):
            found.append((_refined(model, branches, speeds, h, int(b), int(i), motions), h, int(b)))
        found += [
            (float(speeds[i]), h, int(b)) for b, i in zip(*np.nonzero(above == 0.0), strict=True) if speeds[i] > 0
        ]
    return sorted(found)


def _refined(
    model: LateralModel, branches: Branches, speeds: Floats, harmonic: float, branch: int, left: int, motions: Any
) -> float:
    low, high = float(speeds[left]), float(speeds[left + 1])
    ends = branches.eigenvalue.imag[branch, left : left + 2] - harmonic * speeds[left : left + 2]
    vectors = branches.vector[branch, left : left + 2]

    def above(speed: float) -> float:
        if speed in (low, high):
            return float(ends[0 if speed == low else 1])
        found: FreeMotions = motions(speed)
        likeness = correlation(vectors, found.vector, model.mass)
        share = (speed - low) / (high - low)
        best = int(np.argmax((1.0 - share) * likeness[0] + share * likeness[1]))
        return float(found.eigenvalue.imag[best] - harmonic * speed)

    return float(brentq(above, low, high, xtol=1e-12 * high, rtol=1e-13))
