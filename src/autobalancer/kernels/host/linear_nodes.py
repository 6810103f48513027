"""A linear rotor at all nodes of a long step: what kernels/host/linear.py works out at one instant, as forces on its modes.

The motion s = (q, v) comes as amplitudes p of the modes at a speed w_b, a *basis*; there are several. With Z = M^-1 G

    s = P p,    q'' = A p + f,    f = loads + stations - (w - w_b) Z v - w' Z q / 2,
    p' = (exponent + (w0 - w_b) drift - i turning w0) p + force,
    force = P^-1 (0, f) - (w0 - w_b) drift p - i turning (w - w0) p

where the drift of an exponent is what it gains per speed to first order, and w0 the frozen speed.
"""

from __future__ import annotations

from typing import Any

from autobalancer.kernels.balls.planar_nodes import motion_at_nodes, unbalance_at_nodes
from autobalancer.kernels.compiler.flags import MERGED, njit
from autobalancer.kernels.compiler.numba_struct import data
from autobalancer.kernels.compiler.simd import NODES, all_lanes, load, root, store
from autobalancer.kernels.host.external_forces import tabled
from autobalancer.kernels.host.linear import Motion
from autobalancer.kernels.integrators.collocation import FROZEN, OF_EXPONENTS, OF_SPEED, basis_at
from autobalancer.kernels.records import PRESCRIBED
from autobalancer.kernels.trigonometry import sine_cosine_of_lanes

GYRATES = 0  # place in Amplitudes.numbers: whether there is any gyroscopic force
ROOM = 8  # where the room for work begins: rows of lanes, one for each coordinate
# coordinates, velocities, f, A p, what w' takes from f and from the torque; exponents times amplitudes (two for each); then those
# of the stations
Q, V, F, LINEAR, G, OWN_G, DRIVEN, PARTS = 0, 1, 2, 3, 4, 5, 6, 8


KEPT = 18  # rows of a ball, balls/contact_nodes.py


def room(size: int, rows: int, each: int, balls: int) -> int:
    """Length of ``numbers`` for so many coordinates, rows of stations, and balls."""
    return ROOM + NODES * (PARTS * size + rows * (5 + each + rows) + KEPT * balls)


@njit(**MERGED)
def times(matrix: Any, first: int, rows: Any, place: int, count: int) -> Any:
    """Neighboring numbers times neighboring rows of lanes."""
    even, odd = all_lanes(0.0), all_lanes(0.0)
    for j in range(0, count - 1, 2):
        even += load(rows, place + j * NODES) * matrix[first + j]
        odd += load(rows, place + (j + 1) * NODES) * matrix[first + j + 1]
    if count % 2 == 1:
        even += load(rows, place + (count - 1) * NODES) * matrix[first + count - 1]
    return even + odd


@njit(**MERGED)
def solve_free_at_nodes(time: float, step: float, tilting: bool, p: Any, a: Any) -> Motion:
    """The rotor without its balls, and the stations' zeros."""
    h, numbers, values = p.host, data(a.numbers), data(a.values)
    size, width, rank, room = h.size, h.width, 2 * a.modes, ROOM
    loads, row = data(h.loads), NODES * size
    motion, free = motion_at_nodes(time, step, p, a), p.drive.kind != PRESCRIBED
    speed, acceleration, turn_sin, turn_cos = motion.speed, motion.acceleration, motion.sine, motion.cosine

    # the modes do the linear motion by themselves; only what drives them is a force
    segment = p.drive.segments[p.drive.now[0]]
    its = 8 * width * p.drive.now[0]
    since = load(data(a.radau.nodes), 0) * step + (time - segment.start)
    turning = speed * speed
    real, imaginary = turning * turn_cos + acceleration * turn_sin, acceleration * turn_cos - turning * turn_sin
    shapes, bases, basis = data(a.shapes), data(a.bases), basis_at(a)
    for mode in range(a.modes):
        its_real, its_imaginary = load(values, 2 * mode * NODES), load(values, (2 * mode + 1) * NODES)
        decay, pace = bases[basis + OF_EXPONENTS + 2 * mode], bases[basis + OF_EXPONENTS + 2 * mode + 1]
        store(its_real * decay - its_imaginary * pace, numbers, room + DRIVEN * row + 2 * mode * NODES)
        store(its_real * pace + its_imaginary * decay, numbers, room + DRIVEN * row + (2 * mode + 1) * NODES)
    for i in range(size):
        driven = times(shapes, (size + i) * rank, numbers, room + DRIVEN * row, rank)
        store(driven, numbers, room + LINEAR * row + i * NODES)
        force = real * loads[its + i] + imaginary * loads[its + width + i]
        if segment.changing != 0:
            force += (real * loads[its + 4 * width + i] + imaginary * loads[its + 5 * width + i]) * since
        store(force, numbers, room + F * row + i * NODES)
    # gyroscopic forces beyond those of the basis, where the speed is another one
    gyrates = numbers[GYRATES] != 0.0
    if gyrates or tilting:
        for i in range(2 * size):
            store(times(shapes, i * rank, values, 0, rank), numbers, room + Q * row + i * NODES)
    if gyrates:
        _gyrate(speed - bases[basis + OF_SPEED], acceleration * 0.5, p, a)
    # the column of w', and the torque on the rotor, where its speed is free
    if free:
        for i in range(size):
            arm = -turn_sin * (loads[its + i] + since * loads[its + 4 * width + i])
            arm -= turn_cos * (loads[its + width + i] + since * loads[its + 5 * width + i])
            own = -turn_sin * (loads[its + 2 * width + i] + since * loads[its + 6 * width + i])
            own -= turn_cos * (loads[its + 3 * width + i] + since * loads[its + 7 * width + i])
            if gyrates:
                gyroscopic, spin = data(h.gyroscopic), data(h.spin)
                for j in range(size):
                    q = load(numbers, room + Q * row + j * NODES)
                    arm += q * (0.5 * gyroscopic[j * width + i])
                    own += q * spin[j * width + i]
            store(arm, numbers, room + G * row + i * NODES)
            store(own, numbers, room + OWN_G * row + i * NODES)
    stations = p.work.push.shape[0]
    for i in range(stations * (3 + p.work.inert.shape[1])):
        store(all_lanes(0.0), numbers, room + PARTS * row + i * NODES)
    return motion


@njit(**MERGED)
def _gyrate(ahead: Any, half: Any, p: Any, a: Any) -> None:
    """Put into f what the speed differs from that of the basis, and what its rate does."""
    numbers, gyroscopic, size, width = data(a.numbers), data(p.host.gyroscopic), p.host.size, p.host.width
    row, room = NODES * size, ROOM
    for j in range(size):
        place = room + j * NODES
        mixed = ahead * load(numbers, place + V * row) + half * load(numbers, place + Q * row)
        store(mixed, numbers, place + G * row)
    for i in range(size):
        force = load(numbers, room + F * row + i * NODES)
        for j in range(size):
            force -= load(numbers, room + G * row + j * NODES) * gyroscopic[j * width + i]
        store(force, numbers, room + F * row + i * NODES)


@njit(**MERGED)
def solve_coupled_at_nodes(acceleration: Any, torque: Any, inertia: Any, p: Any, a: Any) -> Any:
    """Accelerations of the stations in place of their right-hand sides, and f of all; returns w'."""
    h, numbers = p.host, data(a.numbers)
    size, width, places, rows, each = h.size, h.width, h.stations, h.rows.shape[0], p.work.inert.shape[1]
    row, room = NODES * size, ROOM
    push = room + PARTS * row
    arms, turns, own = push + NODES * rows, push + 2 * NODES * rows, push + 3 * NODES * rows
    one = own + NODES * rows * each
    two, left = one + NODES * rows, one + 2 * NODES * rows
    f, linear, g, own_g = room + F * row, room + LINEAR * row, room + G * row, room + OWN_G * row
    place, mobility, reach = data(h.rows), data(h.mobility), data(h.reach)
    # accelerations of the stations: what the balls pull there depends on them, so a small system for each node
    free = p.drive.kind != PRESCRIBED
    for i in range(rows):
        felt = times(place, i * width, numbers, linear, size) + times(place, i * width, numbers, f, size)
        store(felt + times(mobility, i * rows, numbers, push, rows), numbers, one + i * NODES)
        if free:
            felt = times(place, i * width, numbers, g, size) + times(mobility, i * rows, numbers, arms, rows)
            store(felt, numbers, two + i * NODES)
        for other in range(places):
            for j in range(each):
                total = all_lanes(0.0)
                for k in range(each):
                    inert = load(numbers, own + ((other * each + k) * each + j) * NODES)
                    total += inert * mobility[i * rows + other * each + k]
                if i == other * each + j:
                    total += 1.0
                store(total, numbers, left + (i * rows + other * each + j) * NODES)
    _solve(numbers, left, one, two, rows, free)

    # forces on the stations, put into the rotor
    for i in range(rows):
        first = (i // each) * each
        back, back_arm = load(numbers, push + i * NODES), load(numbers, arms + i * NODES)
        for j in range(each):
            inert = load(numbers, own + (i * each + j) * NODES)
            back -= inert * load(numbers, one + (first + j) * NODES)
            if free:
                back_arm -= inert * load(numbers, two + (first + j) * NODES)
        store(back, numbers, push + i * NODES)
        if free:
            turn = load(numbers, turns + i * NODES)
            torque -= turn * load(numbers, one + i * NODES)
            inertia -= turn * load(numbers, two + i * NODES)
            store(back_arm, numbers, arms + i * NODES)
    for i in range(size):
        force, arm = load(numbers, f + i * NODES), load(numbers, g + i * NODES)
        for j in range(rows):
            force += load(numbers, push + j * NODES) * reach[j * width + i]
            if free:
                arm += load(numbers, arms + j * NODES) * reach[j * width + i]
        store(force, numbers, f + i * NODES)
        if free:
            mine = load(numbers, own_g + i * NODES)
            torque -= mine * (force + load(numbers, linear + i * NODES))
            inertia -= mine * arm
            store(arm, numbers, g + i * NODES)
    # last w', to which all is linear
    if free:
        acceleration = torque / inertia
        for i in range(size):
            store(load(numbers, f + i * NODES) - acceleration * load(numbers, g + i * NODES), numbers, f + i * NODES)
        for i in range(rows):
            found = load(numbers, one + i * NODES) - acceleration * load(numbers, two + i * NODES)
            store(found, numbers, one + i * NODES)
    return acceleration


@njit(**MERGED)
def _solve(numbers: Any, left: int, one: int, two: int, size: int, both: bool) -> None:
    """Gauss elimination with one or both right-hand sides, without a search for pivots: what balls add to 1 is small."""
    for k in range(size):
        # clear the column below; the inverse of the pivot is kept in its place
        inverse = 1.0 / load(numbers, left + (k * size + k) * NODES)
        store(inverse, numbers, left + (k * size + k) * NODES)
        for i in range(k + 1, size):
            factor = load(numbers, left + (i * size + k) * NODES) * inverse
            for j in range(k + 1, size):
                at = left + (i * size + j) * NODES
                store(load(numbers, at) - factor * load(numbers, left + (k * size + j) * NODES), numbers, at)
            store(load(numbers, one + i * NODES) - factor * load(numbers, one + k * NODES), numbers, one + i * NODES)
            if both:
                store(
                    load(numbers, two + i * NODES) - factor * load(numbers, two + k * NODES), numbers, two + i * NODES
                )
    # back substitution
    for k in range(size - 1, -1, -1):
        inverse = load(numbers, left + (k * size + k) * NODES)
        first, second = load(numbers, one + k * NODES), load(numbers, two + k * NODES)
        for j in range(k + 1, size):
            its = load(numbers, left + (k * size + j) * NODES)
            first -= its * load(numbers, one + j * NODES)
            if both:
                second -= its * load(numbers, two + j * NODES)
        store(first * inverse, numbers, one + k * NODES)
        if both:
            store(second * inverse, numbers, two + k * NODES)


@njit(**MERGED)
def write_forces(speed: Any, acceleration: Any, p: Any, a: Any) -> None:
    """The forces on the modes, and the acceleration of the rotor."""
    numbers, values, forces, inverse, bases = (
        data(a.numbers),
        data(a.values),
        data(a.forces),
        data(a.inverse),
        data(a.bases),
    )
    size, rank, room, basis = p.host.size, 2 * a.modes, ROOM, basis_at(a)
    frozen, drift = a.held[FROZEN], basis + OF_EXPONENTS + rank
    # the modes are those of the basis, corrected to first order for the frozen speed; the rest is a force
    shift = frozen - bases[basis + OF_SPEED]
    ahead = speed - frozen if p.rotating == 1 else all_lanes(0.0)
    f = room + F * NODES * size
    # forces in modes, less the drift already in the exponent, less the turning of the axes ahead of the frozen speed
    for mode in range(a.modes):
        real, imaginary = load(values, 2 * mode * NODES), load(values, (2 * mode + 1) * NODES)
        gain, turn = shift * bases[drift + 2 * mode], shift * bases[drift + 2 * mode + 1]
        turned = ahead + turn
        at = 2 * mode * 2 * size + size
        store(times(inverse, at, numbers, f, size) - real * gain + imaginary * turned, forces, 2 * mode * NODES)
        at += 2 * size
        store(times(inverse, at, numbers, f, size) - imaginary * gain - real * turned, forces, (2 * mode + 1) * NODES)
    store(acceleration, forces, rank * NODES)


# What acts on a linear rotor besides its unbalance and its balls, at all nodes of a long step: kernels/host/external_forces.py.
#
# Without records of excitations, stops of bearings and rubber.


@njit(**MERGED)
def external_forces_at_nodes(time: float, step: float, motion: Motion, p: Any, a: Any) -> Motion:
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
    """Bearings that become stiffer as they deflect, kernels/host/external_forces.py."""
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
    """Motion of the base, and forces on the rotor, kernels/host/external_forces.py."""
    passed = load(data(a.radau.nodes), 0) * step
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
                ux, uy = unbalance_at_nodes(time, step, p, a)
                torque += (motion.sine * ux + motion.cosine * uy) * along_x
                torque -= (motion.cosine * ux - motion.sine * uy) * along_y
    return Motion(motion.speed, motion.acceleration, motion.sine, motion.cosine, gx, gy, torque)
