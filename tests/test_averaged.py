"""The averaged theory: against itself in several forms, against the print, and against the exact equations."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.references import averaged as references
from tests.references import averaged_two_balls
from tests.references.averaged import averaged_residuals, unbalance_whirl
from tests.references.planar_states import Equilibrium, backward_whirl, equilibria_of

from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import load_race_machine
from autobalancer.stability import averaged
from autobalancer.stability import averaged as averaged_formulas
from autobalancer.stability import averaged as speed_windows
from autobalancer.stability.host.stations import Plane, of_plane
from autobalancer.stability.maps.balanced import PlanarBalancer, worst_case_border
from autobalancer.stability.maps.exact import averaged_border_of
from autobalancer.stability.stall.borders import release_border
from autobalancer.stability.states.ball_positions import directions

MACHINES = Path(__file__).parents[1] / "examples" / "machines"
SPEEDS = (85.0, 112.0, 127.0, 150.0, 310.0)


def a_plane(
    count: int = 2,
    s: float = 0.2,
    stiffness: tuple[float, float] = (1e5, 1e5),
    damping: tuple[float, float] = (12.0, 12.0),
    unbalance: complex = 2.2e-3,
    offset: complex = 0j,
) -> Plane:
    """Equal balls of 20 g on 100 mm; S is that of the x direction."""
    moment = np.full(count, 2e-3)
    drag = moment**2 * stiffness[0] / 10.0 / (damping[0] * s)
    inertia = np.full(count, 2.8e-4)
    race, center = np.zeros(count, np.int64), np.full(count, offset)
    return Plane(10.0, stiffness, damping, unbalance, np.full(count, 0.02), moment, inertia, drag, race, center)


def lopsided() -> Plane:
    """Orthotropic, eccentric race, unbalance off the zero mark."""
    return a_plane(
        stiffness=(1e5, 1.7e5),
        damping=(60.0, 33.0),
        unbalance=2e-3 * np.exp(-1.1j),
        offset=1e-4 * np.exp(0.7j),
    )


def unequal(random: np.random.Generator, count: int) -> Plane:
    p = a_plane(count, s=0.5 / count)
    return replace(p, moment=p.moment * random.uniform(0.6, 1.4, count), drag=p.drag * random.uniform(0.7, 1.5, count))


def balanced(*angles: float) -> Equilibrium:
    return Equilibrium("balanced", np.array(angles), 0j, max(len(angles) - 2, 0), 0)


def as_printed(p: Plane, speed: float, state: Equilibrium) -> list[np.ndarray]:
    """The matrices of one station for A_x, B_x, A_y, B_y, phi_1 ..., rows of the rotor over -2iWM, of balls over m eps."""
    n = p.moment.size
    order = [0, 2, 1, 3, *range(4, 4 + n)]
    by = np.kron([[0.0, -1.0], [1.0, 0.0]], np.eye(2)) / (2.0 * p.mass * speed)  # -1/(2iWM) on real and imaginary parts
    rows = np.block([[by.T * -1.0, np.zeros((4, n))], [np.zeros((n, 4)), np.diag(1.0 / p.moment)]])
    st, there, speeds = of_plane(p), references.at_station(state), np.array([speed])
    center = (there.whirl[st.station] + st.offset)[None]
    found = averaged._matrices(st, speeds, there.angles[None], center, averaged.whirl_of(st, speeds))
    return [(rows @ matrix[0])[np.ix_(order, order)] for matrix in found]


@pytest.mark.parametrize("speed", SPEEDS)
def test_every_state_of_rest_in_the_rotor_is_a_steady_state_of_the_averaged_equations(speed: float) -> None:
    p = lopsided()
    for state in equilibria_of(p, speed):
        a_x, a_y = references.amplitudes(p, speed, state.angles)
        rate_x, rate_y, torque = averaged_residuals(p, speed, state.angles, a_x, a_y)
        assert abs(rate_x) + abs(rate_y) < 1e-12 * speed * abs(a_x)
        assert np.abs(torque).max() < 1e-10 * p.moment[0] * speed**2 * abs(a_x)
        assert 0.5 * (a_x + a_y) == pytest.approx(state.whirl, rel=1e-10)
        assert a_x - 0.5 * (a_x + a_y) == pytest.approx(np.conj(backward_whirl(p, speed, state.whirl)), rel=1e-9)


@pytest.mark.parametrize("speed", SPEEDS)
def test_closed_forms_of_two_balls_are_the_balanced_states(speed: float) -> None:
    p = lopsided()
    state = averaged_two_balls.two_ball_state(p, speed)
    both = [found for found in equilibria_of(p, speed) if found.name == "balanced"]
    assert state is not None
    assert len(both) == 2
    ours = np.sort_complex(np.round(np.exp(1j * state.angles), 12))
    for other in both:
        assert np.sort_complex(np.round(np.exp(1j * other.angles), 12)) == pytest.approx(ours, abs=1e-9)
    assert 0.5 * (state.a_x + state.a_y) == pytest.approx(-p.offset[0], rel=1e-9)
    assert (state.a_x, state.a_y) == pytest.approx(references.amplitudes(p, speed, state.angles), rel=1e-9)
    assert state.chi == pytest.approx(np.exp(1j * state.angles).sum(), abs=1e-9)


def test_two_balls_have_no_closed_form_exactly_where_they_cannot_balance() -> None:
    for factor in np.linspace(0.05, 3.0, 60):
        p = replace(lopsided(), unbalance=factor * 2e-3 * np.exp(-1.1j))
        there = any(state.name == "balanced" for state in equilibria_of(p, 150.0))
        assert (averaged_two_balls.two_ball_state(p, 150.0) is not None) == there
        assert (abs(averaged_two_balls.chi_of_two_balls(p, 150.0).chi) <= 2.0) == there


def test_without_eccentricity_two_balls_stand_at_the_angle_that_closes_the_triangle() -> None:
    state = averaged_two_balls.two_ball_state(a_plane(unbalance=2.2e-3), 150.0)
    assert state is not None
    assert abs(state.a_x) + abs(state.a_y) == 0.0
    assert np.cos(state.angles) == pytest.approx(-0.55, abs=1e-14)


def test_the_matrices_are_the_printed_ones_but_for_the_sine_in_row_four() -> None:
    p, w, phi = a_plane(stiffness=(1e5, 1.7e5), damping=(60.0, 33.0)), 150.0, (2.1, -1.4)
    (kx, ky), (bx, by), m, s = p.stiffness, p.damping, p.mass, p.moment[0]
    c, n = np.cos(phi), np.sin(phi)
    u, v = s / m, 0.5 * s * w / m
    a = np.array(
        [
            [-1, 0, 0, 0, u * n[0], u * n[1]],
            [0, -1, 0, 0, -u * c[0], -u * c[1]],
            [0, 0, -1, 0, u * n[0], u * n[1]],
            [0, 0, 0, -1, -u * c[0], -u * c[1]],
            [*(0.5 * w * np.array([c[0], n[0], c[0], n[0]])), p.drag[0] / s, 0],
            [*(0.5 * w * np.array([c[1], n[1], c[1], n[1]])), 0, p.drag[1] / s],
        ]
    )
    dx, dy, half = 0.5 * w - kx / (2 * m * w), 0.5 * w - ky / (2 * m * w), 0.5 * w * w
    b = np.array(
        [
            [-bx / (2 * m), dx, 0, 0, v * c[0], v * c[1]],
            [-dx, -bx / (2 * m), 0, 0, v * n[0], v * n[1]],
            [0, 0, -by / (2 * m), dy, v * c[0], v * c[1]],
            [0, 0, -dy, -by / (2 * m), v * n[0], v * n[1]],
            [half * n[0], -half * c[0], half * n[0], -half * c[0], 0, 0],
            [half * n[1], -half * c[1], half * n[1], -half * c[1], 0, 0],
        ]
    )
    ours = as_printed(p, w, balanced(*phi))
    assert ours[0] == pytest.approx(a, rel=1e-13)
    assert ours[1] == pytest.approx(b, rel=1e-13, abs=1e-12)


def test_matrix_b_is_the_slope_of_the_steady_residuals_also_off_the_balanced_state() -> None:
    p, w = lopsided(), 150.0
    for state in equilibria_of(p, w):
        a_x, a_y = references.amplitudes(p, w, state.angles)
        start = np.array([a_x.real, a_x.imag, a_y.real, a_y.imag, *state.angles])

        def residuals(q: np.ndarray) -> np.ndarray:
            x, y, torque = averaged_residuals(p, w, q[4:], complex(q[0], q[1]), complex(q[2], q[3]))
            return np.array([x.real, x.imag, y.real, y.imag, *(-torque / p.moment)])

        steps = np.array([1e-6] * 4 + [1e-5] * 2)
        columns = [(residuals(start + h) - residuals(start - h)) / (2.0 * h.sum()) for h in np.diag(steps)]
        assert as_printed(p, w, state)[1] == pytest.approx(np.array(columns).T, rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("phi", [1.7, 0.75 * math.pi, 2.9])
def test_eigenvalues_are_the_roots_of_the_factorized_polynomial_of_the_appendix(phi: float) -> None:
    p, w = a_plane(s=0.4), 130.0
    m, b, beta, square, c = p.mass, p.damping[0], p.drag[0], 1e4, p.moment[0] ** 2
    spin = (math.sin(phi) * math.cos(phi)) ** 2
    a4 = 4 * w**2 * (4 * c**2 * w**2 * spin + m**2 * beta**2)
    a3 = 4 * m * beta * w**2 * (2 * c * w**2 + c * square + beta * b)
    a2 = m**2 * beta**2 * (w**2 - square) ** 2
    a2 += w**2 * (20 * c**2 * w**4 * spin + 6 * c * beta * w**2 * b + beta**2 * b**2)
    a1 = 2 * c * m * beta * w**4 * (w**2 - square)
    a0 = 4 * c**2 * w**8 * spin
    pair = [-b / (2 * m) + sign * 1j * (square - w**2) / (2 * w) for sign in (1, -1)]  # A.1 with its sign corrected
    own = np.roots([a4, a3, a2, a1, a0])
    found = references.averaged_eigenvalues(p, w, balanced(phi, -phi))  # without the pair, which no ball feels
    assert np.sort_complex(found) == pytest.approx(np.sort_complex(own), rel=1e-9)
    hardly_uneven = replace(p, stiffness=(p.stiffness[0], p.stiffness[1] * (1.0 + 1e-8)))
    found = references.averaged_eigenvalues(hardly_uneven, w, balanced(phi, -phi))
    assert found.size == 6
    for value in (*own, *pair):
        assert np.abs(found - value).min() < 1e-6 * w


@pytest.mark.parametrize("s", [0.02, 0.2033, 0.9])
def test_the_eigenproblem_at_135_degrees_has_the_border_of_the_closed_form(s: float) -> None:
    p = a_plane(s=s)
    explicit = averaged_formulas.explicit_averaged_border(p)
    assert explicit.name == "averaged border, worst case"
    assert explicit.speed == pytest.approx(100.0 * math.sqrt((1.0 + s) / (1.0 - s)), rel=1e-14)
    at_135 = averaged_border_of(replace(p, unbalance=2.0 * p.moment[0] * math.cos(0.25 * math.pi)), False)
    assert at_135.name == "averaged border"
    assert at_135.speed == pytest.approx(explicit.speed, rel=1e-9)


@pytest.mark.parametrize("count", [2, 3, 4, 7])
def test_the_closed_form_for_equal_balls_holds_for_their_number(count: int) -> None:
    p = a_plane(count, s=0.2)
    share = 0.1 * count
    worst = averaged_border_of(p, True)
    assert worst.speed == pytest.approx(100.0 * math.sqrt((1.0 + share) / (1.0 - share)), rel=1e-9)
    assert averaged_formulas.explicit_averaged_border(p).speed == pytest.approx(worst.speed, rel=1e-9)


@pytest.mark.parametrize("seed", range(6))
def test_the_closed_form_for_unequal_balls_holds(seed: int) -> None:
    p = unequal(np.random.default_rng(seed), 2 + seed)
    weight = p.moment**2 / p.drag
    worst = averaged_border_of(p, True).speed
    explicit = averaged_formulas.explicit_averaged_border(p).speed
    if 2.0 * weight.max() <= weight.sum():
        assert worst == pytest.approx(explicit, rel=1e-9)
    else:
        assert worst < explicit


@pytest.mark.parametrize("seed", range(8))
def test_no_ball_positions_have_a_higher_averaged_border_than_the_worst_case(seed: int) -> None:
    random = np.random.default_rng(seed)
    p = unequal(random, 4)
    border = averaged_formulas.explicit_averaged_border(p).speed
    for _ in range(40):
        state = balanced(*random.uniform(-math.pi, math.pi, 4))
        assert references.averaged_growth_rate(p, 1.0001 * border, state) < 0.0
    weight = p.moment**2 / p.drag
    least = max(0.0, 2.0 * float(weight.max() / weight.sum()) - 1.0)  # |g2|/g that these balls can make
    assert references.growth_rates(p, np.array([0.9999 * border]), least)[0] > 0.0


def test_one_ball_meets_its_sufficient_criterion_as_the_rotor_damping_vanishes() -> None:
    for damping, tolerance in ((1.0, 3e-2), (1e-2, 3e-4), (1e-3, 3e-5)):
        p = a_plane(1, s=0.3, damping=(damping, damping), unbalance=2e-3)
        sufficient = averaged_formulas.explicit_averaged_border(p)
        assert sufficient.speed == pytest.approx(100.0 * math.sqrt(1.15 / 0.85), rel=1e-14)
        border = averaged_border_of(p, False).speed
        assert border <= sufficient.speed * (1.0 + 1e-6)  # a rate above -1e-12 of the critical speed counts as marginal
        assert border == pytest.approx(sufficient.speed, rel=tolerance)


def test_averaged_stability_is_lost_for_good_when_n_s_reaches_two() -> None:
    for count in (2, 3, 5):
        below, above = a_plane(count, s=1.999 / count), a_plane(count, s=2.001 / count)
        assert math.isfinite(averaged_formulas.explicit_averaged_border(below).speed)
        assert math.isinf(averaged_formulas.explicit_averaged_border(above).speed)
        assert math.isinf(averaged_border_of(above, True).speed)


def test_the_minimum_drag_puts_the_border_at_the_asked_speed() -> None:
    p = unequal(np.random.default_rng(3), 5)
    drag = averaged_formulas.minimum_drag(p, 140.0)
    there = replace(p, drag=np.full(5, drag))
    assert averaged_formulas.explicit_averaged_border(there).speed == pytest.approx(140.0, rel=1e-12)
    two = a_plane(2)
    assert averaged_formulas.minimum_drag(two) == pytest.approx(two.moment[0] ** 2 * 1e4 / 12.0, rel=1e-14)
    with pytest.raises(QuestionError, match="above the critical speed of 100 rad/s"):
        averaged_formulas.minimum_drag(two, 90.0)


def test_releases_come_at_one_plus_n_times_s_and_twice_as_far_up_as_the_borders_for_small_s() -> None:
    for count in (1, 2, 5):
        p = a_plane(count, s=1e-4)
        release = release_border(p)
        assert release.name == "release speed"
        assert release.speed == pytest.approx(100.0 * (1.0 + 1e-4 * count), rel=1e-14)
        averaged_share = averaged_formulas.explicit_averaged_border(p).speed - 100.0
        assert release.speed - 100.0 == pytest.approx(2.0 * averaged_share, rel=1e-3)


def exact_worst(p: Plane) -> float:
    n, i = p.moment.size, p.inertia[0]
    return worst_case_border(PlanarBalancer(p.mass, p.stiffness[0], p.damping[0], n, p.moment[0], i, p.drag[0]))


@pytest.mark.parametrize(("s", "tolerance"), [(0.02, 2e-3), (0.05, 3e-3), (0.1, 7e-3)])
def test_averaged_and_exact_border_agree_for_heavily_damped_balls_and_small_s(s: float, tolerance: float) -> None:
    for ratio in (1.0, 3.0, 30.0):  # beta / (I w_c)
        p = a_plane(s=s)
        p = replace(p, inertia=p.drag / (ratio * 100.0))
        assert averaged_formulas.explicit_averaged_border(p).speed == pytest.approx(exact_worst(p), rel=tolerance)


def test_balls_without_inertia_have_a_finite_exact_border_where_the_averaged_one_is_never() -> None:
    for count, s in ((2, 0.3), (2, 2.5), (5, 1.0)):
        p = a_plane(count, s=s)
        p = replace(p, inertia=p.drag / (1000.0 * 100.0))
        limit = references.heavily_damped_border(p)
        assert limit.name == "exact border, worst case"
        assert limit.speed == pytest.approx(exact_worst(p), rel=1e-4)
    assert math.isinf(averaged_formulas.explicit_averaged_border(p).speed)


def test_lightly_damped_balls_have_another_exact_border() -> None:
    p = a_plane(s=0.02, damping=(714.0, 714.0))  # beta = 0.1 I w_c, damping ratio 0.36
    assert exact_worst(p) == pytest.approx(111.6, abs=0.05)
    assert averaged_formulas.explicit_averaged_border(p).speed == pytest.approx(102.02, abs=0.01)


@pytest.mark.parametrize(("ratio", "s", "damping"), [(0.3, 0.05, 96.0), (10.0, 2.0, 1.0), (1.0, 0.3, 4.0)])
def test_the_exact_border_near_the_critical_speed_follows_from_three_decay_rates(
    ratio: float, s: float, damping: float
) -> None:
    p = a_plane(s=s, damping=(damping, damping))
    p = replace(p, inertia=p.drag / (ratio * 100.0))
    zeta = damping / (2.0 * p.mass * 100.0)
    x = float(np.roots([1.0, 0.0, 1.0, -s / ratio]).real.max())
    assert exact_worst(p) == pytest.approx(100.0 * (1.0 + (ratio + zeta) * x), rel=3e-3)


def test_undamped_windows_are_above_the_two_critical_speeds_with_a_gap_after_their_mean_square() -> None:
    assert speed_windows.speed_windows(a_plane()) == [(100.0, math.inf)]
    windows = speed_windows.speed_windows(a_plane(stiffness=(1.7e5, 1e5)))
    assert windows == [(100.0, pytest.approx(math.sqrt(1.35e4))), (pytest.approx(math.sqrt(1.7e4)), math.inf)]


def test_damped_windows_fall_onto_the_undamped_ones_and_the_lower_one_closes_with_damping() -> None:
    slight = a_plane(stiffness=(1e5, 1.7e5), damping=(1e-4, 2e-4))
    for damped, undamped in zip(
        speed_windows.speed_windows(slight, damped=True), speed_windows.speed_windows(slight), strict=True
    ):
        assert damped == pytest.approx(undamped, rel=1e-9)
    heavy = replace(slight, damping=(400.0, 400.0))
    assert len(speed_windows.speed_windows(heavy, damped=True)) == 1
    assert speed_windows.speed_windows(a_plane(), damped=True)[0][0] == pytest.approx(100.0, rel=1e-9)


@pytest.mark.parametrize("damping", [(12.0, 12.0), (60.0, 33.0), (5.0, 300.0)])
def test_the_forward_whirl_lags_exactly_inside_the_damped_windows(damping: tuple[float, float]) -> None:
    p = a_plane(stiffness=(1e5, 1.7e5), damping=damping)
    windows = speed_windows.speed_windows(p, damped=True)
    for speed in np.linspace(60.0, 260.0, 801):
        inside = any(low < speed < high for low, high in windows)
        assert ((1.0 / p.dynamic_stiffness(speed)).real < 0.0) == inside
        assert (unbalance_whirl(p, speed)[0].real < 0.0) == inside


def test_on_orthotropic_supports_the_balanced_state_is_stable_in_both_windows_only() -> None:
    p = a_plane(s=0.002, stiffness=(1e5, 1.7e5), damping=(20.0, 20.0))
    (low, high), (upper, _) = speed_windows.speed_windows(p, damped=True)
    verdicts = {
        speed: references.balanced_growth_rate(p, speed) < 0.0
        for speed in (0.97 * low, 0.5 * (low + high), 0.5 * (high + upper), 1.1 * upper)
    }
    assert list(verdicts.values()) == [False, True, False, True]
    border = averaged_border_of(p, False, (low, 0.5 * (low + high)))
    assert low < border.speed < 0.5 * (low + high)


@pytest.mark.parametrize("speed", [70.0, 110.0, 122.0, 200.0])
def test_the_undamped_response_is_that_of_two_oscillators_and_has_the_lost_factor(speed: float) -> None:
    p = replace(a_plane(stiffness=(1e5, 1.7e5)), damping=(0.0, 0.0))
    forward, backward = unbalance_whirl(p, speed)
    turn = np.exp(0.4j)
    x, y = (
        p.unbalance * speed**2 * part / (k - p.mass * speed**2)
        for k, part in zip(p.stiffness, (turn.real, turn.imag), strict=True)
    )
    assert forward * turn + backward / turn == pytest.approx(x + 1j * y, rel=1e-12)
    wx, wy, wr = 1e4, 1.7e4, 1.35e4  # (4.72), squares of the speeds
    product = (wx - speed**2) * (wy - speed**2)
    assert forward == pytest.approx(p.unbalance * speed**2 / p.mass * (wr - speed**2) / product, rel=1e-12)
    difference = (p.stiffness[0] - p.stiffness[1]) / (2.0 * p.mass)
    assert backward == pytest.approx(-p.unbalance * speed**2 / p.mass * difference / product, rel=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_vectors_close_a_polygon_whenever_no_side_is_too_long(seed: int) -> None:
    random = np.random.default_rng(seed)
    for _ in range(200):
        lengths = random.uniform(0.0, 1.0, random.integers(1, 8))
        target = random.uniform(0.0, 1.2) * lengths.sum() * np.exp(1j * random.uniform(-4.0, 4.0))
        angles = directions(lengths, complex(target))
        assert (angles is not None) == (2.0 * max(lengths.max(), abs(target)) <= lengths.sum() + abs(target))
        if angles is not None:
            assert (lengths * np.exp(1j * angles)).sum() == pytest.approx(target, abs=1e-7)


def test_three_equal_balls_can_balance_nothing_at_all() -> None:
    angles = directions(np.ones(3), 0j)
    assert angles is not None
    assert abs(np.exp(1j * angles).sum()) < 1e-14


def test_what_the_averaged_theory_cannot_answer_is_refused_in_words() -> None:
    p = a_plane()
    with pytest.raises(QuestionError, match="a ball without drag"):
        references.averaged_eigenvalues(replace(p, drag=np.zeros(2)), 150.0, balanced(2.0, -2.0))
    with pytest.raises(QuestionError, match="supports are not isotropic"):
        references.heavily_damped_border(a_plane(stiffness=(1e5, 1.7e5)))
    with pytest.raises(QuestionError, match="a race is off the axis"):
        averaged_formulas.explicit_averaged_border(MACHINES / "eccentric_race.toml")
    with pytest.raises(QuestionError, match="needs races on the axis"):
        averaged_border_of(lopsided(), True)
    with pytest.raises(QuestionError, match="two equal balls in one race"):
        averaged_two_balls.two_ball_state(a_plane(3), 150.0)
    nothing = averaged_border_of(replace(p, unbalance=1.0), False)
    assert math.isnan(nothing.speed)
    assert "no balanced state: the balls can balance" in nothing.note


def test_an_eccentric_race_has_an_averaged_border_too() -> None:
    machine = load_race_machine(MACHINES / "eccentric_race.toml")
    p = averaged.averaged_plane(machine)
    border = averaged_border_of(p, False).speed
    critical = math.sqrt(p.stiffness[0] / p.mass)
    assert critical < border < 40.0 * critical
    assert references.balanced_growth_rate(p, 1.001 * border) < 0.0 < references.balanced_growth_rate(p, 0.999 * border)
