"""Measures of places at the end of a run: vibration apart from static deflection, residual unbalance, forces."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import ParamSpec, TypeVar

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.machine.part import Part
from autobalancer.results.answers.answer import Labeled
from autobalancer.results.chamber_shape import is_chamber_run
from autobalancer.results.series import complexes, means, plain, share_of, standing_in
from autobalancer.units import shortened

# Functions of a run that are asked of something else say what they want.


Arguments = ParamSpec("Arguments")
Answer = TypeVar("Answer")
RUNS, CHAMBER_RUNS = "simulate", "simulate_chamber"


def of_a_run(
    *, runs: str = RUNS, of_machine: str = "", called: str = ""
) -> Callable[[Callable[Arguments, Answer]], Callable[Arguments, Answer]]:
    """Refuse a first argument that is no run, with a :class:`QuestionError`.

    Parameters
    ----------
    runs
        The function that gives such runs.
    of_machine
        What to call where a machine is given and its own answer is wanted.
    called
        The public function that asks, by default of the same name.
    """

    def checked(function: Callable[Arguments, Answer]) -> Callable[Arguments, Answer]:
        name = called or function.__name__

        @wraps(function)
        def asked(*arguments: Arguments.args, **named: Arguments.kwargs) -> Answer:
            run = arguments[0] if arguments else named.get("run")
            if (arguments or "run" in named) and not isinstance(run, xr.Dataset):
                raise QuestionError(_wanted(name, run, runs, of_machine))
            if isinstance(run, xr.Dataset):
                _refuse_other_kind(name, run, runs)
            return function(*arguments, **named)

        return asked

    return checked


def _refuse_other_kind(name: str, run: xr.Dataset, runs: str) -> None:
    if is_chamber_run(run) != (runs == CHAMBER_RUNS):
        given, wanted = ("deep chambers", "balls in races") if runs == RUNS else ("balls in races", "deep chambers")
        raise QuestionError(f"{name}: given a run of {given}, or a result that is no run; this is for {wanted}")
    if "machine" not in run.attrs:
        raise QuestionError(f"{name}: the run has lost its attributes, such as its machine; give it as it was computed")


def _wanted(name: str, given: object, runs: str, of_machine: str) -> str:
    if isinstance(given, Part):
        of_it = f"; of the machine itself ask {of_machine}" if of_machine else ""
        return f"{name}: given a machine; it measures a run, as in ab.{name}(ab.{runs}(machine)){of_it}"
    if isinstance(given, (str, Path)):
        return f"{name}: given {shortened(str(given))}; it measures a run, as in ab.{name}(ab.load_run('run.nc'))"
    return f"{name}: given a {type(given).__name__}; it measures a run of {runs}, or one from load_run"


Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
WHEN = "in the last revolutions"
NO_TURNS = (
    "the run kept no whole revolution at its end; run it longer, to a speed above zero (a run that is interrupted keeps "
    "none; in Python, save must hold LastRevolutions())"
)


@of_a_run()
def vibration(run: xr.Dataset, place: str | None = None) -> xr.Dataset:
    """Static deflection and vibration at the end of a run, separately, at every place.

    The places are the planes of the balancers and the named stations. The static deflection is the mean over the last
    whole revolutions that the run kept, and of the balls where these whirl at another speed; none on a vertical axis, where
    nothing is static unless a recorded force is. The vibration is the rest; it includes the oscillation of balls under gravity.

    Parameters
    ----------
    run
        From :func:`simulate`, with ``LastRevolutions``, which it keeps by default.
    place
        Name of a plane or station; by default all, along the dimension ``place``.

    Returns
    -------
    xarray.Dataset
        ``static_x``, ``static_y``, ``static`` (m); ``greatest``, the greatest distance from the mean position (m);
        ``half_range``, half of the range along x or y, whichever is greater (m); ``rms`` (m) and ``velocity_rms`` (m/s),
        root mean squares in the direction in which they are greatest, as sensors along one direction measure (ISO 20816).

    Raises
    ------
    QuestionError
        If the run kept no whole revolution, or has no such place.
    """
    last = run.isel(turn=whole_turns(run))
    z, v = (last[f"turn_place_{x}"].values + 1j * last[f"turn_place_{y}"].values for x, y in (("x", "y"), ("vx", "vy")))
    mean = standing_in(last, z)
    greatest, rms, velocity = moved(z, v, mean)
    found = _measured(
        run,
        "Vibration",
        ("place", run["place"].values),
        static_x=(mean.real, "m", "static deflection along x"),
        static_y=(mean.imag, "m", "static deflection along y"),
        static=(sizes(mean), "m", "static deflection"),
        greatest=(greatest, "m", "greatest distance from the mean position"),
        half_range=(half_range(z), "m", "half of the range of the deflection"),
        rms=(rms, "m", "root mean square of the vibration"),
        velocity_rms=(velocity, "m/s", "root mean square of the velocity"),
    )
    return found if place is None else _chosen(found, "place", place)


@of_a_run()
def static_deflection(run: xr.Dataset, place: str | None = None) -> complex:
    """Mean deflection x + i y (m) in the last revolutions at a place, by default the reference place.

    Raises
    ------
    QuestionError
        If the run kept no whole revolution, or has no such place.
    """
    everywhere = vibration(run)
    here = _chosen(everywhere, "place", str(everywhere["place"].values[0]) if place is None else place)
    return complex(float(here["static_x"]), float(here["static_y"]))


@of_a_run()
def residual_unbalance(run: xr.Dataset, plane: str | None = None) -> xr.Dataset:
    """Residual unbalance in each plane of balancers in the last revolutions of a run.

    Parameters
    ----------
    run
        From :func:`simulate`, with ``LastRevolutions``.
    plane
        Name of a plane; by default all, along the dimension ``plane``.

    Returns
    -------
    xarray.Dataset
        ``unbalance``, what the balls of the plane have to balance at this speed so that no plane vibrates; ``balls``,
        their resultant; ``residual``, the mean size of the sum of both (all kg m); ``share``, residual over unbalance.

    Raises
    ------
    QuestionError
        If the machine has no balancers, or the run kept no whole revolution.
    """
    if "turn_plane_balls" not in run and "plane" not in run.coords:
        raise QuestionError("the machine has no balancers; there is no plane with a residual unbalance")
    last = run.isel(turn=whole_turns(run))
    size, left = map(means, plane_sizes(last))
    found = _measured(
        run,
        "Residual unbalance",
        ("plane", run["plane"].values),
        unbalance=(size, "kg m", "unbalance that the balls of the plane have to balance"),
        balls=(means(last["turn_plane_balls"].values), "kg m", "resultant of the balls of the plane"),
        residual=(left, "kg m", "residual unbalance of the plane"),
        share=(share_of(left, size), "1", "residual unbalance over unbalance"),
    )
    return found if plane is None else _chosen(found, "plane", plane)


@of_a_run()
def support_forces(run: xr.Dataset, support: str | None = None) -> xr.Dataset:
    """Forces of the rotor on its supports in the last revolutions: the static part, with weight, and the vibrating one.

    For supports on the ground these are the forces on the foundation.

    Returns
    -------
    xarray.Dataset
        Over ``support``, N: ``static_x``, ``static_y``, ``static``; ``greatest``, the greatest distance of the force
        from its mean; ``rms`` of the vibrating part in the direction in which it is greatest.

    Raises
    ------
    QuestionError
        If the run kept no whole revolution, or has no such support.
    """
    last = run.isel(turn=whole_turns(run))
    force = last["turn_support_force_x"].values + 1j * last["turn_support_force_y"].values
    mean = standing_in(last, force)
    greatest, rms, _ = moved(force, force, mean)
    found = _measured(
        run,
        "Support forces",
        ("support", run["support"].values),
        static_x=(mean.real, "N", "static force along x"),
        static_y=(mean.imag, "N", "static force along y"),
        static=(sizes(mean), "N", "static force on the support"),
        greatest=(greatest, "N", "greatest distance of the force from its mean"),
        rms=(rms, "N", "root mean square of the vibrating force"),
    )
    return found if support is None else _chosen(found, "support", support)


def plane_sizes(last: xr.Dataset) -> tuple[Floats, Floats]:
    """Unbalance of each plane and what its balls leave of it in the last revolutions of a run, (times, P) kg m."""
    if "turn_plane_residual" in last:
        return last["turn_plane_unbalance"].values, last["turn_plane_residual"].values
    unbalance, balls = plane_vectors(last, "turn_")  # of a file of an earlier version
    return np.abs(unbalance), np.abs(unbalance + balls)


def plane_vectors(run: xr.Dataset, prefix: str = "") -> tuple[Complexes, Complexes]:
    """Unbalance of each plane and what its balls add up to, complex in the rotor, kg m, (times, P)."""
    unbalance, balls = (
        run[f"{prefix}plane_{name}"].values * np.exp(1j * run[f"{prefix}plane_{name}_angle_in_rotor"].values)
        for name in ("unbalance", "balls")
    )
    return unbalance, balls


def whole_turns(run: xr.Dataset) -> slice:
    """The part of the dimension ``turn`` that makes whole revolutions up to the end, its first entry left out.

    Raises
    ------
    QuestionError
        If there is no whole revolution.
    """
    known = "turn_rotor_angle" in run and "turn_place_x" in run
    turns = turns_of(run["turn_rotor_angle"].values if known else np.zeros(0))
    if turns.start == turns.stop:
        raise QuestionError(NO_TURNS)
    return turns


def turns_of(angle: Floats) -> slice:
    """The part of rotor angles at equal steps that makes whole revolutions up to the end; empty if there is none."""
    from autobalancer.kernels.measures.observables import turns_of as counted

    return slice(angle.size - counted(plain(angle)), angle.size)


def moved(z: Complexes, v: Complexes, mean: Complexes) -> tuple[Floats, Floats, Floats]:
    """Greatest distance from a mean place, rms of that distance and of the velocity, for x + i y, (times, places).

    The rms are those along the direction in which they are greatest.
    """
    from autobalancer.kernels.measures import record_series

    found = np.empty((3, z.shape[1]))
    record_series.moved(complexes(z), complexes(v), z.shape[0], complexes(mean), found)
    return found[0], found[1], found[2]


def sizes(z: Complexes) -> Floats:
    """Size of x + i y."""
    from autobalancer.kernels.measures import record_series

    given = complexes(z)
    found = np.empty(given.shape)
    record_series.sizes(given.ravel(), found.ravel())
    return found


def directions(z: Complexes) -> Floats:
    """Angle of x + i y, rad."""
    from autobalancer.kernels.measures import record_series

    given = complexes(z)
    found = np.empty(given.shape)
    record_series.directions(given.ravel(), found.ravel())
    return found


def half_range(z: Complexes) -> Floats:
    """Half of the range along x or y, whichever is greater, (places,)."""
    return np.asarray(0.5 * np.maximum(np.ptp(z.real, axis=0), np.ptp(z.imag, axis=0)), np.float64)


def _measured(
    run: xr.Dataset, title: str, along: tuple[str, NDArray[np.object_]], **values: tuple[Floats, str, str]
) -> Labeled:
    dimension, names = along
    data = {
        name: (dimension, numbers, {"units": unit, "long_name": f"{text} {WHEN}"})
        for name, (numbers, unit, text) in values.items()
    }
    return Labeled.of_run(run, title, xr.Dataset(data, {dimension: names}))


def _chosen(found: xr.Dataset, dimension: str, name: str) -> xr.Dataset:
    known = [str(entry) for entry in found[dimension].values]
    if name not in known:
        raise QuestionError(f"{dimension}: given {name!r}; the run has {', '.join(map(repr, known))}")
    return found.isel({dimension: known.index(name)})
