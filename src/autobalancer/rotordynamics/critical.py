"""Critical speeds: where a whirl of the free rotor has the speed of the rotor, or a multiple of it.

Without damping, q = Re(Q e^(i h w t)) is free where D(w) Q = 0 with the Hermitian D(w) = K(w) - w^2 (h^2 M - i h G).
For one K this is an eigenproblem for 1/w^2; for tables the roots of the ordered eigenvalues of D(w), which are
continuous, are found one by one. In axes of an isotropic rotor forward and backward whirl (h > 0, h < 0) stand alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from scipy.linalg import eigh
from scipy.optimize import brentq

from autobalancer.assembly.rotors import LateralModel
from autobalancer.assembly.rotors.model import Complexes, Floats
from autobalancer.errors import QuestionError
from autobalancer.machine import Machine
from autobalancer.rotordynamics.campbell import checked_harmonics, intersections
from autobalancer.rotordynamics.eigenproblem import free_motions
from autobalancer.rotordynamics.question import along_axis, attributes, rotor_of
from autobalancer.rotordynamics.shapes import ellipses_of, mode_names
from autobalancer.rotordynamics.tracking import tracked
from autobalancer.rotordynamics.whirl import Whirl, whole_direction
from autobalancer.units import optional_argument

NOT_A_SPEED = 1e-10  # of the greatest 1/w^2: below it there is no critical speed
GRID = 600  # intervals in which the roots of tables are sought
Found = list[tuple[float, float, Complexes]]  # speed, harmonic, vector (N,)


def critical_speeds(
    machine: Machine | str | Path,
    *,
    balls: bool = True,
    highest: float | str | None = None,
    harmonics: Sequence[float] = (1.0,),
    damped: bool = False,
) -> xr.Dataset:
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
        solve = _direct if model.speeds.size == 1 else _over_tables
        found = [entry for h in lines for entry in _by_direction(model, h, solve, limit)]
    found = sorted((entry for entry in found if entry[0] <= limit), key=lambda entry: entry[0])
    return _dataset(machine, model, found, balls, damped)


def _dataset(machine: Machine, model: LateralModel, found: Found, balls: bool, damped: bool) -> xr.Dataset:
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
    return result


def _by_direction(model: LateralModel, harmonic: float, solve: Callable[..., Found], limit: float) -> Found:
    n = model.pairs
    if not model.isotropic:
        return solve(lambda w: model.stiffness_at(w), _inertia(model.mass, model.gyroscopic, harmonic), model, limit,
                     harmonic, lambda v: v)  # fmt: skip
    mass, circling = _joined(model.mass, n), _joined(model.gyroscopic, n)
    found: Found = []
    for sign in (1.0, -1.0):

        def whole(vector: Complexes, sign: float = sign) -> Complexes:
            part = vector if sign > 0.0 else vector.conj()
            return np.concatenate([part, -1j * sign * part, np.zeros(model.size - 2 * n)])

        found += solve(lambda w: _joined(model.stiffness_at(w), n), _inertia(mass, circling, sign * harmonic), model,
                       limit, harmonic, whole)  # fmt: skip
    return found


def _joined(matrix: Floats, n: int) -> Complexes:
    return np.asarray(matrix[:n, :n] + 1j * matrix[n : 2 * n, :n], np.complex128)


def _inertia(mass: Any, gyroscopic: Any, harmonic: float) -> Complexes:
    return np.asarray(harmonic**2 * mass - 1j * harmonic * gyroscopic, np.complex128)


def _direct(
    stiffness: Callable[[float], Any],
    inertia: Complexes,
    model: LateralModel,
    limit: float,
    harmonic: float,
    whole: Callable[[Complexes], Complexes],
) -> Found:
    """Eigenvalues 1/w^2 of the inertia over the stiffness; a tiny spring holds a rotor that is free to move."""
    held = stiffness(0.0)
    size = float(np.abs(held).max())
    if np.linalg.eigvalsh(held)[0] <= 1e-13 * size:
        held = held + 1e-13 * size * np.eye(held.shape[0])
    inverse, vectors = eigh(inertia, held)
    chosen = np.flatnonzero(inverse > NOT_A_SPEED * np.abs(inverse).max())
    return [(float(inverse[i] ** -0.5), harmonic, whole(vectors[:, i])) for i in chosen]


def _over_tables(
    stiffness: Callable[[float], Any],
    inertia: Complexes,
    model: LateralModel,
    limit: float,
    harmonic: float,
    whole: Callable[[Complexes], Complexes],
) -> Found:
    """Roots of the ordered eigenvalues of D(w), sought between the speeds of the tables and finer."""
    grid = np.union1d(np.linspace(0.0, limit, GRID + 1), model.speeds[model.speeds < limit])

    def dynamic(speed: float) -> Complexes:
        return np.asarray(stiffness(speed) - speed**2 * inertia)

    levels = np.array([np.linalg.eigvalsh(dynamic(float(w))) for w in grid])
    found: Found = []
    for i, k in zip(*np.nonzero(levels[:-1] * levels[1:] < 0.0), strict=True):
        root = float(brentq(lambda w, k=k: np.linalg.eigvalsh(dynamic(w))[k], grid[i], grid[i + 1], rtol=1e-13))
        found.append((root, harmonic, whole(np.linalg.eigh(dynamic(root))[1][:, k])))
    return found


def _by_branches(model: LateralModel, limit: float, harmonics: Sequence[float], damped: bool) -> Found:
    motions = cache(lambda speed: free_motions(model, speed, damped=damped))
    grid = np.linspace(0.0, limit, 201)
    branches = tracked(motions, grid, model.mass, model.size)
    found: Found = []
    for speed, h, branch in intersections(model, branches, grid, harmonics, motions):
        near = int(np.argmin(np.abs(grid - speed)))
        found.append((speed, h, branches.vector[branch, near]))
    return found
