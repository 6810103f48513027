"""The release of balls of several planes or kinds on rubber that softens with the amplitude."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from tests.references.rubber import MASS, described
from tests.test_rubber_ellipses import machine as on_supports
from tests.test_rubber_response import ONLY, RACE, machine, planar

import autobalancer as ab
from autobalancer.assembly.rotors import balancer_rows, equivalent_stiffness, lateral_model
from autobalancer.machine import Machine
from autobalancer.stability.stall.borders import rubber_under_balls

BALL: dict[str, Any] = RACE["balls"][0]
ROLLING = {"friction": {"rolling_resistance": 0.003}}
LIGHT, HEAVY = [{**BALL, "count": 1}], [{**BALL, "count": 2, "mass": 0.0148}]


def race(balls: list[dict[str, Any]], **more: Any) -> dict[str, Any]:
    return {"races": [{**RACE, **ROLLING, "balls": balls, **more}]}


def in_one_plane(rotor: dict[str, Any], *kinds: list[dict[str, Any]]) -> Machine:
    return machine({"mass": MASS, **rotor}, moment=20e-6, balancers=[race(kind) for kind in kinds])


def released(one: Machine) -> Any:
    return ab.stability.borders(one, only=ONLY[:1])[0]


def test_two_kinds_of_balls_on_rubber_that_hardly_softens_are_released_as_on_plain_springs() -> None:
    springs = {"stiffness": 44654.0, "damping": 68.37}
    hard = {"rubber": {**springs, "friction": {"breakaway_amplitude": [1e-3], "stiffness": [1e-3]}}}
    soft, plain = (released(in_one_plane(rotor, LIGHT, HEAVY)) for rotor in (hard, springs))
    assert soft.speed == pytest.approx(plain.speed, rel=1e-6)
    assert "the strongest balls alone" in soft.note
    assert "the strongest balls alone" in plain.note


@pytest.mark.slow
def test_two_kinds_that_hardly_differ_part_where_equal_balls_do() -> None:
    # equal ones by the phase of the resonance, these by the eigenvalues of their motion with the whirl and the rubber
    near = [{**BALL, "count": 1, "mass": BALL["mass"] * (1.0 + 1e-7)}]
    kinds = in_one_plane({"rubber": described()}, LIGHT, near)
    assert released(kinds).speed == pytest.approx(released(planar(rolling=0.003)).speed, rel=5e-5)


def in_two_planes(
    angles: tuple[list[float], list[float]], springs: Any = None, mass: float = 0.0148, **more: Any
) -> Machine:
    """One or two balls in each plane of a rigid rotor on two supports of rubber."""
    middle = [{**BALL, "count": len(angles[0]), "start_angles": angles[0]}]
    end = [{**BALL, "count": len(angles[1]), "start_angles": angles[1], "mass": mass}]
    races = [{"station": name, **race(balls, collisions=False)} for name, balls in (("middle", middle), ("end", end))]
    return on_supports(springs, moment=20e-6, balancers=races, **more)


def test_where_x_and_y_differ_the_release_of_two_planes_is_refused_with_a_way_out() -> None:
    uneven, caught = ab.stability.borders(in_two_planes(([0.3], [0.1]), (1e3, 3e3)), only=ONLY)
    assert not uneven.known
    assert "simulate a slow run-up" in uneven.note
    assert not caught.known
    assert "simulate a slow run-down" in caught.note


def hangs_to(make: Callable[..., Machine], speeds: tuple[float, float], rate: float) -> np.ndarray:
    """Rotor speed in a slow run-up from the first to the second speed at which each ball still lags by half."""
    times, passed = [0.0, 15.0, 15.0 + (speeds[1] - speeds[0]) / rate], [48.0, *speeds]
    ramp = make(drive={"kind": "speed", "profile": {"kind": "table", "time": times, "speed": passed}})
    run = ab.simulate(ramp, duration=times[-1], save=ab.Samples(count=int(4.0 * times[-1])))
    speed = np.interp(run.time.values, times, passed)
    lag = np.array([np.convolve(one, np.full(9, 1.0 / 9.0), "same") for one in run.ball_speed_in_rotor.values.T])
    late = run.time.values > 14.0
    return np.array([speed[(one < -4.0) & late].max(initial=0.0) for one in lag])


def test_amplitudes_of_the_rubber_do_not_depend_on_where_their_search_begins(monkeypatch: pytest.MonkeyPatch) -> None:
    one = in_two_planes(([0.35], [-0.1]), mass=BALL["mass"])
    soft = rubber_under_balls(one)
    rows = [rows.deflection for rows in balancer_rows(one, lateral_model(one))]
    speeds = np.linspace(50.0, 60.0, 5)
    load = 8e-4 * np.outer(speeds**2, rows[0] * np.exp(-1.7j) + rows[1] * np.exp(-0.2j))
    usual = soft.circles(speeds, load, attempted=True)
    assert np.ptp(usual.amplitude[2]) > 1e-6  # of the two pieces
    found = equivalent_stiffness._newton

    def hardly(laws: Any, w: Any, across: Any, free: Any, size: float) -> Any:
        """No start that is as stiff or as soft as possible finds anything."""
        return found(laws, w, across, free, size) if 0.0 < size < 1.0 else (abs(free), np.arange(w.size))

    monkeypatch.setattr(equivalent_stiffness, "_newton", hardly)
    again = soft.circles(speeds, load, attempted=True)
    np.testing.assert_allclose(again.amplitude, usual.amplitude, rtol=1e-8)
    np.testing.assert_allclose(again.motion, usual.motion, rtol=1e-8)


@pytest.mark.slow
def test_one_ball_in_each_of_two_planes_is_released_in_a_run_where_the_balance_ends() -> None:
    def make(**more: Any) -> Machine:
        return in_two_planes(([0.35], [-0.1]), mass=BALL["mass"], **more)

    found = released(make()).speed
    # by roots of both balances with amplitudes in turns: one at which the first piece of rubber moves 1 mm, so no lower end
    assert found > 64.4432
    left = hangs_to(make, (found - 0.6, found + 0.7), 0.04)
    assert left.min() == pytest.approx(found, rel=0.006)
    assert left.max() < 1.01 * found  # 0.04 rad/s² goes on while the second one leaves


@pytest.mark.slow
def test_of_unequal_planes_that_part_one_after_the_other_the_first_leaves_in_a_run_where_the_note_says() -> None:
    def make(**more: Any) -> Machine:
        return in_two_planes(([0.35, 0.3], [-0.1, 0.1]), **more)

    last = released(make())
    assert (
        "states in which the planes stall at different speeds are not sought, and balls may be released higher"
        in last.note
    )
    first = float(last.note.split("the balls of middle part first, at ")[1].split(" rad/s")[0])
    left = hangs_to(make, (first - 0.7, first + 0.8), 0.03)
    assert left[:2] == pytest.approx(np.full(2, first), rel=0.01)
    assert (left[2:] > first + 0.7).all()  # the others hang on
    left = hangs_to(make, (last.speed - 0.6, last.speed + 1.3), 0.05)
    assert left[2:] == pytest.approx(np.full(2, last.speed), rel=0.02)  # free balls of the other plane shift it


@pytest.mark.slow
def test_two_kinds_in_one_plane_are_released_in_a_run_where_the_balance_ends() -> None:
    def make(**more: Any) -> Machine:
        light, heavy = {**BALL, "count": 1}, {**BALL, "count": 1, "mass": 0.010}
        kinds = [{**light, "start_angles": [0.35]}], [{**heavy, "start_angles": [-0.1]}]
        balancers = [race(kind, collisions=False) for kind in kinds]
        one = machine({"mass": MASS, "rubber": described()}, moment=20e-6, balancers=balancers)
        return Machine(**{**{key: getattr(one, key) for key in one.model_fields_set}, **more})

    found = released(make()).speed
    left = hangs_to(make, (found - 1.5, found + 1.0), 0.04)
    assert left.min() == pytest.approx(found, rel=0.006)
    assert left.max() < 1.01 * found


@pytest.mark.slow
def test_a_slow_run_up_measures_the_release_that_is_not_computed_where_x_and_y_differ() -> None:
    times, passed = [0.0, 15.0, 65.0], [48.0, 62.0, 67.0]
    ramp = {"kind": "speed", "profile": {"kind": "table", "time": times, "speed": passed}}
    one = in_two_planes(([0.35, -0.1], [0.1]), (1e3, 3e3), BALL["mass"], drive=ramp)
    run = ab.simulate(one, duration=times[-1], save=ab.Samples(count=260))
    circling = run.speed + run.ball_speed_in_rotor.mean("ball")
    whirl = float(circling[(run.time > 20.0) & (run.time < 45.0)].mean())
    assert whirl == pytest.approx(54.7, abs=0.5)
    left = ab.run_measures(run, "break_away_speed", critical_speed=1.05 * whirl).values
    # as long as they hang they lag by 8 rad/s and more
    still = (run.ball_speed_in_rotor < -4.0) & (run.time > 20.0)
    seen = [float(run.speed[still[:, ball]].max()) for ball in range(3)]
    assert left == pytest.approx(seen, abs=0.3)
    assert left == pytest.approx(np.full(3, 66.5), abs=0.5)  # 0.1 rad/s², found with 0.05
