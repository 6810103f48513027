"""Which end state follows from which start."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.arrays import Complexes
from autobalancer.assembly.drive_train import without_links
from autobalancer.assembly.places import in_frame
from autobalancer.assembly.system import Assembly, assemble, steady
from autobalancer.assembly.terms import Theory
from autobalancer.catalog.product_tables import NONE_GIVEN
from autobalancer.catalog.resolve import Ball, occupied_angle
from autobalancer.errors import QuestionError
from autobalancer.kernels.integrators import tableau
from autobalancer.kernels.integrators.integrator_state import memory
from autobalancer.kernels.integrators.runge_kutta import FINISHED, advance
from autobalancer.kernels.system import BALLS, SPEED, THETA, Drive, Floats, Matrix, System, X, Y
from autobalancer.machine import Machine
from autobalancer.machine.drive import Constant, PrescribedSpeed, Ramp
from autobalancer.random_numbers import wilson_interval
from autobalancer.results.labels import labeled
from autobalancer.results.time_series import hanging
from autobalancer.results.verdict import BALANCED, NO_VERDICT, NOT, PARTLY, WORSE, verdict_word
from autobalancer.simulation.fluid_lag import diffusing_lags
from autobalancer.simulation.record import record_for
from autobalancer.simulation.steppers import equations
from autobalancer.stability.border import attributes
from autobalancer.stability.friction import RELEASED
from autobalancer.stability.host.stations import Plane, Stations, free_eigenvalues, refuse_forces, station_form
from autobalancer.stability.states.linearized import growth
from autobalancer.stability.states.questions import judged
from autobalancer.stability.states.rest_states import required, states_of

# Which end state follows from which start: basins of attraction, as a map and in percent.
#
# The rule by which an end is named stands in :mod:`autobalancer.stability.basins`.


REVOLUTIONS = (400.0, 20000.0)  # least and most of a hold that is not given
WAY = 1e-4  # rad, by which a race center that should run true is off the axis by less than the rule allows


def question_of(
    machine: Machine, speed: float, hold: float | None, tolerance: float, seed: int, *, ramp: bool
) -> Question:
    """A machine without gravity across its axis made ready, for starts at the speed or with a ``ramp`` up to it."""
    refuse_forces(machine)
    st = station_form(machine)
    lags = diffusing_lags(machine)
    profile = Ramp(start=0.0, end=speed, duration=1.0) if ramp else Constant(speed=speed)
    there = machine.model_copy(update={"drive": PrescribedSpeed(profile=profile)})
    assembly = assemble(without_links(there), seed=seed, contact=False, lags=lags)
    # decay rate of the slowest mode of all stable states, 1/s; infinite if none is stable
    rates = [-growth(judged(st, speed, state)[0], state.freedom) for state in states_of(st, speed)]
    slowest, turn = min([rate for rate in rates if rate > 0.0], default=math.inf), 2.0 * math.pi / speed
    # some decay times of it, and of fluid that a run-up left behind
    forgets = min([slowest, *(float(lag.rates.min()) for lag in (lags if ramp else {}).values())])
    longest = hold or min(max(REVOLUTIONS[0] * turn, 25.0 / forgets), REVOLUTIONS[1] * turn)
    # balls that friction holds may be shaken loose until the rotor has forgotten its start but for a hundredth
    rubs = any(race.friction is not None for balancer in machine.balancers for race in balancer.races)
    earliest = 0.0
    if rubs:
        slowest_of_rotor = float((-free_eigenvalues(st.model, speed).real).min())
        settled = math.log(100.0) / slowest_of_rotor if slowest_of_rotor > 0.0 else math.inf
        earliest = min(settled, 0.5 * longest)
    # of rotors with several coordinates the slowest modes of the balls decay so slowly that balls still have a way to go at
    # 1e-5 of the rotor speed: there they must be near their places
    rest = REST * speed if st.model.pairs == 1 else min(REST * speed, WAY * slowest)
    return Question(machine, assembly, st, speed, longest, tolerance, rest, earliest, rubs)


def released(axes: Iterable[str], acceleration: float | None, balls: Iterable[Ball]) -> str:
    """How the runs begin, in words."""
    axes = list(axes)
    if acceleration or "acceleration" in axes:
        return "after run-ups"
    if any(name.startswith("ball_speed") for name in axes) or any(ball.start_speed for ball in balls):
        return "released at this speed with speeds of their own (not a run-up)"
    return RELEASED if not axes else RELEASED.replace("random", "the given")


def ends_dataset(
    question: Question,
    axes: Mapping[str, Sequence[float]],
    shape: tuple[int, ...],
    starts: Matrix,
    ends: Matrix,
    seed: int,
    acceleration: float | None,
) -> xr.Dataset:
    """Names of the ends and what they leave; ``starts`` and ``ends`` have a row for each run, see :func:`end_state`."""
    # a name for each end; starts in which balls overlap are no starts
    machine, named = question.machine, [end_state(question, end) for end in ends]
    over = End("overlapping start", ("overlapping start",) * len(question.st.names))
    named = [over if bad else one for one, bad in zip(named, overlapping(question, starts), strict=True)]
    # along the axes of the map, or one start after the other
    names = [name.replace("[", "_").rstrip("]") for name in axes]
    dims = tuple(names) if axes else ("run",)
    size = question.assembly.state.size
    n = question.st.moment.size
    states = np.array([STATES.index(one.state) for one in named])
    dataset = xr.Dataset()
    for name, (path, values) in zip(names, axes.items(), strict=True):
        unit, text = unit_of_axis(path), axis_name(path)
        dataset = dataset.assign_coords(
            {name: (name, np.asarray(values, np.float64), {"long_name": text, "units": unit})}
        )
    # what each run left
    dataset["state"] = (dims, states.reshape(shape), {"long_name": "end state", "flag_meanings": list(STATES)})
    dataset["time"] = (dims, ends[:, size + 1].reshape(shape), {"long_name": "time until judged", "units": "s"})
    deflection = np.array([np.abs(deflections(question, end)).max(initial=0.0) for end in ends]).reshape(shape)
    angles = ends[:, BALLS : BALLS + n].reshape(*shape, n)
    dataset["final_ball_angle_in_rotor"] = ((*dims, "ball"), angles, {"long_name": "final ball angle", "units": "rad"})
    dataset = dataset.merge(residuals(question, dims, angles, states.reshape(shape), deflection))
    # the end of each plane by itself
    planes = np.array([[PLANE_STATES.index(name) for name in one.planes] for one in named])
    dataset["plane_state"] = (
        (*dims, "plane"),
        planes.reshape(*shape, -1),
        {"long_name": "end state of a plane", "flag_meanings": list(PLANE_STATES)},
    )
    # shares of the ends with their statistical uncertainty, of random starts only
    possible = states[states != STATES.index("overlapping start")]
    counts = np.bincount(possible, minlength=len(STATES))
    low, high = wilson_interval(counts, max(possible.size, 1))
    dataset = dataset.assign_coords(end=("end", list(STATES)))
    dataset["share"] = ("end", counts / max(possible.size, 1), {"long_name": "share of the starts", "units": "1"})
    if not axes:
        dataset["share_low"] = ("end", low, {"long_name": "lower end of its 95 % interval", "units": "1"})
        dataset["share_high"] = ("end", high, {"long_name": "upper end of its 95 % interval", "units": "1"})
    dataset.attrs = attributes(machine, f"Basins of {machine.name}", Theory.BASIN) | {
        "states": list(STATES),
        "plane_states": list(PLANE_STATES),
        "speed": question.speed,
        "hold": question.hold,
        "tolerance": question.tolerance,
        "seed": seed,
        "released": released(axes, acceleration, question.assembly.balls),
        "overlapping": states.size - possible.size,
        **({"flow_model": "modes"} if diffusing_lags(machine) else {}),
        "remarks": [] if question.rubs else [NONE_GIVEN],
    }
    if axes:
        return dataset
    # the random starts themselves, and the number of the one with the greatest deflection at its end
    dataset["start_ball_angle_in_rotor"] = (("run", "ball"), starts[:, BALLS : BALLS + n], START_ANGLE)
    worst = int(np.nan_to_num(dataset["final_deflection"].values).argmax())
    return dataset.assign_attrs(worst=worst, worst_by="final_deflection", acceleration=0.0)


# The starts of a basin: axes with their values, or random ball angles.


START_ANGLE = {"long_name": "ball angle at the start", "units": "rad", "frame": "rotor"}


def unit_of_axis(name: str) -> str:
    """SI unit of an axis over starts; empty if there is no such axis."""
    return {"ball_angle": "rad", "ball_speed": "rad/s", "acceleration": "rad/s^2"}.get(name.partition("[")[0], "")


def axis_name(path: str) -> str:
    """An axis in words."""
    kind, _, ball = path.partition("[")
    if kind == "acceleration":
        return "acceleration of the run-up"
    which = f"ball {ball.rstrip(']')}" if ball else "all balls"
    return f"start {kind.removeprefix('ball_')} of {which} in the rotor"


# The rule by which the end of a run is named, in this order:
#
# - *balanced*: the balls rest and every race with balls that are not in one row runs true (center within 1/1000 of the
#   deflection scale of the axis of rotation), in all planes; *mixed*: in some of several planes;
# - *coincident*, *in line*: the balls rest in a row with the race center, all on one side, or on both sides;
# - *held by friction*: the balls rest where no ball without friction would;
# - *stalled*: a ball hangs at a whirl that the rotor has passed, by the rule of kernels/measures/record_series.py, on the mean;
# - *chaotic*: the balls keep oscillating, and two runs that start close together diverge exponentially;
# - *oscillating*: the balls keep oscillating, and such runs do not diverge.
#
# Starts at which balls of a race would overlap are marked as such and do not count in the shares.
#
# Balls rest when all are slower in the rotor than 1e-5 of its speed over several looks; on rotors with several
# coordinates, where modes may decay very slowly, when they are near enough to their places. Each plane has a name of
# its own, too: where balls of another plane move, one whose balls swing by less than a degree is *at rest*.


STATES = (
    "balanced",
    "mixed",
    "coincident",
    "in line",
    "held by friction",
    "stalled",
    "oscillating",
    "chaotic",
    "failed",
    "overlapping start",
)
PLANE_STATES = (*(name for name in STATES if name != "mixed"), "at rest")
AT_REST = STATES[:5]
REST = 1e-5  # ball speed over rotor speed
TRUE = 1e-3  # distance of a race center over the deflection scale
NOT_RUN, RESTING, UNDECIDED, FAILED = -1.0, 0.0, 1.0, 2.0  # how a run ended


@dataclass(frozen=True)
class Question:
    """A machine at a speed, ready to be run from many starts."""

    machine: Machine
    assembly: Assembly
    st: Stations
    speed: float
    hold: float
    tolerance: float
    rest: float  # ball speed below which balls rest, rad/s
    earliest: float = 0.0  # s at the speed, before which balls do not count as at rest
    rubs: bool = False  # whether any race has friction


@dataclass(frozen=True)
class End:
    """Names of the end state of a run: of all, and of each plane."""

    state: str
    planes: tuple[str, ...]


def end_state(question: Question, end: Floats) -> End:
    """The end state of a run: its last state, how it ended and when, then mean speeds and swings of balls that do not rest."""
    st, n = question.st, question.st.moment.size
    size, planes = question.assembly.state.size, range(len(question.st.names))
    if end[size] == FAILED:
        return End("failed", ("failed",) * len(planes))
    # a ball that hangs at a whirl is stalled; one that swings oscillates, or chaotically if runs nearby part
    speed, swing = end[size + 2 : size + 2 + n], end[size + 2 + n :]
    if end[size] != RESTING:
        stalled = hanging(speed, question.speed, question.assembly.whirls)
        swinging = swing > math.radians(1.0)
        if stalled.any() or swinging.any():
            moving = "stalled" if stalled.any() else "chaotic" if _diverges(question, end) else "oscillating"
            own = "oscillating" if moving == "stalled" else moving
            return End(
                moving,
                tuple(
                    "stalled"
                    if stalled[st.station == p].any()
                    else own
                    if swinging[st.station == p].any()
                    else "at rest"
                    for p in planes
                ),
            )
    # at rest: every plane is named by where its balls and its center are
    center = centers(question, end)
    names = tuple(_at_rest(question, end[BALLS : BALLS + n], center, st.station == p) for p in planes)
    if "held by friction" not in names and "balanced" in names:
        return End("balanced" if set(names) == {"balanced"} else "mixed", names)
    return End(next(name for name in ("held by friction", "in line", "coincident") if name in names), names)


def centers(question: Question, end: Floats) -> Complexes:
    """Race center of each ball in the rotor, from the axis of rotation, (n,) m.

    Of rotors with several coordinates, some of which may hardly be damped, once the transient of the rotor is gone.
    """
    st, n = question.st, question.st.moment.size
    if st.model.pairs > 1:
        return np.asarray((st.rows @ st.coordinates(question.speed, end[BALLS : BALLS + n]))[st.station] + st.offset)
    whirl = deflections(question, end)
    if not question.assembly.system.rotating:
        whirl = whirl * np.exp(-1j * end[THETA])
    return np.asarray(whirl + st.offset)


def deflections(question: Question, end: Floats) -> Complexes:
    """Of the race of each ball, in the axes of the frame, (n,) m."""
    assembly = question.assembly
    if not assembly.general:
        return np.full(question.st.moment.size, complex(end[X], end[Y]))
    q, _ = in_frame(end[None, : assembly.state.size], assembly)
    x, y = np.moveaxis(assembly.places @ q[0], -1, 0)
    return np.asarray((x + 1j * y)[[ball.balancer for ball in assembly.balls]])


def _at_rest(question: Question, angles: Floats, center: Complexes, here: np.ndarray[Any, Any]) -> str:
    """The name of one plane whose balls rest."""
    along = (np.exp(-1j * angles) * center)[here]
    row = np.abs(along.imag) <= 0.02 * np.abs(along)
    true = np.abs(center[here]) <= TRUE * float(question.assembly.scale[X])
    if (true.any() or not here.any()) and (true | row).all():
        return "balanced"
    if question.rubs and not (true | row).all():
        return "held by friction"
    return "coincident" if len(set(np.sign(along.real[~true]))) <= 1 else "in line"


def overlapping(question: Question, starts: Matrix) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """Which rows of ``starts`` put two balls of a race into one another."""
    result = np.zeros(starts.shape[0], np.bool_)
    balls = question.assembly.balls
    for i, ball in enumerate(balls):
        for j, other in enumerate(balls[:i]):
            if (ball.balancer, ball.race) == (other.balancer, other.race):
                apart = np.abs(np.angle(np.exp(1j * (starts[:, BALLS + i] - starts[:, BALLS + j]))))
                result |= apart < 0.5 * occupied_angle([ball, other]) * (1.0 - 1e-9)
    return result


def _diverges(question: Question, end: Floats) -> bool:
    """Whether neighboring runs part: growth of a small distance over 200 revolutions, renewed at every one."""
    rotating = bool(question.assembly.system.rotating)  # seen from its axes, the rotor is at the angle zero
    turn = Turn(question.machine, question.st, question.speed, 0.0 if rotating else float(end[THETA]))
    state = end[turn.kept]
    small, total = 1e-7, 0.0
    other = state.copy()
    other[4] += small
    for number in range(300):
        state, other = turn(state), turn(other)
        apart = (other - state) / turn.scale
        distance = float(np.linalg.norm(apart))
        if number >= 100:
            total += math.log(max(distance, 1e-300) / small)
        other = state + (other - state) * small / max(distance, 1e-300)
    return total / 200.0 > 0.01


# The map over one revolution of a machine at constant speed, by the compiled equations.


TOLERANCE = 1e-13


class Turn:
    """The map over one revolution of a machine at constant speed, in axes at rest.

    A planar machine counts with smooth races. States are those of the assembly without rotor angle and speed.
    """

    def __init__(self, machine: Machine, p: Plane | Stations, speed: float, angle: float = 0.0) -> None:
        self.assembly: Assembly = assemble(without_links(machine), rotating=False, contact=False, real=False)
        self.system = steadily(self.assembly.system, steady(speed, p.unbalance))
        self.speed, self.count, self.angle = speed, p.moment.size, angle
        self.period = 2.0 * math.pi / speed
        self.pair = tableau.dormand_prince_8()
        self.kept = np.array([i for i in range(self.assembly.state.size) if i not in (THETA, SPEED)])
        self.scale = self.assembly.scale[self.kept]
        self.equations = equations(self.assembly).ready()
        self.record = record_for((), (), self.assembly, self.period)

    def __call__(self, state: Floats, turns: int = 1) -> Floats:
        """The state after so many revolutions."""
        full = np.zeros(self.assembly.state.size)
        full[self.kept], full[SPEED] = state, self.speed
        run = memory(
            full,
            turns * self.period,
            TOLERANCE * self.assembly.scale,
            TOLERANCE * self.assembly.growing,
            total=self.pair.total,
            degree=self.pair.degree,
            longest=self.period,
        )
        run.state[THETA] = self.angle
        self.system.drive.now[0] = 0
        if advance(*self.equations, self.system, self.pair, self.record, run, 10_000_000) != FINISHED:
            raise QuestionError(
                "steady state: the motion grows without limit within one revolution; the start is too far off"
            )
        return np.asarray(run.state[self.kept])


def steadily(system: System, drive: Drive) -> System:
    """The same with another drive, in all of whose segments the loads are those after all schedules."""
    loads = np.repeat(system.host.loads[-1:], len(drive.segments), axis=0)
    return system._replace(drive=drive, host=system.host._replace(loads=loads))


# What the ends of many runs leave: residual unbalance, deflection and verdicts over the starts.


QUANTILES = (0.5, 0.95, 1.0)
MOVING = "balls not at rest"
WORDS = (BALANCED, PARTLY, NOT, WORSE, MOVING)


def residuals(
    question: Question, dims: tuple[str, ...], angles: Floats, states: NDArray[Any], seen: Floats
) -> xr.Dataset:
    """Residual unbalance and deflection of each end, and the distributions over the starts that are possible.

    Where the balls rest, the deflection is the greatest in a turn that they leave once the transient of the rotor is gone;
    else ``seen``, that at the last instant of the run. A verdict compares it with that of evenly spread balls. Of several
    planes the residual is the sum of theirs, and the greatest deflection counts.
    """
    st, speed = question.st, question.speed
    # what the balls of each plane make up, and what they should
    each = moments_of(st, angles)
    try:
        wanted = -st.fixed_load if st.model.pairs == 1 else required(st, speed)
    except QuestionError:  # a critical speed of an undamped rotor
        wanted = np.full(len(st.names), np.nan + 0j)
    left_at = np.abs(each - wanted)
    left, whole = left_at.sum(axis=-1), float(np.abs(wanted).sum())
    resting = np.isin(states, [STATES.index(name) for name in AT_REST])
    possible = states != STATES.index("overlapping start")
    # deflections that these unbalances leave, beside that of evenly spread balls
    alone = float(_deflections(st, speed, np.zeros((1, len(st.names)), np.complex128)).max())
    deflection = _deflections(st, speed, each.reshape(-1, len(st.names))).max(axis=-1).reshape(left.shape)
    ends = np.where(resting & np.isfinite(deflection), deflection, seen)

    # the verdict on each end, and those that never come to rest
    words = [verdict_word(value / alone) if alone > 0.0 else NO_VERDICT for value in deflection[resting]]
    counts = [*(words.count(word) for word in WORDS[:-1]), int((possible & ~resting).sum())]
    shares, planes = np.array(counts) / max(int(possible.sum()), 1), (*dims, "plane")
    of = counted_starts(int(resting.sum()), int(possible.sum()), "starts that end at rest")
    data = {
        "residual_unbalance": (dims, left, "unbalance of rotor and balls together", "kg m"),
        "final_deflection": (dims, ends, "deflection at the end", "m"),
        "plane_residual_unbalance": (planes, left_at, "what the balls of a plane lack to balance it", "kg m"),
        "plane_unbalance": ("plane", np.abs(wanted), "unbalance that the balls of a plane have to balance", "kg m"),
        "residual_quantile": ("quantile", quantiles(left[resting]), f"residual unbalance{of.comment}", "kg m"),
        "deflection_quantile": ("quantile", quantiles(deflection[resting]), f"deflection{of.comment}", "m"),
        "plane_residual_quantile": (
            ("quantile", "plane"),
            quantiles(left_at[resting]),
            f"residual unbalance of a plane{of.comment}",
            "kg m",
        ),
        "verdict_share": ("verdict", shares, "share of the starts", "1"),
        "unbalance": ((), whole, "unbalance without balls", "kg m"),
        "deflection_without_balls": ((), alone, "deflection with evenly spread balls", "m"),
    }
    dataset = labeled(data).assign(quantile_starts=of)
    return dataset.assign_coords(quantile=list(QUANTILES), verdict=list(WORDS), plane=list(st.names))


def quantiles(values: Floats) -> Floats:
    """QUANTILES over the starts, the first axis; nan without any."""
    if len(values):
        return np.asarray(np.quantile(values, QUANTILES, axis=0))
    return np.full((len(QUANTILES), *values.shape[1:]), np.nan)


def counted_starts(count: int, possible: int, which: str) -> xr.DataArray:
    """Over how many starts quantiles are taken; its ``comment`` says so behind a name, nothing where all count."""
    comment = f" of the {count} of {possible} {which}" if count < possible else ""
    return xr.DataArray(count, attrs={"long_name": which, "of": possible, "comment": comment, "units": ""})


def moments_of(st: Stations, angles: Floats) -> Complexes:
    """Resultant m eps e^(i phi) of the balls of each plane for angles (..., n), (..., P) kg m."""
    moments = np.zeros((*angles.shape[:-1], len(st.names)), np.complex128)
    for ball, place in enumerate(st.station.tolist()):
        moments[..., place] += st.moment[ball] * np.exp(1j * angles[..., ball])
    return moments


def _deflections(st: Stations, speed: float, moments: Complexes) -> Floats:
    """Greatest deflection of each plane in a turn with the balls at rest, (k, P) m; infinite where it has no bound."""
    flat = st.plain_at(speed)
    loads = st.fixed_load + moments @ flat.rows  # (k, pairs)
    try:
        if st.isotropic:
            return np.abs(speed**2 * loads @ st.compliance(speed).T @ st.rows.T)
        answer = speed**2 * st.whole_compliance(speed)
    except QuestionError:
        unbounded = np.where(np.abs(loads).max(axis=1) > 0.0, np.inf, 0.0)
        return np.asarray(np.repeat(unbounded[:, None], len(st.names), axis=1))
    pairs = st.model.pairs
    both = np.zeros((len(loads), st.model.size), np.complex128)
    both[:, :pairs], both[:, pairs : 2 * pairs] = loads, -1j * loads
    moved = both @ answer.T
    x, y = moved[:, :pairs] @ st.rows.T, moved[:, pairs : 2 * pairs] @ st.rows.T
    return np.asarray(0.5 * (np.abs(x + 1j * y) + np.abs(x - 1j * y)))
