"""Stepped frequency response: hold a speed, let transients die, measure, go to the next speed."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from threading import local
from typing import Literal

import numpy as np
import xarray as xr

from autobalancer.assembly.mass_spread import MASS_SPREAD
from autobalancer.assembly.system import Assembly
from autobalancer.errors import QuestionError
from autobalancer.files.given import balls_in_races
from autobalancer.files.machine_file import machine_text
from autobalancer.kernels.system import Floats, Matrix
from autobalancer.machine import Machine
from autobalancer.patience import shows_progress
from autobalancer.results.answers.stepped import SteppedResponse
from autobalancer.results.provenance import provenance
from autobalancer.simulation.prepare import prepare
from autobalancer.simulation.remarks.coincidence import CURE, free_groups
from autobalancer.simulation.remarks.critical_text import critical_attributes
from autobalancer.studies.step_dataset import step_dataset
from autobalancer.studies.step_question import at_constant_speed, averaged_stations, checked_plan, checked_speeds
from autobalancer.studies.step_store import StepStore
from autobalancer.studies.stepping import Plan, Row, Stepper, at_speed
from autobalancer.units import argument, list_argument, optional_argument

Place = tuple[int, int]  # leg, number of the speed


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
    tolerance: float = 1e-7,
    seed: int = 0,
    mass_spread: float = MASS_SPREAD,
    max_steps: int = 10_000_000,
    workers: int | None = None,
    store: str | Path | None = None,
    progress: Callable[[int, int], None] | None = None,
    keep_on_interrupt: bool = False,
) -> SteppedResponse:
    """Measure a machine at one speed after the other, as on a test stand (Rodrigues et al. 2011, section 5).

    The drive of the machine is replaced by the prescribed speed; unbalances are those after all schedules.

    Parameters
    ----------
    machine
        A machine or the path of a machine file.
    speeds
        Rotor speeds, rad/s, ascending from above zero.
    dwell, window
        Time at a speed before the measurement, and length of the measurement, s.
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
        Measure again until the amplitudes of both halves of the window differ by less than this share, or until
        ``longest`` (s at one speed) is over; by default every speed is measured once.
    tolerance
        Local error per step, as for :func:`autobalancer.simulate`.
    seed
        For the start positions of balls that have none.
    mass_spread
        Relative difference of the masses of equal balls that pass through each other, as for
        :func:`autobalancer.simulate`; 0 leaves them equal; equal balls at one place never separate.
    max_steps
        Number of steps at one speed after which it is given up.
    workers
        Threads for ``fixed``; the result does not depend on it.
    store
        Result file. Every finished speed is written at once into a journal beside it; a later call with the same
        arguments continues from there, with results identical to the last bit.
    progress
        Called with (speeds done, speeds in all).
    keep_on_interrupt
        If true, Ctrl-C ends the study and returns what was measured, ``attrs["outcome"]`` is then ``interrupted``.

    Returns
    -------
    xarray.Dataset
        Over ``speed``, with ``direction`` before it for ``both``: ``amplitude`` (mean over the stations of the greatest
        deflection, their equation 3), ``greatest_mean_deflection`` (greatest value in time of the mean deflection, which
        their simulated curves show), ``greatest_deflection`` and ``synchronous_x``, ``synchronous_y`` of every
        ``station``, least and greatest ball angle, mean ball speed, ``ball_motion`` and ``motion``, ``amplitude_change``
        within the window, ``time_at_speed``, ``outcome``; where balls stay at one place ``parting_rate``, above zero if that
        state is unstable, and then ``attrs["coincidence_text"]``. ``attrs`` have the number of ``steps``, and how many of
        these were ``long_steps``.

    Raises
    ------
    QuestionError
        For speeds out of order, times not above zero, an unknown station, a store with the result of another study.
    MachineError
        If a table of the machine does not cover the speeds.
    """
    settle = optional_argument("settle", settle, "")
    speeds = list_argument("speeds", speeds, "rad/s")
    dwell = argument("dwell", dwell, "s")
    window = argument("window", window, "s")
    acceleration = optional_argument("acceleration", acceleration, "rad/s^2")
    longest = optional_argument("longest", longest, "s")
    machine = balls_in_races(machine)
    chosen = checked_speeds(speeds)
    plan = checked_plan(dwell, window, acceleration, settle, longest, tolerance, max_steps)
    if direction not in ("up", "down", "both") or start not in ("carried", "fixed"):
        raise QuestionError(
            f"direction, start: given {direction!r}, {start!r}; must be up, down or both; carried or fixed"
        )
    if start == "fixed" and (direction != "up" or acceleration is not None):
        raise QuestionError("start: 'fixed' begins every speed anew; leave out direction and acceleration")
    assembly = prepare(at_constant_speed(machine, float(chosen[-1])), None, seed=seed, mass_spread=mass_spread)
    groups = free_groups(machine)
    names, rows, weights = averaged_stations(assembly, stations)
    legs = ["up", "down"] if direction == "both" else [direction]
    question = {
        "machine": machine_text(machine), "speeds": chosen.tolist(), "dwell": dwell, "window": window,
        "direction": direction, "start": start, "acceleration": acceleration, "settle": settle, "longest": longest,
        "stations": [name for name, weight in zip(names, weights, strict=True) if weight > 0.0], "tolerance": tolerance,
        "seed": seed, "mass_spread": mass_spread, "max_steps": max_steps, "source": provenance()["source"],
    }  # fmt: skip
    kept = None if store is None else StepStore(store, question)
    if kept is not None and kept.finished is not None:
        return SteppedResponse.of(kept.finished)
    found: dict[Place, Row] = dict(kept.rows) if kept is not None else {}
    total, interrupted = len(legs) * chosen.size, False
    if start == "fixed":
        ways = _fixed(assembly, rows, weights, plan, groups, chosen, set(found), workers)
    else:
        ways = _carried(assembly, rows, weights, plan, groups, chosen, legs, found)
    if progress is not None:
        progress(len(found), total)
    try:
        for place, row in ways:
            found[place] = row
            if kept is not None:
                kept.append(*place, row)
            if progress is not None:
                progress(len(found), total)
    except KeyboardInterrupt:
        if not keep_on_interrupt:
            raise
        interrupted = True
    result = step_dataset(assembly, chosen.tolist(), legs, names, found)
    result.attrs = {
        "title": f"Stepped response of {machine.name}",
        **provenance(),
        "machine": machine_text(machine),
        "machine_name": machine.name,
        **critical_attributes(machine, assembly),
        "mass_spread": mass_spread if groups else 0.0,
        **_coincidence(result),
        "start": start,
        "dwell": dwell,
        "window": window,
        "steps": sum(row["steps"] for row in found.values()),
        "long_steps": sum(row["long_steps"] for row in found.values()),
        "averaged_stations": question["stations"],
        "question": json.dumps(question),
        "outcome": "interrupted" if interrupted else "finished" if len(found) == total else "ended early",
    }
    if kept is not None and not interrupted:
        kept.finish(result)
    return result


def _coincidence(found: xr.Dataset) -> dict[str, str]:
    """A sentence if balls stay in one place at speeds where that state is unstable."""
    if "parting_rate" not in found:
        return {}
    driven = (found["parting_rate"].values > 0.0).reshape(-1, found.sizes["speed"]).any(axis=0)
    if not driven.any():
        return {}
    speeds = found["speed"].values[driven]
    return {
        "coincidence_text": f"at {speeds.size} of {found.sizes['speed']} speeds, from {speeds[0]:.5g} to {speeds[-1]:.5g} rad/s, "
        f"balls lie in one place although this state is unstable there. {CURE}"
    }


def _carried(
    assembly: Assembly,
    rows: Sequence[Matrix],
    weights: Floats,
    plan: Plan,
    groups: list[list[int]],
    speeds: Floats,
    legs: Sequence[str],
    found: dict[Place, Row],
) -> Iterator[tuple[Place, Row]]:
    stepper = Stepper(assembly, rows, weights, plan, groups)
    order = [
        (leg, int(number))
        for leg, way in enumerate(legs)
        for number in (range(speeds.size) if way == "up" else range(speeds.size)[::-1])
    ]
    state = at_speed(assembly.state, float(speeds[order[0][1]]))
    for place in order:
        if place not in found:
            yield place, stepper.hold(state, float(speeds[place[1]]))
        if found[place]["outcome"] != "finished":
            return  # there is no state to go on with
        state = np.array(found[place]["state"])


def _fixed(
    assembly: Assembly,
    rows: Sequence[Matrix],
    weights: Floats,
    plan: Plan,
    groups: list[list[int]],
    speeds: Floats,
    done: set[Place],
    workers: int | None,
) -> Iterator[tuple[Place, Row]]:
    own = local()

    def one(number: int) -> tuple[Place, Row]:
        if not hasattr(own, "stepper"):
            own.stepper = Stepper(assembly, rows, weights, plan, groups)
        speed = float(speeds[number])
        return (0, number), own.stepper.hold(at_speed(assembly.state, speed), speed)

    pool = ThreadPoolExecutor(workers if workers is not None else os.cpu_count() or 1)
    try:
        waiting = [pool.submit(one, number) for number in range(speeds.size) if (0, number) not in done]
        for ended in as_completed(waiting):
            yield ended.result()
    finally:
        pool.shutdown(cancel_futures=True)
