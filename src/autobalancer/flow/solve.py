"""A flow solved by one of the two solvers, with the points, the scheme and the certainty that it needs."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.interpolate import CubicSpline

from autobalancer.errors import DurationWarning, QuestionError, warn
from autobalancer.flow.annulus import Annulus, Floats
from autobalancer.flow.choice import LONG, LONGEST, Expected, chosen_points, finer, seconds
from autobalancer.flow.differences import DifferenceFlow
from autobalancer.flow.result import Solved
from autobalancer.flow.spectral import SpectralFlow
from autobalancer.flow.speed import WallSpeed
from autobalancer.flow.track import Track

Progress = Callable[[float, float], None]
Fields = tuple[Floats, Floats, Floats, float, float]

SHARES = {2: 0.002, 3: 0.02}  # of the error asked for that a single step may make, by the order of the integration


def by_solver(
    annulus: Annulus,
    walls: WallSpeed,
    end: float,
    grid: Floats,
    moments: list[float],
    solver: str,
    seen: Expected,
    points: tuple[int, int] | None,
    error: float,
    progress: Progress | None,
) -> Solved:
    """By the full equations; Chebyshev takes more points where those chosen do not resolve the flow.

    Raises
    ------
    QuestionError
        If given points do not resolve it, or chosen ones would take too long.
    """
    chosen, uncertainty = chosen_points(annulus, solver, seen, points, error), 0.0
    kept: list[Fields] = []
    flow: SpectralFlow | DifferenceFlow
    if solver == "differences":
        flow = plain = DifferenceFlow(annulus, *chosen)
        _differences_affordable(plain.seconds(walls, end), seen, chosen, points is None, error)
        track = plain.march(
            walls, end, stops=moments, at_stop=lambda time: kept.append(_fields(plain, walls, time)), progress=progress
        )
    else:
        if points is None:
            _affordable(annulus, seen, chosen)
        flow, track = _resolved(annulus, walls, end, moments, seen, chosen, points is None, error, kept, progress)
        if seen.unsteady and points is None:
            uncertainty = _uncertainty(flow, track, walls, end, seen, SHARES[flow.order] * error)
    times, _, orbit = track.arrays()
    swirl, stream, vorticity, torque, momentum = _stacked(kept)
    return Solved(
        model=solver,
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


def _fields(flow: SpectralFlow | DifferenceFlow, walls: WallSpeed, time: float) -> Fields:
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


def _differences_affordable(time: float, seen: Expected, points: tuple[int, int], ours: bool, error: float) -> None:
    """Refuse what takes far too long and was not asked for by its points; warn of what takes long."""
    if time <= LONG:
        return
    cure = "take the model 'chebyshev', which needs far fewer points, or an 'error' above the present "
    cure += f"{error:g}"
    if seen.error <= error:
        cure = f"take the model 'auto' or 'modes': here diffusion alone is wrong by at most {seen.error:.1g}"
    size = f"{points[0]}x{points[1]}"
    text = f"flow: the model 'differences' takes {size} points and about {time / 60.0:.2g} minutes of one core; {cure}"
    if ours and time > LONGEST:
        raise QuestionError(f"{text}. 'points' (--points {size}) starts it anyway")
    warn(text, DurationWarning)


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
