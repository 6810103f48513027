"""Run a machine with deep chambers."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Literal

import numpy as np
import xarray as xr

from autobalancer.assembly.chamber import contact_time
from autobalancer.assembly.contact.rebound import restitution_at
from autobalancer.errors import QuestionError
from autobalancer.machine.bare_numbers import bare_numbers
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.patience import shows_progress
from autobalancer.simulation.chamber.critical_speeds import chamber_critical_speeds
from autobalancer.simulation.chamber.dataset import joined, labeled
from autobalancer.simulation.chamber.march import begin, restore
from autobalancer.units import to_si

STEPS_IN_CONTACT = 25  # at least, of the default step in the shortest contact
LEAST_IN_CONTACT = 8  # of the longest step allowed
CHUNK = 250  # samples

Checkpoint = dict[str, Any]

MOST = 100_000_000  # samples
FAST = 4.0  # m/s, of an impact at which restitution that depends on the speed decides about the step
LEAST_LEFT = 0.3  # restitution below which the step is not shortened further for it: little is left of the speed


@shows_progress
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
        s, or a text with a unit; by default ``run.duration`` of the machine. A resumed run continues up to this time.
    step
        Time step, s; by default 1/25 of the shortest contact at 4 m/s, less for a
        restitution below 0.5. It is shortened so that samples coincide with steps.
    sample
        Time between samples, s.
    method
        ``verlet``, or the fixed-step ``runge_kutta`` of fourth order of Pakuła (2021), appendix 1, for comparison.
    seed
        For the small disorder in the filling.
    settle
        Whether filled balls come to rest before the run.
    resume
        A checkpoint that ``on_chunk`` received: the run continues from it, identical to the last bit. Seed and filling are
        ignored; step, sample and method must be those of that run.
    on_chunk
        Called after every ``chunk`` samples with the new part of the result, and the checkpoint at its end.
    keep
        Whether to return all samples. If false, memory use stays constant and the last part is returned.
    progress
        Called with time and duration, several times in a second; first with zero while the balls settle.
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
    h = default_step(machine) if step is None else _step(step, shortest)
    every = max(math.ceil(interval / h * (1.0 - 1e-9)), 1)
    h = interval / every
    attributes = {
        "step": h,
        "seed": seed,
        "method": method,
        "sample": interval,
        "contact_time": shortest,
        "critical_speeds": list(chamber_critical_speeds(machine)[0]),
        **({"input_text": "\n".join(odd)} if (odd := bare_numbers(machine)) else {}),
    }
    samples = round(end / interval)
    if samples > MOST:
        raise QuestionError(
            f"sample: given {interval:g} s, which makes {samples:.3g} samples; at most {MOST:.3g} are possible"
        )

    def told(done: int) -> None:
        if progress is not None:
            progress(done * interval, end)

    march = (
        begin(machine, h, every, method, seed, settle, lambda: told(0))
        if resume is None
        else restore(machine, h, every, resume)
    )
    parts: list[xr.Dataset] = []
    waiting = [march.first()] if resume is None else []
    kept = march.samples
    name, text = "finished", f"reached {end:.6g} s"
    try:
        while march.samples < samples:
            part = march.take(min(chunk - march.samples % chunk, samples - march.samples), told)
            if march.interrupted and not part.sizes["time"]:
                raise KeyboardInterrupt
            if waiting:
                part = joined([waiting.pop(), part])
            now = march.samples * interval
            if on_chunk is not None:
                about = (machine, attributes, "running", f"reached {now:.6g} s of {end:.6g} s", end)
                on_chunk(labeled(part, *about), march.checkpoint())
            parts = [*parts, part] if keep else [part]
            kept = march.samples
            if march.interrupted:
                raise KeyboardInterrupt
            if march.failure:
                name, text = march.failure
                break
    except KeyboardInterrupt:
        if not keep_on_interrupt:
            raise
        text = f"interrupted at {kept * interval:.6g} s of {end:.6g} s; what was computed is kept"
        name = "interrupted"
    return labeled(
        joined([*waiting, *parts]) if waiting or parts else march.first(), machine, attributes, name, text, end
    )


def _duration(machine: ChamberMachine, duration: float | str | None) -> float:
    if duration is None:
        if machine.run is None:
            raise QuestionError("duration: not given, and the machine has no run.duration; give one of them")
        return float(machine.run.duration)
    end = float(to_si(duration, "s"))
    if end < 0.0:
        raise QuestionError(f"duration: given {end:g} s; must not be negative")
    return end


def default_step(machine: ChamberMachine) -> float:
    """A twenty-fifth of the shortest contact at 4 m/s, less for a restitution below a half, s."""
    # the error of the rebound speed goes with the jump of the force at the turning point, and with the step squared
    left = float(machine.contact.restitution)
    if machine.contact.rebound is not None:
        left = max(LEAST_LEFT, float(restitution_at((machine.contact.rebound, left, 0.0), np.array([FAST]))[0]))
    jump = math.sqrt(left**-2 - 1.0)
    return contact_time(machine) / max(STEPS_IN_CONTACT, 15.0 * jump)


def _step(step: float | str, shortest: float) -> float:
    h = float(to_si(step, "s"))
    longest = shortest / LEAST_IN_CONTACT
    if not 0.0 < h <= longest * (1.0 + 1e-9):
        raise QuestionError(
            f"step: given {h:g} s; the shortest contact lasts {shortest:.3g} s (at 4 m/s), so it must be greater than zero "
            f"and at most {longest:.3g} s. Shorten it, or make the contact softer"
        )
    return h
