"""One run of one machine."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Literal, Unpack

import numpy as np
import xarray as xr

from autobalancer.assembly.drive_train import unbalance_jumps
from autobalancer.assembly.guided_balls import forces_in
from autobalancer.assembly.places import MOST, Touch, assemble_locked, meetings_of, places_of, with_touches
from autobalancer.assembly.reduced_rotor import top_speed
from autobalancer.assembly.resolved import friction_at_fault
from autobalancer.assembly.system import MASS_SPREAD, Assembly, assemble, equal_groups
from autobalancer.catalog.resolve import Ball, planar_rotor, resolve
from autobalancer.errors import DurationWarning, QuestionError, one_of, warn
from autobalancer.files.machine_file import balls_in_races, machine_text
from autobalancer.kernels.integrators.integrator_state import ACCEPTED, EVENTS_SEEN, NEXT_BIN, TIME, Memory
from autobalancer.kernels.integrators.recording import Record
from autobalancer.kernels.integrators.runge_kutta import EVENT, FINISHED, NOT_FINITE, RUNNING, STEP_TOO_SMALL
from autobalancer.kernels.measures.row import held_at_critical_speed
from autobalancer.kernels.records import IMPACT, NONE
from autobalancer.kernels.system import Floats, Matrix, System
from autobalancer.laws.drag_coefficient import range_record, stokes_record
from autobalancer.machine import Machine, PlanarRotor
from autobalancer.progress import ENOUGH, Progress, interrupts_noted, raise_noted, returned, shows_progress
from autobalancer.results.labels import label
from autobalancer.results.run_arrays import HELD_AT, VARIABLES, Impacts, bins_of
from autobalancer.results.time_series import plain, static_load
from autobalancer.simulation import ONE_RUN, RunOptions, run_duration, run_options
from autobalancer.simulation.fluid_lag import KnownLags, fluid_lags
from autobalancer.simulation.record import (
    Envelope,
    Event,
    LastRevolutions,
    Samples,
    Sampling,
    record_for,
    turns_complete,
)
from autobalancer.simulation.remarks import Ended, critical_attributes, remarks
from autobalancer.simulation.saved import run_dataset
from autobalancer.simulation.steppers import Stepper, stepper_for
from autobalancer.units import shortened

DEFAULT_SAVE = (Samples(), Envelope(), LastRevolutions())
CHUNK = 20_000  # steps between two looks at the progress bar and the keyboard


@shows_progress
def simulate_races(
    machine: Machine | str | Path,
    *,
    duration: float | str | None = None,
    save: Sampling | Sequence[Sampling] = DEFAULT_SAVE,
    events: Sequence[Event] = (),
    frame: Literal["auto", "rotor", "space"] = "auto",
    hold_balls: bool = False,
    seed: int = 0,
    mass_spread: float = MASS_SPREAD,
    progress: Progress | None = None,
    keep_on_interrupt: bool = False,
    **options: Unpack[RunOptions],
) -> xr.Dataset:
    """Run a machine in time.

    Parameters
    ----------
    machine
        A machine or the path of a machine file.
    duration
        Seconds, or a text such as ``"20 s"``; by default the ``run.duration`` of the machine.
    save
        What to keep: :class:`Samples`, :class:`SampleTimes`, :class:`Envelope`, :class:`LastRevolutions`
        or several of them. By default samples, an envelope and, unless an event may end the run, the last revolutions,
        from which its measures are taken.
    events
        Passages to be recorded, or to end the run.
    frame
        Axes in which the equations are integrated. ``auto`` rotates with the rotor if the machine is isotropic and
        has no gravity in its plane; results are the same.
    hold_balls
        Run the same machine without balancing: its balls are spread evenly over their races and held, so that their
        mass stays and critical speeds are the same. The result has no balls.
    seed
        For the start positions of balls that have none in the machine.
    mass_spread
        Equal balls that pass through each other differ in mass by this share, heaviest less lightest, in an order drawn
        from the seed: identical balls at one place would never separate, even where that state is unstable. Real balls differ
        by 1e-4 and more. 0 leaves them equal.
    progress
        Called with (time, duration) a few times a second.
    keep_on_interrupt
        If true, Ctrl-C ends the run with the outcome ``interrupted`` and returns what was computed.
    **options
        ``tolerance`` (1e-8), ``method`` and ``max_steps``, see :class:`~autobalancer.simulation.RunOptions`.

    Returns
    -------
    xarray.Dataset
        See the page on results; ``attrs["outcome"]`` says how the run ended.

    Raises
    ------
    MachineError
        If the machine cannot be run.
    QuestionError
        If an argument is not possible: no duration, a tolerance outside [1e-13, 1e-2], sample times out of order.

    Warns
    -----
    DurationWarning
        If the run will take more than a minute because the machine is stiff; the cause is named.
    """
    machine = balls_in_races(machine)
    end = run_duration(machine, duration)
    how = run_options("simulate", options, ONE_RUN)
    tolerance, method, max_steps = how["tolerance"], how["method"], how["max_steps"]
    one_of("frame", frame, "auto", "rotor", "space")
    known = KnownLags({}, {}) if hold_balls else fluid_lags(machine, end, seed=seed, max_steps=max_steps)
    rotating = None if frame == "auto" else frame == "rotor"

    def assembled() -> tuple[Assembly, Noted]:
        if hold_balls:
            return assemble_locked(machine, rotating), Noted(())
        free = assemble(machine, seed=seed, rotating=rotating, lags=known.lags, mass_spread=mass_spread)
        noting, touches = with_touches(machine, free)
        return noting, Noted(touches)

    assembly, noted = assembled()
    places = places_of(machine, assembly)
    if frame == "rotor" and not assembly.system.rotating:
        raise QuestionError("frame: 'rotor' needs isotropic supports; leave it at 'auto' or take 'space'")
    wishes = _wishes(save, events)
    jumps = unbalance_jumps(machine, end)
    record = record_for(wishes, events, assembly, end, jumps)
    stepper = stepper_for(assembly, end, tolerance, method)
    stepper.make_ready()
    slow = slow_because(machine, assembly, end, long_steps=stepper.long is not None)
    if slow:
        warn(slow, DurationWarning)
    state = stepper.memory
    going = end, max_steps, progress, keep_on_interrupt, _own_code(machine)
    with interrupts_noted(keep=keep_on_interrupt):
        status, interrupted = _drive(assembly, noted, stepper, record, *going)
        spent = status == RUNNING  # once more would take as long again
        if not (interrupted or spent or save is DEFAULT_SAVE or turns_complete(record, state, assembly)):
            # the rotor slowed down or the run ended early: once more, and now keep every revolution until the next
            assembly, noted = assembled()
            record = record_for(wishes, events, assembly, end, jumps)._replace(turn_count=math.inf)
            stepper = stepper_for(assembly, end, tolerance, method)
            state = stepper.memory
            status, interrupted = _drive(assembly, noted, stepper, record, *going)
        names = [event.name for event in events]
        ended = _ended(machine, assembly, names, record, state, status, end, interrupted)
        run = run_dataset(
            assembly,
            places,
            record,
            state,
            names,
            {
                "machine": machine_text(machine),
                "machine_name": machine.name,
                "axis": machine.axis,
                "static_load": static_load(machine),
                "seed": seed,
                "mass_spread": mass_spread if equal_groups(machine, resolve(machine)) else 0.0,
                **critical_attributes(machine, assembly),
                **({"unbalance_jumps": list(jumps)} if jumps else {}),
                "reference_station": assembly.reference or "rotor",
                **reduction_attributes(assembly),
                **known.record,
                **({"balls_held": 1} if hold_balls else {}),
                "outcome": ended.name,
                "outcome_text": ended.text,
                "duration": end,
                "end_time": float(state.clock[TIME]),
                "tolerance": tolerance,
                "frame_of_integration": "rotor" if assembly.system.rotating else "space",
                **stepper.attributes(),
            },
        )
        run = with_impacts(run, noted)
        run.attrs |= _drag_range_attributes(assembly, run, record, state)
        if run.sizes.get("bin" if "envelope_speed" in run else "time"):
            course = bins_of(run)
            numbers = map(plain, (course.end, course.speed, assembly.whirls))
            held = held_at_critical_speed(assembly.system, *numbers, float(state.clock[TIME]))
            run.attrs |= {HELD_AT: held} if math.isfinite(held) else {}
        return run.assign_attrs(remarks=remarks(Ended(machine, end, assembly, places, record, state, run)))


def _drag_range_attributes(assembly: Assembly, run: xr.Dataset, record: Record, state: Memory) -> dict[str, Any]:
    """For the result: law, greatest Reynolds number and a warning where the law was left; empty where beta is given.

    The same of the slipstream where there is one. Velocities are those saved with the run, along the race and relative to its
    fluid, which may lag.
    """
    attributes: dict[str, Any] = {}
    greatest: dict[Any, float] = {}
    in_line, stokes = -1.0, -1.0
    for number, ball in enumerate(assembly.balls):
        if ball.drag_curve is None and not (ball.slipstream or ball.stokes):
            continue
        for name, (times, states) in _saved(record, state).items():
            if name in run:
                rates = run[name].isel(ball=number).values
                speeds = np.abs(rates + _saved_lag(assembly, number, states[: rates.size], times[: rates.size]))
                if speeds.size:
                    velocity = float(np.nanmax(speeds)) * ball.orbit_radius
                    if ball.slipstream:
                        in_line = max(in_line, velocity * ball.diameter / ball.fluid_viscosity)
                    if ball.stokes:
                        stokes = max(stokes, velocity * ball.diameter / ball.fluid_viscosity)
                    if ball.drag_curve is not None:
                        greatest[ball.drag_curve] = max(greatest.get(ball.drag_curve, 0.0), velocity)
    for curve, velocity in greatest.items():
        one = curve.range_record(velocity)
        if not attributes or one["drag_reynolds"] > attributes["drag_reynolds"]:
            attributes = one
    if not attributes and stokes >= 0.0:
        attributes = stokes_record(stokes)
    return attributes | (range_record(in_line) if in_line >= 0.0 else {})


def _saved_lag(assembly: Assembly, number: int, states: Matrix, times: Floats) -> Floats:
    """The lag w - W_f, rad/s, at each of ``states`` (times, n) for the ball of this number; 0 where no fluid lags."""
    system, lag = assembly.system, np.zeros(times.size)
    ball, fluid = (system.free_balls if assembly.resolved else system.balls)[number], system.fluid
    lag += states[:, fluid.modes.state[ball.first_mode : ball.first_mode + ball.modes]].sum(axis=1)
    if ball.lag_table != NONE:
        table = fluid.tables[ball.lag_table]
        known = table.start + table.step * np.arange(table.count)
        lag += np.interp(times, known, fluid.points.value[table.first : table.first + table.count])
    return lag


def _saved(record: Record, state: Memory) -> dict[str, tuple[Floats, Matrix]]:
    """Times and states behind the ball speeds of a run; a bin that the end of the run cut short has the last state."""
    bins = int(state.counts[NEXT_BIN])
    ends, states = record.bin_edges[1 : bins + 1], record.bin_states[:bins]
    return {
        "ball_speed_in_rotor": (record.sample_times, record.samples),
        "envelope_ball_speed_in_rotor": (np.append(ends, state.clock[TIME]), np.vstack([states, state.state])),
    }


def _ended(
    machine: Machine,
    assembly: Assembly,
    names: list[str],
    record: Record,
    state: Memory,
    status: int,
    end: float,
    interrupted: bool,
) -> Outcome:
    """How a run ended: by which of the events with these ``names``, or by whose fault."""
    seen = range(record.event_states.shape[0])[: int(state.counts[EVENTS_SEEN])]
    return outcome(
        status,
        state.clock[TIME],
        end,
        interrupted=interrupted,
        steps=int(state.counts[ACCEPTED]),
        event=names[int(record.event_states[seen[-1], 0])] if seen else "",
        fault=_at_fault(machine, assembly.balls, assembly.system),
    )


def _at_fault(machine: Machine, balls: tuple[Ball, ...], system: System) -> str:
    """Which force or friction law was not a number during a run, and where; empty if none was."""
    wrong = system.forces[system.forces.wrong != 0]
    if not len(wrong):
        return friction_at_fault(machine, balls, system)
    row, first = wrong[0], 0
    for path, force, _ in forces_in(machine, balls):
        if row.first == first:
            return (
                f"the force {force.word()!r} ({path}) was not a number on ball {row.ball + 1} at "
                f"x = {row.wrong_x:.6g} m, y = {row.wrong_y:.6g} m in the race, at a velocity of {row.wrong_vx:.4g} and "
                f"{row.wrong_vy:.4g} m/s and a rotor speed of {row.wrong_speed:.6g} rad/s"
            )
        first += len(force.numbers()) or 1
    return friction_at_fault(machine, balls, system)


def _wishes(save: Sampling | Sequence[Sampling], events: Sequence[Event]) -> list[Sampling]:
    """What is kept of a run, as a list; unasked no last revolutions where an event may end it at any time, as they cost much."""
    if save is DEFAULT_SAVE and any(event.ends_run for event in events):
        return [wish for wish in DEFAULT_SAVE if not isinstance(wish, LastRevolutions)]
    wishes = [save] if isinstance(save, Sampling) else list(save) if isinstance(save, Iterable) else [save]
    if not all(isinstance(wish, Sampling) for wish in wishes):
        raise QuestionError(
            f"save: given {shortened(save)}; give Samples(), SampleTimes(), Envelope(), LastRevolutions() or several"
        )
    return wishes


def reduction_attributes(assembly: Assembly) -> dict[str, float | int]:
    """How many modes a run keeps of a general rotor, and what they leave out."""
    small = assembly.reduction
    if small is None:
        return {}
    return {"modes_kept": small.kept, "modes_in_all": small.total, "reduction_error": small.error}


def _drive(
    assembly: Assembly,
    noted: Noted,
    stepper: Stepper,
    record: Record,
    end: float,
    max_steps: int,
    progress: Progress | None,
    keep: bool,
    own: str,
) -> tuple[int, bool]:
    """Advance in chunks until the end, an event, a failure, the budget or Ctrl-C."""
    status, state = RUNNING, stepper.memory
    try:
        while status == RUNNING and state.counts[ACCEPTED] < max_steps:
            raise_noted()
            budget = min(CHUNK, max_steps - int(state.counts[ACCEPTED]))
            advance = partial(stepper.advance, assembly.system, record, budget)
            status = returned(advance, own, word=ENOUGH, limit=math.inf) if own else advance()
            noted.take(assembly.system)
            if progress is not None:
                progress(float(state.clock[TIME]), end)
    except KeyboardInterrupt:
        if not keep:
            raise
        noted.take(assembly.system)
        return status, status != FINISHED
    return status, False


def _own_code(machine: Machine) -> str:
    """Forces and friction laws of somebody's own that are called within a chunk of steps, in words; empty without any."""
    races = [race for balancer in machine.balancers for race in balancer.races]
    laws = [race.resolved.friction_law for race in races if race.resolved is not None]
    laws += [race.friction.rolling_law for race in races if race.friction is not None]
    leaves = [*(force for race in races for force in race.forces), *(law for law in laws if law is not None)]
    own = {leaf.word(): leaf for leaf in leaves if not type(leaf).__module__.startswith("autobalancer.")}
    return f"a run with {' and '.join(f'the {leaf.one} {word!r}' for word, leaf in own.items())}" if own else ""


# How many steps a run will take, looked at before it begins: explicit steps cannot be much longer than its fastest
# decay.
#
# Long steps solve for drag, damping and vibration exactly, so that only gravity and unequal supports can make them
# many.


REACH = 5.0  # step times rate that an explicit pair of order eight bears
TURN = 0.3  # rad of rotor angle in a step, where gravity or unequal supports act once a revolution
PACE = 4e5  # steps in a second, measured with a few balls on a usual computer
LONG = 60.0  # s of computing from which on it is said


def slow_because(machine: Machine, assembly: Assembly, duration: float, *, long_steps: bool = False) -> str:
    """A sentence about a run of ``duration`` (s) that will take long, with the cause; empty if it will not.

    An estimate from drag at rest, damping and stiffness of planar rotors, linear walls and the greatest speed.
    """
    rates = [*_turns(machine, assembly)] if long_steps else [*_decays(machine, assembly), *_turns(machine, assembly)]
    steps, cause = max(((duration * rate, cause) for rate, cause in rates), default=(0.0, ""))
    if steps / PACE < LONG:
        return ""
    return (
        f"this run is stiff: {cause}, so {duration:.3g} s take about {steps:.1g} steps, {_spoken(steps / PACE)} on a usual "
        "computer. If that value is meant, shorten the run; a limit of steps ends it with the outcome 'budget spent'"
    )


def _decays(machine: Machine, assembly: Assembly) -> Iterator[tuple[float, str]]:
    """Explicit steps in a second of the run, and the decay or vibration that asks for them."""
    for number, ball in enumerate(assembly.balls, 1):
        if ball.drag > 0.0:
            rate = ball.drag / ball.inertia
            yield rate / REACH, f"drag brakes ball {number} with a time constant of {1.0 / rate:.2g} s"
        resolved = machine.balancers[ball.balancer].races[ball.race].resolved
        if resolved is not None and resolved.stiffness is not None:
            rate = math.sqrt(resolved.stiffness / ball.mass)
            yield rate / REACH, f"ball {number} bounces on its wall within {1.0 / rate:.2g} s"
    if isinstance(machine.rotor, PlanarRotor):
        rotor = planar_rotor(machine)
        for stiffness, damping in zip(rotor.stiffness_xy, rotor.damping_xy, strict=True):
            rate = damping / machine.rotor.mass
            if rate > 0.0:
                yield rate / REACH, f"damping brakes the rotor with a time constant of {1.0 / rate:.2g} s"
            rate = math.sqrt(stiffness / machine.rotor.mass)
            yield rate / REACH, f"the rotor vibrates at {rate:.2g} rad/s"


def _turns(machine: Machine, assembly: Assembly) -> Iterator[tuple[float, str]]:
    """Steps in a second of the run where they have to follow each turn."""
    speed = top_speed(machine)
    if speed and not assembly.system.rotating:
        yield speed / TURN, f"the rotor turns at {speed:.3g} rad/s"


def _spoken(seconds: float) -> str:
    for unit, length in (("years", 3.156e7), ("days", 86400.0), ("hours", 3600.0)):
        if seconds >= 2.0 * length:
            return f"{seconds / length:.2g} {unit}"
    return f"{seconds / 60.0:.2g} minutes"


# Impacts that a run notes as it goes.


class Noted:
    """Takes what the equations have noted, between two calls of the stepper, and says what it means."""

    def __init__(self, touches: tuple[Touch, ...]) -> None:
        self._touches = touches
        self._kept: list[Any] = []
        self.count = 0  # of all
        self._size = 0

    def take(self, system: System) -> None:
        """Empty the room in ``system``."""
        if not self._touches:
            return
        seen = int(system.impact_count[0])
        keep = min(seen, system.impacts.size, MOST - self._size)
        if keep > 0:
            self._kept.append(system.impacts[:keep].copy())
        self.count, self._size = self.count + seen, self._size + keep
        system.impact_count[0] = 0

    @property
    def lost(self) -> int:
        """Impacts that were counted, but not kept."""
        return self.count - self._size

    def found(self) -> Impacts | None:
        """All that were kept; None where nothing can touch."""
        if not self._touches:
            return None
        rows = np.concatenate([IMPACT.rows(0), *self._kept])
        from autobalancer.kernels.measures.record_series import losses_and_impulses

        touch, meant = np.array(rows["touch"], np.int64), np.zeros((2, rows.size))
        losses_and_impulses(rows, *meetings_of(self._touches), meant)
        partners = np.array([(touch.one + 1, touch.other + 1) for touch in self._touches])  # 0: partition, -1: wall
        return Impacts(
            time=np.array(rows["time"], np.float64),
            speed=np.array(rows["speed"], np.float64),
            lost=meant[0],
            impulse=meant[1],
            ball=partners[touch, 0],
            partner=partners[touch, 1],
        )


def with_impacts(run: xr.Dataset, noted: Noted) -> xr.Dataset:
    """The run with the impacts that were noted, over the dimension ``impact``."""
    result = noted.found()
    if result is None:
        return run
    variables = {kept: ("impact", getattr(result, name)) for kept, name in VARIABLES.items()}
    run = label(run.assign(variables).assign_coords(impact_time=("impact", result.time)))
    return run.assign_attrs(impacts_not_kept=noted.lost) if noted.lost else run


# How a run ended: a value with a sentence and a cure, not an exception.


@dataclass(frozen=True)
class Outcome:
    """``name`` is one of finished, event, step too small, not finite, budget spent, interrupted."""

    name: str
    text: str


def outcome(
    status: int, time: float, duration: float, *, interrupted: bool, steps: int, event: str = "", fault: str = ""
) -> Outcome:
    """The outcome of a run that stopped at ``time``; ``fault`` names a force or friction law that was not a number."""
    if interrupted:
        return Outcome("interrupted", f"interrupted at {time:.6g} s of {duration:.6g} s; what was computed is kept")
    if status == FINISHED:
        return Outcome("finished", f"reached {duration:.6g} s")
    if status == EVENT:
        return Outcome("event", f"ended at {time:.6g} s by: {event}")
    if fault and status in (STEP_TOO_SMALL, NOT_FINITE):
        return Outcome("not finite", f"at {time:.6g} s {fault}")
    if status == STEP_TOO_SMALL:
        return Outcome(
            "step too small",
            f"at {time:.6g} s the step size fell below rounding; "
            "the tolerance may be too tight or a value far too large",
        )
    if status == NOT_FINITE:
        return Outcome("not finite", f"at {time:.6g} s the motion grew without limit; check masses, drag and drive")
    return Outcome(
        "budget spent",
        f"{steps} steps were taken up to {time:.6g} s; "
        "raise max_steps or shorten the run; steps much shorter than a revolution mean a stiff machine: look for a drag "
        "or a stiffness that is far too large",
    )
