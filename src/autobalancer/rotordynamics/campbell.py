"""The Campbell diagram: natural frequencies over the rotor speed, branch by branch."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any, get_args

import numpy as np
from scipy.optimize import linear_sum_assignment

from autobalancer.arrays import Floats
from autobalancer.assembly.drive_train import torsion_of
from autobalancer.assembly.rotors.critical import Critical, critical_whirls
from autobalancer.assembly.rotors.lateral_model import LateralModel
from autobalancer.errors import QuestionError, one_of
from autobalancer.machine import Machine
from autobalancer.machine.drive import twists
from autobalancer.results.answers.answer import Answer
from autobalancer.results.labels import labeled
from autobalancer.roots import root
from autobalancer.rotordynamics.natural_modes import (
    Branches,
    FreeMotions,
    Whirl,
    along_axis,
    attributes,
    checked_speeds,
    chosen_places,
    correlation,
    decay_rates,
    ellipses_of,
    free_motions,
    mode_names,
    rotor_of,
    station_coordinates,
    tracked,
    whole_direction,
)
from autobalancer.rotordynamics.response import ModeMotion, at_amplitude, rubber_of
from autobalancer.rotordynamics.torsion import shape_name, undamped_torsion
from autobalancer.units import argument, list_argument, optional_argument

THEORIES = ("natural frequencies without damping", "damped natural frequencies")


def campbell(
    machine: Machine | str | Path,
    speeds: Sequence[float | str] | Floats,
    *,
    balls: bool = True,
    modes: int = 10,
    harmonics: Sequence[float] = (1.0,),
    damped: bool = True,
) -> Answer:
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
    # branches: at each speed the motions that continue those of the speed before
    branches = tracked(motions, omega, model.mass, modes)
    axis = along_axis(machine, model)
    ellipses = ellipses_of(model, branches.vector, axis)
    count = branches.eigenvalue.shape[0]
    # the direction of whirl of each mode, along the whole axis
    words = np.full(branches.eigenvalue.shape, "none", dtype=object)
    for place in zip(*np.nonzero(~np.isnan(branches.eigenvalue)), strict=True):
        words[place] = whole_direction(Whirl(ellipses.forward[place], ellipses.backward[place]))
    values = branches.eigenvalue
    lacking = np.isnan(values)
    both, decay = ("branch", "speed"), decay_rates(values)
    data: dict[str, tuple[Any, ...]] = {
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
    # where a branch meets a harmonic of the speed
    crossed = intersections(model, branches, omega, lines, motions)
    at = "intersection"
    data["intersection_speed"] = (at, [c[0] for c in crossed], "speed of the intersection", "rad/s")
    data["intersection_harmonic"] = (at, [c[1] for c in crossed], "frequency over speed", "")
    data["intersection_branch"] = (at, np.array([c[2] + 1 for c in crossed], np.int64), "branch", "")
    nearest = [words[c[2], int(np.argmin(np.abs(omega - c[0])))] for c in crossed]
    data["intersection_whirl"] = (at, np.array(nearest, dtype=object), "direction of whirl", "")
    # torsion: frequencies without damping, the same at all speeds, and where they meet multiples of the speed
    if twists(machine.drive):
        train = torsion_of(machine)
        rates, shapes = undamped_torsion(train)
        names = np.array([shape_name(train.names, shape) for shape in shapes], dtype=object)
        met = sorted((rate / h, h) for rate in rates for h in lines if omega[0] <= rate / h <= omega[-1])
        at = "torsional_intersection"
        data["torsional_frequency"] = ("torsion", rates, "torsional natural frequency", "rad/s")
        data["torsional_name"] = ("torsion", names, "name of the torsional mode")
        data[f"{at}_speed"] = (at, np.array([w for w, _ in met]), "where torsion meets it", "rad/s")
        data[f"{at}_harmonic"] = (at, np.array([h for _, h in met]), "frequency over speed")
    coordinates = {
        "branch": ("branch", np.arange(1, count + 1), "branch, counted from 1"),
        "speed": ("speed", omega, "rotor speed", "rad/s"),
    }
    about = attributes(machine, f"Campbell diagram of {machine.name}", balls=balls) | {
        "theory": THEORIES[damped],
        "harmonics": [float(h) for h in lines],
    }
    return Answer.of(labeled(data, coordinates, about), "Campbell")


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
    intersections = []
    for h in harmonics:
        above = branches.eigenvalue.imag - h * speeds
        for b, i in zip(*np.nonzero(above[:, :-1] * above[:, 1:] < 0.0), strict=True):
            # refined between the two speeds, by the motion that is most like both ends of the branch
            ends = {float(speeds[k]): float(above[b, k]) for k in (i, i + 1)}
            low, high = ends
            vectors = branches.vector[b, i : i + 2]

            def miss(speed: float, h: float = h, ends: Any = ends, vectors: Any = vectors) -> float:
                if speed in ends:
                    return float(ends[speed])
                found: FreeMotions = motions(speed)
                likeness = correlation(vectors, found.vector, model.mass)
                low, high = ends
                share = (speed - low) / (high - low)
                best = int(np.argmax((1.0 - share) * likeness[0] + share * likeness[1]))
                return float(found.eigenvalue.imag[best] - h * speed)

            intersections.append((root(miss, low, high, xtol=1e-12 * high, rtol=1e-13), h, int(b)))
        intersections += [
            (float(speeds[i]), h, int(b)) for b, i in zip(*np.nonzero(above == 0.0), strict=True) if speeds[i] > 0
        ]
    return sorted(intersections)


# Critical speeds: where a whirl of the free rotor has the speed of the rotor, or a multiple of it.
#
# Without damping by :mod:`autobalancer.assembly.rotors.critical`; with damping, or where cross-coupled stiffness
# leaves no Hermitian problem, as intersections of the branches of a Campbell diagram.


GRID = 600  # intervals in which the roots of tables are sought


def critical_speeds(
    machine: Machine | str | Path,
    *,
    balls: bool = True,
    highest: float | str | None = None,
    harmonics: Sequence[float] = (1.0,),
    damped: bool = False,
) -> Answer:
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
    result: list[Critical] = []
    if damped or not lossless:
        if not math.isfinite(limit):
            why = "with damping" if damped else "with cross-coupled stiffness"
            raise QuestionError(f"critical_speeds: highest: missing; {why} a speed is needed up to which to search")
        motions = cache(lambda speed: free_motions(model, speed, damped=damped))
        grid = np.linspace(0.0, limit, 201)
        branches = tracked(motions, grid, model.mass, model.size)
        for speed, h, branch in intersections(model, branches, grid, lines, motions):
            near = int(np.argmin(np.abs(grid - speed)))
            result.append(Critical(speed, h, branches.vector[branch, near]))
    else:
        result = [entry for h in lines for entry in critical_whirls(model, h, limit, intervals=GRID)]
    result = sorted((entry for entry in result if entry[0] <= limit), key=lambda entry: entry[0])
    # the shape of each: its name and the sense of its whirl
    axis = along_axis(machine, model)
    vectors = np.array([vector for *_, vector in result]).reshape(len(result), model.size)
    vectors = vectors / np.sqrt(np.einsum("ij,jk,ik->i", vectors.conj(), model.mass, vectors).real)[:, None]
    ellipses = ellipses_of(model, vectors, axis)
    words = [whole_direction(Whirl(f, b)) for f, b in zip(ellipses.forward, ellipses.backward, strict=True)]
    at = "critical"
    dataset = labeled(
        {
            "critical_speed": (at, np.array([w for w, *_ in result], np.float64), "critical speed", "rad/s"),
            "harmonic": (at, np.array([h for _, h, _ in result], np.float64), "frequency over speed", ""),
            "whirl": (at, np.array(words, dtype=object), "direction of whirl", ""),
            "name": (at, np.array(mode_names(model, vectors, axis), dtype=object), "name of the mode", ""),
        },
        None,
        attributes(machine, f"Critical speeds of {machine.name}", balls=balls) | {"theory": THEORIES[damped]},
    )
    return Answer.of(dataset, "CriticalSpeeds")


# Natural frequencies and mode shapes of a rotor at one speed.


def modes(
    machine: Machine | str | Path,
    speed: float | str = 0.0,
    *,
    balls: bool = True,
    modes: int = 10,
    stations: Sequence[str | float] | None = None,
    rubber_amplitude: float | str | None = None,
    motion: ModeMotion = "line",
) -> Answer:
    """Damped and undamped natural frequencies of the rotor with mode shapes and whirl directions.

    Parameters
    ----------
    machine
        A machine or the path of a machine file.
    speed
        Rotor speed, rad/s, for the gyroscopic terms and for tables of stiffness and damping.
    balls
        Whether the effective masses of the balls are added to the rotor in the planes of their balancers.
    modes
        Number of modes, the lowest ones.
    stations
        Names or positions (m) for the whirl directions; by default all stations.
    rubber_amplitude
        Greatest deflection (m) of the rubber that softens with the amplitude, in each mode; by default small motions, in which
        it is stiffest.
    motion
        Of this rubber: ``line`` after a blow, ``circle`` in whirl, ``ellipse`` that of each mode itself, which is a circle where
        the machine is alike along x and y.

    Returns
    -------
    xarray.Dataset
        Over ``mode``, counted from 1 by frequency: ``name``, ``frequency`` (damped, rad/s), ``undamped_frequency``
        (without damping, of the mode with the most similar shape), ``damping_ratio``, ``decay_rate`` (1/s, negative where
        the motion grows), ``whirl`` (forward, backward, mixed along the axis, or straight). Over ``mode`` and ``place``
        along the axis: the amplitudes ``x_real``, ``x_imag``, ``y_real``, ``y_imag``, the greatest deflection of a mode
        being 1; over ``mode`` and ``station`` the same with the prefix ``station_`` and ``station_whirl``.
        ``attrs["decay_rates_without_frequency"]`` (1/s) are those of motions that do not oscillate.

    Raises
    ------
    QuestionError
        For a negative speed, no modes, an unknown station, a motion that is none, or rubber that is not known in it.
    MachineError
        If the rotor is not possible as described.
    """
    speed = argument("speed", speed, "rad/s")
    machine, model = rotor_of(machine, balls=balls)
    omega = float(checked_speeds(speed, model, "modes")[0])
    check_count(modes, "modes")
    at, axis = chosen_places(machine, model, stations, "modes"), along_axis(machine, model)
    every = free_motions(model, omega)
    found = every.lowest(modes)
    # rubber is as stiff as its amplitude makes it
    if rubber_amplitude is not None:
        rubber_amplitude = float(argument("rubber_amplitude", rubber_amplitude, "m"))
        if not (math.isfinite(rubber_amplitude) and rubber_amplitude >= 0.0):
            raise QuestionError(
                f"modes: rubber_amplitude: given {rubber_amplitude:g} m; must be finite and not negative"
            )
        one_of("modes: motion", motion, *get_args(ModeMotion))
        soft = rubber_of(machine, model)
        if soft is None:
            raise QuestionError(
                "modes: rubber_amplitude: this machine has no rubber that softens with the amplitude; leave it out"
            )
        found = at_amplitude(soft, omega, found, rubber_amplitude, motion)
    ellipses, station_ellipses = (ellipses_of(model, found.vector, places) for places in (axis, at))
    words = [whole_direction(Whirl(f, b)) for f, b in zip(ellipses.forward, ellipses.backward, strict=True)]
    values = found.eigenvalue
    decay = decay_rates(values)
    # frequency without damping of the mode with the most alike shape
    undamped = np.abs(values)
    if rubber_amplitude is None:
        plain = free_motions(model, omega, damped=False)
        rows, columns = linear_sum_assignment(-correlation(found.vector, plain.vector, model.mass))
        undamped = np.full(found.count, math.nan)
        undamped[rows] = plain.eigenvalue.imag[columns]
    data: dict[str, tuple[Any, ...]] = {
        "name": ("mode", np.array(mode_names(model, found.vector, axis), dtype=object), "name of the mode", ""),
        "frequency": ("mode", values.imag, "natural frequency, damped", "rad/s"),
        "undamped_frequency": ("mode", undamped, "natural frequency without damping", "rad/s"),
        "damping_ratio": ("mode", decay / np.abs(values), "damping ratio", ""),
        "decay_rate": ("mode", decay, "decay rate", "1/s"),
        "whirl": ("mode", np.array(words, dtype=object), "direction of whirl", ""),
        "station_whirl": (("mode", "station"), station_ellipses.direction, "direction of whirl at the station", ""),
    }
    # shapes over the greatest semi-major axis of each mode
    size = ellipses.semi_major.max(axis=1, keepdims=True)
    size = np.where(size > 0.0, size, 1.0)
    for prefix, dim, part in (("", "place", ellipses), ("station_", "station", station_ellipses)):
        x, y = part.forward + part.backward.conj(), (part.forward - part.backward.conj()) / 1j
        for letter, values_at in (("x", x / size), ("y", y / size)):
            for kind, numbers in (("real", values_at.real), ("imag", values_at.imag)):
                text = f"{'real' if kind == 'real' else 'imaginary'} part of the amplitude along {letter}"
                data[f"{prefix}{letter}_{kind}"] = (("mode", dim), numbers, text, "")
    coordinates = {
        "mode": ("mode", np.arange(1, found.count + 1), "mode, counted from 1"),
        "place": ("place", axis.positions, "position along the axis", "m"),
        **station_coordinates(at),
    }
    about = attributes(machine, f"Natural frequencies of {machine.name}", balls=balls) | {
        "speed": omega,
        "rubber_amplitude": math.nan if rubber_amplitude is None else rubber_amplitude,
        "decay_rates_without_frequency": (-every.real).tolist(),
        "x_and_y": "alike" if model.isotropic else "different",
    }
    return Answer.of(labeled(data, coordinates, about), "Modes")


def check_count(count: int, owner: str) -> None:
    """A number of modes is a whole number from 1."""
    if isinstance(count, bool) or not isinstance(count, (int, np.integer)) or count < 1:
        raise QuestionError(f"{owner}: modes: given {count!r}; must be a whole number from 1")
