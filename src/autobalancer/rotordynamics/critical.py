"""Critical speeds: where a whirl of the free rotor has the speed of the rotor, or a multiple of it.

Without damping by :mod:`autobalancer.assembly.rotors.critical`; with damping, or where cross-coupled stiffness leaves no
Hermitian problem, as intersections of the branches of a Campbell diagram.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.assembly.rotors import LateralModel
from autobalancer.assembly.rotors.critical import Critical, critical_whirls
from autobalancer.errors import QuestionError
from autobalancer.machine import Machine
from autobalancer.rotordynamics.answers import CriticalSpeeds
from autobalancer.rotordynamics.campbell import checked_harmonics, intersections
from autobalancer.rotordynamics.eigenproblem import free_motions
from autobalancer.rotordynamics.question import along_axis, attributes, rotor_of
from autobalancer.rotordynamics.shapes import ellipses_of, mode_names
from autobalancer.rotordynamics.tracking import tracked
from autobalancer.rotordynamics.whirl import Whirl, whole_direction
from autobalancer.units import optional_argument

GRID = 600  # intervals in which the roots of tables are sought
Found = list[Critical]


def critical_speeds(
    machine: Machine | str | Path,
    *,
    balls: bool = True,
    highest: float | str | None = None,
    harmonics: Sequence[float] = (1.0,),
    damped: bool = False,
) -> CriticalSpeeds:
    """Speeds at which a free whirl has h times the speed of the rotor.

    Parameters
    ----------
    machine
        A machine or the path of a machine file.
    balls
        Whether the effective masses of the balls are added to the rotor.
    highest
        Upper end of the search, rad/s. Required with ``damped`` and with cross-coupled stiffness (no Hermitian problem);
        by default all speeds, or up to the end of the tables.
    harmonics
        h; 1 is the unbalance.
    damped
        Intersections of the damped natural frequencies with the lines, in place of those without damping.

    Returns
    -------
    xarray.Dataset
        Over ``critical``, ascending: ``critical_speed`` (rad/s), ``harmonic``, ``whirl`` (forward, backward, mixed or
        straight), ``name`` of the mode. Unbalance does not excite backward whirl of an isotropic rotor, so nothing
        happens at such a speed.

    Raises
    ------
    QuestionError
        If ``highest`` is missing where it is needed or is not positive, or a harmonic is not.
    MachineError
        If the rotor is not possible as described.
    """
    highest = optional_argument("highest", highest, "rad/s")
    machine, model = rotor_of(machine, balls=balls)
    lines = checked_harmonics(harmonics, "critical_speeds")
    if highest is not None and not (math.isfinite(highest) and highest > 0.0):
        raise QuestionError(f"critical_speeds: highest: given {highest:g} rad/s; must be greater than zero")
    limit = min(math.inf if highest is None else float(highest), model.top_speed)
    lossless = np.abs(model.stiffness - model.stiffness.swapaxes(1, 2)).max() <= 1e-12 * np.abs(model.stiffness).max()
    if damped or not lossless:
        if not math.isfinite(limit):
            why = "with damping" if damped else "with cross-coupled stiffness"
            raise QuestionError(f"critical_speeds: highest: missing; {why} a speed is needed up to which to search")
        found = _by_branches(model, limit, lines, damped)
    else:
        found = [entry for h in lines for entry in critical_whirls(model, h, limit, intervals=GRID)]
    found = sorted((entry for entry in found if entry[0] <= limit), key=lambda entry: entry[0])
    return _dataset(machine, model, found, balls, damped)


def _dataset(machine: Machine, model: LateralModel, found: Found, balls: bool, damped: bool) -> CriticalSpeeds:
    axis = along_axis(machine, model)
    vectors = np.array([vector for *_, vector in found]).reshape(len(found), model.size)
    vectors = vectors / np.sqrt(np.einsum("ij,jk,ik->i", vectors.conj(), model.mass, vectors).real)[:, None]
    ellipses = ellipses_of(model, vectors, axis)
    words = [whole_direction(Whirl(f, b)) for f, b in zip(ellipses.forward, ellipses.backward, strict=True)]
    result = xr.Dataset()
    data: dict[str, tuple[Any, str, str]] = {
        "critical_speed": (np.array([w for w, *_ in found], np.float64), "critical speed", "rad/s"),
        "harmonic": (np.array([h for _, h, _ in found], np.float64), "frequency over speed", ""),
        "whirl": (np.array(words, dtype=object), "direction of whirl", ""),
        "name": (np.array(mode_names(model, vectors, axis), dtype=object), "name of the mode", ""),
    }
    for key, (numbers, text, unit) in data.items():
        result[key] = ("critical", numbers, {"long_name": text, "units": unit})
    result.attrs = attributes(machine, f"Critical speeds of {machine.name}", balls=balls) | {
        "theory": "damped natural frequencies" if damped else "natural frequencies without damping"
    }
    return CriticalSpeeds.of(result)


def _by_branches(model: LateralModel, limit: float, harmonics: Sequence[float], damped: bool) -> Found:
    motions = cache(lambda speed: free_motions(model, speed, damped=damped))
    grid = np.linspace(0.0, limit, 201)
    branches = tracked(motions, grid, model.mass, model.size)
    found: Found = []
    for speed, h, branch in intersections(model, branches, grid, harmonics, motions):
        near = int(np.argmin(np.abs(grid - speed)))
        found.append(Critical(speed, h, branches.vector[branch, near]))
    return found
