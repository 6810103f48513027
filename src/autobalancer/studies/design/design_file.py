"""Specification files: TOML, or the same as a dict, turned into a specification; every fault is named with its key."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from autobalancer.assembly.drive_train import highest_prescribed
from autobalancer.assembly.quantities import changed_part, value_of
from autobalancer.catalog.product_tables import bearing
from autobalancer.errors import Problem, QuestionError, all_of
from autobalancer.files.examples import examples, rig
from autobalancer.files.machine_file import balls_in_races
from autobalancer.files.samples import beside
from autobalancer.files.text_files import built_of, question_data
from autobalancer.machine import Machine, PrescribedSpeed, Unbalance
from autobalancer.machine.drive import Constant
from autobalancer.machine.keys import bare_numbers
from autobalancer.machine.part import Range
from autobalancer.random_numbers import wilson_interval
from autobalancer.results.answers.answer import Answer
from autobalancer.rotordynamics.rational_fit import receptance
from autobalancer.rotordynamics.receptances import (
    MeasuredRotor,
    hertz,
    load_receptance,
    measured_rotor,
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

SAME_SPEED = 0.01  # difference, over the operating speed, up to which a run of the machine ends at it


def read_spec(options: str | Path | Mapping[str, Any]) -> Spec:
    """A specification from a file or a dict of the same form.

    Raises
    ------
    QuestionError
        With the file and the key at fault, what was given, and what is allowed; for limits that contradict each other.
    MachineFileError
        If its machine cannot be read.
    """
    data, source, folder, name = question_data(options, "specification", "design")

    def build(options: Mapping[str, Any]) -> Spec:
        spec = _spec(Specification(**options), folder, name)
        if problems := list(contradictions(spec)):
            raise QuestionError.of("", problems)
        return spec

    return built_of(build, data, source)


def _spec(specification: Specification, folder: Path, name: str) -> Spec:
    machine, name = (
        None if specification.machine is None else _machine(specification.machine, folder),
        specification.name or name,
    )
    measured = None if specification.rotor is None else read_rotor(specification.rotor, folder)
    if measured is not None:
        machine = with_rotor(machine, measured, name)
    assert machine is not None
    own = machine
    unbalance, operation, options = all_of(
        lambda: specification.unbalance or _own_unbalance(own),
        lambda: _operation(own, specification.operation),
        lambda: _options(own, specification.candidates),
    )
    if measured is not None:
        machine = with_some_unbalance(machine, unbalance[1])
    return Spec(
        name=name,
        machine=machine,
        operation=operation,
        unbalance=(float(unbalance[0]), float(unbalance[1])),
        space=specification.space,
        temperature=(float(specification.temperature[0]), float(specification.temperature[1])),
        limits={key: float(value) for key, value in specification.limits if value is not None},
        options=options,
        search=specification.search,
        scatter=specification.scatter,
        measured=measured.fit if measured is not None else None,
        remarks=bare_numbers(specification),
    )


def _machine(argument: Any, folder: Path) -> Machine:
    if isinstance(argument, str) and argument in examples("rigs"):
        return rig(argument)
    return balls_in_races(beside(folder, argument) if isinstance(argument, (str, Path)) else argument)


def _operation(machine: Machine, operation: Operation) -> Operation:
    if not operation.speed:
        top = highest_prescribed(machine)
        if top is None or not top > 0.0:
            raise QuestionError("missing, and the drive of the machine names no highest speed", ("operation", "speed"))
        operation = operation.model_copy(update={"speed": (float(top),)})
    way = {"run_up": operation.run_up, "hold": operation.hold, "coast_down": operation.coast_down}
    if any(way.values()) and not (operation.run_up and operation.hold):
        text = "'run_up' and 'hold' belong together; give both, or neither to take the drive of the machine"
        raise QuestionError(text, ("operation",))
    if len(operation.speed) > 1 and not operation.run_up:
        text = "several speeds need 'run_up' and 'hold', which say how the machine gets to each"
        raise QuestionError(text, ("operation", "speed"))
    if not operation.run_up and machine.run is None:
        raise QuestionError("the machine has no 'run.duration'; give 'run_up' and 'hold' here", ("operation",))
    if not operation.run_up:
        _refuse_another_end(machine, operation.speeds[0])
    return operation


def _refuse_another_end(machine: Machine, speed: float) -> None:
    """Runs with the machine's own drive end at the operating ``speed`` (rad/s), at which borders are judged.

    What a torque reaches is known from runs only, so that only a prescribed speed is compared.
    """
    if machine.run is None or not isinstance(machine.drive, PrescribedSpeed):
        return
    from autobalancer.flow.relaxation import wall_speed

    duration = float(machine.run.duration)
    end, _ = wall_speed(machine.drive.profile).at(duration)
    if abs(end - speed) > SAME_SPEED * speed:
        raise QuestionError(
            f"the operating speed is {rpm_and_si(speed)}, but the machine's own drive ends its run of {duration:g} s at "
            f"{rpm_and_si(end)}, more than {100.0 * SAME_SPEED:g} % away; give 'run_up' and 'hold' here, or a drive of the "
            "machine that ends at the operating speed",
            ("operation", "speed"),
        )


def _own_unbalance(machine: Machine) -> tuple[float, float]:
    size = value_of(machine, "unbalance")
    if not size > 0.0:
        text = 'missing, and the machine has none; give it, such as { from = "0 g*mm", to = "500 g*mm" }'
        raise QuestionError(text, ("unbalance",))
    return size, size


# What a specification asks for that cannot be had together; both keys are named.


def contradictions(spec: Spec) -> Iterator[Problem]:
    """All that no design can keep: the path of the first key, and the other one in the text."""
    members, margin = spec.search.members, spec.limits.get(MARGIN)
    _, most = wilson_interval(np.array([0]), members)
    for key, allowed in ((STALL, spec.limits.get(STALL)), (SHARE, 1.0 - spec.share)):
        if allowed is not None and float(most[0]) > allowed:  # so few runs can never show it
            needed = math.ceil(1.959964**2 * (1.0 - allowed) / allowed)
            text = f"{members} runs without a failure still leave {100.0 * float(most[0]):.3g} % possible (95 %), and"
            asked_for = f"{100.0 * allowed:.3g} % is asked for; take {needed} members"
            yield ("limits", key), f"contradicts search.members: {text} {asked_for}"
    settling, hold = spec.limits.get("settling_time"), spec.operation.hold
    if settling is not None and hold and settling > hold:
        text = f"after the run-up the speed is held for {hold:g} s, which cannot show a settling time of {settling:g} s"
        yield ("limits", "settling_time"), f"contradicts operation.hold: {text}; hold it longer"
    if spec.measured is not None:
        yield from beyond(spec.measured, spec.fastest)
    if margin is None or not spec.machine.balancers:
        return
    from autobalancer.rotordynamics.campbell import critical_speeds

    # no border lies below the lowest critical speed of rotor and supports
    critical = critical_speeds(spec.machine)["critical_speed"].values
    if critical.size and spec.slowest < (1.0 + margin) * float(critical[0]):
        text = f"balls balance above the critical speed of {rpm_and_si(float(critical[0]))} only, and {100.0 * margin:g} % above"
        yield ("limits", MARGIN), f"contradicts operation.speed: {text} it is more than {rpm_and_si(spec.slowest)}"


# The candidates of a specification: races of the catalog or free ones, balls, fluids, how many races and which
# planes.


def _options(machine: Machine, candidates: Candidates) -> Options:
    """What there is to choose from, with the names of the catalog and the stations of the machine."""
    sizes = {name: getattr(candidates, name) for name in ("orbit_radius", "ball_diameter")}
    if not machine.balancers:
        if not candidates.bearings and not all(sizes.values()):
            text = "the machine has no race; give 'bearings', or both 'orbit_radius' and 'ball_diameter'"
            raise QuestionError(text, ("candidates",))
        if candidates.drag is None:
            text = 'missing, and the machine has no race to take it from; such as { law = "cd_times_re", cd_times_re = 387 }'
            raise QuestionError(text, ("candidates", "drag"))
    fillings, blend, free = _fluids(candidates.fluids)
    for place, choice in enumerate(fillings):
        if len(choice) > 1 and len(choice) not in candidates.races:
            labels = ", ".join(one.label for one in choice)
            text = (
                f"{labels} are fluids of {len(choice)} races, and 'races' is {list(candidates.races)}; "
                f"allow {len(choice)} there"
            )
            raise QuestionError(text, ("candidates", "fluids", place))
    values = {name: () if isinstance(one, Range) else tuple(map(float, one)) for name, one in sizes.items()}
    return Options(
        bearings=tuple(bearing(name).designation for name in candidates.bearings),
        orbit_radii=values["orbit_radius"],
        ball_diameters=values["ball_diameter"],
        counts=tuple(dict.fromkeys(candidates.count or ())),
        fluids=tuple(dict.fromkeys(fillings)),
        races=tuple(dict.fromkeys(candidates.races)),
        planes=_planes(machine, candidates.planes),
        balls={name: one for name in ("material", "density") if (one := getattr(candidates, name)) is not None},
        drag=candidates.drag,
        free=(
            *((name, float(one.low), float(one.high)) for name, one in sizes.items() if isinstance(one, Range)),
            *free,
        ),
        blend=blend,
    )


def _planes(machine: Machine, values: tuple[str | tuple[str, ...], ...]) -> tuple[tuple[str, ...], ...]:
    """Choices of stations that hold a balancer each; an empty one keeps the balancers of the machine."""
    path = ("candidates", "planes")
    if not values:
        if machine.balancers or machine.rotor.one_plane:
            return ((),)
        raise QuestionError("missing; name the stations that may hold a balancer", path)
    known = [station.name for station in machine.stations]
    choices = tuple((choice,) if isinstance(choice, str) else choice for choice in values)
    for place, name in ((place, name) for place, choice in enumerate(choices) for name in choice if name not in known):
        said = ", ".join(map(repr, known)) or "none"
        raise QuestionError(f"no station is called {name!r}; there are {said}", (*path, place))
    return choices


def _fluids(
    values: tuple[str | tuple[str, ...] | Blend, ...],
) -> tuple[list[tuple[Filling, ...]], tuple[str, str] | None, list[tuple[str, float, float]]]:
    """Choices of fluids; the pair of oils whose blend is searched, with its viscosities at 25 °C."""
    fluids: list[tuple[Filling, ...]] = []
    for place, entry in enumerate(values):
        path = ("candidates", "fluids", place)
        if not isinstance(entry, Blend):
            names = (entry,) if isinstance(entry, str) else entry
            fluids.append(tuple(Filling(known_fluid(name, *path)) for name in names))
            continue
        oils = known_fluid(entry.blend[0], *path), known_fluid(entry.blend[1], *path)
        blends = [(blended(*oils, float(one)),) for one in entry.viscosity]  # refuses what the two cannot make
        if isinstance(entry.viscosity, Range):
            if len(values) > 1:
                raise QuestionError("a blend with 'from' and 'to' stands alone", path)
            return [], oils, [("viscosity", float(entry.viscosity.low), float(entry.viscosity.high))]
        fluids += blends
    return fluids, None, []


# The rotor of a specification from a measured receptance: read, fitted, and refused where it was not measured.


PREFIX = "rotor_"  # of names in the answer of a design


def read_rotor(measured_receptance: MeasuredReceptance, folder: Path) -> MeasuredRotor:
    """Read a measured receptance and fit a rotor to it; paths are seen from ``folder``.

    Raises
    ------
    QuestionError
        With the key at fault; if no rotor has such a receptance, or its lowest mode was not measured.
    ResultError
        If the file cannot be read.
    """
    file = beside(folder, measured_receptance.receptance)
    try:
        measured = load_receptance(
            file, function=measured_receptance.function, mass_added=measured_receptance.mass_added
        )
        rotor = measured_rotor(
            receptance(measured, modes=measured_receptance.modes, band=measured_receptance.band),
            inertia=measured_receptance.inertia,
        )
    except QuestionError as reason:
        raise reason.within("rotor") from None
    low, lowest = float(rotor.fit.attrs["band_low"]), float(rotor.fit["mode_frequency"].values[0])
    if lowest < low:
        raise QuestionError(
            f"the lowest mode, at {hertz(lowest)} Hz, lies below what was measured, from {hertz(low)} Hz on; a run-up passes it, "
            "so measure from lower frequencies on",
            ("rotor", "receptance"),
        )
    return rotor


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


def beyond(fit: Answer, fastest: float) -> Iterator[Problem]:
    """A speed (rad/s) whose frequency was not measured."""
    high = float(fit.attrs["band_high"])
    if fastest > high * (1.0 + 1e-6):
        text = f"{rpm_and_si(fastest)} are {hertz(fastest)} Hz, and the receptance is known up to {hertz(high)} Hz"
        yield ("operation", "speed"), f"contradicts rotor.receptance: {text}; measure further, or run slower"
