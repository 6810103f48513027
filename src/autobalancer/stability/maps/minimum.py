"""The least viscosity or drag with which the balanced state is stable at a speed and above it."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np

from autobalancer.assembly.quantities import with_quantity
from autobalancer.assembly.terms import ignores, weightless
from autobalancer.errors import QuestionError, RangeWarning, warn
from autobalancer.files.given import balls_in_races
from autobalancer.machine import Machine
from autobalancer.stability.host.planar import Floats
from autobalancer.stability.host.stations import Stations
from autobalancer.stability.maps.averaged import AVERAGED, averaged_of
from autobalancer.stability.maps.balanced import balanced_states
from autobalancer.stability.maps.curve import VARIABLES
from autobalancer.stability.maps.exact import border_of, exact_borders, worst_case_of
from autobalancer.stability.maps.speeds import theory_of
from autobalancer.stability.stall.borders import release_of
from autobalancer.stability.stall.notes import CAPTURE, RELEASE
from autobalancer.stability.states.described import Described, described, lower_critical_speed
from autobalancer.units import to_si, unbalance_argument

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
    whole = balls_in_races(machine)
    machine = weightless(whole)
    if which not in VARIABLES:
        raise QuestionError(f"which: given {which!r}; must be one of {', '.join(VARIABLES)}")
    wanted = _speed(speed)
    p = described(machine, unbalance)
    if left_out := ignores(whole, theory_of(which)):
        warn(f"minimum {name}: the {which} {left_out}", RangeWarning)
    if p.moment.size == 0:
        raise QuestionError(f"minimum {name}: the machine has no balls")
    fast = lower_critical_speed(p) if isinstance(p, Stations) else math.sqrt(max(p.stiffness) / p.mass)
    unit = float(np.median(p.inertia)) * fast
    ends = VISCOSITIES if name == "viscosity" else (DRAGS[0] * unit, DRAGS[1] * unit)
    start = with_quantity(machine, name, ends[1])  # also says if nothing can be changed
    given = unbalance if isinstance(p, Stations) else p.unbalance
    holds = _question(start, which, wanted, given)

    def enough(exponent: float) -> bool:
        return holds(with_quantity(machine, name, math.exp(exponent)))

    def surplus(exponent: float) -> float:
        changed = with_quantity(machine, name, math.exp(exponent))
        return _surplus(changed, described(changed, given), which, wanted)

    low, high = (math.log(value) for value in ends)
    grid = np.linspace(low, high, round(STEPS * (high - low) / math.log(10.0)) + 1)[::-1]
    if not enough(float(grid[0])):
        return math.inf
    if which == RELEASE:
        grid = _around(enough, grid)
    for before, after in pairwise(grid):
        if not enough(float(after)):
            if which in (RELEASE, CAPTURE):
                return _root(surplus, float(after), float(before))
            return _bisected(enough, float(after), float(before))
    return 0.0


def _question(
    machine: Machine, which: str, speed: float, unbalance: complex | float | None
) -> Callable[[Machine], bool]:
    """Whether the border of a machine is not above the speed."""

    def of(machine: Machine) -> Described:
        return described(machine, unbalance)

    if which == AVERAGED:
        found = averaged_of(of(machine))
        if math.isnan(found.speed):
            raise QuestionError(f"{which}: {found.note}")
        return lambda m: averaged_of(of(m)).speed <= speed
    if which in (RELEASE, CAPTURE):
        return lambda m: _surplus(m, of(m), which, speed) <= 0.0
    if which == "exact border, worst case":
        found = worst_case_of(of(machine))
        if math.isnan(found.speed):
            raise QuestionError(f"{which}: {found.note}")
        return lambda m: worst_case_of(of(m)).speed <= speed
    (first, *_) = exact_borders(machine, of(machine))
    if math.isnan(first.speed):
        raise QuestionError(f"{which}: {first.note}")
    worst = which == "exact border"

    def exact(m: Machine) -> bool:
        p = of(m)
        if not isinstance(p, Stations) and p.isotropic and speed <= max(p.critical_speeds):
            return False
        verdicts = (border_of(state, p)[0] <= speed for state in balanced_states(p))
        return all(verdicts) if worst else any(verdicts)

    return exact


def _surplus(machine: Machine, p: Described, which: str, speed: float) -> float:
    """Log of the release or capture speed over ``speed``, between -1 and 1; -1 where balls do not stall."""
    found = {one.name: one.speed for one in release_of(machine, p, capture=which == CAPTURE)}
    border = found[RELEASE] if math.isinf(found[RELEASE]) else found.get(which, math.nan)
    return -1.0 if math.isnan(border) else max(min(math.log(border / speed), 1.0), -1.0)


def _around(enough: Callable[[float], bool], grid: Floats) -> Floats:
    """The two neighbors between which a question is decided whose answer changes once, as that of release does over the drag."""
    low, high = 0, grid.size - 1
    if enough(float(grid[high])):
        return grid[:1]
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if enough(float(grid[middle])) else (low, middle)
    return grid[low : high + 1]


def _root(surplus: Callable[[float], float], low: float, high: float) -> float:
    """Like :func:`_bisected`, faster where the surplus is smooth."""
    from scipy.optimize import brentq

    at = float(brentq(surplus, low, high, xtol=1e-11, rtol=1e-14))
    while surplus(at) > 0.0 and at < high:
        at += 1e-10
    return math.exp(at)


def _speed(speed: float | str) -> float:
    value = float(to_si(speed, "rad/s"))
    if not value > 0.0:
        raise QuestionError(f"speed: given {speed!r}; must be greater than zero")
    return value


def _bisected(enough: Callable[[float], bool], low: float, high: float) -> float:
    """The logarithm between one that is not enough and one that is, turned back."""
    while high - low > 1e-10:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if enough(middle) else (middle, high)
    return math.exp(high)
