"""Growth rates of balanced planar rotors on orthotropic supports, at many speeds at once.

Where races are on the axis a balanced rotor rests and its balls stand still, so that nothing but the supports repeats with
every half turn of the rotor. In its frame, with the means k, b of stiffness and damping and half the differences D, d (y less
x), the equations are those of :mod:`autobalancer.stability.states.linear` for k and b, and on the rotor acts

    e^(-2 i theta) [D conj Q + d (conj Q' - i W conj Q)].

The map over half a turn is integrated by the Gauss method of four stages (order eight) in equal steps, at all speeds together.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from autobalancer.patience import still_time
from autobalancer.stability.host.cycle import gauss
from autobalancer.stability.host.planar import Floats, Matrix, Plane

LEAST, UNIT = 16, 8  # steps in half a turn: at least, and in multiples of
PER_PERIOD = 12  # steps in a period of the fastest motion of the rotor, seen from the rotor
AT_ONCE = 30_000  # numbers in memory: more do not fit the cache of a processor

SIDES = np.array(
    [[[1.0, 0.0], [0.0, -1.0]], [[0.0, -1.0], [-1.0, 0.0]]]
)  # of cos 2 theta, sin 2 theta: e^(-2 i theta) conj Q
ACROSS = np.array([[[0.0, 1.0], [1.0, 0.0]], [[1.0, 0.0], [0.0, -1.0]]])  # times i


def growth_rates(p: Plane, speeds: Floats, angles: Matrix, neutral: NDArray[np.int64]) -> Floats:
    """Greatest real part at each speed, 1/s, of balanced states whose rotor rests.

    Parameters
    ----------
    p
        A planar rotor with races on the axis.
    speeds
        rad/s, (k,).
    angles
        Of the balls in the rotor, rad, (k, n).
    neutral
        How many roots are zero and do not count, (k,).
    """
    fastest = np.sqrt(max(p.stiffness) / p.mass) / speeds + 1.0  # in units of the speed
    steps = UNIT * np.ceil(np.maximum(LEAST, 0.5 * PER_PERIOD * fastest) / UNIT).astype(int)
    rates = np.empty(speeds.size)
    for count in np.unique(steps):
        places = np.flatnonzero(steps == count)
        width = max(1, AT_ONCE // (int(count) * (4 * (2 + p.moment.size)) ** 2))
        for part in np.split(places, range(width, places.size, width)):
            still_time()
            half = half_turns(p, speeds[part], angles[part], int(count))
            rates[part] = _greatest(half, speeds[part], neutral[part])
    return rates


def half_turns(p: Plane, speeds: Floats, angles: Matrix, steps: int) -> Matrix:
    """Maps of small motions (X, Y, phi, X', Y', phi') over half a turn, in the frame of the rotor, (k, 4 + 2n, 4 + 2n).

    Stages are solved for accelerations only, which positions and speeds follow from.
    """
    nodes, weights, inner = gauss()
    k, size, h = speeds.size, 2 + p.moment.size, (np.pi / steps / speeds)[:, None, None, None]
    held, slowed = _accelerations(p, speeds, angles)
    theta = np.pi / steps * (np.arange(steps)[:, None] + nodes)
    waves = np.stack([np.ones_like(theta), np.cos(2.0 * theta), np.sin(2.0 * theta)], axis=-1)  # (steps, 4, 3)
    parts = np.concatenate(
        [(inner @ inner)[:, :, None] * waves[:, :, None], inner[:, :, None] * waves[:, :, None]], axis=-1
    )
    blocks = parts.reshape(-1, 6) @ np.concatenate([-h * h * held, -h * slowed], axis=1).reshape(k, 6, -1)
    left = blocks.reshape(k, steps, 4, 4, size, size).swapaxes(3, 4).reshape(k, steps, 4 * size, 4 * size)
    left[:, :, range(4 * size), range(4 * size)] += 1.0
    at_start = (waves.reshape(-1, 3) @ one.reshape(k, 3, -1) for one in (held, slowed))
    held, slowed = (one.reshape(k, steps, 4, size, size) for one in at_start)
    right = np.concatenate([held, slowed + h[..., None] * nodes[:, None, None] * held], axis=-1)
    found = np.linalg.solve(left, right.reshape(k, steps, 4 * size, 2 * size)).reshape(k, steps, 4, 2 * size * size)
    maps = np.zeros((k, steps, 2 * size, 2 * size)) + np.eye(2 * size)
    maps[:, :, range(size), range(size, 2 * size)] = h[..., 0]
    maps[:, :, :size] += h * h * (weights @ inner @ found).reshape(k, steps, size, 2 * size)
    maps[:, :, size:] += h * (weights @ found).reshape(k, steps, size, 2 * size)
    while maps.shape[1] > 1:
        odd = maps[:, -1:] if maps.shape[1] % 2 else maps[:, :0]
        maps = np.concatenate([maps[:, 1::2] @ maps[:, : maps.shape[1] // 2 * 2 : 2], odd], axis=1)
    return np.asarray(maps[:, 0])


def _greatest(half: Matrix, speeds: Floats, neutral: NDArray[np.int64]) -> Floats:
    with np.errstate(divide="ignore"):  # a motion that dies out at once
        values = np.log(np.linalg.eigvals(half).astype(np.complex128))
    order = np.argsort(np.abs(values), axis=1)
    counted = np.take_along_axis(values.real, order, axis=1)
    counted[np.arange(half.shape[1]) < neutral[:, None]] = -np.inf
    return np.asarray(counted.max(axis=1) * speeds / np.pi)


def _accelerations(p: Plane, speeds: Floats, angles: Matrix) -> Matrix:
    """Of positions and of speeds: constant, with cos 2 theta and with sin 2 theta, (2, k, 3, 2 + n, 2 + n)."""
    k, n = angles.shape
    size, w = 2 + n, speeds[:, None, None]
    (kx, ky), (bx, by) = p.stiffness, p.damping
    stiffness, damping, uneven, drift = 0.5 * (kx + ky), 0.5 * (bx + by), 0.5 * (ky - kx), 0.5 * (by - bx)
    turned = np.array([[0.0, -1.0], [1.0, 0.0]])
    radial = np.stack([p.moment * np.cos(angles), p.moment * np.sin(angles)], axis=1)  # (k, 2, n)
    tangent = turned @ radial
    mass = np.zeros((k, size, size))
    mass[:, :2, :2], mass[:, 2:, 2:] = p.mass * np.eye(2), np.diag(p.inertia)
    mass[:, :2, 2:], mass[:, 2:, :2] = tangent, tangent.transpose(0, 2, 1)
    force = np.zeros((k, size, 2 * size, 3))  # constant, with cos 2 theta, with sin 2 theta
    held, slowed = force[:, :, :size], force[:, :, size:]
    held[:, :2, :2, 0] = -(stiffness - p.mass * w * w) * np.eye(2) - w * damping * turned
    held[:, :2, 2:, 0], held[:, 2:, :2, 0] = w * w * tangent, w * w * tangent.transpose(0, 2, 1)
    slowed[:, :2, :2, 0] = -damping * np.eye(2) - 2.0 * w * p.mass * turned
    slowed[:, :2, 2:, 0], slowed[:, 2:, :2, 0] = 2.0 * w * radial, -2.0 * w * radial.transpose(0, 2, 1)
    slowed[:, 2:, 2:, 0] = -np.diag(p.drag)
    for wave, (side, across) in enumerate(zip(SIDES, ACROSS, strict=True), 1):
        held[:, :2, :2, wave] = uneven * side - w * drift * across
        slowed[:, :2, :2, wave] = drift * side
    moved = np.linalg.solve(mass, force.reshape(k, size, -1)).reshape(k, size, 2, size, 3)
    return np.asarray(moved.transpose(2, 0, 4, 1, 3))
