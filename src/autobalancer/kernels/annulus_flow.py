"""The flow in an annulus by Chebyshev collocation: implicit diffusion, explicit convection, no slip exactly.

    g_t = nu D2 g - u.grad g + 2 w psi_z - r^2 w'
    q_t = nu D2 q - u.grad q + 2 u_r q/r + (g^2/r^2 + 2 w g)_z,   D2 psi = -q

follow from Spannan 2021, (3.10) to (3.12), with G = g + r^2 w and q = r eta: the large part r^4 w^2 of G^2 drops out, and the
three elliptic operators become one, D2, which is diagonal with L_ij in the products of the eigenvectors of both directions.

Steps are backward differentiation with extrapolated explicit terms (Ascher, Ruuth and Wetton 1995), order up to three, of
variable length. The terms with 2 w, waves of the turning fluid, are explicit or, with ``clock[WAVES]``, implicit at a reference
speed that follows the rotor; implicit ones want order two, which damps waves of any frequency.
"""

from __future__ import annotations

from typing import NamedTuple

from numba import types

from autobalancer.kernels.compiler.flags import COMPILED, INLINE, njit
from autobalancer.kernels.laws.curves import between
from autobalancer.kernels.records import HILL
from autobalancer.kernels.system import Floats, Matrix, matrix_type, tuple_type, vector_type

# What the spectral flow solver keeps: matrices of the grid, fields with their past, a clock.
#
# Fields are (m, n): m inner points or shares along r, n along z. A *share* belongs to a product of eigenvectors of D2.
# g and psi_z are even about mid-height and q, psi odd where the walls are, and then n counts half of the height; the
# matrices along z of even and odd fields differ, and equal one another where the whole height is kept.


# clock; AGO: lengths of past steps
(
    TIME, LENGTH, CONVECTION, SHIFT, KNOWN, ACCEPTED, REJECTED, HEAD, LEAST, LOST, REFERENCE, WAVES, AGO,
) = range(13)  # fmt: skip
CLOCK = AGO + 4
LEVELS = 5  # of the past that are kept, one of them for the step that is tried


class Plan(NamedTuple):
    """What does not change. Matrices along z are transposed, to be multiplied from the right."""

    over_r: Floats  # 1/r
    over_dr: Floats  # 1/spacing
    over_dz: Floats
    orbit_r: Floats  # weights of the inner points of g in its interpolation at the orbit
    orbit_z: Floats
    r_forward: Matrix  # values to shares, filtered
    r_backward: Matrix
    r_slope: Matrix  # shares to d/dr
    even_forward: Matrix
    odd_forward: Matrix
    even_backward: Matrix
    odd_backward: Matrix
    even_slope: Matrix  # values to d/dz
    odd_slope: Matrix
    to_even: Matrix  # d/dz of shares, odd to even
    to_odd: Matrix
    even_rates: Matrix  # L
    odd_rates: Matrix
    source: Matrix  # shares of r^2
    lift: Matrix  # what walls with their own speed add to the shares of nu D2 g,
    wall_r: Matrix  # to g_r
    wall_z: Matrix  # to g_z,
    wall_wave: Matrix  # and to its shares
    near_r: Matrix  # (2, m): columns of d/dr that belong to the walls
    near_z: Matrix  # (walls, n): the same along z, of odd fields
    c: Matrix  # (2, m): columns of D2 that belong to the walls, in shares
    d: Matrix  # (walls, n)
    p: Matrix  # (2, m): slopes at the walls of shares
    s: Matrix  # (walls, n)
    right: Matrix  # (corners, size)
    left: Matrix
    viscosity: float
    orbit_wall: float  # what the walls add to g at the orbit


class State(NamedTuple):
    """The past is a ring of ``LEVELS``, where ``clock[HEAD]`` is the present."""

    g: Floats  # values; (level, m, n)
    g_share: Floats
    q_share: Floats
    g_rate: Floats  # shares of the convection terms
    q_rate: Floats
    g_wave: Floats  # shares of psi_z
    q_wave: Floats  # shares of g_z
    green: Floats  # (m, n, n): inverse of one row of the implicit step
    psi_share: Matrix
    a: Matrix
    b: Matrix
    g_r: Matrix
    g_z: Matrix
    q: Matrix
    q_r: Matrix
    q_z: Matrix
    psi_r: Matrix
    psi_z: Matrix
    scale: Matrix  # 1/(s - nu L) of even fields
    block: Matrix  # (n, n)
    influence: Matrix
    q_side: Matrix  # (2, n): q at the cylinders
    q_lid: Matrix  # (walls, m): q at the lids
    weights: Matrix  # (3, 5): derivative, extrapolation of the terms, of the values
    pivots: Floats
    rows: Floats
    columns: Floats
    unknown: Floats
    speeds: Floats  # (level,)


plan_type = tuple_type(Plan)
state_type = tuple_type(State, **dict.fromkeys(State._fields[:8], types.float64[:, :, ::1]))


REACH = 0.7  # step times rate of the explicit terms: inside their stable range
MARGIN = 0.8  # of it, when the step is changed
DRIFT = 0.2  # step times 2 |w - reference| from which the reference follows the rotor
GROWTH = 1.3  # backward differentiation of order three stays stable up to 1.5
WORTH = 1.2  # a longer step is taken from this growth on: a new length costs a new influence matrix
SHRINK = 0.9  # a shorter one below this
REFUSED = 1.5  # error over tolerance above which a step is done again


@njit(
    types.int64(
        plan_type, state_type, vector_type, types.float64, types.float64, vector_type, types.float64,
        types.float64, types.float64, types.int64, matrix_type,
    ),
    **COMPILED,
)  # fmt: skip
def integrate_flow(
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
        # convection and inertial waves are explicit, so they limit the step; a flow that needs ever shorter ones is lost
        reach = 0.0
        if fixed == 0.0:
            waves = 0.0
            if clock[WAVES] == 0.0:
                now = abs(wall_speed(time, start, kind, numbers)[0])
                then = abs(wall_speed(min(time + clock[LENGTH], end), start, kind, numbers)[0])
                waves = 2.0 * max(now, then)
            reach = REACH / (waves + clock[CONVECTION] + 1e-300)
            if not clock[LENGTH] <= reach:
                clock[LENGTH] = MARGIN * reach
            if not clock[LENGTH] >= clock[LEAST] or clock[REJECTED] > 50.0 + clock[ACCEPTED]:
                clock[LOST] = 1.0
                return count
        # two equal steps to the end, not a long one and a short one
        length, left = clock[LENGTH], end - time
        last = left <= length * 1.000001
        step = length
        if last:
            step = left
        elif left < 2.0 * length:
            step = 0.5 * left
        after = end if last else time + step
        # the influence matrix costs far more than a step: it is made anew only when its shift or reference moves too far
        known = int(clock[KNOWN])
        used = min(known, order)
        seen = min(known, order + 1)
        clock[AGO] = step
        weigh(s, clock, used, seen)
        speed, rate = wall_speed(after, start, kind, numbers)
        reference = clock[REFERENCE]
        if clock[WAVES] > 0.0 and not abs(speed - reference) * 2.0 * step <= DRIFT:
            reference = speed
        if s.weights[0, 0] != clock[SHIFT] or reference != clock[REFERENCE]:
            clock[SHIFT], clock[REFERENCE] = s.weights[0, 0], reference
            prepare(p, s, clock[SHIFT], reference)
        implicit(p, s, clock, used, rate)
        # the error is that of the step against the past continued; the length stays unless a change is worth new matrices
        error = missed(p, s, clock, seen) / ((used + 2.0) * goal)
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
        # the step is taken: the ring of the past goes on, and the fluid at the orbit is noted
        for k in range(3, 0, -1):
            clock[AGO + k] = clock[AGO + k - 1]
        clock[KNOWN] = min(known + 1, order + 1)
        clock[TIME] = after
        clock[ACCEPTED] += 1.0
        clock[HEAD] = (int(clock[HEAD]) + 1) % LEVELS
        remember(p, s, clock, speed)
        total = p.orbit_wall
        now_level = int(clock[HEAD])
        for i in range(p.orbit_r.shape[0]):
            for j in range(p.orbit_z.shape[0]):
                total += p.orbit_r[i] * p.orbit_z[j] * s.g[now_level, i, j]
        record[count, 0], record[count, 1], record[count, 2] = after, speed, total
        count += 1
    return count


# Small dense matrices: product, inverse, factors, solution. Nothing is allocated.


@njit(types.void(matrix_type, matrix_type, matrix_type), **COMPILED)
def product(a: Matrix, b: Matrix, out: Matrix) -> None:
    """out = a b; blocks of four by four, so that a row of b serves four rows and a row of ``out`` is touched seldom."""
    rows, depth, columns = a.shape[0], a.shape[1], b.shape[1]
    i = 0
    # blocks of four rows
    while i + 4 <= rows:
        for j in range(columns):
            out[i, j], out[i + 1, j], out[i + 2, j], out[i + 3, j] = 0.0, 0.0, 0.0, 0.0
        k = 0
        while k + 4 <= depth:
            a00, a01, a02, a03 = a[i, k], a[i, k + 1], a[i, k + 2], a[i, k + 3]
            a10, a11, a12, a13 = a[i + 1, k], a[i + 1, k + 1], a[i + 1, k + 2], a[i + 1, k + 3]
            a20, a21, a22, a23 = a[i + 2, k], a[i + 2, k + 1], a[i + 2, k + 2], a[i + 2, k + 3]
            a30, a31, a32, a33 = a[i + 3, k], a[i + 3, k + 1], a[i + 3, k + 2], a[i + 3, k + 3]
            for j in range(columns):
                b0, b1, b2, b3 = b[k, j], b[k + 1, j], b[k + 2, j], b[k + 3, j]
                out[i, j] += a00 * b0 + a01 * b1 + a02 * b2 + a03 * b3
                out[i + 1, j] += a10 * b0 + a11 * b1 + a12 * b2 + a13 * b3
                out[i + 2, j] += a20 * b0 + a21 * b1 + a22 * b2 + a23 * b3
                out[i + 3, j] += a30 * b0 + a31 * b1 + a32 * b2 + a33 * b3
            k += 4
        # the columns of a that four do not divide
        while k < depth:
            a00, a10, a20, a30 = a[i, k], a[i + 1, k], a[i + 2, k], a[i + 3, k]
            for j in range(columns):
                b0 = b[k, j]
                out[i, j] += a00 * b0
                out[i + 1, j] += a10 * b0
                out[i + 2, j] += a20 * b0
                out[i + 3, j] += a30 * b0
            k += 1
        i += 4
    # the last rows, one by one
    while i < rows:
        for j in range(columns):
            out[i, j] = 0.0
        for k in range(depth):
            a00 = a[i, k]
            for j in range(columns):
                out[i, j] += a00 * b[k, j]
        i += 1


@njit(**INLINE)
def _exchange(a, pivots, k: int) -> None:  # type: ignore[no-untyped-def]
    """Bring the greatest number of column k, from row k on, into row k."""
    n, best = a.shape[0], k
    for i in range(k + 1, n):
        if abs(a[i, k]) > abs(a[best, k]):
            best = i
    pivots[k] = best
    if best != k:
        for j in range(n):
            a[k, j], a[best, j] = a[best, j], a[k, j]


@njit(types.void(matrix_type, vector_type), **COMPILED)
def invert(a: Matrix, pivots: Floats) -> None:
    """a becomes its inverse, by Gauss and Jordan with rows exchanged."""
    n = a.shape[0]
    for k in range(n):
        _exchange(a, pivots, k)
        scale = 1.0 / a[k, k]
        a[k, k] = 1.0
        for j in range(n):
            a[k, j] *= scale
        for i in range(n):
            x = a[i, k]
            if i != k and x != 0.0:
                a[i, k] = 0.0
                for j in range(n):
                    a[i, j] -= x * a[k, j]
    for k in range(n - 1, -1, -1):
        best = int(pivots[k])
        if best != k:
            for i in range(n):
                a[i, k], a[i, best] = a[i, best], a[i, k]


@njit(types.void(matrix_type, vector_type), **COMPILED)
def factorize(a: Matrix, pivots: Floats) -> None:
    """a becomes its triangular factors, transposed, with rows exchanged as ``pivots`` say."""
    n = a.shape[0]
    for k in range(n):
        _exchange(a, pivots, k)
        scale = 1.0 / a[k, k]
        for i in range(k + 1, n):
            x = a[i, k] * scale
            a[i, k] = x
            if x != 0.0:
                for j in range(k + 1, n):
                    a[i, j] -= x * a[k, j]
    for i in range(n):
        for j in range(i):
            a[i, j], a[j, i] = a[j, i], a[i, j]


@njit(types.void(matrix_type, vector_type, vector_type), **COMPILED)
def substitute(a: Matrix, pivots: Floats, x: Floats) -> None:
    """x becomes the solution of the system of :func:`factorize` with the right-hand side x."""
    n = a.shape[0]
    for k in range(n):
        best = int(pivots[k])
        if best != k:
            x[k], x[best] = x[best], x[k]
    for j in range(n):
        y = x[j]
        for i in range(j + 1, n):
            x[i] -= a[j, i] * y
    for j in range(n - 1, -1, -1):
        y = x[j] / a[j, j]
        x[j] = y
        for i in range(j):
            x[i] -= a[j, i] * y


# One implicit step of the spectral flow solver, and the explicit terms of the fields that it gives.


@njit(types.void(state_type, vector_type, types.int64, types.int64), **COMPILED)
def weigh(s: State, clock: Floats, order: int, known: int) -> None:
    """Weights of a step of length ``clock[AGO]``; the lengths before it follow, so that equal steps have equal weights."""
    for row in range(3):
        # row 0: the derivative at the new time; rows 1 and 2: extrapolation to it. All by Lagrange's polynomial through the
        # past levels at any distances
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


@njit(types.void(plan_type, state_type, types.boolean), **COMPILED)
def _green(p: Plan, s: State, diagonal: bool) -> None:
    """psi of the right-hand side ``s.b``."""
    m, n = p.odd_rates.shape
    for i in range(m):
        if diagonal:
            for j in range(n):
                s.psi_share[i, j] = s.green[i, j, j] * s.b[i, j]
        else:
            for j in range(n):
                s.psi_share[i, j] = 0.0
            for k in range(n):
                x = s.b[i, k]
                for j in range(n):
                    s.psi_share[i, j] += x * s.green[i, k, j]


@njit(types.void(plan_type, state_type, vector_type, types.int64, types.float64), **COMPILED)
def implicit(p: Plan, s: State, clock: Floats, order: int, rate: float) -> None:
    """The step that the weights and :func:`prepare` are for; it fills the level after the present one."""
    m, n = p.odd_rates.shape
    lids = p.d.shape[0]
    head, reference = int(clock[HEAD]), clock[REFERENCE]
    new = (head + 1) % LEVELS
    # right-hand sides from the past: diffusion is implicit, so it is diagonal here
    for i in range(m):
        for j in range(n):
            s.a[i, j], s.b[i, j] = p.lift[i, j] - rate * p.source[i, j], 0.0
        for k in range(order):
            level = (head - k) % LEVELS
            past, ahead = s.weights[0, k + 1], s.weights[1, k]
            wave = 2.0 * ahead * (s.speeds[level] - reference)
            for j in range(n):
                s.a[i, j] += (
                    ahead * s.g_rate[level, i, j] + wave * s.g_wave[level, i, j] - past * s.g_share[level, i, j]
                )
                s.b[i, j] += (
                    ahead * s.q_rate[level, i, j] + wave * s.q_wave[level, i, j] - past * s.q_share[level, i, j]
                )
        for j in range(n):
            s.a[i, j] *= s.scale[i, j]
    # the waves of the reference speed couple swirl and vorticity
    x = s.unknown
    for k in range(x.shape[0]):
        x[k] = 0.0
    if reference != 0.0:
        product(s.a, p.to_odd, s.q)
        for i in range(m):
            for j in range(n):
                s.b[i, j] += 2.0 * reference * (s.q[i, j] + p.wall_wave[i, j])
    # no slip: the stream function without wall vorticity misses it, and the influence matrix tells which vorticity mends that
    _green(p, s, reference == 0.0)
    for i in range(m):
        for j in range(n):
            psi = s.psi_share[i, j]
            for w in range(2):
                x[w * n + j] -= p.p[w, i] * psi
            for w in range(lids):
                x[2 * n + w * m + i] -= p.s[w, j] * psi
    for k in range(x.shape[0]):
        x[k] *= s.rows[k]
    substitute(s.influence, s.pivots, x)
    for k in range(x.shape[0]):
        x[k] *= s.columns[k]
    # with that vorticity, once more
    for i in range(m):
        for j in range(n):
            s.b[i, j] += p.c[0, i] * x[j] + p.c[1, i] * x[n + j]
        for w in range(lids):
            for j in range(n):
                s.b[i, j] += p.d[w, j] * x[2 * n + w * m + i]
    _green(p, s, reference == 0.0)
    for i in range(m):
        for j in range(n):
            s.q_share[new, i, j] = -p.odd_rates[i, j] * s.psi_share[i, j]
    product(s.psi_share, p.to_even, s.g_wave[new])
    for i in range(m):
        for j in range(n):
            s.g_share[new, i, j] = s.a[i, j] + 2.0 * reference * s.g_wave[new, i, j] * s.scale[i, j]
    product(s.g_share[new], p.even_backward, s.a)
    product(p.r_backward, s.a, s.g[new])


@njit(types.void(plan_type, state_type, vector_type, types.float64), **COMPILED)
def remember(p: Plan, s: State, clock: Floats, speed: float) -> None:
    """Explicit terms of the present level, after :func:`implicit`, which leaves g in ``a``: shares along r, values along z."""
    m, n = p.odd_rates.shape
    now = int(clock[HEAD])
    s.speeds[now] = speed
    lids, nu = p.d.shape[0], p.viscosity
    # slopes of all fields as values at the points, where products are taken
    product(p.r_slope, s.a, s.g_r)
    product(s.g[now], p.even_slope, s.g_z)
    product(s.g_share[now], p.to_odd, s.q_wave[now])
    product(s.q_share[now], p.odd_backward, s.a)
    product(p.r_backward, s.a, s.q)
    product(p.r_slope, s.a, s.q_r)
    product(s.q, p.odd_slope, s.q_z)
    product(s.psi_share, p.odd_backward, s.a)
    product(p.r_slope, s.a, s.psi_r)
    product(s.g_wave[now], p.even_backward, s.a)
    product(p.r_backward, s.a, s.psi_z)
    # the vorticity at the walls is known apart, as it does not vanish there
    for w in range(2):
        for j in range(n):
            total = 0.0
            for k in range(n):
                total += s.unknown[w * n + k] * p.odd_backward[k, j]
            s.q_side[w, j] = total / nu
    for w in range(lids):
        for i in range(m):
            total = 0.0
            for k in range(m):
                total += s.unknown[2 * n + w * m + k] * p.r_backward[i, k]
            s.q_lid[w, i] = total / nu
    # convection and the source of vorticity, and the greatest rate at which the flow crosses a cell
    most = 0.0
    for i in range(m):
        over, dr, near, far = p.over_r[i], p.over_dr[i], p.near_r[0, i], p.near_r[1, i]
        for w in range(lids):
            lid = s.q_lid[w, i]
            for j in range(n):
                s.q_z[i, j] += lid * p.near_z[w, j]
        fastest = 0.0
        for j in range(n):
            u, v = -s.psi_z[i, j] * over, s.psi_r[i, j] * over
            g, g_z, q = s.g[now, i, j], s.g_z[i, j] + p.wall_z[i, j], s.q[i, j]
            q_r = s.q_r[i, j] + near * s.q_side[0, j] + far * s.q_side[1, j]
            s.a[i, j] = -u * (s.g_r[i, j] + p.wall_r[i, j]) - v * g_z
            s.b[i, j] = 2.0 * (u * q + g * g_z * over) * over - u * q_r - v * s.q_z[i, j]
            s.q_wave[now, i, j] += p.wall_wave[i, j]
            fastest = max(fastest, abs(u) * dr + abs(v) * p.over_dz[j])
        most = max(most, fastest)
    # back to shares, in which diffusion is diagonal
    clock[CONVECTION] = most
    product(p.r_forward, s.a, s.g_r)
    product(s.g_r, p.even_forward, s.g_rate[now])
    product(p.r_forward, s.b, s.g_r)
    product(s.g_r, p.odd_forward, s.q_rate[now])


@njit(types.float64(plan_type, state_type, vector_type, types.int64), **COMPILED)
def missed(p: Plan, s: State, clock: Floats, known: int) -> float:
    """Root mean square of the new angular velocity less the one extrapolated from ``known`` instants, rad/s."""
    m, n = p.odd_rates.shape
    head = int(clock[HEAD])
    new = (head + 1) % LEVELS
    total = 0.0
    for i in range(m):
        for j in range(n):
            s.b[i, j] = s.g[new, i, j]
        for k in range(known):
            x, level = s.weights[2, k], (head - k) % LEVELS
            for j in range(n):
                s.b[i, j] -= x * s.g[level, i, j]
        part = 0.0
        for j in range(n):
            part += s.b[i, j] * s.b[i, j]
        total += part * p.over_r[i] ** 4
    return (total / (m * n)) ** 0.5


# The implicit step of the spectral flow solver: its inverse row by row, and wall vorticity by an influence matrix.
#
# With s the leading weight of the derivative, W the reference speed of the rotor, K and K' the slopes along z in
# shares and F what is known, a step is
#
#     (s - nu L) g = F_g + 2 W K psi,   (s - nu L) q = F_q + 2 W K' g + c x + d y,   q = -L psi,
#
# x, y being nu times the vorticity on the walls. K and K' act along z only, so each share along r is a small system of
# its own,
#
#     M_i psi_i = F_q + 2 W K' F_g/(s - nu L) + c_i x + d y_i,   M_i = (s - nu L)(-L) - 4 W^2 K' (s - nu L)^-1 K.
#
# At the walls psi vanishes and so do its slopes, sum_i p_i psi_i = 0 and sum_j s_j psi_ij = 0. This is a linear system
# for x and y, the influence matrix (Ehrenstein and Peyret 1989). It is singular once for each corner, where a pattern
# of wall values acts on no inner point; these patterns are filled up.


@njit(types.void(plan_type, state_type, types.float64, types.float64), **COMPILED)
def _rows(p: Plan, s: State, shift: float, reference: float) -> None:
    """Inverses of M_i; of a reference of zero only the diagonals are set, because there is nothing else."""
    m, n = p.odd_rates.shape
    squared = 4.0 * reference * reference
    for i in range(m):
        if reference == 0.0:
            for j in range(n):
                for k in range(n):
                    s.green[i, j, k] = 0.0
                s.green[i, j, j] = 1.0 / ((p.viscosity * p.odd_rates[i, j] - shift) * p.odd_rates[i, j])
            continue
        for j in range(n):
            own = 1.0 / ((p.viscosity * p.odd_rates[i, j] - shift) * p.odd_rates[i, j])
            for k in range(n):
                s.block[j, k] = 0.0
            for k in range(n):
                x = p.to_odd[k, j] * s.scale[i, k] * squared * own
                for other in range(n):
                    s.block[j, other] -= x * p.to_even[other, k]
            s.block[j, j] += 1.0
        invert(s.block, s.pivots)
        for j in range(n):
            for k in range(n):
                s.green[i, k, j] = s.block[j, k] / ((p.viscosity * p.odd_rates[i, k] - shift) * p.odd_rates[i, k])


@njit(types.void(plan_type, state_type), **COMPILED)
def _influence(p: Plan, s: State) -> None:
    """Slopes at the walls over the wall vorticity."""
    m, n = p.odd_rates.shape
    lids = p.d.shape[0]
    a = s.influence
    for i in range(a.shape[0]):
        for j in range(a.shape[0]):
            a[i, j] = 0.0
    for i in range(m):
        for j in range(n):
            for u in range(2):
                for v in range(2):
                    x = p.p[u, i] * p.c[v, i]
                    for k in range(n):
                        a[u * n + j, v * n + k] += x * s.green[i, k, j]
            for k in range(n):
                green = s.green[i, k, j]
                for w in range(lids):
                    at = 2 * n + w * m + i
                    for u in range(2):
                        a[u * n + j, at] += p.p[u, i] * green * p.d[w, k]
                        a[at, u * n + k] += p.s[w, j] * green * p.c[u, i]
                    for v in range(lids):
                        a[at, 2 * n + v * m + i] += p.s[w, j] * green * p.d[v, k]


@njit(types.void(matrix_type, state_type), **COMPILED)
def _balance(a: Matrix, s: State) -> None:
    """Rows and columns scaled to a greatest entry of one; the scales are kept."""
    size = a.shape[0]
    for i in range(size):
        most = 0.0
        for j in range(size):
            most = max(most, abs(a[i, j]))
        s.rows[i] = 1.0 / most
    for j in range(size):
        s.columns[j] = 0.0
    for i in range(size):
        for j in range(size):
            s.columns[j] = max(s.columns[j], abs(a[i, j]) * s.rows[i])
    for j in range(size):
        s.columns[j] = 1.0 / s.columns[j]
    for i in range(size):
        for j in range(size):
            a[i, j] *= s.rows[i] * s.columns[j]


@njit(types.void(plan_type, state_type, types.float64, types.float64), **COMPILED)
def prepare(p: Plan, s: State, shift: float, reference: float) -> None:
    """Everything that depends on the leading weight of a step and on the reference speed."""
    m, n = p.odd_rates.shape
    for i in range(m):
        for j in range(n):
            s.scale[i, j] = 1.0 / (shift - p.viscosity * p.even_rates[i, j])
    _rows(p, s, shift, reference)
    _influence(p, s)
    _balance(s.influence, s)
    size = s.influence.shape[0]
    for corner in range(p.right.shape[0]):
        left, right = 0.0, 0.0
        for i in range(size):
            left += (p.left[corner, i] / s.rows[i]) ** 2
            right += (p.right[corner, i] / s.columns[i]) ** 2
        norm = 1.0 / (left * right) ** 0.5
        for i in range(size):
            x = p.left[corner, i] / s.rows[i] * norm
            for j in range(size):
                s.influence[i, j] += x * p.right[corner, j] / s.columns[j]
    factorize(s.influence, s.pivots)


# Speed of the walls within one piece of a profile.


RECORD = 2  # kind of a piece: a record, whose numbers are step, count and pairs of value and slope times step


@njit(**INLINE)
def wall_speed(time: float, start: float, kind: float, numbers: Floats) -> tuple[float, float]:
    """Speed of the walls and its rate; ``kind`` and ``numbers`` as a segment of the drive, or a record."""
    if kind == RECORD:
        count = int(numbers[1])
        place = (time - start) / numbers[0]
        inside = min(max(place, 0.0), count - 1.0)
        i = min(int(inside), count - 2)
        s, a = inside - i, 2 + 2 * i
        speed = between(numbers[a], numbers[a + 1], numbers[a + 2], numbers[a + 3], s)
        if inside != place:
            return speed, 0.0
        d = numbers[a + 2] - numbers[a]
        m, n = numbers[a + 1] - d, d - numbers[a + 3]
        return speed, (d + (1.0 - 2.0 * s) * (m * (1.0 - s) + n * s) + s * (1.0 - s) * (n - m)) / numbers[0]
    if kind == HILL:
        if time <= 0.0:
            return numbers[3], 0.0
        ratio = (time / numbers[1]) ** numbers[2]
        rise = ratio / (1.0 + ratio)
        span = numbers[0] - numbers[3]
        return numbers[3] + span * rise, span * rise * numbers[2] / (time * (1.0 + ratio))
    return numbers[0] + numbers[1] * (time - start), numbers[1]
