"""A flow solved by the full equations, with the points, the scheme and the certainty that it needs."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from scipy.interpolate import CubicSpline

from autobalancer.errors import QuestionError
from autobalancer.flow.annulus import Annulus, Floats
from autobalancer.flow.choice import Expected
from autobalancer.flow.result import Solved
from autobalancer.flow.spectral import SpectralFlow
from autobalancer.flow.speed import WallSpeed
from autobalancer.flow.track import Track

Progress = Callable[[float, float], None]
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
        _affordable(annulus, seen, chosen)
    flow, track = _resolved(annulus, walls, end, moments, seen, chosen, points is None, error, kept, progress)
    if seen.unsteady and points is None:
        uncertainty = _uncertainty(flow, track, walls, end, seen, SHARES[flow.order] * error)
    times, _, orbit = track.arrays()
    swirl, stream, vorticity, torque, momentum = _stacked(kept)
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


def _stacked(kept: list[Fields]) -> tuple[Floats, ...]:
    return tuple(np.array(part) for part in zip(*kept, strict=True))


def _affordable(annulus: Annulus, seen: Expected, points: tuple[int, int]) -> None:
    time = seconds(seen, points)
    if time > LONGEST:
        raise QuestionError(
            f"flow: fluid of {1e6 * annulus.viscosity:.3g} mm^2/s would lag by about {seen.lag * seen.fastest:.3g} rad/s, a "
            f"turbulent flow that takes {points[0]}x{points[1]} points and about {time / 60.0:.0f} minutes; speed up more "
            "slowly, shorten the duration, or take the model 'modes' (fluid.lag = 'modes'), which overestimates the lag; "
            f"'points' (--points {points[0]}x{points[1]}) starts it anyway"
        )


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
