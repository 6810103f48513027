"""A flow solved by the full equations, with the points, the scheme and the certainty that it needs."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.linalg import block_diag

from autobalancer.arrays import Floats, Matrix
from autobalancer.errors import QuestionError
from autobalancer.flow.annulus import Annulus, Walls
from autobalancer.flow.relaxation import Expected, Solved, Track, WallSpeed
from autobalancer.kernels import annulus_flow
from autobalancer.kernels.annulus_flow import integrate_flow, remember
from autobalancer.progress import Progress

Fields = tuple[Floats, Floats, Floats, float, float]

MOST = 160  # intervals in one direction
EDDIES, EDDIES_AT, EDDIES_POWER = 40.0, 8800.0, 0.3  # intervals over the gap that carry them, measured
CONVECTION = 1.2  # rate of the convection limit over lag and intervals, measured
STEP = (4e-6, 8.5e-10)  # s of one step on a common processor: alone, and over (intervals)^3
LONGEST = 300.0  # s of computing that are begun without being asked
SHARES = {2: 0.002, 3: 0.02}  # of the error asked for that a single step may make, by the order of the integration


def by_solver(
    annulus: Annulus,
    walls: WallSpeed,
    end: float,
    grid: Floats,
    moments: list[float],
    seen: Expected,
    points: tuple[int, int] | None,
    error: float,
    progress: Progress | None,
) -> Solved:
    """By the full equations, with more points where those chosen do not resolve the flow.

    Raises
    ------
    QuestionError
        If given points do not resolve it, or chosen ones would take too long.
    """
    chosen, uncertainty = chosen_points(annulus, seen, points, error), 0.0
    kept: list[Fields] = []
    if points is None:
        # refuse what takes too long
        time = seconds(seen, chosen)
        if time > LONGEST:
            raise QuestionError(
                f"flow: fluid of {1e6 * annulus.viscosity:.3g} mm^2/s would lag by about {seen.lag * seen.fastest:.3g} rad/s, a "
                f"turbulent flow that takes {chosen[0]}x{chosen[1]} points and about {time / 60.0:.0f} minutes; speed up more "
                "slowly, shorten the duration, or take the model 'modes' (fluid.lag = 'modes'), which overestimates the lag; "
                f"'points' (--points {chosen[0]}x{chosen[1]}) starts it anyway"
            )
    flow, track = _resolved(annulus, walls, end, moments, seen, chosen, points is None, error, kept, progress)
    if seen.unsteady and points is None:
        uncertainty = _uncertainty(flow, track, walls, end, seen, SHARES[flow.order] * error)
    times, _, orbit = track.arrays()
    swirl, stream, vorticity, torque, momentum = (np.array(part) for part in zip(*kept, strict=True))
    return Solved(
        model="chebyshev",
        times=grid,
        speed=walls.over(grid),
        orbit=CubicSpline(times, orbit)(grid),
        radius=flow.radius,
        height=flow.height,
        moments=np.array(moments),
        swirl=swirl,
        stream=stream,
        vorticity=vorticity,
        torque=torque,
        momentum=momentum,
        moment_speed=walls.over(np.array(moments)),
        steps=track.steps,
        uncertainty=uncertainty,
    )


def spectral_flow(annulus: Annulus, seen: Expected, points: tuple[int, int]) -> SpectralFlow:
    """The Chebyshev solver as it suits a flow.

    Waves of the turning fluid would limit the step of a steady flow, and are implicit there. An unsteady one is limited by
    convection anyhow and wants the order three; products of its fields are filtered.
    """
    if seen.unsteady:
        return SpectralFlow(annulus, *points, smooth=True)
    return SpectralFlow(annulus, *points, order=2, waves=True)


def _resolved(
    annulus: Annulus,
    walls: WallSpeed,
    end: float,
    moments: list[float],
    seen: Expected,
    points: tuple[int, int],
    more: bool,
    error: float,
    kept: list[Fields],
    progress: Progress | None,
) -> tuple[SpectralFlow, Track]:
    while True:
        flow = spectral_flow(annulus, seen, points)
        kept.clear()

        def keep(time: float, flow: SpectralFlow = flow) -> None:
            kept.append(_fields(flow, walls, time))

        try:
            track = flow.march(
                walls, end, tolerance=SHARES[flow.order] * error, stops=moments, at_stop=keep, progress=progress
            )
        except QuestionError:
            better = finer(points) if more else None
            if better is None:
                raise
            points = better
        else:
            return flow, track


def _fields(flow: SpectralFlow, walls: WallSpeed, time: float) -> Fields:
    r = flow.radius[:, None]
    speed = walls.at(time)[0]
    return flow.swirl / r**2, flow.stream.copy(), flow.vorticity / r, flow.torque(), flow.momentum(speed)


def _uncertainty(
    flow: SpectralFlow, track: Track, walls: WallSpeed, end: float, seen: Expected, tolerance: float
) -> float:
    """Greatest difference of the speed at the orbit from that with three quarters of the points, over the greatest speed."""
    points = 3 * (flow.radius.size - 1) // 4, 3 * (flow.height.size - 1) // 4
    try:
        other = spectral_flow(flow.annulus, seen, points).march(walls, end, tolerance=tolerance)
    except QuestionError:
        return float("nan")
    (times, _, orbit), (grid, _, others) = track.arrays(), other.arrays()
    return float(np.abs(orbit - np.interp(times, grid, others)).max()) / seen.fastest


def layer(annulus: Annulus, fastest: float) -> float:
    """Thickness of the Ekman layers, sqrt(nu/w), m; at most the chamber."""
    return min(math.sqrt(annulus.viscosity / max(fastest, 1e-300)), annulus.width, annulus.height)


def points_for(annulus: Annulus, seen: Expected, error: float) -> tuple[tuple[int, int], tuple[int, int]]:
    """Intervals (radial, axial): what is needed at least, and what gives the orbit within about ``error``.

    Chebyshev points crowd at the walls, so their number grows with the root of length over layer.
    """
    thin = layer(annulus, seen.fastest)
    needed, wanted = [], []
    for length in (annulus.width, annulus.height):
        base = math.sqrt(length / thin)
        good = (3.0 + 2.5 * seen.lag) * base
        if seen.unsteady:
            eddies = EDDIES * (seen.reynolds / EDDIES_AT) ** EDDIES_POWER
            good = max(good, eddies * math.sqrt(length / annulus.width))
        digits = max(0.0, math.log10(1e-3 / error))
        few = 12.0 + 6.0 * seen.lag + 4.0 * digits
        needed.append(max(6, math.ceil(2.2 * base)))
        wanted.append(2 * math.ceil(0.5 * max(few, good * (1.0 + 0.25 * digits))))
    return (needed[0], needed[1]), (wanted[0], wanted[1])


def chosen_points(annulus: Annulus, seen: Expected, points: tuple[int, int] | None, error: float) -> tuple[int, int]:
    """The intervals to be used.

    Raises
    ------
    QuestionError
        If ``points`` cannot resolve the layers at the walls, or if this takes more than can be afforded.
    """
    needed, wanted = points_for(annulus, seen, error)
    for name, count, least, length in zip(
        ("radial", "axial"), points or wanted, needed, (annulus.width, annulus.height), strict=True
    ):
        if count < least:
            raise QuestionError(
                f"points: given {count} in {name} direction, but the layers at the walls are "
                f"{1e3 * layer(annulus, seen.fastest):.3g} mm thin on {1e3 * length:.3g} mm at {seen.fastest:.4g} rad/s; "
                f"take at least {least} ({wanted[0]} by {wanted[1]} are recommended for an error of {error:g})"
            )
        if count > MOST:
            raise QuestionError(
                f"points: {count} in {name} direction are more than the {MOST} this solver is made for; the layers "
                f"at the walls are only {1e3 * layer(annulus, seen.fastest):.3g} mm thin at {seen.fastest:.4g} rad/s"
            )
    return points or wanted


def finer(points: tuple[int, int]) -> tuple[int, int] | None:
    """The next grid for a flow that this one did not resolve; None beyond what the Chebyshev solver is made for."""
    more = tuple(2 * math.ceil(0.65 * count) for count in points)
    return (more[0], more[1]) if max(more) <= MOST else None


def seconds(seen: Expected, points: tuple[int, int]) -> float:
    """About how long the Chebyshev solver takes, s: steps within the limits of convection and waves times their cost."""
    steps = CONVECTION * seen.lagged * points[1] + (2.0 * seen.turned if seen.unsteady else 0.0)
    return float(steps / 0.56 * (STEP[0] + STEP[1] * (points[0] * points[1]) ** 1.5))


# The full equations by Chebyshev collocation: state, and the time integration in ``kernels/annulus_flow.py``.


FIRST = 0.05  # first step over the diffusion time of the narrowest cell
LEAST = 1e-3  # step over the first one, or over a radian of the rotor, that says the flow is not resolved
CHUNK = 2000  # steps between two looks at the progress bar


class SpectralFlow:
    """State and steps on ``radial`` by ``axial`` intervals.

    ``order`` of the time integration is 1, 2 or 3. Waves of the turning fluid are implicit if ``waves``, and limit the step
    otherwise. Where both lids turn alike the flow is symmetric about mid-height, and half of it is solved.
    """

    def __init__(
        self,
        annulus: Annulus,
        radial: int,
        axial: int,
        *,
        walls: Walls | None = None,
        order: int = 3,
        waves: bool = False,
        smooth: bool = False,
    ) -> None:
        self.annulus, self.order, self.waves = annulus, order, waves
        self.grid = grid = chebyshev_grid(annulus, radial, axial)
        self.radius, self.height = grid.r.points, grid.z.points
        walls = walls or Walls()
        self.walls = walls.momentum(annulus, self.radius, self.height)
        self._parities: tuple[Parity, Parity] = (1, -1) if walls.bottom == walls.top else (0, 0)
        self._families = grid.r.family(smooth=smooth), *(grid.z.family(part, smooth=smooth) for part in self._parities)
        self._plan = self._make_plan()
        self._state = _state(self._plan)
        self._clock = np.zeros(annulus_flow.CLOCK)
        self.swirl = self.walls.copy()  # g = r^2 (W - w), m^2/s; (radius, height)
        self.vorticity = np.zeros_like(self.swirl)  # q = r eta, m/s
        self.stream = np.zeros_like(self.swirl)  # psi, m^3/s

    def orbit_speed(self) -> float:
        """Angular velocity of the fluid at the orbit relative to the rotor, rad/s."""
        r, z = self.grid.r.values_at(self.annulus.orbit_radius), self.grid.z.values_at(0.5 * self.annulus.height)
        return float(r @ self.swirl @ z) / self.annulus.orbit_radius**2

    def momentum(self, speed: float) -> float:
        """Angular momentum of the fluid at the rotor speed ``speed``, kg m^2/s."""
        total = self.swirl + self.radius[:, None] ** 2 * speed
        weight = self.grid.r.weights * self.radius
        return float(2.0 * np.pi * self.annulus.density * (weight @ total @ self.grid.z.weights))

    def torque(self) -> float:
        """Torque of the walls on the fluid, N m."""
        g, grid, r = self.swirl, self.grid, self.radius
        around = (r[[0, -1], None] * (grid.r.derivative[[0, -1]] @ g) - 2.0 * g[[0, -1]]) @ grid.z.weights
        lids = (grid.r.weights * r) @ (g @ grid.z.derivative[[0, -1]].T)
        turning = around[1] - around[0] + lids[1] - lids[0]
        return float(2.0 * np.pi * self.annulus.density * self.annulus.viscosity * turning)

    def march(
        self,
        speed: WallSpeed,
        end: float,
        *,
        tolerance: float,
        stops: Sequence[float] = (),
        at_stop: Callable[[float], None] = lambda time: None,
        progress: Progress | None = None,
        fixed: float = 0.0,
    ) -> Track:
        """Run from time zero, fluid turning as before, to ``end``.

        A step is as long as the error, the waves in the turning fluid and convection allow:
        length (2 w + |u_r|/dr + |u_z|/dz) <= 0.7.

        Parameters
        ----------
        speed
            Of the walls.
        end
            s.
        tolerance
            Local error of the angular velocity, root mean square over the points, relative to the greatest speed.
        stops
            Times at which ``at_stop`` is called; the fields are then those of this time.
        progress
            Called now and then with time and end.
        fixed
            A step that is kept whatever happens, s; 0 for steps by error.

        Raises
        ------
        QuestionError
            If the grid does not resolve the flow.
        """
        # the first step is short against the diffusion across the narrowest cell
        clock, first = self._clock, speed.at(0.0)[0]
        goal = tolerance * max(speed.fastest(end), 1e-300)
        self._begin(first, speed.before)
        narrow = min(float(np.diff(self.radius).min()), float(np.diff(self.height).min()))
        step = min(fixed or FIRST * narrow**2 / self.annulus.viscosity, end)
        clock[annulus_flow.LENGTH] = step
        clock[annulus_flow.LEAST] = LEAST * min(step, 1.0 / max(speed.fastest(end), 1e-300))
        track = Track()
        track.note(0.0, first, speed.before - first)
        if 0.0 in stops:
            at_stop(0.0)
        # from mark to mark: corners of the speed, and times at which the flow is asked for
        record, corners = np.empty((CHUNK, 3)), set(speed.corners(end))
        for mark in sorted({*(t for t in stops if 0.0 < t < end), *corners, end}):
            piece = speed.piece(float(clock[annulus_flow.TIME]))
            numbers = np.array(piece.numbers, np.float64)
            while clock[annulus_flow.TIME] < mark:
                done = integrate_flow(
                    self._plan, self._state, clock, piece.start, float(piece.kind), numbers, mark, fixed, goal, self.order, record
                )  # fmt: skip
                for time, w, lag in record[:done].tolist():
                    track.note(time, w, lag)
                if clock[annulus_flow.LOST]:
                    raise QuestionError(
                        f"the flow solver cannot continue past {clock[annulus_flow.TIME]:.4g} s with steps of "
                        f"{clock[annulus_flow.LENGTH]:.2g} s: the flow is not resolved; take more 'points'"
                    )
                if progress is not None:
                    progress(float(clock[annulus_flow.TIME]), end)
            if mark in stops or mark == end:
                self._gather()
            if mark in stops:
                at_stop(mark)
            if mark in corners:  # the rate of the speed jumps, so the past is of no use
                clock[annulus_flow.KNOWN], clock[annulus_flow.LENGTH] = 1.0, step
        track.steps, track.rejected = int(clock[annulus_flow.ACCEPTED]), int(clock[annulus_flow.REJECTED])
        return track

    def _begin(self, speed: float, fluid_speed: float) -> None:
        """Fluid turning as a solid with ``fluid_speed`` between walls that turn with ``speed``."""
        r, even, _ = self._families
        plan, state, clock = self._plan, self._state, self._clock
        for part in state:
            part[...] = 0.0
        clock[:] = 0.0
        clock[annulus_flow.KNOWN], clock[annulus_flow.WAVES] = 1.0, float(self.waves)
        state.g[0] = self.radius[1:-1, None] ** 2 * (fluid_speed - speed)
        state.g_share[0] = r.forward @ state.g[0] @ even.forward.T
        state.a[:] = state.g_share[0] @ plan.even_backward
        remember(plan, state, clock, speed)
        self._gather()

    def _gather(self) -> None:
        """The fields with their walls, from the present level."""
        r, _, odd = self._families
        state, level, parities = self._state, int(self._clock[annulus_flow.HEAD]), self._parities
        stream = r.backward @ state.psi_share @ odd.backward.T
        vorticity = r.backward @ state.q_share[level] @ odd.backward.T
        self.swirl, self.vorticity, self.stream = (
            self.walls.copy(),
            np.zeros_like(self.walls),
            np.zeros_like(self.walls),
        )
        for whole, inner, parity in (
            (self.swirl, state.g[level], parities[0]),
            (self.vorticity, vorticity, parities[1]),
            (self.stream, stream, parities[1]),
        ):
            whole[1:-1, 1:-1] = self._unfold(inner, parity)
        self.vorticity[[0, -1], 1:-1] = self._unfold(state.q_side, parities[1])
        lids = state.q_lid
        self.vorticity[1:-1, [0, -1]] = np.stack([lids[0], lids[-1] * (1.0 if lids.shape[0] == 2 else -1.0)], axis=1)

    def _unfold(self, inner: Floats, parity: Parity) -> Floats:
        """Values between the lids to those over the whole height."""
        edge = np.zeros((inner.shape[0], 1))
        return inner if parity == 0 else self.grid.z.unfold(np.concatenate([edge, inner], axis=1), parity)[:, 1:-1]

    def _make_plan(self) -> annulus_flow.Plan:
        # the walls inside, and what they contribute as a lift
        grid, annulus = self.grid, self.annulus
        r, even, odd = self._families
        parity = self._parities[0]
        inside = slice(1, -1) if parity == 0 else slice(1, 1 + even.rates.size)
        edge, lids = self.walls, [0, -1] if parity == 0 else [0]
        sides, lid = edge[[0, -1], inside], edge[1:-1, lids]
        lift = r.forward @ (r.walls @ sides + lid @ even.walls.T) @ even.forward.T
        c, d, p, s = (r.forward @ r.walls).T, (odd.forward @ odd.walls).T, r.ends, odd.ends
        right, left = _corners(c, d, p, s)
        # weights that give the flow at the orbit of the balls
        at_r = grid.r.values_at(annulus.orbit_radius) / annulus.orbit_radius**2
        at_z = grid.z.values_at(0.5 * annulus.height)
        radius = grid.r.points[1:-1]
        arrays = {
            "over_r": 1.0 / radius,
            "over_dr": 1.0 / np.gradient(grid.r.points)[1:-1],
            "over_dz": 1.0 / np.gradient(grid.z.points)[inside],
            "orbit_r": at_r[1:-1],
            "orbit_z": grid.z.fold(at_z, parity)[slice(1, -1) if parity == 0 else slice(1, None)],
            "r_forward": r.filtered,
            "r_backward": r.backward,
            "r_slope": r.slope @ r.backward,
            "even_forward": even.filtered.T,
            "odd_forward": odd.filtered.T,
            "even_backward": even.backward.T,
            "odd_backward": odd.backward.T,
            "even_slope": even.slope.T,
            "odd_slope": odd.slope.T,
            "to_even": (even.forward @ odd.slope @ odd.backward).T,
            "to_odd": (odd.forward @ even.slope @ even.backward).T,
            "even_rates": r.rates[:, None] + even.rates,
            "odd_rates": r.rates[:, None] + odd.rates,
            "source": r.forward @ np.tile(radius[:, None] ** 2, even.rates.size) @ even.forward.T,
            "lift": annulus.viscosity * lift,
            "wall_r": r.near @ sides,
            "wall_z": lid @ even.near.T,
            "wall_wave": r.forward @ lid @ even.near.T @ odd.forward.T,
            "near_r": r.near.T,
            "near_z": odd.near.T,
            "c": c,
            "d": d,
            "p": p,
            "s": s,
            "right": right,
            "left": left,
        }
        return annulus_flow.Plan(
            **{key: np.ascontiguousarray(value, np.float64) for key, value in arrays.items()},
            viscosity=annulus.viscosity,
            orbit_wall=float(at_r @ edge @ at_z),
        )


def _corners(c: Matrix, d: Matrix, p: Matrix, s: Matrix) -> tuple[Matrix, Matrix]:
    """Patterns of wall vorticity that act on no inner point, and combinations of slopes that always vanish."""
    (_, m), (lids, n) = c.shape, d.shape
    right, left = np.zeros((2 * lids, 2 * n + lids * m)), np.zeros((2 * lids, 2 * n + lids * m))
    for corner, (i, j) in enumerate((i, j) for i in range(2) for j in range(lids)):
        right[corner, i * n : (i + 1) * n] = d[j]
        right[corner, 2 * n + j * m : 2 * n + (j + 1) * m] = -c[i]
        left[corner, i * n : (i + 1) * n] = s[j]
        left[corner, 2 * n + j * m : 2 * n + (j + 1) * m] = -p[i]
    return right, left


def _state(plan: annulus_flow.Plan) -> annulus_flow.State:
    (m, n), lids = plan.odd_rates.shape, plan.d.shape[0]
    size = 2 * n + lids * m
    shapes: dict[str, tuple[int, ...]] = dict.fromkeys(
        ("g", "g_share", "q_share", "g_rate", "q_rate", "g_wave", "q_wave"), (annulus_flow.LEVELS, m, n)
    )
    shapes |= {"green": (m, n, n), "block": (n, n), "influence": (size, size), "weights": (3, 5)}
    shapes |= {"q_side": (2, n), "q_lid": (lids, m), "speeds": (annulus_flow.LEVELS,), "pivots": (max(size, n),)}
    shapes |= dict.fromkeys(("rows", "columns", "unknown"), (size,))
    return annulus_flow.State(**{name: np.zeros(shapes.get(name, (m, n))) for name in annulus_flow.State._fields})


# Chebyshev collocation on one coordinate, whole or folded at its middle, with D2 of that direction diagonalized.


Parity = Literal[-1, 0, 1]  # of a field about the middle: odd, of no parity, even
KEPT, POWER, STRENGTH = 0.6, 2, 36.0  # share of the wave numbers that the filter leaves alone, and its shape beyond


@dataclass(frozen=True)
class Family:
    """Fields of one parity between the walls: n unknowns (those of one half if there is a parity), k walls.

    Attributes
    ----------
    rates, forward, backward
        The second derivative (or D2) between walls at zero is backward diag(rates) forward.
    walls
        Its columns of the values at the walls, (n, k).
    slope, near
        First derivative at the unknowns from the unknowns (n, n) and from the walls (n, k).
    ends
        First derivative at the walls from the unknowns where the walls are at zero, (k, n).
    filtered
        ``forward`` after the removal of what products of fields put into the highest wave numbers.
    """

    rates: Floats
    forward: Matrix
    backward: Matrix
    walls: Matrix
    slope: Matrix
    near: Matrix
    ends: Matrix
    filtered: Matrix


@dataclass(frozen=True)
class Line:
    """Points of one coordinate, ascending; ``second`` is d2/dz2, or d2/dr2 - (1/r) d/dr."""

    points: Floats
    derivative: Matrix
    second: Matrix
    weights: Floats

    def values_at(self, place: float) -> Floats:
        """Row that interpolates at ``place``, by the barycentric formula of the Chebyshev points."""
        count = self.points.size
        side = np.where(np.arange(count) % 2 == 0, 1.0, -1.0)
        side[[0, -1]] *= 0.5
        away = place - self.points
        if not away.all():
            return np.asarray(away == 0.0, np.float64)
        share = side / away
        return np.asarray(share / share.sum(), np.float64)

    def fold(self, row: Floats, parity: Parity) -> Floats:
        """Columns of all points to those of the points up to the middle; the last axis."""
        if parity == 0:
            return row
        count = row.shape[-1]
        half = (count + 1) // 2
        folded = row[..., :half] + parity * row[..., ::-1][..., :half]
        if count % 2:
            folded[..., -1] *= 0.5
        return np.asarray(folded, np.float64)

    def unfold(self, values: Floats, parity: Parity) -> Floats:
        """Values at the points up to the middle to those at all points; the last axis."""
        if parity == 0:
            return values
        mirrored = parity * values[..., ::-1][..., self.points.size % 2 :]
        return np.concatenate([values, mirrored], axis=-1)

    def family(self, parity: Parity = 0, *, smooth: bool = False) -> Family:
        """Fields of one parity, filtered if ``smooth``; a point in the middle is an unknown of odd ones too, of value zero."""
        count = self.points.size
        rows = slice(1, -1) if parity == 0 else slice(1, (count + 1) // 2)
        ends = [0, -1] if parity == 0 else [0]
        second, first = self.fold(self.second, parity)[rows], self.fold(self.derivative, parity)
        columns = slice(1, -1) if parity == 0 else slice(1, None)
        inside, slope = second[:, columns].copy(), first[rows][:, columns].copy()
        sieve = self.fold(_filter(count - 1, STRENGTH * smooth), parity)[: inside.shape[0]]
        middle = parity != 0 and count % 2 == 1
        if middle and parity == 1:
            slope[-1] = 0.0
        if middle and parity == -1:
            sieve[-1], sieve[:, -1] = 0.0, 0.0
            rates, forward, backward = _eigenvectors(inside[:-1, :-1])
            rates = np.append(rates, rates.min())
            forward, backward = (block_diag(matrix, 1.0) for matrix in (forward, backward))
        else:
            rates, forward, backward = _eigenvectors(inside)
        return Family(
            rates,
            forward,
            backward,
            second[:, ends],
            slope,
            first[rows][:, ends],
            first[ends][:, columns] @ backward,
            forward @ sieve,
        )


@dataclass(frozen=True)
class Grid:
    """Points and derivatives in a cross-section."""

    r: Line
    z: Line


def chebyshev_grid(annulus: Annulus, radial: int, axial: int) -> Grid:
    """``radial`` by ``axial`` intervals."""
    return Grid(line(annulus.inner, annulus.outer, radial, radial=True), line(0.0, annulus.height, axial, radial=False))


def line(begin: float, end: float, count: int, *, radial: bool) -> Line:
    """``count`` intervals; the operator is d2/dr2 - (1/r) d/dr if ``radial``, else d2/dz2."""
    points, first, weights = _chebyshev(count)
    half = 0.5 * (end - begin)
    points, first = begin + half * (1.0 + points), first / half
    second = first @ first
    if radial:
        second -= first / points[:, None]
    return Line(points, first, second, weights * half)


def _eigenvectors(matrix: Matrix) -> tuple[Floats, Matrix, Matrix]:
    rates, vectors = np.linalg.eig(matrix)
    order = np.argsort(-rates.real)
    rates, vectors = rates.real[order], np.ascontiguousarray(vectors.real[:, order])
    return rates, np.linalg.inv(vectors), vectors


def _filter(count: int, strength: float) -> Matrix:
    """Low wave numbers pass, high ones fade, on the inner points of ``count`` intervals.

    The inner points are those of Gauss for the polynomials U_k, so the way to their shares and back is exact.
    """
    angle = math.pi * (count - np.arange(1, count)) / count
    k = np.arange(1, count)
    shapes = np.sin(np.outer(angle, k)) / np.sin(angle)[:, None]
    back = 2.0 / count * shapes * (np.sin(angle) ** 2)[:, None]
    over = np.maximum(0.0, (k / count - KEPT) / (1.0 - KEPT))
    return np.asarray((shapes * np.exp(-strength * over**POWER)) @ back.T, np.float64)


def _chebyshev(count: int) -> tuple[Floats, Matrix, Floats]:
    """Ascending points on [-1, 1], first derivative (rows sum to zero exactly), weights of Clenshaw and Curtis."""
    k = np.arange(count + 1)
    points = np.sin(math.pi * (2.0 * k - count) / (2.0 * count))
    share = np.where(k % 2 == 0, 1.0, -1.0)
    share[[0, -1]] *= 2.0
    # differences of the points by the product of sines, which keeps their digits
    angle = math.pi * k / (2.0 * count)
    apart = 2.0 * np.sin(angle[:, None] + angle[None, :]) * np.sin(angle[:, None] - angle[None, :])
    np.fill_diagonal(apart, 1.0)
    matrix = np.outer(share, 1.0 / share) / apart
    np.fill_diagonal(matrix, 0.0)
    np.fill_diagonal(matrix, -matrix.sum(axis=1))
    even = np.arange(0, count + 1, 2)
    moments = np.zeros(count + 1)
    moments[even] = 2.0 / (1.0 - even.astype(np.float64) ** 2)
    cosines = np.cos(math.pi * np.outer(k, k) / count)
    halves = np.ones(count + 1)
    halves[[0, -1]] = 0.5
    weights = 2.0 / count * halves * (cosines @ (halves * moments))
    return points, matrix, weights
