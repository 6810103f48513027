"""What a fixed step does to the energy of a collision, against a closed form of the leading error."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import zeta as scipy_zeta

import autobalancer as ab
from autobalancer.errors import QuestionError
from autobalancer.laws.impacts import contact_time, edge_error, energy_error, zeta
from autobalancer.studies.chamber_study import _collide

K = 1e10
SPEED = 4.0


def test_the_zeta_function_agrees_with_others() -> None:
    start = np.array([0.05, 0.3, 1.0])
    np.testing.assert_allclose(zeta(2.5, start), scipy_zeta(2.5, start), rtol=1e-13)
    assert float(zeta(-1.5, np.array(1.0))) == pytest.approx(-0.025485201889833036, rel=1e-11)  # Riemann's
    np.testing.assert_allclose(zeta(-1.5, start) - zeta(-1.5, start + 1.0), start**1.5, atol=1e-13)


def test_the_error_at_an_edge_is_that_of_simpsons_rule() -> None:
    for phase in (0.1, 0.5, 0.77, 1.0):
        count = 400
        ends = phase - 1.0 + np.arange(count + 1)
        middles = ends[:-1] + 0.5
        force = lambda t: np.maximum(t, 0.0) ** 1.5 * (1.0 - t / ends[-1]) ** 6  # noqa: B023, E731
        rule = (force(ends[:-1]) + 4.0 * force(middles) + force(ends[1:])).sum() / 6.0
        exact = quad(lambda t: t**1.5 * (1.0 - t / ends[-1]) ** 6, 0.0, ends[-1], epsabs=1e-9, limit=200)[0]  # noqa: B023
        assert rule - exact == pytest.approx(float(edge_error(np.array(phase))), abs=2e-4)


def test_a_contact_lasts_as_long_as_hertz_says() -> None:
    depth = (1.25 * SPEED**2 / (2.0 * K)) ** 0.4
    half = quad(lambda s: 2.0 * s / np.sqrt(1.0 - (1.0 - s * s) ** 2.5), 0.0, 1.0)[0]
    assert contact_time(SPEED, K) == pytest.approx(2.0 * depth / SPEED * half, rel=1e-8)


@pytest.mark.parametrize("step", [1e-6, 2e-7])
def test_the_energy_error_of_each_phase_follows_the_closed_form(step: float) -> None:
    start = (np.arange(40) + 0.5) / 40.0
    after = _collide(SPEED, step, K, 1.0, start, "runge_kutta")
    entry = 1.0 - start  # the first step ends this part of a step after the contact began
    entry = np.where(start < 1.0, entry, 1.0)
    leave = start + contact_time(SPEED, K) / step
    found = energy_error(SPEED, step, K, entry, np.where(leave % 1.0 > 0.0, leave % 1.0, 1.0))
    error = (after / SPEED) ** 2 - 1.0
    scale = 4.0 * K * np.sqrt(SPEED) * step**2.5 * 0.03
    np.testing.assert_allclose(error, found, atol=0.05 * scale)


@pytest.mark.slow
def test_the_error_shrinks_with_the_power_two_and_a_half_of_the_step() -> None:
    found = ab.chamber.step_size(np.linspace(4.0, 10.0, 20), [1e-6, 2.5e-7], stiffness_over_mass=K, phases=30)
    size = np.sqrt((found["root_mean_square"].values ** 2).mean(axis=0))
    assert size[0] / size[1] == pytest.approx(4.0**2.5, rel=0.2)
    np.testing.assert_allclose(
        found["root_mean_square"], found["expected_root_mean_square"], rtol=0.1, atol=0.05 * size[0]
    )
    np.testing.assert_allclose(size, found["typical_root_mean_square"].mean("relative_speed"), rtol=0.2)


def test_a_collision_gains_energy_as_often_as_it_loses() -> None:
    found = ab.chamber.step_size([4.0, 10.0], [1e-6, 3e-7], stiffness_over_mass=K, phases=1000)
    np.testing.assert_allclose(found["share_of_gains"], 0.5, atol=0.08)
    assert np.all(np.abs(found["mean"]) < 0.15 * found["root_mean_square"])
    assert np.all(found["greatest"] > 0.0)
    assert np.all(found["least"] < 0.0)


def test_the_rebound_has_the_restitution_of_the_law() -> None:
    for scheme in ("runge_kutta", "velocity_verlet"):
        after = _collide(SPEED, 1e-7, K, 0.54, np.linspace(0.0, 1.0, 20), scheme)
        np.testing.assert_allclose(after, 0.54 * SPEED, rtol=5e-3)


@pytest.mark.slow
def test_verlet_has_an_error_of_the_same_order() -> None:
    speeds = np.linspace(4.0, 10.0, 20)
    found = ab.chamber.step_size(speeds, [1e-6, 2.5e-7], stiffness_over_mass=K, phases=30, scheme="velocity_verlet")
    size = np.sqrt((found["root_mean_square"].values ** 2).mean(axis=0))
    assert size[0] / size[1] == pytest.approx(4.0**2.5, rel=0.2)


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ({"steps": [0.0]}, "steps: given"),
        ({"speeds": []}, "speeds: given"),
        ({"restitution": 1.2}, "restitution: given 1.2"),
        ({"phases": 0}, "phases: given 0"),
        ({"scheme": "euler"}, "scheme: given 'euler'"),
    ],
)
def test_a_study_that_makes_no_sense_is_refused(wrong: dict[str, object], told: str) -> None:
    with pytest.raises(QuestionError, match=told):
        ab.chamber.step_size(**({"stiffness_over_mass": K} | wrong))  # type: ignore[arg-type]
