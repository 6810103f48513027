"""Several chambers on one rotor, several sizes of balls in one chamber, rings."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.spatial.distance import pdist
from tests.references.chamber_machines import SUPPORT, free_machine, small_machine

from autobalancer.assembly.chamber_assembly import wall_stiffness
from autobalancer.errors import MachineError, QuestionError
from autobalancer.laws.impacts import hertz_stiffness
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.results.chamber_measures import balls_unbalance, chamber_measures
from autobalancer.simulation.chamber import simulate_chamber
from autobalancer.simulation.chamber.bounds import fill

PLACES = [[0.0, 0.05, 0.03], [0.0, -0.06, -0.02], [0.0, 0.01, -0.07]]
DOWN = {"gravity": [0.0, 0.0, -9.81]}
FIXED = {"body": {"freedom": "fixed"}}


def group(count: int, diameter: float, **given: Any) -> dict[str, Any]:
    return {"count": count, "density": 7800.0, "diameter": diameter} | given


def legs(**changed: Any) -> list[dict[str, Any]]:
    """Four supports in the plane of the rotor, alike at both ends."""
    return [{"position": [x, y, 0.0], **SUPPORT, **changed} for x in (0.3, -0.3) for y in (0.4, -0.4)]


def test_two_equal_chambers_at_equal_distances_move_the_body_without_tilting_it() -> None:
    balls = group(3, 0.03, positions=PLACES)
    pair = [{"radius": 0.1, "depth": 0.05, "position": x, "balls": [balls]} for x in (0.12, -0.12)]
    released = {"freedom": "free", "mass": 110.0, "inertia": [20.0, 25.0, 20.0]}
    run = simulate_chamber(small_machine(body=released, supports=legs(), chambers=pair), duration=0.3)
    assert run["chamber"].values.tolist() == [1, 1, 1, 2, 2, 2]
    assert int(run.contacts_wall.sum()) > 20
    assert float(np.abs(run.body_position[:, 1:]).max()) > 1e-4
    assert float(np.abs(run.body_rotation[:, 1:]).max()) < 1e-12
    assert float(np.abs(run.body_position[:, 0]).max()) < 1e-12
    one, two = run.ball_position.values[:, :3], run.ball_position.values[:, 3:]
    np.testing.assert_allclose(one, two, atol=1e-9)
    left, right = run.bearing_force.values[:, 0, 1:], run.bearing_force.values[:, 1, 1:]
    np.testing.assert_allclose(left, right, atol=1e-6 * np.abs(left).max())


def test_in_planar_motion_two_chambers_are_one_long_chamber_with_balls_at_the_same_places() -> None:
    apart = [
        {"radius": 0.1, "depth": 0.05, "position": x, "balls": [group(3, 0.03, positions=PLACES)]}
        for x in (0.12, -0.12)
    ]
    shifted = [[[x, y, z] for _, y, z in PLACES] for x in (0.12, -0.12)]
    merged = [{"radius": 0.1, "depth": 0.3, "balls": [group(3, 0.03, positions=places) for places in shifted]}]
    two, one = (simulate_chamber(small_machine(chambers=c), duration=0.3) for c in (apart, merged))
    assert int(one.contacts_ball.sum()) > 0
    assert one["chamber"].values.tolist() == [1] * 6
    for name in ("body_position", "body_rotation", "rotor_angle", "energy_kinetic", "loss_friction", "bearing_force"):
        np.testing.assert_array_equal(one[name].values, two[name].values, err_msg=name)
    shift = np.array([[0.12, 0.0, 0.0]] * 3 + [[-0.12, 0.0, 0.0]] * 3)
    np.testing.assert_allclose(one.ball_position.values, two.ball_position.values + shift, atol=1e-15)


def test_balls_of_different_sizes_collide_with_the_restitution_and_keep_all_momenta() -> None:
    large, small = 0.04, 0.01
    gap = 0.5 * (large + small) + 1e-4
    balls = [
        group(1, large, positions=[[0, 0, 0]], velocities=[[0, 0.3, 0]], spins=[[20.0, 40.0, -10.0]]),
        group(1, small, positions=[[0, gap, 0]], velocities=[[0, -2.0, 0]], spins=[[-300.0, 50.0, 80.0]]),
    ]
    machine = free_machine(**FIXED, chambers=[{"radius": 0.1, "depth": 0.2, "balls": balls}])
    run = simulate_chamber(machine, duration=1.2e-3, sample=4e-4)
    mass, radius = run.ball_mass.values[:, None], run.ball_radius.values[:, None]
    place, velocity, spin = (run[name].values for name in ("ball_position", "ball_velocity", "ball_spin"))
    assert mass[0] / mass[1] == pytest.approx(64.0)
    assert int(run.contacts_ball.sum()) == 1
    assert velocity[-1, 1, 1] - velocity[-1, 0, 1] == pytest.approx(0.6 * 2.3, rel=0.005)
    total = (mass * velocity).sum(axis=1)
    np.testing.assert_allclose(total, np.tile(total[0], (len(total), 1)), atol=1e-13 * np.abs(total).max())
    turning = (mass * np.cross(place, velocity) + 0.4 * mass * radius**2 * spin).sum(axis=1)
    np.testing.assert_allclose(turning, np.tile(turning[0], (len(turning), 1)), atol=1e-9 * np.abs(turning).max())
    assert np.abs(spin[-1] - spin[0]).min() < np.abs(spin[-1] - spin[0]).max()


def mixed(**changed: Any) -> ChamberMachine:
    """Two chambers, a ring and one with balls of three sizes, more of them than pairs are looked at one by one."""
    chambers = [
        {"radius": 0.08, "depth": 0.06, "position": 0.1, "balls": [group(60, 0.01), group(6, 0.02), group(50, 0.008)]},
        {"radius": 0.1, "inner_radius": 0.07, "depth": 0.03, "position": -0.1, "balls": [group(8, 0.025)]},
    ]
    body = {"freedom": "free", "mass": 110.0, "inertia": [20.0, 25.0, 20.0]}
    soft = {"law": "restitution", "restitution": 0.54, "friction": 0.5, "rolling_arm": 2e-5, "stiffness": 1e7}
    return small_machine(**({"chambers": chambers, "body": body, "contact": soft} | changed))


def test_mixed_chambers_resume_to_the_same_bits_and_keep_their_account() -> None:
    held: list[Any] = []
    machine = mixed()
    whole = simulate_chamber(machine, duration=0.06, chunk=30, on_chunk=lambda part, state: held.append(state))
    later = simulate_chamber(machine, duration=0.06, resume=held[0])
    for name in whole.data_vars:
        np.testing.assert_array_equal(whole[name].values[31:], later[name].values, err_msg=str(name))
    assert whole["chamber"].values.tolist() == [1] * 116 + [2] * 8
    assert np.unique(whole.ball_radius.values).round(9).tolist() == [0.004, 0.005, 0.01, 0.0125]
    exchanged = float(whole.work_motor[-1])
    assert float(np.abs(whole.energy_error).max()) < 1e-3 * exchanged
    across = np.hypot(whole.ball_position.values[:, 116:, 1], whole.ball_position.values[:, 116:, 2])
    assert across.min() > 0.07 + 0.0125 - 1e-4
    assert across.max() < 0.1 - 0.0125 + 1e-4
    wider = [chamber.model_dump() for chamber in machine.chambers]
    wider[1]["inner_radius"] = 0.06
    for other in (mixed(unbalances=[{"moment": 0.01}]), mixed(chambers=wider), mixed(supports=[])):
        with pytest.raises(QuestionError, match="another machine"):
            simulate_chamber(other, duration=0.06, resume=held[0])


def test_filled_balls_of_all_sizes_stand_clear_of_each_other_and_settle() -> None:
    for machine in (mixed(), small_machine(chambers=[{"radius": 0.1, "balls": [group(20, 0.02)]}])):
        places, settles = fill(machine, 3)
        assert settles
        begin = 0
        for chamber in machine.chambers:
            radii = np.concatenate([np.full(balls.count, balls.radius) for balls in chamber.balls])
            own = places[begin : begin + len(radii)]
            begin += len(radii)
            reach = [one + two for i, one in enumerate(radii) for two in radii[i + 1 :]]
            assert (pdist(own) > reach).all()
            assert (np.abs(own[:, 0]) + radii <= 0.5 * chamber.inner_depth * (1.0 + 1e-12)).all()
            across = np.hypot(own[:, 1], own[:, 2])
            assert (across + radii <= chamber.radius * (1.0 + 1e-12)).all()
            assert (across - radii >= chamber.inner_radius * (1.0 - 1e-12)).all() or chamber.inner_radius == 0.0
    still = mixed(**FIXED, drive={"kind": "speed", "profile": {"kind": "constant", "speed": 0.0}})
    run = simulate_chamber(still, duration=0.05, sample=0.05)
    assert run.constraint_force.values[-1, 2] == pytest.approx(9.80665 * float(run.ball_mass.sum()), rel=0.02)


def test_a_filling_that_does_not_fit_is_refused_with_the_largest_number_that_does() -> None:
    def filled(large: int, small: int, **shape: Any) -> None:
        chamber = {"radius": 0.05, "depth": 0.06} | shape
        balls = [group(small, 0.009), *([group(large, 0.03)] if large else [])]
        fill(
            small_machine(
                chambers=[{"radius": 0.1, "depth": 0.1, "balls": [group(2, 0.01)]}, chamber | {"balls": balls}]
            )
        )

    for large, shape in ((3, {}), (0, {}), (0, {"inner_radius": 0.04}), (0, {"depth": None})):
        with pytest.raises(MachineError, match=r"chambers\[2\].*9 mm do not fit.*at most \d+ do") as refused:
            filled(large, 3000, **shape)
        most = int(str(refused.value).split("at most ")[1].split(" ")[0])
        assert most > 20
        filled(large, most, **shape)
        with pytest.raises(MachineError, match=f"at most {most} do"):
            filled(large, most + 1, **shape)
    with pytest.raises(
        MachineError, match=r"chambers\[2\]\.balls\[2\]: 40 balls of 30 mm do not fit .* beside the others"
    ):
        filled(40, 10)


def test_a_ring_takes_as_many_balls_as_stand_around_it() -> None:
    ring = small_machine(chambers=[{"radius": 0.1, "inner_radius": 0.079, "balls": [group(27, 0.02)]}])
    places, _ = fill(ring)
    across = np.hypot(places[:, 1], places[:, 2])
    assert across == pytest.approx(np.full(27, 0.09), abs=2e-4)
    with pytest.raises(MachineError, match=r"radius 79 to 100 mm and depth 20\.2 mm; at most 28 do"):
        fill(small_machine(chambers=[{"radius": 0.1, "inner_radius": 0.079, "balls": [group(29, 0.02)]}]))
    with pytest.raises(MachineError, match="the ring is only 15 mm wide, from inner_radius to radius"):
        small_machine(chambers=[{"radius": 0.1, "inner_radius": 0.085, "balls": [group(2, 0.02)]}])
    inside = [group(1, 0.02, positions=[[0, 0, -0.06]])]
    with pytest.raises(MachineError, match="ball 1 stands in the wall"):
        fill(small_machine(chambers=[{"radius": 0.1, "inner_radius": 0.079, "balls": inside}]))


@pytest.mark.parametrize("law", ["restitution", "history"])
def test_a_ball_rebounds_from_the_inner_wall_and_takes_up_its_turning(law: str) -> None:
    ball = group(1, 0.02, positions=[[0, 0.08, 0]], velocities=[[0, -2.0, 0]])
    ring = [{"radius": 0.1, "inner_radius": 0.06, "depth": 0.05, "balls": [ball]}]
    drive = {"kind": "speed", "profile": {"kind": "constant", "speed": 50.0}}
    contact = {"law": law, "friction": 5.0, "rolling_arm": 0.0, "restitution": 0.8, "slip_speed": 1e-4}
    run = simulate_chamber(
        free_machine(**FIXED, chambers=ring, drive=drive, contact=contact), duration=0.012, sample=0.012
    )
    velocity, spin = run.ball_velocity.values[-1, 0], run.ball_spin.values[-1, 0]
    assert int(run.contacts_wall.sum()) == 1
    assert velocity[1] == pytest.approx(0.8 * 2.0, rel=0.03 if law == "history" else 0.005)
    if law == "restitution":  # it leaves rolling: 2/7 of the speed of the wall, and the spin that goes with it
        assert velocity[2] == pytest.approx(2.0 / 7.0 * 50.0 * 0.06, rel=0.02)
        assert spin[0] == pytest.approx(-(50.0 * 0.06 - velocity[2]) / 0.01, rel=0.02)


def test_the_inner_wall_is_softer_than_a_flat_one_by_hertz() -> None:
    contact = mixed(contact={"law": "history", "restitution": 0.5, "friction": 0.3, "youngs_modulus": 2e11}).contact
    around = wall_stiffness(contact, 0.01, -0.05)
    assert around == hertz_stiffness(2e11 / (2.0 * 0.91), 0.01, -0.05)
    assert around < wall_stiffness(contact, 0.01) < wall_stiffness(contact, 0.01, 0.1)


def test_measures_count_the_couple_of_balls_in_both_chambers() -> None:
    turning = {
        "drive": {"kind": "speed", "profile": {"kind": "constant", "speed": 200.0}},
        **FIXED,
        "gravity": [0.0, 0.0, 0.0],
    }
    reach = 0.1 - 0.015
    pair = [
        {"radius": 0.1, "depth": 0.05, "position": x,
         "balls": [group(1, 0.03, positions=[[0, 0, z]], velocities=[[0, -200.0 * z, 0]], spins=[[200.0, 0, 0]])]}
        for x, z in ((0.12, reach), (-0.08, -reach))
    ]  # fmt: skip
    run = simulate_chamber(small_machine(chambers=pair, unbalances=[], **turning), duration=0.05)
    mass = float(run.ball_mass[0])
    own = balls_unbalance(run)
    np.testing.assert_array_equal(balls_unbalance(run, np.array([0.12, -0.08]))["couple"], own["couple"])
    assert np.hypot(*own["couple"].values[-1]) == pytest.approx(mass * reach * 0.2, rel=5e-3)
    measured = chamber_measures(run)
    assert float(measured["residual_unbalance"]) < 5e-3 * mass * reach
    assert float(measured["residual_couple"]) == pytest.approx(mass * reach * 0.2, rel=5e-3)
    assert math.isclose(float(measured["share_carried"]), 1.0)


def test_a_motion_that_leaves_all_bounds_ends_the_run_and_keeps_what_was_good() -> None:
    legs = [{"position": [x, y, 0.0], "stiffness": [1e14] * 3} for x in (0.3, -0.3) for y in (0.4, -0.4)]
    run = simulate_chamber(mixed(supports=legs), duration=0.05, sample=1e-4)
    assert run.attrs["outcome"] == "not finite"
    assert run.sizes["time"] < 500
    assert np.isfinite(run.ball_position.values).all()
