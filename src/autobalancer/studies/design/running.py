"""Runs of a design with scatter: unbalance, temperature, starts and what else the specification lets vary."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from autobalancer.assembly.off_center import off_center
from autobalancer.assembly.parameters import with_value_at
from autobalancer.assembly.places import places_of
from autobalancer.assembly.system import assemble
from autobalancer.catalog.friction_table import friction
from autobalancer.catalog.resolve import resolve
from autobalancer.errors import QuestionError
from autobalancer.machine import Machine
from autobalancer.results.answers.studied import Studied
from autobalancer.results.number_text import length_text, moment_text
from autobalancer.simulation.fluid_lag import diffusing_lags
from autobalancer.stability.friction.held import held_by_friction
from autobalancer.studies.design.building import driven, machine_of
from autobalancer.studies.design.candidate import Candidate
from autobalancer.studies.design.screening import Design
from autobalancer.studies.design.spec import Spec
from autobalancer.studies.study.scatter import vary
from autobalancer.studies.study.study import study

TYPICAL = "bearing ring in a running balancer"  # of the catalog: the friction that is assumed to say what any would do
FRICTION = ("friction", "rolling_resistance", "adherence")  # in names of what may vary
STEPS = 101  # temperatures that stand for a range, where a fluid is no single one of the catalog
Report = Callable[[int, int], None] | None


class Case(NamedTuple):
    """Runs of one kind: to an operating speed, or there and back, which only the peak is asked of."""

    name: str
    found: Studied
    coasting: bool


def runs_of(
    spec: Spec, one: Candidate, folder: Path | None, workers: int | None, progress: Report, seed: int | None = None
) -> list[Case]:
    """All runs that judge a candidate; finished ones are taken from the folder.

    Raises
    ------
    QuestionError
        If the scatter makes impossible machines.
    """
    machine = machine_of(spec, one, 0.5 * sum(spec.temperature), spec.unbalance[1])
    cases = [
        (f"{speed:.6g} rad/s", driven(spec, machine, speed, coasting=False), False) for speed in spec.operation.speeds
    ]
    if spec.operation.coast_down:
        cases.append(("coast-down", driven(spec, machine, spec.fastest, coasting=True), True))
    found = []
    for name, described, coasting in cases:
        asked = study_of(spec, described, one, spec.search.seed if seed is None else seed)
        place = folder / name_of(spec, one, name) if folder is not None else None
        found.append(Case(name, study(asked, folder=place, workers=workers, progress=progress), coasting))
    return found


def refuse_faulty_scatter(spec: Spec, found: Design) -> None:
    """Refuse a scatter, or temperatures of the machine's own fluid, that no design can have, before anything runs.

    Raises
    ------
    QuestionError
        With the key at fault.
    """
    if spec.scatter and found.machine is not None:
        try:
            vary(found.machine, spec.scatter)
        except QuestionError as reason:
            raise QuestionError(f"scatter{str(reason).removeprefix('vary')}") from None
    if found.machine is not None and not found.candidate.fluid:
        _temperatures(spec, found.machine, found.candidate)


def left_out(spec: Spec, machine: Machine) -> str:
    """What the runs leave out of a machine that nobody said is ideal: eccentricity and friction, and what typical ones would do.

    They are no scatter by themselves, since coefficients of friction differ by thousands from race to race: a value that nobody
    gave would decide the order.
    """
    found = list[str]()
    if not any("eccentricity" in name for name in spec.scatter):
        away = off_center(
            places_of(machine, assemble(machine, lags=diffusing_lags(machine))), resolve(machine), spec.fastest
        )
        for plane in away.planes if away is not None else ():
            if not plane.given:
                left = f" and {moment_text(plane.residual)}" * math.isfinite(plane.residual)
                size = length_text(plane.eccentricity)
                found.append(
                    f"eccentricity of the race: {size}, as is typical, would leave a vibration of {size}{left}"
                )
                break
    races = [
        f"balancers[{b}].races[{r}]" for b, part in enumerate(machine.balancers, 1) for r, _ in enumerate(part.races, 1)
    ]
    named = any(word in name for name in spec.scatter for word in FRICTION)
    if not named and all(race.friction is None for balancer in machine.balancers for race in balancer.races):
        typical = next(one for one in friction() if one.name == TYPICAL)
        for race in races:
            rolling = {"adherence": typical.adherence, "rolling_resistance": typical.rolling_resistance}
            machine = with_value_at(machine, f"{race}.friction", rolling)
        held = max((plane.residual_95 for plane in held_by_friction(machine, spec.fastest).planes), default=0.0)
        found.append(
            f"friction: that of a {TYPICAL} (adherence {typical.adherence:g}) would leave up to {moment_text(held)} in 95 % of "
            "starts at this speed, that of others more"
        )
    return "; ".join([*found, "give them in the machine or in [scatter], 0 for none"]) if found else ""


def study_of(spec: Spec, machine: Machine, one: Candidate, seed: int) -> dict[str, Any]:
    """The study that runs a machine with the scatter of the specification, as a dict of the form of study files."""
    low, high = spec.unbalance
    vary: dict[str, Any] = {"unbalance": {"distribution": "uniform", "low": low, "high": high}} if low < high else {}
    vary |= _temperatures(spec, machine, one) | spec.scatter
    return {
        "machine": machine,
        "members": spec.search.members,
        "seed": seed,
        "tolerance": spec.search.tolerance,
        "impossible": "truncate",
        "settling_from": spec.search.settling_from,
        "vary": vary,
    }


def _temperatures(spec: Spec, machine: Machine, one: Candidate) -> dict[str, Any]:
    low, high = spec.temperature
    if low == high:
        return {}
    fluids = {race.fluid for balancer in machine.balancers for race in balancer.races}
    if all(fluid is not None and fluid.name is not None for fluid in fluids):
        return {"temperature": {"distribution": "uniform", "low": low, "high": high}}
    if len(one.fillings) != 1:
        which = one.fluid or "the fluid of the machine"
        raise QuestionError(
            f"temperature: given from {low - 273.15:.4g} to {high - 273.15:.4g} °C, which is known for fluids of the catalog "
            f"and for one blend in all races, not for {which}; give one temperature"
        )
    middles = low + (high - low) * (np.arange(STEPS) + 0.5) / STEPS
    values = [one.fillings[0].at(float(temperature))[1] for temperature in middles]
    return {"viscosity": {"distribution": "discrete", "values": values}}


def name_of(spec: Spec, one: Candidate, case: str) -> str:
    """The name of the folder of a design's runs: the same for the same design."""
    return hashlib.sha256(repr((one.key(), case)).encode()).hexdigest()[:16]
