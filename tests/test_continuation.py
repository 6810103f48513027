"""Continuation: steady states, their bifurcations, curves of special points, against closed forms."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import typer
from scipy.optimize import brentq
from tests.references.balanced_pair import growth
from tests.references.machines import random_machine
from tests.references.pictures import size_of
from tests.references.rates import rates_at
from tests.references.two_balls import (
    DISCOIDAL,
    MACHINES,
    RACE,
    STALL,
    branch,
    specials,
    stall_machine,
    swinging,
    with_balls,
)
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.assembly.quantities import with_quantity, with_value_at
from autobalancer.assembly.system import assemble, steady
from autobalancer.cli.stability import branches as command
from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import load_race_machine
from autobalancer.kernels.balls.planar import planar
from autobalancer.machine import Machine
from autobalancer.stability.bifurcations import Point, Steps, follow, locate, lyapunov_coefficient
from autobalancer.stability.branch_diagrams import bifurcation_curves, branches
from autobalancer.stability.curve_explorer import Explorer
from autobalancer.stability.host.stations import of_plane, plane, stations
from autobalancer.stability.host.vector_field import Field
from autobalancer.stability.maps.balanced import growth_rate, planar_balancer_of, worst_case_border
from autobalancer.stability.periodic_orbits import DEGREE, Mesh
from autobalancer.stability.steady_curves import SMOOTH, Family, Range, Steady, expanded, kinds, merged

SEEDS = range(20)


def random_field(seed: int) -> tuple[Field, np.ndarray, np.ndarray]:
    """A field, a state and the sizes of its components."""
    random = np.random.default_rng(seed)
    machine = random_machine(random, isotropic=True, axis="vertical", drive="constant")
    p = plane(machine)
    n = p.moment.size
    scale = np.concatenate([[1e-3] * 2, [0.3] * 2, np.ones(n), np.full(n, 100.0)])
    return Field(of_plane(p), random.uniform(50.0, 400.0)), scale * random.uniform(-1.0, 1.0, 4 + 2 * n), scale


# the vector field


@pytest.mark.parametrize("seed", SEEDS)
def test_the_vector_field_is_that_of_the_compiled_equations(seed: int) -> None:
    random = np.random.default_rng(seed)
    machine = random_machine(random, isotropic=True, axis="vertical", drive="constant")
    field, state, _ = random_field(seed)
    system = assemble(machine, rotating=True).system._replace(drive=steady(field.speed, field.host.unbalance))
    full = np.concatenate([state[:4], [0.0, field.speed], state[4:]])
    expected = np.delete(rates_at(planar, 0.0, full, system), [4, 5])
    np.testing.assert_allclose(field(state), expected, rtol=0.0, atol=1e-13 * np.abs(expected).max())


@pytest.mark.parametrize("seed", SEEDS)
def test_the_derivatives_of_the_field_are_those_of_its_values(seed: int) -> None:
    field, state, scale = random_field(seed)
    random = np.random.default_rng(seed)
    u, v = (scale * random.normal(size=state.size) for _ in range(2))
    steps = 1e-2 * np.array([-2.0, -1.0, 1.0, 2.0])

    def difference(function: Any) -> np.ndarray:
        a, b, c, d = (function(state + h * v) for h in steps)
        return (a - 8.0 * b + 8.0 * c - d) / 12e-2

    for obtained, expected in (
        (field.jacobian(state) @ v, difference(field)),
        (field.second(state, u, v), difference(lambda x: field.jacobian(x) @ u)),
        (field.third(state, u, v), difference(lambda x: field.second(x, u, u))),
    ):
        np.testing.assert_allclose(obtained, expected, rtol=0.0, atol=2e-4 * np.abs(expected).max())
    np.testing.assert_allclose(field.taylor(state, v, 1)[1], field.jacobian(state) @ v, rtol=1e-9, atol=1e-9)


def test_quick_changes_of_a_parameter_are_those_of_the_described_machine() -> None:
    for name, value in (
        ("unbalance", 4e-4), ("drag", 3e-4), ("viscosity", 7e-6), ("ball_mass", 5e-3), ("damping", 50.0), ("stiffness", 6e4),
    ):  # fmt: skip
        quick, slow = Family(DISCOIDAL, [name], 80.0)(value).host, stations(with_quantity(DISCOIDAL, name, value))
        for key in ("load", "unbalance", "ball_mass", "moment", "inertia", "drag", "rows"):
            np.testing.assert_allclose(getattr(quick, key), getattr(slow, key), rtol=1e-13, err_msg=f"{name}: {key}")
        for key in ("mass", "stiffness", "damping", "gyroscopic"):
            one, other = getattr(quick.model, key), getattr(slow.model, key)
            np.testing.assert_allclose(one, other, rtol=1e-13, err_msg=f"{name}: {key}")


def test_balls_that_coincide_move_as_one_ball_of_their_sum() -> None:
    p = of_plane(plane(with_balls(4, "1.5 g")))
    groups = ((0, 2, 3), (1,))
    state = np.array([1e-4, -2e-4, 0.03, 0.01, 0.4, 2.0, -3.0, 5.0])
    whole = expanded(state, groups, 4)
    together, apart = Field(merged(p, groups), 300.0)(state), Field(p, 300.0)(whole)
    np.testing.assert_allclose(expanded(together, groups, 4), apart, rtol=1e-12, atol=1e-10)


# the method


class Circle:
    """x^2 + (2 p - 1)^2 = 1/4 with p the parameter's share."""

    weight = np.ones(2)

    def residual(self, u: np.ndarray) -> np.ndarray:
        return np.array([u[0] ** 2 + (u[1] - 0.5) ** 2 - 0.16])

    def solve(self, u: np.ndarray, row: np.ndarray, right: np.ndarray, last: float) -> np.ndarray:
        return np.linalg.solve(np.array([[2.0 * u[0], 2.0 * u[1] - 1.0], row]), np.append(right, last))

    def renewed(self, u: np.ndarray, tangent: np.ndarray) -> tuple[Circle, np.ndarray, np.ndarray]:
        return self, u, tangent


def test_arclength_goes_round_a_circle_through_its_folds() -> None:
    folds = []
    for problem, a, b in follow(Circle(), np.array([0.4, 0.5]), np.array([0.0, 1.0]), steps=Steps(count=150)):
        assert abs(problem.residual(b.u)[0]) < 1e-12
        if a.tangent[-1] * b.tangent[-1] < 0.0:
            folds.append(locate(problem, a, b, lambda p: float(p.tangent[-1])).u[-1])
    np.testing.assert_allclose(folds[:2], [0.9, 0.1], atol=1e-12)


class Planar:
    """x' = -w y + f, y' = w x + g with quadratic and cubic f and g, given by their second and third derivatives."""

    def __init__(self, w: float, second: np.ndarray, third: np.ndarray) -> None:
        self.w, self.b, self.c = w, second, third  # (2, 2, 2), (2, 2, 2, 2), symmetric in all but the first index

    def jacobian(self, u: np.ndarray) -> np.ndarray:
        return np.array([[0.0, -self.w], [self.w, 0.0]])

    def second(self, u: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return np.einsum("kij,i,j->k", self.b, a, b)

    def third(self, u: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return np.einsum("kijl,i,j,l->k", self.c, a, a, b)


@pytest.mark.parametrize("seed", range(5))
def test_the_lyapunov_coefficient_is_that_of_guckenheimer_and_holmes(seed: int) -> None:
    random = np.random.default_rng(seed)
    w, b, c = random.uniform(0.5, 3.0), random.normal(size=(2, 2, 2)), random.normal(size=(2, 2, 2, 2))
    b = 0.5 * (b + b.transpose(0, 2, 1))
    c = sum(c.transpose(0, *order) for order in ((1, 2, 3), (1, 3, 2), (2, 1, 3), (2, 3, 1), (3, 1, 2), (3, 2, 1)))
    (fxx, fxy, fyy), (gxx, gxy, gyy) = ((m[0, 0], m[0, 1], m[1, 1]) for m in b)
    cubic = c[0, 0, 0, 0] + c[0, 0, 1, 1] + c[1, 0, 0, 1] + c[1, 1, 1, 1]
    quadratic = fxy * (fxx + fyy) - gxy * (gxx + gyy) - fxx * gxx + fyy * gyy
    expected = (cubic + quadratic / w) / 16.0  # a' = expected a^3, their eq. (3.4.11)
    problem: Any = Planar(w, b, c)
    obtained = w * lyapunov_coefficient(problem, np.zeros(3), np.array([0.5, -0.5j]), w)
    assert obtained == pytest.approx(expected, rel=1e-10)


def test_collocation_converges_with_its_order_and_adapts_its_mesh() -> None:
    def error(count: int) -> float:
        mesh = Mesh(np.linspace(0.0, 1.0, count + 1))
        x = np.exp(np.sin(2.0 * np.pi * mesh.nodes))[:, None]
        times = np.linspace(0.0, 1.0, 777)
        return float(np.abs(mesh.interpolated(x, times)[:, 0] - np.exp(np.sin(2.0 * np.pi * times))).max())

    assert math.log2(error(10) / error(20)) > DEGREE + 0.5
    mesh = Mesh(np.linspace(0.0, 1.0, 21))
    narrow = mesh.adapted(np.exp(-((mesh.nodes - 0.5) ** 2) / 0.002)[:, None])
    assert np.diff(narrow.edges).min() < 0.03 < 2.0 * np.diff(narrow.edges).max()
    assert np.all(np.diff(narrow.edges) > 0.0)


# steady states


@pytest.mark.parametrize(
    "machine", [DISCOIDAL, STALL, with_balls(4, "1.5 g")], ids=["discoidal", "stall", "four balls"]
)
def test_the_balanced_state_ends_in_a_pitchfork_where_the_balls_just_suffice(machine: Machine) -> None:
    reach = float(plane(machine).moment.sum())
    found = branches(machine, "unbalance", 0.2 * reach, 1.5 * reach, speed=400.0, orbits=False)
    (point,) = specials(found, "pitchfork")
    assert float(point["special_parameter"]) == pytest.approx(reach, rel=1e-12)
    assert found.attrs["branch_ends"][0] == "pitchfork"
    coincident_states = branch(found, 2)
    below = coincident_states["parameter"] < reach * (1.0 - 1e-9)
    above = coincident_states["parameter"] > reach * (1.0 + 1e-9)
    assert (branch(found, 1)["verdict"][:-1] == "stable").all()
    assert (coincident_states["verdict"][below] == "unstable").all()
    assert (coincident_states["verdict"][above] == "stable").all()


def test_from_coincident_balls_the_balanced_state_is_found_and_takes_over_their_stability() -> None:
    found = branches(STALL, "ball_mass", "1 g", "6 g", speed=400.0, from_state="coincident", orbits=False)
    (point,) = specials(found, "pitchfork")
    assert float(point["special_parameter"]) == pytest.approx(2.5e-3, rel=1e-12)
    born = [int(i) for i in np.unique(found["branch"]) if (branch(found, int(i))["name"] == "balanced").mean() > 0.9]
    assert len(born) == 1
    assert (branch(found, born[0])["verdict"][1:] == "stable").all()


@pytest.mark.parametrize("share", [0.1, 0.3, 0.5, 0.65, 0.72, 0.85, 0.95])
@pytest.mark.parametrize(("machine", "low", "high"), [(DISCOIDAL, 61.0, 200.0), (STALL, 255.0, 600.0)])
def test_hopf_speeds_are_the_exact_border(machine: Machine, low: float, high: float, share: float) -> None:
    p = plane(machine)
    machine = with_quantity(machine, "unbalance", share * float(p.moment.sum()))
    closed = planar_balancer_of(plane(machine))
    spread = 2.0 * abs(2.0 * share**2 - 1.0)
    found = specials(branches(machine, "speed", low, high, orbits=False), "Hopf")
    assert found
    for point in found:
        speed = float(point["special_parameter"])
        exact = brentq(lambda w: growth_rate(closed, w, spread), speed - 0.05, speed + 0.05, xtol=1e-12)
        assert speed == pytest.approx(exact, abs=1e-8)


def test_coincident_balls_lose_their_place_at_a_fold_of_known_speed() -> None:
    p = plane(DISCOIDAL)
    (point,) = specials(branches(DISCOIDAL, "speed", 20.0, 200.0, from_state="coincident", orbits=False), "fold")
    w, reach = float(point["special_parameter"]), p.moment.sum() / abs(p.unbalance)
    k, b = p.stiffness[0], p.damping[0]
    assert (k - p.mass * w * w) ** 2 == pytest.approx((b * w) ** 2 * (reach**2 - 1.0), rel=1e-9)


@pytest.mark.parametrize(
    ("machine", "parameter", "start", "end"),
    [
        pytest.param(
            STALL, "speed", 245.0, 280.0, marks=pytest.mark.slow
        ),  # unbalance just as large as the balls balance
        # no two bundles balance the first of these
        pytest.param(with_balls(3, "2 g"), "unbalance", 5e-5, 9e-4, marks=pytest.mark.slow),
        pytest.param(with_balls(3, "2 g"), "speed", 300.0, 252.0, marks=pytest.mark.slow),
        (with_balls(1, "3 g"), "speed", 254.0, 262.0),  # about the critical speed
        (load_race_machine(MACHINES / "eccentric_race.toml"), f"{RACE}.eccentricity", 1e-6, 4e-5),
    ],
    ids=["in line", "three balls", "three balls over speed", "one ball", "eccentric"],
)
def test_symmetric_states_and_continua_are_followed(machine: Machine, parameter: str, start: float, end: float) -> None:
    speed = None if parameter == "speed" else 400.0
    found = branches(machine, parameter, start, end, speed=speed, from_state="all", orbits=False)
    span = Range(Family(machine, [parameter], speed), start, end)
    assert found["branch"].max() >= 2
    assert found.sizes["point"] < 1500
    for value in found["parameter"].values:
        assert min(start, end) - 1e-12 <= value <= max(start, end) + 1e-12
    assert span.length > 0.0


def test_three_balls_split_off_the_coincident_state_one_by_two() -> None:
    machine = with_balls(3, "2 g")
    found = branches(machine, "unbalance", 9e-4, 1e-4, speed=400.0, from_state="coincident", orbits=False)
    first = specials(found, "branch point")[0]
    assert float(first["special_parameter"]) == pytest.approx(6e-4, rel=1e-12)
    (last,) = specials(found, "pitchfork")  # two against one balance no less than the moment of one ball
    assert float(last["special_parameter"]) == pytest.approx(2e-4, rel=1e-12)


# two parameters


def test_the_hopf_curve_is_the_explicit_worst_case_curve() -> None:
    machine = with_quantity(STALL, "unbalance", float(plane(STALL).moment.sum()) * math.cos(math.pi / 4.0))
    found = bifurcation_curves(machine, "Hopf", "speed", 600.0, 252.0, "drag", 2e-5, 1e-3)
    closed = planar_balancer_of(plane(machine))
    assert found.sizes["point"] > 30
    for drag, speed in zip(found["second_parameter"].values, found["parameter"].values, strict=True):
        assert speed == pytest.approx(worst_case_border(replace(closed, drag=float(drag))), abs=1e-7)


def test_criticality_changes_at_a_bautin_point() -> None:
    found = bifurcation_curves(
        stall_machine(0.85, 1e-4), "Hopf", "speed", 300.0, 260.0, "drag", 6e-5, 3e-4, largest_step=0.1
    )
    assert found["special_type"].values.tolist() == ["Bautin"]
    drag = float(found["special_second_parameter"][0])
    sub = found["criticality"].values == "subcritical"
    assert np.array_equal(sub, found["second_parameter"].values < drag)
    assert len(ab.plot.answer(found).axes[0].lines) == 3


def test_the_fold_curve_of_coincident_balls_has_its_closed_form() -> None:
    found = bifurcation_curves(
        DISCOIDAL, "fold", "speed", 20.0, 100.0, "damping", 40.0, 150.0, from_state="coincident", largest_step=0.1
    )
    p = plane(DISCOIDAL)
    w, b = found["parameter"].values, found["second_parameter"].values
    reach = float(p.moment.sum()) / abs(p.unbalance)
    left, right = (p.stiffness[0] - p.mass * w**2) ** 2, (b * w) ** 2 * (reach**2 - 1.0)
    np.testing.assert_allclose(left, right, rtol=1e-9)


# results, pictures, commands, errors


@pytest.mark.slow
def test_a_result_says_what_it_holds_and_can_be_drawn_and_kept(tmp_path: Path) -> None:
    found = swinging(0.85)
    for name in ("parameter", "deflection_max", "growth_rate", "period", "special_parameter"):
        assert found[name].attrs["long_name"]
        assert found[name].attrs["units"]
    figure = ab.plot.branches(found, speed_unit="rad/s")
    assert figure.axes[-1].get_xlabel() == "rotor speed (rad/s)"
    assert {line.get_linestyle() for line in figure.axes[0].lines} >= {"-", "--"}
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    assert {"balanced", "stable", "unstable", "Hopf, subcritical"} <= set(texts)
    found.to_netcdf(tmp_path / "branches.nc")


def test_the_command_lists_the_hopf_point_of_the_balanced_state(tmp_path: Path) -> None:
    app = typer.Typer()
    app.command()(command)
    words = [
        str(MACHINES / "discoidal.toml"),
        "--over",
        "speed=100:62 rad/s",
        "--no-orbits",
        "--plot",
        str(tmp_path / "b.png"),
    ]
    answer = CliRunner().invoke(app, [*words, "--json"])
    point = json.loads(answer.stdout)["special"][0]
    assert growth(DISCOIDAL, point["parameter"]) == pytest.approx(0.0, abs=1e-7)
    assert growth(DISCOIDAL, point["parameter"] - 0.1) > 0.03 > -0.03 > growth(DISCOIDAL, point["parameter"] + 0.1)
    assert point["criticality"] == "supercritical"
    assert size_of(tmp_path / "b.png") == (1200, 990)
    assert "supercritical" in CliRunner().invoke(app, words[:-2]).stdout


def test_progress_is_reported_while_branches_are_followed() -> None:
    seen: list[tuple[int, float]] = []
    branches(DISCOIDAL, "speed", 100.0, 80.0, progress=lambda number, share: seen.append((number, share)))
    assert seen
    assert seen[-1] == (1, 1.0)


@pytest.mark.parametrize(
    ("arguments", "options", "words"),
    [
        (("sped", 1.0, 2.0), {}, "speed, viscosity"),
        (("rotor.mas", 1.0, 2.0), {"speed": 80.0}, "mass, stiffness"),
        (("drive.profile", 1.0, 2.0), {"speed": 80.0}, "write 'speed'"),
        ((f"{RACE}.balls[1].count", 1, 3), {"speed": 80.0}, "smoothly"),
        (("unbalance", 1e-4, 2e-4), {}, "no constant prescribed speed"),
        (("unbalance", 1e-4, 2e-4), {"speed": -3.0}, "greater than zero"),
        (("speed", 80.0, "80 rad/s"), {}, "two different values"),
        (("speed", -5.0, 80.0), {}, "greater than zero"),
        (("unbalance", "2000 g*mm", "1500 g*mm"), {"speed": 80.0}, "there is coincident, in line"),
        (("speed", 80.0, 90.0), {"from_state": "balance"}, "must be 'balanced'"),
        (("speed", 200.0, 300.0), {"from_state": "stalled"}, "stall at no resonance"),
        (("speed", 80.0, 90.0), {"largest_step": 0.0}, "largest_step"),
        (("speed", 80.0, 90.0), {"intervals": 2}, "intervals"),
    ],
)
def test_a_question_that_cannot_be_answered_says_what_is_possible(
    arguments: tuple[Any, ...], options: dict[str, Any], words: str
) -> None:
    with pytest.raises(QuestionError, match=words):
        branches(DISCOIDAL, *arguments, **options)


def test_machines_without_a_state_of_rest_in_the_rotor_are_refused() -> None:
    with pytest.raises(QuestionError, match="gravity"):
        branches(with_value_at(DISCOIDAL, "axis", "horizontal"), "speed", 80.0, 90.0)
    with pytest.raises(QuestionError, match="no Hopf point"):
        bifurcation_curves(DISCOIDAL, "Hopf", "speed", 100.0, 120.0, "drag", 1e-5, 1e-3)


def test_every_smooth_quantity_is_a_parameter() -> None:
    assert {"speed", "unbalance", "drag", "viscosity", "ball_mass", "ball_diameter", "damping", "stiffness"} <= set(
        SMOOTH
    )
    for name in SMOOTH:
        family = Family(DISCOIDAL, [name], 80.0)
        assert family(1.1 * (80.0 if name == "speed" else family.now(0))).balls == 2


def test_symmetric_start_states_are_followed_once() -> None:
    span = Range(Family(DISCOIDAL, ["speed"]), 80.0, 90.0)
    kind = kinds([stations(DISCOIDAL)])
    explorer = Explorer(span, kind, Steps(), 10, 10, None)
    state = np.zeros(8)
    angle = math.acos(-abs(plane(DISCOIDAL).unbalance) / float(plane(DISCOIDAL).moment.sum()))
    for angles in ((angle, -angle), (-angle, angle)):
        state[4:6] = angles
        explorer.steady_from(((0,), (1,)), state)
    assert len(explorer.branches) == 1
    assert isinstance(explorer.branches[0].problem, Steady)
    assert isinstance(explorer.branches[0].points[0], Point)
