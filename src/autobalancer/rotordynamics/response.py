"""The synchronous unbalance response: where every station goes once a revolution."""

from __future__ import annotations

import cmath
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, get_args

import numpy as np
import xarray as xr
from scipy.interpolate import CubicHermiteSpline, make_interp_spline

from autobalancer.arrays import Complexes, Floats
from autobalancer.assembly.drive_train import unbalance_factor
from autobalancer.assembly.quantities import with_value_at
from autobalancer.assembly.rotors import balancer_rows, lateral_model, reference, unbalance_load
from autobalancer.assembly.rotors.ellipses import Ellipses, alike_springs, steadily
from autobalancer.assembly.rotors.equivalent_stiffness import Softened, softened
from autobalancer.assembly.rotors.lateral_model import LateralModel
from autobalancer.catalog.resolve import resolve
from autobalancer.errors import QuestionError, one_of
from autobalancer.machine import Machine, Unbalance
from autobalancer.results.answers.answer import Answer, Labeled
from autobalancer.results.labels import labeled
from autobalancer.roots import least
from autobalancer.rotordynamics.natural_modes import (
    FreeMotions,
    Places,
    along_axis,
    attributes,
    checked_speeds,
    chosen_places,
    correlation,
    free_motions,
    greatest_mean,
    mean_of_greatest,
    rotor_of,
    station_coordinates,
    turning,
    whirl,
)
from autobalancer.units import argument, list_argument, unbalance_argument

Quantity = Literal["displacement", "velocity", "acceleration"]
UNITS = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s^2"}  # each is the rate of the one before
AT_ONCE = 4_000_000  # entries of the dynamic stiffnesses that are solved together
STEP, FEWEST, MOST_STEPS = 0.07, 150, 60_000  # of a run-up, over 1/sqrt(growth of the speed); least and greatest number
ROOT = 6.0**0.5
RADAU_TIMES = ((4.0 - ROOT) / 10.0, (4.0 + ROOT) / 10.0, 1.0)
RADAU = np.array(  # Hairer and Wanner (1996), table 5.6
    [
        [(88.0 - 7.0 * ROOT) / 360.0, (296.0 - 169.0 * ROOT) / 1800.0, (-2.0 + 3.0 * ROOT) / 225.0],
        [(296.0 + 169.0 * ROOT) / 1800.0, (88.0 + 7.0 * ROOT) / 360.0, (-2.0 - 3.0 * ROOT) / 225.0],
        [(16.0 - ROOT) / 36.0, (16.0 + ROOT) / 36.0, 1.0 / 9.0],
    ]
)


def response(
    machine: Machine | str | Path,
    speeds: Sequence[float | str] | Floats,
    stations: Sequence[str | float] | str | float | None = None,
    unbalance: UnbalanceArgument | str = None,
    *,
    balls: bool = False,
    ball_angles: Sequence[float | str] | None = None,
    quantity: Quantity = "displacement",
    smooth: bool = False,
    time: Sequence[float | str] | Floats | None = None,
) -> Answer:
    """Response of the rotor to its unbalance over the speed: steady, or on the way through these speeds.

    Rubber that softens with the amplitude has the stiffness and loss of its own deflection: exactly where the machine is alike
    along x and y and moves in circles, else with the first harmonic of its force.

    Parameters
    ----------
    machine
        A machine or the path of a machine file.
    speeds
        Rotor speeds, rad/s, not negative.
    stations
        Names of stations or positions along the axis (m); by default all stations, without any the plane of the first
        balancer.
    unbalance
        By default that of the machine after all its schedules; or :class:`~autobalancer.machine.Unbalance` parts; or
        one number, kg m, complex for one off the zero mark, in the plane of the first balancer.
    balls
        Whether the masses of the balls are added to the rotor, without unbalance of their own.
    ball_angles
        Angles of all balls in the rotor, rad, where they rest: mass and unbalance of the balls are included.
    quantity
        ``displacement``, ``velocity`` or ``acceleration``.
    smooth
        Adds speeds between the given ones where the response changes much, so that a picture shows every peak in full.
    time
        When the rotor has these speeds, s, ascending: the response of this run-up or run-down in place of the steady one, which
        a resonance is late to reach. It begins steadily. Not for rubber that softens.

    Returns
    -------
    xarray.Dataset
        Over ``speed`` and ``station``, in m, m/s or m/s^2: complex amplitudes as ``x_real``, ``x_imag``, ``y_real``,
        ``y_imag`` (x = Re(X e^(i theta)) with the rotor angle theta), ``forward`` and ``backward`` (radii of the two
        circles), ``semi_major``, the greatest deflection, and ``semi_minor``; ``inclination`` of the ellipse (rad),
        ``whirl`` (forward, backward, straight), and ``phase``, ``x_phase``, ``y_phase`` against the unbalance (rad,
        negative where the rotor lags; of the forward circle, along x, along y). Over ``speed`` two measures of all
        chosen stations together, see :func:`~autobalancer.rotordynamics.natural_modes.greatest_mean`: ``mean_of_greatest``,
        Rodrigues et al. 2011, (3), and ``greatest_mean``. Over ``speed`` and ``rubber``, if there is any that softens:
        ``rubber_amplitude`` and ``rubber_minor`` (m, greatest and least deflection), ``rubber_stiffness`` and ``rubber_loss``
        (N/m, means over the ellipse), ``rubber_third_harmonic`` (m, an estimate of the motion at three times the speed that
        is left out; nan of rubber that is strained along one line in a machine that circles).

    Raises
    ------
    QuestionError
        For no, negative or too high speeds, no or unknown stations, no unbalance, an unknown quantity, at an undamped critical
        speed, or where softening rubber has no or two steady ellipses.
    MachineError
        If the rotor is not possible as described, or a position is not on it.
    """
    ball_angles = None if ball_angles is None else list_argument("ball_angles", ball_angles, "rad")
    speeds = list_argument("speeds", speeds, "rad/s")
    unbalance = unbalance_argument(unbalance)
    owner = "response"
    machine, model = rotor_of(machine, balls=balls or ball_angles is not None)
    omega = checked_speeds(speeds, model, owner)
    order = _order(quantity, owner)
    places = chosen_places(machine, model, stations, owner)
    load = load_of(machine, model, unbalance, ball_angles, owner)
    soft = rubber_of(machine, model)
    when = None if time is None else list_argument("time", time, "s")
    # a run-up that is too fast for steady motion: the modes are followed through time
    if when is not None:
        if len(when) != omega.size or len(when) < 4 or not (np.diff(when) > 0.0).all() or smooth or soft is not None:
            raise QuestionError(
                f"{owner}: time: given {len(when)} times for {omega.size} speeds; give four or more that ascend, one for each "
                "speed, without smooth, and for a rotor without rubber that softens"
            )
        motion = _followed(model, np.asarray(when, np.float64), omega, load.load, order)
        n = model.pairs
        x, y = (motion[:, k * n : (k + 1) * n] @ places.deflection.T for k in (0, 1))
        return _labeled(machine, omega, places, (x, y), load, quantity, balls, ball_angles)
    if smooth:
        omega = smooth_speeds(omega, lambda between: np.hstack(amplitudes(model, between, load, places, soft)))
    # on rubber that softens the stiffness belongs to the amplitude that it gives
    steady = None if soft is None else steadily(soft, omega, load.load, owner)
    x, y = amplitudes(model, omega, load, places, soft) if steady is None else motion_at(steady, model, places)
    rate = (1j * omega[:, None]) ** order
    response = _labeled(machine, omega, places, (x * rate, y * rate), load, quantity, balls, ball_angles)
    if soft is not None and steady is not None:
        add_rubber(response, soft, steady)
    return response


def _order(quantity: str, owner: str) -> int:
    """How often the displacement is differentiated."""
    one_of(f"{owner}: quantity", quantity, *UNITS)
    return list(UNITS).index(quantity)


def _labeled(
    machine: Machine,
    omega: Floats,
    places: Places,
    seen: tuple[Complexes, Complexes],
    load: Load,
    quantity: Quantity,
    balls: bool,
    ball_angles: Sequence[float | str] | None,
) -> Answer:
    (x, y), unit, both = seen, UNITS[quantity], ("speed", "station")
    ellipses, turned = whirl(x, y), np.exp(-1j * load.direction)
    mean, greatest = mean_of_greatest(ellipses), greatest_mean(ellipses)
    data = {
        "x_real": (both, x.real, f"real part of the {quantity} along x", unit),
        "x_imag": (both, x.imag, f"imaginary part of the {quantity} along x", unit),
        "y_real": (both, y.real, f"real part of the {quantity} along y", unit),
        "y_imag": (both, y.imag, f"imaginary part of the {quantity} along y", unit),
        "forward": (both, np.abs(ellipses.forward), "radius of the forward circle", unit),
        "backward": (both, np.abs(ellipses.backward), "radius of the backward circle", unit),
        "semi_major": (both, ellipses.semi_major, f"greatest {quantity}, major semi-axis", unit),
        "semi_minor": (both, np.abs(ellipses.semi_minor), f"least {quantity}, minor semi-axis", unit),
        "inclination": (both, ellipses.inclination, "angle of the major axis from x", "rad"),
        "whirl": (both, ellipses.direction, "direction of whirl", ""),
        "phase": (both, np.angle(ellipses.forward * turned), "phase of the forward circle to the unbalance", "rad"),
        "x_phase": (both, np.angle(x * turned), "phase along x to the unbalance", "rad"),
        "y_phase": (both, np.angle(1j * y * turned), "phase along y to the unbalance", "rad"),
        "mean_of_greatest": ("speed", mean, f"mean over the stations of the greatest {quantity} of each", unit),
        "greatest_mean": ("speed", greatest, f"greatest value in time of the mean {quantity} over the stations", unit),
    }
    coordinates = {"speed": ("speed", omega, "rotor speed", "rad/s"), **station_coordinates(places)}
    title = f"Unbalance response of {machine.name}"
    about = attributes(machine, title, balls=balls or ball_angles is not None) | {
        "quantity": quantity,
        "unbalance_angle_in_rotor": load.direction,
        "ball_angles_in_rotor": [] if ball_angles is None else [float(angle) for angle in ball_angles],
    }
    return Answer.of(labeled(data, coordinates, about), "Response")


def amplitudes(
    model: LateralModel, speeds: Floats, load: Load, places: Places, soft: Softened | None = None
) -> tuple[Complexes, Complexes]:
    """Complex amplitudes of the displacement along x and y, each (S, places)."""
    if soft is not None:
        return motion_at(steadily(soft, speeds, load.load, "response", twice=False), model, places)
    n = model.pairs
    size = n if model.isotropic else model.size
    x, y = np.empty((2, speeds.size, places.deflection.shape[0]), np.complex128)
    step = max(1, AT_ONCE // size**2)
    for first in range(0, speeds.size, step):
        part = slice(first, first + step)
        motion = _motion(model, speeds[part], load.load)
        x[part], y[part] = motion[:, :n] @ places.deflection.T, motion[:, n : 2 * n] @ places.deflection.T
    return x, y


def motion_at(steady: Ellipses, model: LateralModel, places: Places) -> tuple[Complexes, Complexes]:
    """The same of a motion on softening rubber."""
    n = model.pairs
    return steady.motion[:, :n] @ places.deflection.T, steady.motion[:, n : 2 * n] @ places.deflection.T


def _motion(model: LateralModel, speeds: Floats, load: Complexes) -> Complexes:
    """Q of q = Re(Q e^(i theta)), (S, N); an isotropic rotor is solved for z = q_x + i q_y."""
    n, square = model.pairs, (speeds**2)[:, None, None]
    if model.isotropic:
        parts = [model.complex_matrices(float(w)) for w in speeds]
        dynamic = np.array([stiff + 1j * w * turning for w, (_, turning, stiff) in zip(speeds, parts, strict=True)])
        dynamic = dynamic - square * parts[0][0]
        force = load
    else:
        dynamic = np.array([model.stiffness_at(w) + 1j * w * model.damping_at(w) for w in map(float, speeds)])
        dynamic = dynamic + square * (1j * model.gyroscopic - model.mass)
        force = np.concatenate([load, -1j * load, np.zeros(model.size - 2 * n)])
    try:
        motion = np.linalg.solve(dynamic, (square * force)[:, 0, :, None])[..., 0]
    except np.linalg.LinAlgError:
        raise QuestionError(
            "response: one of the speeds is a critical speed without any damping, where nothing limits the "
            "response; leave it out, or give the supports damping"
        ) from None
    if model.isotropic:
        motion = np.concatenate([motion, -1j * motion, np.zeros((speeds.size, model.size - 2 * n))], axis=1)
    return np.asarray(motion, np.complex128)


def _followed(model: LateralModel, time: Floats, speeds: Floats, load: Complexes, rate: int) -> Complexes:
    """Q of q = Re(Q e^(i theta)) while the speed changes, or of its first or second derivative; (S, N).

    M (Q'' + 2 i w Q' + (i w' - w²) Q) + (C + w G) (Q' + i w Q) + (K + w' G/2) Q = (w² - i w') load, by the method Radau IIA of
    order five, whose steps are short for the time in which the run-up passes an undamped resonance, 1/sqrt(w'), and for the beats
    of a lightly damped one after it.
    """
    # the speed as a smooth course, and steps that are short against how fast it changes
    course = make_interp_spline(time, speeds, k=3)
    growth, span = course.derivative(), float(time[-1] - time[0])
    steps = int(np.clip(np.ceil(span * np.sqrt(np.abs(growth(time)).max()) / STEP), FEWEST, MOST_STEPS))
    h, n = span / steps, model.pairs
    clock = time[0] + h * np.arange(steps + 1)
    # the amplitude Q of q = Re(Q e^(i theta)) changes slowly, so steps need not follow the turns
    isotropic, force = model.isotropic, np.concatenate([load, -1j * load, np.zeros(model.size - 2 * n)])
    force = load if isotropic else force
    size = force.size
    mass = model.complex_matrices(0.0)[0] if isotropic else model.mass
    g = model.gyroscopic
    gyroscopic = np.asarray(g[:n, :n] + 1j * g[n : 2 * n, :n] if isotropic else g, np.complex128)

    # M (Q'' + 2 i w Q' + (i w' - w^2) Q) + (C + w G)(Q' + i w Q) + (K + w' G/2) Q = load, solved for Q' and Q''
    def of_speed(at: Floats) -> tuple[Complexes, Complexes]:
        """Matrix and constant part of the rate of (Q, Q') at times."""
        w, up = np.clip(course(at), 0.0, model.top_speed), growth(at)
        parts = [
            model.complex_matrices(float(v))[1:]
            if isotropic
            else (model.damping_at(float(v)) + v * model.gyroscopic, model.stiffness_at(float(v)))
            for v in (w if model.speeds.size > 1 else (0.0, 1.0))
        ]
        turning, stiff = (np.array([part[k] for part in parts], np.complex128) for k in (0, 1))
        whirl = turning[1] - turning[0] if model.speeds.size == 1 else gyroscopic
        w, up = w[:, None, None], up[:, None, None]
        if model.speeds.size == 1:
            turning, stiff = turning[0] + w * whirl, stiff[0] + 0.0 * w
        lower = -np.linalg.solve(
            mass, np.concatenate([(1j * up - w**2) * mass + 1j * w * turning + stiff + 0.5 * up * whirl,
                                  2j * w * mass + turning], axis=2)
        )  # fmt: skip
        upper = np.broadcast_to(np.eye(size, 2 * size, size), lower.shape)
        pushed = (w**2 - 1j * up)[:, :, 0] * np.linalg.solve(mass, force)
        return np.concatenate([upper, lower], axis=1), np.concatenate([np.zeros_like(pushed), pushed], axis=1)

    def at_rest(w: float) -> Complexes:
        return _motion(model, np.array([w]), load)[0, :size]

    # begin as in a steady state at this speed, which changes with it
    begin, slope = float(speeds[0]), 1e-4 * float(speeds[0])
    states = np.empty((steps + 1, 2 * size), np.complex128)
    states[0] = np.r_[
        at_rest(begin), growth(time[0]) * (at_rest(begin + slope) - at_rest(begin - slope)) / (2.0 * slope)
    ]
    # Radau's method of three stages: the equations are linear, so many steps are worked out at once
    per = max(1, AT_ONCE // (6 * size) ** 2)
    for first in range(0, steps, per):
        here = clock[first : min(first + per, steps)]
        stages = [of_speed(here + h * c) for c in RADAU_TIMES]
        whole = np.concatenate(
            [np.concatenate([(i == j) * np.eye(2 * size) - h * RADAU[i, j] * a for j in range(3)], axis=2)
             for i, (a, _) in enumerate(stages)], axis=1
        )  # fmt: skip
        right = np.concatenate([np.concatenate([a, b[:, :, None]], axis=2) for a, b in stages], axis=1)
        rates = np.linalg.solve(whole, right).reshape(here.size, 3, 2 * size, 2 * size + 1)
        moved = h * np.einsum("i,kiab->kab", RADAU[2], rates)
        for k, step in enumerate(moved, first):
            states[k + 1] = states[k] + step[:, :-1] @ states[k] + step[:, -1]
    # between the steps by cubics through values and rates
    matrices, pushes = of_speed(clock)
    rates = np.einsum("kab,kb->ka", matrices, states) + pushes
    q, first_rate = (
        CubicHermiteSpline(clock, one[:, :size], two[:, :size])(time)
        for one, two in ((states, rates), (states[:, size:], rates[:, size:]))
    )
    # velocity or acceleration of q itself, if that is asked for
    w, up = speeds[:, None], growth(time)[:, None]
    if rate == 1:
        q = first_rate + 1j * w * q
    elif rate == 2:
        second = CubicHermiteSpline(clock, rates[:, size:], np.gradient(rates[:, size:], clock, axis=0))(time)
        q = second + 2j * w * first_rate + (1j * up - w**2) * q
    if isotropic:
        q = np.concatenate([q, -1j * q, np.zeros((time.size, model.size - 2 * n))], axis=1)
    return np.asarray(q, np.complex128)


# Speeds so close that straight lines between the values show every resonance as it is.


CHORD = 0.1  # of the greater end: a resonance is a circle through zero, so its peak is missed by 1 - cos(0.05), 0.13 %
ROUNDS = 16  # each about halves a step: one of 40 rpm ends at 0.0006 rpm; without damping there is no end
BESIDE = 0.49  # of a step: its middle is often a round speed, and may be a resonance without damping, without any value


def smooth_speeds(speeds: Floats, respond: Callable[[Floats], Complexes]) -> Floats:
    """``speeds``, ascending, with others between where the complex response, (S, places), turns or grows."""
    speeds = np.unique(speeds)
    values = respond(speeds)
    for _ in range(ROUNDS):
        size = np.abs(values)
        far = np.abs(np.diff(values, axis=0)) > CHORD * np.maximum(size[:-1], size[1:])
        wide = np.flatnonzero(far.any(axis=1))
        if wide.size == 0:
            break
        between = speeds[wide] + BESIDE * (speeds[wide + 1] - speeds[wide])
        speeds = np.insert(speeds, wide + 1, between)
        values = np.insert(values, wide + 1, respond(between), axis=0)
    return speeds


# Speeds at which the unbalance response has its peaks: the critical speeds one measures.


Measure = Literal["mean_of_greatest", "greatest_mean"]


def response_peaks(
    machine: Machine | str | Path,
    lowest: float | str,
    highest: float | str,
    stations: Sequence[str | float] | str | float | None = None,
    unbalance: UnbalanceArgument | str = None,
    *,
    balls: bool = False,
    measure: Measure = "mean_of_greatest",
    quantity: Quantity = "displacement",
    samples: int = 1000,
) -> Answer:
    """Peaks of the response between two speeds, with damping; each is refined between the samples.

    Parameters
    ----------
    machine, stations, unbalance, balls, quantity
        As for :func:`~autobalancer.rotordynamics.response.response`.
    lowest, highest
        Rotor speeds, rad/s.
    measure
        Of the chosen stations together: ``mean_of_greatest``, or ``greatest_mean``.
    samples
        Number of speeds of the search; peaks closer than two of its steps are not distinguished.

    Returns
    -------
    xarray.Dataset
        Over ``peak``: ``peak_speed`` (rad/s) and ``peak_amplitude`` (m, m/s or m/s^2), by ascending speed.

    Raises
    ------
    QuestionError
        If the speeds do not ascend from zero, a measure is unknown, or as for ``response``.
    """
    lowest = argument("lowest", lowest, "rad/s")
    highest = argument("highest", highest, "rad/s")
    unbalance = unbalance_argument(unbalance)
    owner = "response_peaks"
    machine, model = rotor_of(machine, balls=balls)
    if not 0.0 <= lowest < highest or not highest <= model.top_speed:
        raise QuestionError(
            f"{owner}: given {lowest:g} to {highest:g} rad/s; must ascend from zero, up to {model.top_speed:g} rad/s at most"
        )
    one_of(f"{owner}: measure", measure, *get_args(Measure))
    order = _order(quantity, owner)
    if samples < 3:
        raise QuestionError(f"{owner}: samples: given {samples}; must be at least 3")
    places = chosen_places(machine, model, stations, owner)
    load = load_of(machine, model, unbalance, None, owner)
    summed = mean_of_greatest if measure == "mean_of_greatest" else greatest_mean

    soft = rubber_of(machine, model)

    # the amplitude over a grid, each peak refined between its neighbors
    def height(speeds: Floats) -> Floats:
        return speeds**order * summed(whirl(*amplitudes(model, speeds, load, places, soft)))

    grid = np.linspace(lowest, highest, samples)
    level = height(grid)
    peaks = []
    for i in np.flatnonzero((level[1:-1] > level[:-2]) & (level[1:-1] >= level[2:])) + 1:
        speed, depth = least(lambda w: -height(np.array([w]))[0], grid[i - 1], grid[i + 1], xtol=1e-10 * grid[i])
        peaks.append((speed, -depth))
    result = labeled(
        {
            "peak_speed": ("peak", [speed for speed, _ in peaks], "speed of the peak", "rad/s"),
            "peak_amplitude": ("peak", [size for _, size in peaks], "amplitude at the peak", UNITS[quantity]),
        },
        None,
        attributes(machine, f"Peaks of the unbalance response of {machine.name}", balls=balls)
        | {"measure": measure, "quantity": quantity, "stations": places.names},
    )
    return Answer.of(result, "ResponsePeaks")


# Whirl orbits at one speed, at stations and along the whole axis.


def whirl_orbits(
    machine: Machine | str | Path,
    speed: float | str,
    stations: Sequence[str | float] | str | float | None = None,
    unbalance: UnbalanceArgument | str = None,
    *,
    balls: bool = False,
    ball_angles: Sequence[float | str] | None = None,
    points: int = 181,
) -> xr.Dataset:
    """Paths of the axis over one revolution under unbalance at a speed.

    Parameters
    ----------
    machine, stations, unbalance, balls, ball_angles
        As for :func:`~autobalancer.rotordynamics.response.response`.
    speed
        Rotor speed, rad/s.
    points
        Number of points of an orbit; the last one equals the first one.

    Returns
    -------
    xarray.Dataset
        Over ``station`` and ``rotor_angle`` (rad, from 0 to a full turn) ``x`` and ``y`` (m); ``whirl``, ``semi_major``,
        ``semi_minor`` (m) and ``inclination`` (rad) over ``station``; ``axis_x`` and ``axis_y`` over ``place`` along the
        axis and ``rotor_angle``.

    Raises
    ------
    QuestionError
        As for :func:`~autobalancer.rotordynamics.response.response`, and for fewer than 9 points.
    """
    ball_angles = None if ball_angles is None else list_argument("ball_angles", ball_angles, "rad")
    speed = argument("speed", speed, "rad/s")
    unbalance = unbalance_argument(unbalance)
    owner = "whirl_orbits"
    machine, model = rotor_of(machine, balls=balls or ball_angles is not None)
    omega = checked_speeds(speed, model, owner)
    if points < 9:
        raise QuestionError(f"{owner}: points: given {points}; must be at least 9")
    at, axis = chosen_places(machine, model, stations, owner), along_axis(machine, model)
    load = load_of(machine, model, unbalance, ball_angles, owner)
    soft = rubber_of(machine, model)
    angle = np.linspace(0.0, 2.0 * np.pi, points)
    here, everywhere = (whirl(*(part[0] for part in amplitudes(model, omega[:1], load, p, soft))) for p in (at, axis))
    orbit, line = turning(here, angle), turning(everywhere, angle)
    title, around, along = f"Whirl orbits of {machine.name}", ("station", "rotor_angle"), ("place", "rotor_angle")
    result = labeled(
        {
            "x": (around, orbit.real, "deflection along x", "m"),
            "y": (around, orbit.imag, "deflection along y", "m"),
            "axis_x": (along, line.real, "deflection of the axis along x", "m"),
            "axis_y": (along, line.imag, "deflection of the axis along y", "m"),
            "whirl": ("station", here.direction, "direction of whirl", ""),
            "semi_major": ("station", here.semi_major, "greatest deflection, major semi-axis", "m"),
            "semi_minor": ("station", np.abs(here.semi_minor), "least deflection, minor semi-axis", "m"),
            "inclination": ("station", here.inclination, "angle of the major axis from x", "rad"),
        },
        {
            "rotor_angle": ("rotor_angle", angle, "rotor angle", "rad"),
            **station_coordinates(at),
            "place": ("place", axis.positions, "position along the axis", "m"),
        },
        attributes(machine, title, balls=balls or ball_angles is not None) | {"speed": float(omega[0])},
    )
    return Labeled.of(result)


# What unbalances a rotor in a question: the machine's own unbalance or another, and balls at rest in it.


UnbalanceArgument = complex | float | Unbalance | Sequence[Unbalance] | None


@dataclass(frozen=True)
class Load:
    """Forces are w^2 Re, Im (load e^(i theta)); ``direction`` is the angle in the rotor that phases count from, rad."""

    load: Complexes  # (pairs,)
    direction: float


def load_of(
    machine: Machine,
    model: LateralModel,
    unbalance: UnbalanceArgument,
    ball_angles: Sequence[float] | None,
    owner: str,
) -> Load:
    """The load of the unbalance and of balls at given angles in the rotor.

    The direction is that of the resultant point unbalance; of the resultant couple if there is no point unbalance.

    Raises
    ------
    QuestionError
        If there is no unbalance at all, or there are more or fewer angles than balls.
    """
    moments, couples = 0j, 0j
    if isinstance(unbalance, (int, float, complex, np.number)):
        moments = complex(unbalance)
        if not cmath.isfinite(moments):
            raise QuestionError(f"{owner}: unbalance: given {unbalance!r}; must be finite, in kg m")
        load = np.asarray(moments * reference(machine, model)[1].deflection, np.complex128)
    else:
        if unbalance is not None:
            parts = [unbalance] if isinstance(unbalance, Unbalance) else list(unbalance)
            machine = with_value_at(machine, "unbalances", tuple(parts))
        load = unbalance_load(machine, model)
        for part in machine.unbalances:
            factor = unbalance_factor(part, np.inf)
            moments += factor * part.vector
            couples += factor * cmath.rect(part.couple or part.misalignment or 0.0, part.angle)
    if ball_angles is not None:
        balls = resolve(machine)
        if len(ball_angles) != len(balls):
            raise QuestionError(
                f"{owner}: ball_angles: given {len(ball_angles)} for {len(balls)} balls; give one for each, in rad"
            )
        rows = balancer_rows(machine, model)
        for ball, angle in zip(balls, ball_angles, strict=True):
            arm = ball.eccentricity + ball.orbit_radius * cmath.exp(1j * float(angle))
            load = load + ball.effective_mass * arm * rows[ball.balancer].deflection
    if not np.any(load):
        raise QuestionError(f"{owner}: the rotor has no unbalance and would not move; give one with 'unbalance'")
    return Load(load, cmath.phase(moments) if moments else cmath.phase(couples))


# Unbalance response on rubber that softens with the amplitude, and its own table.


ModeMotion = Literal["line", "circle", "ellipse"]

PASSES, SAME, NEAR = (
    60,
    1e-12,
    1e-6,
)  # of a mode stiffened by its own amplitude, and relative changes: none, and accepted
ROUND = 1e-6  # of an ellipse that counts as a circle
UNMOVED = 1e-9  # of the largest coordinate


def on_ellipses(soft: Softened, stretch: Complexes, size: Floats, frequency: float) -> LateralModel:
    """The rotor with springs that act as its rubber does in ellipses of a shape (M, 2) and sizes (M,), m."""
    stiffness, damping = soft.sliding.stiffness, soft.sliding.damping
    for law, mount, shape, amplitude in zip(soft.laws, soft.mounts, stretch, size, strict=True):
        if amplitude > UNMOVED * size.max():
            springs = alike_springs(law, shape, float(amplitude), frequency)
            stiffness = stiffness + mount.rows.T @ springs.real @ mount.rows
            damping = damping + mount.rows.T @ springs.imag @ mount.rows / frequency
        else:
            still = law.at_rest(frequency) - law.elastic - 1j * law.viscous * frequency
            stiffness = stiffness + still.real * (mount.rows.T @ mount.rows)
            damping = damping + still.imag / frequency * (mount.rows.T @ mount.rows)
    return replace(soft.sliding, stiffness=stiffness, damping=damping)


def rubber_of(machine: Machine, model: LateralModel) -> Softened | None:
    """The softening rubber of a machine whose mass is that of ``model``; none without any."""
    return softened(machine, lateral_model(machine), model)


def add_rubber(dataset: xr.Dataset, soft: Softened, steady: Ellipses) -> None:
    """Add deflection, stiffness and loss of each piece of rubber, and what the first harmonic leaves out."""
    names = np.array([mount.name for mount in soft.mounts], dtype=object)
    dataset.coords["rubber"] = ("rubber", names, {"long_name": "rubber"})
    for name, numbers, text, unit in (
        ("rubber_amplitude", steady.amplitude, "greatest deflection of the rubber", "m"),
        ("rubber_minor", steady.minor, "least deflection of the rubber, negative where it turns backward", "m"),
        ("rubber_stiffness", steady.stiffness.real, "stiffness of the rubber", "N/m"),
        ("rubber_loss", steady.stiffness.imag, "loss of the rubber", "N/m"),
        ("rubber_third_harmonic", steady.third, "its deflection at three times the speed, left out", "m"),
    ):
        dataset[name] = (("speed", "rubber"), numbers, {"long_name": text, "units": unit})
    beyond = [
        mount.name
        for mount, law, size in zip(soft.mounts, soft.laws, steady.amplitude.max(axis=0), strict=True)
        if size > law.largest_amplitude
    ]
    dataset.attrs["rubber_beyond_its_elements"] = beyond
    apart = np.abs(steady.minor) < (1.0 - ROUND) * steady.amplitude
    if apart.any() and not np.isnan(steady.third).any():
        dataset.attrs["rubber_third_harmonic"] = float((steady.third / steady.amplitude).max())


def at_amplitude(soft: Softened, speed: float, start: FreeMotions, amplitude: float, motion: ModeMotion) -> FreeMotions:
    """Free motions in which the farthest moving piece of rubber moves ``amplitude``; each has its own stiffness.

    K'' counts as the damping K''/w at the frequency of the motion. Pieces that move less in this shape are stiffer.

    Raises
    ------
    QuestionError
        If an ellipse of a mode and the stiffness of the rubber in it are not found together.
    """
    values, vectors = start.eigenvalue.copy(), start.vector.copy()
    for k in range(start.count):
        moved = 0.0
        model: LateralModel | None = None
        for _ in range(PASSES):
            stretch = np.array([mount.rows @ vectors[k] for mount in soft.mounts])  # (M, 2)
            size = np.sqrt(0.5 * ((np.abs(stretch) ** 2).sum(axis=1) + np.abs((stretch**2).sum(axis=1))))
            if size.max() <= UNMOVED * np.abs(vectors[k]).max():
                break  # a shape that leaves the rubber at rest
            sizes, frequency = amplitude * size / size.max(), float(values[k].imag)
            if motion == "ellipse":
                # halfway from the model before, so that shape and stiffness do not swing about each other
                before, model = model, on_ellipses(soft, stretch, sizes, frequency)
                if before is not None:
                    stiffness, damping = before.stiffness + model.stiffness, before.damping + model.damping
                    model = replace(model, stiffness=0.5 * stiffness, damping=0.5 * damping)
            else:
                model = soft.at_amplitude(sizes, frequency, motion)
            every = free_motions(model, speed)
            alike = correlation(vectors[k][None], every.vector, model.mass)[0]
            same = int(np.argmax(alike - 1e-6 * np.abs(every.eigenvalue - values[k]) / abs(values[k])))
            moved = abs(every.eigenvalue[same] - values[k]) / abs(values[k])
            values[k], vectors[k] = every.eigenvalue[same], every.vector[same]
            if moved < SAME:
                break
        if motion == "ellipse" and moved > NEAR:
            raise QuestionError(
                f"modes: mode {k + 1} and the stiffness of the rubber in its ellipse were not found together; give "
                "motion='line' or 'circle', or another amplitude"
            )
    order = np.argsort(
        np.round(values.imag / np.abs(values).max(initial=1e-300), 9), kind="stable"
    )  # keeps pairs in order
    return FreeMotions(values[order], vectors[order], start.real)
