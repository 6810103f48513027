"""What is observed at places, supports and planes; first where a time or a speed is in a table."""

from __future__ import annotations

import math
from typing import Any

from numba import boolean, float64, int64, types, void

from autobalancer.kernels.compiler.flags import EXACT, EXACT_PART, INLINE, njit
from autobalancer.kernels.compiler.numba_struct import data, row
from autobalancer.kernels.host.external_forces import central
from autobalancer.kernels.measures.thresholds import SAME_MOTION
from autobalancer.kernels.measures.workspace import (
    PLANAR,
    RESOLVED,
    MeasureInputs,
    Workspace,
    complex_matrix_type,
    complexes_type,
    inputs_type,
    workspace_type,
)
from autobalancer.kernels.records import BALL_STATES, BALL_VX, BALL_VY, BALL_X, BALL_Y
from autobalancer.kernels.system import (
    BALLS,
    SPEED,
    THETA,
    VX,
    Floats,
    Matrix,
    System,
    X,
    matrix_type,
    system_type,
    vector_type,
)
from autobalancer.kernels.trigonometry import sine_cosine


@njit(int64(float64, system_type), **EXACT_PART)
def segment_at(time: float, p: System) -> int:
    """The stretch of drive and unbalance in force at a time, just after a jump."""
    segments, k = p.drive.segments, 0
    while k + 1 < segments.shape[0] and segments[k + 1].start <= time:
        k += 1
    return k


@njit(**INLINE)
def since(time: float, k: int, p: System) -> float:
    """Time since the begin of stretch k, s; 0 where no unbalance changes in it, so that time may be infinite."""
    return time - p.drive.segments[k].start if p.drive.segments[k].changing != 0 else 0.0


@njit(types.UniTuple(float64, 2)(float64, system_type), **EXACT_PART)
def unbalance_at(time: float, p: System) -> tuple[float, float]:
    """Resultant unbalance in the rotor at a time, just after a jump, kg m."""
    k = segment_at(time, p)
    own, now = p.drive.segments[k], since(time, k, p)
    return own.unbalance_x + now * own.unbalance_rate_x, own.unbalance_y + now * own.unbalance_rate_y


@njit(**INLINE)
def share_of(k: int, speeds: Any, speed: float) -> float:
    """Weight of speed k of a table at a speed: linear in between, constant outside."""
    last, at = speeds.size - 1, abs(speed)
    if last == 0:
        return 1.0
    if at <= speeds[k]:
        if k == 0 or at == speeds[k]:
            return 1.0
        return max(0.0, (at - speeds[k - 1]) / (speeds[k] - speeds[k - 1]))
    return 1.0 if k == last else max(0.0, (speeds[k + 1] - at) / (speeds[k + 1] - speeds[k]))


# Small complex equations: solved by elimination, or in the sense of least squares without what is nearly dependent.
#
# The matrix and its right-hand sides stand side by side in one array.


TURNS = 60  # of all pairs of columns, at most
SMALL = 1e-15  # relative: columns as good as perpendicular


@njit(**INLINE)
def square(z: complex) -> float:
    """The square of its size."""
    return z.real * z.real + z.imag * z.imag


@njit(boolean(complex_matrix_type, int64, int64), **EXACT_PART)
def solve(a: Any, size: int, right: int) -> bool:
    """Replace the ``right`` columns behind the matrix by the solutions; False where there are none."""
    for k in range(size):
        best = k
        for i in range(k + 1, size):
            if square(a[i, k]) > square(a[best, k]):
                best = i
        if not square(a[best, k]) > 0.0:
            return False
        if best != k:
            for j in range(k, size + right):
                a[k, j], a[best, j] = a[best, j], a[k, j]
        for i in range(k + 1, size):
            if a[i, k] != 0.0:
                share = a[i, k] / a[k, k]
                for j in range(k + 1, size + right):
                    a[i, j] -= share * a[k, j]
    for k in range(size - 1, -1, -1):
        for j in range(size, size + right):
            value = a[k, j]
            for i in range(k + 1, size):
                value -= a[k, i] * a[i, j]
            a[k, j] = value / a[k, k]
    return True


@njit(void(complex_matrix_type, int64, int64, int64, complex_matrix_type), **EXACT_PART)
def reduce(a: Any, rows: int, size: int, right: int, small: Any) -> None:
    """Bring a tall matrix with its right-hand sides to a square one of the same least squares, by Gram and Schmidt."""
    for k in range(size):
        # length of the column, which becomes a diagonal element
        total = 0.0
        for t in range(rows):
            total += square(a[t, k])
        length = math.sqrt(total)
        for i in range(k + 1, size):
            small[i, k] = 0.0
        small[k, k] = length
        for t in range(rows if length > 0.0 else 0):
            a[t, k] = a[t, k] / length
        # its share is taken out of all columns behind it
        for j in range(k + 1, size + right):
            share = complex(0.0, 0.0)
            for t in range(rows):
                share += a[t, k].conjugate() * a[t, j]
            small[k, j] = share
            for t in range(rows):
                a[t, j] -= share * a[t, k]


@njit(**INLINE)
def _perpendicular(a: Any, v: Any, i: int, j: int, rows: int, size: int) -> bool:
    """Turn two columns until they are perpendicular, the same turn in ``v``; whether they were so already."""
    # squares of both columns and their product, which is to vanish
    alpha, beta, gamma = 0.0, 0.0, complex(0.0, 0.0)
    for t in range(rows):
        alpha, beta = alpha + square(a[t, i]), beta + square(a[t, j])
        gamma += a[t, i].conjugate() * a[t, j]
    size_of = math.sqrt(square(gamma))
    if not size_of > SMALL * math.sqrt(alpha * beta):
        return True
    # the turn that does it (smaller angle of the two), and its phase, as numbers are complex
    phase = gamma / size_of
    zeta = (beta - alpha) / (2.0 * size_of)
    tangent = math.copysign(1.0, zeta) / (abs(zeta) + math.sqrt(1.0 + zeta * zeta))
    cosine = 1.0 / math.sqrt(1.0 + tangent * tangent)
    sine = cosine * tangent
    for t in range(rows):
        x, y = a[t, i], a[t, j] * phase.conjugate()
        a[t, i], a[t, j] = cosine * x - sine * y, sine * x + cosine * y
    for t in range(size):
        x, y = v[t, i], v[t, j] * phase.conjugate()
        v[t, i], v[t, j] = cosine * x - sine * y, sine * x + cosine * y
    return False


@njit(void(complex_matrix_type, int64, int64, types.float64, complex_matrix_type), **EXACT_PART)
def least_squares(a: Any, size: int, right: int, least: float, v: Any) -> None:
    """Replace the right-hand sides of a square matrix by the shortest solutions without singular values below ``least``.

    That is relative to the greatest. One-sided rotations of Jacobi make the columns perpendicular (Golub and Van Loan 2013,
    section 8.6); ``v`` is work.
    """
    # rotations of pairs of columns until all are perpendicular: then they are U S, and v is V
    for i in range(size):
        for j in range(size):
            v[i, j] = 1.0 if i == j else 0.0
    for _ in range(TURNS):
        done = True
        for i in range(size):
            for j in range(i + 1, size):
                done = _perpendicular(a, v, i, j, size, size) and done
        if done:
            break
    # the greatest singular value
    greatest = 0.0
    for k in range(size):
        total = 0.0
        for t in range(size):
            total += square(a[t, k])
        greatest = max(greatest, total)
    # each right-hand side: V S^-1 U^H without what is as good as zero
    for j in range(size, size + right):
        for k in range(size):
            total, share = 0.0, complex(0.0, 0.0)
            for t in range(size):
                total += square(a[t, k])
                share += a[t, k].conjugate() * a[t, j]
            v[k, size] = share / total if total > least * least * greatest else complex(0.0, 0.0)
        for t in range(size):
            value = complex(0.0, 0.0)
            for k in range(size):
                value += v[t, k] * v[k, size]
            v[t, size + 1] = value
        for t in range(size):
            a[t, j] = v[t, size + 1]


# What unbalance does at the planes and places of a machine at a steady speed w.
#
# (K + i w (C + w G) - w^2 M) q = w^2 u, deflections are Re(q e^(i theta))


LEAST = 1e-11  # relative: planes that can as good as not be told apart


@njit(**INLINE)
def _dynamic_stiffness(g: MeasureInputs, speed: float, d: Workspace) -> None:
    size, a = g.rows.shape[0], d.small
    for i in range(size):
        for j in range(size):
            a[i, j] = complex(-(speed * speed) * g.mass[i, j], speed * speed * g.gyroscopic[i, j])
    for k in range(g.model_speeds.size):
        share = share_of(k, g.model_speeds, speed)
        for i in range(size if share != 0.0 else 0):
            for j in range(size):
                a[i, j] += share * complex(g.model_stiffness[k, i, j], speed * g.model_damping[k, i, j])


@njit(**INLINE)
def _load(p: System, time: float, r: int) -> complex:
    """Entry r of the load of all unbalances."""
    k = segment_at(time, p)
    now = since(time, k, p)
    if p.host.size > 0:
        u = p.host.loads[k]
        return complex(u[2, r] + now * u[6, r], u[3, r] + now * u[7, r])
    own = p.drive.segments[k]
    x, y = own.unbalance_x + now * own.unbalance_rate_x, own.unbalance_y + now * own.unbalance_rate_y
    return complex(x, y) if r == 0 else complex(y, -x)


@njit(**INLINE)
def _weight(g: MeasureInputs, k: int, greatest: float) -> float:
    """Capability of a plane; a full race can balance nothing."""
    if g.capability[k] > 0.0:
        return g.capability[k]
    return 1e-6 * greatest if greatest > 0.0 else 1.0


@njit(void(system_type, inputs_type, types.float64, types.float64, workspace_type, complexes_type), **EXACT)
def plane_unbalances(p: System, g: MeasureInputs, time: float, speed: float, d: Workspace, wanted: Any) -> None:
    """The unbalance that the balls of each plane have to balance so that all planes rest, kg m in the rotor.

    It is what the unbalances do at the planes at this speed, put into these planes; on a planar rotor their sum. nan at a
    critical speed of an undamped rotor. Of many solutions it is the one that takes the least share of the capabilities.
    """
    size, planes, a = g.rows.shape[0], g.capability.size, d.small
    # a planar rotor feels the sum of all unbalances
    if g.scalars[PLANAR] != 0.0:
        for k in range(planes):
            wanted[k] = _load(p, time, 0)
        return
    # deflections by a unit force at each plane, and by the unbalances
    _dynamic_stiffness(g, speed, d)
    for r in range(size):
        for k in range(planes):  # forces of a unit vector that turns with the rotor
            a[r, size + k] = complex(g.rows[r, 2 * k], -g.rows[r, 2 * k + 1])
        a[r, size + planes] = _load(p, time, r)
    if not solve(a, size, planes + 1):
        for k in range(planes):
            wanted[k] = complex(math.nan, math.nan)
        return
    # how the planes move by forces in the planes; unknowns over their capability, so that the shortest answer is fair
    greatest, host = 0.0, d.columns
    for k in range(planes):
        greatest = max(greatest, g.capability[k])
    for k in range(planes):
        for j in range(planes + 1):
            value = complex(0.0, 0.0)
            for r in range(size):
                value += complex(g.rows[r, 2 * k], g.rows[r, 2 * k + 1]) * a[r, size + j]
            host[k, j] = 0.5 * value
    for k in range(planes):
        for j in range(planes):
            host[k, j] *= _weight(g, j, greatest)
    # what has to be in the planes so that they do not move
    least_squares(host, planes, 1, LEAST, a)
    for k in range(planes):
        wanted[k] = host[k, planes] * _weight(g, k, greatest)


@njit(**INLINE)
def _semi_major(x: complex, y: complex) -> float:
    """Greatest length of Re((x, y) e^(i theta))."""
    return 0.5 * (
        math.sqrt((x.real - y.imag) ** 2 + (x.imag + y.real) ** 2)
        + math.sqrt((x.real + y.imag) ** 2 + (x.imag - y.real) ** 2)
    )


@njit(void(system_type, inputs_type, types.float64, types.float64, workspace_type, vector_type, vector_type), **EXACT)
def observe_locked_balls(
    p: System, g: MeasureInputs, time: float, speed: float, d: Workspace, vibration: Floats, force: Floats
) -> None:
    """Greatest vibration of each place (m) and greatest vibrating force on each support (N) at a steady speed.

    The balls are spread evenly over their races and held, and nothing shakes the machine from outside. nan at a critical speed
    of an undamped rotor.
    """
    size, places, supports, a = g.rows.shape[0], g.rows.shape[1] // 2, g.weight.size // 2, d.small
    # the rotor with the balls' mass spread evenly, and the unbalance alone
    _dynamic_stiffness(g, speed, d)
    for r in range(size):
        a[r, size] = speed * speed * (_load(p, time, r) + complex(g.held_loads[0, r], g.held_loads[1, r]))
    if not solve(a, size, 1):
        for k in range(places):
            vibration[k] = math.nan
        for k in range(supports):
            force[k] = math.nan
        return
    # vibration: greatest length of the ellipse at each place
    for k in range(places):
        x, y = complex(0.0, 0.0), complex(0.0, 0.0)
        for r in range(size):
            x, y = x + g.rows[r, 2 * k] * a[r, size], y + g.rows[r, 2 * k + 1] * a[r, size]
        vibration[k] = _semi_major(x, y)
    # force on each support: its springs and dampers at this speed
    for k in range(supports):
        x, y = complex(0.0, 0.0), complex(0.0, 0.0)
        for i in range(g.speeds.size):
            share = share_of(i, g.speeds, speed)
            for r in range(size if share != 0.0 else 0):
                stiff, damp = g.held_stiffness[i, r], g.held_damping[i, r]
                x += share * complex(stiff[2 * k], speed * damp[2 * k]) * a[r, size]
                y += share * complex(stiff[2 * k + 1], speed * damp[2 * k + 1]) * a[r, size]
        force[k] = _semi_major(x, y)


# Deflections, forces and unbalances at the places of a machine, from states of a run.
#
# States stand in the rows of a ring with the time first; row ``first`` is the oldest.


ball_type = types.UniTuple(types.float64, 2)


@njit(int64(vector_type), **EXACT)
def turns_of(angle: Floats) -> int:
    """How many of the last of these angles, at equal steps, make whole revolutions; the entry before them is their begin."""
    count = angle.size
    step = abs(angle[count - 1] - angle[count - 2]) if count > 1 else 0.0
    if not step > 0.0:
        return 0
    each = math.floor(2.0 * math.pi / step + 0.5)
    return (count - 1) // each * each if each > 0 else 0


@njit(ball_type(vector_type, int64, int64, int64, int64), **EXACT_PART)
def ball_at(y: Floats, i: int, count: int, size: int, resolved: int) -> tuple[float, float]:
    """Angle and speed of ball i of ``count`` in the rotor, for R = ``size`` coordinates.

    The angle that resolved balls carry counts the turns; position and velocity are exact even where one passed near the center.
    """
    angle, rate = y[BALLS + i], y[BALLS + count + i]
    if resolved == 0:
        return angle, rate
    own = 2 + 2 * size + 2 * count + i * BALL_STATES
    a, b = y[own + BALL_X], y[own + BALL_Y]
    s, c = sine_cosine(angle)
    square = max(a * a + b * b, 1e-30)
    return angle + math.atan2(b * c - a * s, a * c + b * s), (a * y[own + BALL_VY] - b * y[own + BALL_VX]) / square


@njit(void(matrix_type, int64, int64, int64, matrix_type, matrix_type), **EXACT)
def ball_motion(states: Matrix, count: int, size: int, resolved: int, angle: Matrix, rate: Matrix) -> None:
    """Angles (rad) and speeds (rad/s) of the balls in the rotor, (T, n) each, from states without their time."""
    for t in range(states.shape[0]):
        for i in range(count):
            angle[t, i], rate[t, i] = ball_at(states[t], i, count, size, resolved)


@njit(**INLINE)
def _dot(one: Any, at: int, step: int, values: Any, count: int) -> float:
    """Sum of every ``step``-th number from a place on, each times its value."""
    total = 0.0
    for k in range(count):
        total += one[at + k * step] * values[k]
    return total


@njit(**INLINE)
def _rotor(y: Any, p: System, size: int, s: float, c: float, d: Workspace) -> None:
    """Coordinates and their velocities in space."""
    rest = BALLS + 2 * p.ball_count
    for r in range(0, size, 2):
        at, to = (X, VX) if r == 0 else (rest + r - 2, rest + size + r - 4)
        d.place[r], d.place[r + 1] = y[at] * c - y[at + 1] * s, y[at] * s + y[at + 1] * c
        d.move[r], d.move[r + 1] = y[to] * c - y[to + 1] * s, y[to] * s + y[to + 1] * c


@njit(**INLINE)
def _supports(y: Any, p: System, g: MeasureInputs, s: float, c: float, d: Workspace) -> None:
    """Force of the rotor on each support, its weight included, to ``d.push``; coordinates are known."""
    wide, size, push, weight = g.weight.size, g.rows.shape[0], data(d.push), data(g.weight)
    place, move, stiffness, damping = data(d.place), data(d.move), data(g.stiffness), data(g.damping)
    # springs and dampers at this speed, on top of the weight
    for i in range(wide):
        total = weight[i]
        for k in range(g.speeds.size):
            share = share_of(k, g.speeds, y[SPEED])
            if share != 0.0:
                at = k * size * wide + i
                total += share * (_dot(stiffness, at, wide, place, size) + _dot(damping, at, wide, move, size))
        push[i] = total
    # rubber that slides or relaxes: its elements' forces are states
    for m in range(p.rubber.mounts.shape[0]):
        mount, a, b = p.rubber.mounts[m], 0.0, 0.0
        for e in range(mount.first, mount.first + mount.elements):
            at = p.rubber.elements[e].state
            a, b = a + y[at], b + y[at + 1]
        a, b = a * c - b * s, a * s + b * c
        for i in range(wide):
            push[i] += a * g.rubber[2 * m, i] + b * g.rubber[2 * m + 1, i]
    # bearings that become stiffer
    for h in range(p.bearings.springs.shape[0]):
        a, b = 0.0, 0.0
        for r in range(size):
            a += p.bearings.rows[2 * h, r] * place[r]
            b += p.bearings.rows[2 * h + 1, r] * place[r]
        a, b = central(row(p.bearings.springs, h), data(p.bearings.tables), a, b)
        for i in range(wide):
            push[i] += a * g.hard[2 * h, i] + b * g.hard[2 * h + 1, i]


@njit(void(system_type, inputs_type, matrix_type, int64, int64, int64, workspace_type), **EXACT)
def observe(p: System, g: MeasureInputs, ring: Matrix, first: int, count: int, planes: int, d: Workspace) -> None:
    """Fill ``d.seen`` and ``d.rotor`` from ``count`` states; ``planes`` 1: work out what each plane has to balance, too."""
    size, n, seen, wide = g.rows.shape[0], g.ball_mass.size, d.seen, g.rows.shape[1]
    rows, place, move, push, states = data(g.rows), data(d.place), data(d.move), data(d.push), data(ring)
    at_z, at_v, at_force, length = data(seen.z), data(seen.v), data(seen.force), ring.shape[1]
    places, supports, speed_before, before = wide // 2, g.weight.size // 2, 0.0, -1
    resolved = 1 if g.scalars[RESOLVED] != 0.0 else 0
    for t in range(count):
        number = (first + t) % ring.shape[0]
        time, y = states[number * length], ring[number, 1:]
        # the rotor in space, and its places and supports
        s, c = 0.0, 1.0
        if p.rotating == 1:
            s, c = sine_cosine(y[THETA])
        d.rotor[t] = y[THETA]
        _rotor(y, p, size, s, c, d)
        for k in range(places):
            x, z = _dot(rows, 2 * k, wide, place, size), _dot(rows, 2 * k + 1, wide, place, size)
            at_z[t * places + k] = complex(x, z)
            x, z = _dot(rows, 2 * k, wide, move, size), _dot(rows, 2 * k + 1, wide, move, size)
            at_v[t * places + k] = complex(x, z)
        _supports(y, p, g, s, c, d)
        for k in range(supports):
            at_force[t * supports + k] = complex(push[2 * k], push[2 * k + 1])
        # what the balls hold of the unbalance, plane by plane
        x, z = unbalance_at(time, p)
        seen.unbalance[t, 0] = complex(x, z)
        for k in range(g.capability.size):
            seen.held[t, k] = 0.0
        total_x, total_y = 0.0, 0.0
        for i in range(n):
            angle, _ = ball_at(y, i, n, size, resolved)
            seen.angles[t, i] = y[THETA] + angle
            a, b = g.ball_mass[i] * g.ball_centers[i, 0], g.ball_mass[i] * g.ball_centers[i, 1]
            if resolved == 1:
                own = 2 + 2 * size + 2 * n + i * BALL_STATES
                a, b = a + g.ball_mass[i] * y[own + BALL_X], b + g.ball_mass[i] * y[own + BALL_Y]
            else:
                sine, cosine = sine_cosine(angle)
                a, b = a + g.ball_moment[i] * cosine, b + g.ball_moment[i] * sine
            total_x, total_y = total_x + a, total_y + b
            seen.held[t, g.ball_planes[i]] += complex(a, b)
        seen.left[t, 0] = complex(x + total_x, z + total_y)
        # what each plane has to balance is costly, so it is kept while the speed stays
        if planes == 1:
            k = segment_at(time, p)
            if k == before and y[SPEED] == speed_before and p.drive.segments[k].changing == 0:
                for i in range(g.capability.size):
                    seen.wanted[t, i] = seen.wanted[t - 1, i]
            else:
                plane_unbalances(p, g, time, y[SPEED], d, seen.wanted[t])
            before, speed_before = k, y[SPEED]


# What of a motion stands still, and what vibrates.


columns_type = types.Array(types.complex128, 2, "A")


@njit(
    void(
        columns_type, int64, vector_type, matrix_type, int64, complex_matrix_type, complex_matrix_type, complexes_type,
    ),
    **EXACT,
)  # fmt: skip
def standing(
    z: Any, count: int, rotor: Floats, balls: Matrix, centered: int, work: Any, small: Any, found: Any
) -> None:
    """The part of x + i y that stands still, of each column of ``count`` rows; zero where nothing can deflect a rotor for good.

    ``rotor`` is its angle, at equal steps over whole turns, ``balls`` are the angles of the balls in space, rad. Where some of
    them go round both in space and in the rotor, the revolutions of the rotor are not those of the deflection. Then the standing
    part is fitted together with what whirls with the rotor, with the balls, and against them. Weights that vanish at both ends
    (Hann's) suppress the rest. ``work`` is (T, 1 + 2 (1 + n) + columns), ``small`` as many columns square and two more.
    """
    columns, last, whirling = z.shape[1], count - 1, 0
    for k in range(columns):
        found[k] = complex(0.0, 0.0)
    if centered != 0 or count == 0:
        return
    turned = rotor[last] - rotor[0]
    for i in range(balls.shape[1]):
        way = balls[last, i] - balls[0, i]
        if abs(way) > 2.0 * math.pi and abs(way - turned) > math.pi:
            whirling += 1
    if whirling == 0:
        for k in range(columns):
            total = complex(0.0, 0.0)
            for t in range(count):
                total += z[t, k]
            found[k] = total / count
        return
    size = 1 + 2 * (1 + whirling)
    for t in range(count):
        weight, place = math.sin(math.pi * (t + 0.5) / count), 1
        work[t, 0] = weight
        for i in range(-1, balls.shape[1]):
            angle = rotor[t]
            if i >= 0:
                way = balls[last, i] - balls[0, i]
                if not (abs(way) > 2.0 * math.pi and abs(way - turned) > math.pi):
                    continue
                angle = balls[t, i]
            s, c = sine_cosine(angle)
            work[t, place] = complex(weight * c, weight * s)
            work[t, place + 1 + whirling] = complex(weight * c, -weight * s)
            place += 1
        for k in range(columns):
            work[t, size + k] = weight * z[t, k]
    reduce(work, count, size, columns, small)
    least_squares(small, size, columns, SAME_MOTION, work)
    for k in range(columns):
        found[k] = small[0, size + k]
