"""Run a machine with deep chambers."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Literal

import numpy as np
import xarray as xr

from autobalancer.assembly.chamber import ChamberNumbers, assemble_chamber, contact_time
from autobalancer.errors import QuestionError
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.simulation.chamber.dataset import chamber_dataset, energies
from autobalancer.simulation.chamber.filling import fill
from autobalancer.simulation.chamber.march import Recorder, advance, begin, restore
from autobalancer.simulation.chamber.settle import settled
from autobalancer.units import to_si

STEPS_IN_CONTACT = 30  # of the default step, in the shortest contact
LEAST_IN_CONTACT = 8  # of the longest step allowed
CHUNK = 250  # samples

Checkpoint = dict[str, Any]


def simulate_chamber(
    machine: ChamberMachine,
    *,
    duration: float | str | None = None,
    step: float | str | None = None,
    sample: float | str = 1e-3,
    method: Literal["verlet", "runge_kutta"] = "verlet",
    seed: int = 0,
    settle: bool = True,
    resume: Checkpoint | None = None,
    on_chunk: Callable[[xr.Dataset, Checkpoint], Any] | None = None,
    keep: bool = True,
    chunk: int = CHUNK,
    progress: Callable[[float, float], Any] | None = None,
    keep_on_interrupt: bool = False,
) -> xr.Dataset:
    """Run a machine whose balls move freely in its chambers.

    Parameters
    ----------
    machine
        The machine.
    duration
        s, or a text with a unit; by default ``run.duration`` of the machine. A resumed run goes on up to this time.
    step
        Of time, s; by default a thirtieth of the shortest contact at 4 m/s. It is shortened so that samples fall on steps.
    sample
        Time between samples, s.
    method
        ``verlet``, or the fixed-step ``runge_kutta`` of fourth order of Pakuła (2021), appendix 1, for comparison.
    seed
        For the trace of disorder in the filling.
    settle
        Whether filled balls come to rest before the run.
    resume
        What ``on_chunk`` got with an earlier chunk: the run goes on from there, equal to the last bit. Seed and filling count
        no more; step, sample and method must be those of that run.
    on_chunk
        Called after every ``chunk`` samples with the new part of the result, and the checkpoint at its end.
    keep
        Whether to keep all samples for the answer. Without, memory stays flat and the answer is the last part.
    progress
        Called with time and duration.
    keep_on_interrupt
        Whether Ctrl-C ends the run with what was computed; otherwise it is raised.

    Returns
    -------
    xarray.Dataset
        Dimensions ``time``, ``ball``, ``axis`` (x along the rotor, y, z) and ``bearing``; see the page on the deep chamber.

    Raises
    ------
    QuestionError
        For a step too long for the contacts, a sample shorter than the step, or no duration.
    MachineError
        If the balls do not fit, or given ones overlap.
    """
    end = _duration(machine, duration)
    interval = float(to_si(sample, "s"))
    if not interval > 0.0:
        raise QuestionError(f"sample: given {interval:g} s; must be greater than zero")
    if method not in ("verlet", "runge_kutta"):
        raise QuestionError(f"method: given {method!r}; must be 'verlet' or 'runge_kutta'")
    if method == "runge_kutta" and machine.contact.law == "history":
        raise QuestionError("method: contacts with memory need 'verlet'")
    shortest = contact_time(machine)
    h = _step(step, shortest)
    every = max(math.ceil(interval / h * (1.0 - 1e-9)), 1)
    h = interval / every
    numbers, first_energy = _first_state(machine, h, seed, settle, resume, interval)
    samples = max(round(end / interval), 0)
    recorder = Recorder(every, method)
    parts: list[xr.Dataset] = []
    interrupted = False
    done = int(numbers.counts_done) // every
    attributes = {"step": h, "seed": seed, "method": method, "sample": interval, "contact_time": shortest}
    if resume is None:
        parts.append(chamber_dataset(machine, numbers, recorder.now(numbers), first_energy))
    try:
        while done < samples:
            count = min(chunk - done % chunk, samples - done)
            record = recorder.take(numbers, count, advance)
            part = chamber_dataset(machine, numbers, record, first_energy)
            done += part.sizes["time"]
            if resume is None and done <= chunk and on_chunk is not None:
                part = xr.concat([parts.pop(), part], "time", data_vars="minimal", coords="minimal", compat="override")
            if on_chunk is not None:
                on_chunk(_labeled(part, machine, attributes, "running", f"reached {done * interval:.6g} s", end), {
                    **numbers.checkpoint(), "first_energy": np.array([first_energy]), "every": np.array([every]),
                })  # fmt: skip
            parts = [*parts, part] if keep else [part]
            if progress is not None:
                progress(done * interval, end)
            if record.failed:
                break
    except KeyboardInterrupt:
        if not keep_on_interrupt:
            raise
        interrupted = True
    outcome, text = _outcome(numbers, done * interval, end, interrupted)
    whole = _joined(machine, numbers, parts, first_energy)
    return _labeled(whole, machine, attributes, outcome, text, end)
