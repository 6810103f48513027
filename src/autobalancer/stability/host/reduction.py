"""Fewer coordinates where the growth rate is asked at hundreds of speeds.

Modes of the rotor at rest, with the static deflections under a force at each station and under the unbalances added to
them, which take over what the higher modes would do. Modes are added by the criterion of all reductions,
:func:`autobalancer.assembly.rotors.reduction.fewest`; where this does not save anything, the whole rotor is kept.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from autobalancer.arrays import Matrix
from autobalancer.assembly.rotors.lateral_model import LateralModel
from autobalancer.assembly.rotors.reduction import AIM, fewest
from autobalancer.stability.host.stations import Stations

FEW = 12  # pairs of coordinates that are not reduced
BEYOND = 2.0  # times the highest speed: what is slow in the rotor may whirl so fast in space


def reduced(st: Stations, highest: float) -> Stations:
    """The same machine for speeds up to ``highest`` (rad/s), with fewer coordinates if it has many."""
    basis = basis_for(st, highest)
    return st if basis is None else projected(st, basis)


def basis_for(st: Stations, highest: float) -> Matrix | None:
    """Shapes that carry the motion at the stations up to ``highest``, (pairs, fewer); ``None`` if all coordinates are needed."""
    model, n = st.model, st.model.pairs
    if n <= FEW or not (st.isotropic or model.size == 2 * n):
        return None
    from scipy.linalg import eigh

    # shapes: the lowest modes, and what the rotor does under static forces at its stations
    held = model.stiffness_at(min(0.5 * highest, model.top_speed))
    directions = [slice(0, n)] if st.isotropic else [slice(0, n), slice(n, 2 * n)]
    modes, static = [], []
    for block in directions:
        stiffness, mass = held[block, block], model.mass[block, block]
        pushed = np.column_stack(
            [st.rows.T, *(() if st.slopes is None else (st.slopes.T,)), st.load.real, st.load.imag]
        )
        stiffness = 0.5 * (stiffness + stiffness.T)
        modes.append(eigh(stiffness, mass)[1])
        static.append(np.linalg.lstsq(stiffness, pushed, rcond=1e-13)[0])

    # more and more of them, until the receptances agree up to the highest speed
    def bases() -> Iterator[Matrix]:
        count = 4
        while count * len(directions) + sum(part.shape[1] for part in static) < 0.7 * n:
            basis = _orthonormal(st, [m[:, :count] for m in modes] + static)
            yield basis if st.isotropic else _both(model, basis)
            count += max(4, count // 2)

    basis = fewest(model, bases(), st.rows, st.load, min(BEYOND * highest, model.top_speed))
    if basis is None or basis[1] > AIM:
        return None
    return basis[0] if st.isotropic else basis[0][:n, : basis[0].shape[1] // 2]


def _orthonormal(st: Stations, parts: list[Matrix]) -> Matrix:
    """One basis for x and y, orthonormal for the mass, without directions that are there twice."""
    n = st.model.pairs
    root = np.linalg.cholesky(st.model.mass[:n, :n])
    wide = root.T @ np.column_stack(parts)
    sizes = np.linalg.norm(wide, axis=0)
    left, weights, _ = np.linalg.svd(wide[:, sizes > 0.0] / sizes[sizes > 0.0], full_matrices=False)
    return np.asarray(np.linalg.solve(root.T, left[:, weights > 1e-10]))


def projected(st: Stations, basis: Matrix) -> Stations:
    """The machine in coordinates r, q = ``basis`` r."""
    model, r = st.model, basis.shape[1]
    both = _both(model, basis)
    small = replace(
        model,
        mass=both.T @ model.mass @ both,
        gyroscopic=both.T @ model.gyroscopic @ both,
        damping=both.T @ model.damping @ both,
        stiffness=both.T @ model.stiffness @ both,
        pairs=r,
        coordinates=tuple(f"mode {i % r + 1} along {'xy'[i // r]}" for i in range(2 * r)),
    )
    slopes = None if st.slopes is None else st.slopes @ basis
    return replace(st, model=small, rows=st.rows @ basis, slopes=slopes, load=basis.T @ st.load)


def _both(model: LateralModel, basis: Matrix) -> Matrix:
    """Shapes along x, (pairs, r), as shapes over all coordinates, all x before all y, (N, 2 r)."""
    n, r = basis.shape
    both = np.zeros((model.size, 2 * r))
    both[:n, :r], both[n : 2 * n, r:] = basis, basis
    return both
