"""The averaged equations: Spannan (2021), chapter 4."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.polynomial import Polynomial

from autobalancer.arrays import Complexes, Floats, Matrix
from autobalancer.assembly.terms import Theory, ignores
from autobalancer.errors import QuestionError, RangeWarning, warn
from autobalancer.files.machine_file import balls_in_races
from autobalancer.machine import Machine
from autobalancer.stability.border import Border, ignoring
from autobalancer.stability.host.stations import Plane, Stations, plane
from autobalancer.stability.states.linearized import deciding_eigenvalues
from autobalancer.stability.states.rest_states import StationState
from autobalancer.units import unbalance_argument

# The averaged equations of motion of a planar rotor, Spannan (2021), section 4.1.2, with the misprints corrected, for
# any balls.
#
# With x = Re[a_x e^(i W t)], y = Im[a_y e^(i W t)], a = A + iB (4.18) and the forward whirl Z = (a_x + a_y)/2:
#
#     a_x' = -i/(2 M W) [W^2 F + 2 W sum s e^(i phi) phi' - D_x a_x],   D_x = k_x - M W^2 + i b_x W,   likewise a_y
#     beta phi' = s W Im[e^(-i phi) (W c - i Z')],   c = Z + E,   F = U + sum m E + sum s e^(i phi),   s = m eps
#
# Corrected against the print: the sign in (4.24), cos to sin in row 4 of matrix B (4.68). The inertia of the ball
# angle is left out, as in the source, and motions are slow against the speed. So borders found here are those of the
# exact equations only for heavily damped balls and small S: the decay rate beta/I of a ball large against that of the
# rotor, b/(2M), and against (N S/2) w_c, and N S/2 below about 0.1. Then they agree to better than a percent.
#
# They are linearized as those of one station of any rotor, :mod:`autobalancer.stability.averaged`.


MachineArgument = Plane | Machine | str | Path


def averaged_plane(machine: MachineArgument, unbalance: complex | float | str | None = None) -> Plane:
    """The numbers of a machine (or the path of its file) that this theory needs, with another unbalance if given."""
    unbalance = unbalance_argument(unbalance)
    _, p = _machine_and_plane(machine)
    return p if unbalance is None else replace(p, unbalance=complex(unbalance))


def _machine_and_plane(machine: MachineArgument) -> tuple[Machine | None, Plane]:
    """What was given, if it is more than a plane, and its plane."""
    if isinstance(machine, Plane):
        return None, machine
    machine = balls_in_races(machine)
    return machine, plane(machine)


# The averaged border in closed form, and the exact border of balls without inertia.
#
# On isotropic supports and for races on the axis the averaged equations see the balls only through g = sum s^2/beta and
# |g2|, g2 = sum (s^2/beta) e^(2 i phi), s = m eps. For g2 = 0, the worst case, they are stable if and only if
#
#     (w_c^2 g / (2 b)) (W^2 + w_c^2) < W^2 - w_c^2,
#
# which is (4.74) of Spannan (2021) for two equal balls (g = 2 (m eps)^2/beta) and (A.7) for one ball, for which it is
# sufficient only. N equal balls: g = N (m eps)^2/beta, so the greatest admissible S = (m eps w_c)^2/(b beta) is 2/N.
# What takes its place on orthotropic supports is derived in :mod:`~autobalancer.stability.averaged`.
#
# For balls without inertia the exact equations give W > w_c (1 + w_c^2 g/(2 b)), the same to first order; so the
# *never* of the averaged border belongs to the averaging, not to the balancer. Where beta/I is not large against
# b/(2M) and (N S/2) w_c neither this limit nor (4.74) stands in for the exact border.


WORST = "averaged border, worst case"


def damping_share(machine: MachineArgument, unbalance: complex | float | None = None) -> float:
    """w_c^2 g / (2 b), S N/2 for N equal balls: the averaged balanced state is stable at high speed if it is below 1.

    Raises
    ------
    QuestionError
        If the supports are not isotropic, a race is off the axis, or rotor or balls are undamped.
    """
    p = averaged_plane(machine, unbalance)
    _closed_form(p)
    return float(p.stiffness[0] / p.mass * (p.moment**2 / p.drag).sum() / (2.0 * p.damping[0]))


def explicit_averaged_border(machine: MachineArgument) -> Border:
    """Averaged border in closed form, worst case over the unbalance of ``machine``, for any balls in races on the axis.

    On isotropic supports (4.74) and (A.7); on orthotropic ones the highest root of a polynomial of degree five in W^2, above
    which the state stays stable, at least up to 40 times the higher critical speed.

    Raises
    ------
    QuestionError
        If a race is off the axis, or rotor or balls are undamped.
    """
    whole, p = _machine_and_plane(machine)
    border = _closed_border(p)
    return border if whole is None else ignoring(whole, border, Theory.AVERAGED)


def _closed_border(p: Plane) -> Border:
    if p.isotropic:
        share = damping_share(p)
        if share >= 1.0:
            why = "for the worst unbalance up to the capability; drag or damping is too small (Spannan 2021, 4.75)"
            return Border(WORST, math.inf, why)
        speed = math.sqrt(p.stiffness[0] / p.mass * (1.0 + share) / (1.0 - share))
        return Border(WORST, speed, "sufficient only" if p.moment.size == 1 else "")
    # on orthotropic supports the last range in which it is stable
    _closed_form(p, isotropic=False)
    searched = p.highest_searched
    ranges = stable_ranges(p)
    last = next((one for one in ranges if one[0] < searched <= one[1]), None)
    windows = tuple(one for one in ranges if one != last)
    if last is None:
        return Border(WORST, math.inf, "drag or damping is too small", windows=windows)
    others = [f"{low:.6g} to {high:.6g} rad/s" for low, high in windows]
    notes = [f"stable also {', '.join(others)}"] if others else []
    if p.moment.size == 1:
        notes.insert(0, "sufficient only")
    if math.isfinite(last[1]):
        notes.append(f"up to {last[1]:.6g} rad/s")
    return Border(WORST, last[0], "; ".join(notes), windows=windows)


def minimum_drag(machine: MachineArgument, speed: float = math.inf) -> float:
    """Drag beta that every ball needs to be stable at ``speed`` by the averaged equations, N m s, whatever the unbalance.

    (4.74) solved for beta, and what takes its place on orthotropic supports. At infinite speed this is (4.75): N/2 times
    (m eps w_c)^2 / b for N equal balls on isotropic supports.

    Raises
    ------
    QuestionError
        As :func:`explicit_averaged_border`, or if the forward whirl does not lag by more than a quarter turn at the speed; on
        isotropic supports it does above the critical speed.
    """
    p = averaged_plane(machine)
    _closed_form(replace(p, drag=np.ones_like(p.drag)), isotropic=False)
    most = greatest_g(p, speed)
    if not most > 0.0:
        must = (
            f"above the critical speed of {p.critical_speeds[0]:.6g} rad/s"
            if p.isotropic
            else "in one of speed_windows"
        )
        raise QuestionError(f"minimum drag: given {speed:.6g} rad/s, where no drag is enough; must be {must}")
    return float((p.moment**2).sum()) / most


def _closed_form(p: Plane, *, isotropic: bool = True) -> None:
    reasons = {
        "it has no balls": p.moment.size == 0,
        "its supports are not isotropic": isotropic and not p.isotropic,
        "a race is off the axis": bool(np.any(p.offset != 0.0)),
        "its rotor or its balls are undamped": max(p.damping) <= 0.0 or not (p.drag > 0.0).all(),
    }
    for reason, true in reasons.items():
        if true:
            raise QuestionError(f"averaged border: no closed form for this machine: {reason}")


# The averaged border on orthotropic supports in closed form: (4.74) of Spannan (2021) where x and y differ.
#
# Balls whose races run true are seen through g = sum s^2/beta and g2 = sum (s^2/beta) e^(2 i phi) only, as on
# isotropic supports, because the averaged torque knows nothing but the forward whirl. For g2 = 0 the equation for an
# eigenvalue q splits into a cubic and its conjugate,
#
#     q R_x R_y = (g W^2/2) (W - iq) (W - 2iq) (R_x + R_y)/2,    R = k - M W^2 + i b W + 2 i M W q  of x and y.
#
# With k, b the means over both directions and D, d half the differences (y less x), it has an imaginary root if and
# only if
#
#     K^3 + [(b^2 + d^2) W^2 - D^2] K = 2 b d D W^2    for a real K, with c = (k - K)/M, and
#     g = 2/(b c W^2) (W^2 - c)/(W^2 + c) [D^2 - K^2 + (b^2 - d^2) W^2].
#
# So the limit of g, hence of the drag, is explicit at each speed: one cubic, of which K = 0 is a root where stiffness
# or damping are alike in x and y. On isotropic supports K = 0 and c = w_c^2, which is (4.74). The border speeds for a
# given g are not explicit. But both lines are linear in W^2 once the bracket is replaced by means of the first;
# without K they leave a polynomial of degree five in W^2, whose roots are all border speeds at once. At high speed
# the limit is
#
#     g = 4 M b_x b_y / ((b_x + b_y) k'),    k' = (k_x b_y^2 + k_y b_x^2)/(b_x^2 + b_y^2),
#
# (4.75) for supports that differ. That g2 = 0 is the worst case over the unbalance is proved on isotropic supports
# only; elsewhere it was so for all of 65 000 random machines and speeds at which the forward whirl lags and g is
# below every limit.


DOUBLE = 1e-6  # share of an imaginary part below which roots may be a double real one
Range = tuple[float, float]


def greatest_g(p: Plane, speed: float) -> float:
    """The greatest g = sum s^2/beta, kg s, with which the balanced state is stable at a speed, which may be infinite.

    Zero where the forward whirl does not lag by more than a quarter turn, as below the lower critical speed.
    """
    (kx, ky), (bx, by) = p.stiffness, p.damping
    if not bx + by > 0.0:
        return 0.0
    if math.isinf(speed):
        return 4.0 * p.mass * bx * by * (bx * bx + by * by) / ((bx + by) * (kx * by * by + ky * bx * bx))
    if not p.dynamic_stiffness(speed).real < 0.0:
        return 0.0
    unit, diff, b, d = _scaled(p)
    y = (speed / unit) ** 2
    cubic = Polynomial([-2.0 * b * d * diff * y, (b * b + d * d) * y - diff * diff, 0.0, 1.0])
    limits = []
    for left in _real(cubic):
        c = 1.0 - left
        limits.append(2.0 / (b * c * y) * (y - c) / (y + c) * (diff * diff - left * left + (b * b - d * d) * y))
    return p.mass / unit * min((g for g in limits if g > 0.0), default=math.inf)


def stable_ranges(p: Plane) -> list[Range]:
    """All speeds at which the balanced state of these balls with g2 = 0 is stable, rad/s; the last may end at infinity."""
    unit = _scaled(p)[0]
    edges = [0.0, *_crossings(p), math.inf]
    ranges: list[Range] = []
    for low, high in pairwise(edges):
        middle = (2.0 * low or 1.0) if math.isinf(high) else 0.5 * high if low == 0.0 else math.sqrt(low * high)
        if not _stable(p, middle):
            continue
        start = ranges.pop()[0] if ranges and ranges[-1][1] == low * unit else low * unit
        ranges.append((start, high * unit))
    return ranges


def _scaled(p: Plane) -> tuple[float, float, float, float]:
    """A unit of speed, sqrt(k/M), and in units of k and M D, b, d: means and half the differences."""
    (kx, ky), (bx, by) = p.stiffness, p.damping
    k = 0.5 * (kx + ky)
    unit = math.sqrt(k / p.mass)
    damping = p.mass * unit
    return unit, 0.5 * (ky - kx) / k, 0.5 * (bx + by) / damping, 0.5 * (by - bx) / damping


def _crossings(p: Plane) -> list[float]:
    """Speeds at which a root crosses the imaginary axis, in units, ascending; a double one may be none.

    W^2 is linear in both conditions, and the second one, with the first, is quadratic in K: this is their resultant.
    """
    unit, diff, b, d = _scaled(p)
    g = float((p.moment**2 / p.drag).sum()) * unit / p.mass
    h = d * diff
    y = Polynomial([0.0, 1.0])  # W^2
    first, rest = (b * b + d * d) * y - diff * diff, -2.0 * b * y  # K^3 + first K + h rest = 0
    two, one = -g * (y + 2.0) - 4.0 * b, g * (y + 1.0 - first) - 4.0 * (b * (y - 1.0) - h)
    none = 2.0 * b * g * y + 4.0 * (y - 1.0)  # two K^2 + one K + h none = 0
    resultant = (first * none - rest * one) * (one**2 + first * two**2) + h * (
        two * rest * (two**2 * rest + 3.0 * one * none) - 2.0 * two * first * none**2 + h * none**3
    )
    return sorted(math.sqrt(square) for square in _real(resultant) if square > 0.0)


def _stable(p: Plane, speed: float) -> bool:
    """Whether the three roots decay, at a speed in units."""
    unit, diff, b, d = _scaled(p)
    w = speed
    q = Polynomial([0.0, 1.0])
    x, y = (1.0 + s * diff - w * w + 1j * (b + s * d) * w + 2j * w * q for s in (-1.0, 1.0))
    g = float((p.moment**2 / p.drag).sum()) * unit / p.mass
    cubic = q * x * y - 0.25 * g * w * w * (w - 1j * q) * (w - 2j * q) * (x + y)
    return bool(cubic.roots().real.max() < 0.0)


def _real(whole: Polynomial) -> list[float]:
    """Real roots, each improved by two steps of Newton's method."""
    slope, real = whole.deriv(), []
    for root in np.atleast_1d(whole.trim().roots()):
        if abs(root.imag) > DOUBLE * abs(root):
            continue
        x = float(root.real)
        for _ in range(2):
            step = float(slope(x))
            x = x - float(whole(x)) / step if step != 0.0 else x
        real.append(x)
    return real


# The averaged equations of balls on any rotor, linearized about a state of rest in the rotor.
#
# Coordinates x = Re[a_x e^(i W t)], y = Im[a_y e^(i W t)] with slow a, as are the ball angles. With a = (a_x, a_y,
# others), rows B_p of the stations over x, R = (B, B, 0), s = m eps, D = K + iW (C + WG) - W^2 M and F the load R^T U
# of unbalances and balls, averaging over a turn to first order in damping, balls and slow rates leaves
#
#     (2iW M + WG) a' = W^2 F + 2W sum s R^T e^(i phi) phi' - D a
#     beta phi' = s W Im[e^(-i phi) (W (Z_p + E) - i Z_p')],    Z = R a / 2
#
# where rows and columns of y in M, C, G and K are multiplied by i and -i. Balls feel the forward whirl Z only, the
# backward part has no mean. One pair of coordinates gives :mod:`autobalancer.stability.averaged`, Spannan
# (2021), (4.24)-(4.29). Where x and y are alike balls move the forward whirl a_x = a_y = Z of the coordinates only,
# and the equations are those of Z.
#
# The gyroscopic part of the first factor is not small and stays: with it an undamped mode that whirls forward at v
# goes through its resonance as i (v - W), exact at W = v. The inertia of the ball angle is left out, and so is all
# that balls feel beyond the deflection of their race.


LOST = 1e-7  # singular value, over the greatest, of ball motions that move nothing


class Whirl(NamedTuple):
    """What balls move at k speeds: h complex coordinates a, of which the share Z = ``felt`` R a is felt."""

    slow: Complexes  # (k, h, h) before a'
    held: Complexes  # D, (k, h, h)
    rows: Matrix  # R, (P, h)
    felt: float
    mass: Floats  # (h,)


def whirl_of(st: Stations, speeds: Floats) -> Whirl:
    """The matrices of the rotor at speeds (k,)."""
    w, model, n = speeds[:, None, None], st.model, st.model.pairs
    damping, stiffness = model.damping, model.stiffness
    if model.speeds.size > 1:
        damping, stiffness = (
            np.array([at(speed) for speed in speeds]) for at in (model.damping_at, model.stiffness_at)
        )
    slow = np.asarray(2j * w * model.mass + w * model.gyroscopic, np.complex128)
    moving = damping + w * model.gyroscopic
    held = np.asarray(stiffness - w * w * model.mass + 1j * w * moving, np.complex128)
    mass = np.diag(model.mass)
    if st.isotropic:
        slow, held = (matrix[:, :n, :n] + 1j * matrix[:, n : 2 * n, :n] for matrix in (slow, held))
        return Whirl(slow, held, st.rows, 1.0, mass[:n])
    quarter = np.ones(model.size, np.complex128)
    quarter[n : 2 * n] = 1j
    seen = np.outer(quarter, quarter.conj())
    rows = np.concatenate([st.rows, st.rows, np.zeros((len(st.names), model.size - 2 * n))], 1)
    return Whirl(np.asarray(seen * slow), np.asarray(seen * held), rows, 0.5, mass)


def averaged_station_eigenvalues(st: Stations, speed: float, state: StationState) -> Complexes:
    """Eigenvalues, 1/s, the fastest growing first.

    Raises
    ------
    QuestionError
        If a ball has no drag.
    """
    center = state.whirl[st.station] + st.offset
    values = eigenvalues_at(st, np.array([speed]), state.angles[None], center[None])[0]
    return np.asarray(values[np.argsort(-values.real, kind="stable")], np.complex128)


def eigenvalues_at(st: Stations, speeds: Floats, angles: Matrix, centers: Complexes) -> Complexes:
    """Eigenvalues at k speeds for ball angles and race centers in the rotor, both (k, n); (k, size), 1/s.

    Raises
    ------
    QuestionError
        If a ball has no drag.
    """
    refuse_without_drag(st.drag)
    whirl = whirl_of(st, speeds)
    a, b = _matrices(st, speeds, angles, centers, whirl)
    heavy = np.sqrt(whirl.mass * float(speeds.mean()))
    unit = 1.0 / np.concatenate([heavy, heavy, np.sqrt(st.drag)])
    scale = np.outer(unit, unit)
    return np.asarray(np.linalg.eigvals(-np.linalg.solve(a * scale, b * scale)), np.complex128)


def averaged_station_growth(st: Stations, speed: float, state: StationState) -> float:
    """Greatest real part that counts, 1/s: of a balanced state without the zeros of balls that may be moved for nothing."""
    return float(deciding_eigenvalues(averaged_station_eigenvalues(st, speed, state), _neutral(st, state)).real.max())


def averaged_station_growths(st: Stations, speeds: Floats, state: StationState) -> Floats:
    """The same at many speeds, (k,), of a state whose angles and deflections are alike at all of them."""
    k, center = speeds.size, state.whirl[st.station] + st.offset
    values = eigenvalues_at(st, speeds, np.tile(state.angles, (k, 1)), np.tile(center, (k, 1)))
    order = np.argsort(np.abs(values), axis=1)[:, _neutral(st, state) :]
    return np.asarray(np.take_along_axis(values.real, order, axis=1).max(axis=1))


def refuse_without_drag(drag: Floats) -> None:
    """Refuse balls without drag: the averaged equations, which leave out their inertia, say nothing about them.

    Raises
    ------
    QuestionError
        If there is one.
    """
    if not (drag > 0.0).all():
        raise QuestionError("averaged theory: a ball without drag has no averaged equation of motion; give it some")


def _matrices(st: Stations, speeds: Floats, angles: Matrix, centers: Complexes, whirl: Whirl) -> tuple[Matrix, Matrix]:
    """A and B at k speeds, each (k, size, size)."""
    n, h, w, felt = st.moment.size, whirl.held.shape[1], speeds[:, None, None], whirl.felt
    push = whirl.rows[st.station].T * (st.moment * np.exp(1j * angles))[:, None]  # (k, h, n)
    a, b = (np.zeros((speeds.size, 2 * h + n, 2 * h + n)) for _ in range(2))
    host, ball, each = slice(0, 2 * h), slice(2 * h, None), 2 * h + np.arange(n)
    a[:, host, host] = _real_form(whirl.slow)
    b[:, host, host] = _real_form(whirl.held)
    along, across = _parts(push), _parts(1j * push)
    a[:, host, ball], b[:, host, ball] = -2.0 * w * along, -w * w * across
    # Re[e^(-i phi) z] and Im[e^(-i phi) z] of a complex z as rows over its real and imaginary part
    a[:, ball, host] = felt * w * along.swapaxes(1, 2)
    b[:, ball, host] = -felt * w * w * across.swapaxes(1, 2)
    a[:, each, each] = st.drag
    b[:, each, each] = speeds[:, None] ** 2 * (st.moment * np.exp(-1j * angles) * centers).real
    return a, b


def _neutral(st: Stations, state: StationState) -> int:
    """Dimension of the small ball motions that leave a balanced rotor balanced."""
    if state.name != "balanced":
        return 0
    weight = np.sqrt(np.diag(st.model.mass)[: st.model.pairs])
    push = st.rows[st.station].T * (st.moment * np.exp(1j * state.angles)) / weight[:, None]
    reach = np.linalg.svd(np.vstack([push.real, push.imag]), compute_uv=False)
    return st.moment.size - int(np.sum(reach > LOST * reach[0]))


def _real_form(matrices: Complexes) -> Matrix:
    return np.block([[matrices.real, -matrices.imag], [matrices.imag, matrices.real]])


def _parts(columns: Complexes) -> Matrix:
    return np.concatenate([columns.real, columns.imag], axis=1)


# Speed ranges in which balls are drawn towards the light side: the forward whirl must lag by more than a quarter turn.
#
# On orthotropic supports the balls feel the forward part of the whirl only; the backward part averages out over a
# turn. The averaged torque balances where Re(1/D) < 0, 1/D = (1/D_x + 1/D_y)/2 the forward receptance. Without damping
# this gives the two ranges of Spannan (2021), section 4.2.1: w_x to w_r and above w_y, w_r^2 = (w_x^2 + w_y^2)/2
# (4.71).
#
# It is necessary, not sufficient: within a range the averaged or the exact border says from which speed on the
# balanced state is stable.


Window = tuple[float, float]


def speed_windows(machine: MachineArgument, *, damped: bool = False) -> list[Window]:
    """Speed ranges (low, high) in rad/s, ascending, in which the averaged torque moves balls to the light side.

    Parameters
    ----------
    machine
        A machine, the path of its file, or its plane.
    damped
        If true, the sign of the real part of the forward receptance decides, and damping may close the lower range. If
        false, the undamped theory: (w_x, w_r) and (w_y, inf), one range where both critical speeds are one.
    """
    whole, p = _machine_and_plane(machine)
    if whole is not None and (left_out := ignores(whole, Theory.AVERAGED)):
        warn(f"speed windows: the averaged theory {left_out}", RangeWarning)
    squares = sorted(k / p.mass for k in p.stiffness)
    if not damped:
        low, high = (math.sqrt(square) for square in squares)
        middle = math.sqrt(0.5 * sum(squares))
        return [(low, math.inf)] if low == high else [(low, middle), (high, math.inf)]
    unit = squares[1]  # Re(1/D) |D_x D_y|^2 is a cubic in u = (W/unit speed)^2
    detuning = [Polynomial([k / (p.mass * unit), -1.0]) for k in p.stiffness]
    amount = [d**2 + Polynomial([0.0, b**2 / (p.mass**2 * unit)]) for d, b in zip(detuning, p.damping, strict=True)]
    lag = detuning[0] * amount[1] + detuning[1] * amount[0]
    roots = np.asarray(lag.roots(), np.complex128)
    edges = sorted(roots.real[(roots.real > 0.0) & (np.abs(roots.imag) < 1e-7 * np.abs(roots))].tolist())
    points = [0.0, *edges, 2.0 * max(edges, default=1.0)]
    windows: list[Window] = []
    for first, last in zip(points, [*edges, math.inf], strict=False):
        inside = 2.0 * first + 1.0 if last == math.inf else 0.5 * (first + last)
        if float(lag(inside)) < 0.0 and last > first:
            low, high = math.sqrt(first * unit), math.sqrt(last * unit)
            if windows and windows[-1][1] == low:  # a double root parts nothing
                low = windows.pop()[0]
            windows.append((low, high))
    return windows
