"""A rotor with stations as the numbers of kernels/host/linear.py."""

from __future__ import annotations

import numpy as np

from autobalancer.assembly.profile import unbalance_factor
from autobalancer.assembly.rotors.model import Floats, LateralModel, Matrix
from autobalancer.assembly.spatial import Parts
from autobalancer.kernels.lanes import LANES
from autobalancer.kernels.system import Host, Work
from autobalancer.machine import Machine
from autobalancer.remembered import remembered


def host_of(machine: Machine, parts: Parts, starts: Floats) -> tuple[Host, Work]:
    """The rotor of a machine, and room for its work; ``starts`` are those of the segments of its drive."""
    width, count = padded_size(parts.size), parts.places.shape[0]
    each = 4 if machine.tilting_races == "full" else 2
    inverse, matrices = _matrices(parts.sliding, parts.reduction.basis, parts.mass, parts.places, parts.slopes, each)
    host = Host(
        size=parts.size,
        width=width,
        stations=count,
        axial_gravity=axial_gravity(machine),
        loads=loads_of(machine, parts, inverse, starts, width),
        **matrices,
    )
    return host, _work(width, count * each, each)


@remembered(8)
def _matrices(
    model: LateralModel, basis: Matrix, mass: Matrix, places: Matrix, slopes: Matrix, each: int
) -> tuple[Matrix, dict[str, Matrix]]:
    """The inverse of the mass, and the matrices of a rotor with ``each`` rows at a station."""
    size, width = mass.shape[0], padded_size(mass.shape[0])
    inverse: Matrix = np.asarray(np.linalg.inv(mass), np.float64)
    stations = zip(places, slopes, strict=True)
    rows = np.concatenate([np.zeros((0, size)), *(np.concatenate(both[: each // 2]) for both in stations)])
    gyroscopic = basis.T @ model.gyroscopic @ basis

    def columns(matrix: Matrix) -> Matrix:
        return _wide(matrix.T, (width, width))  # row j is column j of the matrix

    return inverse, {
        "speeds": np.array(model.speeds, np.float64),
        "gyroscopic": columns(inverse @ gyroscopic),
        "damping": np.array([columns(inverse @ (basis.T @ c @ basis)) for c in model.damping]),
        "stiffness": np.array([columns(inverse @ (basis.T @ k @ basis)) for k in model.stiffness]),
        "spin": columns(0.5 * gyroscopic),
        "rows": _wide(rows, (places.shape[0] * each, width)),
        "reach": _wide(rows @ inverse, (places.shape[0] * each, width)),
        "mobility": np.ascontiguousarray(rows @ inverse @ rows.T),
    }


def _work(width: int, rows: int, each: int) -> Work:
    q, v, f, g, own = (np.zeros(width) for _ in range(5))
    one, two, push, arm, turn = (np.zeros(rows) for _ in range(5))
    return Work(q, v, f, g, own, np.zeros((rows, rows)), one, two, push, arm, turn, np.zeros((rows, each)))


def _wide(matrix: Matrix, shape: tuple[int, int]) -> Matrix:
    """With zeros around."""
    wide = np.zeros(shape)
    wide[: matrix.shape[0], : matrix.shape[1]] = matrix
    return wide


def axial_gravity(machine: Machine) -> float:
    """Acceleration along +z of a machine with a vertical axis; z points up unless its rotor says the contrary."""
    if machine.axis == "horizontal":
        return 0.0
    return float(machine.gravity) if getattr(machine.rotor, "up", None) == "-z" else -float(machine.gravity)


def loads_of(machine: Machine, parts: Parts, inverse: Matrix, starts: Floats, width: int) -> Matrix:
    """Of each segment of time: M^-1 u and u, real and imaginary parts, then the rates of these four; (segments, 8, W)."""
    loads = np.zeros((starts.size, 8, width))
    for number, start in enumerate(starts):
        now, rate = np.zeros((2, parts.size), np.complex128)
        for shape, unbalance in zip(parts.shapes, machine.unbalances, strict=True):
            factor = unbalance_factor(unbalance, float(start))
            now = now + factor * shape
            if number + 1 < starts.size:
                late = unbalance_factor(unbalance, float(starts[number + 1]), before=True)
                rate = rate + (late - factor) / (starts[number + 1] - start) * shape
        # the kernel takes Re(u e^(i theta)) as real part times cosine less imaginary part times sine
        vectors = [
            part for load in (now, rate) for vector in (inverse @ load, load) for part in (vector.real, vector.imag)
        ]
        loads[number, :, : parts.size] = vectors
    return loads


def padded_size(size: int) -> int:
    """Coordinates in whole lanes."""
    return size + (-size % LANES)
