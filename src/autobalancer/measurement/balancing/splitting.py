"""A correction split over holes: masses at given angles whose sum comes nearest to the wanted one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from math import comb
from pathlib import Path
from typing import Any, Literal

import numpy as np

from autobalancer.errors import QuestionError
from autobalancer.laws.capabilities import grade_argument, permissible_unbalance
from autobalancer.machine import Machine
from autobalancer.measurement.balancing.runs import AMPLITUDES, MASSES, Complexes, Floats, one_of
from autobalancer.rotordynamics.response import response
from autobalancer.units import argument, list_argument, optional_argument

MOST = 20_000_000  # combinations that are tried
AT_ONCE = 500_000
EQUAL = 1e-6  # share of the wanted mass by which two answers are equally near


@dataclass(frozen=True)
class Split:
    """``masses`` (kg or kg m) at ``angles`` (rad), and what they leave: ``residual`` and ``residual_angle``."""

    angles: tuple[float, ...]
    masses: tuple[float, ...]
    residual: float
    residual_angle: float
    unit: str


def split_mass(
    mass: float | str,
    angle: float | str,
    *,
    holes: int | Sequence[float | str],
    first: float | str = 0.0,
    masses: Sequence[float | str] | None = None,
    largest: float | str | None = None,
    most: int = 3,
) -> Split:
    """Split a mass at an angle over holes.

    Parameters
    ----------
    mass
        Wanted, kg, or a text; an unbalance as ``"25 g*mm"``.
    angle
        Of it, rad.
    holes
        Their number, evenly spaced from ``first`` (rad) on, or the angle of each, rad.
    masses
        That there are, each as often as needed and one in a hole: of all choices of up to ``most`` holes the nearest is
        found, of equally near ones that with fewest and lightest masses. Without any, masses may have any size: the least sum
        of masses that makes the wanted one exactly.
    largest
        Greatest mass in a hole, where any size is possible.
    most
        Holes that may be used with given masses.

    Returns
    -------
    Split
        Only holes with a mass.

    Raises
    ------
    QuestionError
        If holes and masses cannot make the wanted mass, or there are too many choices.
    """
    wanted_size, unit = one_of("mass", mass, MASSES)
    where = argument("angle", angle, "rad")
    if not wanted_size >= 0.0:
        raise QuestionError(f"split_mass: mass: given {mass!r}; must not be below zero")
    places = _places(holes, argument("first", first, "rad"))
    wanted = complex(wanted_size * np.exp(1j * where))
    if masses is None:
        limit = np.inf if largest is None else _of_kind("largest", largest, unit)
        result = _any_size(wanted, places, limit)
    else:
        if largest is not None:
            raise QuestionError("split_mass: largest: given with masses; leave those out that are too large")
        sizes = np.array(sorted({_of_kind("masses", mass, unit) for mass in masses}))
        if not sizes.size or not most >= 1:
            raise QuestionError("split_mass: give at least one of 'masses', and 'most' from 1 on")
        result = _of_stock(wanted, places, sizes, min(int(most), places.size))
    used = np.flatnonzero(result > 1e-9 * max(wanted_size, 1e-300))
    left = wanted - complex((result * np.exp(1j * places)).sum())
    return Split(
        tuple(places[used].tolist()),
        tuple(result[used].tolist()),
        abs(left),
        float(np.angle(left)),
        unit.replace("*", " "),
    )


def _of_kind(name: str, value: float | str, unit: str) -> float:
    number, own = one_of(name, value, MASSES)
    if isinstance(value, str) and own != unit:
        raise QuestionError(f"split_mass: {name}: given {value!r}, but the wanted mass is in {unit}")
    if not number > 0.0:
        raise QuestionError(f"split_mass: {name}: given {value!r}; must be above zero")
    return number


def _places(holes: int | Sequence[float | str], first: float) -> Floats:
    if isinstance(holes, int):
        if holes < 2:
            raise QuestionError(f"split_mass: holes: given {holes}; at least two are needed")
        return np.asarray(first + 2.0 * np.pi * np.arange(holes) / holes)
    return np.array(list_argument("holes", holes, "rad"))


def _any_size(wanted: complex, places: Floats, limit: float) -> Floats:
    """The least sum of masses; two neighbors by the law of sines, unless a limit asks for more holes."""
    from scipy.optimize import linprog

    scale = abs(wanted) or 1.0
    result = linprog(
        np.ones(places.size),
        A_eq=np.stack([np.cos(places), np.sin(places)]),
        b_eq=np.array([wanted.real, wanted.imag]) / scale,
        bounds=(0.0, limit / scale if np.isfinite(limit) else None),
    )
    if not result.success:
        raise QuestionError(
            f"split_mass: {places.size} holes cannot hold this mass; there must be holes within 180 deg around its angle, and "
            "'largest' must not be too small"
        )
    return np.asarray(result.x * scale)


def _of_stock(wanted: complex, places: Floats, sizes: Floats, most: int) -> Floats:
    """All choices of up to ``most`` holes, and of a mass in each."""
    count = sum(comb(places.size, n) * sizes.size**n for n in range(1, most + 1))
    if count > MOST:
        raise QuestionError(
            f"split_mass: {count:.2g} choices of up to {most} of {places.size} holes and {sizes.size} masses are too many; "
            "take fewer masses, or a smaller 'most'"
        )
    best, answer = abs(wanted), np.zeros(places.size)
    slack = EQUAL * max(abs(wanted), float(sizes[0]))
    for n in range(1, most + 1):
        grids: Floats = np.stack(np.meshgrid(*[sizes] * n, indexing="ij"), -1).reshape(-1, n)
        chosen = np.array(list(combinations(range(places.size), n)))
        for part in np.array_split(chosen, -(-chosen.shape[0] * grids.shape[0] // AT_ONCE)):
            if not part.size:
                continue
            ways: Complexes = np.exp(1j * places[part])
            far = np.abs(ways @ grids.T - wanted)
            nearest = far.min()
            if nearest >= best - slack:
                continue
            near = np.argwhere(far <= nearest + slack)
            lightest = near[int(np.argmin(grids[near[:, 1]].sum(axis=1)))]
            best = float(far[tuple(lightest)])
            answer = np.zeros(places.size)
            answer[part[lightest[0]]] = grids[lightest[1]]
    return answer


# The trial mass for a balancing job: how large, where, and whether it will be seen.


GRAVITY = 9.80665
SHARE = 0.1  # of the weight that a trial mass may pull with, rule of practice
GRADE_TIMES = 5.0  # permissible unbalances that a trial mass makes
SEEN = 0.3  # share of the reading by which it should change it
Running = Literal["below", "above"]
QUANTITIES = {"m": "displacement", "m/s": "velocity", "m/s^2": "acceleration"}


@dataclass(frozen=True)
class TrialPlan:
    """A trial mass (kg) at ``radius`` (m), its unbalance (kg m), force (N), and angle (rad, nan where nothing says where).

    ``change`` is the share by which it changes the reading, nan where no model says so; ``remarks`` say what to be careful about.
    """

    mass: float
    unbalance: float
    radius: float
    angle: float
    force: float
    change: float
    rule: str
    remarks: tuple[str, ...]


def trial_mass(
    *,
    radius: float | str,
    speed: float | str,
    rotor_mass: float | str | None = None,
    grade: float | str | None = None,
    machine: Machine | str | Path | None = None,
    station: str | float | None = None,
    plane: str | float | None = None,
    direction: Literal["x", "y"] = "x",
    reading: float | str | None = None,
    phase: float | str | None = None,
    running: Running | None = None,
) -> TrialPlan:
    """Plan a trial mass.

    Its size comes from the model if there is one (it changes the ``reading`` by 30 %), else from the ``grade`` (five times what
    the grade allows), else it pulls with a tenth of the weight of the rotor. Its place takes unbalance away rather than adding
    to it.

    Parameters
    ----------
    radius
        At which it will be, m.
    speed
        At which it will run, rad/s.
    rotor_mass
        kg; not needed with a machine of one mass.
    grade
        Balance quality grade in mm/s, such as 6.3 or ``"G 6.3"``.
    machine, station, plane, direction
        Model, where it is read and where the mass will be (by default the plane of the first balancer), and along what.
    reading, phase
        Of the run without trial mass, amplitude (peak) with unit, and lead against the mark, rad.
    running
        Without a model: ``"below"`` the critical speed, where the rotor moves towards its heavy side, or ``"above"``, where it
        moves away from it.

    Raises
    ------
    QuestionError
        If neither of the three ways is possible.

    Source: ISO 21940-11:2016 for grades; the tenth of the weight is a rule of practice.
    """
    arm, w = argument("radius", radius, "m"), argument("speed", speed, "rad/s")
    heavy = optional_argument("rotor_mass", rotor_mass, "kg")
    lead = optional_argument("phase", phase, "rad")
    for name, value in (("radius", arm), ("speed", w)):
        if not value > 0.0:
            raise QuestionError(f"trial_mass: {name}: given {value:g}; must be above zero")
    amplitude, unit = (None, "m") if reading is None else one_of("reading", reading, AMPLITUDES, amplitude=True)
    remarks: list[str] = []
    gain = None if machine is None else _gain(machine, w, station, plane, direction, unit)
    if gain is not None and amplitude is not None:
        unbalance, rule = SEEN * amplitude / abs(gain), "30 % of the reading, by the model"
    elif heavy is not None and grade is not None:
        unbalance, rule = (
            GRADE_TIMES * permissible_unbalance(grade, heavy, w),
            f"five times what G {grade_argument(grade):g} allows",
        )
    elif heavy is not None:
        unbalance, rule = SHARE * heavy * GRAVITY / w**2, "a tenth of the weight"
    else:
        raise QuestionError("trial_mass: give a machine and a reading, or the 'rotor_mass', with or without a 'grade'")
    force = unbalance * w**2
    if heavy is not None and force > SHARE * heavy * GRAVITY * (1.0 + 1e-9):
        remarks.append(
            f"it pulls with {force / (heavy * GRAVITY):.2g} of the weight of the rotor, more than a tenth; start at a lower speed"
        )
    change = float("nan") if gain is None or amplitude is None else abs(gain) * unbalance / amplitude
    return TrialPlan(
        unbalance / arm, unbalance, arm, _place(lead, gain, running, remarks), force, change, rule, tuple(remarks)
    )


def _place(lead: float | None, gain: complex | None, running: Running | None, remarks: list[str]) -> float:
    """Opposite to where the unbalance is, as far as anything says."""
    if lead is None:
        remarks.append(
            "without a phase nothing says where; start anywhere, and move it by 120 deg if the vibration grows much"
        )
        return float("nan")
    if gain is not None:
        heavy_side = lead - float(np.angle(gain))
    elif running is None:
        remarks.append(
            "say whether the rotor runs below or above its critical speed, or give a model, to know where it goes"
        )
        return float("nan")
    else:
        heavy_side = lead - (0.0 if running == "below" else np.pi)
    return float(np.mod(heavy_side + np.pi, 2.0 * np.pi))


def _gain(
    machine: Machine | str | Path,
    speed: float,
    station: str | float | None,
    plane: str | float | None,
    direction: str,
    unit: str,
) -> complex:
    """Complex amplitude at the station for a unit unbalance in the plane, lead and sense of rotation."""
    from autobalancer.machine import Unbalance

    if unit not in QUANTITIES:
        raise QuestionError(
            f"trial_mass: reading: with a model a displacement, velocity or acceleration is needed, not {unit}"
        )
    load: Any = 1.0 if plane is None else (Unbalance(moment=1.0, station=plane),)
    quantity: Any = QUANTITIES[unit]
    result = response(machine, [speed], None if station is None else [station], load, quantity=quantity)
    one = result.isel(speed=0, station=0)
    return complex(float(one[f"{direction}_real"]), float(one[f"{direction}_imag"]))
