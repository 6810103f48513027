"""The general equations against the Lagrangian of a rigid rotor in space."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.references.spatial import Spatial, joined, split
from tests.references.spatial_machines import rates, states_of, tilting, turned

from autobalancer.assembly.system import assemble
from autobalancer.machine import Machine

RAMP = {"kind": "speed", "profile": {"kind": "ramp", "start": 100.0, "end": 320.0, "duration": 0.8}}
TORQUE = {"kind": "torque", "torque": 8.0, "damping": 2e-3}
DRIVES = {"ramp": RAMP, "torque": TORQUE}
CASES = [
    (races, axis, drive)
    for races in ("deflection", "full")
    for axis in ("vertical", "horizontal")
    for drive in ("ramp", "torque")
]
RUNS = (CASES[0], CASES[3], CASES[5], CASES[6])  # each pair of race, axis and drive once
every_case = pytest.mark.parametrize(("races", "axis", "drive"), CASES)


def random_place(random: np.random.Generator, speed: float) -> tuple[np.ndarray, np.ndarray]:
    """q and q' of a rotor with four balls, far from rest: slopes of a hundredth."""
    lateral = np.array([1e-3, 1e-2] * 2)
    q = np.concatenate([random.normal(size=4) * lateral, random.uniform(-4.0, 4.0, 5)])
    v = np.concatenate([random.normal(size=4) * 100.0 * lateral, [speed], random.normal(size=4) * 60.0])
    return q, v


@every_case
@pytest.mark.parametrize("isotropic", [True, False])
def test_accelerations_are_those_of_the_lagrangian_in_space(races: Any, axis: str, drive: str, isotropic: bool) -> None:
    machine = tilting(isotropic=isotropic, axis=axis, tilting_races=races, drive=DRIVES[drive])
    reference, assembly = Spatial(machine), assemble(machine, rotating=False)
    random = np.random.default_rng(5)
    for _ in range(5):
        q, v = random_place(random, 100.0 + 220.0 * 0.3 / 0.8)
        found = split(machine, rates(assembly, 0.3, joined(machine, q, v))[None])[0]
        expected = reference.accelerations(0.3, q, v)
        np.testing.assert_allclose(found[0], v, rtol=1e-12)
        for group in ([0, 2], [1, 3], [4], [5, 6, 7, 8]):
            scale = np.abs(expected[group]).max()
            np.testing.assert_allclose(found[1][group], expected[group], rtol=0.0, atol=1e-12 * scale)


@pytest.mark.parametrize("races", ["deflection", "full"])
@pytest.mark.parametrize("drive", DRIVES)
def test_axes_of_the_rotor_and_axes_at_rest_show_the_same_accelerations(races: str, drive: str) -> None:
    machine = tilting(isotropic=True, tilting_races=races, drive=DRIVES[drive])
    still, turning = assemble(machine, rotating=False), assemble(machine, rotating=True)
    assert turning.system.rotating == 1.0
    q, v = random_place(np.random.default_rng(6), 182.5)
    state = joined(machine, q, v)
    own = turned(state, 4, -1.0)
    # move a little along the derivative in either frame and look from the same axes
    step, there = 1e-6, rates(turning, 0.3, own)
    ahead, behind = turned(own + step * there, 4), turned(own - step * there, 4)
    expected, scale = rates(still, 0.3, state), np.abs(rates(still, 0.3, state)).max()
    np.testing.assert_allclose((ahead - behind) / (2.0 * step), expected, rtol=1e-6, atol=1e-9 * scale)


def moves(machine: Machine, duration: float) -> tuple[np.ndarray, np.ndarray]:
    times = np.linspace(0.0, duration, 41)
    return split(machine, states_of(machine, times)), Spatial(machine).run(times)


def assert_same_moves(ours: np.ndarray, theirs: np.ndarray, tolerance: float) -> None:
    for level in range(2):
        for group in ([0, 2], [1, 3], [4], [5, 6, 7, 8]):
            scale = np.abs(theirs[:, level, group]).max()
            np.testing.assert_allclose(ours[:, level, group], theirs[:, level, group], rtol=0.0, atol=tolerance * scale)


@pytest.mark.parametrize(
    ("races", "axis", "drive"),
    [pytest.param(*case, marks=pytest.mark.slow if number % 2 else ()) for number, case in enumerate(RUNS)],
)
def test_a_run_up_with_balls_at_two_stations_is_that_of_the_lagrangian(races: str, axis: str, drive: str) -> None:
    """Unequal supports, static and couple unbalance, unequal balls, one race off center: through both criticals."""
    machine = tilting(axis=axis, tilting_races=races, drive=DRIVES[drive])
    ours, theirs = moves(machine, 0.8)
    assert theirs[-1, 1, 4] > 270.0
    assert np.ptp(theirs[:, 0, 5:], axis=0).min() > 1.0  # the balls travel
    assert_same_moves(ours, theirs, 1e-7)


@pytest.mark.slow
@pytest.mark.parametrize("races", ["deflection", "full"])
def test_a_run_up_in_axes_of_the_rotor_is_that_of_the_lagrangian(races: str) -> None:
    machine = tilting(isotropic=True, tilting_races=races, drive=TORQUE)
    assert assemble(machine).system.rotating == 1.0
    assert_same_moves(*moves(machine, 0.8), 1e-7)


@pytest.mark.parametrize("drive", DRIVES)
def test_a_couple_that_grows_and_a_blade_that_is_lost_move_the_rotor_as_the_lagrangian_says(drive: str) -> None:
    unbalances = [
        {"moment": 4e-4, "angle": 0.4, "station": "upper", "schedule": {"time": [0.2, 0.2], "factor": [1.0, 0.3]}},
        {"couple": 6e-5, "angle": 2.0, "schedule": {"time": [0.1, 0.35], "factor": [0.0, 2.0]}},
        {"misalignment": 1e-3, "angle": -1.0},
    ]
    machine = tilting(unbalances=unbalances, drive=DRIVES[drive])
    times = np.linspace(0.0, 0.5, 26)
    ours = split(machine, states_of(machine, times))
    assert_same_moves(ours, Spatial(machine).run(times, corners=[0.1, 0.2, 0.35]), 1e-7)


@pytest.mark.slow
def test_tables_over_the_speed_move_the_rotor_as_the_lagrangian_with_interpolated_supports_says() -> None:
    rotor = tilting().rotor.model_dump(exclude_unset=True)
    rotor["supports"] = [
        rotor["supports"][0],
        {
            "position": 0.15,
            "table": {
                "speed": [50.0, 180.0, 400.0],
                "stiffness": [5e4, (9e4, 7e4), 1.5e5],
                "damping": [40.0, 20.0, 10.0],
            },
        },
    ]
    machine = tilting(rotor=rotor, drive=RAMP)
    times = np.linspace(0.0, 0.8, 41)
    corner = 0.8 * (180.0 - 100.0) / 220.0
    assert_same_moves(split(machine, states_of(machine, times)), Spatial(machine).run(times, corners=[corner]), 1e-7)


@pytest.mark.parametrize("races", ["deflection", "full"])
def test_the_mass_matrix_behind_the_equations_is_symmetric_and_positive(races: str) -> None:
    """Unit forces cannot be applied to compiled equations, but springs, drag and torque can be changed: accelerations
    change by M^-1 times the change of force, one column after the other.
    """
    machine = tilting(tilting_races=races, drive=TORQUE)
    q, v = random_place(np.random.default_rng(7), 200.0)
    state, columns = joined(machine, q, v), []
    assembly = assemble(machine, rotating=False)
    base = split(machine, rates(assembly, 0.0, state)[None])[0, 1]
    rotor = machine.rotor
    assert rotor.kind == "rigid"
    # across and tilting: a support at the mass center and a tilt spring, in x or y
    for direction in range(2):
        for kind in range(2):
            here = float(rotor.supports[0].position)
            pair = [1e-9, 1e-9]  # a spring along one direction only, nearly
            pair[direction] = 1e4
            place = here if kind else 0.0
            more = rotor.model_copy(
                update={
                    "supports": (
                        *rotor.supports,
                        rotor.supports[0].model_validate({"position": place, "stiffness": pair}),
                    )
                }
            )
            changed = assemble(machine.model_copy(update={"rotor": more}), rotating=False)
            other = machine.model_copy(update={"rotor": more})
            rate = split(other, rates(changed, 0.0, joined(other, q, v))[None])[0, 1] - base
            force = np.zeros(9)
            force[[2 * direction, 2 * direction + 1]] = 1.0, place
            columns.append((force, -rate / (1e4 * (q[2 * direction] + place * q[2 * direction + 1]))))
    drive = machine.drive.model_copy(update={"torque": machine.drive.torque + 1.0})  # type: ignore[union-attr]
    changed = assemble(machine.model_copy(update={"drive": drive}), rotating=False)
    columns.append((np.eye(9)[4], split(machine, rates(changed, 0.0, state)[None])[0, 1] - base))
    for i in range(4):
        changed = assemble(machine, rotating=False)
        changed.system.balls[i].drag += 1e-3
        rate = split(machine, rates(changed, 0.0, state)[None])[0, 1] - base
        columns.append((np.eye(9)[5 + i], -rate / (1e-3 * v[5 + i])))
    forces, answers = (np.array(rows) for rows in zip(*columns, strict=True))
    inverse = np.linalg.solve(forces, answers)
    scale = np.sqrt(np.outer(np.diag(inverse), np.diag(inverse)))
    np.testing.assert_allclose(inverse / scale, inverse.T / scale, rtol=0.0, atol=1e-8)
    assert np.linalg.eigvalsh(0.5 * (inverse + inverse.T) / scale)[0] > 0.0
    np.testing.assert_allclose(np.linalg.inv(inverse), Spatial(machine).parts(0.0, q, v)[0], rtol=0.0, atol=1e-7)
