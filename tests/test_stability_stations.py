"""Steady states and exact stability of balls at any stations of rotors that tilt."""

from __future__ import annotations

import cmath
import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve
from tests.references.planar_linear import matrices
from tests.references.planar_states import equilibria_of
from tests.references.tilting import Tilting
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.assembly.quantities import with_value_at
from autobalancer.cli.main import app
from autobalancer.errors import QuestionError
from autobalancer.files.examples import rig
from autobalancer.machine import (
    Balancer,
    Balls,
    Constant,
    Machine,
    PlanarRotor,
    PrescribedSpeed,
    Race,
    RigidRotor,
    Support,
    Unbalance,
    ViscousDrag,
)
from autobalancer.stability.host.stations import Stations, plane, stations
from autobalancer.stability.maps.balanced import EqualAtOneStation, StationBalls, growth_of
from autobalancer.stability.states.linearized import eigensystem, exponents_of, swing_of
from autobalancer.stability.states.linearized import matrices as station_matrices
from autobalancer.stability.states.rest_states import StationState, balanced_of, states_of, without_exchanges

MACHINES = Path(__file__).parents[1] / "examples" / "machines"
ENDS = (-0.12, 0.16)
STATIC, COUPLE = 2e-4 * cmath.exp(0.3j), 1e-5 * cmath.exp(1.1j)
Group = tuple[float, tuple[float, ...]]  # position of a race and the masses of its balls


def machine(
    groups: tuple[Group, ...],
    *,
    polar: float = 0.02,
    transverse: float = 0.05,
    stiffness: float | tuple[float, float] = 2e4,
    ends: tuple[float, float] = ENDS,
    static: complex = STATIC,
    couple: complex = COUPLE,
    drag: float = 2e-4,
    offsets: tuple[complex, ...] = (),
) -> Machine:
    """A rigid rotor on two supports with races of point balls on 50 mm."""
    offsets = offsets or (0j,) * len(groups)
    balancers = tuple(
        Balancer(
            station=place,
            races=(
                Race(
                    orbit_radius=0.05,
                    drag=ViscousDrag(damping=drag * (1.0 + 0.3 * number)),
                    eccentricity=abs(offset),
                    eccentricity_angle=cmath.phase(offset),
                    balls=tuple(Balls(mass=mass, motion="point") for mass in masses),
                ),
            ),
        )
        for number, ((place, masses), offset) in enumerate(zip(groups, offsets, strict=True))
    )
    unbalances = [Unbalance(moment=abs(static), angle=cmath.phase(static), station=0.0)] if static else []
    if couple:
        unbalances.append(Unbalance(couple=abs(couple), angle=cmath.phase(couple)))
    return Machine(
        name="test",
        axis="vertical",
        rotor=RigidRotor(
            mass=5.0,
            transverse_inertia=transverse,
            polar_inertia=polar,
            supports=tuple(Support(position=z, stiffness=stiffness, damping=20.0) for z in ends),
        ),
        unbalances=tuple(unbalances),
        balancers=balancers,
        drive=PrescribedSpeed(profile=Constant(speed=300.0)),
    )


TWO = ((-0.1, (0.004, 0.003)), (0.15, (0.0035, 0.0035)))
ONE = ((0.05, (0.004, 0.004)),)


def reference(m: Machine, st: Stations, speed: float) -> Tilting:
    """The independent equations of a machine of :func:`machine`."""
    rotor = m.rotor
    assert isinstance(rotor, RigidRotor)
    places = [float(b.station or 0.0) for b in m.balancers for r in b.races for _ in r.balls]
    k = [s.stiffness if isinstance(s.stiffness, tuple) else (s.stiffness, s.stiffness) for s in rotor.supports]
    c = [s.damping if isinstance(s.damping, tuple) else (s.damping, s.damping) for s in rotor.supports]
    static = sum((u.size * cmath.exp(1j * u.angle) for u in m.unbalances), 0j)
    couple = sum((float(u.couple or 0.0) * cmath.exp(1j * u.angle) for u in m.unbalances), 0j)
    return Tilting(
        rotor.mass,
        rotor.transverse_inertia,
        rotor.polar_inertia,
        tuple((float(s.position), *ki, *ci) for s, ki, ci in zip(rotor.supports, k, c, strict=True)),
        static,
        couple,
        tuple(zip(places, st.ball_mass, st.moment / st.ball_mass, st.inertia, st.drag, strict=True)),
        speed,
    )


def same_spectrum(one: np.ndarray, other: np.ndarray) -> float:
    """Greatest distance from a value of one to the nearest of the other, both ways."""
    apart = np.abs(np.asarray(one)[:, None] - np.asarray(other)[None, :])
    return float(max(apart.min(0).max(), apart.min(1).max()))


# steady states --------------------------------------------------------------------------------------------------------


def test_two_planes_share_the_unbalance_like_a_statically_determinate_beam_at_any_speed() -> None:
    m = machine(TWO)
    wanted = -np.linalg.solve([[1.0, 1.0], [-0.1, 0.15]], [STATIC, COUPLE])
    for speed in (50.0, 110.0, 700.0):
        found = ab.stability.equilibria(m, speed)
        assert np.allclose(found["required_moment"], np.abs(wanted), rtol=1e-11)
        st = stations(m)
        for state in balanced_of(st, speed):
            sums = st.moments(state.angles)
            assert np.allclose(sums, wanted, rtol=1e-11)
            assert np.abs(st.coordinates(speed, state.angles)).max() < 1e-16  # no vibration anywhere
        assert len(balanced_of(st, speed)) == 4  # both mirror images at both planes


def test_one_plane_cannot_balance_a_couple_and_the_rotor_still_tilts_about_it() -> None:
    st, speed, z = stations(machine(ONE)), 300.0, 0.05
    (state, _) = balanced_of(st, speed)
    whirl = st.coordinates(speed, state.angles)
    x, slope = whirl
    assert abs(x + z * slope) < 1e-12 * abs(slope)
    assert state.whirl[0] == 0.0
    # pinned at the plane: the moment about it decides the slope
    r = [(p - z, 2e4, 20.0) for p in ENDS]
    about = 0.05 - 0.02 + 5.0 * z**2  # J_t - J_p + m z^2; the balls sit at the pin
    tilt = sum(p**2 * (k + 1j * speed * c) for p, k, c in r) - speed**2 * about
    assert slope == pytest.approx(speed**2 * (COUPLE - z * STATIC) / tilt, rel=1e-11)


def test_with_one_plane_what_balances_depends_on_the_speed() -> None:
    first, second = (
        float(ab.stability.equilibria(machine(ONE), speed)["required_moment"][0]) for speed in (200.0, 500.0)
    )
    assert abs(first / second - 1.0) > 0.02


def test_every_state_is_at_rest_in_the_full_nonlinear_equations() -> None:
    m, speed = machine(TWO), 230.0
    st = stations(m)
    rotor = reference(m, st, speed)
    states = states_of(st, speed)
    assert {state.name for state in states} == {"balanced", "mixed", "coincident", "in line"}
    for state in states:
        x, slope = st.coordinates(speed, state.angles)
        rates = rotor.rotating(rotor.resting(x, slope, state.angles))
        assert np.abs(rates[: 4 + 4]).max() < 1e-9  # m/s
        assert np.abs(rates[8:12]).max() < 1e-9  # m/s^2
        assert np.abs(rates[12:]).max() < 1e-8 * speed**2
        assert np.allclose(st.rows @ np.array([x, slope]), state.whirl, atol=1e-15)


@pytest.mark.parametrize(("speed", "count"), [(60.0, 4), (130.0, 2), (160.0, 0), (400.0, 4)])
def test_no_state_of_two_stations_is_missed_by_many_random_starts(speed: float, count: int) -> None:
    st = stations(machine(((-0.1, (0.003,)), (0.15, (0.0035,)))))
    known = [np.exp(1j * state.angles) for state in states_of(st, speed) if state.name in ("coincident", "in line")]
    assert len(known) == count

    def torque(angles: np.ndarray) -> np.ndarray:
        whirl = st.rows @ st.coordinates(speed, angles)
        return (np.exp(-1j * angles) * whirl).imag / 1e-5

    random, seen = np.random.default_rng(1), []
    for start in random.uniform(-math.pi, math.pi, (150, 2)):
        angles, _, ok, _ = fsolve(torque, start, xtol=1e-13, full_output=True)
        if ok == 1 and np.abs(torque(angles)).max() < 1e-10:
            place = np.exp(1j * angles)
            if not any(np.abs(place - other).max() < 1e-6 for other in seen):
                seen.append(place)
    assert len(seen) == len(known)
    for place in seen:
        assert min(np.abs(place - other).max() for other in known) < 1e-6


def test_races_with_several_centers_at_two_stations_have_states_at_rest() -> None:
    groups = ((-0.1, (0.004,)), (-0.1, (0.003,)), (0.15, (0.004,)))
    st, speed = stations(machine(groups, offsets=(1e-4 + 0j, 0j, 5e-5j))), 320.0
    assert len(st.names) == 2
    states = states_of(st, speed)
    assert states
    for state in states:
        center = (st.rows @ st.coordinates(speed, state.angles))[st.station] + st.offset
        assert np.abs((np.exp(-1j * state.angles) * center).imag).max() < 1e-9 * np.abs(center).max()


# exact stability ------------------------------------------------------------------------------------------------------


def test_eigenvalues_are_those_of_the_numerical_jacobian_of_the_full_equations() -> None:
    m, speed = machine(TWO), 230.0
    st = stations(m)
    rotor = reference(m, st, speed)
    for state in states_of(st, speed):
        x, slope = st.coordinates(speed, state.angles)
        numeric = np.linalg.eigvals(rotor.jacobian(rotor.resting(x, slope, state.angles)))
        exact, _ = eigensystem(*station_matrices(st, speed, state))
        assert exact.size == 16
        assert same_spectrum(exact, numeric) < 2e-6 * speed


def loop(st: Stations, state: StationState, speed: float, s: complex) -> complex:
    """det(1 - T(s)) of unequal balls at several stations, written from the receptance."""

    def fourth(sigma: complex) -> np.ndarray:
        mass, turning, stiffness = st.model.complex_matrices(speed)
        return sigma**4 * st.rows @ np.linalg.solve(sigma**2 * mass + sigma * turning + stiffness, st.rows.T)

    ahead, back = fourth(s + 1j * speed), np.conj(fourth(np.conj(s) + 1j * speed))
    ball = st.moment**2 / (st.inertia * s**2 + st.drag * s)
    places = len(st.names)
    direct, turned, other = np.zeros((3, places, places), complex)
    for p in range(places):
        own = st.station == p
        direct[p, p] = ball[own].sum()
        turned[p, p] = (ball * np.exp(2j * state.angles))[own].sum()
        other[p, p] = (ball * np.exp(-2j * state.angles))[own].sum()
    t = 0.5 * np.block([[direct @ ahead, turned @ back], [other @ ahead, direct @ back]])
    return complex(np.linalg.det(np.eye(2 * places) - t))


@pytest.mark.parametrize(
    "groups",
    [
        ((0.05, (0.004, 0.0025, 0.003)),),
        TWO,
        ((-0.1, (0.002, 0.002)), (-0.1, (0.001, 0.003)), (0.15, (0.004, 0.003, 0.002))),
    ],
    ids=["one station", "two stations", "two races and one"],
)
def test_eigenvalues_are_the_roots_of_the_closed_form_for_unequal_balls(groups: tuple[Group, ...]) -> None:
    st, speed = stations(machine(groups)), 260.0
    state = balanced_of(st, speed)[0]
    values, _ = eigensystem(*station_matrices(st, speed, state))
    bare = np.concatenate([np.zeros(1), -st.drag / st.inertia])  # poles of T
    checked = 0
    for value in values:
        if np.abs(value - bare).min() < 1e-3:
            continue
        step = 1e-4 * (1.0 + 1j)
        slope = (loop(st, state, speed, value + step) - loop(st, state, speed, value - step)) / (2.0 * step)
        assert abs(loop(st, state, speed, value) / slope) < 1e-6  # the root is that near
        checked += 1
    assert checked >= 8


def planar() -> Machine:
    return Machine(
        name="planar",
        axis="vertical",
        rotor=PlanarRotor(mass=10.0, stiffness=6e5, damping=100.0),
        unbalances=(Unbalance(moment=4.1e-4, angle=0.3),),
        balancers=(
            Balancer(
                races=(
                    Race(
                        orbit_radius=0.1,
                        drag=ViscousDrag(damping=2e-4),
                        balls=(Balls(count=2, mass=0.003, motion="point"), Balls(mass=0.002, motion="point")),
                    ),
                )
            ),
        ),
        drive=PrescribedSpeed(profile=Constant(speed=400.0)),
    )


def test_a_planar_rotor_as_one_station_has_the_states_and_eigenvalues_of_the_planar_theory() -> None:
    p, st = plane(planar()), stations(planar())
    for speed in (200.0, 400.0):
        flat, spatial = equilibria_of(p, speed), states_of(st, speed)
        assert [s.name for s in flat] == [s.name for s in spatial]
        for one, other in zip(flat, spatial, strict=True):
            assert np.abs(np.exp(1j * one.angles) - np.exp(1j * other.angles)).max() < 1e-7
            assert abs(one.whirl - other.whirl[0]) < 1e-15
            assert (one.freedom, one.outward) == (other.freedom, other.outward)
            a, _ = eigensystem(*matrices(p, speed, one))
            b, _ = eigensystem(*station_matrices(st, speed, other))
            assert same_spectrum(a, b) < 1e-10 * speed


def test_a_balancer_in_the_plane_of_the_mass_center_of_a_symmetric_rotor_has_the_planar_border() -> None:
    flat = with_value_at(planar(), "balancers[1].races[1].balls", (Balls(count=2, mass=0.003, motion="point"),))
    rotor = RigidRotor(
        mass=10.0,
        transverse_inertia=0.2,
        polar_inertia=0.1,
        supports=tuple(Support(position=z, stiffness=3e5, damping=50.0) for z in (-0.2, 0.2)),
    )
    deep = flat.model_copy(
        update={
            "rotor": rotor,
            "balancers": (flat.balancers[0].model_copy(update={"station": 0.0}),),
            "unbalances": (Unbalance(moment=4.1e-4, angle=0.3, station=0.0),),
        }
    )
    wanted = {border.name: border.speed for border in ab.stability.borders(flat)}
    for border in ab.stability.borders(deep):
        assert border.speed == pytest.approx(wanted[border.name], rel=1e-9)
    assert {"exact border", "exact border, worst case", "release speed", "capture speed"} <= {
        border.name for border in ab.stability.borders(deep)
    }


def test_equal_balls_at_one_station_count_by_their_second_harmonic_only() -> None:
    m = machine(((0.05, (0.003, 0.003, 0.003)),), couple=0j)
    st, speed = stations(m), 180.0
    for state in balanced_of(st, speed):
        spread = abs(np.exp(2j * state.angles).sum())
        direct = growth_of(st, speed, state)
        merged = EqualAtOneStation(st, spread=float(spread)).rates(np.array([speed]))[0]
        assert merged == pytest.approx(direct, abs=1e-8 * speed)


def test_exchanging_equal_balls_is_no_other_state() -> None:
    st = stations(machine(((-0.1, (0.004, 0.004)), (0.15, (0.0035, 0.0035)))))
    assert len(balanced_of(st, 300.0)) == 4
    assert len(without_exchanges(st, balanced_of(st, 300.0))) == 1


# what it comes to -----------------------------------------------------------------------------------------------------


def test_two_planes_balance_a_slender_rotor_above_its_second_critical_speed_and_not_below() -> None:
    m = machine(TWO)
    st = stations(m)
    low, high = st.critical_speeds
    assert (low, high) == pytest.approx((88.05, 163.36), abs=0.01)
    found = ab.stability.stable_windows(m, 2000.0)
    assert len(found.windows) == 1
    assert found.windows[0][1] == 2000.0
    assert found.windows[0][0] > high
    rates = StationBalls(st).rates(np.linspace(low * 1.01, high, 30))
    assert (rates > 0.0).all()
    border = {b.name: b.speed for b in ab.stability.borders(m)}["exact border"]
    assert border == pytest.approx(found.windows[0][0], rel=1e-9)
    assert StationBalls(st).rates(np.array([border * (1.0 - 1e-6)]))[0] > 0.0
    assert StationBalls(st).rates(np.array([border * (1.0 + 1e-6)]))[0] < 0.0


@pytest.mark.slow
def test_a_disk_like_rotor_has_no_conical_critical_speed_and_no_stable_balancing() -> None:
    slender, disk = (stations(machine(TWO, polar=polar)) for polar in (0.045, 0.055))
    assert len(slender.critical_speeds) == 2
    assert len(disk.critical_speeds) == 1
    speeds = np.geomspace(5.0, 20000.0, 120)
    assert (StationBalls(disk).rates(speeds) > 0.0).all()
    assert ab.stability.stable_windows(machine(TWO, polar=0.055), 5000.0).windows == ()
    border = {b.name: b for b in ab.stability.borders(machine(TWO, polar=0.055))}["exact border"]
    assert math.isinf(border.speed)
    assert "disk-like, J_p = 0.055 > J_t = 0.05" in border.note
    assert "disk-like" not in {b.name: b for b in ab.stability.borders(machine(TWO))}["exact border"].note


def test_one_plane_on_a_disk_like_rotor_is_stable_at_high_speed_only_near_the_mass_center() -> None:
    # W^2 H -> -1/m + z^2/(J_p - J_t): balls are drawn to the light side where z^2 < (J_p - J_t)/m
    limit = math.sqrt((0.08 - 0.05) / 5.0)
    for z, stable in ((0.8 * limit, True), (1.2 * limit, False)):
        st = stations(machine(((z, (0.0004, 0.0004)),), polar=0.08, static=1e-6, couple=0j, drag=1e-3))
        rates = EqualAtOneStation(st).rates(np.array([3000.0, 6000.0]))
        assert ((rates < 0.0) == stable).all()


# anisotropic supports -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("groups", [ONE, TWO], ids=["one plane", "two planes"])
def test_multipliers_of_an_isotropic_rotor_are_its_eigenvalues(groups: tuple[Group, ...]) -> None:
    st, speed = stations(machine(groups)), 230.0
    for state in states_of(st, speed)[:6]:
        values, _ = eigensystem(*station_matrices(st, speed, state))
        found = exponents_of(st, speed, state)
        turn = 2.0 * math.pi / speed
        assert same_spectrum(np.exp(found * turn), np.exp(values * turn)) < 1e-9
        slow = values.real > -0.5 * speed  # what dies out within a turn is rounding
        assert np.abs(np.sort(found.real)[::-1] - np.sort(values.real)[::-1])[: int(slow.sum())].max() < 1e-8 * speed


@pytest.mark.slow
def test_the_swinging_state_on_anisotropic_supports_returns_after_a_turn_and_its_multipliers_are_the_numerical_ones() -> (
    None
):
    m, speed = machine(ONE, stiffness=(2.2e4, 1.8e4)), 90.0
    st = stations(m)
    rotor = reference(m, st, speed)
    guess = next(state for state in states_of(st, speed) if state.name == "in line")
    swing = swing_of(st, speed, guess)
    phi, rate, _, _ = swing.at(np.zeros(1))
    assert np.ptp(swing.angles, axis=1).max() > 1e-3  # they do swing
    turn = 2.0 * math.pi / speed

    def after(y: np.ndarray) -> np.ndarray:
        return solve_ivp(rotor.rates, (0.0, turn), y, method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]

    start = rotor.resting(*st.coordinates(speed, guess.angles), guess.angles)
    start[4:6], start[10:12] = phi[:, 0], rate[:, 0]
    scale = np.array([1e-4] * 4 + [1.0] * 2 + [1e-2] * 4 + [10.0] * 2)
    slope = np.empty((12, 12))
    for _ in range(3):  # the rotor's part of the state by Newton's method on the independent equations
        back = after(start)
        for i in range(12):
            step = np.zeros(12)
            step[i] = 1e-4 * scale[i]
            slope[:, i] = (after(start + step) - after(start - step)) / (2.0 * step[i])
        start = start - np.linalg.solve((slope - np.eye(12)) * scale, back - start) * scale
    assert np.abs((after(start) - start) / scale).max() < 1e-9
    assert np.allclose(start[4:6], phi[:, 0], atol=1e-8)
    assert np.allclose(start[10:12], rate[:, 0], atol=1e-6)
    assert same_spectrum(np.exp(exponents_of(st, speed, guess) * turn), np.linalg.eigvals(slope)) < 1e-6


def test_rodrigues_rig_balances_as_soon_as_its_balls_are_strong_enough_above_the_conical_speeds() -> None:
    m = rig("rodrigues_rig")
    found = ab.stability.stable_windows(m, 4500.0 * math.pi / 30.0, lowest=1000.0 * math.pi / 30.0)
    ((low, high),) = found.windows
    assert low * 30.0 / math.pi == pytest.approx(2441.6, abs=0.5)
    assert high == pytest.approx(4500.0 * math.pi / 30.0)
    need = ab.stability.equilibria(m, low * (1.0 + 1e-9))["required_moment"]
    assert float(need[0]) == pytest.approx(2 * 0.44e-3 * 42.8e-3, rel=2e-4)  # both balls nearly in line


# questions that make no sense -----------------------------------------------------------------------------------------


def test_what_is_known_of_planar_rotors_only_says_what_to_ask_instead() -> None:
    m = machine(TWO)
    with pytest.raises(QuestionError, match=r"planar rotors only.*equilibria"):
        ab.stability.speed_windows(m)
    with pytest.raises(QuestionError, match=r"2 unbalances along its axis"):
        ab.stability.equilibria(m, 300.0, unbalance=1e-4)


def test_gravity_across_the_axis_is_refused() -> None:
    m = machine(TWO)
    with pytest.raises(QuestionError, match="gravity acts across the axis"):
        ab.stability.eigenvalues(m.model_copy(update={"axis": "horizontal"}), [300.0])


def test_a_plane_whose_balls_are_too_weak_is_named() -> None:
    m = machine(((-0.1, (0.0001, 0.0001)), (0.15, (0.0035, 0.0035))))
    with pytest.raises(QuestionError, match="'plane 1'"):
        ab.stability.eigenvalues(m, [300.0])
    assert any("'plane 1'" in warning for warning in ab.check(m).warnings)


def test_what_a_plane_needs_is_its_greatest_over_time_though_the_planes_need_it_at_different_times() -> None:
    """A blade loss moves the unbalance along the axis; before and after, planes share it like the supports of a beam."""
    two = ab.load_machine("docs/machines/two_planes.toml")

    def part(moment: str, station: str, factor: list[float]) -> Unbalance:
        schedule = {"time": ["0 s", "8 s", "8.01 s"], "factor": factor}
        return Unbalance.model_validate({"moment": moment, "station": station, "schedule": schedule})

    before, after = part("50 g*mm", "-100 mm", [1.0, 1.0, 0.0]), part("60 g*mm", "100 mm", [0.0, 0.0, 1.0])
    found = ab.check(two.model_copy(update={"unbalances": (before, after)})).stations
    assert [plane.required * 1e6 for plane in found] == pytest.approx([50.0, 60.0 * 200.0 / 250.0])
    last = ab.check(two.model_copy(update={"unbalances": (after,)})).stations
    assert [plane.required * 1e6 for plane in last] == pytest.approx([60.0 * 50.0 / 250.0, 60.0 * 200.0 / 250.0])


def test_a_border_that_is_not_computed_is_called_not_known() -> None:
    answer = CliRunner().invoke(app, ["check", "docs/machines/two_planes.toml"], env={"COLUMNS": "300"})
    row = next(line for line in answer.output.splitlines() if "worst case" in line)
    assert "not known: computed for equal balls at one station only" in row
    assert "none" not in row


def test_another_size_of_the_only_unbalance_keeps_its_direction_and_place() -> None:
    m = machine(TWO, couple=0j)
    twice = ab.stability.equilibria(m, 300.0, unbalance=2.0 * abs(STATIC))
    once = ab.stability.equilibria(m, 300.0)
    assert np.allclose(twice["required_moment"], 2.0 * once["required_moment"], rtol=1e-12)
    assert np.allclose(twice["required_moment_angle"], once["required_moment_angle"], atol=1e-12)


@pytest.mark.parametrize("name", ["two_plane_rotor", "disk_like_rotor"])
def test_the_command_line_checks_machines_that_tilt(name: str) -> None:
    file = str(MACHINES / f"{name}.toml")
    runner = CliRunner()
    checked = runner.invoke(app, ["check", file])
    assert checked.exit_code == 0
    assert "plane upper" in checked.output
    borders = json.loads(runner.invoke(app, ["borders", file, "--json"]).output)["borders"]
    exact = next(border["speed"] for border in borders if border["name"] == "exact border")
    assert exact == "Infinity" if name == "disk_like_rotor" else exact > 100.0
    spoken = runner.invoke(app, ["eigenvalues", file, "--speeds", "6000 rpm:9000 rpm:3"])
    assert spoken.exit_code == 0
    assert ("unstable" in spoken.output) == (name == "disk_like_rotor")
