"""A solved flow as a labelled dataset."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace

import numpy as np
import xarray as xr
from scipy.interpolate import PchipInterpolator

from autobalancer.flow.annulus import Annulus, Floats, Matrix
from autobalancer.flow.choice import Expected
from autobalancer.results.answers.answer import Labeled
from autobalancer.results.provenance import provenance

LABELS = {
    "time": ("time", "s"),
    "speed": ("rotor speed", "rad/s"),
    "fluid_speed": ("angular velocity of the fluid at the orbit", "rad/s"),
    "diffusion_speed": ("angular velocity of the fluid at the orbit by diffusion alone", "rad/s"),
    "relative_velocity": ("azimuthal velocity of the fluid at the orbit relative to the rotor", "m/s"),
    "moment": ("time of a field", "s"),
    "moment_speed": ("rotor speed at the time of a field", "rad/s"),
    "radius": ("distance from the axis", "m"),
    "height": ("distance from the lower lid", "m"),
    "fluid_angular_velocity": ("angular velocity of the fluid", "rad/s"),
    "stream_function": ("stream function of the secondary flow", "m^3/s"),
    "vorticity": ("azimuthal vorticity", "1/s"),
    "wall_torque": ("torque of the walls on the fluid", "N m"),
    "angular_momentum": ("angular momentum of the fluid", "kg m^2/s"),
}


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


def flow_dataset(
    annulus: Annulus, solved: Solved, diffusion: Floats, name: str, reason: str, seen: Expected, settled: float
) -> xr.Dataset:
    """Label what was solved; ``settled`` is the time from which the rotor keeps its speed, s."""
    field = ("moment", "radius", "height")
    lag = solved.orbit - solved.speed
    data = {
        "speed": ("time", solved.speed),
        "fluid_speed": ("time", solved.orbit),
        "relative_velocity": ("time", annulus.orbit_radius * lag),
        "diffusion_speed": ("time", diffusion),
        "fluid_angular_velocity": (field, solved.swirl + solved.moment_speed[:, None, None]),
        "stream_function": (field, solved.stream),
        "vorticity": (field, solved.vorticity),
        "moment_speed": ("moment", solved.moment_speed),
    }
    if np.isfinite(solved.torque).all():
        data |= {"wall_torque": ("moment", solved.torque), "angular_momentum": ("moment", solved.momentum)}
    coordinates = {"time": solved.times, "moment": solved.moments, "radius": solved.radius, "height": solved.height}
    dataset = xr.Dataset(data, coordinates)
    for key in dataset.variables:
        text, unit = LABELS[str(key)]
        dataset[key].attrs = {"long_name": text, "units": unit}
    dataset.attrs = {
        "title": f"Flow in the annulus of {name}",
        **provenance(),
        "machine_name": name,
        "model": solved.model,
        "model_reason": reason,
        "error_of_diffusion": seen.error,
        "ekman_number": annulus.ekman_number(seen.fastest),
        "spin_up_time": decay_time(solved.times, lag, settled),
        "greatest_lag": float(np.abs(lag).max()),
        "points": [solved.radius.size - 1, solved.height.size - 1],
        "steps": solved.steps,
        "uncertainty": solved.uncertainty,
        **{key: value for key, value in asdict(replace(annulus, sheared=None)).items() if key != "sheared"},
    }
    return Labeled.of(dataset)


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


def decay_time(times: Floats, lag: Floats, start: float) -> float:
    """Time from ``start`` until the lag has fallen to 1/e of what it was then for good, s; nan if it has not by the end."""
    if not start < times[-1]:
        return float("nan")
    size = np.abs(lag)
    goal = float(np.interp(start, times, size)) / math.e
    above = np.flatnonzero((size > goal) & (times >= start))
    if goal == 0.0 or above.size == 0 or above[-1] + 1 == size.size:
        return float("nan")
    i = int(above[-1])
    part = (size[i] - goal) / (size[i] - size[i + 1])
    return float(times[i] + part * (times[i + 1] - times[i]) - start)


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
