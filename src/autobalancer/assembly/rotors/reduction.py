"""Fewer coordinates for integration in time: modes of the rotor at rest, with the deflection at one place in front.

The new coordinates r are the deflection (X, Y) at the reference place and combinations of modes orthogonal to it, in
the same unit. On an isotropic rotor they come in pairs (x, y), so that turning the machine turns each pair.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh, null_space

from autobalancer.assembly.rotors.model import Complexes, LateralModel, Matrix, Rows
from autobalancer.errors import MachineError

FREQUENCIES = 48  # at which the receptances of both models are compared
AIM = 1e-3  # error of the receptance at which no further mode is added
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
    model: LateralModel, front: Rows, places: Matrix, loads: Complexes, top: float, wanted: int | None
) -> Reduction:
    """Modes that carry the motion at the ``places`` (P, pairs) under forces there and under unbalance ``loads``.

    Parameters
    ----------
    wanted
        Number of modes (of pairs on isotropic supports); ``None`` takes as many as bring the error below 1e-3.

    Raises
    ------
    MachineError
        If ``wanted`` modes cannot move the places.
    """
    n = model.pairs
    isotropic = model.isotropic
    stiffness = model.stiffness_at(0.0)
    stiffness = 0.5 * (stiffness + stiffness.T)
    mass = model.mass
    if isotropic:
        stiffness, mass = stiffness[:n, :n], mass[:n, :n]
    _, modes = eigh(stiffness, mass)
    ahead = _ahead(front, n if isotropic else model.size, isotropic, n)
    total = modes.shape[1]
    least = max(1 if isotropic else 2, 1)
    if wanted is not None:
        if wanted < 1:
            raise MachineError(f"rotor.modes: given {wanted}; at least 1 is needed")
        count = min(wanted if isotropic else 2 * wanted, total)
        counts = [count]
    else:
        few = min(total, FEW if isotropic else 2 * FEW)
        counts = [total] if total <= few else [*range(few // 2, total, 1 if isotropic else 2), total]
    top = float(min(top, model.top_speed))
    found = None
    for count in counts:
        if count < least:
            continue
        chosen = modes[:, :count]
        seen = ahead @ chosen
        if np.linalg.matrix_rank(seen, tol=1e-9 * np.abs(seen).max(initial=1e-300)) < seen.shape[0]:
            continue
        basis = _in_front(chosen, seen)
        if isotropic:
            basis = _paired(basis, model)
        error = (
            0.0
            if count == total and (isotropic or basis.shape[1] == model.size)
            else _error(model, basis, places, loads, top)
        )
        found = Reduction(basis, error, top, count, total)
        if error <= AIM:
            break
    if found is None:
        raise MachineError(f"rotor.modes: given {wanted}; too few modes to move the plane of the balancer in x and y")
    return found


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


def _error(model: LateralModel, basis: Matrix, places: Matrix, loads: Complexes, top: float) -> float:
    """At speeds up to ``top``, synchronous: what forces at the places and the unbalance move there."""
    seen = model.both(places)
    pushed = np.column_stack([seen.T.astype(np.complex128), circular(model, loads)])
    worst = 0.0
    for speed in np.linspace(0.0, top, FREQUENCIES + 1)[1:]:
        damping = model.damping_at(speed) + speed * model.gyroscopic
        dynamic = model.stiffness_at(speed) + 1j * speed * damping - speed**2 * model.mass
        full = seen @ np.linalg.solve(dynamic, pushed)
        small = seen @ basis @ np.linalg.solve(basis.T @ dynamic @ basis, basis.T @ pushed)
        size = np.linalg.norm(full)
        worst = max(worst, float(np.linalg.norm(full - small) / size)) if size > 0.0 else worst
    return worst


def circular(model: LateralModel, loads: Complexes) -> Complexes:
    """An unbalance load (pairs,) as a force e^(i w t) on all coordinates: u along x and -i u along y."""
    force = np.zeros(model.size, np.complex128)
    force[: model.pairs] = loads
    force[model.pairs : 2 * model.pairs] = -1j * loads
    return force
