"""The border speeds over any parameter of the machine."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import pairwise, product
from pathlib import Path
from typing import Any

import numpy as np

from autobalancer.arrays import Floats
from autobalancer.assembly.guided_balls import has_forces
from autobalancer.assembly.quantities import parameter_range, parameter_unit, si_value, with_quantity
from autobalancer.assembly.terms import Theory, ignores, unknown, weightless
from autobalancer.catalog.resolve import resolve
from autobalancer.errors import MachineError, QuestionError, RangeWarning, one_of, warn
from autobalancer.files.machine_file import balls_in_races
from autobalancer.machine import Machine
from autobalancer.machine.path import axis_attributes, dimension_of, text_of
from autobalancer.results.answers.answer import Answer
from autobalancer.results.labels import labeled
from autobalancer.roots import root
from autobalancer.stability.border import Border, attributes
from autobalancer.stability.host.stations import is_planar, plane
from autobalancer.stability.maps.balanced import balanced_states
from autobalancer.stability.maps.exact import (
    AVERAGED,
    NAMES,
    averaged_of,
    border_of,
    borders_of,
    exact_borders,
    positive_speed,
    smaller_noted,
    theory_of,
    with_ignored_terms,
    worst_case_of,
)
from autobalancer.stability.stall.borders import release_of
from autobalancer.stability.stall.capture import CAPTURE, RELEASE
from autobalancer.stability.states.rest_states import Described, described
from autobalancer.units import unbalance_argument

Progress = Callable[[int, int], None]
VARIABLES = {name: name.replace(", ", "_").replace(" ", "_") for name in NAMES}
MISSING = {  # why a border that others have is not there
    "exact border, best case": "positions of the balls make no difference",
    "capture speed": "balls in line are not captured",
}


def border_curve(
    machine: Machine | str | Path,
    parameter: str,
    values: Sequence[Any] | Floats | str | None = None,
    *,
    only: Sequence[str] = (),
    up_to: float | str | None = None,
    progress: Progress | None = None,
) -> Answer:
    """The border speeds over a parameter.

    Parameters
    ----------
    machine
        A machine or the path of a machine file.
    parameter
        A name of :data:`autobalancer.machine.path.QUANTITIES`, such as ``"unbalance"``, ``"viscosity"`` or
        ``"rolling_resistance"``, or a path such as ``"balancers[1].races[1].orbit_radius"``.
    values
        SI, strings with units, or a range such as ``"1:100 mm^2/s:30:log"``. For the unbalance they may be
        omitted: then from zero to the capability, dense near the values at which the border is highest.
    only, up_to
        Names of the borders that are wanted, and the highest speed of the run-up, see :func:`borders`.
    progress
        Called with (values done, values in all).

    Returns
    -------
    xarray.Dataset
        Over the parameter, in rad/s: ``averaged_border``, ``exact_border``, ``exact_border_worst_case`` (any
        unbalance), for more than two balls ``exact_border_best_case``, ``release_speed``, ``capture_speed``; each with a
        text ``..._note``. Infinite is *never*, nan *none*; the note says why. ``critical_speed`` is the lower one.

    Raises
    ------
    QuestionError
        For an unknown parameter or no values, no balls, or the ``unbalance`` of a rotor that tilts
        or bends, which may have several: there give the path of one.
    MachineError
        If a value makes no possible machine; the message names it.
    """
    machine = balls_in_races(machine)
    if values is None:
        parameter_unit(machine, parameter)  # refuses a name that is none, with what was perhaps meant
        if parameter != "unbalance" or not is_planar(machine):
            raise QuestionError(
                f"values: none given; give those of {parameter!r}. Only for 'unbalance' of a planar rotor they follow from the "
                "machine"
            )
        values = unbalances_to_capability(machine)
    if isinstance(values, str):
        values = parameter_range(machine, parameter, values)
    if len(values) == 0:
        raise QuestionError(f"values: given none; give at least one of {parameter!r}")
    points = [value.item() if isinstance(value, np.generic) else value for value in values]
    numbers = [si_value(machine, parameter, value) for value in points]
    rows, critical, top = [], [], None if up_to is None else positive_speed(up_to, "up_to")
    constant: tuple[Border, ...] | None = None  # only the exact border depends on the unbalance of races on the axis
    for number, value in enumerate(points):
        changed, p = with_values(machine, {parameter: value})
        if parameter == "unbalance" and not only and constant is not None and p.knows_any_unbalance:
            rows.append(
                (
                    *(b for b in constant if not b.name.startswith("exact border")),
                    *with_ignored_terms(changed, exact_borders(changed, p)),
                )
            )
            rows[-1] += tuple(b for b in constant if b.name == "exact border, worst case")
        else:
            constant = borders_of(changed, p, only, top)
            rows.append(constant)
        critical.append(p.scale_speed)
        if progress is not None:
            progress(number + 1, len(points))
    return _dataset(machine, parameter, numbers, rows, critical)


def unbalances_to_capability(machine: Machine, count: int = 161) -> Floats:
    """From zero to what the balls side by side can balance, kg m, dense about two balls at right angles, where |S2| = 0."""
    p = plane(weightless(machine), 0.0, with_forces=True)
    if p.moment.size == 0:
        raise QuestionError("the machine has no balls; there is no border over the unbalance")
    most, points = p.capability, float(p.moment.sum())
    even = np.linspace(0.0, 1.0, count // 2)
    around = math.sqrt(0.5) + np.concatenate(
        [-np.geomspace(1e-5, 0.1, count // 4)[::-1], [0.0], np.geomspace(1e-5, 0.1, count // 4)]
    )
    return np.unique(np.minimum(np.concatenate([most * even, points * around]), most))


def _dataset(
    machine: Machine, parameter: str, numbers: list[float], rows: list[tuple[Border, ...]], critical: list[float]
) -> Answer:
    dim = dimension_of(parameter)
    by_name = [{border.name: border for border in smaller_noted(row)} for row in rows]
    names = [name for name in VARIABLES if any(name in entry for entry in by_name)]
    data: dict[str, tuple[Any, ...]] = {}
    for name in names:
        missing = Border(name, math.nan, MISSING.get(name, ""))
        borders = [entry.get(name, missing) for entry in by_name]
        notes = np.array([b.note for b in borders], dtype=object)
        data[VARIABLES[name]] = (dim, [b.speed for b in borders], name, "rad/s")
        data[f"{VARIABLES[name]}_note"] = (dim, notes, f"note on the {name}")
    data["critical_speed"] = (dim, critical, "lower critical speed", "rad/s")
    p = described(weightless(machine), None)
    # what the borders of balls at rest leave out, and those of stalled balls, which know more
    left_out: dict[bool, dict[str, None]] = {}
    for theory in map(theory_of, names):
        left_out.setdefault(theory is Theory.STALLED, {}).update(dict.fromkeys(unknown(machine, theory)))
    stalled = ", ".join(left_out.get(True, ()))
    ignored = {"ignores": stalled}
    if False in left_out:
        ignored = {"ignores": ", ".join(left_out[False]), "stalled_ignores": stalled}
    title = f"Border speeds of {machine.name} over {text_of(parameter)}"
    dataset = labeled(data, None, attributes(machine, title, Theory.AT_REST)).assign_coords(
        {dim: (dim, numbers, axis_attributes(parameter))}
    )
    capability = float(np.sum(p.capability))
    # where the greatest unbalance that can be balanced lies between two values, the exact borders there
    if parameter == "unbalance" and min(numbers) < capability < max(numbers) and "exact_border" in dataset:
        changed, there = with_values(machine, {parameter: capability})
        ends = {f"{VARIABLES[b.name]}_at_capability": b.speed for b in exact_borders(changed, there)}
        dataset.attrs |= {name: speed for name, speed in ends.items() if not math.isnan(speed)}
    dataset.attrs |= ignored | {
        "parameter": parameter,
        "unbalance": abs(p.unbalance),
        "capability": capability,
        "balls": len(resolve(machine)),
        "theory": "exact border: full equations; averaged border: averaged equations (Spannan 2021, 4.74); release and "
        "capture speed: torque balance of stalled balls",
    }
    return Answer.of(dataset, "BorderCurve")


# The least viscosity or drag with which the balanced state is stable at a speed and above it.


VISCOSITIES = (1e-9, 0.1)  # m^2/s; nothing that balls run in lies outside
DRAGS = (1e-6, 1e5)  # beta over I w_c
STEPS = 6  # a decade


def minimum_viscosity(
    machine: Machine | str | Path,
    speed: float | str,
    which: str = "exact border",
    *,
    unbalance: float | str | None = None,
) -> float:
    """The least kinematic viscosity of the fluid for which the balanced state is stable at ``speed`` and above it.

    Parameters
    ----------
    machine
        A machine or the path of a machine file. The density of its fluid is kept, in all races.
    speed
        rad/s, or a string with a unit.
    which
        ``"exact border"``: at this unbalance, for more than two balls in their worst positions. ``"exact border, worst
        case"``: for any unbalance up to the capability. ``"averaged border"``, ``"release speed"`` or ``"capture
        speed"``: that one at most at ``speed``; the last two with the drag law and rolling resistance of the machine.
    unbalance
        kg m; by default the largest of the machine.

    Returns
    -------
    float
        m^2/s. With any thicker fluid the border is not above ``speed`` either; thinner fluids may also be enough, in windows.
        Zero if every fluid does; infinite if none does, as below the critical speed.

    Raises
    ------
    QuestionError
        If the drag follows from no fluid, ``which`` is unknown, or there is no balanced state.
    """
    unbalance = unbalance_argument(unbalance)
    return _minimum(machine, "viscosity", speed, which, unbalance)


def minimum_drag(
    machine: Machine | str | Path,
    speed: float | str,
    which: str = "exact border",
    *,
    unbalance: float | str | None = None,
) -> float:
    """The least drag beta of every ball, N m s, for which the balanced state is stable at ``speed`` and above it.

    The border ``which`` of ``machine`` and the ``unbalance`` (kg m) are as in :func:`minimum_viscosity`; the effective mass
    of the balls does not change.
    """
    unbalance = unbalance_argument(unbalance)
    return _minimum(machine, "drag", speed, which, unbalance)


def _minimum(
    machine: Machine | str | Path, name: str, speed: float | str, which: str, unbalance: float | None
) -> float:
    # what is asked, and whether there is an answer at all
    whole = balls_in_races(machine)
    machine = weightless(whole)
    one_of("which", which, *VARIABLES)
    wanted = positive_speed(speed)
    p = described(machine, unbalance)
    if left_out := ignores(whole, theory_of(which)):
        warn(f"minimum {name}: the {which} {left_out}", RangeWarning)
    if p.moment.size == 0:
        raise QuestionError(f"minimum {name}: the machine has no balls")
    # the range that is searched: for drag in units of the inertia times the critical speed
    fast = p.scale_speed
    unit = float(np.median(p.inertia)) * fast
    ends = VISCOSITIES if name == "viscosity" else (DRAGS[0] * unit, DRAGS[1] * unit)
    start = with_quantity(machine, name, ends[1])  # also says if nothing can be changed
    holds = _question(start, which, wanted, unbalance)

    def enough(exponent: float) -> bool:
        return holds(with_quantity(machine, name, math.exp(exponent)))

    def surplus(exponent: float) -> float:
        changed = with_quantity(machine, name, math.exp(exponent))
        return _surplus(changed, described(changed, unbalance), which, wanted)

    # from the thickest fluid down, until it is not enough
    low, high = (math.log(value) for value in ends)
    grid = np.linspace(low, high, round(STEPS * (high - low) / math.log(10.0)) + 1)[::-1]
    if not enough(float(grid[0])):
        return math.inf
    if which == RELEASE:  # whose answer changes once over the drag: the two neighbors between which it does
        first, last = 0, grid.size - 1
        if enough(float(grid[last])):
            return 0.0
        while last - first > 1:
            middle = (first + last) // 2
            first, last = (middle, last) if enough(float(grid[middle])) else (first, middle)
        grid = grid[first : last + 1]
    # between two values: a root where the border is a smooth function, else bisection
    for before, after in pairwise(grid):
        if not enough(float(after)):
            if which in (RELEASE, CAPTURE):
                at = root(surplus, float(after), float(before), xtol=1e-11, rtol=1e-14)
                while surplus(at) > 0.0 and at < before:
                    at += 1e-10
                return math.exp(at)
            return _bisected(enough, float(after), float(before))
    return 0.0


def _question(
    machine: Machine, which: str, speed: float, unbalance: complex | float | None
) -> Callable[[Machine], bool]:
    """Whether the border of a machine is not above the speed."""

    def of(machine: Machine) -> Described:
        return described(machine, unbalance)

    # each border has its own way; one that is not known at the start is refused with its reason
    if which == AVERAGED:
        result = averaged_of(of(machine))
        if math.isnan(result.speed):
            raise QuestionError(f"{which}: {result.note}")
        return lambda m: averaged_of(of(m)).speed <= speed
    if which in (RELEASE, CAPTURE):
        return lambda m: _surplus(m, of(m), which, speed) <= 0.0
    if which == "exact border, worst case":
        result = worst_case_of(of(machine))
        if math.isnan(result.speed):
            raise QuestionError(f"{which}: {result.note}")
        return lambda m: worst_case_of(of(m)).speed <= speed
    # the exact border is that of the worst position of the balls, the best case that of the best one
    (first, *_) = exact_borders(machine, of(machine))
    if math.isnan(first.speed):
        raise QuestionError(f"{which}: {first.note}")
    worst = which == "exact border"

    def exact(m: Machine) -> bool:
        p = of(m)
        if speed <= p.never_below:
            return False
        verdicts = (border_of(state, p).speed <= speed for state in balanced_states(p))
        return all(verdicts) if worst else any(verdicts)

    return exact


def _surplus(machine: Machine, p: Described, which: str, speed: float) -> float:
    """Log of the release or capture speed over ``speed``, between -1 and 1; -1 where balls do not stall."""
    entries = {one.name: one.speed for one in release_of(machine, p, capture=which == CAPTURE)}
    border = entries[RELEASE] if math.isinf(entries[RELEASE]) else entries.get(which, math.nan)
    return -1.0 if math.isnan(border) else max(min(math.log(border / speed), 1.0), -1.0)


def _bisected(enough: Callable[[float], bool], low: float, high: float) -> float:
    """The logarithm between one that is not enough and one that is, turned back."""
    while high - low > 1e-10:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if enough(middle) else (middle, high)
    return math.exp(high)


# The growth rates of a map: compiled and in threads for equal balls, state by state otherwise.


MEMBERS = 6  # of a continuum of balanced states, at most
TASKS = 32  # at least so many pieces of work, if there is enough of it


def rates_over(
    machine: Machine,
    values: dict[str, Floats],
    speed: float,
    worst: bool,
    workers: int | None,
    progress: Callable[[int, int], None] | None,
) -> Floats:
    """Growth rates over two parameters, 1/s, in their order; nan without a balanced state."""
    # speed and, on a planar rotor, unbalance need no new machine: they are the inner loops
    planar = is_planar(machine) and not has_forces(machine)
    inner = ("unbalance", "speed") if planar else ("speed",)
    outer = [name for name in values if name not in inner]  # those that need another machine
    speeds = values.get("speed", np.array([speed]))
    rows = list(product(*(values[name].tolist() for name in outer)))
    planes = [with_values(machine, dict(zip(outer, row, strict=True)))[1] for row in rows]
    own = np.array([np.nan])  # the unbalance of the machine
    sizes = values.get("unbalance", own) if planar else own
    # some more tasks than threads, so that none waits long for the last
    parts = np.array_split(np.arange(sizes.size), max(1, min(sizes.size, TASKS // len(rows))))
    tasks = [(row, part) for row in range(len(rows)) for part in parts]
    result = np.empty((len(rows), sizes.size, speeds.size))

    def work(task: tuple[int, Floats]) -> None:
        row, part = task
        for k in part:
            p = planes[row]
            if not np.isnan(sizes[k]):  # another size of its unbalance
                p = replace(p, unbalance=float(sizes[k]) * (p.unbalance / abs(p.unbalance) if p.unbalance else 1.0))
            rates = np.array([member.rates(speeds) for member in balanced_states(p)[:MEMBERS]])
            result[row, k] = (np.fmax if worst else np.fmin).reduce(rates)

    with ThreadPoolExecutor(workers or os.cpu_count() or 1) as pool:
        for done, _ in enumerate(pool.map(work, tasks), 1):
            if progress is not None:
                progress(done, len(tasks))
    # back to the order of the axes
    order = [*outer, *(name for name in inner if name in values)]
    kept = result.reshape([values[name].size for name in order])
    return np.ascontiguousarray(kept.transpose([order.index(name) for name in values]))


def with_values(machine: Machine, values: dict[str, Any]) -> tuple[Machine, Described]:
    """The machine with other values of its parameters, and its numbers.

    Raises
    ------
    MachineError
        If they make no possible machine; the message names them.
    """
    try:
        for name, value in values.items():
            machine = with_quantity(machine, name, value)
        return machine, described(weightless(machine), None)
    except MachineError as error:
        given = ", ".join(f"{name} = {value}" for name, value in values.items())
        raise MachineError(f"{given}: {error}") from None
