"""Stalled balls on any rotor: limits, symmetry, energy, and runs of the equations of motion."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
import pytest
import xarray as xr

import autobalancer as ab
from autobalancer.assembly.quantities import value_of, with_quantity, with_value_at
from autobalancer.assembly.reduced_rotor import coordinate_places
from autobalancer.errors import QuestionError
from autobalancer.kernels.system import BALLS, SPEED
from autobalancer.machine import (
    Balancer,
    Constant,
    Disk,
    Machine,
    PlanarRotor,
    PrescribedSpeed,
    Race,
    RigidRotor,
    ShaftMaterial,
    ShaftRotor,
    ShaftSegment,
    Support,
)
from autobalancer.simulation.record import Samples
from autobalancer.stability.border import Border
from autobalancer.stability.host.stations import stations
from autobalancer.stability.stall.borders import release_of
from autobalancer.stability.stall.branch import hanging_ranges
from autobalancer.stability.stall.capture import Motion, SlowRuns
from autobalancer.stability.stall.states import Balance, Loads, Whirling, stalled_groups

BOTH = ("release speed", "capture speed")
BEGUN = 200  # samples, 10 s, until balls have settled at a resonance
OIL = {"density": 760.0, "viscosity": 0.65e-6}


def rotor(polar: float = 0.08, stiffness: Any = 2e4, shift: float = 0.0) -> RigidRotor:
    places = (-0.12 + shift, 0.12 + shift)
    supports = tuple(Support(position=z, stiffness=stiffness, damping=20.0) for z in places)
    return RigidRotor(mass=5.0, transverse_inertia=0.05, polar_inertia=polar, supports=supports)


def shaft() -> ShaftRotor:
    return ShaftRotor(
        material=ShaftMaterial(density=7800.0, youngs_modulus=2.1e11, poisson_ratio=0.3),
        segments=tuple(ShaftSegment(length=0.15, diameter=0.03) for _ in range(4)),
        disks=tuple(
            Disk(name=f"disk {i}", position=z, mass=2.0, transverse_inertia=2e-3, polar_inertia=3e-3)
            for i, z in enumerate((0.15, 0.45))
        ),
        supports=tuple(Support(position=z, stiffness=2e4, damping=20.0) for z in (0.05, 0.55)),
    )


def machine(
    carrier: Any, places: tuple[float | None, ...], count: int = 2, rolling: float = 0.0, beta: float | None = None
) -> Machine:
    """Balls of 4 g in every plane, in thin oil with drag that grows faster than linearly, or with ``beta``."""
    race: dict[str, Any] = {
        "orbit_radius": 0.05,
        "collisions": False,
        "balls": [{"count": count, "mass": 0.004, "diameter": 0.01, "motion": "point"}],
    }
    if beta is None:
        race |= {"fluid": OIL, "drag": {"law": "discoidal"}, "friction": {"rolling_resistance": rolling}}
    else:
        race |= {"drag": {"law": "viscous", "damping": beta}}
    return Machine(
        name="rotor",
        axis="vertical",
        rotor=carrier,
        balancers=tuple(Balancer(station=z, races=(Race(**race),)) for z in places),
        drive=PrescribedSpeed(profile=Constant(speed=300.0)),
    )


def balance(m: Machine) -> Balance:
    """Of all balls of a machine."""
    st = stations(m)
    return Balance(Whirling(st), Loads(stalled_groups(m, st.station.tolist())))


def found(m: Machine, **options: Any) -> dict[str, Border]:
    return {border.name: border for border in ab.stability.borders(m, only=BOTH, **options)}


def test_a_slow_run_goes_on_where_the_rotor_keeps_more_modes_of_a_shaft_from_the_same_motion() -> None:
    runs = SlowRuns(machine(shaft(), (0.15, 0.45)), Loads([]))
    low, high = (runs._assembled((0.0, 1.0), (10.0, speed), 0.0) for speed in (100.0, 3000.0))
    state = np.random.default_rng(1).normal(size=low.state.size)
    on = Motion(np.zeros(1), np.zeros((1, 4)), state, low).onto(high)
    assert on.size == high.state.size > state.size
    for kind in (0, 1):  # deflections, and their rates
        before, after = (
            one.places @ given[coordinate_places(one.places.shape[-1], 4)[kind]]
            for one, given in ((low, state), (high, on))
        )
        assert after == pytest.approx(before, rel=1e-9)
    others = slice(SPEED, BALLS + 8)
    assert (on[others] == state[others]).all()


# limits and symmetry ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("beta", "rolling"), [(None, 0.0), (None, 0.006), (1e-4, 0.0)])
def test_a_plane_through_the_center_of_a_symmetric_rotor_has_release_and_capture_of_the_planar_one(
    beta: float | None, rolling: float
) -> None:
    flat = machine(PlanarRotor(mass=5.0, stiffness=4e4, damping=40.0), (None,), 2, rolling, beta)
    deep = machine(rotor(), (0.0,), 2, rolling, beta)
    wanted, one = found(flat), found(deep)
    assert one["release speed"].speed == pytest.approx(wanted["release speed"].speed, rel=1e-9)
    assert one["capture speed"].speed == pytest.approx(wanted["capture speed"].speed, rel=1e-7)


# springs along x and y, damping, drag, capture speed, and the whirl speed to which a ball falls there
UNEVEN = [
    ((14e3, 2e4), 20.0, 5e-5, 104.6, 49.3),  # the fold between both resonances is at 158 rad/s
    (
        (5e3, 2e4),
        20.0,
        2.5e-5,
        118.2,
        56.5,
    ),  # at 31 rad/s a ball could stall, too, but it meets the upper resonance first
]


def on_uneven_springs(
    stiffness: tuple[float, float], damping: float, beta: float, flat: bool, count: int = 1, mass: float = 0.04
) -> Machine:
    halves = tuple(0.5 * k for k in stiffness)
    supports = tuple(Support(position=z, stiffness=halves, damping=0.5 * damping) for z in (-0.12, 0.12))
    deep = RigidRotor(mass=5.0, transverse_inertia=0.05, polar_inertia=0.08, supports=supports)
    planar = PlanarRotor(mass=5.0, stiffness=stiffness, damping=damping)
    m = machine(planar if flat else deep, (None if flat else 0.0,), count, beta=beta)
    return with_value_at(m, "balancers[1].races[1].balls[1].mass", mass)


@pytest.mark.parametrize(("stiffness", "damping", "beta", "wanted", "to"), UNEVEN)
def test_on_uneven_springs_balls_are_captured_at_the_fold_beyond_both_resonances_whatever_the_rotor(
    stiffness: tuple[float, float], damping: float, beta: float, wanted: float, to: float
) -> None:
    given = (stiffness, damping, beta)
    planar, deep = (found(on_uneven_springs(*given, flat))["capture speed"] for flat in (True, False))
    assert planar.speed == pytest.approx(wanted, abs=0.1)
    assert deep.speed == pytest.approx(planar.speed, rel=1e-6)
    whirl = re.search(r"resonance of ([\d.]+) rad/s", deep.note)
    assert whirl is not None
    assert float(whirl[1]) == pytest.approx(to, rel=0.03)


def test_balls_that_weak_drag_lets_lag_by_more_than_a_quarter_are_captured_at_the_fold_on_any_rotor() -> None:
    machines = [on_uneven_springs((5e3, 2e4), 60.0, 3e-7, flat, 2, 0.004) for flat in (True, False)]
    planar, deep = (found(m)["capture speed"].speed for m in machines)
    assert planar == pytest.approx(223.7, abs=0.1)
    assert deep == pytest.approx(planar, rel=1e-6)


@pytest.mark.parametrize("beta", [2.5e-6, 1.5e-5, 1e-4])
def test_with_strong_damping_and_weak_drag_a_ball_lags_far_and_is_released_alike_on_any_rotor(beta: float) -> None:
    """At 1.5e-5 N m s the balance says 780 rad/s; below, the ball hangs at 48 rad/s while the rotor turns at 230."""
    planar, deep = (found(on_uneven_springs((14e3, 2e4), 60.0, beta, flat)) for flat in (True, False))
    for name in BOTH:
        assert deep[name].speed == pytest.approx(planar[name].speed, rel=1e-6)


def test_a_ball_with_weak_drag_hangs_up_to_a_release_speed_far_above_both_resonances() -> None:
    m = on_uneven_springs((14e3, 2e4), 60.0, 5e-5, False)
    wanted = found(m)["release speed"].speed
    assert wanted == pytest.approx(278.5, abs=0.1)
    held, freed = (run(m, low, high, 1.0, 50.0) for low, high in ((160.0, 0.99 * wanted), (270.0, 1.03 * wanted)))
    assert (held["ball_speed_in_space"] < 65.0).all()
    assert float(freed["ball_speed_in_space"][-1, 0]) > 150.0


@pytest.mark.parametrize(("stiffness", "damping", "beta", "wanted", "to"), UNEVEN)
def test_a_ball_on_uneven_springs_turns_with_the_rotor_down_to_the_capture_speed_and_falls_to_the_next_resonance(
    stiffness: tuple[float, float], damping: float, beta: float, wanted: float, to: float
) -> None:
    high, low = (165.0 if wanted < 110.0 else 1.06 * wanted), 0.955 * wanted
    made = run(on_uneven_springs(stiffness, damping, beta, True), high, low, 0.1, high)
    speed, ball = made["speed"].values, made["ball_speed_in_space"].values[:, 0]
    assert (ball[speed > wanted] > 70.0).all()
    assert speed[ball < 63.0].max() == pytest.approx(wanted, rel=0.03)  # the speed falls on while the ball slows down
    assert ball[-1] == pytest.approx(to, rel=0.03)


def test_two_planes_on_both_sides_hang_at_the_cylindrical_mode_like_one_in_the_middle() -> None:
    one, two = (balance(machine(rotor(), *rest)) for rest in (((0.0,), 4), ((-0.1, 0.1), 2)))
    (single,), (double,) = (stall.found(np.array([115.0])) for stall in (one, two))
    same = [k for k in range(double.speed.size) if abs(np.exp(1j * double.phases[k, 1]) - 1.0) < 1e-6]
    assert double.whirl[same] == pytest.approx(single.whirl, rel=1e-9)
    assert same


def test_two_planes_can_also_leave_each_other_so_they_hang_a_little_less_long_than_one_in_the_middle() -> None:
    one, two = (found(machine(rotor(), *rest))["release speed"].speed for rest in (((0.0,), 4), ((-0.1, 0.1), 2)))
    assert 0.995 * one < two < one


def test_the_order_of_planes_and_the_origin_of_the_axis_do_not_matter() -> None:
    reference = found(machine(rotor(0.03), (-0.1, 0.15)))
    turned = found(machine(rotor(0.03), (0.15, -0.1)))
    mirrored = found(machine(rotor(0.03), (0.1, -0.15)))
    # Planes that may leave each other are caught in a slow run. Both swing there, so that rounding, which differs between
    # processors and mirrored machines, decides in which turn a ball falls: 5e-5 of the speed was seen.
    for name, tolerance in zip(BOTH, (1e-8, 5e-4), strict=True):
        assert turned[name].speed == pytest.approx(reference[name].speed, rel=tolerance)
        assert mirrored[name].speed == pytest.approx(reference[name].speed, rel=tolerance)


def test_supports_that_are_hardly_anisotropic_release_like_isotropic_ones() -> None:
    alike, not_quite = (found(machine(rotor(0.08, k), (0.03,))) for k in (2e4, (2e4, 2e4 * (1.0 + 1e-7))))
    for name in BOTH:
        assert not_quite[name].speed == pytest.approx(alike[name].speed, rel=1e-5)


def test_the_power_of_the_drag_is_what_the_supports_take() -> None:
    m = machine(rotor(0.03), (0.07,))
    st = stations(m)
    loads = Loads(stalled_groups(m, st.station.tolist()))
    for one in hanging_ranges(Whirling(st), loads, 300.0):
        if math.isinf(one.end):
            continue
        v, model = one.whirl, st.model
        both = model.both(st.rows)[:, :]
        force = v**2 * st.moment.sum() * (both[0] - 1j * both[1])
        turning = model.damping_at(one.end) + one.end * model.gyroscopic
        q = np.linalg.solve(model.stiffness_at(one.end) + 1j * v * turning - v**2 * model.mass, force)
        taken = 0.5 * v**2 * float(np.real(q.conj() @ model.damping_at(one.end) @ q))
        given = v * float(loads.groups[0].drag(np.array([one.end - v]))[0]) * 2
        assert given == pytest.approx(taken, rel=1e-6)


def test_the_power_of_the_drag_on_two_planes_with_a_free_phase_is_what_the_supports_take() -> None:
    m = machine(rotor(0.02), (-0.1, 0.15), beta=2e-4)
    st, stall = stations(m), balance(m)
    (found_,) = stall.found(np.array([190.0]))
    assert found_.speed.size > 2
    model, loads = st.model, stall.loads
    for i, v in enumerate(found_.whirl.tolist()):
        load = v**2 * st.rows.T @ (loads.count * loads.moment * np.exp(1j * found_.phases[i]))
        mass, _, stiffness = model.complex_matrices(190.0)
        q = np.linalg.solve(stiffness + 1j * v * _whirling(model, 190.0) - v**2 * mass, load)
        damping = model.damping_at(190.0)[: model.pairs, : model.pairs]
        taken = v**2 * float(np.real(q.conj() @ damping @ q))
        given = v * float(2.0 * 2e-4 * (190.0 - v) * 2)
        assert given == pytest.approx(taken, rel=1e-8)


def _whirling(model: Any, speed: float) -> np.ndarray:
    """Damping and gyroscopic terms over z = q_x + i q_y."""
    n, whole = model.pairs, model.damping_at(speed) + speed * model.gyroscopic
    return np.asarray(whole[:n, :n] + 1j * whole[n : 2 * n, :n])


def test_a_slender_rotor_has_a_resonance_that_rises_with_the_speed_and_a_disk_like_one_has_not() -> None:
    slender, disk = (found(machine(rotor(polar), (-0.1, 0.15), beta=2e-4)) for polar in (0.02, 0.08))
    assert "balls can stall again" in slender["release speed"].note
    assert "again" not in disk["release speed"].note
    assert slender["release speed"].speed > 138.0 > disk["release speed"].speed


@pytest.mark.slow
def test_only_resonances_that_the_run_up_meets_count() -> None:
    m = machine(shaft(), (0.2,))
    low, first = found(m)["release speed"], stations(m).critical_speeds[0]
    assert first < low.speed < 2.0 * first
    assert low.speed == pytest.approx(found(m, up_to="1500 rpm")["release speed"].speed, rel=1e-9)
    assert "resonances above 300 rad/s left out" in low.note
    far = found(m, up_to="40000 rpm")[
        "release speed"
    ]  # at a bending mode, above the speeds that are searched for states
    assert stations(m).critical_speeds[2] < 2600.0 < far.speed < math.inf
    assert "90.94 rad/s at that of 73.86 rad/s" in far.note


def test_release_falls_steadily_with_rolling_resistance_until_balls_are_carried_through() -> None:
    m = machine(rotor(0.08, (2e4, 3e4)), (-0.1, 0.15), beta=2e-4)
    shares = np.linspace(0.0025, 0.03, 11)  # without it slow runs of planes that stall at different speeds count, too
    curve = ab.stability.border_curve(m, "rolling_resistance", shares, only=("release speed",))
    release = curve["release_speed"].values
    known = np.isfinite(release)
    assert 4 <= known.sum() < 11
    assert not known[known.sum() :].any()
    assert (np.diff(release[known]) < 0.0).all()
    assert (np.abs(np.diff(release[known], 2)) < 0.1).all()


def test_balls_between_partitions_do_not_stall() -> None:
    m = machine(rotor(), (0.03,))
    walls = with_value_at(m, "balancers[1].races[1].partitions", {"count": 2})
    (border,) = ab.stability.borders(walls, only=BOTH)
    assert math.isnan(border.speed)
    assert "between partitions are carried along" in border.note


# unequal balls ---------------------------------------------------------------------------------------------------------


def unequal(share: float, beta: float = 1e-4) -> Machine:
    race = {
        "orbit_radius": 0.05,
        "drag": {"law": "viscous", "damping": beta},
        "collisions": False,
        "balls": [{"count": 1, "mass": 0.01 * part, "motion": "point"} for part in (share, 1.0)],
    }
    return Machine(
        name="unequal",
        axis="vertical",
        rotor=PlanarRotor(mass=10.0 - 0.01 * (1.0 + share), stiffness=1e5, damping=40.0),
        balancers=({"races": [race]},),
        drive=PrescribedSpeed(profile=Constant(speed=200.0)),
    )


def test_a_weaker_ball_settles_before_the_stronger_one_and_lets_it_go_earlier() -> None:
    beta = 2.0 * (0.01 * 0.05 * 100.0) ** 2 / 40.0  # one ball of 10 g alone is let go at 150 rad/s
    for share, wanted in ((1.0, 200.0), (0.9, 181.0), (0.8, 164.0), (0.6, 150.0)):
        assert found(unequal(share, beta))["release speed"].speed == pytest.approx(wanted, rel=1e-12)


# against the equations of motion ----------------------------------------------------------------------------------------


def run(m: Machine, low: float, high: float, rate: float, start: float) -> xr.Dataset:
    """A slow change of the speed; all balls start in line at the speed ``start`` in space."""
    time = abs(high - low) / rate
    m = with_value_at(m, "drive.profile", {"kind": "table", "time": [0.0, time], "speed": [low, high]})
    for b, balancer in enumerate(m.balancers, 1):
        for g, group in enumerate(balancer.races[0].balls, 1):
            place = f"balancers[{b}].races[1].balls[{g}]"
            m = with_value_at(m, f"{place}.start_speeds", [start - low] * group.count)
            m = with_value_at(m, f"{place}.start_angles", [0.25 * (i + g) for i in range(group.count)])
    return ab.simulate(m, duration=time, save=Samples(int(20 * time) + 1), tolerance=1e-7, max_steps=10**6)


def uneven(m: Machine) -> Machine:
    """One of two equal balls of each race a ten-thousandth heavier, so that they can part."""
    for b, balancer in enumerate(m.balancers, 1):
        (group,) = balancer.races[0].balls
        one = group.model_dump(exclude_unset=True) | {"count": 1}
        pair = [one, one | {"mass": float(one["mass"]) * (1.0 + 1e-4)}]
        m = with_value_at(m, f"balancers[{b}].races[1].balls", pair)
    return m


def passes(run: xr.Dataset) -> float:
    """Rotor speed at which the last ball leaves a resonance or falls back to it: where its speed changes most."""
    speed = run["ball_speed_in_space"].values
    mean = np.apply_along_axis(lambda v: np.convolve(v, np.full(21, 1.0 / 21.0), mode="valid"), 0, speed)
    change = np.abs(mean[20:] - mean[:-20])[BEGUN:]
    return float(run["speed"].values[10:-10][10:][BEGUN:][: change.shape[0]][change.argmax(axis=0)].max())


@pytest.mark.parametrize(
    ("carrier", "places", "rolling", "low", "high", "start"),
    [
        (rotor(), (-0.1, 0.15), 0.01, 89.5, 120.0, 85.0),
        (rotor(0.03, (2e4, 2.5e4)), (0.03,), 0.0, 92.0, 125.0, 87.0),
        (shaft(), (0.2,), 0.01, 73.5, 86.0, 70.0),
        (shaft(), (0.15, 0.4), 0.01, 74.0, 97.0, 70.0),
    ],
    ids=["disk-like, two planes", "anisotropic", "shaft", "shaft, two planes"],
)
@pytest.mark.slow
def test_balls_leave_a_resonance_at_the_release_speed(
    carrier: Any, places: tuple[float, ...], rolling: float, low: float, high: float, start: float
) -> None:
    m = machine(carrier, places, 2, rolling)
    wanted = found(m, up_to=high)["release speed"].speed
    assert passes(run(uneven(m), low, high, 0.06, start)) == pytest.approx(wanted, rel=0.015)


@pytest.mark.parametrize(("carrier", "place"), [(rotor(), 0.05), (shaft(), 0.2)], ids=["disk-like", "shaft"])
def test_one_ball_falls_back_to_a_resonance_at_the_capture_speed(carrier: Any, place: float) -> None:
    m = machine(carrier, (place,), 1)
    wanted = found(m)["capture speed"].speed
    assert passes(run(m, wanted + 8.0, wanted - 5.0, 0.1, wanted + 7.0)) == pytest.approx(wanted, rel=0.01)


def test_unequal_balls_are_released_where_their_joint_balance_says() -> None:
    m = unequal(0.8, 2.0 * (0.01 * 0.05 * 100.0) ** 2 / 40.0)
    assert passes(run(m, 115.0, 175.0, 0.4, 99.0)) == pytest.approx(164.0, rel=0.015)  # s_min sum s would be at 172


@pytest.mark.slow
def test_balls_in_one_plane_leave_the_nutation_where_it_has_risen_to() -> None:
    m = with_value_at(machine(rotor(0.02), (0.15,), beta=2e-4), "drive.profile.speed", 420.0)
    wanted = found(m)["release speed"].speed
    assert passes(run(uneven(m), 138.5, 260.0, 0.2, 136.5)) == pytest.approx(wanted, rel=0.015)


@pytest.mark.slow
def test_of_two_planes_that_hang_at_the_nutation_one_is_released_first_and_the_other_later() -> None:
    m = with_value_at(machine(rotor(0.02), (-0.1, 0.15), beta=2e-4), "drive.profile.speed", 420.0)
    wanted = found(m)["release speed"].speed
    made = run(uneven(m), 138.5, 260.0, 0.4, 136.5)
    hangs = (made["ball_speed_in_space"] < 0.85 * made["speed"]).values
    first, last = (float(made["speed"][np.flatnonzero(hangs[:, i])[-1]]) for i in (0, 2))
    assert last == pytest.approx(wanted, rel=0.03)  # the others, in line, disturb those that stay
    assert first < 0.9 * last


# where they are shown -------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_curves_have_release_and_capture_over_what_only_real_races_have() -> None:
    m = machine(rotor(), (0.15,))
    curve = ab.stability.border_curve(m, "rolling_resistance", [0.0, 0.008], only=BOTH)
    assert "exact_border" not in curve
    for name in ("release_speed", "capture_speed"):
        assert (np.diff(curve[name].values) < 0.0).all()
    thick = ab.stability.border_curve(m, "plateau", [0.4, 0.8], only=BOTH)["release_speed"].values
    assert thick[0] > thick[1]
    figure = ab.plot.answer(curve)
    assert {"release speed", "capture speed"} <= {text.get_text() for text in figure.legends[0].get_texts()}


def test_warm_oil_lets_go_later() -> None:
    m = with_value_at(machine(rotor(), (0.03,)), "balancers[1].races[1].fluid", {"name": "silicone oil 1"})
    release = ab.stability.border_curve(m, "temperature", ["10 degC", "50 degC"], only=["release speed"])[
        "release_speed"
    ].values
    assert release[0] < release[1]
    assert value_of(with_quantity(m, "temperature", "30 degC"), "temperature") == pytest.approx(303.15)


def test_a_map_without_the_speed_has_the_release_speed_over_both_axes() -> None:
    flat = machine(PlanarRotor(mass=5.0, stiffness=4e4, damping=40.0), (None,))
    axes = {"rolling_resistance": [0.0, 0.004, 0.008], "count": [2, 3]}
    drawn = ab.stability.map(flat, axes, speed=115.0)
    assert drawn["release_speed"].shape == (3, 2)
    changed = with_quantity(with_quantity(flat, "rolling_resistance", 0.004), "count", 3)
    assert float(drawn["release_speed"][1, 1]) == found(changed)["release speed"].speed
    assert any("release speed" in text.get_text() for text in ab.plot.map(drawn).legends[0].get_texts())


@pytest.mark.slow
def test_the_least_drag_for_a_speed_has_its_release_speed_there_on_any_rotor() -> None:
    m = machine(rotor(), (0.15,), beta=2e-4)
    drag = ab.stability.minimum_drag(m, 110.0, "release speed")
    assert found(with_quantity(m, "drag", drag))["release speed"].speed == pytest.approx(110.0, rel=1e-6)


def test_the_least_drag_for_a_release_counts_rolling_resistance() -> None:
    flat = machine(PlanarRotor(mass=5.0, stiffness=4e4, damping=40.0), (None,), beta=2e-4)
    rubbed = with_quantity(flat, "rolling_resistance", 0.004)
    drag, less = (ab.stability.minimum_drag(m, 110.0, "release speed") for m in (flat, rubbed))
    assert less < 0.9 * drag
    assert found(with_quantity(rubbed, "drag", less))["release speed"].speed == pytest.approx(110.0, rel=1e-6)


def test_check_lists_release_and_capture_of_any_rotor() -> None:
    assert set(BOTH) <= {border.name for border in ab.check(machine(rotor(), (0.03,))).borders}


def test_release_without_capture_is_the_same() -> None:
    m = machine(rotor(), (-0.1, 0.15))
    st = stations(m)
    assert release_of(m, st, capture=False) == release_of(m, st)[:1]


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda m: ab.stability.borders(m, only=["release"]), "only: given 'release'; must be among"),
        (lambda m: ab.stability.borders(m, up_to=-1.0), "up_to: given -1.0; must be greater than zero"),
        (lambda m: with_quantity(m, "temperature", 300.0), "has no fluid of the catalog"),
        (lambda m: with_quantity(with_quantity(m, "drag", 1e-4), "plateau", 0.5), "'viscous', has none"),
        (lambda m: with_quantity(m, "rolling_resistance", -0.1), "must not be negative"),
        (lambda m: ab.stability.speed_windows(m), "autobalancer equivalent-planar FILE --out planar.toml"),
    ],
)
def test_what_cannot_be_answered_says_what_to_do(ask: Any, message: str) -> None:
    with pytest.raises(QuestionError, match=message):
        ask(machine(rotor(), (0.03,)))


def test_balls_that_turn_round_go_on_where_rounding_leaves_their_speed_the_old_sign() -> None:
    carried = run(machine(rotor(0.08, (2e4, 3e4)), (-0.1, 0.15), rolling=0.0027), 110.6, 118.6, 0.2, 106.0)
    assert carried.attrs["outcome"] == "finished"
    assert float(carried["ball_speed_in_rotor"].max()) > 0.0
