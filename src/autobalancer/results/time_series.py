"""The numbers behind the measures of one run, asked of compiled functions that sweeps use, too.

They are loaded when something is measured, not when measures are named.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, wraps
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from autobalancer.arrays import Complexes, Floats
from autobalancer.errors import KEEP_TURNS, QuestionError
from autobalancer.kernels.measures.thresholds import STALL_MARGIN
from autobalancer.machine import Machine
from autobalancer.machine.part import Part
from autobalancer.machine_kinds import RACES, Kind, machine_kind
from autobalancer.results.answers.answer import Labeled
from autobalancer.units import shortened

ORIGINS = (
    "",
    "start",
    "jump",
    "end of the run-up",
    "release",
)  # in the order of kernels/measures/thresholds.py


@cache
def compiled() -> Any:
    """The compiled functions."""
    from autobalancer.kernels.measures import record_series

    return record_series


def plain(values: ArrayLike) -> Floats:
    """Numbers as compiled functions take them."""
    return np.require(values, np.float64, ["C", "W"])


def each_ball(function: Callable[..., None], *values: Floats | float) -> Floats:
    """What a compiled function of ``values`` writes for each ball; arrays of two dimensions are (time, ball)."""
    numbers = [plain(value) if isinstance(value, np.ndarray) else value for value in values]
    result = np.empty(next(np.shape(value)[1] for value in numbers if np.ndim(value) == 2))
    function(*numbers, result)
    return result


def hanging(rate: ArrayLike, rotor_speed: ArrayLike, whirls: Floats) -> NDArray[np.bool_]:
    """Whether balls with a ``rate`` in the rotor hang at a whirl that it has passed, by the rule of kernels/measures.

    ``whirls`` are (K, 2): critical speeds (rad/s), ascending, and the gyroscopic share of each.
    """

    def one(own: float, speed: float) -> bool:
        return bool(compiled().hangs(own + speed, speed, whirls, STALL_MARGIN))

    return np.asarray(np.vectorize(one, otypes=[bool])(rate, rotor_speed))


def values_at(rows: Floats, values: Floats) -> Floats:
    """Values at rows with a fraction; nan where the row is."""
    values = plain(values)
    return np.array([compiled().value_at(row, values) for row in rows], np.float64)


def lifted_from(values: Floats, floor: Floats) -> Floats:
    """Of values over time that of the first sample from which on the floor carries each ball no more; nan if it does at the end.

    ``floor`` is the force of the floor, (time, ball).
    """
    carried = [np.flatnonzero(force > 0.0) for force in floor.T]
    rows = [int(on[-1]) + 1 if on.size else 0 for on in carried]
    return np.array([values[row] if row < values.size else np.nan for row in rows])


def end_of_run_up(time: Floats, rotor_speed: Floats, start: float) -> float:
    """Time from which the rotor speed stays within 0.1 % of its last value; ``start`` (s) if it always does."""
    return float(compiled().end_of_run_up(plain(time), plain(rotor_speed), start))


def origin_of(after: float, cause: int, start: float, end: float, jumps: Sequence[float] = ()) -> tuple[float, str]:
    """From when (s) settling counts in a run from ``start`` to ``end``, and what happened then.

    That is ``after`` (nan if there is none; ``cause`` is one of those of sweeps) or a jump of the unbalance, if that is later.
    """
    begin, code = compiled().origin_of(after, cause, start, end, plain(list(jumps)))
    return float(begin), ORIGINS[code]


def time_since(begin: float, settled: Floats) -> Floats:
    """How long after ``begin`` (s) balls have settled: zero if they had before, nan if they have not."""
    return np.array([compiled().time_since(begin, at) for at in settled], np.float64)


def wrapped(angle: ArrayLike) -> Floats:
    """The same angle within (-pi, pi]."""
    return _one_by_one(compiled().all_wrapped, plain(angle))


def last_deflection(time: Floats, high: Floats, begin: float) -> float:
    """The greatest of ``high`` (m) from ``begin`` (s) on, the last one in any case."""
    return float(compiled().last_deflection(plain(time), plain(high), begin))


def mean(values: Floats) -> float:
    """Mean of some numbers, summed one after the other."""
    return float(compiled().mean(plain(values)))


def means(values: Floats) -> Floats:
    """The same of each column."""
    return np.array([mean(column) for column in values.T], np.float64)


def sizes_of_means(vectors: Complexes) -> Floats:
    """Size of the mean of each column of complex numbers: what swings to and fro in the rotor is no unbalance of it."""
    x, y = means(vectors.real), means(vectors.imag)
    return np.asarray(np.sqrt(x * x + y * y))


def share_of(part: ArrayLike, whole: ArrayLike) -> Floats:
    """``part`` over ``whole``; nan where there is no whole."""
    part, whole = np.asarray(part, np.float64), np.asarray(whole, np.float64)
    return np.asarray(np.divide(part, whole, out=np.full_like(part, np.nan), where=whole > 0.0))


def crests(time: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Where the greatest of each column of samples (T, L) is in size, s, and its value there, both (L,).

    Between samples it is the vertex of the parabola through the greatest one and its neighbors: of a sine with ten samples in a
    cycle 0.4 % too low at most, where the greatest sample is up to 5 % too low.
    """
    at = np.abs(values).argmax(axis=0)
    columns = np.arange(values.shape[1])
    before, after = np.maximum(at - 1, 0), np.minimum(at + 1, len(time) - 1)
    best, top = np.asarray(time[at], np.float64), values[at, columns]
    inside = (before < at) & (at < after)
    left, right = time[at] - time[before], time[after] - time[at]
    rise, fall = top - values[before, columns], values[after, columns] - top
    with np.errstate(divide="ignore", invalid="ignore"):
        bend = (fall / right - rise / left) / (left + right)
        slope = (rise / left * right + fall / right * left) / (left + right)
        shift = np.where(inside & (bend != 0.0), -0.5 * slope / bend, 0.0)
        more = np.where(inside & (bend != 0.0), 0.5 * slope * shift, 0.0)
    return best + shift, top + more


def greatest_at(values: Floats) -> int:
    """Where the greatest is, the first one; nan is greater than all, so that of times it is the one that never comes."""
    return int(compiled().greatest_at(plain(values)))


def greatest_known(values: Floats) -> float:
    """The greatest that is a number; nan if there is none."""
    return float(compiled().greatest_known(plain(values)))


# What of a motion in space stands still: its mean over whole turns of everything that whirls.


WEIGHT, RECORD, NONE = "weight", "recorded excitation", "none"


def static_load(machine: Machine) -> str:
    """What can deflect a rotor for good: ``"weight"``, ``"recorded excitation"`` or ``"none"``.

    Without such a load no direction in space is preferred, on any supports: with every motion its opposite is possible, too.
    """
    if machine.axis == "horizontal":
        return WEIGHT
    recorded = any(part.kind in ("recorded_force", "recorded_base_motion") for part in machine.excitations)
    return RECORD if recorded else NONE


def standing(z: Complexes, rotor: Floats, balls: Floats, load: str) -> Complexes:
    """The part of x + i y that stands still, (columns,); zero without a static ``load``.

    Parameters
    ----------
    z
        (times, columns), at equal steps of the rotor angle over whole turns.
    rotor
        Angle of the rotor, rad, (times,).
    balls
        Angles of the balls in space, rad, (times, balls). Where some of them go round both in space and in the rotor, the
        revolutions of the rotor are not those of the deflection. Then the standing part is fitted together with what whirls
        with the rotor, with the balls, and against them. Weights that vanish at both ends (Hann's) suppress the rest.
    """
    result = np.zeros(z.shape[1], np.complex128)
    if load == NONE:
        return result
    count, columns = z.shape[0], 1 + 2 * (1 + balls.shape[1])
    work = np.zeros((max(count, columns), columns + z.shape[1] + 1), np.complex128)
    small = np.zeros((columns, columns + z.shape[1]), np.complex128)
    from autobalancer.kernels.measures.observables import standing as stands

    stands(complexes(z), count, plain(rotor), plain(balls), 0, work, small, result)
    return result


def complexes(values: Any) -> Complexes:
    """x + i y as compiled functions take it."""
    return np.require(values, np.complex128, ["C", "W"])


def calm_mean(values: Complexes | Floats) -> Complexes:
    """Mean over the first axis with weights that vanish at both ends (Hann's), so that parts of turns hardly count.

    What goes round n times adds about 1/n^3 of its size, to the plain mean 1/n.
    """
    steps = len(values)
    weight = np.sin(np.pi * (np.arange(steps) + 0.5) / steps) ** 2
    return np.asarray(np.tensordot(weight / weight.sum(), values, axes=1), np.complex128)


def standing_in(run: xr.Dataset, z: Complexes, prefix: str = "turn_") -> Complexes:
    """The same for the last revolutions of a run, or with ``prefix`` "" for its samples; ``z`` is (times, columns)."""
    rotor = run[f"{prefix}rotor_angle"].values
    name = f"{prefix}ball_angle_in_rotor"
    inside = run[name].values if name in run else np.zeros((rotor.size, 0))
    return standing(z, rotor, rotor[:, None] + inside, load_of(run.attrs))


def load_of(attributes: dict[Any, Any]) -> str:
    """The static load of a run; runs of earlier versions say only how the axis lies."""
    known = WEIGHT if attributes.get("axis", "vertical") == "horizontal" else NONE
    return str(attributes.get("static_load", known))


# Measures of places at the end of a run: vibration apart from static deflection, residual unbalance, forces.


# Functions of a run that are asked of something else say what they want.


Arguments = ParamSpec("Arguments")
Answer = TypeVar("Answer")


def of_a_run(
    *, runs: Kind = RACES, of_machine: str = "", called: str = ""
) -> Callable[[Callable[Arguments, Answer]], Callable[Arguments, Answer]]:
    """Refuse a first argument that is no run, with a :class:`QuestionError`.

    Parameters
    ----------
    runs
        Of which kind they are.
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
                raise QuestionError(_wanted(name, run, of_machine))
            if isinstance(run, xr.Dataset):
                _refuse_other_kind(name, run, runs)
            return function(*arguments, **named)

        return asked

    return checked


def _refuse_other_kind(name: str, run: xr.Dataset, runs: Kind) -> None:
    if (given := machine_kind(run)) is not runs:
        raise QuestionError(
            f"{name}: given a run of {given.words}, or a result that is no run; this is for {runs.words}"
        )
    over_time = "time" in run.dims or {"speed", "envelope_time", "turn_time"} & set(run.coords)
    if not over_time and "answer" in run.attrs:
        raise QuestionError(
            f"{name}: given {run.attrs.get('title')!r}, which is an answer about many runs; print what load_run gives, or plot it"
        )
    if "machine" not in run.attrs:
        raise QuestionError(f"{name}: the run has lost its attributes, such as its machine; give it as it was computed")


def _wanted(name: str, argument: object, of_machine: str) -> str:
    asked = name if name == "verdict" else "run_measures"
    if isinstance(argument, Part):
        of_it = f"; of the machine itself ask {of_machine}" if of_machine else ""
        return f"{name}: given a machine; it measures a run, as in ab.{asked}(ab.simulate(machine)){of_it}"
    if isinstance(argument, (str, Path)):
        return f"{name}: given {shortened(str(argument))}; it measures a run, as in ab.{asked}(ab.load_run('run.nc'))"
    return f"{name}: given a {type(argument).__name__}; it measures a run of simulate, or one from load_run"


WHEN = "in the last revolutions"
NO_TURNS = (
    "the run kept no whole revolution at its end; run it longer, to a speed above zero (a run that is interrupted keeps "
    f"none{KEEP_TURNS})"
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
    found = place_measures(z, v, mean)
    result = _measured(
        run,
        "Vibration",
        ("place", run["place"].values),
        static_x=(mean.real, "m", "static deflection along x"),
        static_y=(mean.imag, "m", "static deflection along y"),
        static=(found.static_deflection, "m", "static deflection"),
        greatest=(found.vibration, "m", "greatest distance from the mean position"),
        half_range=(half_range(z), "m", "half of the range of the deflection"),
        rms=(found.vibration_rms, "m", "root mean square of the vibration"),
        velocity_rms=(found.velocity_rms, "m/s", "root mean square of the velocity"),
    )
    return result if place is None else _chosen(result, "place", place)


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
        their resultant; ``residual``, the size of the mean of the sum of both in the rotor (all kg m); ``share``, residual
        over unbalance.

    Raises
    ------
    QuestionError
        If the machine has no balancers, or the run kept no whole revolution.
    """
    if "turn_plane_balls" not in run and "plane" not in run.coords:
        raise QuestionError("the machine has no balancers; there is no plane with a residual unbalance")
    last = run.isel(turn=whole_turns(run))
    size, left = means(last["turn_plane_unbalance"].values), sizes_of_means(residual_vectors(last, whole=False))
    result = _measured(
        run,
        "Residual unbalance",
        ("plane", run["plane"].values),
        unbalance=(size, "kg m", "unbalance that the balls of the plane have to balance"),
        balls=(means(last["turn_plane_balls"].values), "kg m", "resultant of the balls of the plane"),
        residual=(left, "kg m", "residual unbalance of the plane"),
        share=(share_of(left, size), "1", "residual unbalance over unbalance"),
    )
    return result if plane is None else _chosen(result, "plane", plane)


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
    found = place_measures(force, force, mean)
    result = _measured(
        run,
        "Support forces",
        ("support", run["support"].values),
        static_x=(mean.real, "N", "static force along x"),
        static_y=(mean.imag, "N", "static force along y"),
        static=(found.static_deflection, "N", "static force on the support"),
        greatest=(found.vibration, "N", "greatest distance of the force from its mean"),
        rms=(found.vibration_rms, "N", "root mean square of the vibrating force"),
    )
    return result if support is None else _chosen(result, "support", support)


def residual_vectors(last: xr.Dataset, whole: bool) -> Complexes:
    """What balls leave of the unbalance in the last revolutions, in the rotor, (times, P) kg m; of the ``whole``, (times, 1)."""
    name = "turn_residual" if whole else "turn_plane_residual"
    vectors = np.asarray(last[f"{name}_x"].values + 1j * last[f"{name}_y"].values, np.complex128)
    return vectors[:, None] if whole else vectors


def rotor_unbalance(last: xr.Dataset) -> tuple[float, float]:
    """Unbalance of the whole rotor and what is left of it in the last revolutions, kg m."""
    return mean(last["turn_unbalance"].values), float(sizes_of_means(residual_vectors(last, whole=True))[0])


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


def place_measures(z: Complexes, v: Complexes, mean: Complexes) -> Any:
    """What is measured of each place or support, by name, for x + i y and x' + i y', (times, places), and its ``mean``."""
    result = np.empty((len(compiled().PLACE), z.shape[1]))
    compiled().place_measures(complexes(z), complexes(v), z.shape[0], complexes(mean), result)
    return compiled().Place(*result)


def sizes(z: Complexes) -> Floats:
    """Size of x + i y."""
    return _one_by_one(compiled().sizes, complexes(z))


def directions(z: Complexes) -> Floats:
    """Angle of x + i y, rad."""
    return _one_by_one(compiled().directions, complexes(z))


def _one_by_one(function: Callable[..., None], given: Complexes | Floats) -> Floats:
    """What a compiled function writes for each of many numbers."""
    result = np.empty(given.shape)
    function(given.ravel(), result.ravel())
    return result


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


def _chosen(dataset: xr.Dataset, dimension: str, name: str) -> xr.Dataset:
    known = [str(entry) for entry in dataset[dimension].values]
    if name not in known:
        raise QuestionError(f"{dimension}: given {name!r}; the run has {', '.join(map(repr, known))}")
    return dataset.isel({dimension: known.index(name)})
