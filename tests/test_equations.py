"""The compiled equations of motion against an independent Lagrangian derivation."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import sympy as sp
from tests.references import lagrange
from tests.references.machines import random_machine, random_state
from tests.references.rates import rates_at

from autobalancer.assembly.system import assemble
from autobalancer.kernels.balls.planar import planar
from autobalancer.kernels.host.shaft_train import enter_segment
from autobalancer.kernels.system import SPEED, THETA, System, own
from autobalancer.kernels.trigonometry import sine_cosine
from autobalancer.machine import Machine

SEEDS = range(60)


def rates(system: System, time: float, state: np.ndarray) -> np.ndarray:
    """Derivative of the state by the compiled kernel, in the axes of the system."""
    system.drive.now[0] = 0
    enter_segment(time, system.drive)
    return rates_at(planar, time, state, system)


def assert_same_rates(obtained: np.ndarray, expected: np.ndarray, tolerance: float = 3e-12) -> None:
    """Every group of rates (velocities, accelerations, of host, rotor and balls) agrees.

    The reference solves its whole matrix; its rounding differs between linear algebra libraries, by up to 1.1e-12 here.
    """
    n = (expected.size - 6) // 2
    for group in (slice(0, 2), slice(2, 4), slice(4, 5), slice(5, 6), slice(6, 6 + n), slice(6 + n, None)):
        scale = np.abs(expected[group]).max(initial=0.0)
        np.testing.assert_allclose(obtained[group], expected[group], rtol=0.0, atol=tolerance * scale)


def seen_from_rotor(expected: np.ndarray, state: np.ndarray) -> np.ndarray:
    """Rates in axes at rest -> rates of the components along the axes of the rotor."""
    turn = np.exp(-1j * state[THETA])
    out = expected.copy()
    for a, b in ((0, 1), (2, 3)):
        rate = (expected[a] + 1j * expected[b]) * turn - 1j * expected[THETA] * turn * (state[a] + 1j * state[b])
        out[a], out[b] = rate.real, rate.imag
    return out


@pytest.mark.parametrize("seed", SEEDS)
def test_the_kernel_equals_the_full_lagrangian_equations_in_axes_at_rest(seed: int) -> None:
    random = np.random.default_rng(seed)
    machine = random_machine(random)
    reference, system = lagrange.planar(machine), assemble(machine, rotating=False).system
    for _ in range(5):
        time, state = random_state(random, reference)
        assert_same_rates(rates(system, time, state), reference.rates(time, state))


@pytest.mark.parametrize("seed", SEEDS)
def test_the_kernel_equals_the_full_lagrangian_equations_in_axes_of_the_rotor(seed: int) -> None:
    random = np.random.default_rng(1000 + seed)
    machine = random_machine(random, isotropic=True)
    reference, system = lagrange.planar(machine), assemble(machine, rotating=True).system
    assert system.rotating == 1.0
    for _ in range(5):
        time, state = random_state(random, reference)
        expected = seen_from_rotor(reference.rates(time, state), state)
        assert_same_rates(rates(system, time, lagrange.to_rotor(state)), expected)


def response(system: System, time: float, state: np.ndarray) -> np.ndarray:
    """Inverse mass matrix of the kernel, column by column, by pulling at one coordinate after the other.

    A spring pulls along x or y, the external damping brakes the rotor, the drag of one ball brakes this ball.
    """
    n = system.ball_count
    rows = [2, 3, 5, *range(6 + n, 6 + 2 * n)]
    base = rates(system, time, state)[rows]
    columns = []
    for number in range(n + 3):
        changed = own(system)
        if number == 0:
            force = 1e3
            rotor = changed.planar._replace(stiffness_x=changed.planar.stiffness_x - force / state[0])
            changed = changed._replace(planar=rotor)
        elif number == 1:
            force = 1e3
            rotor = changed.planar._replace(stiffness_y=changed.planar.stiffness_y - force / state[1])
            changed = changed._replace(planar=rotor)
        elif number == 2:
            force = 10.0
            drive = changed.drive._replace(damping=changed.drive.damping - force / state[SPEED])
            changed = changed._replace(drive=drive)
        else:
            force = 1.0
            changed.balls[number - 3].drag -= force / state[3 + n + number]
        columns.append((rates(changed, time, state)[rows] - base) / force)
    return np.array(columns).T


@pytest.mark.parametrize("seed", range(20))
def test_the_mass_matrix_behind_the_kernel_is_symmetric_and_positive(seed: int) -> None:
    random = np.random.default_rng(2000 + seed)
    machine = random_machine(random, drive="torque")
    reference, system = lagrange.planar(machine), assemble(machine, rotating=False).system
    time, state = random_state(random, reference)
    inverse = response(system, time, state)
    size = np.sqrt(np.diag(inverse))
    scaled = inverse / np.outer(size, size)  # without units, ones on the diagonal
    np.testing.assert_allclose(scaled, scaled.T, rtol=0.0, atol=1e-9)
    assert np.linalg.eigvalsh(0.5 * (scaled + scaled.T)).min() > 0.0
    matrix = reference.mass_matrix(time, reference.split(state)[0])
    np.testing.assert_allclose(inverse @ matrix, np.eye(len(matrix)) * 1.0, rtol=0.0, atol=1e-8 * _spread(matrix))


def _spread(matrix: np.ndarray) -> float:
    """How far apart the units of the coordinates are."""
    size = np.sqrt(np.diag(matrix))
    return float(size.max() / size.min())


# the reference itself: Euler-Lagrange equations of the printed Lagrangian ------------------------------------------------


def _printed_lagrangian(n: int) -> tuple[sp.Expr, list[sp.Symbol], list[sp.Symbol], dict[str, Any]]:
    """(4.10) of Spannan 2021, letter by letter."""
    names = "m m0 J eps0 kx ky E gamma"
    m, m0, inertia, eps0, kx, ky, shift, gamma = sp.symbols(names)
    mi, eps, ji, ri = (sp.symbols(f"{s}1:{n + 1}") for s in ("m_", "eps_", "J_", "r_"))
    q, v = list(sp.symbols(f"x y theta phi1:{n + 1}")), list(sp.symbols(f"xd yd w u1:{n + 1}"))
    (x, y, th, *phi), (xd, yd, w, *u) = q, v
    sin, cos = sp.sin, sp.cos
    balls = range(n)
    lagrangian = (
        (m + m0 + sum(mi)) / 2 * (xd**2 + yd**2)
        - (kx * x**2 + ky * y**2) / 2
        + sum(mi[i] * eps[i] * (cos(th + phi[i]) * yd - sin(th + phi[i]) * xd) * u[i] for i in balls)
        + sum((ji[i] * eps[i] ** 2 / (2 * ri[i] ** 2) + mi[i] * eps[i] ** 2 / 2) * u[i] ** 2 for i in balls)
        + sum(
            (shift * mi[i] * eps[i] * cos(gamma - phi[i]) - ji[i] * eps[i] / ri[i] + mi[i] * eps[i] ** 2) * u[i] * w
            for i in balls
        )
        + (
            (cos(th) * yd - sin(th) * xd) * eps0 * m0
            + (cos(th + gamma) * yd - sin(th + gamma) * xd) * shift * sum(mi)
            + sum((cos(th + phi[i]) * yd - sin(th + phi[i]) * xd) * eps[i] * mi[i] for i in balls)
        )
        * w
        + (
            inertia
            + m0 * eps0**2
            + sum(
                shift**2 * mi[i] + 2 * shift * mi[i] * eps[i] * cos(gamma - phi[i]) + ji[i] + mi[i] * eps[i] ** 2
                for i in balls
            )
        )
        * w**2
        / 2
    )
    symbols = {"m": m, "m0": m0, "J": inertia, "eps0": eps0, "kx": kx, "ky": ky, "E": shift, "gamma": gamma}
    return lagrangian, q, v, symbols | {"mi": mi, "eps": eps, "ji": ji, "ri": ri}


def test_the_reference_equals_the_euler_lagrange_equations_of_the_printed_lagrangian() -> None:
    lagrangian, q, v, s = _printed_lagrangian(2)
    matrix = sp.hessian(lagrangian, v)
    rest = [
        sp.diff(lagrangian, a) - sum(sp.diff(lagrangian, b, c) * d for c, d in zip(q, v, strict=True))
        for a, b in zip(q, v, strict=True)
    ]
    random = np.random.default_rng(7)
    values = random.uniform(0.5, 2.0, 8)
    m0, eps0 = values[1], values[3]
    mass, orbit, radius, spin = (random.uniform(0.5, 2.0, 2) for _ in range(4))
    numbers = dict(zip([s[k] for k in ("m", "m0", "J", "eps0", "kx", "ky", "E", "gamma")], values, strict=True))
    for i in range(2):
        numbers |= {s["mi"][i]: mass[i], s["eps"][i]: orbit[i], s["ri"][i]: radius[i]}
        numbers |= {s["ji"][i]: spin[i] * mass[i] * radius[i] ** 2}
    reference = lagrange.Planar(
        mass=values[0] + m0,
        stiffness=(values[4], values[5]),
        damping=(0.0, 0.0),
        inertia=values[2] + m0 * eps0**2,
        gravity=(0.0, 0.0),
        ball_mass=mass,
        effective_mass=mass,
        fluid_mass=np.zeros(2),
        own=spin * mass * radius**2,
        turn=-orbit / radius,
        orbit=orbit,
        center=np.full(2, values[6] * np.exp(1j * values[7])),
        drag=np.zeros(2),
        unbalance=lambda time: complex(m0 * eps0),
        speed=None,
        torque=lambda time, w: 0.0,
    )
    place, velocity = random.uniform(-2.0, 2.0, 5), random.uniform(-2.0, 2.0, 5)
    at = numbers | dict(zip(q + v, [*place, *velocity], strict=True))
    printed_matrix = np.array(matrix.subs(at).evalf(17), float)
    printed_rest = np.array([float(row.subs(at).evalf(17)) for row in rest])
    np.testing.assert_allclose(reference.mass_matrix(0.0, place), printed_matrix, rtol=1e-13, atol=1e-13)
    np.testing.assert_allclose(reference.forces(0.0, place, velocity), printed_rest, rtol=1e-13, atol=1e-13)
    energy = sum(a * sp.diff(lagrangian, a) for a in v) - lagrangian
    assert reference.energy(0.0, place, velocity) == pytest.approx(float(energy.subs(at).evalf(17)), rel=1e-13)


@pytest.mark.parametrize("seed", range(10))
def test_the_kinetic_energy_is_half_the_velocity_times_mass_matrix_times_velocity(seed: int) -> None:
    random = np.random.default_rng(seed)
    reference = lagrange.planar(random_machine(random))
    time, state = random_state(random, reference)
    q, v = reference.split(state)
    assert 0.5 * v @ reference.mass_matrix(time, q) @ v == pytest.approx(reference.kinetic(time, q, v), rel=1e-12)


def test_sine_and_cosine_are_those_of_the_library_to_an_ulp_of_one() -> None:
    random = np.random.default_rng(0)
    quarters = np.arange(-40, 41) * math.pi / 4
    angles = [*random.uniform(-7.0, 7.0, 5000), *random.uniform(-1e6, 1e6, 5000), *quarters, 0.0, 1e-300, 3e7, -1e15]
    for angle in angles:
        s, c = sine_cosine(angle)
        assert abs(s - math.sin(angle)) <= 2.3e-16
        assert abs(c - math.cos(angle)) <= 2.3e-16
    assert all(math.isnan(value) for value in sine_cosine(math.nan))


# limits -----------------------------------------------------------------------------------------------------------------

SIMPLE: dict[str, Any] = {
    "name": "simple",
    "axis": "vertical",
    "rotor": {"mass": 10.0, "stiffness": 6.0e5, "damping": 80.0, "inertia": 0.05},
    "unbalances": [{"moment": 4e-4, "angle": 0.3}],
    "balancers": [
        {
            "races": [
                {
                    "orbit_radius": 0.1,
                    "drag": {"law": "viscous", "damping": 2e-4},
                    "balls": [{"count": 2, "diameter": 0.01, "mass": 4e-3, "start_angles": [0.5, 2.5]}],
                }
            ]
        }
    ],
    "drive": {"kind": "torque", "torque": 3.0, "damping": 0.01},
    "start": {"speed": 100.0},
}


def simple(race: dict[str, Any] | None = None, balls: dict[str, Any] | None = None, **top: Any) -> Machine:
    """SIMPLE with changes in the race, in its balls, or on top."""
    races = SIMPLE["balancers"][0]["races"][0]
    data = SIMPLE | {"balancers": [{"races": [races | {"balls": [races["balls"][0] | (balls or {})]} | (race or {})]}]}
    return Machine(**(data | top))


STATE = np.array([2e-4, -3e-4, 0.05, 0.02, 0.7, 220.0, 0.5, 2.5, -3.0, 4.0])


def test_spannans_ball_row_holds_for_the_accelerations_found() -> None:
    machine = simple({"eccentricity": 2e-3, "eccentricity_angle": 0.9})
    system = assemble(machine, rotating=False).system
    rate = rates(system, 0.0, STATE)
    ax, ay, turning, rolling = rate[2], rate[3], rate[5], rate[8:]
    theta, w, phi, phi_rate = STATE[4], STATE[5], STATE[6:8], STATE[8:]
    m, eps, beta, j, r, shift, gamma = 4e-3, 0.1, 2e-4, 0.4, 0.005, 2e-3, 0.9
    left = (1 + j) * m * eps**2 * rolling + beta * phi_rate
    right = m * eps * (shift * np.sin(gamma - phi) * w**2 + np.sin(theta + phi) * ax - np.cos(theta + phi) * ay)
    right += (j * m * r * eps - shift * m * eps * np.cos(gamma - phi) - m * eps**2) * turning
    np.testing.assert_allclose(left, right, rtol=1e-12)


def test_spannans_host_rows_hold_for_the_accelerations_found() -> None:
    machine = simple({"eccentricity": 2e-3, "eccentricity_angle": 0.9})
    rate = rates(assemble(machine, rotating=False).system, 0.0, STATE)
    acceleration, turning, rolling = rate[2] + 1j * rate[3], rate[5], rate[8:]
    theta, w, phi, phi_rate = STATE[4], STATE[5], STATE[6:8], STATE[8:]
    ball = 2e-3 * np.exp(1j * (theta + 0.9)), 0.1 * np.exp(1j * (theta + phi))
    u = 4e-4 * np.exp(1j * (theta + 0.3))
    inertial = (10.0 + 2 * 4e-3) * acceleration + u * (1j * turning - w**2)
    inertial += 4e-3 * np.sum(
        ball[0] * (1j * turning - w**2) + ball[1] * (1j * (turning + rolling) - (w + phi_rate) ** 2)
    )
    supports = 80.0 * (STATE[2] + 1j * STATE[3]) + 6.0e5 * (STATE[0] + 1j * STATE[1])
    assert abs(inertial + supports) < 1e-11 * abs(supports)


def test_without_balls_only_a_linear_oscillator_with_unbalance_is_left() -> None:
    machine = Machine(**(SIMPLE | {"balancers": []}))
    rate = rates(assemble(machine, rotating=False).system, 0.0, STATE[:6])
    u = 4e-4 * np.exp(1j * (0.7 + 0.3))
    acceleration = rate[2] + 1j * rate[3]
    force = -6.0e5 * (STATE[0] + 1j * STATE[1]) - 80.0 * (STATE[2] + 1j * STATE[3])
    assert acceleration == pytest.approx((force + u * (220.0**2 - 1j * rate[5])) / 10.0, rel=1e-12)
    torque = 3.0 - 0.01 * 220.0 - (u.conjugate() * acceleration).imag
    assert rate[5] == pytest.approx(torque / 0.05, rel=1e-12)


@pytest.mark.parametrize(
    ("poorer", "richer"),
    [
        (simple(), simple({"eccentricity": 0.0, "eccentricity_angle": 1.0})),
        (simple(), simple({"height": 0.02, "width": 0.02})),
        (simple(), simple({"fluid": {"density": 1e-12, "viscosity": 1e-6}})),
        (simple(), simple(axis="horizontal", gravity=0.0)),
        (simple(), simple(rotor=SIMPLE["rotor"] | {"stiffness": (6e5, 6e5), "damping": [80.0, 80.0]})),
        (
            simple(),
            simple(drive={"kind": "torque_table", "speed": [0.0, 1e3], "torque": [3.0, 3.0], "damping": 0.01}),
        ),
    ],
    ids=[
        "centered race",
        "room around the balls",
        "fluid of no density",
        "no gravity",
        "a pair of equal supports",
        "flat table",
    ],
)
def test_the_richer_machine_falls_onto_the_poorer_one_at_its_limit(poorer: Machine, richer: Machine) -> None:
    one, other = (rates(assemble(m, rotating=False).system, 0.0, STATE) for m in (poorer, richer))
    assert_same_rates(one, other, 1e-10)


def test_a_small_offset_of_the_race_has_a_small_effect_proportional_to_it() -> None:
    base = rates(assemble(simple(), rotating=False).system, 0.0, STATE)
    effects = []
    for offset in (1e-6, 2e-6):
        system = assemble(simple({"eccentricity": offset, "eccentricity_angle": 0.4}), rotating=False).system
        effects.append(rates(system, 0.0, STATE) - base)
    moving = slice(8, 10)
    np.testing.assert_allclose(effects[1][moving], 2.0 * effects[0][moving], rtol=1e-4)
    assert np.abs(effects[0][moving]).max() > 1e-3


def test_a_rolling_ball_of_no_size_still_has_seven_fifths_of_the_inertia_of_a_point_ball() -> None:
    """A small ball spins fast: rolling inertia does not vanish with the size, only its coupling to the rotor does."""
    rolling = assemble(simple(balls={"diameter": 1e-9}), rotating=False).system
    point = assemble(simple(balls={"diameter": 1e-9, "motion": "point"}), rotating=False).system
    assert rolling.balls.inertia[0] == pytest.approx(1.4 * point.balls.inertia[0], rel=1e-14)
    assert rolling.balls.spin[0] == pytest.approx(point.balls.spin[0], rel=1e-7)
    assert rolling.polar_inertia == pytest.approx(point.polar_inertia, rel=1e-14)


def test_a_ball_as_heavy_as_the_fluid_around_it_neither_pulls_nor_falls() -> None:
    machine = simple({"fluid": {"density": 4e-3 / (math.pi / 6 * 1e-6) * (1 - 1e-12), "viscosity": 1e-6}})
    system = assemble(machine, rotating=False).system
    assert np.all(np.abs(system.balls.mass) < 1e-14)
    without = rates(assemble(Machine(**(SIMPLE | {"balancers": []})), rotating=False).system, 0.0, STATE[:6])
    with_balls = rates(system, 0.0, STATE)
    np.testing.assert_allclose(with_balls[2:4], without[2:4], rtol=1e-3)  # only rolling couples, through the speed


def test_a_prescribed_speed_is_a_rotor_of_endless_inertia() -> None:
    heavy = simple(rotor=SIMPLE["rotor"] | {"inertia": 1e12}, drive={"kind": "torque", "torque": 7e12})
    table = {"kind": "table", "time": [0.0, 100.0], "speed": [220.0, 920.0]}
    prescribed = simple(drive={"kind": "speed", "profile": table}, start={})
    one, other = (rates(assemble(m, rotating=False).system, 0.0, STATE) for m in (heavy, prescribed))
    assert other[5] == 7.0
    assert_same_rates(one, other, 1e-9)


def test_gravity_along_a_horizontal_axis_pulls_balls_but_not_the_weight_of_the_rotor_alone() -> None:
    state = STATE.copy()
    state[[0, 1, 2, 3, 5, 8, 9]] = 0.0
    machine = simple(
        axis="horizontal",
        gravity=9.81,
        unbalances=[],
        drive={"kind": "speed", "profile": {"kind": "constant", "speed": 0.0}},
        start={},
    )
    rate = rates(assemble(machine, rotating=False).system, 0.0, state)
    reference = lagrange.planar(machine)
    assert_same_rates(rate, reference.rates(0.0, state))
    # a ball on a race at rest falls like a rolling ball on a slope: -g cos(angle) / (1.4 eps), but for the light host
    angles = state[4] + state[6:8]
    np.testing.assert_allclose(rate[8:], -9.81 * np.cos(angles) / (1.4 * 0.1), rtol=2e-3)
    assert -4.0 * 2 * 4e-3 < rate[3] < 0.0


@pytest.mark.parametrize("seed", range(10))
def test_turning_the_whole_machine_turns_the_rates_with_it(seed: int) -> None:
    random = np.random.default_rng(3000 + seed)
    machine = random_machine(random, isotropic=True, axis="vertical")
    reference, system = lagrange.planar(machine), assemble(machine, rotating=False).system
    time, state = random_state(random, reference)
    angle = 1.234
    turned = state.copy()
    turned[THETA] += angle
    for a, b in ((0, 1), (2, 3)):
        z = (state[a] + 1j * state[b]) * np.exp(1j * angle)
        turned[a], turned[b] = z.real, z.imag
    one, other = rates(system, time, state), rates(system, time, turned)
    for a, b in ((0, 1), (2, 3)):
        z = (one[a] + 1j * one[b]) * np.exp(1j * angle)
        one[a], one[b] = z.real, z.imag
    assert_same_rates(other, one, 1e-11)
