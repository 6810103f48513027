"""Stepped frequency response: hold a speed, let transients die, measure, go to the next speed."""

from __future__ import annotations

import cmath
import json
import math
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import nullcontext
from dataclasses import dataclass
from functools import partial
from itertools import chain
from pathlib import Path
from threading import local
from typing import Any, Literal, Unpack

import numpy as np
import xarray as xr

from autobalancer.assembly.places import assemble_locked
from autobalancer.assembly.quantities import with_value_at
from autobalancer.assembly.system import MASS_SPREAD, Assembly
from autobalancer.errors import QuestionError, one_of
from autobalancer.files.machine_file import balls_in_races, machine_text
from autobalancer.kernels.balls.contact_nodes import contacts_in_steps
from autobalancer.kernels.balls.planar_nodes import planar_nodes
from autobalancer.kernels.dwell import Window, hold
from autobalancer.kernels.integrators.collocation import LONG_STEPS, amplitudes
from autobalancer.kernels.integrators.collocation_sweep import by_powers
from autobalancer.kernels.integrators.dense_output import SUM
from autobalancer.kernels.integrators.integrator_state import ACCEPTED, TIME, Memory
from autobalancer.kernels.integrators.runge_kutta import FINISHED
from autobalancer.kernels.system import BALLS, SPEED, Floats, Matrix, own
from autobalancer.machine import Constant, Machine, PrescribedSpeed, Schedule, Start
from autobalancer.progress import interrupts_noted, raise_noted, shows_progress
from autobalancer.results.answers.answer import provenance
from autobalancer.results.answers.run import SteppedResponse
from autobalancer.results.folder_store import Store, refuse_other_question
from autobalancer.results.labels import labeled
from autobalancer.results.store import load_run, save_run
from autobalancer.results.time_series import hanging
from autobalancer.safe_file import as_path
from autobalancer.simulation import MANY_RUNS, STEPPED, ManyRunOptions, SteppedOptions, run_options
from autobalancer.simulation.fluid_lag import prepare
from autobalancer.simulation.record import record_for
from autobalancer.simulation.remarks import CURE, critical_attributes, free_groups, pairs_together, parting_rate
from autobalancer.simulation.run import outcome
from autobalancer.simulation.steppers import LongSteps, long_steps, stepper_for
from autobalancer.units import argument, list_argument, optional_argument

Place = tuple[int, int]  # leg, number of the speed
ALL: SteppedOptions = {**MANY_RUNS, **STEPPED}


@shows_progress
def stepped_response(
    machine: Machine | str | Path,
    speeds: Sequence[float | str] | np.ndarray,
    *,
    dwell: float | str,
    window: float | str,
    direction: Literal["up", "down", "both"] = "up",
    start: Literal["carried", "fixed"] = "carried",
    acceleration: float | str | None = None,
    stations: Sequence[str] | None = None,
    settle: float | str | None = None,
    longest: float | str | None = None,
    mass_spread: float = MASS_SPREAD,
    store: str | Path | None = None,
    **options: Unpack[SteppedOptions],
) -> SteppedResponse:
    """Measure a machine at one speed after the other, as on a test stand (Rodrigues et al. 2011, section 5).

    The drive of the machine is replaced by the prescribed speed; unbalances are those after all schedules.

    Parameters
    ----------
    machine
        A machine or the path of a machine file.
    speeds
        Rotor speeds, rad/s, ascending from above zero.
    dwell
        Time at a speed before it is measured, s.
    window
        Length of the measurement, s.
    direction
        ``up``, ``down``, or ``both``: up, and then down again from where the way up ended.
    start
        ``carried``: every speed begins with the state at the end of the one before, the first one with the start state
        of the machine. ``fixed``: all begin with that.
    acceleration
        Rate at which the speed goes to the next one, rad/s^2; ``None`` changes the speed at once.
    stations
        Names of those whose deflections are averaged; by default all stations of the machine, or without any the place
        that a run calls its deflection.
    settle
        Measure again until the amplitudes of both halves of the window differ by less than this share; by default every
        speed is measured once.
    longest
        With ``settle``: longest time at a speed, s.
    mass_spread
        Relative difference of the masses of equal balls that pass through each other, as for
        :func:`autobalancer.simulate`; 0 leaves them equal; equal balls at one place never separate.
    store
        Result file. Every finished speed is written at once into a folder beside it, ``NAME.nc.parts``; a later call with the
        same arguments continues from there, with results identical to the last bit.
    **options
        ``tolerance`` (1e-7), ``method``, ``max_steps`` at one speed, ``seed``, ``workers`` for ``fixed``, ``progress`` and
        ``keep_on_interrupt``, see :class:`~autobalancer.simulation.ManyRunOptions`; where Ctrl-C ended it, ``attrs["outcome"]``
        is ``interrupted``. ``without_balls`` measures all speeds once more with the balls spread evenly and held.

    Returns
    -------
    xarray.Dataset
        Over ``speed``, with ``direction`` before it for ``both``: ``amplitude`` (mean over the stations of the greatest
        deflection, their equation 3), ``greatest_mean_deflection`` (greatest value in time of the mean deflection, which
        their simulated curves show), ``greatest_deflection`` and ``synchronous_x``, ``synchronous_y`` of every
        ``station``, least and greatest ball angle, mean ball speed, ``ball_motion`` and ``motion``, ``amplitude_change``
        within the window, ``time_at_speed``, ``outcome``; where balls stay at one place ``parting_rate``, above zero if that
        state is unstable, and then ``attrs["remarks"]``; with ``without_balls`` both kinds of amplitude again, with this
        behind their names. ``attrs`` have the number of ``steps``, and how many of
        these were ``long_steps``.

    Raises
    ------
    QuestionError
        For speeds out of order, times not above zero, an unknown station, a store with the result of another study.
    MachineError
        If a table of the machine does not cover the speeds.
    """
    how = run_options("stepped_response", options, ALL)
    seed, progress, without_balls = how["seed"], how["progress"] or None, how["without_balls"]
    settle = optional_argument("settle", settle, "")
    speeds = list_argument("speeds", speeds, "rad/s")
    dwell = argument("dwell", dwell, "s")
    window = argument("window", window, "s")
    acceleration = optional_argument("acceleration", acceleration, "rad/s^2")
    longest = optional_argument("longest", longest, "s")
    machine = balls_in_races(machine)
    chosen = checked_speeds(speeds)
    plan = checked_plan(dwell, window, acceleration, settle, longest, how)
    one_of("direction", direction, "up", "down", "both")
    one_of("start", start, "carried", "fixed")
    if start == "fixed" and (direction != "up" or acceleration is not None):
        raise QuestionError("start: 'fixed' begins every speed anew; leave out direction and acceleration")
    assembly = prepare(at_constant_speed(machine, float(chosen[-1])), None, seed=seed, mass_spread=mass_spread)
    # what the deflection is averaged over, and the same machine with its balls held for comparison
    groups = free_groups(machine)
    names, _, weights = averaged_stations(assembly, stations)
    held = assemble_locked(at_constant_speed(machine, float(chosen[-1]))) if without_balls and assembly.balls else None
    legs = ["up", "down"] if direction == "both" else [direction]
    # all that the answer depends on: a store that holds another question is refused
    question = {
        "machine": machine_text(machine), "speeds": chosen.tolist(), "dwell": dwell, "window": window,
        "direction": direction, "start": start, "acceleration": acceleration, "settle": settle, "longest": longest,
        "stations": [name for name, weight in zip(names, weights, strict=True) if weight > 0.0], "tolerance": plan.tolerance,
        "seed": seed, "mass_spread": mass_spread, "max_steps": plan.max_steps, "source": provenance()["source"],
        **({"without_balls": True} if without_balls else {}),
    }  # fmt: skip
    place = None if store is None else as_path(store)
    if place is not None and (known := _finished(place, question)) is not None:
        return known
    total, interrupted = len(legs) * chosen.size * (1 if held is None else 2), False
    store_of_parts = Store(f"{place}.parts", question, "stepped response") if place is not None else nullcontext()
    with store_of_parts as kept, interrupts_noted(keep=how["keep_on_interrupt"]):
        parts = {} if kept is None else kept.parts()
        entries = {span: {key: values.tolist() for key, values in row.items()} for span, row in parts.items()}
        ways = []
        for first, one in ((0, assembly), (len(legs), held)):
            if one is not None:
                rows, own = averaged_stations(one, stations)[1], groups if first == 0 else []
                asked = one.state, partial(Stepper, one, rows, weights, plan, own), chosen
                if start == "fixed":
                    ways.append(_fixed(*asked, set(entries), how["workers"], first))
                else:
                    ways.append(_carried(*asked, legs, entries, first))
        if progress is not None:
            progress(len(entries), total)
        try:
            for span, row in chain(*ways):
                entries[span] = row
                if kept is not None:
                    kept.keep(span, row)
                raise_noted()
                if progress is not None:
                    progress(len(entries), total)
        except KeyboardInterrupt:
            if not how["keep_on_interrupt"]:
                raise
            interrupted = True
        result = step_dataset(assembly, chosen.tolist(), legs, names, entries)
        if held is not None:
            plain = step_dataset(held, chosen.tolist(), legs, names, entries, len(legs))
            for name in ("amplitude", "greatest_mean_deflection"):
                text = {"long_name": f"{plain[name].attrs['long_name']}, without balls"}
                result[f"{name}_without_balls"] = plain[name].assign_attrs(text)
        result.attrs |= _about(machine, assembly, question, entries.values(), mass_spread if groups else 0.0)
        result.attrs |= {
            "remarks": _coincidence(result),
            "outcome": "interrupted" if interrupted else "finished" if len(entries) == total else "ended early",
        }
        if place is not None and kept is not None and not interrupted:
            save_run(result, place)
            kept.remove()
    return result


def _about(
    machine: Machine, assembly: Assembly, question: dict[str, Any], rows: Iterable[Row], spread: float
) -> dict[str, Any]:
    """What a result says of its machine, of what was asked, and of the work."""
    rows = list(rows)
    return {
        "title": f"Stepped response of {machine.name}",
        **provenance(),
        "machine": question["machine"],
        "machine_name": machine.name,
        **critical_attributes(machine, assembly),
        "mass_spread": spread,
        **{name: question[name] for name in ("start", "dwell", "window")},
        "steps": sum(row["steps"] for row in rows),
        "long_steps": sum(row["long_steps"] for row in rows),
        "averaged_stations": question["stations"],
        "question": json.dumps(question),
    }


def _finished(path: Path, question: dict[str, Any]) -> SteppedResponse | None:
    """The result that the same call left."""
    if path.suffix != ".nc":
        raise QuestionError(f"store: given {str(path)!r}; give a result file that ends with .nc")
    if not path.exists():
        return None
    known = load_run(path)
    requested = json.loads(known.attrs.get("question", "null"))
    if not isinstance(requested, dict):
        raise QuestionError(f"store: {path} is not a stepped response; give another file")
    refuse_other_question(path, "stepped response", requested, json.loads(json.dumps(question)))
    return SteppedResponse.of(known)


def _coincidence(dataset: xr.Dataset) -> list[str]:
    """A sentence if balls stay in one place at speeds where that state is unstable."""
    if "parting_rate" not in dataset:
        return []
    driven = (dataset["parting_rate"].values > 0.0).reshape(-1, dataset.sizes["speed"]).any(axis=0)
    if not driven.any():
        return []
    speeds = dataset["speed"].values[driven]
    return [
        f"at {speeds.size} of {dataset.sizes['speed']} speeds, from {speeds[0]:.5g} to {speeds[-1]:.5g} rad/s, "
        f"balls lie in one place although this state is unstable there. {CURE}"
    ]


def _carried(
    begin: Floats,
    stepper_of: Callable[[], Stepper],
    speeds: Floats,
    legs: Sequence[str],
    found: dict[Place, Row],
    first: int,
) -> Iterator[tuple[Place, Row]]:
    stepper = stepper_of()
    order = [
        (leg, int(number))
        for leg, way in enumerate(legs, first)
        for number in (range(speeds.size) if way == "up" else range(speeds.size)[::-1])
    ]
    state = at_speed(begin, float(speeds[order[0][1]]))
    for place in order:
        if place not in found:
            yield place, stepper.hold(state, float(speeds[place[1]]))
        if found[place]["outcome"] != "finished":
            return  # there is no state to go on with
        state = np.array(found[place]["state"])


def _fixed(
    begin: Floats, stepper_of: Callable[[], Stepper], speeds: Floats, done: set[Place], workers: int | None, leg: int
) -> Iterator[tuple[Place, Row]]:
    own = local()

    def one(number: int) -> tuple[Place, Row]:
        if not hasattr(own, "stepper"):
            own.stepper = stepper_of()
        speed = float(speeds[number])
        return (leg, number), own.stepper.hold(at_speed(begin, speed), speed)

    pool = ThreadPoolExecutor(workers if workers is not None else os.cpu_count() or 1)
    try:
        waiting = [pool.submit(one, number) for number in range(speeds.size) if (leg, number) not in done]
        for ended in as_completed(waiting):
            yield ended.result()
    finally:
        pool.shutdown(cancel_futures=True)


# A stepped response as a labelled result, and the names of what balls do at a speed.


MOTIONS = ("at rest", "swinging", "stalled")
SWING = math.radians(1.0)  # a ball that moves less rests

QUANTITIES = {  # name of a row of an integration, over what it is besides direction and speed, meaning, unit
    "amplitude": ("amplitude", (), "greatest deflection, mean over the stations", "m"),
    "greatest_mean_deflection": ("mean", (), "greatest value in time of the mean deflection of the stations", "m"),
    "amplitude_change": (
        *("change", (), "relative change of the amplitude from the first to the second half of the window", "1"),
    ),
    "time_at_speed": ("hold", (), "time at the speed, window included", "s"),
    "greatest_deflection": ("greatest", ("station",), "greatest deflection of a station", "m"),
    "least_ball_angle_in_rotor": ("low", ("ball",), "least ball angle in the rotor", "rad"),
    "greatest_ball_angle_in_rotor": ("high", ("ball",), "greatest ball angle in the rotor", "rad"),
    "mean_ball_speed_in_rotor": ("ball_speed", ("ball",), "mean ball speed in the rotor", "rad/s"),
    "parting_rate": (
        *("parting", (), "rate at which balls that stay at one place would separate; nan where none do", "1/s"),
    ),
}


def step_dataset(
    assembly: Assembly,
    speeds: Sequence[float],
    legs: Sequence[str],
    names: Sequence[str],
    rows: dict[tuple[int, int], Row],
    first: int = 0,
) -> SteppedResponse:
    """Arrays over (direction, speed) of the legs from the ``first`` on; what was not reached is nan."""
    rows = {(leg - first, number): row for (leg, number), row in rows.items() if first <= leg < first + len(legs)}
    count, n, s = len(speeds), len(assembly.balls), len(names)

    def column(key: str, *shape: int) -> np.ndarray:
        values = np.full((len(legs), count, *shape), np.nan)
        for (leg, number), row in rows.items():
            if key in row:
                values[leg, number] = np.reshape(row[key], shape)
        return values

    # numbers of all speeds that were reached, over direction and speed
    # without balls there is nothing of them, and no rate where none stay together
    over, sizes = ("direction", "speed"), {"station": s, "ball": n}
    missing = {"parting"} - {key for row in rows.values() for key in row}
    numbers = {
        name: ((*over, *along), column(key, *map(sizes.__getitem__, along)), *about)
        for name, (key, along, *about) in QUANTITIES.items()
        if key not in missing and (n or "ball" not in along)
    }
    for k, where in enumerate(("along its zero mark", "a quarter turn ahead of its zero mark")):
        forward = column("forward", s, 2)[..., k], f"deflection that turns with the rotor, {where}", "m"
        numbers[f"synchronous_{'xy'[k]}"] = ((*over, "station"), *forward)
    # how each speed ended, and the axes
    outcomes = np.full((len(legs), count), "not reached", dtype=object)
    for place, row in rows.items():
        outcomes[place] = row["outcome"]
    axes = {
        "speed": ("speed", np.asarray(speeds, np.float64), "rotor speed", "rad/s"),
        "station": ("station", np.array(list(names), dtype=object), "station"),
        "direction": ("direction", np.array(list(legs), dtype=object), "direction through the speeds"),
    }
    result = SteppedResponse.of(labeled(numbers | {"outcome": (over, outcomes, "how the integration ended")}, axes))
    if n:
        swing = result["greatest_ball_angle_in_rotor"].values - result["least_ball_angle_in_rotor"].values
        lag = result["mean_ball_speed_in_rotor"].values
        # stalled is a ball whose mean speed hangs at a whirl, by the rule of kernels/measures/record_series.py
        hung = hanging(lag, np.asarray(speeds)[None, :, None], assembly.whirls)
        motion = np.where(np.isfinite(swing), np.where(hung, 2, np.where(swing > SWING, 1, 0)), -1)
        attrs = {"flag_values": list(range(len(MOTIONS))), "flag_meanings": list(MOTIONS)}
        result["ball_motion"] = ((*over, "ball"), motion, {"long_name": "what a ball does", **attrs})
        result["motion"] = (
            over,
            motion.max(axis=2),
            {"long_name": "the most severe motion class of all balls", **attrs},
        )
        result = result.assign_coords(
            ball=np.arange(1, n + 1), balancer=("ball", [ball.balancer + 1 for ball in assembly.balls])
        )
    return result if len(legs) > 1 else result.isel(direction=0)


# What a stepped response is asked: the machine at a speed, the stations, speeds and times that make sense.


def at_constant_speed(machine: Machine, speed: float) -> Machine:
    """The machine with a prescribed speed and with its unbalances after all schedules."""
    # the fields are set together: a prescribed speed and a start speed exclude each other
    begin = Start(**{key: getattr(machine.start, key) for key in machine.start.model_fields_set - {"speed"}})
    drive = PrescribedSpeed(profile=Constant(speed=speed))
    fields = {key: getattr(machine, key) for key in machine.model_fields_set} | {"drive": drive, "start": begin}
    machine = Machine(**fields)
    for number, unbalance in enumerate(machine.unbalances, start=1):
        if unbalance.schedule is not None:
            last = Schedule(time=(0.0,), factor=unbalance.schedule.factor[-1:])
            machine = with_value_at(machine, f"unbalances[{number}].schedule", last)
    return machine


def averaged_stations(assembly: Assembly, wanted: Sequence[str] | None) -> tuple[list[str], list[Matrix], Floats]:
    """Names and rows of all stations, and their weights in the mean."""
    named: dict[str, Matrix] = dict(assembly.stations)
    if not named:
        size = 2 + (assembly.state.size - 6 - 2 * len(assembly.balls)) // 2
        named = {assembly.reference or "rotor": np.eye(2, size)}
    if isinstance(wanted, str):
        wanted = [wanted]
    chosen = list(named) if wanted is None else list(wanted)
    unknown = [name for name in chosen if name not in named]
    if unknown or not chosen or len(set(chosen)) < len(chosen):
        known = ", ".join(map(repr, named))
        raise QuestionError(f"stations: given {chosen!r}; name each once, there is {known}")
    weights = np.array([(name in chosen) / len(chosen) for name in named])
    return list(named), list(named.values()), weights


def checked_speeds(speeds: Sequence[float] | np.ndarray) -> Floats:
    """Speeds that ascend from above zero."""
    chosen = np.array(speeds, np.float64)
    if chosen.ndim != 1 or chosen.size == 0 or not np.all(np.isfinite(chosen)):
        raise QuestionError("speeds: give a list of finite speeds in rad/s")
    if chosen[0] <= 0.0 or np.any(np.diff(chosen) <= 0.0):
        raise QuestionError(
            f"speeds: given {chosen[0]:g} to {chosen[-1]:g} rad/s; must ascend from above zero; "
            "direction='down' runs through them the other way"
        )
    return chosen


def checked_plan(
    dwell: float,
    window: float,
    acceleration: float | None,
    settle: float | None,
    longest: float | None,
    how: ManyRunOptions,
) -> Plan:
    """Times that make sense."""
    for name, value, unit in (
        ("dwell", dwell, "s"), ("window", window, "s"), ("acceleration", acceleration, "rad/s^2"),
        ("settle", settle, "relative"), ("longest", longest, "s"),
    ):  # fmt: skip
        needless = value is None or (name == "dwell" and value == 0.0)
        if not needless and not (math.isfinite(float(value or 0.0)) and float(value or 0.0) > 0.0):
            raise QuestionError(f"{name}: given {value!r}; must be greater than zero ({unit})")
    if (settle is None) != (longest is None):
        raise QuestionError("settle, longest: give both or none; 'longest' ends a motion that never settles")
    if longest is not None and longest < dwell + window:
        raise QuestionError(f"longest: given {longest:g} s; must be at least dwell and window, {dwell + window:g} s")
    numbers = how["tolerance"], how["max_steps"], how["method"]
    return Plan(dwell, window, rate(acceleration), settle, longest or 0.0, *numbers)


# One machine held at one speed after the other.


LONGEST = 1e9  # s that one speed can be held
NEAR = math.radians(30.0)  # a ball that moves less stays where it is in the rotor, apart from a vibration

Row = dict[str, Any]  # what was seen at one speed: plain numbers and lists, so that it goes into a text exactly


@dataclass(frozen=True)
class Plan:
    """How long a speed is held and measured; see :func:`autobalancer.stepped_response`."""

    dwell: float
    window: float
    acceleration: float  # rad/s^2, infinite for a jump
    settle: float | None
    longest: float
    tolerance: float
    max_steps: int
    method: str = "auto"


class Stepper:
    """Work arrays of one thread."""

    def __init__(
        self, assembly: Assembly, rows: Sequence[Matrix], weights: Floats, plan: Plan, groups: Sequence[list[int]]
    ) -> None:
        self.balls, self.groups, self.named = assembly.balls, groups, weights.size
        if groups:  # whether balls in one place stay there depends on the deflection of their race
            rows = [*rows, *places(assembly)]
            weights = np.append(weights, np.zeros(len(rows) - weights.size))
        self.system = own(assembly.system)
        self.stepper, self.plan = stepper_for(assembly, LONGEST, plan.tolerance, plan.method), plan
        self.assembly, self.memory, self.modes = assembly, self.stepper.memory, dict[float, LongSteps]()
        self.quiet = record_for((), (), assembly, 1.0)
        # an event that never comes: for its sake the stepper keeps the dense output of all components
        self.dense = self.quiet._replace(
            event_kinds=np.array([SUM]),
            event_firsts=np.array([SPEED]),
            event_seconds=np.array([-1]),
            event_levels=np.array([1e300]),
            event_directions=np.zeros(1, np.int64),
            event_terminal=np.zeros(1, np.int64),
            event_seen=np.zeros(1, np.int64),
            event_sides=np.zeros(1),
            event_places=np.zeros(1),
        )
        s, n, size = weights.size, len(assembly.balls), rows[0].shape[1]
        self.window = Window(
            rows=np.ascontiguousarray(np.concatenate(rows), np.float64),
            weights=weights,
            greatest=np.zeros((2, s + 1)),
            low=np.zeros((2, n)),
            high=np.zeros((2, n)),
            ends=np.zeros((2, n)),
            forward=np.zeros((s, 2)),
            spent=np.zeros(3),
            place=np.zeros(size),
            move=np.zeros(size),
            points=np.zeros((s, 2)),
            value=np.zeros(s + 1),
            growth=np.zeros(s + 1),
            before=np.zeros(s + 1),
        )

    def hold(self, state: Floats, speed: float) -> Row:
        """Bring a state to a speed and measure there; without balls and stations lists are empty."""
        m, w, plan = self.memory, self.window, self.plan
        m.state[:] = state
        settle = -1.0 if plan.settle is None else plan.settle
        numbers = [speed, plan.acceleration, plan.dwell, plan.window, settle, plan.longest, plan.max_steps]
        nodes, watch, powers, long, unknowns = self._long_steps_at(speed)
        status = hold(
            *self.stepper.moving, nodes, watch, self.system, (self.stepper.pair, powers), (self.quiet, self.dense), (m, long),
            unknowns, w, np.array(numbers, np.float64),
        )  # fmt: skip
        end, steps = float(m.clock[TIME]), int(m.counts[ACCEPTED])
        taken = int(unknowns.tallies[LONG_STEPS])
        row: Row = {"speed": float(speed), "steps": steps, "long_steps": taken, "state": m.state.tolist()}
        if status != FINISHED:
            planned = float(w.spent[0]) + plan.dwell + plan.window
            ended = outcome(status, end, planned, interrupted=False, steps=steps)
            return row | {"outcome": ended.name, "text": ended.text}
        each = w.greatest[:, : self.named].max(axis=0)
        return (
            row
            | self._parting(m.state, speed)
            | {
                "outcome": "finished",
                "hold": end - float(w.spent[0]),
                "change": float(w.spent[1]),
                "greatest": each.tolist(),
                "amplitude": float(each @ w.weights[: self.named]),
                "mean": float(w.greatest[:, -1].max()),
                "low": w.low.min(axis=0).tolist(),
                "high": w.high.max(axis=0).tolist(),
                "ball_speed": ((w.ends[1] - w.ends[0]) / plan.window).tolist(),
                "forward": w.forward[: self.named].tolist(),
            }
        )

    def _long_steps_at(self, speed: float) -> LongSteps:
        """Long steps at a speed: they depend on no other speed that is asked for, and speeds that are near share them."""
        own, near = self.stepper.long, 0.0
        if own is not None and own.amplitudes.bases.size > 0:
            stride = 2.0 ** (math.floor(math.log2(speed)) - 4)
            near = stride * round(speed / stride)
        if near not in self.modes:
            result = own if near == 0.0 else long_steps(self.assembly, self.memory, near)
            self.modes[near] = result or _no_long_steps(self.memory)
        return self.modes[near]

    def _parting(self, state: Floats, speed: float) -> Row:
        """How fast balls would part that stay in one place of the rotor, the fastest pair."""
        n, w, worst = len(self.balls), self.window, -math.inf
        for one, _ in pairs_together(list(self.groups), state[BALLS : BALLS + n]):
            low, high = w.low[:, one].min(), w.high[:, one].max()
            if high - low > NEAR:
                continue
            ball = self.balls[one]
            center = complex(*w.forward[self.named + ball.balancer]) + ball.eccentricity
            outward = (center * cmath.exp(-0.5j * (low + high))).real
            worst = max(worst, parting_rate(ball, speed, outward))
        return {"parting": worst} if math.isfinite(worst) else {}


def _no_long_steps(memory: Memory) -> LongSteps:
    """In place of those that a machine cannot take: no modes, so that all steps are those of the pair."""
    nothing = amplitudes(np.zeros(0), np.zeros((0, 0)), np.zeros(0, np.int64), 0, np.zeros(0), 0, turning=False)
    return LongSteps(planar_nodes, contacts_in_steps, by_powers(), memory, nothing)


def places(assembly: Assembly) -> list[Matrix]:
    """Rows of the deflection of each balancer; a planar rotor has one place."""
    if assembly.places.shape[0]:
        return list(assembly.places)
    return [np.eye(2)] * (1 + max((ball.balancer for ball in assembly.balls), default=0))


def at_speed(state: Floats, speed: float) -> Floats:
    """A start state with the rotor at a speed."""
    state = state.copy()
    state[SPEED] = speed
    return state


def rate(acceleration: float | None) -> float:
    """The rate of a ramp; a jump is infinitely fast."""
    return math.inf if acceleration is None else float(acceleration)
