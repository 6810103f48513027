"""What friction holds: the whirl below which no ball moves, and the residual unbalance, against grids and simulation."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.ndimage import label
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.assembly.drive_train import greatest_rise
from autobalancer.assembly.quantities import with_value_at
from autobalancer.cli.main import app
from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import parse_machine
from autobalancer.laws.stall import held_whirl, largest_held_residual
from autobalancer.machine import Machine
from autobalancer.results.display_units import moment_text
from autobalancer.results.verdict import rpm_text
from autobalancer.stability.host.stations import plane, stations
from autobalancer.stability.states.rest_states import required
from autobalancer.stability.summary import friction_rows

MACHINES = Path(__file__).parent.parent / "examples" / "machines"
RACE = "balancers[1].races[1]"


def machine(adherence: float, rolling: float | None = None, name: str = "discoidal.toml") -> Machine:
    found = ab.load_machine(MACHINES / name)
    friction = {"rolling_resistance": 0.5 * adherence if rolling is None else rolling, "adherence": adherence}
    for number in range(1, len(found.balancers) + 1):
        found = with_value_at(found, f"balancers[{number}].races[1].friction", friction)
    return found


# the whirl --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("mu", [1e-4, 0.006, 0.3])
def test_just_below_the_held_whirl_no_angle_moves_and_just_above_one_does(mu: float) -> None:
    angles = np.linspace(-math.pi, math.pi, 20001)

    def moves(whirl: float) -> bool:
        seen = whirl * np.exp(-1j * angles)
        return bool((np.abs(seen.imag) > mu * (0.07 + seen.real)).any())

    assert not moves(held_whirl(0.07, mu) * (1.0 - 1e-6))
    assert moves(held_whirl(0.07, mu) * (1.0 + 1e-6))


def test_weight_across_the_axis_takes_from_the_whirl_that_is_held() -> None:
    """With g/w^2 above mu eps / sqrt(1 + mu^2) nothing is held: a ball in the horizontal race of a resting rotor rolls."""
    speed, mu = 120.0, 0.006
    assert held_whirl(0.25, mu, weight=9.81 / speed**2) == pytest.approx(held_whirl(0.25, mu) - 9.81 / speed**2)
    assert held_whirl(0.25, mu, weight=9.81 / 50.0**2) < 0.0
    lying = with_value_at(machine(mu), "axis", "horizontal")
    assert "friction does not hold them" in ab.stability.held_by_friction(lying, "600 rpm").planes[0].sentence
    with pytest.raises(QuestionError, match="orbit_radius"):
        held_whirl(0.0, mu)


@pytest.mark.parametrize(("mu", "holds"), [(0.0062, True), (0.0056, False)])
def test_on_a_horizontal_axis_balls_move_just_where_weight_and_whirl_together_exceed_adherence(
    mu: float, holds: bool
) -> None:
    """g/w^2 is 397 um and the unbalance makes 57 um, together 0.0059 of the orbit radius; balls start opposite."""
    lying = with_value_at(machine(mu, mu), "axis", "horizontal")
    lying = with_value_at(lying, "drive.profile", {"kind": "constant", "speed": "1500 rpm"})
    lying = with_value_at(lying, "balancers[1].races[1].balls[1].start_angles", ["107 deg", "-73 deg"])
    assert ab.stability.held_by_friction(lying).planes[0].holds is holds
    angle = ab.simulate(lying, duration=6.0)["ball_angle_in_rotor"].values
    late = np.abs(angle[-1] - angle[angle.shape[0] // 2]).max()
    assert bool(late > 1e-6) is not holds


# the residual -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("first", "second", "phase", "held"), [(0.58, 0.58, 2.92, 0.1), (1.29, 1.5, 2.96, 0.3), (0.84, 0.84, 3.13, 0.1)]
)
def test_the_largest_held_residual_is_that_of_a_map_of_all_angles_of_two_balls(
    first: float, second: float, phase: float, held: float
) -> None:
    """All pairs of angles at rest that are connected with the balanced ones, by flood fill on the torus."""
    count = 700
    a, b = np.meshgrid(*2 * [np.linspace(-math.pi, math.pi, count, endpoint=False)], indexing="ij")
    residual = 1.0 + first * np.exp(1j * a) + second * np.exp(1j * b)
    whirl = residual * np.exp(1j * phase)
    rests = (np.abs((whirl * np.exp(-1j * a)).imag) <= held) & (np.abs((whirl * np.exp(-1j * b)).imag) <= held)
    twice = np.tile(rests, (2, 2))
    parts, _ = label(twice, structure=np.ones((3, 3)))
    balanced = np.unique(parts[twice & np.tile(np.abs(residual) < 0.02, (2, 2))])
    there = np.isin(parts, balanced[balanced > 0])
    connected = there[:count, :count] | there[count:, :count] | there[:count, count:] | there[count:, count:]
    greatest = float(np.abs(residual)[connected].max())
    found = largest_held_residual((1.0, 1.0), (first, second), held, phase=phase)
    assert found == pytest.approx(greatest, rel=0.06, abs=0.004)  # the grid has steps of half a degree
    assert found > greatest - 0.01


def test_without_friction_nothing_is_held_and_with_much_everything() -> None:
    assert largest_held_residual((1.0, 1.0), (0.8, 0.8), 0.0) == 0.0
    assert largest_held_residual((1.0, 1.0), (0.8, 0.8), 3.0) == pytest.approx(2.6)
    short = largest_held_residual((1.0, 1.0), (0.3, 0.3), 1e-4)  # the balls leave 0.4, friction or not
    assert short == pytest.approx(0.4, abs=0.01)


def _random_machine(rng: np.random.Generator) -> tuple[Machine, float]:
    """Balls in fluid that do balance: well above the critical speed, with a held whirl below that of the unbalance."""
    found = machine(1e-3)
    critical = math.sqrt(44654.0 / 12.27)
    speed = critical * rng.uniform(1.6, 5.0)
    found = with_value_at(found, "unbalances", [{"moment": float(rng.uniform(200e-6, 900e-6))}])
    p = plane(found)
    whirl = abs(p.fixed_load) * speed**2 / abs(p.dynamic_stiffness(speed))
    adherence = float(whirl * rng.uniform(0.05, 0.4) / 0.07695)
    friction = {"rolling_resistance": adherence * float(rng.uniform(0.2, 1.0)), "adherence": adherence}
    return with_value_at(found, "balancers[1].races[1].friction", friction), float(speed)


def test_worst_and_typical_residual_of_random_machines_are_those_of_simulated_ones() -> None:
    rng = np.random.default_rng(5)
    for _ in range(4):
        one, speed = _random_machine(rng)
        said = ab.stability.held_by_friction(one, speed).planes[0]
        p = plane(one)
        angles = ab.basin(one, speed, random=250)["final_ball_angle_in_rotor"].values
        left = np.abs(p.fixed_load + (p.moment * np.exp(1j * angles)).sum(axis=1))
        assert said.median_residual == pytest.approx(float(np.median(left)), rel=0.2)  # of 250 starts
        assert (left < said.residual_95).mean() == pytest.approx(0.95, abs=0.05)
        trapped = left > said.sticking_residual
        assert trapped.mean() == pytest.approx(said.trapped_share, abs=0.06)
        assert (
            left[trapped] > 0.8 * said.required
        ).all()  # balls in line on both sides: nothing between these and the worst


@pytest.mark.slow
@pytest.mark.parametrize("adherence", [1e-3, 1e-4])
def test_residuals_of_both_planes_are_those_of_runs_of_the_whole_machine(adherence: float) -> None:
    two = machine(adherence, name="two_plane_rotor.toml")
    for number in (1, 2):
        two = with_value_at(two, f"balancers[{number}].races[1].collisions", False)
    said, st = ab.stability.held_by_friction(two), stations(two, largest=True)
    need, rng, left = required(st, said.speed), np.random.default_rng(3), []
    for _ in range(60):
        one = two
        for number in (1, 2):
            starts = rng.uniform(-math.pi, math.pi, 2).tolist()
            one = with_value_at(one, f"balancers[{number}].races[1].balls[1].start_angles", starts)
        run = ab.simulate(one, duration=6.0)
        assert np.abs(run["ball_speed_in_rotor"].values[-1]).max() < 1e-6 * said.speed
        left.append(np.abs(st.moments(run["ball_angle_in_rotor"].values[-1]) - need))
    for place, middle in zip(said.planes, np.median(left, axis=0), strict=True):
        assert place.median_residual == pytest.approx(middle, rel=0.35)  # sixty runs


def test_balls_that_settled_above_the_border_keep_their_places_in_a_slow_rise_and_lose_them_in_a_quick_one() -> None:
    """A resting ball needs the adherence w'/w^2 to be taken along."""
    rough, low, high = machine(3e-4), 75.0, 125.0
    said = ab.stability.held_by_friction(rough, low).planes[0]
    assert said.greatest_acceleration == pytest.approx(3e-4 * low**2, rel=1e-6)
    moved = []
    for share in (0.5, 3.0):
        end = 40.0 + (high - low) / (share * said.greatest_acceleration)
        profile = {"kind": "table", "time": [0.0, 40.0, end, end + 5.0], "speed": [low, low, high, high]}
        run = ab.simulate(with_value_at(rough, "drive.profile", profile), duration=end + 5.0)
        angle, settled = run["ball_angle_in_rotor"].values, int(np.searchsorted(run["time"].values, 39.9))
        assert (run["ball_speed_in_rotor"].values[settled] == 0.0).all()
        moved.append(float(np.abs(angle[-1] - angle[settled]).max()))
    assert moved[0] < 1e-9
    assert moved[1] > 0.01


OFF = """
name = "a race off the axis, with friction"
axis = "vertical"
rotor = { kind = "planar", mass = "8 kg", critical_speed = "900 rpm", damping_ratio = "4 %" }
unbalances = [{ moment = "500 g*mm" }]
drive = { kind = "speed", profile = { kind = "ramp", end = "4000 rpm", duration = "60 s" } }
run = { duration = "90 s" }
[[balancers]]
[[balancers.races]]
bearing = "61832"
width = "14 mm"
height = "14 mm"
eccentricity = "25 um"
fluid = { name = "silicone oil 20" }
drag = { law = "sphere_on_plane", range = "whole" }
friction = { rolling_resistance = 5e-5, adherence = 1e-4 }
balls = [{ count = 2, material = "steel" }]
"""


def test_friction_and_an_eccentric_race_hold_more_than_each_alone_and_no_run_exceeds_what_is_said() -> None:
    off = parse_machine(OFF)
    both = ab.stability.held_by_friction(off).planes[0]
    centered = ab.stability.held_by_friction(with_value_at(off, f"{RACE}.eccentricity", 0.0)).planes[0]
    p, speed = plane(off), 4000 * math.pi / 30
    assert both.eccentric_residual == pytest.approx(25e-6 * abs(p.dynamic_stiffness(speed)) / speed**2, rel=1e-9)
    rising = ab.basin(off, speed, random=4, acceleration=7.0)["residual_unbalance"].values
    assert (rising > both.eccentric_residual + centered.sticking_residual).all()  # the numbers one by one say less
    assert (rising < both.sticking_residual).all()
    # released at rest: the residual of a run contains what the eccentric race leaves
    left = ab.basin(off, speed, random=200)["residual_unbalance"].values
    assert both.median_residual == pytest.approx(float(np.median(left)), rel=0.2)
    assert (left < both.residual_95).mean() == pytest.approx(0.95, abs=0.06)
    assert (left < both.greatest_residual).all()
    assert "190 g mm of it is left by the eccentric race" in both.sentence
    assert "eccentric" not in centered.sentence


def test_the_eccentricity_counts_where_balls_start_to_move() -> None:
    """Against the unbalance it brings the race back to the axis: no ball moves where the whirl alone would move it."""
    off = with_value_at(parse_machine(OFF), f"{RACE}.eccentricity", "60 um")
    found = ab.stability.held_by_friction(off).planes[0]
    assert found.unbalance_whirl < found.held_whirl
    assert found.holds
    off = with_value_at(off, "drive.profile", {"kind": "constant", "speed": "4000 rpm"})
    off = with_value_at(off, f"{RACE}.balls[1].start_angles", ["20 deg", "200 deg"])

    def way(one: Machine) -> float:
        angle = ab.simulate(one, duration=3.0)["ball_angle_in_rotor"].values
        return float(np.abs(angle[-1] - angle[0]).max())

    assert way(off) < 1e-3  # the whirl that decays after the start moves them a little
    assert way(with_value_at(off, f"{RACE}.eccentricity", 0.0)) > 0.1


def test_no_row_says_a_bound_that_trapped_starts_exceed() -> None:
    found = ab.stability.held_by_friction(with_value_at(parse_machine(OFF), f"{RACE}.eccentricity", 0.0)).planes[0]
    said = dict(found.rows)
    assert found.trapped_share > 0.0
    assert found.greatest_residual > found.sticking_residual
    bound = f"residual at most {moment_text(found.sticking_residual)} where balls stick on their way to balance"
    assert said["sticking"] == f"{bound}, more where they are trapped"
    assert dict(found.settled_rows)[""] == f"balls that settle there: {said['sticking']}"
    assert said["trapped"] == dict(found.settled_rows)["trapped"]
    assert said["trapped"].endswith(f"the greatest residual of all starts: {moment_text(found.greatest_residual)}")


# what is said -----------------------------------------------------------------------------------------------------------


def test_a_soft_fast_rotor_with_ordinary_friction_is_told_that_its_balls_will_not_move() -> None:
    """The whirl of the unbalance, U/M, is below mu eps: the same machine at speed keeps its balls where they start."""
    fast = with_value_at(machine(0.006), "drive.profile", {"kind": "constant", "speed": "3000 rpm"})
    said = ab.stability.held_by_friction(fast)
    assert said.planes[0].holds
    assert "WILL NOT MOVE" in said.planes[0].sentence
    assert said.planes[0].sticking_residual == pytest.approx(
        abs(plane(fast).unbalance) + plane(fast).moment.sum(), rel=1e-9
    )
    run = ab.simulate(fast, duration=3.0)
    moved = run["ball_angle_in_rotor"].values[-1] - run["ball_angle_in_rotor"].values[0]
    assert np.abs(moved).max() < 1e-9
    low = ab.stability.held_by_friction(machine(1e-5)).planes[0]
    assert not low.holds
    assert low.sticking_residual < 0.05 * abs(plane(fast).unbalance)


def test_below_the_critical_speed_the_residual_is_that_of_unbalance_and_balls_together() -> None:
    rough = machine(1e-4)
    said, p = ab.stability.held_by_friction(rough, 30.0).planes[0], plane(rough)
    assert said.sticking_residual == pytest.approx(abs(p.unbalance) + p.moment.sum(), rel=1e-9)
    assert said.median_residual > 1.5 * said.required


def test_rolling_resistance_alone_holds_as_adherence_does() -> None:
    both = ab.stability.held_by_friction(machine(1e-3, 1e-3)).planes[0]
    rolling = with_value_at(machine(1e-3), "balancers[1].races[1].friction", {"rolling_resistance": 1e-3})
    assert ab.stability.held_by_friction(rolling).planes[0] == both


def test_a_run_says_below_which_whirl_its_balls_stay_or_that_they_are_ideal() -> None:
    def said(one: Machine) -> Any:
        return ab.simulate(with_value_at(one, "drive.profile", {"kind": "constant", "speed": 125.0}), duration=0.5)

    rough, ideal = said(machine(0.006)), said(ab.load_machine(MACHINES / "discoidal.toml"))
    assert "462 µm" in rough.attrs["remarks"][0]
    assert "ideal balls" in ideal.attrs["remarks"][0]
    assert rough.attrs["remarks"][0] in ab.verdict(rough).notes
    assert ideal.attrs["remarks"][0] in ab.verdict(ideal).notes


def test_check_says_what_friction_does_or_that_there_is_none(tmp_path: Path) -> None:
    ideal, rough = MACHINES / "discoidal.toml", tmp_path / "rough.toml"
    ab.save_machine(machine(0.006), rough)
    for path, words in ((ideal, "ideal balls"), (rough, "WILL NOT MOVE")):
        answer = CliRunner().invoke(app, ["check", str(path)], env={"COLUMNS": "300"}, catch_exceptions=False)
        assert words in answer.output
        found = json.loads(CliRunner().invoke(app, ["check", str(path), "--json"], catch_exceptions=False).output)
        assert bool(found["friction"]["planes"]) == (path == rough)
    assert found["friction"]["planes"][0]["holds"]
    assert found["friction_settled"]["speed"] < found["friction"]["speed"]


def test_check_says_what_friction_holds_in_short_rows_and_borders_only_the_first(tmp_path: Path) -> None:
    rough = tmp_path / "rough.toml"
    ab.save_machine(machine(1e-4), rough)
    held = ab.stability.held_by_friction(machine(1e-4))
    rows = friction_rows(held, rpm_text)
    assert [name.strip() for name, _ in rows] == ["friction", "sticking", "starts", "trapped", "places"]
    assert all(text.count(",") < 3 and len(text) < 160 for _, text in rows)
    said = CliRunner().invoke(app, ["borders", str(rough)], catch_exceptions=False).output
    assert "friction: at" in said
    assert "released at rest" not in said


def sentence(plane: Any) -> str:
    return "; ".join(text for _, text in plane.settled_rows)


def test_the_row_says_that_balls_are_released_at_rest_and_not_run_up() -> None:
    words = "released at rest at this speed at random places (not a run-up): median"
    plane = ab.stability.held_by_friction(machine(1e-4)).planes[0]
    assert words in plane.sentence
    assert words in sentence(plane)
    at = ab.basin(machine(1e-4), 125.0, random=2, hold=0.5)
    assert at.attrs["released"] == words.partition(":")[0]
    rising = ab.basin(machine(1e-4), 125.0, {"acceleration": [1e3]}, hold=0.5)
    assert rising.attrs["released"] == "after run-ups"


def test_settled_balls_are_carried_on_by_a_drive_that_rises_faster_than_adherence_allows() -> None:
    """A ball of adherence alone stays while W' eps < held whirl W^2, which a ramp of twice that exceeds, and of half not."""
    limit = held_whirl(0.07695, 1e-3) * 80.0**2 / 0.07695

    def settled(rise: float) -> Any:
        ramp = {"kind": "ramp", "end": 125.0, "duration": 125.0 / rise}
        return ab.stability.held_by_friction(with_value_at(machine(1e-3), "drive.profile", ramp), 80.0).planes[0]

    assert settled(2.0 * limit).drive_acceleration == pytest.approx(2.0 * limit)
    assert settled(2.0 * limit).carried_on
    assert sentence(settled(2.0 * limit)).endswith(f"; this drive ({2.0 * limit:.3g} rad/s^2) moves them again")
    assert sentence(settled(0.5 * limit)).endswith("; this drive rises more slowly")
    constant = with_value_at(machine(1e-3), "drive.profile", {"kind": "constant", "speed": 125.0})
    assert "the drive" not in sentence(ab.stability.held_by_friction(constant, 80.0).planes[0])


def test_where_a_torque_drives_the_row_says_why_it_is_of_three_times_the_critical_speed() -> None:
    driven = with_value_at(
        with_value_at(machine(1e-3), "rotor.inertia", 0.1), "drive", {"kind": "torque", "torque": 1.0}
    )
    held = ab.stability.held_by_friction(driven)
    why = " (3 times the lowest critical speed, as no speed is prescribed) "
    assert why.strip() in repr(held)
    assert why in friction_rows(held, rpm_text)[0][1]
    assert why.strip() not in repr(ab.stability.held_by_friction(driven, 100.0))


def test_the_greatest_rise_counts_above_a_speed_only_and_less_where_the_speed_is_higher() -> None:
    def rise(profile: dict[str, Any], speed: float) -> float | None:
        return greatest_rise(with_value_at(machine(1e-3), "drive.profile", profile), speed)

    table = {"kind": "table", "time": [0.0, 1.0, 11.0, 12.0], "speed": [0.0, 50.0, 100.0, 140.0]}
    assert rise(table, 60.0) == pytest.approx(40.0 * 0.6**2)
    assert rise(table, 25.0) == pytest.approx(50.0)
    assert rise(table, 150.0) == 0.0
    hill = {"kind": "hill", "end": 125.0, "half_time": 4.0, "exponent": 3.0}
    time = np.linspace(0.0, 400.0, 400001)
    speed = 125.0 * time**3 / (4.0**3 + time**3)
    above = speed >= 70.0
    expected = (np.gradient(speed, time)[above] * (70.0 / speed[above]) ** 2).max()
    assert rise(hill, 70.0) == pytest.approx(expected, rel=2e-3)


def test_every_border_names_in_its_own_line_what_its_theory_leaves_out() -> None:
    rough = {border.name: border.note for border in ab.stability.borders(machine(0.006))}
    assert "ignores friction" in rough["exact border"]
    assert "ignores friction" in rough["averaged border"]
    assert rough["release speed"].endswith("ignores adherence")
    ideal = ab.stability.borders(MACHINES / "discoidal.toml")
    assert not any("ignores" in border.note for border in ideal)
    real = ab.stability.borders("docs/machines/real_race.toml")
    assert all("waves of the race, excitations" in border.note for border in real)


def test_a_map_hatches_where_the_whirl_of_the_unbalance_is_below_what_friction_holds() -> None:
    rough, speeds, sizes = machine(1e-3), np.linspace(80.0, 200.0, 9), np.linspace(50e-6, 900e-6, 7)
    found = ab.stability.map(rough, {"speed": speeds, "unbalance": sizes}, borders=0)
    p = plane(rough)
    whirl = np.array([[size * w**2 / abs(p.dynamic_stiffness(w)) for size in sizes] for w in speeds])
    assert found["held_share"].values == pytest.approx(held_whirl(0.07695, 1e-3) / whirl, rel=1e-9)
    assert (found["held_share"] > 1.0).any()
    assert (found["held_share"] < 1.0).any()
    labels = [text.get_text() for text in ab.plot.map(found).legends[0].get_texts()]
    assert "friction holds balls at rest" in labels
    assert "friction" in found.attrs["ignores"]
    ideal = ab.stability.map(MACHINES / "discoidal.toml", {"speed": speeds, "unbalance": sizes}, borders=0)
    assert "held_share" not in ideal
    assert ideal.attrs["ignores"] == ""
    along = ab.stability.map(
        MACHINES / "discoidal.toml", {"rolling_resistance": [1e-5, 1e-2], "unbalance": sizes}, borders=0, speed=125.0
    )
    assert (along["held_share"][0] < 1.0).any()
    assert (along["held_share"][1] > 1.0).all()


def test_every_range_of_the_stability_command_says_that_it_ignores_friction(tmp_path: Path) -> None:
    rough = tmp_path / "rough.toml"
    ab.save_machine(machine(1e-3), rough)
    arguments = ["eigenvalues", str(rough), "--speeds", "500 rpm:1300 rpm:5"]
    first = CliRunner().invoke(app, arguments, catch_exceptions=False).output.strip().splitlines()[0]
    assert "ignores friction" in first, "the title of the table, which holds for every range in it"


def test_stable_windows_and_least_drag_say_what_they_ignore(tmp_path: Path) -> None:
    assert "ignores friction" in ab.stability.stable_windows(machine(1e-3), 150.0).note
    rough = tmp_path / "rough.toml"
    ab.save_machine(machine(1e-3), rough)
    arguments = ["borders", str(rough), "--only", "exact border, release speed", "--minimum-drag-at", "1200 rpm"]
    lines = CliRunner().invoke(app, arguments, catch_exceptions=False).output.splitlines()
    assert any(line.strip().startswith("exact border:") and "ignores friction" in line for line in lines)
    assert any(line.strip().startswith("release speed:") and "ignores adherence" in line for line in lines)
