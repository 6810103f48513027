"""A correction split over holes: masses at given angles whose sum comes nearest to the wanted one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from math import comb

import numpy as np

from autobalancer.errors import QuestionError
from autobalancer.measurement.balancing.arrays import Complexes, Floats
from autobalancer.measurement.balancing.runs import MASSES, one_of
from autobalancer.units import argument, list_argument

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
        found = _any_size(wanted, places, limit)
    else:
        if largest is not None:
            raise QuestionError("split_mass: largest: given with masses; leave those out that are too large")
        sizes = np.array(sorted({_of_kind("masses", one, unit) for one in masses}))
        if not sizes.size or not most >= 1:
            raise QuestionError("split_mass: give at least one of 'masses', and 'most' from 1 on")
        found = _of_stock(wanted, places, sizes, min(int(most), places.size))
    used = np.flatnonzero(found > 1e-9 * max(wanted_size, 1e-300))
    left = wanted - complex((found * np.exp(1j * places)).sum())
    return Split(
        tuple(places[used].tolist()),
        tuple(found[used].tolist()),
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
    found = linprog(
        np.ones(places.size),
        A_eq=np.stack([np.cos(places), np.sin(places)]),
        b_eq=np.array([wanted.real, wanted.imag]) / scale,
        bounds=(0.0, limit / scale if np.isfinite(limit) else None),
    )
    if not found.success:
        raise QuestionError(
            f"split_mass: {places.size} holes cannot hold this mass; there must be holes within 180 deg around its angle, and "
            "'largest' must not be too small"
        )
    return np.asarray(found.x * scale)


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
