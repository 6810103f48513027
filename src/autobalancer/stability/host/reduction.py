"""Fewer coordinates where the growth rate is asked at hundreds of speeds.

Modes of the rotor at rest, with the static deflections under a force at each station and under the unbalances added to
them, which take over what the higher modes would do. Modes are added until receptances at the stations agree with those
of the whole rotor; where this does not save anything, the whole rotor is kept.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy.linalg

from autobalancer.stability.host.planar import Complexes, Matrix
from autobalancer.stability.host.stations import Stations

FEW = 12  # pairs of coordinates that are not reduced
AIM = 1e-4  # relative error of the receptances up to twice the highest speed
FREQUENCIES = 8


def reduced(st: Stations, highest: float) -> Stations:
    """The same machine for speeds up to ``highest`` (rad/s), with fewer coordinates if it has many."""
    basis = basis_for(st, highest)
    return st if basis is None else projected(st, basis)


def basis_for(st: Stations, highest: float) -> Matrix | None:
    """Shapes that carry the motion at the stations up to ``highest``, (pairs, fewer); ``None`` if all coordinates are needed."""
    model, n = st.model, st.model.pairs
    if n <= FEW or not (st.isotropic or model.size == 2 * n):
        return None
    held = model.stiffness_at(min(0.5 * highest, model.top_speed))
    directions = [slice(0, n)] if st.isotropic else [slice(0, n), slice(n, 2 * n)]
    modes, static = [], []
    for block in directions:
        stiffness, mass = held[block, block], model.mass[block, block]
        pushed = np.column_stack(
            [st.rows.T, *(() if st.slopes is None else (st.slopes.T,)), st.load.real, st.load.imag]
        )
        stiffness = 0.5 * (stiffness + stiffness.T)
        modes.append(scipy.linalg.eigh(stiffness, mass)[1])
        static.append(np.linalg.lstsq(stiffness, pushed, rcond=1e-13)[0])
    count = 4
    while count * len(directions) + sum(part.shape[1] for part in static) < 0.7 * n:
        basis = _orthonormal(st, [m[:, :count] for m in modes] + static)
        if _error(st, projected(st, basis), min(highest, model.top_speed)) < AIM:
            return basis
        count += max(4, count // 2)
    return None


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
    model, n, r = st.model, st.model.pairs, basis.shape[1]
    both = np.zeros((model.size, 2 * r))
    both[:n, :r], both[n : 2 * n, r:] = basis, basis
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


def _error(st: Stations, small: Stations, highest: float) -> float:
    """Greatest relative difference of the receptances at the stations, forces there and unbalances."""
    worst, scale = 0.0, float(np.abs(st.rows).max() / max(np.abs(st.load).max(), 1e-300)) if np.any(st.load) else 0.0
    for speed in (0.05 * highest, 0.5 * highest, highest):
        for frequency in np.linspace(0.02, 2.0, FREQUENCIES) * highest:
            whole, part = (_answer(one, 1j * frequency, speed, scale) for one in (st, small))
            worst = max(worst, float(np.linalg.norm(whole - part) / np.linalg.norm(whole)))
    return worst


def _answer(st: Stations, sigma: complex, speed: float, scale: float) -> Complexes:
    model, n = st.model, st.model.pairs
    if st.isotropic:
        mass, turning, stiffness = model.complex_matrices(speed)
        pushed = np.column_stack([st.rows.T, scale * st.load])
        return np.asarray(st.rows @ np.linalg.solve(sigma**2 * mass + sigma * turning + stiffness, pushed))
    dynamic = sigma**2 * model.mass + sigma * (model.damping_at(speed) + speed * model.gyroscopic)
    dynamic = dynamic + model.stiffness_at(speed)
    seen = model.both(st.rows)
    force = np.zeros((model.size, 1), np.complex128)
    force[:n, 0], force[n : 2 * n, 0] = st.load, -1j * st.load
    return np.asarray(seen @ np.linalg.solve(dynamic, np.column_stack([seen.T, scale * force])))
