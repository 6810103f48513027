"""Restitution that falls with the speed of an impact and in a fluid, in races and in deep chambers."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from tests.references.chamber_machines import free_machine
from tests.references.race_runs import states_from, states_of
from tests.references.standing_races import BOTTOM, DENSITY, DIAMETER, ORBIT, standing

from autobalancer.assembly.system import assemble
from autobalancer.errors import MachineError
from autobalancer.kernels.records import BALL_STATES, BALL_VX, BALL_VY, BALL_X, BALL_Y
from autobalancer.laws.impacts import first_yield, stokes_number, wet_factor, yielding_factor
from autobalancer.machine import Machine
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.simulation.chamber.chamber_run import simulate_chamber

SLOW, YIELDS, CRITICAL = 0.9, 0.05, 10.0
OIL = {"density": 900.0, "viscosity": 1e-4, "virtual_mass": 0.0}  # m^2/s
VISCOSITY = OIL["density"] * OIL["viscosity"]
DRY = {"yield_speed": YIELDS}
WET = {**DRY, "critical_stokes": CRITICAL}
MEASURED = {"speeds": [0.02, 0.07, 0.3], "factors": [1.0, 0.8, 0.5]}
SPEEDS = np.geomspace(1e-3, 1.0, 7)  # m/s
NEAR = 0.01  # of the speed of the impact; what the tables leave open

MASS = DENSITY * math.pi / 6.0 * DIAMETER**3
PAIR = (0.5 * MASS, 0.25 * DIAMETER)  # reduced mass and radius
WALL = (MASS, 0.5 * DIAMETER)


def left(speed: float, rebound: dict[str, Any], body: tuple[float, float]) -> float:
    """Restitution by the formulas of the sources, computed here; a rebound under 1 % counts as that."""
    share = SLOW * min(1.0, (YIELDS / speed) ** 0.25)
    if "critical_stokes" in rebound:
        stokes = body[0] * speed / (6.0 * math.pi * VISCOSITY * body[1] ** 2)
        share *= max(1.0 - CRITICAL / stokes, 0.0)
    return max(share, 0.01)


def _guided(speed: float, rebound: dict[str, Any], **race: Any) -> np.ndarray:
    """Ball speeds along the race after two balls, 0.02 rad from contact, met at this speed."""
    rate = speed / (ORBIT * math.sqrt(1.0 - (0.5 * DIAMETER / ORBIT) ** 2))
    touch = 2.0 * math.asin(0.5 * DIAMETER / ORBIT)
    machine = standing(
        axis="vertical", angles=[0.0, touch + 0.02], speeds=[0.0, -rate], fluid=OIL,
        contact={"restitution": SLOW, "rebound": rebound}, **race,
    )  # fmt: skip
    found = states_of(machine, np.array([0.0, 0.1 / rate]), tolerance=1e-10)[-1]
    return np.asarray(found[8:10] / rate)


@pytest.mark.parametrize("rebound", [DRY, WET])
def test_guided_balls_part_with_the_restitution_of_their_speed(rebound: dict[str, Any]) -> None:
    for speed in SPEEDS:
        after = _guided(speed, rebound)
        assert after[1] - after[0] == pytest.approx(left(speed, rebound, PAIR), abs=NEAR)
        assert after.sum() == pytest.approx(-1.0, rel=1e-8)  # momentum


def test_just_above_the_critical_stokes_number_the_rebound_is_right_within_3_percent_of_the_speed() -> None:
    """Restitution rises steeply there, and a table has its cells; no source knows the critical number so well."""
    least = CRITICAL * 6.0 * math.pi * VISCOSITY * PAIR[1] ** 2 / PAIR[0]
    for speed in (0.9 * least, 1.05 * least, 1.1 * least):
        after = _guided(speed, {"critical_stokes": CRITICAL})
        assert after[1] - after[0] == pytest.approx(max(SLOW * (1.0 - least / speed), 0.01), abs=0.03)


@pytest.mark.parametrize(
    ("speed", "rebound"), [(1.01 * YIELDS, DRY), (2.0 * YIELDS, WET), (0.07, MEASURED), (0.5, MEASURED)]
)
def test_a_rigid_impact_has_the_restitution_of_its_law_also_at_the_corners(
    speed: float, rebound: dict[str, Any]
) -> None:
    """Exactly, as nothing is tabled."""
    if rebound is MEASURED:
        share = SLOW * float(np.interp(speed, MEASURED["speeds"], MEASURED["factors"]))
    else:
        share = left(speed, rebound, PAIR)
    after = _guided(speed, rebound)
    assert after[1] - after[0] == pytest.approx(share, rel=1e-6)


def test_guided_balls_leave_partitions_with_the_restitution_of_their_speed() -> None:
    half = math.asin(0.5 * DIAMETER / ORBIT)
    for speed in SPEEDS:
        rate = speed / (ORBIT * math.cos(half))
        machine = standing(
            axis="vertical", angles=[0.5], speeds=[-rate], fluid=OIL, partitions={"count": 2, "angle": BOTTOM},
            contact={"restitution": SLOW, "rebound": WET},
        )  # fmt: skip
        found = states_of(machine, np.array([0.0, 0.6 / rate]), tolerance=1e-10)[-1]
        assert found[7] / rate == pytest.approx(left(speed, WET, WALL), abs=NEAR)


def _resolved(place: tuple[float, float], speed: float, **stiffness: float) -> Machine:
    """Two balls of a race at rest, that have no friction."""
    law = {"restitution": SLOW, "rebound": WET, "sliding_friction": 0.0, "slip_speed": 1e-3, **stiffness}
    return standing(
        axis="vertical", angles=[place[0], place[1]], speeds=[0.0, -speed / ORBIT], fluid=OIL,
        contact={"restitution": SLOW, "rebound": WET}, resolved=law,
    )  # fmt: skip


@pytest.mark.parametrize("stiffness", [{"stiffness": 1e5}, {"reduced_modulus": 1e9}])
def test_resolved_balls_leave_the_wall_with_the_restitution_of_their_speed(stiffness: dict[str, float]) -> None:
    """One ball flies along a chord and meets the wall; what is left of its speed across the wall counts."""
    for speed in SPEEDS[::2]:
        assembly = assemble(_resolved((0.0, 2.0), 0.0, **stiffness), rotating=False)
        first = assembly.state.size - 2 * BALL_STATES
        own = assembly.state[first:]
        own[[BALL_X, BALL_Y, BALL_VX, BALL_VY]] = ORBIT - 1e-4, 0.0, speed, 0.0
        own[[BALL_STATES + BALL_X, BALL_STATES + BALL_Y]] = -0.5 * ORBIT, 0.0
        end = 3e-4 / speed + 1e-3
        after = states_from(assembly, np.array([0.0, end]), tolerance=1e-10)[-1][first:]
        assert -after[BALL_VX] / speed == pytest.approx(left(speed, WET, WALL), abs=NEAR)
        # and balls that meet in the middle of the race
        own[[BALL_X, BALL_Y, BALL_VX, BALL_VY]] = -1e-4 - 0.5 * DIAMETER, 0.0, 0.5 * speed, 0.0
        own[[BALL_STATES + BALL_X, BALL_STATES + BALL_Y]] = 1e-4 + 0.5 * DIAMETER, 0.0
        own[[BALL_STATES + BALL_VX, BALL_STATES + BALL_VY]] = -0.5 * speed, 0.0
        after = states_from(assembly, np.array([0.0, 6e-4 / speed + 1e-3]), tolerance=1e-10)[-1][first:]
        parting = after[BALL_STATES + BALL_VX] - after[BALL_VX]
        assert parting / speed == pytest.approx(left(speed, WET, PAIR), abs=NEAR)
        assert after[BALL_STATES + BALL_VX] + after[BALL_VX] == pytest.approx(0.0, abs=1e-9 * speed)


def _chamber(law: str, rebound: dict[str, Any], velocities: list[list[float]], **changed: Any) -> ChamberMachine:
    gap = 0.5 * DIAMETER + 2e-5
    balls = {
        "count": 2, "density": DENSITY, "diameter": DIAMETER, "velocities": velocities,
        "positions": [[0.0, -gap, 0.0], [0.0, gap, 0.0]],
    }  # fmt: skip
    wet = {"viscosity": VISCOSITY} if rebound and "critical_stokes" in rebound else {}
    return free_machine(
        body={"freedom": "fixed"},
        chambers=[{"radius": 0.06, "depth": 0.1, "balls": [balls], **wet}],
        contact={"law": law, "restitution": SLOW, "rebound": rebound, "friction": 0.0, "rolling_arm": 0.0, **changed},
    )


@pytest.mark.parametrize("law", ["restitution", "history"])
@pytest.mark.parametrize("rebound", [DRY, WET])
def test_balls_of_a_chamber_part_with_the_restitution_of_their_speed(law: str, rebound: dict[str, Any]) -> None:
    for speed in SPEEDS[::2]:
        machine = _chamber(law, rebound, [[0.0, 0.5 * speed, 0.0], [0.0, -0.5 * speed, 0.0]], stiffness=1e8)
        end = 1.5e-4 / speed + 1e-3
        run = simulate_chamber(machine, duration=end, sample=end)
        velocity = run["ball_velocity"].values[-1]
        assert (velocity[1, 1] - velocity[0, 1]) / speed == pytest.approx(left(speed, rebound, PAIR), abs=NEAR)
        assert np.abs(velocity.sum(axis=0)).max() < 1e-9 * speed
        lost = 0.25 * MASS * (speed**2 - (velocity[1, 1] - velocity[0, 1]) ** 2)
        assert float(run["loss_contact"][-1]) == pytest.approx(lost, rel=1e-3)


def test_balls_of_a_chamber_leave_its_walls_with_the_restitution_of_their_speed() -> None:
    for speed in (0.05, 0.15, 0.6):
        machine = _chamber("history", WET, [[0.0, 0.0, 0.0], [speed, 0.0, 0.0]], stiffness=None, youngs_modulus=1e9)
        run = simulate_chamber(machine, duration=0.05 / speed, sample=0.05 / speed)
        assert -run["ball_velocity"].values[-1, 1, 0] / speed == pytest.approx(left(speed, WET, WALL), abs=NEAR)


@pytest.mark.parametrize("law", ["restitution", "history"])
def test_contacts_never_give_energy_to_balls_that_fly_about(law: str) -> None:
    """Twelve balls in a fixed chamber without weight: nothing but contacts acts, and each takes energy or none."""
    random = np.random.default_rng(2)
    places = [[0.016 * (i % 3 - 1), 0.016 * (i // 3 % 2), 0.016 * (i // 6) - 0.008] for i in range(12)]
    balls = {
        "count": 12, "density": DENSITY, "diameter": DIAMETER, "positions": places,
        "velocities": random.uniform(-2.0, 2.0, (12, 3)).tolist(),
    }  # fmt: skip
    machine = free_machine(
        body={"freedom": "fixed"},
        chambers=[{"radius": 0.03, "depth": 0.06, "viscosity": VISCOSITY, "balls": [balls]}],
        contact={"law": law, "restitution": SLOW, "rebound": WET, "stiffness": 1e8},
    )
    run = simulate_chamber(machine, duration=0.15, sample=1e-3)
    energy = (run["energy_kinetic"] + run["energy_contact"]).values
    losses = run["loss_contact"].values
    assert int(run["contacts_ball"].sum()) > 10
    assert np.diff(energy).max() < 1e-3 * energy[0]  # what the steps leave open, as with constant restitution
    assert losses[-1] > 0.5 * energy[0]
    assert float(np.abs(run["energy_error"]).max()) < 5e-3 * energy[0]


def test_a_rebound_that_changes_nothing_is_the_constant_restitution() -> None:
    never = {"yield_speed": 1e3}
    after = _guided(0.3, never)
    assert after[1] - after[0] == pytest.approx(SLOW, abs=2e-5)
    for law in ("restitution", "history"):
        velocities = [[0.0, 0.2, 0.0], [0.0, -0.2, 0.0]]
        ends = [
            simulate_chamber(machine, duration=2e-3, sample=2e-3)["ball_velocity"].values[-1]
            for machine in (
                _chamber(law, never, velocities, stiffness=1e8),
                _chamber(law, None, velocities, stiffness=1e8),  # type: ignore[arg-type]
            )
        ]
        np.testing.assert_allclose(ends[0], ends[1], atol=2e-5)


def test_the_laws_have_their_limits() -> None:
    assert yielding_factor([0.01, 0.05, 0.8], 0.05) == pytest.approx([1.0, 1.0, 0.5])
    assert wet_factor([5.0, 10.0, 20.0, 1e9], 10.0) == pytest.approx([0.0, 0.0, 0.5, 1.0], abs=1e-7)
    # of a ball at a wall: density, diameter and speed over nine times the viscosity
    assert stokes_number(0.3, MASS, 0.5 * DIAMETER, 0.02) == pytest.approx(DENSITY * DIAMETER * 0.3 / (9.0 * 0.02))
    # Thornton (1997) with his rounded factor
    assert first_yield(1e9, 1.1e11, 7800.0) == pytest.approx(1.56 * math.sqrt(1e45 / (1.1e11**4 * 7800.0)), rel=1e-3)


@pytest.mark.parametrize(
    ("rebound", "message"),
    [
        ({}, r"rebound: says nothing; give 'yield_speed'"),
        ({"yield_speed": 0.1, "speeds": [0.1], "factors": [0.5]}, "give either 'yield_speed' or a table"),
        ({"speeds": [0.1, 0.2], "factors": [0.9]}, "factors: given 1 for 2 speeds"),
        ({"speeds": [0.2, 0.1], "factors": [1.0, 0.9]}, r"speeds\[2\]: given 0.1 m/s after 0.2 m/s"),
        ({"speeds": [0.1, 0.2], "factors": [1.0, 0.4]}, r"factors\[2\]: .* must be more than 0.5"),
        ({"speeds": [0.1, 0.2], "factors": [1.2, 1.0]}, r"factors.*given 1.2; must be greater than 0 and at most 1"),
        ({"critical_stokes": 10.0, "exponent": 0.25}, "exponent: has no effect without 'yield_speed'"),
        ({"critical_stokes": 10.0}, r"contact.rebound.critical_stokes: needs the viscosity of a fluid"),
    ],
)
def test_a_rebound_that_is_not_possible_is_refused_with_the_reason(rebound: dict[str, Any], message: str) -> None:
    with pytest.raises(MachineError, match=message):
        standing(contact={"restitution": 0.5, "rebound": rebound})


def test_what_a_rebound_in_a_fluid_needs_is_named() -> None:
    contact = {"restitution": 0.5, "rebound": {"critical_stokes": 10.0}}
    with pytest.raises(MachineError, match=r"chambers\[1\].viscosity: missing; contact.rebound.critical_stokes"):
        free_machine(contact=contact)
    chamber = {"radius": 0.06, "viscosity": 0.1, "balls": [{"count": 2, "density": 7800.0, "mass": 0.1}]}
    with pytest.raises(MachineError, match=r"chambers\[1\].viscosity: has no effect without"):
        free_machine(chambers=[chamber])
    with pytest.raises(MachineError, match="rebound: changes the 'restitution' of the walls"):
        standing(resolved={
            "stiffness": 1e5, "damping": 10.0, "rebound": DRY, "sliding_friction": 0.1, "slip_speed": 1e-3,
        })  # fmt: skip
    rollers = [{"count": 2, "body": "roller", "diameter": 0.01, "length": 0.01, "density": 7800.0}]
    with pytest.raises(MachineError, match="is known for balls only"):
        standing(fluid=OIL, contact=contact, balls=rollers)


def test_a_chamber_with_a_rebound_goes_on_to_the_last_bit_and_another_scheme_agrees() -> None:
    machine = _chamber("restitution", WET, [[0.0, 0.4, 0.0], [0.0, -0.4, 0.0]], stiffness=1e8)
    kept: list[Any] = []
    ends = 4e-4, 2e-3
    simulate_chamber(machine, duration=ends[0], sample=1e-4, chunk=1, on_chunk=lambda _, point: kept.append(point))
    resumed = simulate_chamber(machine, duration=ends[1], sample=1e-4, resume=kept[-1])
    whole = simulate_chamber(machine, duration=ends[1], sample=1e-4)
    np.testing.assert_array_equal(resumed["ball_velocity"].values[-1], whole["ball_velocity"].values[-1])
    classical = simulate_chamber(machine, duration=ends[1], sample=1e-4, method="runge_kutta")
    after = classical["ball_velocity"].values[-1, :, 1]
    assert (after[1] - after[0]) / 0.8 == pytest.approx(left(0.8, WET, PAIR), abs=NEAR)
