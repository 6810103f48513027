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

from numba import types

from autobalancer.kernels.flags import COMPILED, njit
from autobalancer.kernels.flow.spectral_arrays import (
    ACCEPTED,
    AGO,
    CONVECTION,
    HEAD,
    KNOWN,
    LEAST,
    LENGTH,
    LEVELS,
    LOST,
    REFERENCE,
    REJECTED,
    SHIFT,
    TIME,
    WAVES,
    Plan,
    State,
    plan_type,
    state_type,
)
from autobalancer.kernels.flow.spectral_terms import implicit, missed, remember, weigh
from autobalancer.kernels.flow.spectral_walls import prepare
from autobalancer.kernels.flow.speed import wall_speed
from autobalancer.kernels.system import Floats, Matrix, matrix_type, vector_type

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
        speed, rate = wall_speed(after, start, kind, numbers)
        reference = clock[REFERENCE]
        if clock[WAVES] > 0.0 and not abs(speed - reference) * 2.0 * step <= DRIFT:
            reference = speed
        if s.weights[0, 0] != clock[SHIFT] or reference != clock[REFERENCE]:
            clock[SHIFT], clock[REFERENCE] = s.weights[0, 0], reference
            prepare(p, s, clock[SHIFT], reference)
        implicit(p, s, clock, used, rate)
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
