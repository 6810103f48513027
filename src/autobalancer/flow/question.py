"""One flow in one annulus."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Literal, get_args

import numpy as np
import xarray as xr

from autobalancer.assembly.profile import SpeedProfile
from autobalancer.errors import QuestionError, RangeWarning, warn
from autobalancer.files.given import balls_in_races
from autobalancer.flow.annulus import Annulus, Floats, annulus_of
from autobalancer.flow.choice import expected
from autobalancer.flow.relaxation import all_modes, diffusive_swirl
from autobalancer.flow.result import Solved, flow_dataset, percent
from autobalancer.flow.sheared import by_shear
from autobalancer.flow.speed import WallSpeed, machine_speed, wall_speed
from autobalancer.machine import Machine
from autobalancer.patience import shows_progress
from autobalancer.units import argument, list_argument, optional_argument

Model = Literal["auto", "modes", "chebyshev", "differences", "azimuthal"]
Progress = Callable[[float, float], None]

_SECONDARY = (
    "flow: the model 'azimuthal' leaves out the secondary flow, which at the mean viscosity of this flow would change the speed "
    "of the fluid by up to {} of the greatest speed"
)
FIELD = 33  # points of a field of the modes in each direction


@shows_progress
def annulus_flow(
    chamber: Annulus | Machine | str | Path,
    speed: SpeedProfile | WallSpeed | float | str | None = None,
    *,
    duration: float | str | None = None,
    initial_speed: float | str | None = None,
    times: Sequence[float | str] = (),
    samples: int = 501,
    model: Model = "auto",
    points: tuple[int, int] | None = None,
    error: float = 1e-3,
    balancer: int = 1,
    race: int = 1,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Flow of the fluid in an annulus whose walls turn with a rotor of prescribed speed.

    The balls are assumed not to disturb it (Spannan 2021, section 5.2.1), so one solution serves all runs with this profile.

    Parameters
    ----------
    chamber
        An annulus, or a machine or the path of its file, of which ``balancer`` and ``race`` (from 1) are taken.
    speed
        Profile of the rotor, one speed in rad/s, or :func:`~autobalancer.flow.recorded_speed`; by default that of the
        machine's drive.
    duration
        s; by default the ``run.duration`` of the machine.
    initial_speed
        Angular velocity of the fluid before time zero, rad/s; by default the first speed of the profile. 0 with a constant speed
        is an impulsive start.
    times
        Times at which the whole field is stored, s; by default the end.
    samples
        Number of equally spaced times at which the fluid speed at the orbit is stored.
    model
        ``modes``: diffusion alone, exact; ``chebyshev``, ``differences``: the full equations; ``auto``: modes if neglecting the
        secondary flow costs less than ``error``, else ``chebyshev``. ``azimuthal``: without secondary flow, with the viscosity
        of the local rate of shear; a fluid with a shear law always takes it, and a warning says where secondary flow matters.
    points
        Intervals in radial and axial direction for the full equations.
    error
        Of the angular velocity at the orbit over the greatest speed of the rotor.
    progress
        Called with time and end.

    Returns
    -------
    xarray.Dataset
        Over ``time``: ``speed`` of the rotor, ``fluid_speed`` at the orbit at mid-height, ``relative_velocity`` (azimuthal, to
        solid rotation) and ``diffusion_speed``, what diffusion alone would give. Over ``(moment, radius, height)``:
        ``fluid_angular_velocity``, ``stream_function``, ``vorticity``; over ``moment``: ``wall_torque`` and ``angular_momentum``.
        Attributes say which model was used and why, and give ``spin_up_time``: from the moment at which the rotor keeps its
        speed until the lag has fallen to 1/e of what it was then. ``uncertainty`` is set where the flow is unsteady: the greatest
        difference of the speed at the orbit from that on a coarser grid, over the greatest speed; nan if that is not known.

    Raises
    ------
    MachineError
        If the race has no proper chamber or fluid.
    QuestionError
        If the speed is not known, a time lies outside the run, or the points cannot resolve the flow, or take longer
        than five minutes and were not given explicitly.
    """
    if isinstance(speed, str):
        speed = argument("speed", speed, "rad/s")
    duration = optional_argument("duration", duration, "s")
    initial_speed = optional_argument("initial_speed", initial_speed, "rad/s")
    times = list_argument("times", times, "s")
    annulus, profile, end, name = _chamber(chamber, speed, duration, balancer, race)
    if model not in get_args(Model):
        raise QuestionError(
            f"model: given {model!r}; must be 'auto', 'modes', 'chebyshev', 'differences' or 'azimuthal'"
        )
    if annulus.sheared is not None and model not in ("auto", "azimuthal"):
        raise QuestionError(
            f"model: given {model!r}, which is for constant viscosity; a fluid with a shear law has the model 'azimuthal'"
        )
    if samples < 2:
        raise QuestionError(f"samples: given {samples}; must be at least 2")
    moments = sorted({float(t) for t in times} or {end})
    if moments[0] < 0.0 or moments[-1] > end:
        raise QuestionError(f"times: given {moments[0]:g} to {moments[-1]:g} s; must lie within 0 and {end:g} s")
    walls = wall_speed(profile, initial_speed)
    if not 1e-6 <= error <= 0.5:
        raise QuestionError(f"error: given {error:g}; must be between 1e-6 and 0.5")
    modes = all_modes(annulus)
    seen = expected(annulus, modes, walls, end)
    if annulus.sheared is not None:
        model = "azimuthal"
    solver = model if model != "auto" else "modes" if seen.error <= error else "chebyshev"
    grid = np.linspace(0.0, end, samples)
    cornered = _with_corners(grid, walls, end)
    diffusion = modes.response(walls, cornered)[np.searchsorted(cornered, grid)]
    if solver == "modes":
        solved = _by_modes(annulus, walls, grid, diffusion, moments)
    elif solver == "azimuthal":
        solved, seen = by_shear(annulus, walls, grid, moments, points, error, progress)
        if seen.error > error:
            warn(_SECONDARY.format(percent(min(seen.error, 1.0))), RangeWarning)
    else:
        from autobalancer.flow.solve import by_solver

        solved = by_solver(annulus, walls, end, grid, moments, solver, seen, points, error, progress)
    reason = (
        f"diffusion alone is enough, wrong by at most {percent(seen.error)} of the greatest speed"
        if seen.error <= error
        else "a secondary flow carries the fluid along; without it the speed of the fluid would be wrong by up to "
        f"{percent(min(seen.error, 1.0))} of the greatest speed"
    )
    return flow_dataset(
        annulus, solved, diffusion, name, _reason(model, annulus, reason, seen.error), seen, walls.settled
    )


def _reason(model: str, annulus: Annulus, reason: str, error: float) -> str:
    if annulus.sheared is not None:
        left_out = f"the secondary flow, left out, would change its speed by up to {percent(min(error, 1.0))} of the greatest one"
        return f"the viscosity of the fluid depends on the rate of shear; {left_out}"
    return "asked for" if model != "auto" else reason


def _chamber(
    chamber: Annulus | Machine | str | Path,
    speed: SpeedProfile | WallSpeed | float | None,
    duration: float | None,
    balancer: int,
    race: int,
) -> tuple[Annulus, SpeedProfile | WallSpeed | float, float, str]:
    if isinstance(chamber, Annulus):
        annulus, machine, name = chamber, None, "annulus"
    else:
        machine = balls_in_races(chamber)
        annulus, name = annulus_of(machine, balancer, race), machine.name
    if speed is None:
        if machine is None:
            raise QuestionError("speed: missing; an annulus alone has no wall speed")
        speed = machine_speed(machine)
    if duration is None and machine is not None and machine.run is not None:
        duration = float(machine.run.duration)
    if duration is None or not duration > 0.0:
        given = "missing" if duration is None else f"given {duration:g} s"
        raise QuestionError(f"duration: {given}; must be a time greater than 0 s")
    return annulus, speed, duration, name


def _with_corners(grid: Floats, walls: WallSpeed, end: float) -> Floats:
    """``grid`` and the instants at which the rate of the speed jumps."""
    return np.unique(np.concatenate([grid, walls.corners(end)]))


def _by_modes(annulus: Annulus, walls: WallSpeed, grid: Floats, orbit: Floats, moments: list[float]) -> Solved:
    """By diffusion alone; ``orbit`` is what it gives at the orbit over ``grid``."""
    radius = np.linspace(annulus.inner, annulus.outer, FIELD)
    height = np.linspace(0.0, annulus.height, FIELD)
    times = _with_corners(np.concatenate([grid, moments]), walls, float(grid[-1]))
    swirl = diffusive_swirl(annulus, walls, times, radius, height)[np.searchsorted(times, moments)]
    return Solved(
        model="modes",
        times=grid,
        speed=walls.over(grid),
        orbit=orbit,
        radius=radius,
        height=height,
        moments=np.array(moments),
        swirl=swirl,
        stream=np.zeros_like(swirl),
        vorticity=np.zeros_like(swirl),
        torque=np.full(len(moments), np.nan),
        momentum=np.full(len(moments), np.nan),
        moment_speed=walls.over(np.array(moments)),
        steps=0,
    )
