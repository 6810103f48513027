"""Which end state follows from which start: basins of attraction, as a map and in percent.

The rule by which an end is named stands in :mod:`autobalancer.stability.basins.end_states`.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.assembly.drive import steady
from autobalancer.assembly.fluids import Lags
from autobalancer.assembly.starts import start_angles
from autobalancer.assembly.system import assemble
from autobalancer.catalog.friction_table import NONE_GIVEN
from autobalancer.catalog.resolve import Ball
from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import machine_text
from autobalancer.kernels.integrators import tableau as tableaus
from autobalancer.kernels.integrators.memory import memory
from autobalancer.kernels.settle import settle
from autobalancer.kernels.system import BALLS, SPEED, THETA, VX, VY, Floats, Matrix, System, X, Y, own
from autobalancer.machine import Machine
from autobalancer.random_numbers import generator
from autobalancer.results.provenance import provenance
from autobalancer.simulation.equations import equations
from autobalancer.simulation.fluid_lag import diffusing_lags
from autobalancer.simulation.record import record_for
from autobalancer.stability.basins.end_states import REST, STATES, Question, end_state, overlapping
from autobalancer.stability.basins.residuals import residuals
from autobalancer.stability.friction.held_values import RELEASED
from autobalancer.stability.host.planar import Plane, plane
from autobalancer.stability.host.stations import of_plane
from autobalancer.stability.states.questions import judged
from autobalancer.stability.states.stations import states_of
from autobalancer.stability.states.verdicts import growth

REVOLUTIONS = (400.0, 20000.0)  # least and most of a hold that is not given
START_ANGLE = {"long_name": "ball angle at the start", "units": "rad", "frame": "rotor"}
ROWS = 128  # runs handed to a thread at once


def planar_basin(
    machine: Machine,
    speed: float,
    axes: Mapping[str, Sequence[float]],
    *,
    random: int,
    seed: int,
    acceleration: float | None,
    hold: float | None,
    tolerance: float,
    workers: int | None,
    progress: Callable[[int, int], None] | None,
) -> xr.Dataset:
    """End states of a planar machine without gravity in the plane; the arguments are those of :func:`autobalancer.basin`."""
    p = plane(machine)
    lags = diffusing_lags(machine)
    assembly = assemble(machine, seed=seed, contact=False, lags=lags)
    longest = hold or _long_enough(machine, p, speed, lags if acceleration or "acceleration" in axes else {})
    rubs = any(race.friction is not None for balancer in machine.balancers for race in balancer.races)
    question = Question(machine, assembly, p, speed, longest, tolerance, rubs)
    starts, rates, shape = _starts(question, axes, random, seed, acceleration)
    ends = _settle(question, starts, rates, workers, progress)
    states = np.array([end_state(question, end) for end in ends])
    states[overlapping(question, starts)] = STATES.index("overlapping start")
    found = _dataset(machine, question, axes, shape, ends, states, seed, acceleration)
    return found if axes else _with_starts(found, starts)


def unit_of_axis(name: str) -> str:
    """SI unit of an axis over starts; empty if there is no such axis."""
    return {"ball_angle": "rad", "ball_speed": "rad/s", "acceleration": "rad/s^2"}.get(name.partition("[")[0], "")


def _long_enough(machine: Machine, p: Plane, speed: float, lags: Lags) -> float:
    """Some decay times of the slowest mode of all stable states, and of fluid that a run-up left behind."""
    turn = 2.0 * math.pi / speed
    host = of_plane(p)
    rates = [-growth(judged(host, speed, state)[0], state.freedom) for state in states_of(host, speed)]
    rates += [float(lag.rates.min()) for lag in lags.values()]
    slowest = min([rate for rate in rates if rate > 0.0], default=0.0)
    return min(max(REVOLUTIONS[0] * turn, 25.0 / slowest if slowest else 0.0), REVOLUTIONS[1] * turn)


def released(axes: Iterable[str], acceleration: float | None, balls: Iterable[Ball]) -> str:
    """How the runs begin, in words."""
    axes = list(axes)
    if acceleration or "acceleration" in axes:
        return "after run-ups"
    if any(name.startswith("ball_speed") for name in axes) or any(ball.start_speed for ball in balls):
        return "released at this speed with speeds of their own (not a run-up)"
    return RELEASED if not axes else RELEASED.replace("random", "the given")


def _starts(
    question: Question, axes: Mapping[str, Sequence[float]], random: int, seed: int, acceleration: float | None
) -> tuple[Matrix, Floats, tuple[int, ...]]:
    n, speed = question.p.moment.size, question.speed
    values = [np.asarray(v, np.float64) for v in axes.values()]
    if any(v.ndim != 1 or v.size == 0 or not np.all(np.isfinite(v)) for v in values):
        raise QuestionError("basin: each axis needs a list of finite numbers")
    shape = tuple(v.size for v in values) if axes else (random,)
    count = int(np.prod(shape))
    first = question.assembly.state.copy()
    first[[X, Y, VX, VY, THETA]] = 0.0
    first[SPEED] = 0.0 if acceleration or "acceleration" in axes else speed
    starts, rates = np.tile(first, (count, 1)), np.full(count, acceleration or 0.0)
    if not axes:
        drawn = generator(seed)
        balls = question.assembly.balls
        starts[:, BALLS : BALLS + n] = [start_angles(balls, drawn, given=False) for _ in range(count)]
    for name, grid in zip(axes, np.meshgrid(*values, indexing="ij"), strict=True):
        column = grid.ravel()
        kind, _, ball = name.partition("[")
        if kind == "acceleration" and not ball:
            if column.min() <= 0.0:
                raise QuestionError("basin: an acceleration must be greater than zero")
            rates[:] = column
        elif kind == "ball_speed" and not ball:
            starts[:, BALLS + n :] = column[:, None]
        elif kind in ("ball_angle", "ball_speed") and ball.rstrip("]").isdigit() and 1 <= int(ball.rstrip("]")) <= n:
            starts[:, BALLS + n * (kind == "ball_speed") + int(ball.rstrip("]")) - 1] = column
        else:
            raise QuestionError(
                f"basin: no axis {name!r}; there are ball_angle[1] to ball_angle[{n}], ball_speed[i], ball_speed, "
                "acceleration"
            )
    return starts, rates, shape


def _system(question: Question, ramp: bool) -> System:
    """A copy for one thread: constant speed, or a ramp up to it."""
    system: System = own(question.assembly.system)
    drive = steady(question.speed, question.p.unbalance)
    if ramp:
        segments = np.concatenate([drive.segments, drive.segments]).view(np.recarray)
        segments[-1].start = 1.0
        drive = drive._replace(segments=segments)
    loads = np.repeat(system.host.loads[-1:], len(drive.segments), axis=0)  # after all schedules
    return system._replace(drive=drive, host=system.host._replace(loads=loads))


def _settle(
    question: Question,
    starts: Matrix,
    rates: Floats,
    workers: int | None,
    progress: Callable[[int, int], None] | None,
) -> Matrix:
    size, n = starts.shape[1], question.p.moment.size
    ends = np.zeros((starts.shape[0], size + 2 + 2 * n))
    pair = tableaus.dormand_prince_8()
    done = 0

    def part(first: int) -> None:
        nonlocal done
        rows = slice(first, min(first + ROWS, starts.shape[0]))
        a = question.assembly
        tolerance = question.tolerance
        m = memory(
            starts[first],
            1.0,
            tolerance * a.scale,
            tolerance * a.growing,
            total=pair.total,
            degree=pair.degree,
            longest=1e9,
        )
        system = _system(question, bool(rates.any()))
        record = record_for((), (), a, 1.0)
        rest = REST * question.speed
        settle(
            *equations(question.assembly),
            system,
            pair,
            record,
            m,
            starts[rows],
            rates[rows],
            question.hold,
            rest,
            _steady_after(question) if question.rubs else 0.0,
            ends[rows],
        )
        done += rows.stop - rows.start
        if progress is not None:
            progress(done, starts.shape[0])

    with ThreadPoolExecutor(workers if workers is not None else os.cpu_count() or 1) as pool:
        list(pool.map(part, range(0, starts.shape[0], ROWS)))
    return ends


def _steady_after(question: Question) -> float:
    """Time after which the rotor has forgotten its start but for a hundredth, s; at most half of the time there is."""
    slowest = min(question.p.damping) / (2.0 * question.p.mass)
    return min(math.log(100.0) / slowest if slowest > 0.0 else math.inf, 0.5 * question.hold)


def _dataset(
    machine: Machine,
    question: Question,
    axes: Mapping[str, Sequence[float]],
    shape: tuple[int, ...],
    ends: Matrix,
    states: np.ndarray[Any, Any],
    seed: int,
    acceleration: float | None,
) -> xr.Dataset:
    names = [name.replace("[", "_").rstrip("]") for name in axes]
    dims = tuple(names) if axes else ("run",)
    size = question.assembly.state.size
    n = question.p.moment.size
    found = xr.Dataset()
    for name, (path, values) in zip(names, axes.items(), strict=True):
        unit, text = unit_of_axis(path), _axis_name(path)
        found = found.assign_coords({name: (name, np.asarray(values, np.float64), {"long_name": text, "units": unit})})
    found["state"] = (dims, states.reshape(shape), {"long_name": "end state", "flag_meanings": list(STATES)})
    found["time"] = (dims, ends[:, size + 1].reshape(shape), {"long_name": "time until judged", "units": "s"})
    deflection = np.hypot(ends[:, X], ends[:, Y]).reshape(shape)
    angles = ends[:, BALLS : BALLS + n].reshape(*shape, n)
    found["final_ball_angle_in_rotor"] = ((*dims, "ball"), angles, {"long_name": "final ball angle", "units": "rad"})
    found = found.merge(residuals(question, dims, angles, states.reshape(shape), deflection))
    possible = states[states != STATES.index("overlapping start")]
    counts = np.bincount(possible, minlength=len(STATES))
    low, high = wilson_interval(counts, max(possible.size, 1))
    found = found.assign_coords(end=("end", list(STATES)))
    found["share"] = ("end", counts / max(possible.size, 1), {"long_name": "share of the starts", "units": "1"})
    if not axes:
        found["share_low"] = ("end", low, {"long_name": "lower end of its 95 % interval", "units": "1"})
        found["share_high"] = ("end", high, {"long_name": "upper end of its 95 % interval", "units": "1"})
    found.attrs = {
        **provenance(),
        "title": f"Basins of {machine.name}",
        "machine": machine_text(machine),
        "machine_name": machine.name,
        "states": list(STATES),
        "speed": question.speed,
        "hold": question.hold,
        "tolerance": question.tolerance,
        "seed": seed,
        "released": released(axes, acceleration, question.assembly.balls),
        "overlapping": states.size - possible.size,
        **({"flow_model": "modes"} if diffusing_lags(machine) else {}),
        **({} if question.rubs else {"friction_text": NONE_GIVEN}),
    }
    return found


def _with_starts(found: xr.Dataset, starts: Matrix) -> xr.Dataset:
    """The random starts themselves, and the number of the one with the greatest deflection at its end."""
    n = found.sizes["ball"]
    found["start_ball_angle_in_rotor"] = (("run", "ball"), starts[:, BALLS : BALLS + n], START_ANGLE)
    worst = int(np.nan_to_num(found["final_deflection"].values).argmax())
    return found.assign_attrs(worst=worst, worst_by="final_deflection", acceleration=0.0)


def _axis_name(path: str) -> str:
    kind, _, ball = path.partition("[")
    if kind == "acceleration":
        return "acceleration of the run-up"
    which = f"ball {ball.rstrip(']')}" if ball else "all balls"
    return f"start {kind.removeprefix('ball_')} of {which} in the rotor"


def wilson_interval(counts: np.ndarray[Any, Any], total: int) -> tuple[Floats, Floats]:
    """95 % interval of a share (Wilson 1927)."""
    z = 1.959964
    share = counts / total
    middle = (share + z * z / (2 * total)) / (1 + z * z / total)
    half = z / (1 + z * z / total) * np.sqrt(share * (1 - share) / total + z * z / (4 * total**2))
    return np.maximum(middle - half, 0.0), np.minimum(middle + half, 1.0)
