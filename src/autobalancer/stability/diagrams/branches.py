"""Bifurcation diagrams: all connected steady states and periodic motions along one parameter."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, Literal

import numpy as np
import xarray as xr

from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import load_machine, machine_text
from autobalancer.machine import Machine
from autobalancer.results.provenance import provenance
from autobalancer.stability.continuation.family import Family
from autobalancer.stability.continuation.follow import Steps
from autobalancer.stability.continuation.steady import Range
from autobalancer.stability.continuation.symmetry import coincident, in_two_bundles, kinds
from autobalancer.stability.continuation.vector_field import Field
from autobalancer.stability.diagrams.explorer import Explorer, Progress
from autobalancer.stability.diagrams.tables import branch_dataset
from autobalancer.stability.host.planar import Floats
from autobalancer.stability.ignored import ignored_at_rest
from autobalancer.stability.periodic.stalled import stalled_orbit
from autobalancer.stability.states.planar import Equilibrium, equilibria_of
from autobalancer.units import optional_argument

State = Literal["balanced", "coincident", "in line", "stalled", "all"]
STARTS = 13  # places in the range at which a stalled orbit is looked for


def branches(
    machine: Machine | str | Path,
    parameter: str,
    start: float | str,
    end: float | str,
    *,
    speed: float | str | None = None,
    from_state: State = "balanced",
    switch: bool = True,
    orbits: bool = True,
    largest_step: float = 0.03,
    intervals: int = 30,
    limit: int = 40,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Follow steady states and periodic motions of an isotropic machine at constant speed along a parameter.

    Parameters
    ----------
    machine
        A machine or the path of a machine file; isotropic supports, no gravity in its plane.
    parameter
        ``speed``, ``unbalance``, ``drag``, ``viscosity``, ``ball_mass``, ``ball_diameter``, ``damping``, ``stiffness``, or a
        path like ``"balancers[1].races[1].eccentricity"``.
    start, end
        The range, SI or with a unit; ``end`` may be the lower one.
    speed
        Rotor speed in rad/s where it is not the parameter; by default that of a machine with a constant prescribed speed.
    from_state
        Steady states at ``start`` from which to begin; *stalled* for balls stalled at the critical speed, wherever
        in the range they stall; *all* for all of these.
    switch
        Also follow all branches that start from the ones found.
    orbits
        Follow the periodic motions that begin at Hopf points.
    largest_step
        Of the parameter as a share of its range, and of the ball angles in rad; for orbits five times that.
    intervals
        Of the mesh over a period, four collocation points each.
    limit
        Greatest number of branches.
    progress
        Called with (number of the branch, place in the range between 0 and 1).

    Returns
    -------
    xarray.Dataset
        Along ``point``: ``branch``, the parameter, ``kind``, ``name``, ``verdict``, ``unstable_directions``,
        ``growth_rate``, least and greatest ``deflection`` and ``ball_angle_in_rotor``, mean ``ball_speed_in_space``,
        ``period``. Along ``special``: ``special_type`` (fold, Hopf, pitchfork, branch point, period doubling, torus,
        infinite period), where, ``lyapunov_coefficient`` and ``criticality`` of Hopf points.

    Raises
    ------
    QuestionError
        For an unknown parameter or state, an empty range, orthotropic supports, gravity in the plane, no balls.
    """
    speed = optional_argument("speed", speed, "rad/s")
    if not isinstance(machine, Machine):
        machine = load_machine(machine)
    if from_state not in ("balanced", "coincident", "in line", "stalled", "all"):
        raise QuestionError(f"from_state: given {from_state!r}; must be balanced, coincident, in line, stalled or all")
    if not 1e-4 <= largest_step <= 0.5:
        raise QuestionError(f"largest_step: given {largest_step!r}; must be between 1e-4 and 0.5, 0.03 is a good start")
    if not 4 <= intervals <= 400:
        raise QuestionError(f"intervals: given {intervals!r}; must be between 4 and 400, 30 is a good start")
    family = Family(machine, [parameter], speed)
    first, last = family.read(0, start), family.read(0, end)
    if first == last:
        raise QuestionError(f"{parameter}: the range begins and ends at {first:.6g}; give two different values")
    if parameter in ("speed", "stiffness", "ball_mass", "ball_diameter") and not min(first, last) > 0.0:
        raise QuestionError(f"{parameter}: given {min(first, last):.6g}; must be greater than zero")
    span = Range(family, first, last)
    planes = [family(value).plane for value in (first, last, 0.63 * first + 0.37 * last)]
    if planes[0].moment.size == 0:
        raise QuestionError("branches: the machine has no balls")
    if len({p.moment.size for p in planes}) > 1:
        raise QuestionError(f"{parameter}: the number of balls must not change along the range")
    kind = kinds(planes)
    explorer = Explorer(span, kind, Steps(0.3 * largest_step, 1e-7, largest_step), intervals, limit, progress)
    if from_state != "stalled":
        field = family(first)
        for state in starts_of(field, from_state, parameter, first):
            begin = begin_at(field, state, kind)
            explorer.steady_from(coincident(begin[4 : 4 + len(kind)], kind), begin)
        if switch:
            explorer.switch()
        if orbits:
            explorer.orbits()
    if from_state in ("stalled", "all"):
        _stalled(explorer, span, kind, intervals, from_state)
    attributes: dict[str, Any] = {
        "title": f"Branches of {machine.name}",
        **provenance(),
        "machine": machine_text(machine),
        "machine_name": machine.name,
        "parameter": parameter,
        "theory": "pseudo-arclength continuation of the full equations",
        "ignores": ", ".join(ignored_at_rest(machine)),
    }
    if "speed" not in parameter:
        attributes["speed"] = family(first).speed
    return branch_dataset(explorer, *family.label(0), attributes)


def state_vector(field: Field, state: Equilibrium) -> Floats:
    """X, Y, VX, VY, ball angles and speeds of a steady state."""
    whirl, rate = state.whirl, 1j * field.speed * state.whirl
    rest = np.zeros(state.angles.size)
    return np.concatenate([[whirl.real, whirl.imag, rate.real, rate.imag], state.angles, rest])


def begin_at(field: Field, state: Equilibrium, kind: list[tuple[float, ...]]) -> Floats:
    """The state vector from which a steady state is followed: of a continuum the member in two bundles."""
    here = state_vector(field, state)
    bundled = in_two_bundles(field.plane, here, kind) if state.freedom else None
    return here if bundled is None else bundled


def starts_of(field: Field, wanted: str, parameter: str, value: float) -> list[Equilibrium]:
    states = equilibria_of(field.plane, field.speed)
    chosen = [state for state in states if wanted in (state.name, "all")]
    if not chosen:
        there = ", ".join(sorted({state.name for state in states}))
        raise QuestionError(
            f"from_state: no state {wanted!r} at {parameter} = {value:.6g}; there is {there}. take one of these"
        )
    return chosen


def _stalled(explorer: Explorer, span: Range, kind: list[tuple[float, ...]], intervals: int, wanted: str) -> None:
    groups = coincident(np.zeros(len(kind)), kind)
    # speeds at which balls hang begin at the critical speed, where the drag just overcomes them: try the middle first
    shares = sorted(np.linspace(0.0, 1.0, STARTS), key=lambda share: abs(share - 0.5))
    for share in shares:
        found = stalled_orbit(span, groups, float(share), intervals)
        if found is not None:
            explorer.orbit_from(*found)
            return
    if wanted == "stalled":
        field = span.field(0.0, groups)
        critical = math.sqrt(field.plane.stiffness[0] / field.plane.mass)
        raise QuestionError(
            f"from_state: balls that start at the critical speed ({critical:.5g} rad/s) stall there at none of {STARTS} values "
            "in the range; they catch up with the rotor or settle elsewhere. Widen the range, or look for them with simulate()"
        )
