"""Fewer coordinates: one criterion for runs and for stability, :func:`fewest`, and those for integration in time.

These are modes of the rotor at rest, with the deflection at one place in front. The new coordinates r are the deflection (X, Y)
at the reference place and combinations of modes orthogonal to it, in the same unit. On an isotropic rotor they come in pairs
(x, y), so that turning the machine turns each pair.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import eigh, null_space

from autobalancer.assembly.rotors.model import Complexes, LateralModel, Matrix, Rows
from autobalancer.errors import MachineError

FREQUENCIES = 48  # at which the receptances of both models are compared
AIM = 1e-3  # error of the receptance at which no further mode is added, for runs and for stability
FEW = 6  # so many pairs are kept without asking


@dataclass(frozen=True)
class Reduction:
    """q = ``basis`` r."""

    basis: Matrix  # (N, R)
    error: float  # greatest relative error of the receptance at the places, up to ``top`` rad/s
    top: float
    kept: int
    total: int


def reduction(
    model: LateralModel,
    front: Rows,
    places: Matrix,
    loads: Complexes,
    top: float,
    wanted: int | None,
    *,
    isotropic: bool,
) -> Reduction:
    """Modes that carry the motion at the ``places`` (P, pairs) under forces there and under unbalance ``loads``.

    Parameters
    ----------
    wanted
        Number of modes (of pairs on isotropic supports); ``None`` takes as many as bring the error below 1e-3.
    isotropic
        Whether x and y are alike, and so modes come in pairs without motion along the axis or about it.

    Raises
    ------
    MachineError
        If ``wanted`` modes cannot move the places.
    """
    n = model.pairs
    stiffness = model.stiffness_at(0.0)
    stiffness = 0.5 * (stiffness + stiffness.T)
    mass = model.mass
    if isotropic:
        stiffness, mass = stiffness[:n, :n], mass[:n, :n]
    _, modes = eigh(stiffness, mass)
    ahead = _ahead(front, n if isotropic else model.size, isotropic, n)
    total = modes.shape[1]
    least = 1 if isotropic else 2
    if wanted is not None:
        if wanted < 1:
            raise MachineError(f"rotor.modes: given {wanted}; at least 1 is needed")
        count = min(wanted if isotropic else 2 * wanted, total)
        counts = [count]
    else:
        few = min(total, FEW if isotropic else 2 * FEW)
        counts = [total] if total <= few else [*range(few // 2, total, 1 if isotropic else 2), total]
    top = float(min(top, model.top_speed))

    def bases() -> Iterator[Matrix]:
        for count in counts:
            chosen = modes[:, :count]
            seen = ahead @ chosen
            movable = np.linalg.matrix_rank(seen, tol=1e-9 * np.abs(seen).max(initial=1e-300)) == seen.shape[0]
            if count >= least and movable:
                yield _in_front(chosen, seen)

    found = fewest(model, bases(), places, loads, top)
    if found is None:
        raise MachineError(f"rotor.modes: given {wanted}; too few modes to move the plane of the balancer in x and y")
    basis, error = found
    return Reduction(_paired(basis, model) if isotropic else basis, error, top, basis.shape[1], total)


def _ahead(front: Rows, size: int, isotropic: bool, pairs: int) -> Matrix:
    if isotropic:
        return front.deflection[None]
    rows = np.zeros((2, size))
    rows[0, :pairs] = front.deflection
    rows[1, pairs : 2 * pairs] = front.deflection
    return rows


def _in_front(modes: Matrix, seen: Matrix) -> Matrix:
    """Combine modes so that the first coordinates are what is ``seen`` of them."""
    size = float(np.exp(np.log(np.linalg.norm(seen, axis=1)).mean()))
    forward = np.vstack([seen, size * null_space(seen).T])
    return np.asarray(modes @ np.linalg.inv(forward))


def _paired(basis: Matrix, model: LateralModel) -> Matrix:
    n, count = basis.shape
    both = np.zeros((model.size, 2 * count))
    both[:n, 0::2] = basis
    both[n : 2 * n, 1::2] = basis
    return both


def fewest(
    model: LateralModel, candidates: Iterable[Matrix], places: Matrix, loads: Complexes, top: float
) -> tuple[Matrix, float] | None:
    """The first of several bases whose :func:`receptance_error` is below 1e-3, else the last, and its error."""
    found = None
    for basis in candidates:
        found = basis, receptance_error(model, basis, places, loads, top)
        if found[1] <= AIM:
            break
    return found


def receptance_error(model: LateralModel, basis: Matrix, places: Matrix, loads: Complexes, top: float) -> float:
    """Greatest relative error of what forces at the places, and the unbalance, move there at speeds up to ``top``.

    ``basis`` is over all coordinates, (N, R), or, on isotropic rotors, over those along x, (pairs, r). An unbalance that
    hardly moves the places is compared with what a force of its size does. All coordinates have no error. A speed at which the
    matrix of the whole rotor is singular, a critical one without damping, does not count, since nothing is determined there;
    where only that of the reduced rotor is, the error is infinite.
    """
    if basis.shape[0] == basis.shape[1]:
        return 0.0
    answers = _whirls if model.isotropic and basis.shape[0] == model.pairs else _ellipses
    share = float(np.abs(loads).max(initial=0.0)) / max(float(np.abs(places).max(initial=0.0)), 1e-300)
    worst = 0.0
    for speed in np.linspace(0.0, top, FREQUENCIES + 1)[1:]:
        try:
            whole, small = answers(model, basis, places, loads, float(speed))
        except np.linalg.LinAlgError:
            continue
        apart, size = np.linalg.norm((whole - small)[:, :-1]), np.linalg.norm(whole[:, :-1])
        of_load, load_size = np.linalg.norm((whole - small)[:, -1]), np.linalg.norm(whole[:, -1])
        for error, norm in ((apart, size), (of_load, max(load_size, share * size))):
            worst = max(worst, float(error / norm)) if norm > 0.0 else worst
    return worst


def _ellipses(
    model: LateralModel, basis: Matrix, places: Matrix, loads: Complexes, speed: float
) -> tuple[Complexes, Complexes]:
    """Answers of the places along x and y to forces there and, last, to the loads: of the whole rotor and the reduced one."""
    seen = model.both(places)
    pushed = np.column_stack([seen.T.astype(np.complex128), circular(model, loads)])
    damping = model.damping_at(speed) + speed * model.gyroscopic
    dynamic = model.stiffness_at(speed) + 1j * speed * damping - speed**2 * model.mass
    whole = seen @ np.linalg.solve(dynamic, pushed)
    return whole, _reduced(dynamic, pushed, seen, basis)


def _whirls(
    model: LateralModel, basis: Matrix, places: Matrix, loads: Complexes, speed: float
) -> tuple[Complexes, Complexes]:
    """The same of an isotropic rotor, as forward and backward whirl: of the same size."""
    mass, turning, stiffness = model.complex_matrices(speed)
    found: list[tuple[Complexes, Complexes]] = []
    for way in (1.0, -1.0):
        dynamic = stiffness + 1j * way * speed * turning - speed**2 * mass
        unbalance = np.sqrt(2.0) * loads if way > 0.0 else 0.0 * loads
        pushed = np.column_stack([places.T.astype(np.complex128), unbalance])
        found.append((places @ np.linalg.solve(dynamic, pushed), _reduced(dynamic, pushed, places, basis)))
    return np.concatenate([one for one, _ in found]), np.concatenate([one for _, one in found])


def _reduced(dynamic: Any, pushed: Complexes, seen: Matrix, basis: Matrix) -> Complexes:
    """The answers of the reduced rotor; infinite where its matrix is singular."""
    try:
        return np.asarray(seen @ basis @ np.linalg.solve(basis.T @ dynamic @ basis, basis.T @ pushed))
    except np.linalg.LinAlgError:
        return np.full((seen.shape[0], pushed.shape[1]), np.inf, np.complex128)


def circular(model: LateralModel, loads: Complexes) -> Complexes:
    """An unbalance load (pairs,) as a force e^(i w t) on all coordinates: u along x and -i u along y."""
    force = np.zeros(model.size, np.complex128)
    force[: model.pairs] = loads
    force[model.pairs : 2 * model.pairs] = -1j * loads
    return force
