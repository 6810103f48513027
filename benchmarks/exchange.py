"""A machine exported as a library in C: a step, and the balls alone, beside the package itself in one run."""

from __future__ import annotations

import ctypes
import tempfile
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

import autobalancer as ab
from autobalancer.assembly.system import assemble
from autobalancer.simulation.record import record_for
from autobalancer.simulation.steppers import stepper_for
from benchmarks import compared, measured

MACHINES = Path(__file__).parents[1] / "examples" / "machines"
MACHINE = MACHINES / "discoidal.toml"
CALLS, END = 20_000, 160.0


def bench() -> list[dict[str, Any]]:
    """The run of the library beside that of the package; the balls alone."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        ab.export(MACHINE, folder / "whole")
        text = (MACHINES / "rigid_rotor.toml").read_text("utf-8")
        balls = ab.parse_machine(text.replace("[[balancers.races]]", "[[balancers.races]]\ncollisions = false"))
        ab.export(balls, folder / "balls", part="balancer")
        whole, alone = (ctypes.CDLL(str(next((folder / name).glob("lib*.so")))) for name in ("whole", "balls"))
        ours, steps = _ours()
        theirs, taken = _library(whole)
        element = _element(alone)
    note = f"{MACHINE.name}: {steps} steps; the library {taken}, with 1000 looks on the way; peer: the stepper alone"
    return [
        compared("exported_run", theirs, "the package", ours, note=note),
        measured(
            "exported_balls",
            element,
            "ns",
            note="an evaluation of two balls, called from Python by ctypes",
        ),
    ]


def _ours() -> tuple[float, int]:
    machine, times, steps = ab.load_machine(MACHINE), [], 0
    record = record_for([ab.SampleTimes((0.0,))], (), assemble(machine), END)
    for _ in range(5):
        stepper = stepper_for(assemble(machine), END, 1e-8, "dormand_prince_8")
        system = assemble(machine).system
        begin = perf_counter()
        stepper.advance(system, record, 10**9)
        times.append(perf_counter() - begin)
        steps = int(stepper.attributes()["steps"])
    return min(times), steps


def _library(c: ctypes.CDLL) -> tuple[float, int]:
    c.ab_create.restype, c.ab_steps_taken.restype = ctypes.c_void_p, ctypes.c_int64
    times, taken = [], 0
    for _ in range(5):
        one = ctypes.c_void_p(c.ab_create())
        begin = perf_counter()
        for k in range(1, 1001):
            c.ab_step(one, ctypes.c_double(END * k / 1000))
        times.append(perf_counter() - begin)
        taken = int(c.ab_steps_taken(one))
        c.ab_free(one)
    return min(times), taken


def _element(c: ctypes.CDLL) -> float:
    """Nanoseconds of an evaluation, without what a call from Python takes by itself."""
    c.ab_create.restype, c.ab_time.restype = ctypes.c_void_p, ctypes.c_double
    one = ctypes.c_void_p(c.ab_create())
    arrays = [np.array([1e-5, 2e-5, 1e-3, 2e-3]), np.array([0.3, 200.0]), np.array([1.0, 2.0, 3.0, 4.0])]
    arrays += [np.zeros(count) for count in (3, 9, 2, 6)]
    given = [one, ctypes.c_double(0.0), *(ctypes.c_void_p(each.ctypes.data) for each in arrays)]
    best, empty = np.inf, np.inf
    for _ in range(10):
        begin = perf_counter()
        for _ in range(CALLS):
            c.ab_element(*given)
        middle = perf_counter()
        for _ in range(CALLS):
            c.ab_set_input(*given)  # refused at once: the same arguments, no work
        best, empty = min(best, middle - begin), min(empty, perf_counter() - middle)
    return 1e9 * (best - empty) / CALLS
