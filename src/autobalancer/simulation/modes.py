"""The modes of a linear rotor with stations, as the numbers of its long steps."""

from __future__ import annotations

import numpy as np

from autobalancer.assembly.rotors.model import Complexes, Floats, Matrix
from autobalancer.kernels.host.linear_nodes import room
from autobalancer.kernels.integrators.collocation.amplitudes import Amplitudes, amplitudes
from autobalancer.kernels.integrators.collocation.bases import room_of_change
from autobalancer.kernels.records.drive import HILL, PRESCRIBED
from autobalancer.kernels.system import BALLS, SPEED, VX, VY, Drive, System, X, Y
from autobalancer.remembered import remembered

BASES = 32  # speeds at which the modes of a rotor with gyroscopic forces are worked out
SMALL_ROTOR = 12  # coordinates; a larger rotor has fewer bases
FEW_BASES = 12
ILL = 1e6  # condition of the shapes beyond which modes are no coordinates: two of them are nearly the same
FURTHER = (
    3.0  # times the highest critical speed, up to which bases reach where the drive does not say how fast it turns
)


def rotor_modes(
    system: System, state: Floats, critical_speeds: tuple[float, ...], near: float | None = None
) -> Amplitudes | None:
    """The modes of a rotor; None if they cannot carry its motion. They are those ``near`` a speed, or all that a drive asks for.

    On axes that turn with the rotor a mode is a whirl, forward or backward, and may decay as fast as it will. In axes at rest it
    is a vibration; there a rotor that creeps back without vibrating has too few of them.
    """
    h, n = system.host, system.ball_count
    stiffness, damping = (one[0, : h.size, : h.size].T for one in (h.stiffness, h.damping))
    gyroscopic = h.gyroscopic[: h.size, : h.size].T
    speeds = np.zeros(1)
    if gyroscopic.any() and near is not None:
        speeds = np.array([near])
    elif gyroscopic.any():
        low, high = _reach(system.drive, state[SPEED], critical_speeds)
        speeds = np.linspace(low, high, BASES if h.size <= SMALL_ROTOR else FEW_BASES)
    found = _bases(stiffness, damping, gyroscopic, speeds, bool(system.rotating))
    if found is None:
        return None
    rest = BALLS + 2 * n
    rows, each = system.work.inert.shape
    numbers = np.zeros(room(h.size, rows, each, n))
    numbers[0] = float(gyroscopic.any())
    exponents, shapes = found[0, 1 : 1 + 2 * h.size], found[0, 1 + 4 * h.size :][: 4 * h.size**2]
    return amplitudes(
        exponents[0::2] + 1j * exponents[1::2],
        shapes.reshape(2 * h.size, 2 * h.size),
        np.array([X, Y, *range(rest, rest + h.size - 2), VX, VY, *range(rest + h.size - 2, rest + 2 * h.size - 4)]),
        n,
        numbers,
        state.size,
        turning=bool(system.rotating),
        bases=np.concatenate([found.ravel(), np.zeros(room_of_change(h.size))]),
    )


def _reach(drive: Drive, start: float, critical_speeds: tuple[float, ...]) -> tuple[float, float]:
    """The least and the greatest speed of the bases."""
    speeds = [0.0, float(start)]
    if drive.kind == PRESCRIBED:
        ends = np.append(drive.segments.start[1:], drive.segments.start[-1:])
        for segment, end in zip(drive.segments, ends, strict=True):
            its = segment.end if segment.kind == HILL else segment.value + (end - segment.start) * segment.rate
            speeds += [float(segment.value), float(segment.begin), float(its)]
    else:
        speeds += [FURTHER * max(critical_speeds, default=100.0), drive.synchronous_speed, *drive.table[:, 0].tolist()]
    return min(speeds), max(*speeds, min(speeds) + 1.0)


@remembered(8, by=lambda *given: tuple(one.tobytes() if isinstance(one, np.ndarray) else one for one in given))
def _bases(stiffness: Matrix, damping: Matrix, gyroscopic: Matrix, speeds: Floats, turning: bool) -> Matrix | None:
    """For each speed the exponents, what they gain per speed, shapes and their inverse, of M^-1 K, M^-1 C and M^-1 G."""
    size = stiffness.shape[0]
    parts = [_complex(one) if turning else one for one in (stiffness, damping, gyroscopic)]
    order, count = parts[0].shape[0], speeds.size
    whole = np.zeros((count, 2 * order, 2 * order), parts[0].dtype)
    whole[:, :order, order:] = np.eye(order)
    whole[:, order:, :order] = -parts[0]
    whole[:, order:, order:] = -parts[1] - speeds[:, None, None] * parts[2]
    exponents, shapes = np.linalg.eig(whole)
    kept = np.ones(exponents.shape, np.bool_) if turning else exponents.imag > 0.0
    if (kept.sum(axis=1) != size).any() or not _apart(shapes, exponents):
        return None
    inverse = np.linalg.inv(shapes)
    drifts = -np.einsum("tkj,jl,tlk->tk", inverse[:, :, order:], parts[2], shapes[:, order:])
    one: Complexes = shapes.swapaxes(1, 2)[kept].reshape(count, size, 2 * order).swapaxes(1, 2)
    other: Complexes = inverse[kept].reshape(count, size, 2 * order)
    if turning:
        matrices = _turning(one), _turning(other)
    else:
        matrices = _resting(np.asarray(2.0 * one)), _resting(other.conj().swapaxes(1, 2)).swapaxes(1, 2)
    drawn = (_pairs(numbers[kept].reshape(count, size)) for numbers in (exponents, drifts))
    return np.hstack([speeds[:, None], *drawn, *(matrix.reshape(count, -1) for matrix in matrices)])


def _apart(shapes: Complexes, exponents: Complexes) -> bool:
    """Whether modes differ enough to be coordinates; velocities count in the fastest mode's amplitude."""
    order = shapes.shape[1] // 2
    scaled = shapes.copy()
    scaled[:, order:] /= np.abs(exponents).max() + 1e-300
    scaled /= np.linalg.norm(scaled, axis=1, keepdims=True)
    return bool(np.isfinite(scaled).all() and (np.linalg.cond(scaled) < ILL).all())


def _complex(matrix: Matrix) -> Complexes:
    """A matrix of an isotropic rotor over x + i y."""
    return np.asarray(matrix[0::2, 0::2] + 1j * matrix[1::2, 0::2], np.complex128)


def _pairs(numbers: Complexes) -> Matrix:
    """Real and imaginary parts, alternating along the last axis."""
    return np.ascontiguousarray(numbers).view(np.float64)


def _turning(matrices: Complexes) -> Matrix:
    """Complex matrices over real and imaginary parts, alternating."""
    count, rows, columns = matrices.shape
    result = np.zeros((count, 2 * rows, 2 * columns))
    result[:, 0::2, 0::2] = result[:, 1::2, 1::2] = matrices.real
    result[:, 0::2, 1::2], result[:, 1::2, 0::2] = -matrices.imag, matrices.imag
    return result


def _resting(matrices: Complexes) -> Matrix:
    """The real part of complex matrices times amplitudes, over their real and imaginary parts, alternating."""
    count, rows, columns = matrices.shape
    result = np.zeros((count, rows, 2 * columns))
    result[:, :, 0::2], result[:, :, 1::2] = matrices.real, -matrices.imag
    return result
