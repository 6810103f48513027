"""Bearings that become stiffer as they deflect, as the numbers of kernels/host/hardening.py, and their forces in a run."""

from __future__ import annotations

import numpy as np

from autobalancer.assembly.host import padded_size
from autobalancer.assembly.rotors.hardening import central_force, hardenings
from autobalancer.assembly.rotors.model import Matrix
from autobalancer.assembly.spatial import Parts
from autobalancer.kernels.records.hardening import HARDENING
from autobalancer.kernels.system import Bearings
from autobalancer.machine import Hardening, Machine


def bearings_of(parts: Parts) -> Bearings:
    """All of them, over the coordinates of a run."""
    width, count = padded_size(parts.size), len(parts.hard)
    springs, rows = HARDENING.rows(count), np.zeros((2 * count, width))
    pieces = [np.zeros((0, 5))]
    for i, (one, place) in enumerate(zip(springs, parts.hard, strict=True)):
        rows[2 * i : 2 * i + 2, : parts.size] = place.rows @ parts.reduction.basis
        law = central_force(place.hardening)
        one.cubic, one.contact, one.clearance = law.cubic, law.contact, law.clearance
        one.center_x, one.center_y = place.hardening.center
        one.rest_x, one.rest_y = hardening_force(place.hardening, np.zeros((1, 2)))[0]
        one.first, one.pieces = sum(map(len, pieces)), len(law.pieces)
        pieces.append(law.pieces)
    reach = np.zeros_like(rows)
    reach[:, : parts.size] = rows[:, : parts.size] @ np.linalg.inv(parts.mass)
    return Bearings(springs, rows, reach, np.vstack(pieces))


def hardening_force(hardening: Hardening, moved: Matrix) -> Matrix:
    """Force of the rotor on the bearing at deflections (T, 2) from where it rests, that at rest included; (T, 2) N."""
    way = moved - np.array(hardening.center, float)
    distance = np.hypot(way[:, 0], way[:, 1])
    size = central_force(hardening).force(distance)
    return np.asarray(way * (size / np.where(distance > 0.0, distance, 1.0))[:, None])


def has_hardening(machine: Machine) -> bool:
    """Whether any bearing of a machine becomes stiffer as it deflects."""
    return any(True for _ in hardenings(machine))


def off_middle(machine: Machine) -> bool:
    """Whether a rotor rests beside the middle of such a bearing, so that directions differ."""
    return any(hardening.center != (0.0, 0.0) for *_, hardening in hardenings(machine))
