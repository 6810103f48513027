"""Steps of the spectral solver: as long as the error, the waves in the turning fluid and convection allow."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from autobalancer.errors import QuestionError
from autobalancer.flow.annulus import Floats
from autobalancer.flow.spectral import SpectralFlow
from autobalancer.flow.speed import WallSpeed

REACH = 0.5  # step times (2 w + convection rate): inside the stable range of the explicit terms
GROWTH = 1.3  # backward differentiation of order three stays stable up to steps that grow by 1.5
FIRST = 0.05  # first step over the diffusion time of the narrowest cell
REFUSED = 1.5  # error over tolerance above which a step is done again
WORTH = 1.2  # a longer step is taken from this growth on: a new step length costs a new influence matrix
SHRINK = 0.9
LEAST = 1e-3  # step over the first one, or over a radian of the rotor, that says the flow is not resolved
MARGIN = 0.8  # of the reach, where it has become shorter

Progress = Callable[[float, float], None]


@dataclass
class Track:
    """What was recorded at every step: time, speed of the rotor, angular velocity of the fluid at the orbit."""

    times: list[float] = field(default_factory=list)
    speeds: list[float] = field(default_factory=list)
    orbit: list[float] = field(default_factory=list)
    steps: int = 0
    rejected: int = 0

    def note(self, time: float, speed: float, lag: float) -> None:
        """One more instant; ``lag`` is relative to the rotor."""
        self.times.append(time)
        self.speeds.append(speed)
        self.orbit.append(speed + lag)

    def arrays(self) -> tuple[Floats, Floats, Floats]:
        """The same as arrays."""
        return np.array(self.times), np.array(self.speeds), np.array(self.orbit)


def march(
    flow: SpectralFlow,
    speed: WallSpeed,
    end: float,
    *,
    tolerance: float,
    stops: Sequence[float] = (),
    at_stop: Callable[[float], None] = lambda time: None,
    progress: Progress | None = None,
    fixed: float | None = None,
) -> Track:
    """Run from time zero to ``end``.

    Parameters
    ----------
    flow
        Its state is set anew.
    speed
        Of the walls.
    end
        s.
    tolerance
        Local error of the angular velocity, relative to the greatest speed.
    stops
        Times at which ``at_stop`` is called with the state of just then.
    progress
        Called now and then with time and end.
    fixed
        A step that is kept whatever happens, s.

    Raises
    ------
    QuestionError
        If the step becomes too small, because the grid does not resolve the flow.
    """
    goal = tolerance * max(speed.fastest(end), 1e-300)
    marks = sorted({*(t for t in stops if 0.0 < t < end), *speed.corners(end), end})
    corners = set(speed.corners(end))
    flow.begin(speed.at(0.0)[0], speed.before)
    track = Track()
    track.note(0.0, speed.at(0.0)[0], flow.orbit_speed())
    if 0.0 in stops:
        at_stop(0.0)
    narrow = min(float(np.diff(flow.radius).min()), float(np.diff(flow.height).min()))
    first = min(fixed or FIRST * narrow**2 / flow.annulus.viscosity, end)
    least = LEAST * min(first, 1.0 / max(speed.fastest(end), 1e-300))
    time, length = 0.0, first
    for mark in marks:
        piece = speed.piece(time)
        while time < mark:
            if fixed is None:
                w = max(abs(speed.at(time, piece)[0]), abs(speed.at(min(time + length, mark), piece)[0]))
                reach = REACH / (2.0 * w + flow.convection + 1e-300)
                if length > reach:
                    length = MARGIN * reach
                if length < least or track.rejected > 50 + track.steps:
                    raise QuestionError(
                        f"the flow solver cannot pass {time:.4g} s with steps of {length:.2g} s: the flow is not resolved; "
                        "take more 'points'"
                    )
            left = mark - time
            last = left <= length * 1.000001
            step = left if last else min(length, 0.5 * left) if left < 2.0 * length else length
            new = mark if last else time + step
            now, rate = speed.at(new, piece)
            order = min(len(flow.history), flow.order)
            error = flow.step(step, now, rate) / goal
            if fixed is None:
                wish = step * float(np.clip(0.85 * max(error, 1e-9) ** (-1.0 / (order + 1)), 0.2, GROWTH))
                if not error <= REFUSED and len(flow.history) > 1:  # of the first step nothing is known
                    length = wish if np.isfinite(error) else 0.2 * step
                    track.rejected += 1
                    continue
                longest = min(wish, MARGIN * reach)
                if longest >= WORTH * length or wish < SHRINK * step:
                    length = longest
            flow.accept()
            time = new
            track.steps += 1
            track.note(time, now, flow.orbit_speed())
            if progress is not None and track.steps % 50 == 0:
                progress(time, end)
        if mark in stops:
            at_stop(mark)
        if mark in corners:
            flow.restart()
            length = first
    return track
