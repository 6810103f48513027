"""What acts on a linear rotor besides its unbalance and its balls, at all nodes of a long step: kernels/host/acted.py.

Without records of excitations, stops of bearings and rubber.
"""

from __future__ import annotations

from typing import Any

from autobalancer.kernels.flags import MERGED, njit
from autobalancer.kernels.host.hardening import tabled
from autobalancer.kernels.host.linear import Motion
from autobalancer.kernels.host.linear_nodes import ROOM, F, Q, times
from autobalancer.kernels.pointers import data
from autobalancer.kernels.records.drive import PRESCRIBED
from autobalancer.kernels.trigonometry import sine_cosine_of_lanes
from autobalancer.kernels.wide import NODES, load, root, store


@njit(**MERGED)
def acted_at_nodes(time: float, step: float, motion: Motion, p: Any, a: Any) -> Motion:
    """Add to f the accelerations by excitations and bearings; returns the motion with gravity as felt on the base."""
    _harden(p, a)
    return _shaken(time, step, motion, p, a)


@njit(**MERGED)
def _push(along_x: Any, along_y: Any, vectors: Any, at: int, p: Any, a: Any) -> None:
    """Add two neighboring rows of vectors to f, so much of each."""
    numbers, size, width = data(a.numbers), p.host.size, p.host.width
    for i in range(size):
        place = ROOM + (F * size + i) * NODES
        force = along_x * vectors[at + i] + along_y * vectors[at + width + i]
        store(load(numbers, place) + force, numbers, place)


@njit(**MERGED)
def _harden(p: Any, a: Any) -> None:
    """Bearings that become stiffer as they deflect, kernels/host/hardening.py."""
    numbers, shapes, work, size, rank = data(a.numbers), data(a.shapes), data(a.work), p.host.size, 2 * a.modes
    rows, reach, tables = data(p.bearings.rows), data(p.bearings.reach), data(p.bearings.tables)
    q = ROOM + Q * NODES * size
    for b in range(p.bearings.springs.shape[0]):
        one, at = p.bearings.springs[b], 2 * b * p.host.width
        if b == 0:
            for i in range(size):
                store(times(shapes, i * rank, data(a.values), 0, rank), numbers, q + i * NODES)
        x = times(rows, at, numbers, q, size) - one.center_x
        y = times(rows, at + p.host.width, numbers, q, size) - one.center_y
        square = x * x + y * y
        rate = square * one.cubic
        if one.pieces > 0:
            store(root(square), work, 0)
            for i in range(NODES):
                work[NODES + i] = tabled(one, tables, work[i])
            rate += load(work, NODES)
        _push(one.rest_x - rate * x, one.rest_y - rate * y, reach, at, p, a)


@njit(**MERGED)
def _shaken(time: float, step: float, motion: Motion, p: Any, a: Any) -> Motion:
    """Motion of the base, and forces on the rotor, kernels/host/shaking.py."""
    segment, passed = p.drive.segments[p.drive.now[0]], load(data(a.radau.nodes), 0) * step
    gx, gy, torque = motion.gravity_x, motion.gravity_y, motion.torque
    for e in range(p.shakes.shape[0]):
        shake = p.shakes[e]
        turned = load(data(a.values), (2 * a.modes + 1) * NODES) if shake.by_angle == 1 else passed + time
        s, c = sine_cosine_of_lanes(turned * shake.frequency)
        along_x, along_y = c * shake.x_real - s * shake.x_imaginary, c * shake.y_real - s * shake.y_imaginary
        _push(along_x, along_y, data(p.shake_vectors), 2 * e * p.host.width, p, a)
        if shake.felt == 1:
            gx -= along_x
            gy -= along_y
            if p.drive.kind != PRESCRIBED:
                since = passed + (time - segment.start)
                ux = since * segment.unbalance_rate_x + segment.unbalance_x
                uy = since * segment.unbalance_rate_y + segment.unbalance_y
                torque += (motion.sine * ux + motion.cosine * uy) * along_x
                torque -= (motion.cosine * ux - motion.sine * uy) * along_y
    return Motion(motion.speed, motion.acceleration, motion.sine, motion.cosine, gx, gy, torque)
