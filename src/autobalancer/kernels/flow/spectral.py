"""The flow in an annulus by Chebyshev collocation: implicit diffusion, explicit convection, no slip exactly.

    g_t = nu D2 g - u.grad g + 2 w psi_z - r^2 w'
    q_t = nu D2 q - u.grad q + 2 u_r q/r + (g^2/r^2 + 2 w g)_z,   D2 psi = -q

follow from Spannan 2021, (3.10) to (3.12), with G = g + r^2 w and q = r eta: the large part r^4 w^2 of G^2 drops out, and the
three elliptic operators become one, D2, which is diagonal with L_ij in the products of the eigenvectors of both directions.

Steps are backward differentiation with extrapolated explicit terms (Ascher, Ruuth and Wetton 1995), order up to three, of
variable length. At the walls psi and its slope vanish; the vorticity there is whatever this takes. With s the leading weight of
the derivative and G = 1/((s - nu L)(-L)) a step gives

    psi_ij = G_ij (f_ij + c0_i x0_j + c1_i x1_j + d0_j y0_i + d1_j y1_i),

c, d columns of D2 that belong to the walls, x, y nu times the vorticity on them. Vanishing slopes, sum_i p_i psi_ij = 0 and
sum_j s_j psi_ij = 0, are a linear system for x and y, the influence matrix (Ehrenstein and Peyret 1989). It is singular four
times, once for each corner, where a pattern of wall values acts on no inner point; these patterns are filled up.
"""

from __future__ import annotations

from typing import NamedTuple

from numba import njit, types
from numba.core.types import NamedTuple as NamedTupleType

from autobalancer.kernels.flags import COMPILED
from autobalancer.kernels.flow.dense import factorize, product, substitute
from autobalancer.kernels.flow.speed import wall_speed
from autobalancer.kernels.system import Floats, Matrix, matrix_type, vector_type

# clock
TIME, LENGTH, CONVECTION, SHIFT, KNOWN, ACCEPTED, REJECTED, FIRST, LEAST, LOST, AGO = range(
    11
)  # AGO: lengths of past steps
CLOCK = AGO + 4

REACH = 0.7  # step times (2 w + convection): inside the stable range of the explicit terms
MARGIN = 0.8  # of it, when the step is changed
GROWTH = 1.3  # backward differentiation of order three stays stable up to 1.5
WORTH = 1.2  # a longer step is taken from this growth on: a new length costs a new influence matrix
SHRINK = 0.9  # a shorter one below this
REFUSED = 1.5  # error over tolerance above which a step is done again

stack_type = types.float64[:, :, ::1]


class Plan(NamedTuple):
    """What does not change: m inner points along r, n along z."""

    radius: Floats
    space_r: Floats
    space_z: Floats
    orbit_r: Floats
    orbit_z: Floats
    along_r: Matrix  # (m, m + 2)
    along_z: Matrix  # (n + 2, n), transposed
    r_forward: Matrix
    r_backward: Matrix
    z_forward: Matrix  # transposed
    z_backward: Matrix  # transposed
    laplacian: Matrix  # L
    c: Matrix  # (m, 2)
    d: Matrix  # (n, 2)
    p: Matrix  # (2, m)
    s: Matrix  # (2, n)
    right: Matrix  # (2 (m + n), 4)
    left: Matrix
    lift: Matrix  # what walls with their own speed add to g
    viscosity: float


class State(NamedTuple):
    """Fields with their walls, the past at the inner points (newest first), and work space."""

    g: Matrix
    q: Matrix
    psi: Matrix
    g_past: Floats  # (5, m, n)
    q_past: Floats
    g_rate: Floats
    q_rate: Floats
    work: Floats  # (6, m, n)
    a: Matrix
    b: Matrix
    f: Matrix
    scale: Matrix
    influence: Matrix
    pivots: Floats
    rows: Floats
    columns: Floats
    unknown: Floats
    weights: Matrix  # (3, 5): derivative, extrapolation of the terms, of the values


plan_type = NamedTupleType([vector_type] * 5 + [matrix_type] * 14 + [types.float64], Plan)
state_type = NamedTupleType(
    [matrix_type] * 3 + [stack_type] * 5 + [matrix_type] * 5 + [vector_type] * 4 + [matrix_type], State
)


@njit(types.void(plan_type, state_type, vector_type, types.float64), **COMPILED)
def remember(p: Plan, s: State, clock: Floats, speed: float) -> None:
    """Explicit terms of the present fields; they and the fields become the newest of the past."""
    m, n = p.laplacian.shape
    for k in range(4, 0, -1):
        for i in range(m):
            for j in range(n):
                s.g_past[k, i, j] = s.g_past[k - 1, i, j]
                s.q_past[k, i, j] = s.q_past[k - 1, i, j]
                s.g_rate[k, i, j] = s.g_rate[k - 1, i, j]
                s.q_rate[k, i, j] = s.q_rate[k - 1, i, j]
    for i in range(m):
        for k in range(6):
            for j in range(n):
                s.work[k, i, j] = 0.0
        for k in range(m + 2):
            x = p.along_r[i, k]
            for j in range(n):
                s.work[0, i, j] += x * s.g[k, j + 1]
                s.work[1, i, j] += x * s.q[k, j + 1]
                s.work[2, i, j] += x * s.psi[k, j + 1]
        for k in range(n + 2):
            x, y, z = s.g[i + 1, k], s.q[i + 1, k], s.psi[i + 1, k]
            for j in range(n):
                s.work[3, i, j] += x * p.along_z[k, j]
                s.work[4, i, j] += y * p.along_z[k, j]
                s.work[5, i, j] += z * p.along_z[k, j]
    most = 0.0
    for i in range(m):
        r = p.radius[i]
        for j in range(n):
            psi_z, g_z, g, q = s.work[5, i, j], s.work[3, i, j], s.g[i + 1, j + 1], s.q[i + 1, j + 1]
            u, v = -psi_z / r, s.work[2, i, j] / r
            s.g_past[0, i, j], s.q_past[0, i, j] = g, q
            s.g_rate[0, i, j] = 2.0 * speed * psi_z - u * s.work[0, i, j] - v * g_z
            s.q_rate[0, i, j] = (
                2.0 * (u * q / r + g * g_z / (r * r) + speed * g_z) - u * s.work[1, i, j] - v * s.work[4, i, j]
            )
            rate = abs(u) / p.space_r[i] + abs(v) / p.space_z[j]
            if not rate <= most:
                most = rate
    clock[CONVECTION] = most


@njit(types.void(plan_type, state_type, types.float64), **COMPILED)
def prepare(p: Plan, s: State, shift: float) -> None:
    """Scale of the implicit step and factors of its influence matrix."""
    m, n = p.laplacian.shape
    size = 2 * (m + n)
    for i in range(m):
        for j in range(n):
            s.scale[i, j] = 1.0 / (shift - p.viscosity * p.laplacian[i, j])
            s.a[i, j] = -s.scale[i, j] / p.laplacian[i, j]
    for i in range(size):
        for j in range(size):
            s.influence[i, j] = 0.0
    for u in range(2):
        for v in range(2):
            for i in range(m):
                for j in range(n):
                    g = s.a[i, j]
                    s.influence[u * n + j, v * n + j] += p.p[u, i] * p.c[i, v] * g
                    s.influence[u * n + j, 2 * n + v * m + i] = p.p[u, i] * g * p.d[j, v]
                    s.influence[2 * n + u * m + i, v * n + j] = p.s[u, j] * g * p.c[i, v]
                    s.influence[2 * n + u * m + i, 2 * n + v * m + i] += p.s[u, j] * g * p.d[j, v]
    for i in range(size):
        most = 0.0
        for j in range(size):
            most = max(most, abs(s.influence[i, j]))
        s.rows[i] = 1.0 / most
    for j in range(size):
        most = 0.0
        for i in range(size):
            most = max(most, abs(s.influence[i, j]) * s.rows[i])
        s.columns[j] = 1.0 / most
    for i in range(size):
        for j in range(size):
            s.influence[i, j] *= s.rows[i] * s.columns[j]
    for corner in range(4):
        left, right = 0.0, 0.0
        for i in range(size):
            left += (p.left[i, corner] / s.rows[i]) ** 2
            right += (p.right[i, corner] / s.columns[i]) ** 2
        norm = 1.0 / (left * right) ** 0.5
        for i in range(size):
            x = p.left[i, corner] / s.rows[i] * norm
            for j in range(size):
                s.influence[i, j] += x * p.right[j, corner] / s.columns[j]
    factorize(s.influence, s.pivots)


@njit(types.void(state_type, vector_type, types.int64, types.int64), **COMPILED)
def weigh(s: State, clock: Floats, order: int, known: int) -> None:
    """Weights of a step of length ``clock[AGO]``; the lengths before it follow, so that equal steps have equal weights."""
    for row in range(3):
        count = known if row == 2 else order
        total, lead = 0.0, 0.0
        for j in range(count):
            total += clock[AGO + j]
            x, other = 1.0, 0.0
            for k in range(count):
                other += clock[AGO + k]
                if k != j:
                    x *= other / (other - total)
            if row == 0:
                s.weights[0, j + 1] = -x / total
                lead += x / total
            else:
                s.weights[row, j] = x
        if row == 0:
            s.weights[0, 0] = lead


@njit(types.void(plan_type, state_type, types.int64, types.float64), **COMPILED)
def implicit(p: Plan, s: State, order: int, rate: float) -> None:
    """The fields after a step with the present weights and influence matrix."""
    m, n = p.laplacian.shape
    nu = p.viscosity
    for i in range(m):
        r = p.radius[i]
        for j in range(n):
            s.a[i, j], s.f[i, j] = -r * r * rate, 0.0
        for k in range(order):
            past, ahead = s.weights[0, k + 1], s.weights[1, k]
            for j in range(n):
                s.a[i, j] += ahead * s.g_rate[k, i, j] - past * s.g_past[k, i, j]
                s.f[i, j] += ahead * s.q_rate[k, i, j] - past * s.q_past[k, i, j]
    product(p.r_forward, s.a, s.b)
    product(s.b, p.z_forward, s.a)
    for i in range(m):
        for j in range(n):
            s.a[i, j] = (s.a[i, j] + p.lift[i, j]) * s.scale[i, j]
    product(p.r_backward, s.a, s.b)
    product(s.b, p.z_backward, s.a)
    for i in range(m):
        for j in range(n):
            s.g[i + 1, j + 1] = s.a[i, j]
    product(p.r_forward, s.f, s.b)
    product(s.b, p.z_forward, s.f)
    x = s.unknown
    for k in range(2 * (m + n)):
        x[k] = 0.0
    for i in range(m):
        for j in range(n):
            slope = s.f[i, j] * s.scale[i, j] / p.laplacian[i, j]
            for w in range(2):
                x[w * n + j] += p.p[w, i] * slope
                x[2 * n + w * m + i] += p.s[w, j] * slope
    for k in range(2 * (m + n)):
        x[k] *= s.rows[k]
    substitute(s.influence, s.pivots, x)
    for k in range(2 * (m + n)):
        x[k] *= s.columns[k]
    for i in range(m):
        for j in range(n):
            add = p.c[i, 0] * x[j] + p.c[i, 1] * x[n + j] + p.d[j, 0] * x[2 * n + i] + p.d[j, 1] * x[2 * n + m + i]
            s.f[i, j] = s.scale[i, j] * (s.f[i, j] + add)
            s.a[i, j] = -s.f[i, j] / p.laplacian[i, j]
    product(p.r_backward, s.f, s.b)
    product(s.b, p.z_backward, s.f)
    product(p.r_backward, s.a, s.b)
    product(s.b, p.z_backward, s.a)
    for i in range(m):
        for j in range(n):
            s.q[i + 1, j + 1], s.psi[i + 1, j + 1] = s.f[i, j], s.a[i, j]
    for w in range(2):
        for j in range(n):
            total = 0.0
            for k in range(n):
                total += x[w * n + k] * p.z_backward[k, j]
            s.q[w * (m + 1), j + 1] = total / nu
        for i in range(m):
            total = 0.0
            for k in range(m):
                total += x[2 * n + w * m + k] * p.r_backward[i, k]
            s.q[i + 1, w * (n + 1)] = total / nu


@njit(types.float64(plan_type, state_type, types.int64), **COMPILED)
def missed(p: Plan, s: State, known: int) -> float:
    """Root mean square of the new angular velocity less the one extrapolated from ``known`` instants, rad/s."""
    m, n = p.laplacian.shape
    total = 0.0
    for i in range(m):
        r2 = p.radius[i] * p.radius[i]
        for j in range(n):
            x = s.g[i + 1, j + 1]
            for k in range(known):
                x -= s.weights[2, k] * s.g_past[k, i, j]
            total += (x / r2) ** 2
    return (total / (m * n)) ** 0.5


@njit(
    types.int64(
        plan_type, state_type, vector_type, types.float64, types.float64, vector_type, types.float64,
        types.float64, types.float64, types.int64, matrix_type,
    ),
    **COMPILED,
)  # fmt: skip
def march(
    p: Plan,
    s: State,
    clock: Floats,
    start: float,
    kind: float,
    numbers: Floats,
    end: float,
    fixed: float,
    goal: float,
    order: int,
    record: Matrix,
) -> int:
    """Steps from ``clock[TIME]`` to ``end`` within one piece of the speed, at most as many as ``record`` has rows.

    A row of the record is time, rotor speed, speed of the fluid at the orbit relative to it. ``fixed`` is the step to take,
    or 0 for steps with the local error ``goal`` (rad/s). ``clock[LOST]`` is set where the flow is not resolved. Returns the
    number of rows written.
    """
    count = 0
    while count < record.shape[0] and clock[TIME] < end:
        time = clock[TIME]
        reach = 0.0
        if fixed == 0.0:
            now = abs(wall_speed(time, start, kind, numbers)[0])
            then = abs(wall_speed(min(time + clock[LENGTH], end), start, kind, numbers)[0])
            reach = REACH / (2.0 * max(now, then) + clock[CONVECTION] + 1e-300)
            if not clock[LENGTH] <= reach:
                clock[LENGTH] = MARGIN * reach
            if not clock[LENGTH] >= clock[LEAST] or clock[REJECTED] > 50.0 + clock[ACCEPTED]:
                clock[LOST] = 1.0
                return count
        length, left = clock[LENGTH], end - time
        last = left <= length * 1.000001
        step = length
        if last:
            step = left
        elif left < 2.0 * length:
            step = 0.5 * left
        after = end if last else time + step
        known = int(clock[KNOWN])
        used = min(known, order)
        seen = min(known, order + 1)
        clock[AGO] = step
        weigh(s, clock, used, seen)
        if s.weights[0, 0] != clock[SHIFT]:
            clock[SHIFT] = s.weights[0, 0]
            prepare(p, s, clock[SHIFT])
        speed, rate = wall_speed(after, start, kind, numbers)
        implicit(p, s, used, rate)
        error = missed(p, s, seen) / ((used + 2.0) * goal)
        if fixed == 0.0:
            wish = 0.2 * step
            if error < 1e30:
                wish = step * min(max(0.85 * max(error, 1e-9) ** (-1.0 / (used + 1.0)), 0.2), GROWTH)
            if not error <= REFUSED and known > 1:  # of the first step nothing is known
                clock[LENGTH] = wish
                clock[REJECTED] += 1.0
                continue
            longest = min(wish, MARGIN * reach)
            if longest >= WORTH * length or wish < SHRINK * step:
                clock[LENGTH] = longest
        for k in range(3, 0, -1):
            clock[AGO + k] = clock[AGO + k - 1]
        clock[KNOWN] = min(known + 1, order + 1)
        clock[TIME] = after
        clock[ACCEPTED] += 1.0
        remember(p, s, clock, speed)
        total = 0.0
        for i in range(p.orbit_r.shape[0]):
            for j in range(p.orbit_z.shape[0]):
                total += p.orbit_r[i] * p.orbit_z[j] * s.g[i, j]
        record[count, 0], record[count, 1], record[count, 2] = after, speed, total
        count += 1
    return count
