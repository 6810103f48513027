"""The verdict on a run, and the machine without balancing beside it."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import solve_ivp
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.assembly.drive_train import largest_unbalance
from autobalancer.assembly.system import assemble
from autobalancer.cli.main import app
from autobalancer.errors import QuestionError
from autobalancer.files.examples import rig
from autobalancer.machine import Machine
from autobalancer.reporting.report_pages import quality_page
from autobalancer.results import verdict as rule
from autobalancer.results.display_units import moment_text, significant
from autobalancer.results.run_arrays import stall_of
from autobalancer.results.verdict import Settling, Verdict, headline, rpm_text, verdict_lines, verdict_word
from autobalancer.stability.summary import Summary, service_of, service_rows, summary_rows
from autobalancer.tables import rpm_and_si

MACHINES = Path(__file__).parents[1] / "examples" / "machines"


def driven(speed: float) -> dict[str, Any]:
    return {"kind": "speed", "profile": {"kind": "ramp", "end": speed, "duration": 10.0}}


def at_speed(name: str, speed: float) -> Machine:
    drive = {"kind": "speed", "profile": {"kind": "constant", "speed": speed}}
    return ab.with_parameter(ab.load_machine(MACHINES / name), "drive", drive)


def with_adherence(adherence: float) -> Machine:
    machine = at_speed("discoidal.toml", 150.0)
    friction = {"rolling_resistance": 0.5 * adherence, "adherence": adherence}
    return ab.with_parameter(machine, "balancers[1].races[1].friction", friction)


@pytest.fixture(scope="module")
def balanced() -> xr.Dataset:
    return ab.simulate(at_speed("two_plane_rotor.toml", 600.0), duration=4.0)


def test_balls_that_balance_are_called_so_and_what_is_left_is_said_of_each_plane(balanced: xr.Dataset) -> None:
    found = ab.verdict(balanced)
    assert found.balanced
    assert found.word == "balanced"
    rows = dict(verdict_lines(found)[1])
    assert " from its mean position, " in rows["vibration"]
    assert rows["greatest deflection"].endswith(", from the rest position")
    assert [plane.name for plane in found.planes] == ["lower", "upper"]
    assert all(plane.residual < 1e-2 * plane.unbalance for plane in found.planes)
    assert [place.name for place in found.places] == ["lower", "upper", "support 1", "support 2"]
    assert str(found).startswith("balanced: vibration ")
    # equal residuals on the same side would be static only, on opposite sides couple only: their squares add up
    ends = [plane.residual for plane in found.planes]
    shares = found.static_residual**2 + (2.0 * found.couple_residual / 0.25) ** 2
    assert shares == pytest.approx(2.0 * (ends[0] ** 2 + ends[1] ** 2), rel=1e-2)
    assert "upper" in found._repr_html_()
    json.dumps(found.as_dict())


@pytest.mark.parametrize(
    "name", ["discoidal.toml", "two_plane_rotor.toml", "eccentric_race.toml", "resolved_balls.toml"]
)
def test_a_run_with_held_balls_ends_in_the_steady_response_that_every_run_has_beside_it(name: str) -> None:
    machine = at_speed(name, 300.0)
    short = ab.simulate(machine, duration=0.05, save=ab.LastRevolutions(1, 4))
    held = ab.simulate(machine, duration=6.0, hold_balls=True, tolerance=1e-10)
    found = ab.run_measures(held, "vibration")
    assert held.sizes["ball"] == 0
    np.testing.assert_allclose(found["greatest"], short["vibration_without_balls"], rtol=1e-3)
    np.testing.assert_allclose(
        ab.run_measures(held, "support_forces")["greatest"], short["force_without_balls"], rtol=1e-3
    )
    np.testing.assert_allclose(held.attrs["critical_speeds"], short.attrs["critical_speeds"], rtol=1e-12)
    if name != "eccentric_race.toml":  # whose balls have an unbalance of their own even when they are spread
        steady = ab.rotor.response(machine, [300.0], balls=True)["semi_major"][0].sel
        for place in set(found["place"].values) & {
            str(s) for s in short.coords.get("station", xr.DataArray([])).values
        }:
            assert float(steady(station=place)) == pytest.approx(float(found["greatest"].sel(place=place)), rel=1e-3)


def test_without_balls_a_planar_rotor_whirls_as_the_textbook_says() -> None:
    run = ab.simulate(at_speed("stall_and_release.toml", 400.0), duration=0.1, save=ab.LastRevolutions(1))
    w, m, k, b, u = 400.0, 10.0, 625e3, 100.0, 5e-4
    assert float(run["vibration_without_balls"][0]) == pytest.approx(
        u * w**2 / abs(k - m * w**2 + 1j * b * w), rel=1e-9
    )


def test_balls_that_friction_holds_are_not_balanced() -> None:
    found = ab.verdict(ab.simulate(with_adherence(0.1), duration=10.0))
    assert found.word in ("not balanced", "worse than without balls", "partly balanced")
    # a planar rotor at rest in its own frame answers in proportion to what is left
    assert found.ratio == pytest.approx(found.residual_share, rel=1e-3)
    assert ab.verdict(ab.simulate(with_adherence(1e-7), duration=30.0)).word == "balanced"


def test_balls_below_the_critical_speed_make_it_worse() -> None:
    machine = at_speed("discoidal.toml", 0.5 * 62.6)
    found = ab.verdict(ab.simulate(machine, duration=120.0))
    assert found.word == "worse than without balls"
    assert found.residual > 1.9 * found.unbalance


def test_the_first_line_says_which_balls_are_stalled_just_below_the_critical_speed_and_for_how_long() -> None:
    ramp = {"kind": "ramp", "end": 314.0, "duration": 10.0}
    slow = ab.with_parameter(ab.load_machine(MACHINES / "stall_and_release.toml"), "drive.profile", ramp)
    found = ab.verdict(ab.simulate(slow, duration=20.0))
    assert found.stall is not None
    assert found.stall.balls == (1, 2)
    assert all(0.95 * 250.0 < speed < 250.0 for speed in found.stall.speeds)
    assert found.stall.critical_speeds == found.stall.whirls == (250.0, 250.0)
    assert found.as_dict()["stall"]["modes"] == (1, 1)
    passed = 10.0 * 1.02 * 250.0 / 314.0  # s, when the rotor is so far above the critical speed that balls can stall
    assert found.stall.duration == pytest.approx(20.0 - passed, rel=0.02)
    assert found.stall.rotor_speed == pytest.approx(314.0, rel=1e-3)
    at = f"the critical speed of 2387 rpm (whirling at {significant(found.stall.speeds[0] * 30.0 / math.pi)} rpm)"
    said = str(found).splitlines()[0]
    assert f"worse than without balls, 2 of 2 balls stalled at {at} while the rotor turns at " in said
    assert " rpm, for 11.8 s" in said
    assert dict(verdict_lines(found)[1])["residual unbalance"].endswith("with the rotor: no residual to count on")
    assert dict(verdict_lines(found)[1])["ISO 21940-11"].startswith("no grade, as balls do not turn with the rotor; ")
    summary = ab.check(ab.with_parameter(slow, "drive", driven(314.0)))
    assert isinstance(summary, Summary)
    turning = replace(found, stall=None, goes_round=True, word="not balanced")
    settled = replace(turning, goes_round=False)
    for judged, balls, enough in (
        (found, "balls stalled, worse than without balls", "NO"),
        (turning, "balls still go round", "NO"),
        (settled, "balls settled", "yes"),
    ):
        page = quality_page(summary, found.residual, judged, 4000.0, "")  # a grade that each residual is below
        (row,) = [row for row in page.decisive if "the run-up" in row.question]
        assert row.question == f"residual unbalance, {balls}, at the end of the run-up"
        assert row.enough == enough
        assert row.found.endswith("no grade") == (judged is not settled)
    still = ab.verdict(ab.simulate(slow, duration=20.0, hold_balls=True))
    assert still.stall is None
    assert still.turns_with_rotor


def test_each_stalled_ball_is_said_to_be_at_the_critical_speed_whose_whirl_it_drives() -> None:
    """f^2 - g w f = (1 - g) w_c^2 is 160 rad/s for w_c = 150 and w = 300 rad/s if g = 0.121; a third mode is not passed."""
    time = np.linspace(0.0, 20.0, 401)
    rates = np.array([98.0, 155.0, 156.0, 300.0]) - 300.0
    moved = xr.Dataset(
        {
            "time": time,
            "speed": ("time", np.full_like(time, 300.0)),
            "deflection": ("time", np.full_like(time, 1e-3)),
            "ball_angle_in_rotor": (("time", "ball"), time[:, None] * rates),
            "ball_speed_in_rotor": (("time", "ball"), np.tile(rates, (time.size, 1))),
            "ball": [1, 2, 3, 4],
        },
        attrs={"critical_speeds": [100.0, 150.0, 400.0], "end_time": 20.0, "static_load": "none"},
    )
    share = (160.0**2 - 150.0**2) / (160.0 * 300.0 - 150.0**2)
    stall = stall_of(moved.assign_attrs(gyroscopic_shares=[0.0, share, 0.0]))
    assert stall is not None
    assert (stall.balls, stall.modes, stall.critical_speeds) == ((1, 2, 3), (1, 2, 2), (100.0, 150.0, 150.0))
    assert stall.whirls == pytest.approx((100.0, 160.0, 160.0))
    assert headline(Verdict("not balanced", "", stall=stall), lambda speed: f"{speed:.1f} rad/s").startswith(
        "not balanced, 1 of 4 balls stalled at the first critical speed of 100.0 rad/s (whirling at 98.0 rad/s), 2 of 4 balls "
        "stalled at the second critical speed of 150.0 rad/s (whirling at 155.5 rad/s, near its forward whirl of 160.0 rad/s) "
        "while the rotor turns at 300.0 rad/s, for 20 s: "
    )


def test_the_words_have_the_limits_that_are_documented() -> None:
    words = [verdict_word(ratio) for ratio in (0.0, 0.1, 0.1001, 0.9, 0.9001, 1.1, 1.1001, math.nan)]
    partly, not_ = "partly balanced", "not balanced"
    worse = "worse than without balls"
    assert words == ["balanced", "balanced", partly, partly, not_, not_, worse, "no verdict"]


def test_a_run_that_is_not_at_its_end_has_no_verdict() -> None:
    machine = ab.load_machine(MACHINES / "stall_and_release.toml")
    during = ab.verdict(ab.simulate(machine, duration=12.0))
    assert during.word == "no verdict"
    assert "speed still changes" in during.because
    stopped = ab.verdict(ab.simulate(machine, max_steps=200))
    assert stopped.because.startswith("the run did not finish: 200 steps")
    settling = ab.simulate(at_speed("stall_and_release.toml", 500.0), duration=0.6)
    assert ab.verdict(settling).word == "not settled yet"
    assert "vibration still changes" in ab.verdict(settling).because
    turn = 2.0 * math.pi / 500.0
    short, enough = (
        ab.verdict(ab.simulate(at_speed("stall_and_release.toml", 500.0), duration=n * turn)) for n in (6, 11)
    )
    assert (short.word, short.because) == ("not settled yet", "too short to tell: 6 revolutions; take 10 or more")
    assert "too short" not in enough.because
    bare = machine.model_copy(update={"balancers": ()})
    assert ab.verdict(ab.simulate(bare)).because == "the machine has no balls"
    light = machine.model_copy(update={"unbalances": ()})
    assert ab.verdict(ab.simulate(light)).because == "the rotor has no unbalance"


def creeping(name: str) -> Machine:
    """Machines in whose oil the balls creep, at their last speed from the start."""
    if name == "two planes":
        found = at_speed("two_plane_rotor.toml", 600.0)
        races = [f"balancers[{i}].races[1]" for i in (1, 2)]
        return with_values(found, {f"{race}.drag": {"law": "viscous", "damping": 1e-2} for race in races})
    found = with_values(
        at_speed("stall_and_release.toml", 500.0),
        {"unbalances[1].mass": 4e-3, "balancers[1].races[1].balls[1].start_angles": [0.35, 1.05]}
        | {"balancers[1].races[1].drag.damping": 5e-2, "balancers[1].races[1].balls[1].mass": 3e-3},
    )
    parts = {"on uneven supports": ("rotor.stiffness", (5e5, 7e5)), "lying": ("axis", "horizontal")}
    return ab.with_parameter(found, *parts[name]) if name in parts else found


def with_values(machine: Machine, values: dict[str, Any]) -> Machine:
    for path, value in values.items():
        machine = ab.with_parameter(machine, path, value)
    return machine


@pytest.mark.parametrize(
    ("name", "short", "factor"),
    [("one plane", 14.0, 1.1), ("on uneven supports", 14.0, 1.1), ("lying", 14.0, 1.1), ("two planes", 8.0, 1.4)],
)
def test_a_run_whose_balls_creep_names_the_duration_that_shows_them_settled(
    name: str, short: float, factor: float
) -> None:
    machine = creeping(name)
    found = ab.verdict(ab.simulate(machine, duration=short))
    assert found.word == "not settled yet"
    assert found.settling is not None
    assert found.settling.moving
    ahead = found.forecast
    assert ahead is not None
    assert f"run for about {significant(ahead.duration, 2)} s to see it (run.duration)" in str(found).splitlines()[0]
    later = ab.verdict(ab.simulate(machine, duration=ahead.duration))
    assert later.word == "balanced"
    assert later.settling is not None
    assert not later.settling.moving
    assert ahead.duration < factor * later.settling.settled_at / 0.95  # not longer than it takes
    assert ahead.share == pytest.approx(0.0, abs=0.01)
    swept = ab.sweep(machine, {}, seeds=1, duration=short)
    assert swept["verdict"].values.tolist() == ["not settled yet"]
    assert not swept["balanced"].any()
    assert np.isnan(swept["settling_time"]).all()


SETTLED_LATE = Verdict("not settled yet", "balls drift", settling=Settling(0, np.nan, "", np.nan, (1, 2)))


@pytest.fixture(scope="module")
def swinging() -> xr.Dataset:
    """Two balls with p' = g Re(exp(-i p) R): to them balance is a center, about which they swing for ever."""
    moment, gain = np.array([0.8, 0.8]), 20.0

    def turning(_: float, balls: np.ndarray) -> np.ndarray:
        return gain * (np.exp(-1j * balls) * (1.0 + np.exp(1j * balls) @ moment)).real

    time, balanced = np.linspace(0.0, 1.0, 401), np.arccos(-0.5 / 0.8)
    angle = solve_ivp(turning, (0.0, 1.0), [balanced + 0.3, -balanced], t_eval=time, rtol=1e-10, atol=1e-12).y.T
    variables = {
        "speed": ("time", np.full(401, 100.0)),
        "ball_angle_in_rotor": (("time", "ball"), angle),
        "ball_speed_in_rotor": (("time", "ball"), np.gradient(angle, time, axis=0)),
        "ball_moment": ("ball", moment),
        **{f"plane_{of}": (("time", "plane"), np.ones((401, 1))) for of in ("unbalance", "balls")},
        **{f"plane_{of}_angle_in_rotor": (("time", "plane"), np.zeros((401, 1))) for of in ("unbalance", "balls")},
    }
    return xr.Dataset(variables, {"time": time, "ball": [1, 2]}, {"end_time": 1.0})


@pytest.mark.parametrize(("evaluations", "ahead"), [(500, 1000.0), (5000, 1000.0), (5000, 3.0)])
def test_balls_that_never_settle_are_followed_for_so_many_evaluations_and_no_longer(
    swinging: xr.Dataset, monkeypatch: pytest.MonkeyPatch, evaluations: int, ahead: float
) -> None:
    monkeypatch.setattr(rule, "EVALUATIONS", evaluations)
    monkeypatch.setattr(rule, "AHEAD", ahead)
    found = rule.forecast_of(swinging, 0.0)
    assert found is not None
    assert np.isnan([found.share, found.duration]).all()  # no share and no time of balls that do not come to rest
    # a period of 2 pi/(g sin p) = 0.4 s takes some 80 evaluations; AHEAD ends the cheaper ones
    if ahead * 1.0 < evaluations / 200.0:
        assert found.followed == pytest.approx(1.0 + ahead)
    else:
        assert found.followed - 1.0 == pytest.approx(evaluations / 200.0, rel=0.3)
    said = replace(SETTLED_LATE, forecast=found)
    text = f"how long they take to settle is not known, more than {significant(found.followed, 2)} s (extrapolated)"
    assert text in headline(said)
    assert text in str(replace(said, word="balanced"))


def test_a_shaken_machine_is_compared_with_its_run_with_held_balls() -> None:
    machine = at_speed("discoidal.toml", 150.0)
    shake = {"kind": "base_motion", "acceleration": "0.2 m/s^2", "frequency": "9 Hz"}
    shaken = ab.with_parameter(machine, "excitations", (shake,))
    run = ab.simulate(shaken, duration=15.0)
    assert "hold_balls" in ab.verdict(run).because
    found = ab.verdict(run, ab.simulate(shaken, duration=15.0, hold_balls=True))
    assert found.word in ("partly balanced", "not balanced")  # the balls do nothing against the base
    assert str(found).splitlines()[0].endswith("of that without balls (balanced is up to 10 %)")
    assert found.residual_share < 0.05


def test_balance_quality_grades_are_the_velocity_of_the_mass_center() -> None:
    # ISO 21940-11: G 6.3 at 3000 rpm is an eccentricity of 20 um
    speed = 3000 * math.pi / 30
    allowed = ab.laws.permissible_unbalance(6.3, 10.0, speed)
    assert allowed == pytest.approx(10.0 * 20.05e-6, rel=1e-3)
    assert ab.laws.balance_grade(allowed, 10.0, speed) == pytest.approx(6.3)
    for grade in ("6.3", "G 6.3", "G6.3", "g 6.3", "6.3 mm/s", "0.0063 m/s"):
        assert ab.laws.permissible_unbalance(grade, 10.0, speed) == pytest.approx(allowed)
    assert ab.laws.permissible_unbalance("G 2.5", "10 kg", "3000 1/min") == pytest.approx(79.577e-6, rel=1e-4)
    for grade in (6.3e-3, "0.0063", 6300.0, "G", "fine", "6.3 kg", "G 2,5", True, float("nan")):
        with pytest.raises(QuestionError, match=r"grade: given .*; write it as in ISO 21940-11, such as 2\.5 or"):
            ab.laws.permissible_unbalance(grade, 10.0, speed)
    with pytest.raises(QuestionError, match="mass"):
        ab.laws.balance_grade(1e-4, 0.0, speed)


def test_the_grade_of_a_run_is_that_of_what_is_left_on_the_mass_that_turns(balanced: xr.Dataset) -> None:
    found = ab.verdict(balanced)
    mass = 5.0 + float((balanced["ball_moment"] / balanced["orbit_radius"]).sum())
    assert found.grade_before == pytest.approx(1e3 * found.unbalance * 600.0 / mass, rel=1e-9)
    assert found.grade_after == pytest.approx(1e3 * found.residual * 600.0 / mass, rel=1e-9)
    described = rig("discoidal_rig")  # of several bodies only those that turn count
    turning = sum(float(body.mass) for body in described.rotor.bodies if body.rotating)
    run = ab.simulate(described, duration=0.5, save=ab.LastRevolutions(1))
    assert turning < float(run.attrs["turning_mass"]) < turning + 0.2


@pytest.mark.parametrize("name", ["two_plane_rotor.toml", "discoidal.toml"])
def test_check_says_before_a_run_what_the_run_compares_with(name: str) -> None:
    found = ab.check(MACHINES / name)
    run = ab.simulate(at_speed(name, found.highest_speed or 0.0), duration=0.1)
    assert found.service is not None
    assert dict(found.service.vibration) == pytest.approx(
        dict(zip(run["place"].values, run["vibration_without_balls"].values, strict=True)), rel=1e-9
    )
    assert found.service.grade == pytest.approx(ab.verdict(run).grade_before, rel=1e-9)
    shown = CliRunner(env={"COLUMNS": "80"}).invoke(app, ["check", str(MACHINES / name)]).stdout
    assert "without balancing" in shown
    assert "ISO 21940-11 G" in shown
    driven = ab.load_machine(MACHINES / "stall_and_release.toml").model_copy(update={"unbalances": ()})
    assert ab.check(driven).service is None


@pytest.mark.parametrize(
    ("name", "changes", "said"),
    [
        ("discoidal", {}, "yes, at 1200 rpm: the balanced state is stable from "),
        (
            "discoidal",
            {"unbalance": "2000 g*mm"},
            "only in part: the balls can balance 1023 g mm of 2000 g mm; take more",
        ),
        ("discoidal", {"drive": driven(40.0)}, "no, not at 382 rpm: below the critical speed"),
        (  # and a run leaves 189 g mm, too
            "discoidal",
            {"balancers[1].races[1].eccentricity": "20 um"},
            "only in part, at 1200 rpm: the race eccentricity leaves 189 g mm of 594 g mm, center the race better",
        ),
        (  # stable in a range of speeds, above which there is no balanced state at all
            "discoidal",
            {"balancers[1].races[1].eccentricity": "200 um"},
            "no, not at 1200 rpm: the balanced state is stable 614 rpm to 983 rpm only; run there, or more drag",
        ),
        (  # what run-ups leave is another question, with its own command
            "discoidal",
            {"balancers[1].races[1].friction": {"rolling_resistance": 1e-4}},
            "95 % of the starts of balls released at rest in the rotor at that speed, not of run-ups (autobalancer ensemble",
        ),
        (
            "eccentric_race",
            {},
            "no, not at 5664 rpm: the race eccentricity leaves 824 g mm",
        ),
        (
            "stall_and_release",
            {"drive": driven(260.0)},
            "no, not at 2483 rpm: the balanced state is stable",
        ),
        (
            "stall_and_release",
            {"drive": driven(330.0)},
            "not after a slow run-up: balls that stall are",
        ),
    ],
)
def test_check_answers_first_whether_the_balls_balance_the_machine(
    name: str, changes: dict[str, Any], said: str
) -> None:
    machine = ab.example(name)
    for path, value in changes.items():
        machine = ab.with_parameter(machine, path, value)
    found = ab.check(machine)
    assert isinstance(found, Summary)
    label, text = summary_rows(found, rpm_text)[0]
    assert label == "balances"
    assert said in text
    assert found.as_dict()["balances"] == found.rows()[0][1]
    below = type(found.borders)(replace(border, windows=((80.0, 90.0),)) for border in found.borders)
    told = summary_rows(replace(found, borders=below), rpm_text)[0][1]
    assert "state is stable from" not in told, "ranges below the border are named before it"


def test_check_and_verdict_name_the_same_unbalances_alike() -> None:
    machine = ab.load_machine(Path("docs/machines/two_planes.toml"))
    end = ab.verdict(ab.simulate(machine, duration=12.0, save=ab.LastRevolutions()))
    before = service_of(machine, assemble(machine), 4000.0 * np.pi / 30.0)
    assert abs(largest_unbalance(machine)) == pytest.approx(1e-4) == pytest.approx(end.static_unbalance, rel=1e-9)
    assert before is not None
    assert before.added_up
    assert before.unbalance == pytest.approx(end.unbalance, rel=1e-6)
    # a couple of 10 kg mm² at 60 degrees, and 100 g mm at 20 mm, which is 5 mm below the middle between the planes
    assert end.couple_unbalance == pytest.approx(abs(1e-5 * np.exp(1j * np.pi / 3.0) - 1e-4 * 5e-3), rel=1e-6)
    assert "of 123 g mm, the needs of the planes added up" in service_rows(before, rpm_and_si)[0][1]
    assert "of 123 g mm" in str(end)
    assert "of 100 g mm, couple about their middle" in str(end)


def test_a_sweep_gives_the_measures_and_the_verdict_of_single_runs() -> None:
    machine = ab.load_machine(MACHINES / "two_plane_rotor.toml")
    path = "rotor.polar_inertia"
    found = ab.sweep(machine, {path: [0.02, 0.08]}, duration=8.0)
    for i, inertia in enumerate(found["rotor_polar_inertia"].values):
        run = ab.simulate(ab.with_parameter(machine, path, float(inertia)), duration=8.0, tolerance=1e-7)
        one, there = ab.verdict(run), found.isel(rotor_polar_inertia=i)
        assert there["verdict"] == one.word
        worst = max(place.vibration for place in one.places)
        # the sweep's envelope is coarser, so that its last twentieth begins a little later
        assert float(there["vibration"]) == pytest.approx(worst, rel=0.05, abs=1e-9)
        assert float(there["residual_unbalance"]) == pytest.approx(one.residual, rel=1e-2, abs=1e-9)
        assert float(there["vibration_without_balls"]) == max(place.without_balls for place in one.places)
        assert float(there["support_force"]) == pytest.approx(
            max(s.vibrating for s in one.supports), rel=1e-2, abs=1e-4
        )


def test_the_command_prints_the_verdict_first_within_eighty_columns(tmp_path: Path) -> None:
    machine = str(MACHINES / "two_plane_rotor.toml")
    answer = CliRunner(env={"COLUMNS": "80"}).invoke(app, ["simulate", machine, "--out", str(tmp_path / "r.nc")])
    assert answer.exit_code == 0
    lines = answer.stdout.splitlines()
    assert lines[0].startswith("balanced, but the greatest deflection on the way is ")
    assert max(map(len, lines[:-1])) <= 80
    assert "ISO 21940-11" in answer.stdout
    shown = CliRunner().invoke(app, ["simulate", machine, "--out", str(tmp_path / "r.nc"), "--json"])
    told = json.loads(shown.stdout)["verdict"]
    assert told["word"] == "balanced"
    assert told["peak_without_balls"]["deflection"] > 0.0


def test_a_passage_that_balls_make_worse_is_said_in_the_first_line_and_speeds_follow_their_unit(tmp_path: Path) -> None:
    machine = MACHINES / "two_plane_rotor.toml"
    command = ["simulate", str(machine), "--out", str(tmp_path / "r.nc"), "--speed-unit", "rad/s"]
    shown = CliRunner(env={"COLUMNS": "80"}).invoke(app, command).stdout
    assert "rpm" not in shown
    assert max(map(len, shown.splitlines()[:-1])) <= 80
    run, held = ab.load_run(tmp_path / "r.nc"), ab.simulate(machine, hold_balls=True)
    found = ab.verdict(run, held)
    times = float(ab.run_measures(run, "peak_deflection")["deflection"]) / float(
        ab.run_measures(held, "peak_deflection")["deflection"]
    )
    assert times > 1.5
    assert found.as_dict()["peak_ratio"] == pytest.approx(times, rel=1e-12)
    said = f"balanced, but the greatest deflection on the way is {times:.3g} times as much as without balls"
    assert said in str(found).splitlines()[0]
    assert said in " ".join(shown.split())
    assert found.peak_without_balls is not None
    for more, text in ((1.09, ""), (1.42, ", but the greatest deflection on the way is 42 % worse than without balls")):
        peak = replace(found.peak_without_balls, deflection=more * found.peak_without_balls.deflection)
        assert headline(replace(found, peak=peak)).startswith(f"balanced{text}{'' if text else ':'}")
    assert found.peak is not None
    assert f"at {found.peak.speed:.3g} rad/s" in shown
    assert "on the way" not in str(ab.verdict(run))  # nothing to compare with
    assert "on the way" not in str(ab.verdict(run, run))  # as great as without


def test_without_a_run_with_held_balls_the_verdict_says_how_to_compare_the_peak(balanced: xr.Dataset) -> None:
    """The command compares the greatest deflection with a run that it makes; a verdict in Python without one says so."""
    alone = str(ab.verdict(balanced))
    assert "not computed; verdict(run, held) compares it" in alone
    compared = ab.verdict(balanced, ab.simulate(at_speed("two_plane_rotor.toml", 600.0), hold_balls=True, duration=0.5))
    assert "not computed" not in str(compared)
    held = ab.simulate(at_speed("two_plane_rotor.toml", 600.0), hold_balls=True, duration=0.5)
    assert "not computed" not in str(ab.verdict(held))


def test_large_unbalances_are_written_in_larger_units_and_never_with_an_exponent(tmp_path: Path) -> None:
    texts = [moment_text(value) for value in (5e-4, 1e-2, 0.1, 0.14117, 7.0986, 500.0)]
    assert texts == ["500 g mm", "10000 g mm", "100 kg mm", "141 kg mm", "7.1 kg m", "500 kg m"]
    assert moment_text(0.14117, 5) == "141.17 kg mm"
    heavy = ab.with_parameter(ab.load_machine(MACHINES / "discoidal.toml"), "unbalances[1]", {"moment": "1e5 g*mm"})
    ab.save_machine(heavy, tmp_path / "heavy.toml")
    rows = CliRunner().invoke(app, ["check", str(tmp_path / "heavy.toml")], catch_exceptions=False).stdout
    assert "100 kg mm" in rows
    assert "e+0" not in rows


def test_two_races_are_compared_with_the_unbalance_together() -> None:
    one = ab.load_machine(MACHINES / "discoidal.toml")
    balancer = one.balancers[0]
    two = ab.with_parameter(one, "balancers", [balancer.model_copy(update={"races": 2 * balancer.races})])
    found = ab.check(two)
    rows = [(name, text) for name, text in summary_rows(found, rpm_and_si) if "times the unbalance" in text]
    assert [name for name, _ in rows] == ["all races"]
    assert f"{found.capability / found.unbalance:.3g} times" in rows[0][1]
    assert found.capability == pytest.approx(2.0 * ab.check(one).capability, rel=1e-12)


def test_a_force_that_holds_a_vertical_rotor_aside_is_no_vibration() -> None:
    machine = at_speed("stall_and_release.toml", 500.0)
    push = {"kind": "recorded_force", "time": [0.0, 0.5, 1.0, 4.0], "force": [0.0, 62.5, 62.5, 62.5]}
    pushed = ab.with_parameter(machine, "excitations", (push,))
    run, held = (ab.simulate(pushed, duration=4.0, hold_balls=hold) for hold in (False, True))
    found = ab.verdict(run, held)
    static = 62.5 / 625e3  # force over stiffness
    assert found.places[0].static == pytest.approx(static, rel=1e-3)
    assert found.places[0].vibration < 0.01 * static
    assert found.word == "balanced"
    assert ab.run_measures(run, "residual_vibration") < 0.01 * static
    assert float(ab.sweep(pushed, {"unbalance": [5e-4]}, duration=4.0)["vibration"][0]) < 0.01 * static
    assert f"vibration about {1e6 * static:.0f} µm" in str(
        [x.get_label() for x in ab.plot.run_up(run).axes[1].get_lines()]
    )


def test_check_says_that_the_speed_of_a_torque_drive_is_known_from_a_run_only() -> None:
    assert "highest speed" in repr(ab.check(ab.example("stall_and_release")))
    assert "known from a run only" in repr(ab.check(ab.example("stall_and_release")))
    assert "known from a run only" not in repr(ab.check(ab.example("discoidal")))
