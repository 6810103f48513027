"""Modes of a rotor whose gyroscopic forces change them with the speed, known at several speeds: the bases.

Between two of them the exponents drift in proportion to the speed, and the shapes are those of the basis in force; what this
leaves out is among the forces. ``bases`` has for each speed, ascending and equally spaced: the speed, the exponents (2 K), what
these gain per speed (2 K), the shapes and their inverse (2 K 2 K each). Room for the change from one to another follows.
"""

from __future__ import annotations

import math
from typing import Any

from autobalancer.kernels.flags import APART, MERGED, njit
from autobalancer.kernels.integrators.collocation.amplitudes import (
    BASIS,
    DECAY_KNOWN,
    FROZEN,
    FROZEN_BEFORE,
    LENGTH_KNOWN,
)
from autobalancer.kernels.pointers import behind, data
from autobalancer.kernels.wide import NODES, all_lanes, load, store

OF_SPEED, OF_EXPONENTS = 0, 1
STAY = 0.6  # of the way between two bases: beyond it the next one is taken


@njit(**MERGED)
def stride(modes: int) -> int:
    """Length of a basis."""
    return 1 + 4 * modes + 8 * modes * modes


def room_of_change(modes: int) -> int:
    """Length of what follows the bases."""
    return 2 * modes * (2 * modes + NODES)


@njit(**MERGED)
def basis_at(a: Any) -> int:
    """Where the basis in force begins."""
    return int(a.held[BASIS]) * stride(a.modes)


@njit(**MERGED)
def drift(part: int, a: Any) -> float:
    """What a part of an exponent gains per speed."""
    if a.bases.size == 0:
        return 0.0
    return float(data(a.bases)[basis_at(a) + OF_EXPONENTS + 2 * a.modes + part])


@njit(**MERGED)
def _exponent(part: int, speed: float, a: Any) -> float:
    bases, at = data(a.bases), basis_at(a)
    place = at + OF_EXPONENTS + part
    return float(bases[place] + (speed - bases[at + OF_SPEED]) * bases[place + 2 * a.modes])


@njit(**APART)
def take_basis(amplitudes: Any) -> None:
    """Exponents, shapes and their inverse for the frozen speed; what is kept of the last step is written in them."""
    a = behind(amplitudes)
    if a.bases.size == 0:
        return
    size, length, bases, speed = 2 * a.modes, stride(a.modes), data(a.bases), a.held[FROZEN]
    last = (a.bases.size - size * (size + NODES)) // length - 1
    room = (last + 1) * length
    way = 0.0
    if last > 0:
        way = (speed - bases[0]) / (bases[length] - bases[0])
    near = a.held[BASIS]
    if not abs(way - near) <= STAY:
        near = float(min(max(int(way + 0.5), 0), last))
    if near != a.held[BASIS]:
        before, known = a.held[FROZEN_BEFORE], a.held[BASIS] >= 0.0
        if known:
            _to_rates(1.0, before, a)
        a.held[BASIS] = near
        first = basis_at(a) + OF_EXPONENTS + 2 * size
        shapes, inverse = data(a.shapes), data(a.inverse)
        old, work = shapes, bases
        for i in range(size):
            for j in range(size):
                total = 0.0
                for k in range(size):
                    total += bases[first + size * size + i * size + k] * old[k * size + j]
                work[room + i * size + j] = total
        for i in range(size * size):
            shapes[i], inverse[i] = bases[first + i], bases[first + size * size + i]
        if known:
            _changed(data(a.amplitudes_before), room, a)
            _changed(data(a.forces_before), room, a)
            _to_rates(-1.0, before, a)
    for part in range(size):
        a.exponents[part] = _exponent(part, speed, a)
    a.held[LENGTH_KNOWN] = a.held[DECAY_KNOWN] = math.nan


@njit(**MERGED)
def _to_rates(sign: float, speed: float, a: Any) -> None:
    """Add to the forces of the last step what the modes do by themselves, or take it away."""
    forces, amplitudes = data(a.forces_before), data(a.amplitudes_before)
    for mode in range(a.modes):
        one, other = 2 * mode * NODES, (2 * mode + 1) * NODES
        real, imaginary = sign * _exponent(2 * mode, speed, a), sign * _exponent(2 * mode + 1, speed, a)
        its, beside = load(amplitudes, one), load(amplitudes, other)
        store(load(forces, one) + its * real - beside * imaginary, forces, one)
        store(load(forces, other) + its * imaginary + beside * real, forces, other)


@njit(**MERGED)
def _changed(rows: Any, change: int, a: Any) -> None:
    """Rows of amplitudes in the new shapes."""
    size, numbers = 2 * a.modes, data(a.bases)
    first = change + size * size
    for i in range(size):
        total = all_lanes(0.0)
        for j in range(size):
            total += load(rows, j * NODES) * numbers[change + i * size + j]
        store(total, numbers, first + i * NODES)
    for i in range(size):
        store(load(numbers, first + i * NODES), rows, i * NODES)
