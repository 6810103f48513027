"""The border speeds: numbers of the discoidal rig, limits, symmetries, and what is said where there is none."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.references.planar_linear import matrices
from tests.references.planar_states import Equilibrium, equilibria_of

import autobalancer as ab
from autobalancer import progress as patience
from autobalancer.assembly.quantities import si_value, value_of, with_quantity, with_value_at
from autobalancer.errors import AutobalancerError, QuestionError, UnitError
from autobalancer.machine import Machine
from autobalancer.stability.border import Borders
from autobalancer.stability.host.stations import plane
from autobalancer.stability.maps.balanced import (
    EqualBalls,
    PlanarBalancer,
    balanced_states,
    growth_rate,
    worst_case_border,
)
from autobalancer.stability.maps.exact import border_of, borders_of
from autobalancer.stability.states.ball_positions import spread_range
from autobalancer.stability.states.linearized import deciding_eigenvalues, eigensystem
from autobalancer.stability.summary import summary

MACHINES = Path(__file__).parents[1] / "examples" / "machines"
BALL = 6.656e-3 * 0.07695  # kg m, table 6.4 of Spannan (2021)


def rig(
    *,
    balls: list[dict[str, Any]] | None = None,
    beta: float = 5.468e-6,
    unbalance: float = 594e-6,
    races: list[dict[str, Any]] | None = None,
    **rotor: Any,
) -> Machine:
    """The discoidal rig of table 6.4 with oil of 0.65 mm^2/s; its mass of 12.27 kg contains two balls."""
    balls = balls or [{"count": 2, "mass": "6.656 g", "diameter": "12.3 mm"}]
    race = {"orbit_radius": 0.07695, "drag": {"law": "viscous", "damping": beta}, "balls": balls}
    return Machine(
        name="rig",
        axis="vertical",
        rotor={"mass": 12.27 - 2 * 6.656e-3, "stiffness": 44654.0, "damping": 68.37, **rotor},
        unbalances=[{"moment": unbalance, "angle": 0.4}] if unbalance else [],
        balancers=[{"races": races or [race]}],
        drive={"kind": "speed", "profile": {"kind": "constant", "speed": 120.0}},
    )


def speeds(machine: Machine | Path, unbalance: complex | float | None = None) -> dict[str, float]:
    return {border.name: border.speed for border in ab.stability.borders(machine, unbalance)}


def at_angle(degrees: float) -> float:
    """The unbalance that two balls balance at this angle to both sides of it."""
    return -2.0 * BALL * math.cos(math.radians(degrees))


@pytest.mark.parametrize(
    ("degrees", "low", "high"),
    [
        *((d, 78.75, 79.85) for d in (95.0, 105.0, 115.0, 120.0, 125.0, 150.0, 165.0, 179.0)),
        (130.0, 80.9, 81.1),
        (133.0, 116.6, 117.4),
        (134.0, 200.0, 203.0),
        (140.0, 80.9, 81.1),
    ],
)
def test_the_exact_border_of_the_discoidal_rig_is_level_but_for_a_band_about_135_degrees(
    degrees: float, low: float, high: float
) -> None:
    assert low < speeds(rig(), at_angle(degrees))["exact border"] < high


def test_at_135_degrees_the_discoidal_rig_is_never_stable_and_the_other_borders_are_those_of_the_notes() -> None:
    found = {border.name: border for border in ab.stability.borders(rig(), at_angle(135.0))}
    critical = plane(rig()).critical_speeds[0]
    assert math.isinf(found["exact border"].speed)
    assert f"none up to {40.0 * critical:.4g} rad/s" in found["exact border"].note
    assert math.isinf(found["averaged border"].speed)
    assert math.isinf(found["exact border, worst case"].speed)
    assert found["release speed"].speed == pytest.approx(368.4, abs=0.1)


@pytest.mark.parametrize("seed", range(12))
def test_the_explicit_curve_is_the_border_of_the_eigenvalues_at_right_angles(seed: int) -> None:
    random = np.random.default_rng(seed)
    machine = with_quantity(rig(damping=float(random.uniform(40.0, 300.0))), "drag", 10 ** random.uniform(-4.3, -3.0))
    p = plane(machine, math.sqrt(2.0) * BALL)
    explicit = worst_case_border(EqualBalls(p).balancer)
    found = {border.name: border for border in borders_of(machine, p)}
    assert found["exact border"].speed == pytest.approx(explicit, rel=1e-8)
    assert found["exact border, worst case"].speed >= explicit * (1.0 - 1e-12)


@pytest.mark.parametrize("seed", range(8))
def test_no_unbalance_has_a_border_above_the_worst_case(seed: int) -> None:
    random = np.random.default_rng(seed)
    damping, beta = 10 ** random.uniform(-0.5, 2.5), 10 ** random.uniform(-5.5, -3.5)
    machine = rig(damping=damping, beta=beta)
    worst = speeds(machine)["exact border, worst case"]
    for share in np.linspace(0.0, 2.0, 23):
        assert speeds(machine, share * BALL)["exact border"] <= worst * (1.0 + 1e-6)


def test_for_a_lightly_damped_rotor_balls_in_line_are_worse_than_balls_at_right_angles() -> None:
    machine = rig(damping=1.1, beta=1e-4, balls=[{"count": 2, "mass": "60 g", "diameter": "25 mm"}])
    worst = next(border for border in ab.stability.borders(machine) if border.name == "exact border, worst case")
    assert "in line" in worst.note
    balancer = EqualBalls(plane(machine)).balancer
    assert worst.speed > 1.01 * worst_case_border(balancer)
    assert growth_rate(balancer, 0.999 * worst.speed, 2.0) > 0.0 > growth_rate(balancer, 1.001 * worst.speed, 2.0)


@pytest.mark.parametrize("s", [0.02, 0.05])
def test_averaged_and_exact_border_agree_for_heavy_drag_and_small_s(s: float) -> None:
    machine = rig()
    p = plane(machine)
    critical = math.sqrt(p.stiffness[0] / p.mass)
    beta = 10.0 * p.inertia[0] * critical
    p = replace(p, drag=np.full(2, beta), damping=((BALL * critical) ** 2 / (s * beta),) * 2)
    p = replace(p, unbalance=complex(math.sqrt(2.0) * BALL))
    found = {border.name: border.speed / critical - 1.0 for border in borders_of(machine, p)}
    assert found["exact border"] == pytest.approx(found["averaged border"], rel=0.03)
    assert found["release speed"] == pytest.approx(2.0 * found["averaged border"], rel=0.06)


@pytest.mark.parametrize(
    ("of_mass", "of_time", "of_length"), [(3.0, 1.0, 1.0), (1.0, 0.2, 1.0), (1.0, 1.0, 7.0), (2, 3, 0.5)]
)
def test_borders_scale_with_time_only(of_mass: float, of_time: float, of_length: float) -> None:
    p = plane(rig(beta=3e-5))
    m, t, size = of_mass, of_time, of_length
    scaled = replace(
        p,
        mass=m * p.mass,
        stiffness=(m / t**2 * p.stiffness[0],) * 2,
        damping=(m / t * p.damping[0],) * 2,
        unbalance=m * size * p.unbalance,
        ball_mass=m * p.ball_mass,
        moment=m * size * p.moment,
        inertia=m * size**2 * p.inertia,
        drag=m * size**2 / t * p.drag,
    )
    for one, other in zip(borders_of(rig(), p), borders_of(rig(), scaled), strict=True):
        assert other.speed == pytest.approx(one.speed / t, rel=1e-9)


def test_the_direction_of_the_unbalance_and_a_mirrored_machine_make_no_difference() -> None:
    reference = speeds(rig(), 300e-6)
    for turned in (300e-6 * np.exp(2.1j), -300e-6 + 0j):
        assert speeds(rig(), complex(turned)) == pytest.approx(reference, rel=1e-9)


def test_two_races_with_a_ball_each_are_one_race_with_two() -> None:
    race = {"orbit_radius": 0.07695, "drag": {"law": "viscous", "damping": 5.468e-6}}
    ball = {"mass": "6.656 g", "diameter": "12.3 mm"}
    assert speeds(rig(races=[{**race, "balls": [ball]}] * 2)) == pytest.approx(speeds(rig()), rel=1e-12)


def test_balls_that_are_nearly_equal_have_nearly_the_border_of_equal_balls() -> None:
    balls = [{"mass": f"{mass} g", "diameter": "12.3 mm"} for mass in (6.656 * (1.0 + 1e-9), 6.656)]
    found = speeds(rig(balls=balls))
    assert balanced_states(plane(rig(balls=balls)))[0].route == "eigenvalues"
    assert found["exact border"] == pytest.approx(speeds(rig())["exact border"], rel=1e-7)
    assert found["release speed"] == pytest.approx(speeds(rig())["release speed"], rel=1e-7)


def test_supports_that_are_nearly_isotropic_have_nearly_the_border_of_isotropic_ones() -> None:
    machine = rig(stiffness=(44654.0, 44654.0 * (1.0 + 1e-7)), beta=1e-4)
    assert balanced_states(plane(machine))[0].route == "multipliers of a rotor at rest"
    reference = speeds(rig(beta=1e-4))
    assert speeds(machine)["exact border"] == pytest.approx(reference["exact border"], rel=1e-6)
    assert speeds(machine)["release speed"] == pytest.approx(reference["release speed"], rel=0.02)


def test_a_race_that_is_hardly_eccentric_has_the_border_of_a_centric_one() -> None:
    race = rig().balancers[0].races[0]
    eccentric = with_value_at(rig(), "balancers[1].races[1]", race.model_copy(update={"eccentricity": 1e-12}))
    assert speeds(eccentric)["exact border"] == pytest.approx(speeds(rig())["exact border"], rel=1e-5)


@pytest.mark.parametrize("count", [2, 3])
def test_an_eccentric_race_has_the_growth_rates_of_its_eigenvalues_where_the_balls_can_balance(count: int) -> None:
    machine = with_quantity(ab.load_machine(MACHINES / "eccentric_race.toml"), "count", count)
    p = plane(machine)
    followed = np.array([100.0, 200.0, 255.0, 280.0, 300.0, 500.0])
    low, high = (EqualBalls(p, place).rates(followed) for place in (0.0, 1.0))
    for speed, one, other in zip(followed, low, high, strict=True):
        states = [state for state in equilibria_of(p, float(speed)) if state.name == "balanced"]
        assert bool(states) == bool(np.isfinite(one))
        for state in states[:1]:
            values, _ = eigensystem(*matrices(p, float(speed), state))
            rate = float(deciding_eigenvalues(values, count - 2).real.max())
            assert min(one, other) - 1e-6 <= rate <= max(one, other) + 1e-6
    assert np.isnan(low[0])
    assert np.isfinite(low[-3:]).all()


@pytest.mark.parametrize("count", [3, 4, 5])
def test_the_eigenvalues_of_more_balls_depend_on_their_positions_through_s2_only(count: int) -> None:
    random = np.random.default_rng(count)
    for _ in range(20):
        angles = random.uniform(-math.pi, math.pi, count)
        share, spread = abs(np.exp(1j * angles).sum()), abs(np.exp(2j * angles).sum())
        low, high = spread_range(count, float(share))
        assert low - 1e-6 <= spread <= high + 1e-6
        ball = [{"count": count, "mass": "6.656 g", "diameter": "12.3 mm"}]
        machine = rig(balls=ball, unbalance=float(share * BALL))
        p = plane(machine)
        state = Equilibrium("balanced", angles, 0j, count - 2, 0)
        values, _ = eigensystem(*matrices(p, 80.0, state))
        rate = float(deciding_eigenvalues(values, count - 2).real.max())
        assert growth_rate(EqualBalls(p).balancer, 80.0, float(spread)) == pytest.approx(rate, abs=1e-9 * 60.0)


def test_more_than_two_balls_have_a_worst_and_a_best_border_and_a_note() -> None:
    machine = rig(balls=[{"count": 5, "mass": "4 g", "diameter": "12.3 mm"}], beta=1e-4)
    found = {border.name: border for border in ab.stability.borders(machine)}
    best, exact = found["exact border, best case"], found["exact border"]
    assert best.speed < exact.speed <= found["exact border, worst case"].speed * (1.0 + 1e-9)
    assert "|S2| from 0 to" in exact.note
    assert "best" in exact.note
    assert "best" in best.note


@pytest.mark.parametrize(
    ("count", "share", "low", "high"),
    [
        (2, 0.7, 1.51, 1.51),
        (3, 0.0, 0.0, 0.0),
        (3, 2.0, 0.0, math.sqrt(1.5)),
        (4, 1.0, 0.0, 3.5),
        (6, 4.5, 0.75, None),
        (5, 5.0, 5, 5),
    ],
)
def test_the_range_of_s2_is_known_where_it_can_be_worked_out(
    count: int, share: float, low: float, high: float | None
) -> None:
    found = spread_range(count, share)
    assert found[0] == pytest.approx(low, abs=1e-6)
    assert high is None or found[1] == pytest.approx(high, abs=1e-6)


def test_stable_windows_are_stable_inside_and_unstable_outside() -> None:
    # a light rotor damping and light balls: the first window lies just above the critical speed
    machine = rig(damping=12.0, beta=2e-5, balls=[{"count": 2, "mass": "60 g", "diameter": "25 mm"}], unbalance=1e-4)
    found = ab.stability.stable_windows(machine, 400.0)
    assert len(found.windows) == 2
    assert found.windows[-1][0] == pytest.approx(speeds(machine)["exact border"], rel=1e-9)
    edges = [edge for window in found.windows for edge in window][:-1]
    for number, edge in enumerate(edges):
        rates = ab.stability.eigenvalues(machine, [edge * (1.0 - 1e-5), edge * (1.0 + 1e-5)])["growth_rate"].values
        assert (rates[0] < 0.0) == bool(number % 2)
        assert (rates[1] < 0.0) != bool(number % 2)


def test_on_orthotropic_supports_the_windows_are_those_of_the_forward_whirl() -> None:
    machine = rig(
        stiffness=(40e3, 60e3),
        damping=20.0,
        beta=3e-3,
        balls=[{"count": 2, "mass": "2 g", "diameter": "8 mm"}],
        unbalance=2e-4,
    )
    found = ab.stability.stable_windows(machine, 120.0, lowest=45.0)
    mass = plane(machine).mass
    low, middle, high = (math.sqrt(k / mass) for k in (40e3, 50e3, 60e3))
    assert [edge for window in found.windows for edge in window][:-1] == pytest.approx([low, middle, high], rel=0.01)


def nothing_without_a_note(machine: Machine, unbalance: float | None = None) -> dict[str, Any]:
    found = ab.stability.borders(machine, unbalance)
    assert all(border.note for border in found if not math.isfinite(border.speed))
    return {border.name: border for border in found}


def test_what_does_not_exist_says_why() -> None:
    found = nothing_without_a_note(rig(), 2e-3)
    weak = found["exact border"]
    assert math.isnan(weak.speed)
    assert all("not of this one" in found[name].note for name in ("averaged border", "exact border, worst case"))
    assert "1021 g mm at most, the unbalance is 2000 g mm" in weak.note
    single = nothing_without_a_note(ab.load_machine(MACHINES / "one_ball_run_up.toml"))
    assert all("one ball alone" in single[name].note for name in ("exact border", "exact border, worst case"))
    assert single["exact border, worst case"].known
    balls = [{"mass": f"{mass} g", "diameter": "12.3 mm"} for mass in (9.0, 5.0)]
    unequal = nothing_without_a_note(rig(balls=balls), 1e-4)["exact border"]
    assert "unequal balls always add up to 307.8 g mm" in unequal.note
    for undamped in (rig(damping=0.0), rig(beta=0.0), rig(damping=0.0, beta=0.0)):
        found = nothing_without_a_note(undamped)
        assert math.isinf(found["release speed"].speed)
        assert math.isinf(found["averaged border"].speed)
        assert "without damping" in found["exact border"].note
    assert "without damping" not in nothing_without_a_note(rig())["exact border"].note
    assert ab.stability.stable_windows(rig(), 500.0, unbalance=2e-3).note.startswith("no balanced state")


def test_exactly_at_the_critical_speed_of_an_undamped_rotor_nothing_breaks() -> None:
    machine = rig(damping=0.0, unbalance=594e-6)
    critical = math.sqrt(44654.0 / plane(machine).mass)
    found = ab.stability.stable_windows(machine, 2.0 * critical, lowest=critical)
    assert found.windows == ()
    assert found.note
    assert ab.stability.stable_windows(rig(), 2.0 * critical, lowest=critical).windows


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda: ab.stability.borders(rig(), -1.0), "must be a size not below zero"),
        (lambda: ab.stability.borders(rig(), math.nan), "must be a size not below zero"),
        (lambda: ab.stability.stable_windows(rig(), 10.0, lowest=20.0), "they must ascend"),
        (lambda: ab.stability.stable_windows(rig(), math.inf), "they must ascend"),
        (lambda: ab.stability.borders(with_value_at(rig(), "balancers", ())), "has no balls"),
        (lambda: ab.stability.border_curve(rig(), "mass", [1.0]), "no such name; there are viscosity, drag"),
        (lambda: ab.stability.border_curve(rig(), "unbalanc"), "did you mean 'unbalance'"),
        (lambda: ab.stability.border_curve(rig(), "ball_mass"), "give those of 'ball_mass'"),
        (lambda: ab.stability.border_curve(rig(), "ball_mass", []), "given none"),
        (lambda: ab.stability.border_curve(rig(), "viscosity", [1e-6]), "which no viscosity changes"),
        (lambda: ab.stability.border_curve(rig(), "rotor.colour", [1e-6]), "no 'colour' there"),
        (lambda: ab.stability.minimum_viscosity(rig(), 80.0), "which no viscosity changes"),
        (lambda: ab.stability.minimum_drag(rig(), 80.0, "border"), "given 'border'; must be 'averaged border'"),
        (lambda: ab.stability.minimum_drag(rig(), -80.0), "must be greater than zero"),
        (lambda: ab.stability.minimum_drag(rig(), 80.0, unbalance=1.0), "can balance 1021 g mm at most"),
        (lambda: with_quantity(rig(), "count", 2.5), "whole number of balls"),
        (lambda: with_quantity(rig(), "unbalance", -1.0), "must not be negative"),
    ],
)
def test_bad_questions_are_refused_with_a_reason(ask: Any, message: str) -> None:
    with pytest.raises(QuestionError, match=message.replace("(", r"\(")):
        ask()


def test_a_quantity_of_another_dimension_is_refused() -> None:
    with pytest.raises(UnitError, match="rad/s is wanted"):
        ab.stability.minimum_drag(rig(), "80 mm")
    with pytest.raises(AutobalancerError):
        ab.stability.border_curve(rig(), "ball_diameter", ["3 m"])


def test_the_border_over_the_unbalance_peaks_where_the_balls_are_at_right_angles() -> None:
    found = ab.stability.border_curve(rig(), "unbalance")
    share = found["unbalance"].values / BALL
    assert share[0] == 0.0
    touching = 2.0 * math.cos(math.asin(0.5 * 12.3 / 76.95))  # two balls side by side
    assert share[-1] == pytest.approx(touching, rel=1e-12)
    never = np.isinf(found["exact_border"].values)
    assert never.any()
    # no border near the right angle; the points about it, each a quarter farther off than the last, have one from 0.0149 on
    band = np.abs(share - math.sqrt(2.0)) < 0.0148
    np.testing.assert_array_equal(never, band)
    assert np.isfinite(found["exact_border"].values[np.abs(share - math.sqrt(2.0)) > 0.02]).all()
    assert all(found["exact_border_note"].values[never])
    one = float(found["exact_border"][20])
    assert one == pytest.approx(speeds(rig(), float(found["unbalance"][20]))["exact border"], rel=1e-12)
    assert np.isinf(found["averaged_border"]).all()


def test_a_border_curve_has_the_borders_of_each_machine_and_can_be_stored(tmp_path: Path) -> None:
    path, values = "balancers[1].races[1].drag.damping", [1e-5, "1e-4 N*m*s"]
    by_path, by_name = ab.stability.border_curve(rig(), path, values), ab.stability.border_curve(rig(), "drag", values)
    for number, beta in enumerate((1e-5, 1e-4)):
        for name, speed in speeds(rig(beta=beta)).items():
            variable = name.replace(", ", "_").replace(" ", "_")
            assert float(by_path[variable][number]) == float(by_name[variable][number]) == speed
    ab.save_run(by_path, tmp_path / "curve.nc")
    assert ab.load_run(tmp_path / "curve.nc")["exact_border"].equals(by_path["exact_border"])


@pytest.mark.parametrize("which", ["exact border", "exact border, worst case", "averaged border", "release speed"])
def test_with_the_least_viscosity_the_border_is_the_speed_asked_for(which: str) -> None:
    machine = ab.load_machine(MACHINES / "discoidal.toml")
    least = ab.stability.minimum_viscosity(machine, "80 rad/s", which)
    assert speeds(with_quantity(machine, "viscosity", least))[which] == pytest.approx(80.0, rel=1e-6)
    assert speeds(with_quantity(machine, "viscosity", 1.2 * least))[which] < 80.0
    assert speeds(with_quantity(machine, "viscosity", least / 1.2))[which] > 80.0


def test_the_least_drag_is_that_of_the_closed_forms_and_none_helps_below_the_critical_speed() -> None:
    machine = rig()
    critical = math.sqrt(44654.0 / plane(machine).mass)
    pull = (BALL * critical) ** 2 / 68.37
    averaged = pull * (80.0**2 + critical**2) / (80.0**2 - critical**2)
    assert ab.stability.minimum_drag(machine, 80.0, "averaged border") == pytest.approx(averaged, rel=1e-8)
    release = 2.0 * pull * critical / (80.0 - critical)
    assert ab.stability.minimum_drag(machine, 80.0, "release speed") == pytest.approx(release, rel=1e-8)
    assert math.isinf(ab.stability.minimum_drag(machine, 0.99 * critical))


def test_unequal_balls_break_away_one_after_the_other() -> None:
    machine = rig(balls=[{"mass": f"{mass} g", "diameter": "12.3 mm"} for mass in (9.0, 3.0)], beta=1e-4)
    p = plane(machine)
    critical = math.sqrt(p.stiffness[0] / p.mass)
    heavy, light = p.moment
    pull = critical**3 / (68.37 * 1e-4)
    first = critical + light * (heavy + light) * pull  # the light ball goes first, then the heavy one hangs alone
    assert speeds(machine)["release speed"] == pytest.approx(max(first, critical + heavy**2 * pull), rel=1e-12)


def test_each_quantity_changes_what_it_says_and_nothing_else() -> None:
    machine = ab.load_machine(MACHINES / "discoidal.toml")
    for name, value in (
        ("viscosity", "5 mm^2/s"),
        ("ball_mass", "7 g"),
        ("ball_diameter", "10 mm"),
        ("count", 4),
        ("unbalance", "300 g*mm"),
        ("damping", "80 N*s/m"),
        ("stiffness", "50 kN/m"),
        ("drag", "1e-4 N*m*s"),
    ):
        changed = with_quantity(machine, name, value)
        assert value_of(changed, name) == pytest.approx(si_value(machine, name, value), rel=1e-12)
        others = {"viscosity", "ball_mass", "ball_diameter", "count", "unbalance", "damping", "stiffness"} - {name}
        others -= {"ball_mass"} if name == "ball_diameter" else {"viscosity"} if name == "drag" else set()
        for other in others:
            assert value_of(changed, other) == pytest.approx(value_of(machine, other), rel=1e-12)
    assert value_of(with_quantity(machine, "ball_diameter", "6.15 mm"), "ball_mass") == pytest.approx(
        value_of(machine, "ball_mass") / 8.0, rel=1e-12
    )
    assert abs(plane(with_quantity(rig(), "unbalance", 1e-4)).unbalance - 1e-4 * np.exp(0.4j)) < 1e-18


def test_the_border_of_a_scaled_balancer_is_that_of_the_unscaled_one() -> None:
    unit = PlanarBalancer(1.0, 1.0, 0.1, 2, 0.02, 1.0, 0.05)
    big = PlanarBalancer(4.0, 4.0 * 9.0, 0.1 * 4.0 * 3.0, 2, 0.02 * 4.0, 4.0, 0.05 * 4.0 * 3.0)
    assert worst_case_border(big) == pytest.approx(3.0 * worst_case_border(unit), rel=1e-12)


def test_a_speed_in_a_window_below_the_border_is_not_called_unstable() -> None:
    rig = ab.example("discoidal_rig")
    (rate,) = ab.stability.eigenvalues(rig, [1200.0 * math.pi / 30.0])["growth_rate"].values
    assert rate < 0.0
    (border,) = [
        border for border in ab.stability.borders(rig, only=("exact border",)) if border.name == "exact border"
    ]
    assert border.speed > 1200.0 * math.pi / 30.0
    (warning,) = [text for text in ab.check(rig).warnings if "below the exact border" in text]
    assert "only in the ranges" in warning


@pytest.mark.parametrize(("name", "value"), [("damping", 1.0), ("damping", 0.0), ("drag", 1e-6)])
def test_a_border_that_is_never_reached_is_not_called_so_twice(name: str, value: float) -> None:
    never = [one for one in ab.stability.borders(ab.with_parameter(rig(), name, value)) if math.isinf(one.speed)]
    assert never
    assert not [one for one in never if one.note.startswith("never") or not one.note]


def test_a_check_says_what_it_did_not_find_in_time_and_the_question_itself_has_no_limit(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    race = {
        "orbit_radius": 0.07695,
        "drag": {"law": "viscous", "damping": 5e-6},
        "friction": {"rolling_resistance": 1e-4, "adherence": 1e-4},
        "balls": [{"count": 2, "mass": 1e-3, "diameter": 2e-3}],
    }
    off_center = rig(races=[race | {"eccentricity": 1e-5 * (1 + k)} for k in range(2)])
    several = rig(races=[race | {"balls": [{"count": 1, "mass": 1e-3 * (1 + k), "diameter": 2e-3} for k in range(2)]}])
    monkeypatch.setattr(patience, "SOON", 0.0)
    words: list[str] = []
    found = summary(off_center, words.append, seconds=0.0)
    left_out = {border.name for border in found.borders if "not found in 0 s of computing" in border.note}
    assert left_out >= {"averaged border", "exact border"}
    assert found.friction is not None
    assert "not found in 0 s" in found.friction.note
    assert {"the averaged border", "what friction holds", "the critical speeds"} <= set(words)
    late = {one.name: one.note for one in summary(several, seconds=0.0).borders}
    assert "'autobalancer borders FILE' (ab.stability.borders) looks as long as it takes" in late["release speed"]
    assert late["release speed"] == late["capture speed"]
    assert all(border.known for border in ab.stability.borders(off_center) if border.name in left_out)


def test_on_a_horizontal_axis_all_borders_are_those_without_gravity_and_say_so() -> None:
    lying = with_value_at(rig(), "axis", "horizontal")
    beside = {border.name: border.speed for border in ab.stability.borders(rig())}
    found = ab.stability.borders(lying)
    assert {border.name: border.speed for border in found} == pytest.approx(beside, rel=1e-12, nan_ok=True)
    assert all("ignores gravity in the plane" in border.note for border in found if not math.isnan(border.speed))
    assert [border.note for border in ab.check(lying).borders] == [border.note for border in found]
    assert ab.stability.stable_windows(lying, 300.0).note.endswith("ignores gravity in the plane")
    assert ab.stability.minimum_drag(lying, 80.0) == ab.stability.minimum_drag(rig(), 80.0)
    with pytest.raises(QuestionError, match="gravity acts in the plane"):  # nothing rests there
        ab.stability.equilibria(lying, 100.0)


DRUM = """
name = "drum"
axis = "vertical"
rotor = { kind = "planar", mass = "45 kg", critical_speed = "280 rpm", damping_ratio = "6 %" }
drive = { kind = "speed", profile = { kind = "ramp", end = "600 rpm", duration = "12 s" } }
unbalances = [{ moment = "70 kg*mm" }]
run = { duration = "40 s" }
[[balancers]]
[[balancers.races]]
orbit_radius = "230 mm"
fluid = { name = "silicone oil 5", temperature = "25 degC" }
drag = { law = "sphere_on_plane", range = "whole" }
balls = [{ count = 8, diameter = "25 mm", material = "steel" }]
"""


def test_where_only_some_positions_of_the_balls_are_stable_nothing_says_that_none_is(tmp_path) -> None:
    (tmp_path / "drum.toml").write_text(DRUM)
    drum = ab.load_machine(tmp_path / "drum.toml")
    p, top = plane(drum), np.array([600.0 * math.pi / 30.0])
    low, high = spread_range(8, 0.07 / float(p.moment[0]))
    rates = [growth_rate(EqualBalls(p).balancer, float(top[0]), float(spread)) for spread in (low, high)]
    assert rates[0] > 0.0 > rates[1]  # |S2| = 0 is unstable, balls more in line are stable
    (exact,) = (border for border in ab.stability.borders(drum, only=["exact border"]) if border.name == "exact border")
    assert math.isinf(exact.speed)
    first = max(
        border_of(member, p).speed for member in balanced_states(p) if member.place == 0.3
    )  # of those that are tried
    assert exact.best == pytest.approx(first, rel=1e-12) == pytest.approx(395.0 * math.pi / 30.0, rel=1e-3)
    assert repr(exact).startswith(
        "exact border: from 394.98 rpm (41.363 rad/s) at the best positions of the balls, never at all"
    )
    found = ab.check(drum)
    (warning,) = (text for text in found.warnings if "balanced state" in text)
    assert warning.startswith("the balanced state is stable at the highest speed at some positions of the balls only")
    assert "41.36 rad/s" in warning
    oil = ab.stability.minimum_viscosity(drum, "600 rpm")  # the advice
    thick = ab.with_parameter(drum, "viscosity", 1.001 * oil)
    assert not [text for text in ab.check(thick).warnings if "balanced state" in text]
    assert Borders([exact]).row(exact)[:3] == ("exact border", "some positions", "some positions")
    (shown,) = (
        column.values for column in ab.compare([drum], duration="0.1 s").columns() if column.head == "exact border"
    )
    assert shown == ["some positions"]
    assert [text.get_text() for text in ab.plot.borders([exact]).axes[0].texts] == [
        "  from 394.98 rpm at the best positions of the balls, never at all positions"
    ]


def test_a_balanced_state_that_is_stable_nowhere_is_said_to_be_so_at_all_positions(tmp_path) -> None:
    (tmp_path / "drum.toml").write_text(
        DRUM.replace("silicone oil 5", "silicone oil 0.65").replace("600 rpm", "500 rpm")
    )
    (warning,) = (text for text in ab.check(tmp_path / "drum.toml").warnings if "balanced state" in text)
    assert warning == (
        "the highest speed is below the exact border; the balanced state is not stable there at any position of the balls; "
        "take a thicker fluid"
    )


@pytest.mark.parametrize("viscosity", [50.0, 110.0, 140.0, 200.0])
def test_balls_are_not_captured_above_the_speed_at_which_they_are_released(tmp_path, viscosity: float) -> None:
    # with thick oil balls in line fall back in their fold above the speed at which stalled balls part
    (tmp_path / "drum.toml").write_text(DRUM)
    drum = ab.with_parameter(ab.load_machine(tmp_path / "drum.toml"), "viscosity", viscosity * 1e-6)
    release, capture = ab.stability.borders(drum, only=["release speed", "capture speed"])
    assert capture.speed <= release.speed
    assert ("part there and leave" in capture.note) == (capture.speed == release.speed) == (viscosity > 100.0)
