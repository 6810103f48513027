"""The shape of a run-up as something that varies: rate, dwell, a temporary reduction of the speed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from autobalancer.assembly.parameters import with_value_at
from autobalancer.assembly.profile import corners
from autobalancer.errors import QuestionError
from autobalancer.machine import Machine, Reduction
from autobalancer.machine.part import unknown_key
from autobalancer.studies.study.spec import Study
from autobalancer.studies.variations import with_variation
from autobalancer.units import argument, shortened

RUN_UP = "run_up"
UNITS = {
    "speed": "rad/s",  # of operation
    "rate": "rad/s^2",
    "dwell_speed": "rad/s",
    "dwell": "s",
    "before_reduction": "s",
    "reduced": "rad/s",
    "reduced_for": "s",
}
OF_PROFILE = {
    "speed": "end",
    "rate": "acceleration",
    "dwell_speed": "dwell",
    "dwell": "hold_dwell",
    "before_reduction": "hold_peak",
    "reduced": "reduced",
    "reduced_for": "hold_reduced",
}
SHAPES = {
    "drive.profile.end & drive.profile.peak": "rotor speed",
    "drive.profile.acceleration": "rate of the run-up",
    "drive.profile.dwell": "speed of the dwell on the way up",
    "drive.profile.hold_dwell": "time of this dwell",
    "drive.profile.hold_peak": "time before the reduction",
    "drive.profile.reduced": "speed to which it is reduced",
    "drive.profile.hold_reduced": "time at the reduced speed",
}
EXAMPLE = '{ speed = "1200 rpm", rate = "20 rpm/s", reduced = "700 rpm", reduced_for = "10 s" }'


def with_run_up(machine: Machine, given: Any) -> tuple[Machine, dict[str, str]]:
    """A machine that is run up in this way, from the table of a study file; names under 'vary' with their paths.

    Raises
    ------
    QuestionError
        With the key at fault.
    MachineError
        If there can be no such run-up.
    """
    if not isinstance(given, Mapping):
        raise QuestionError(f"{RUN_UP}: given {shortened(given)}; must be a table, such as {EXAMPLE}")
    for key in given:
        if key not in UNITS:
            raise QuestionError(f"{RUN_UP}.{key}: {unknown_key(key, [*UNITS])}")
    for key in ("speed", "rate"):
        if key not in given:
            raise QuestionError(f"{RUN_UP}.{key}: missing; write {RUN_UP} = {EXAMPLE}")
    values = {key: argument(f"{RUN_UP}.{key}", given[key], UNITS[key]) for key in given}
    shape = {OF_PROFILE[key]: value for key, value in values.items()}
    profile = {"kind": "reduction", "peak": values["speed"], "reduced": values["speed"], **shape}
    machine = with_value_at(machine, "drive", {"kind": "speed", "profile": profile})
    paths = {key: f"drive.profile.{name}" for key, name in OF_PROFILE.items()}
    paths["speed"] = "drive.profile.end & drive.profile.peak"
    return machine, paths


def check_length(study: Study) -> None:
    """Refuse a study that ends before one of its run-ups does.

    Raises
    ------
    QuestionError
        With the duration that is needed.
    """
    longest = 0.0
    for point in study.points:
        own = {name: value for name, value in zip(study.grid, point, strict=True) if name.startswith("drive.")}
        machine = with_variation(study.machine, own, tuple(own.values()))
        profile = machine.drive.profile  # type: ignore[union-attr]
        assert isinstance(profile, Reduction)
        longest = max(longest, corners(profile)[-1][0])
    if longest >= study.duration:
        raise QuestionError(
            f"duration: the run-up takes up to {longest:.4g} s, and runs end after {study.duration:.4g} s; give a longer "
            "duration, so that the balls have time at the last speed"
        )
