"""What a stepped response is asked: the machine at a speed, the stations, speeds and times that make sense."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from autobalancer.assembly.parameters import with_value_at
from autobalancer.assembly.system import Assembly
from autobalancer.errors import QuestionError
from autobalancer.kernels.system import Floats, Matrix
from autobalancer.machine import Constant, Machine, PrescribedSpeed, Schedule, Start
from autobalancer.studies.stepping import Plan, rate
from autobalancer.units import argument


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
    tolerance: float,
    max_steps: int,
) -> Plan:
    """Times and tolerances that make sense."""
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
    tolerance = argument("tolerance", tolerance, "")
    if not 1e-13 <= tolerance <= 1e-2:
        raise QuestionError(f"tolerance: given {tolerance:g}; must be between 1e-13 and 1e-2")
    if max_steps < 1:
        raise QuestionError(f"max_steps: given {max_steps}; must be at least 1")
    return Plan(dwell, window, rate(acceleration), settle, longest or 0.0, tolerance, max_steps)
