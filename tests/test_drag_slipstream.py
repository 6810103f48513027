"""Slipstream of balls in line: the published polynomial inside its range, tame outside."""

from __future__ import annotations

import numpy as np
import pytest

from autobalancer.errors import QuestionError
from autobalancer.laws.drag_coefficient import slipstream_factor, slipstream_factors


@pytest.mark.parametrize("re", [0.0, 40.0, 300.0])
def test_the_factor_at_contact_is_the_sum_of_the_published_coefficients(re: float) -> None:
    constant = 452100 + 164000 - 29690 + 2731 - 116.9 + 1.876
    first = -2937 + 321.9 - 55.15 + 4.918 - 0.1302
    second = 4.95 + 0.8646 - 0.1306 + 0.003754
    expected = (constant + re * first + re**2 * second) * 1e-6
    assert float(slipstream_factor(re, 1.0)) == pytest.approx(expected, rel=1e-12)


def test_the_factor_stays_between_its_extremes_and_one_everywhere() -> None:
    re, distance = np.meshgrid(np.linspace(0.0, 5000.0, 200), np.linspace(0.0, 60.0, 301))
    factor = slipstream_factor(re, distance)
    assert factor.min() == pytest.approx(0.277, abs=0.003)
    assert factor.max() == 1.0


def test_outside_of_its_range_the_fit_is_clamped_not_extrapolated() -> None:
    np.testing.assert_array_equal(slipstream_factor([1e3, 1e5], 5.0), slipstream_factor(300.0, [5.0, 5.0]))
    np.testing.assert_array_equal(slipstream_factor(100.0, [0.0, 0.5, 1.0]), [slipstream_factor(100.0, 1.0)] * 3)
    np.testing.assert_array_equal(slipstream_factor([0.0, 150.0, 300.0], [25.0, 30.0, 20.0]), 1.0)
    assert float(slipstream_factor(300.0, 20.0 - 1e-9)) == pytest.approx(1.0, abs=0.01)


def test_the_ball_behind_is_shielded_and_the_direction_of_motion_says_which_that_is() -> None:
    angles, orbit, d, nu = [0.0, 0.5], 0.077, 0.0123, 1e-4
    forward = slipstream_factors(angles, [1.0, 1.0], orbit, d, nu)
    back = slipstream_factors(angles, [-1.0, -1.0], orbit, d, nu)
    assert forward[0] == pytest.approx(float(slipstream_factor(d / nu, 0.5 * orbit / d)), rel=1e-12)
    assert back[1] == forward[0] < 0.9
    assert forward[1] == back[0] == 1.0  # for the leader it is farther ahead along the race than the wake reaches
    np.testing.assert_array_equal(slipstream_factors(angles, [0.0, 0.0], orbit, d, nu), 1.0)
    np.testing.assert_array_equal(slipstream_factors([0.3], [2.0], orbit, d, nu), 1.0)


def test_balls_that_pass_each_other_hand_over_the_shield_without_a_jump() -> None:
    orbit, d, nu = 0.077, 0.0123, 1e-4
    for steps, most in ((401, 2e-1), (4001, 2e-2)):
        path = [
            slipstream_factors([a, 0.0, 0.03], [1.0, 1.0, 2.0], orbit, d, nu) for a in np.linspace(-0.3, 0.3, steps)
        ]
        assert np.abs(np.diff(path, axis=0)).max() < most


def test_each_ball_needs_a_velocity() -> None:
    with pytest.raises(QuestionError, match="2 angles and 1"):
        slipstream_factors([0.0, 1.0], [1.0], 0.077, 0.0123, 1e-6)
