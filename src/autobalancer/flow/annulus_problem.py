"""One flow in one annulus."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
import scipy.sparse as sp
import xarray as xr
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.sparse.linalg import spsolve

from autobalancer.arrays import Floats, Matrix
from autobalancer.assembly.drive_train import SpeedProfile
from autobalancer.errors import QuestionError, RangeWarning, one_of, warn
from autobalancer.files.machine_file import balls_in_races
from autobalancer.flow.annulus import Annulus, Walls, annulus_of
from autobalancer.flow.relaxation import (
    Expected,
    Solved,
    WallSpeed,
    all_modes,
    diffusive_swirl,
    expected,
    percent,
    wall_speed,
)
from autobalancer.machine import Machine
from autobalancer.machine.drive import PrescribedSpeed
from autobalancer.progress import Progress, shows_progress
from autobalancer.results.answers.answer import Labeled, provenance
from autobalancer.units import argument, list_argument, optional_argument

Model = Literal["auto", "modes", "chebyshev", "azimuthal"]

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
        ``modes``: diffusion alone, exact; ``chebyshev``: the full equations; ``auto``: modes if neglecting the
        secondary flow costs less than ``error``, else ``chebyshev``. ``azimuthal``: without secondary flow, with the viscosity
        of the local rate of shear; a fluid with a shear law always takes it, and a warning says where secondary flow matters.
    points
        Intervals in radial and axial direction for the full equations.
    error
        Of the angular velocity at the orbit over the greatest speed of the rotor.
    balancer, race
        Counted from 1.
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
    one_of("model", model, *get_args(Model))
    if annulus.sheared is not None and model not in ("auto", "azimuthal"):
        raise QuestionError(
            f"model: given {model!r}, which is for constant viscosity; a fluid with a shear law has the model 'azimuthal'"
        )
    if samples < 2:
        raise QuestionError(f"samples: given {samples}; must be at least 2")
    moments = sorted({float(t) for t in times} or {end})
    if moments[0] < 0.0 or moments[-1] > end:
        raise QuestionError(f"times: given {moments[0]:g} to {moments[-1]:g} s; must lie within 0 and {end:g} s")
    # how much the secondary flow, which modes leave out, would change decides on the solver
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

        solved = by_solver(annulus, walls, end, grid, moments, seen, points, error, progress)
    reason = (
        f"diffusion alone is enough, wrong by at most {percent(seen.error)} of the greatest speed"
        if seen.error <= error
        else "a secondary flow carries the fluid along; without it the speed of the fluid would be wrong by up to "
        f"{percent(min(seen.error, 1.0))} of the greatest speed"
    )
    return _flow_dataset(
        annulus, solved, diffusion, name, _reason(model, annulus, reason, seen.error), seen, walls.settled
    )


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


def _flow_dataset(
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
        speed = _machine_speed(machine)
    if duration is None and machine is not None and machine.run is not None:
        duration = float(machine.run.duration)
    if duration is None or not duration > 0.0:
        given = "missing" if duration is None else f"given {duration:g} s"
        raise QuestionError(f"duration: {given}; must be a time greater than 0 s")
    return annulus, speed, duration, name


def _machine_speed(machine: Machine) -> SpeedProfile:
    """The profile of a machine whose speed is prescribed.

    Raises
    ------
    QuestionError
        If a torque drives, because then the speed is known only after a run.
    """
    if not isinstance(machine.drive, PrescribedSpeed):
        raise QuestionError(
            f"drive: of kind {machine.drive.kind!r}, so the speed is not known before a run; give 'speed', a profile "
            "or a number in rad/s"
        )
    return machine.drive.profile


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


# Azimuthal flow of a fluid whose viscosity depends on the rate of shear, in an annulus of rectangular cross-section.
#
# Angular momentum alone, r^3 W_t = (r^3 n W_r)_r + (r^3 n W_z)_z with the kinematic viscosity n = nu s(g) at the rate
# of shear g = r |grad W|; secondary flow is left out. Bilinear elements on half of the height, g at their Gauss
# points; the mass of a node is lumped. The slope of the stress is positive, so each implicit step is a convex problem
# and Newton's steps find it.


POINTS = (48, 32)  # intervals along the radius and over the height
CROWDED = 0.6  # how much closer points stand at walls: 0 evenly, 1 as Chebyshev's
STEEP = 1e-4  # relative step for the slope of the viscosity
MOST_STEPS = 200


@dataclass(frozen=True)
class Elements:
    """Matrices of bilinear elements: gradients at the Gauss points, their weights r^3 dr dz, and masses of the nodes."""

    along_r: Any  # (gauss, node)
    along_z: Any
    weight: Floats  # (gauss,)
    radius: Floats  # of the Gauss points
    mass: Floats  # (node,)


class ShearFlow:
    """The flow relative to walls that turn with the rotor.

    Parameters
    ----------
    annulus
        The chamber and its fluid; without a shear law its viscosity is constant.
    radial, axial
        Intervals along the radius and over the height, which is even.
    walls
        Angular velocities of single walls relative to the rotor; lids that are None exert no stress.
    """

    def __init__(
        self, annulus: Annulus, radial: int = POINTS[0], axial: int = POINTS[1], walls: Walls | None = None
    ) -> None:
        if radial < 4 or axial < 4 or axial % 2:
            raise QuestionError(
                f"points: given {radial}x{axial}; must be 4 or more, and an even number over the height"
            )
        self.annulus, self.walls = annulus, walls or Walls(bottom=0.0, top=0.0)
        self.radius = annulus.inner + annulus.width * _spread(radial)
        self.half = annulus.height * _spread(axial)[: axial // 2 + 1]
        self.height = np.concatenate([self.half, annulus.height - self.half[-2::-1]])
        self.shape = radial + 1, self.half.size

    @cached_property
    def elements(self) -> Elements:
        """Of the half below mid-height."""
        return _elements(self.radius, self.half)

    @cached_property
    def held(self) -> Any:
        """Which nodes are on walls; (node,)."""
        on = np.zeros(self.shape, bool)
        on[0], on[-1] = True, True
        on[:, 0] |= self.walls.bottom is not None
        return on.ravel()

    @cached_property
    def given(self) -> Floats:
        """Angular velocity relative to the rotor of the nodes on walls; zero elsewhere; (node,)."""
        value = np.zeros(self.shape)
        if self.walls.bottom is not None:
            value[:, 0] = self.walls.bottom
        value[0], value[-1] = self.walls.inner, self.walls.outer
        return value.ravel()

    def viscosity(self, rate: Floats) -> Floats:
        """Kinematic, m^2/s."""
        law = self.annulus.sheared
        return np.full(rate.shape, self.annulus.viscosity) if law is None else self.annulus.viscosity * law.share(rate)

    def rates(self, swirl: Floats) -> Floats:
        """Rate of shear at the Gauss points, 1/s; ``swirl`` (node,)."""
        e = self.elements
        return np.asarray(e.radius * np.hypot(e.along_r @ swirl, e.along_z @ swirl))

    def friction(self, swirl: Floats) -> Floats:
        """What viscosity takes from each node, over 2 pi rho; (node,)."""
        e = self.elements
        stiff = e.weight * self.viscosity(self.rates(swirl))
        return np.asarray(e.along_r.T @ (stiff * (e.along_r @ swirl)) + e.along_z.T @ (stiff * (e.along_z @ swirl)))

    def slope(self, swirl: Floats) -> Any:
        """Derivative of :meth:`friction`, a sparse symmetric matrix."""
        e = self.elements
        along = np.array([e.along_r @ swirl, e.along_z @ swirl])
        size = np.hypot(*along)
        rate = e.radius * size
        viscosity, step = self.viscosity(rate), STEEP * np.maximum(rate, 1e-12)
        rising = (self.viscosity(rate + step) - viscosity) / step * rate  # n'(g) g
        unit = np.divide(along, size, out=np.zeros_like(along), where=size > 0.0)
        parts = [[e.weight * (viscosity * (i == j) + rising * unit[i] * unit[j]) for j in range(2)] for i in range(2)]
        both = (e.along_r, e.along_z)
        return sum(both[i].T @ sp.diags(parts[i][j]) @ both[j] for i in range(2) for j in range(2)).tocsc()

    def steady(self) -> Matrix:
        """Steady angular velocity relative to the rotor; (radius, half of the height).

        Raises
        ------
        QuestionError
            If Newton's steps do not converge.
        """
        swirl, free = self.given.copy(), ~self.held
        swirl[free] = 0.5 * (self.walls.inner + self.walls.outer)
        scale = 0.0
        for _ in range(MOST_STEPS):
            rest = self.friction(swirl)[free]
            size = float(np.abs(rest).max())
            scale = max(scale, size)
            if size <= 1e-11 * scale:
                return np.asarray(swirl.reshape(self.shape))
            step, part = spsolve(self.slope(swirl)[free][:, free], -rest), 1.0
            while part > 1e-6:
                tried = swirl.copy()
                tried[free] += part * step
                if np.linalg.norm(self.friction(tried)[free]) < np.linalg.norm(rest):
                    break
                part *= 0.5
            swirl = tried
        raise QuestionError(
            "flow: no steady flow was found; take a shear law that changes less abruptly, or fewer points"
        )

    def march(
        self, speed: WallSpeed, end: float, times: Floats, error: float, progress: Progress | None = None
    ) -> tuple[Matrix, int]:
        """Angular velocity relative to the rotor at ``times``, (time, radius, half of the height), and the number of steps.

        ``error`` is that of the angular velocity over the greatest speed.
        """
        # unknowns are the nodes that no wall holds; the fluid turned with the rotor before
        free, e = ~self.held, self.elements
        mass = e.mass[free]
        state = self.given.copy()
        state[free] += speed.before - speed.at(0.0)[0]
        speeds, steps = np.empty((times.size, state.size)), 0
        speeds[times <= 0.0] = state
        edges = [0.0, *speed.corners(end), end]
        size = max(speed.fastest(end), 1e-300)
        for first, last in pairwise(edges):
            piece = speed.piece(first)

            # in axes of the rotor its acceleration is an inertial force
            def rate(time: float, values: Floats, piece: Any = piece) -> Floats:
                if progress is not None:
                    progress(time, end)
                whole = self.given.copy()
                whole[free] = values
                return np.asarray(-self.friction(whole)[free] / mass - speed.at(time, piece)[1])

            def slope(time: float, values: Floats) -> Any:
                whole = self.given.copy()
                whole[free] = values
                return -sp.diags(1.0 / mass) @ self.slope(whole)[free][:, free]

            inside = np.flatnonzero((times > first) & (times <= last))
            solved = solve_ivp(
                rate,
                (first, last),
                state[free],
                method="BDF",
                jac=slope,
                t_eval=np.append(times[inside][times[inside] < last], last),
                rtol=0.03 * error,
                atol=0.01 * error * size,
            )
            if not solved.success:
                raise QuestionError(f"flow: the steps became too small at {solved.t[-1]:g} s: {solved.message}")
            state[free] = solved.y[:, -1]
            speeds[np.ix_(inside, np.flatnonzero(free))] = solved.y[:, : inside.size].T
            speeds[np.ix_(inside, np.flatnonzero(self.held))] = self.given[self.held]
            steps += int(solved.nlu)
        return speeds.reshape(times.size, *self.shape), steps

    def at_orbit(self, swirl: Matrix) -> Floats:
        """Angular velocity relative to the rotor at the orbit at mid-height; ``swirl`` (..., radius, half of the height)."""
        return np.asarray(CubicSpline(self.radius, swirl[..., -1], axis=-1)(self.annulus.orbit_radius))

    def whole(self, swirl: Matrix) -> Matrix:
        """Both halves of the height."""
        return np.concatenate([swirl, swirl[..., -2::-1]], axis=-1)

    def torque(self, swirl: Matrix, acceleration: float) -> float:
        """Of all walls on the fluid, N m."""
        on = self.held
        reaction = self.friction(swirl.ravel())[on] + self.elements.mass[on] * acceleration
        return float(4.0 * math.pi * self.annulus.density * reaction.sum())

    def momentum(self, swirl: Matrix, speed: float) -> float:
        """Angular momentum of the fluid, kg m^2/s."""
        return float(4.0 * math.pi * self.annulus.density * self.elements.mass @ (swirl.ravel() + speed))

    def mean_viscosity(self, swirl: Matrix) -> float:
        """Mean over the fluid, weighted with the dissipation, m^2/s; that at rest where nothing is sheared."""
        rate = self.rates(swirl.ravel())
        weight = self.elements.weight * self.viscosity(rate) * rate**2
        if weight.sum() == 0.0:
            return self.annulus.viscosity
        return float(weight @ self.viscosity(rate) / weight.sum())


def by_shear(
    annulus: Annulus,
    walls: WallSpeed,
    grid: Floats,
    moments: list[float],
    points: tuple[int, int] | None,
    error: float,
    progress: Progress | None,
) -> tuple[Solved, Expected]:
    """The flow at the times of ``grid`` and ``moments``, and what to expect of one with the mean viscosity where it lags most."""
    flow, end = ShearFlow(annulus, *(points or POINTS)), float(grid[-1])
    times = np.union1d(grid, moments)
    swirl, steps = flow.march(walls, end, times, error, progress)
    lag = flow.at_orbit(swirl)
    thin = replace(annulus, viscosity=flow.mean_viscosity(swirl[int(np.abs(lag).argmax())]), sheared=None)
    kept = np.searchsorted(times, moments)
    speeds = [walls.at(time) for time in moments]
    fields = flow.whole(swirl[kept])
    solved = Solved(
        model="azimuthal",
        times=grid,
        speed=walls.over(grid),
        orbit=walls.over(grid) + lag[np.searchsorted(times, grid)],
        radius=flow.radius,
        height=flow.height,
        moments=np.array(moments),
        swirl=fields,
        stream=np.zeros_like(fields),
        vorticity=np.zeros_like(fields),
        torque=np.array([flow.torque(swirl[i], rate) for i, (_, rate) in zip(kept, speeds, strict=True)]),
        momentum=np.array([flow.momentum(swirl[i], speed) for i, (speed, _) in zip(kept, speeds, strict=True)]),
        moment_speed=walls.over(np.array(moments)),
        steps=steps,
    )
    return solved, expected(thin, all_modes(thin), walls, end)


def _spread(count: int) -> Floats:
    x = np.linspace(0.0, 1.0, count + 1)
    return np.asarray((1.0 - CROWDED) * x + CROWDED * 0.5 * (1.0 - np.cos(math.pi * x)))


def _elements(radius: Floats, height: Floats) -> Elements:
    nr, nz = radius.size, height.size
    number = np.arange(nr * nz).reshape(nr, nz)
    corners = np.stack([number[:-1, :-1], number[1:, :-1], number[:-1, 1:], number[1:, 1:]], -1).reshape(-1, 4)
    dr, dz = (np.repeat(np.diff(radius), nz - 1), np.tile(np.diff(height), nr - 1))
    low = np.repeat(radius[:-1], nz - 1)
    rows, weights, radii, mass = [], [], [], np.zeros(nr * nz)
    for s in (0.5 - 0.5 / math.sqrt(3.0), 0.5 + 0.5 / math.sqrt(3.0)):
        for t in (0.5 - 0.5 / math.sqrt(3.0), 0.5 + 0.5 / math.sqrt(3.0)):
            r = low + s * dr
            weight = 0.25 * dr * dz * r**3
            shapes = ((1 - s) * (1 - t), s * (1 - t), (1 - s) * t, s * t)
            slopes = ((-(1 - t), 1 - t, -t, t), (-(1 - s), -s, 1 - s, s))
            rows.append([np.outer(1.0 / length, slope) for length, slope in zip((dr, dz), slopes, strict=True)])
            weights.append(weight)
            radii.append(r)
            for corner, shape in enumerate(shapes):
                np.add.at(mass, corners[:, corner], shape * weight)
    count = corners.shape[0]
    place = (np.repeat(np.arange(4 * count), 4), np.tile(corners, (4, 1)).ravel())
    along = [
        sp.csr_matrix((np.concatenate([row[i] for row in rows]).ravel(), place), shape=(4 * count, nr * nz))
        for i in range(2)
    ]
    return Elements(along[0], along[1], np.concatenate(weights), np.concatenate(radii), mass)
