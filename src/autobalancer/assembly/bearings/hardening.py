"""Bearings that become stiffer as they deflect, as the numbers of kernels/host/hardening.py, and their forces in a run."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from autobalancer.assembly.host import padded_size
from autobalancer.assembly.rotors.hardening import hardening_rows, hardenings
from autobalancer.assembly.rotors.model import Floats, Matrix
from autobalancer.assembly.spatial import Parts
from autobalancer.kernels.records.hardening import HARDENING
from autobalancer.kernels.system import Bearings
from autobalancer.machine import Hardening, Machine


def bearings_of(machine: Machine, parts: Parts) -> Bearings:
    """All of them, over the coordinates of a run."""
    found = [spring for _, spring in hardenings(machine)]
    width = padded_size(parts.size)
    springs, rows = HARDENING.rows(len(found)), np.zeros((2 * len(found), width))
    rows[:, : parts.size] = hardening_rows(machine, parts.model) @ parts.reduction.basis
    for one, spring in zip(springs, found, strict=True):
        one.cubic, one.contact = spring.cubic_stiffness, spring.contact_stiffness or 0.0
        one.clearance = spring.clearance or 0.0
        one.center_x, one.center_y = spring.center
        rest = central_force(spring, np.zeros(1), np.zeros(1))
        one.rest_x, one.rest_y = float(rest.real[0]), float(rest.imag[0])
    reach = np.zeros_like(rows)
    reach[:, : parts.size] = rows[:, : parts.size] @ np.linalg.inv(parts.mass)
    return Bearings(springs, rows, reach)


def central_force(spring: Hardening, x: Floats, y: Floats) -> np.ndarray:
    """Force of the rotor on the bearing at deflections, x + i y in N, that at rest included."""
    way = x - spring.center[0] + 1j * (y - spring.center[1])
    distance = np.abs(way)
    rate = spring.cubic_stiffness * distance**2
    if spring.clearance is not None and spring.contact_stiffness is not None:
        far = np.maximum(distance - spring.clearance, 0.0)
        rate = rate + spring.contact_stiffness * far / np.where(distance > 0.0, distance, 1.0)
    return np.asarray(rate * way)


def hardening_forces(machine: Machine, supports: int, rows: Matrix, q: Matrix) -> np.ndarray:
    """Force of the rotor on each support by its hardening, as far as it is not at rest, x + i y in N, (T, S).

    ``rows`` (2 bearings, R) give the deflections in the bearings for coordinates ``q`` (T, R).
    """
    total = np.zeros((q.shape[0], supports), np.complex128)
    for i, (support, spring) in enumerate(hardenings(machine)):
        x, y = q @ rows[2 * i], q @ rows[2 * i + 1]
        rest = central_force(spring, np.zeros(1), np.zeros(1))
        total[:, support] += central_force(spring, x, y) - rest
    return total


def has_hardening(machine: Machine) -> bool:
    """Whether any bearing of a machine becomes stiffer as it deflects."""
    return any(True for _ in hardenings(machine))


def off_center(machine: Machine) -> bool:
    """Whether a rotor rests beside the middle of such a bearing, so that directions differ."""
    return any(spring.center != (0.0, 0.0) for spring in _springs(machine))


def _springs(machine: Machine) -> Iterator[Hardening]:
    return (spring for _, spring in hardenings(machine))
