"""Specification files: TOML, or the same as a dict, turned into a specification; every fault is named with its key."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from autobalancer.assembly.drive_train import highest_prescribed
from autobalancer.assembly.quantities import changed_part, value_of
from autobalancer.catalog.product_tables import bearing
from autobalancer.errors import QuestionError
from autobalancer.files.examples import rig, rigs
from autobalancer.files.machine_file import balls_in_races
from autobalancer.files.samples import beside
from autobalancer.files.text_files import faults_of, question_data
from autobalancer.machine import Machine, PrescribedSpeed, Unbalance
from autobalancer.machine.drive import Constant
from autobalancer.machine.keys import bare_numbers
from autobalancer.machine.part import Range
from autobalancer.results.verdict import wilson_interval
from autobalancer.rotordynamics.receptance.rational_fit import receptance
from autobalancer.rotordynamics.receptance.receptances import (
    FittedReceptance,
    MeasuredRotor,
    hertz,
    load_receptance,
    measured_rotor,
    said_of,
    with_measured_rotor,
)
from autobalancer.studies.design.specification import (
    MARGIN,
    SHARE,
    STALL,
    Blend,
    Candidates,
    Filling,
    MeasuredReceptance,
    Operation,
    Options,
    Spec,
    Specification,
    blended,
    known_fluid,
)
from autobalancer.tables import rpm_and_si


def read_spec(given: str | Path | Mapping[str, Any]) -> Spec:
    """A specification from a file or a dict of the same form.

    Raises
    ------
    QuestionError
        With the file and the key at fault, what was given, and what is allowed; for limits that contradict each other.
    MachineFileError
        If its machine cannot be read.
    """
    data, source, folder, name = question_data(given, "specification", "design")
    with faults_of(source):
        spec = _spec(Specification(**data), folder, name)
        refuse_contradictions(spec)
    return spec


def _spec(asked: Specification, folder: Path, name: str) -> Spec:
    machine, name = None if asked.machine is None else _machine(asked.machine, folder), asked.name or name
    measured = None if asked.rotor is None else read_rotor(asked.rotor, folder)
    if measured is not None:
        machine = with_rotor(machine, measured, name)
    assert machine is not None
    unbalance = asked.unbalance or _own_unbalance(machine)
    if measured is not None:
        machine = with_some_unbalance(machine, unbalance[1])
    return Spec(
        name=name,
        machine=machine,
        operation=_operation(machine, asked.operation),
        unbalance=(float(unbalance[0]), float(unbalance[1])),
        space=asked.space,
        temperature=(float(asked.temperature[0]), float(asked.temperature[1])),
        limits={key: float(value) for key, value in asked.limits if value is not None},
        options=_options(machine, asked.candidates),
        search=asked.search,
        scatter=asked.scatter,
        measured=measured.fit if measured is not None else None,
        remarks=bare_numbers(asked),
    )


def _machine(given: Any, folder: Path) -> Machine:
    if isinstance(given, str) and given in rigs():
        return rig(given)
    return balls_in_races(beside(folder, given) if isinstance(given, (str, Path)) else given)


def _operation(machine: Machine, given: Operation) -> Operation:
    if not given.speed:
        top = highest_prescribed(machine)
        if top is None or not top > 0.0:
            raise QuestionError("missing, and the drive of the machine names no highest speed", ("operation", "speed"))
        given = given.model_copy(update={"speed": (float(top),)})
    way = {"run_up": given.run_up, "hold": given.hold, "coast_down": given.coast_down}
    if any(way.values()) and not (given.run_up and given.hold):
        text = "'run_up' and 'hold' belong together; give both, or neither to take the drive of the machine"
        raise QuestionError(text, ("operation",))
    if len(given.speed) > 1 and not given.run_up:
        text = "several speeds need 'run_up' and 'hold', which say how the machine gets to each"
        raise QuestionError(text, ("operation", "speed"))
    if not given.run_up and machine.run is None:
        raise QuestionError("the machine has no 'run.duration'; give 'run_up' and 'hold' here", ("operation",))
    return given


def _own_unbalance(machine: Machine) -> tuple[float, float]:
    size = value_of(machine, "unbalance")
    if not size > 0.0:
        text = 'missing, and the machine has none; give it, such as { from = "0 g*mm", to = "500 g*mm" }'
        raise QuestionError(text, ("unbalance",))
    return size, size


# What a specification asks for that cannot be had together; both keys are named.


def refuse_contradictions(spec: Spec) -> None:
    """Refuse what no design can keep.

    Raises
    ------
    QuestionError
        With the two keys that contradict each other; its path is that of the first.
    """
    _enough_members(spec)
    settling, hold = spec.limits.get("settling_time"), spec.operation.hold
    if settling is not None and hold and settling > hold:
        raise QuestionError(
            f"contradicts operation.hold: after the run-up the speed is held for {hold:g} s, which cannot show a settling time "
            f"of {settling:g} s; hold it longer",
            ("limits", "settling_time"),
        )
    if spec.measured is not None:
        refuse_beyond(spec.measured, spec.fastest)
    _fast_enough(spec)


def _enough_members(spec: Spec) -> None:
    """Shares that so few runs can never show, even without a single failure."""
    members = spec.search.members
    _, most = wilson_interval(np.array([0]), members)
    for key, allowed in ((STALL, spec.limits.get(STALL)), (SHARE, 1.0 - spec.share)):
        if allowed is not None and float(most[0]) > allowed:
            needed = math.ceil(1.959964**2 * (1.0 - allowed) / allowed)
            raise QuestionError(
                f"contradicts search.members: {members} runs without a failure still leave {100.0 * float(most[0]):.3g} % "
                f"possible (95 %), and {100.0 * allowed:.3g} % is asked for; take {needed} members",
                ("limits", key),
            )


def _fast_enough(spec: Spec) -> None:
    """No border lies below the lowest critical speed of rotor and supports."""
    margin = spec.limits.get(MARGIN)
    if margin is None or not spec.machine.balancers:
        return
    from autobalancer.rotordynamics.campbell import critical_speeds

    found = critical_speeds(spec.machine)["critical_speed"].values
    if found.size and spec.slowest < (1.0 + margin) * float(found[0]):
        raise QuestionError(
            f"contradicts operation.speed: balls balance above the critical speed of {rpm_and_si(float(found[0]))} only, and "
            f"{100.0 * margin:g} % above it is more than {rpm_and_si(spec.slowest)}",
            ("limits", MARGIN),
        )


# The candidates of a specification: races of the catalog or free ones, balls, fluids, how many races and which
# planes.


def _options(machine: Machine, given: Candidates) -> Options:
    """What there is to choose from, with the names of the catalog and the stations of the machine."""
    sizes = {name: getattr(given, name) for name in ("orbit_radius", "ball_diameter")}
    if not machine.balancers:
        if not given.bearings and not all(sizes.values()):
            text = "the machine has no race; give 'bearings', or both 'orbit_radius' and 'ball_diameter'"
            raise QuestionError(text, ("candidates",))
        if given.drag is None:
            text = 'missing, and the machine has no race to take it from; such as { law = "cd_re", cd_re = 387 }'
            raise QuestionError(text, ("candidates", "drag"))
    fillings, blend, free = _fluids(given.fluids)
    for place, choice in enumerate(fillings):
        if len(choice) > 1 and len(choice) not in given.races:
            labels = ", ".join(one.label for one in choice)
            text = f"{labels} are fluids of {len(choice)} races, and 'races' is {list(given.races)}; allow {len(choice)} there"
            raise QuestionError(text, ("candidates", "fluids", place))
    values = {name: () if isinstance(one, Range) else tuple(map(float, one)) for name, one in sizes.items()}
    return Options(
        bearings=tuple(bearing(name).designation for name in given.bearings),
        orbit_radii=values["orbit_radius"],
        ball_diameters=values["ball_diameter"],
        counts=tuple(dict.fromkeys(given.count or ())),
        fluids=tuple(dict.fromkeys(fillings)),
        races=tuple(dict.fromkeys(given.races)),
        planes=_planes(machine, given.planes),
        balls={name: one for name in ("material", "density") if (one := getattr(given, name)) is not None},
        drag=given.drag,
        free=(
            *((name, float(one.low), float(one.high)) for name, one in sizes.items() if isinstance(one, Range)),
            *free,
        ),
        blend=blend,
    )


def _planes(machine: Machine, given: tuple[str | tuple[str, ...], ...]) -> tuple[tuple[str, ...], ...]:
    """Choices of stations that hold a balancer each; an empty one keeps the balancers of the machine."""
    path = ("candidates", "planes")
    if not given:
        if machine.balancers or machine.rotor.kind in ("planar", "modal"):
            return ((),)
        raise QuestionError("missing; name the stations that may hold a balancer", path)
    known = [one.name for one in machine.stations]
    choices = tuple((choice,) if isinstance(choice, str) else choice for choice in given)
    for place, name in ((place, name) for place, choice in enumerate(choices) for name in choice if name not in known):
        said = ", ".join(map(repr, known)) or "none"
        raise QuestionError(f"no station is called {name!r}; there are {said}", (*path, place))
    return choices


def _fluids(
    given: tuple[str | tuple[str, ...] | Blend, ...],
) -> tuple[list[tuple[Filling, ...]], tuple[str, str] | None, list[tuple[str, float, float]]]:
    """Choices of fluids; the pair of oils whose blend is searched, with its viscosities at 25 °C."""
    found: list[tuple[Filling, ...]] = []
    for place, entry in enumerate(given):
        path = ("candidates", "fluids", place)
        if not isinstance(entry, Blend):
            names = (entry,) if isinstance(entry, str) else entry
            found.append(tuple(Filling(known_fluid(name, *path)) for name in names))
            continue
        oils = known_fluid(entry.blend[0], *path), known_fluid(entry.blend[1], *path)
        blends = [(blended(*oils, float(one)),) for one in entry.viscosity]  # refuses what the two cannot make
        if isinstance(entry.viscosity, Range):
            if len(given) > 1:
                raise QuestionError("a blend with 'from' and 'to' stands alone", path)
            return [], oils, [("viscosity", float(entry.viscosity.low), float(entry.viscosity.high))]
        found += blends
    return found, None, []


# The rotor of a specification from a measured receptance: read, fitted, and refused where it was not measured.


PREFIX = "rotor_"  # of names in the answer of a design
KEPT = ("title", "fit_error", "free_error", "modes", "band_low", "band_high", "warnings", "noise")


def read_rotor(given: MeasuredReceptance, folder: Path) -> MeasuredRotor:
    """Read a measured receptance and fit a rotor to it; paths are seen from ``folder``.

    Raises
    ------
    QuestionError
        With the key at fault; if no rotor has such a receptance, or its lowest mode was not measured.
    ResultError
        If the file cannot be read.
    """
    file = beside(folder, given.receptance)
    try:
        measured = load_receptance(file, function=given.function, mass_added=given.mass_added)
        found = measured_rotor(receptance(measured, modes=given.modes, band=given.band), inertia=given.inertia)
    except QuestionError as reason:
        raise reason.within("rotor") from None
    low, lowest = float(found.fit.attrs["band_low"]), float(found.fit["mode_frequency"].values[0])
    if lowest < low:
        raise QuestionError(
            f"the lowest mode, at {hertz(lowest)} Hz, lies below what was measured, from {hertz(low)} Hz on; a run-up passes it, "
            "so measure from lower frequencies on",
            ("rotor", "receptance"),
        )
    return found


def with_rotor(machine: Machine | None, measured: MeasuredRotor, name: str) -> Machine:
    """A machine with the measured rotor in place of its own; without one a machine that is nothing but this rotor.

    Raises
    ------
    QuestionError
        If the machine has what a rotor known in one plane cannot carry.
    """
    if machine is None:
        still = PrescribedSpeed(profile=Constant(speed=0.0))
        machine = Machine(name=name, axis="vertical", rotor=measured.rotor, drive=still)
    return with_measured_rotor(machine, measured)


def with_some_unbalance(machine: Machine, size: float) -> Machine:
    """The machine itself, or with an unbalance (kg m) if it has none that could be changed."""
    if machine.unbalances:
        return machine
    changed: Machine = changed_part(machine, unbalances=(Unbalance(moment=size),))
    return changed


def refuse_beyond(fit: FittedReceptance, fastest: float) -> None:
    """Refuse speeds (rad/s) whose frequency was not measured.

    Raises
    ------
    QuestionError
        With both keys.
    """
    high = float(fit.attrs["band_high"])
    if fastest > high * (1.0 + 1e-6):
        raise QuestionError(
            f"contradicts rotor.receptance: {rpm_and_si(fastest)} are {hertz(fastest)} Hz, and the receptance is known up to "
            f"{hertz(high)} Hz; measure further, or run slower",
            ("operation", "speed"),
        )


def labelled(fit: FittedReceptance) -> tuple[dict[str, Any], dict[str, Any]]:
    """Variables and attributes under names that no other of a design has."""
    variables = {f"{PREFIX}{name}": fit[name].rename(None) for name in map(str, fit.data_vars)}
    return variables, {f"{PREFIX}{name}": fit.attrs[name] for name in KEPT if name in fit.attrs} | {
        "rotor": said_of(fit)
    }


def read_back(designs: Any) -> FittedReceptance | None:
    """The fit in the answer of a design; None if its rotor was no measured one."""
    if f"{PREFIX}receptance_real" not in designs:
        return None
    names = {name: str(name)[len(PREFIX) :] for name in designs.data_vars if str(name).startswith(PREFIX)}
    attrs = {str(name)[len(PREFIX) :]: value for name, value in designs.attrs.items() if str(name).startswith(PREFIX)}
    found = designs[list(names)].rename(names)
    found.attrs = {**attrs, "rotor": designs.attrs["rotor"], "modes": int(np.asarray(attrs["modes"]))}
    return FittedReceptance.of(found)
