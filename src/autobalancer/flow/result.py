"""A solved flow as a labelled dataset."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import xarray as xr
from scipy.interpolate import PchipInterpolator

from autobalancer.flow.annulus import Floats, Matrix


@dataclass(frozen=True)
class Solved:
    """Arrays of a solved flow, whatever the model."""

    model: str
    times: Floats
    speed: Floats
    orbit: Floats
    radius: Floats
    height: Floats
    moments: Floats
    swirl: Matrix  # W - w; (moment, radius, height)
    stream: Matrix
    vorticity: Matrix
    torque: Floats
    momentum: Floats
    moment_speed: Floats
    steps: int
    uncertainty: float = 0.0  # of an unsteady flow, over the greatest speed


def percent(share: float) -> str:
    """A share as people read it: ``"14.3 %"``."""
    return f"{100.0 * share:.3g} %"


def flow_notes(flow: xr.Dataset) -> list[str]:
    """What to make of a solved flow, in sentences: how certain an unsteady one is."""
    uncertainty = float(flow.attrs["uncertainty"])
    if uncertainty == 0.0:
        return []
    if not np.isfinite(uncertainty):
        return [
            "vortices form at the inner wall, and a coarser grid cannot follow them, so it is unknown how certain the lag is; "
            "a finer grid (points) shows it"
        ]
    lag = float(flow.attrs["greatest_lag"]) / max(float(np.abs(flow["speed"]).max()), 1e-300)
    return [
        f"vortices form at the inner wall: at an instant the speed of the fluid is certain to {percent(uncertainty)} of the "
        f"greatest speed only (a coarser grid differs by this), and the greatest lag is {percent(lag)} of it; "
        "a mean over time is more certain"
    ]


# The fluid at the orbit over time, as a table.


@dataclass(frozen=True)
class SpinUp:
    """Angular velocity of the fluid at the orbit over time, for balls on a rotor whose speed is prescribed.

    The flow does not depend on the balls, so one table serves all runs with this profile.

    Parameters
    ----------
    times
        Ascending, s; (time,).
    angular_velocity
        Of the fluid at the orbit in space, rad/s; (time,).
    """

    times: Floats
    angular_velocity: Floats

    def at(self, times: Floats | float) -> Floats:
        """Angular velocity at ``times``, rad/s: monotonic cubics between the entries, constant outside."""
        inside = np.clip(times, self.times[0], self.times[-1])
        return np.asarray(PchipInterpolator(self.times, self.angular_velocity)(inside), np.float64)


def spin_up(flow: xr.Dataset) -> SpinUp:
    """The table of ``flow``, a result of :func:`annulus_flow`."""
    return SpinUp(flow["time"].values.copy(), flow["fluid_speed"].values.copy())


# What a solver records at every step.


Progress = Callable[[float, float], None]


@dataclass
class Track:
    """Time, speed of the rotor and angular velocity of the fluid at the orbit (rad/s), step by step."""

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
