"""A member of an ensemble has the bits of its single run, on any rotor and number of threads, or nearly so if it says so."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from tests.test_ensembles import TOLERANCE, TWO_PLANES, alone, same
from tests.test_places import SHAFT

import autobalancer as ab
from autobalancer.assembly.system import Model
from autobalancer.files.examples import rig
from autobalancer.files.machine_file import load_race_machine
from autobalancer.kernels.system import BALLS, SPEED
from autobalancer.machine import Machine
from autobalancer.simulation.fluid_lag import prepare
from autobalancer.studies.ensemble.columns import columns_of
from autobalancer.studies.ensemble.layout import Plan
from autobalancer.studies.ensemble.members import Members, without_start_angles

RACE = "balancers[1].races[1]"
ROUGH: dict[str, Any] = {
    f"{RACE}.balls": [{"count": 2, "diameter": "7 mm", "density": 7800.0, "motion": "rolling"}],
    f"{RACE}.friction": {"rolling_resistance": 1e-4, "adherence": 2e-4},
}
CURVED: dict[str, Any] = {
    f"{RACE}.balls[1].diameter": "7 mm",
    f"{RACE}.fluid": {"density": 950.0, "viscosity": "20 mm^2/s"},
    f"{RACE}.drag": {"law": "discoidal"},
}
TILTING = {"tilting_races": "full"}


def shaft(**changes: Any) -> Machine:
    """A shaft with two balancers on unlike supports, started at speed."""
    machine = ab.parse_machine(SHAFT)
    fast = {"kind": "speed", "profile": {"kind": "ramp", "start": 200.0, "end": 300.0, "duration": 1.0}}
    return _changed(ab.with_parameter(machine, "drive", fast), changes)


def multibody(**changes: Any) -> Machine:
    """A published rig of several bodies, at speed from the start."""
    fast = {"kind": "speed", "profile": {"kind": "constant", "speed": "900 rpm"}}
    return _changed(ab.with_parameter(rig("discoidal_rig"), "drive", fast), changes)


def _changed(machine: Machine, changes: dict[str, Any]) -> Machine:
    for name, value in changes.items():
        machine = ab.with_parameter(machine, name, value)
    return machine


SIZES, ANGLES, OILS = [7e-3, 7.1e-3, 7.2e-3], [0.1, 0.2, 0.3], [1e-5, 2e-5, 3e-5]
RUBBING = {f"{RACE}.friction": ROUGH[f"{RACE}.friction"]}
CASES: dict[str, tuple[Callable[..., Machine], dict[str, Any], Model, float]] = {
    "shaft": (shaft, {}, Model.GUIDED, 0.1),
    "shaft, races that tilt": (shaft, TILTING, Model.TILTING, 0.1),
    "shaft, friction": (shaft, ROUGH, Model.ROUGH, 0.1),
    "shaft, a drag curve on races that tilt": (shaft, CURVED | TILTING, Model.ROUGH_TILTING, 0.1),
    "bodies": (multibody, {}, Model.GUIDED, 0.2),
    "bodies, friction on races that tilt": (multibody, RUBBING | TILTING, Model.ROUGH_TILTING, 0.2),
}


def _members_are_their_runs(case: str, end: float) -> None:
    make, changes, model, _ = CASES[case]
    machine, angles = make(**changes), [0.1, 0.7, 2.0]
    assert prepare(machine, end).model is model
    one, two = (
        ab.ensemble(
            machine, {"unbalances[1].angle": angles}, duration=end, tolerance=TOLERANCE, bins=20, keep_states=True,
            workers=workers,
        )
        for workers in (1, 2)
    )  # fmt: skip
    for name in one.data_vars:
        assert one[name].equals(two[name]), name
    for number in (1, 2):
        same(one, number, alone(ab.with_parameter(machine, "unbalances[1].angle", angles[number]), end=end))


@pytest.mark.parametrize("case", [case for case in CASES if "," in case])
def test_a_member_has_the_bits_of_its_run_and_two_threads_those_of_one(case: str) -> None:
    _members_are_their_runs(case, CASES[case][3])


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_a_longer_member_has_the_bits_of_its_run_too(case: str) -> None:
    _members_are_their_runs(case, 10.0 * CASES[case][3])


@pytest.mark.parametrize(
    ("case", "columns"),
    [
        ("shaft", {"unbalances[2].moment": [2e-5, 3e-5, 4e-5], "ball_mass": [1e-3, 1.5e-3, 2e-3]}),
        ("shaft, friction", {"rotor.supports[2].damping": [20.0, 25.0, 30.0], f"{RACE}.balls[1].diameter": SIZES}),
        ("shaft, a drag curve on races that tilt", {f"{RACE}.fluid.viscosity": OILS, "unbalances[1].angle": ANGLES}),
        ("bodies", {"temperature": ["15 degC", "20 degC", "25 degC"], "rotor.bodies[1].mass": [4.1, 4.2, 4.3]}),
        ("bodies, friction on races that tilt", {f"{RACE}.eccentricity": [0.0, 1e-5, 2e-5]}),
    ],
)  # fmt: skip
def test_members_on_rotors_that_bend_have_the_words_of_an_assembly(case: str, columns: dict[str, Any]) -> None:
    machine = CASES[case][0](**CASES[case][1])
    asked = Members(machine, columns_of(machine, columns), np.arange(2), 0, "member")
    blocks = []
    for quick in (True, False):
        blocks.append(np.zeros((6, 0)))
        for group in asked._sorted(Plan(0.1, 1e-6, 20, 100), "refuse", follow=quick)[0].all:
            words = group.words(range(len(group.numbers)), places := group.places())
            found = np.tile(group.fresh, (len(group.numbers), 1))
            found[:, places] = words
            blocks[-1] = found if not blocks[-1].size else np.concatenate([blocks[-1], found])
    assert np.array_equal(*blocks)


def test_members_between_assembled_ones_move_as_their_single_runs_do() -> None:
    """Their numbers are smooth functions of the mass and known to within the tolerance; so are their motions."""
    masses, number = np.linspace(4.07, 4.13, 60), 41
    found = ab.ensemble(
        multibody(),
        {"rotor.bodies[1].mass": masses},
        seeds=2,
        duration=0.1,
        tolerance=TOLERANCE,
        bins=20,
        keep_states=True,
    )
    assert found.attrs["interpolated_members"] == 118  # the first row follows itself
    assert found.attrs["interpolation_error"] <= TOLERANCE
    text = next(text for text in found.remarks() if text.startswith("interpolated: 118 of 120 members"))
    assert f"within {found.attrs['interpolation_error']:.1e}" in text
    machine = ab.with_parameter(without_start_angles(multibody()), "rotor.bodies[1].mass", masses[number])
    run = alone(machine, seed=1, end=0.1)
    member, end = 2 * number + 1, run["envelope_ball_angle_in_rotor"].values[-1]
    assert found["final_state"].values[member][BALLS : BALLS + end.size] == pytest.approx(end, abs=10.0 * TOLERANCE)
    assert float(found["peak_deflection"][member]) == pytest.approx(
        float(ab.run_measures(run)["peak_deflection"]), rel=1e-5
    )


def test_members_with_other_meshes_are_no_smooth_functions_and_have_the_words_of_an_assembly() -> None:
    """A disk that is moved along a shaft takes a node with it, past others."""
    columns = {"rotor.disks[1].position": np.linspace(0.09, 0.11, 60)}
    asked = Members(shaft(), columns_of(shaft(), columns), None, 0, "member")
    groups, _ = asked.sorted(Plan(0.1, 1e-6, 20, 100), "refuse", interpolate=True)
    assert (groups.interpolated, sum(len(group.numbers) for group in groups.all)) == (0, 60)


def test_members_at_other_speeds_lie_between_assembled_ones_too() -> None:
    """A rigid rotor has the same modes at any speed, so what a speed changes is smooth."""
    columns = {"drive.profile.speed": np.linspace(410.0, 415.0, 60)}
    machine = load_race_machine(TWO_PLANES)
    asked = Members(machine, columns_of(machine, columns), None, 0, "member")
    groups, _ = asked.sorted(Plan(0.1, 1e-6, 20, 100), "refuse", interpolate=True)
    (group,) = groups.all
    assert (groups.interpolated, len(group.numbers)) == (59, 60)
    start = group.layout.place("memory.state", SPEED)
    words = group.words(range(60), places := group.places())
    assert words[:, np.searchsorted(places, start)].view(float) == pytest.approx(
        columns["drive.profile.speed"][group.numbers]
    )
