"""Events are found where they happen, and steps end at corners."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq
from tests.references import lagrange
from tests.references.cases import CORNERED, CORNERS, both, exact, oscillator, prepared, run_up
from tests.references.runs import states_at

import autobalancer as ab
from autobalancer.assembly.system import assemble
from autobalancer.kernels.integrators.integrator_state import NEXT_SAMPLE, TIME
from autobalancer.kernels.integrators.runge_kutta import EVENT, FINISHED, RUNNING, advance
from autobalancer.simulation.record import Envelope, Event, Samples, SampleTimes
from autobalancer.simulation.steppers import PLANAR

# events ---------------------------------------------------------------------------------------------------------------


def test_a_speed_is_passed_at_the_exact_time() -> None:
    """Without balls and unbalance the speed grows by torque over inertia."""
    machine = run_up(balancers=[], unbalances=[])
    levels = [50.0, 123.456, 299.0]
    run = ab.simulate(machine, duration=1.0, save=Samples(2), events=[Event("speed", level) for level in levels])
    np.testing.assert_allclose(run.event_time, np.array(levels) * 0.05 / 15.0, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(run.event_speed, levels, rtol=1e-13)


@both
@pytest.mark.parametrize("direction", ["rising", "falling", "both"])
def test_deflections_are_passed_at_the_times_of_the_closed_form(method: str, direction: str) -> None:
    machine, level, end = oscillator(), 4e-4, 0.5

    def value(t: Any) -> Any:
        return np.hypot(*exact(machine, t)) - level

    grid = np.linspace(0.0, end, 20001)
    signs = np.sign(value(grid))
    wanted = {"rising": (1,), "falling": (-1,), "both": (1, -1)}[direction]
    expected = [
        brentq(value, grid[i], grid[i + 1], xtol=1e-15)
        for i in range(grid.size - 1)
        if signs[i] != signs[i + 1] and signs[i + 1] in wanted
    ]
    assert len(expected) > 10
    event = Event("deflection", level, direction=direction)
    run = ab.simulate(machine, duration=end, save=Samples(2), events=[event], tolerance=1e-13, method=method)
    np.testing.assert_allclose(run.event_time, expected, rtol=0.0, atol=1e-10)
    np.testing.assert_allclose(run.event_deflection, level, rtol=1e-12)


def test_events_of_several_kinds_come_in_the_order_of_time() -> None:
    machine = run_up()
    events = [
        Event("ball_speed_in_rotor", -20.0, ball=1),
        Event("speed", 100.0),
        Event("ball_speed_in_space", 150.0, ball=2, direction="rising"),
        Event("fastest_ball_in_rotor", 30.0),
        Event("deflection", 2e-4),
    ]
    run = ab.simulate(machine, duration=2.0, save=Samples(20001), events=events, tolerance=1e-11)
    assert np.all(np.diff(run.event_time) >= 0.0)
    assert set(run.event_name.values) == {event.name for event in events}
    series = {
        events[0].name: run.ball_speed_in_rotor.values[:, 0] + 20.0,
        events[1].name: run.speed.values - 100.0,
        events[3].name: np.abs(run.ball_speed_in_rotor.values).max(axis=1) - 30.0,
        events[4].name: run.deflection.values - 2e-4,
    }
    for name, value in series.items():
        change = np.flatnonzero(value[:-1] * value[1:] < 0.0)
        times = run.event_time.values[run.event_name.values == name]
        assert times.size == change.size
        assert np.all((run.time.values[change] <= times) & (times <= run.time.values[change + 1]))
    rising = run.ball_speed_in_space.values[:, 1] - 150.0
    change = np.flatnonzero((rising[:-1] < 0.0) & (rising[1:] > 0.0))
    assert np.count_nonzero(run.event_name.values == events[2].name) == change.size


def test_a_terminal_event_ends_the_run_there_and_the_state_is_that_of_the_event() -> None:
    machine = run_up()
    events = [Event("speed", 60.0), Event("speed", 100.0, ends_run=True), Event("speed", 100.1)]
    system, pair, record, memory = prepared(machine, 5.0, [Samples(5001), Envelope(50)], events, tolerance=1e-12)
    assert advance(*PLANAR, system, pair, record, memory, 10**6) == EVENT
    assert memory.state[5] == pytest.approx(100.0, rel=1e-13)
    assert list(record.event_seen) == [1, 1, 0]
    np.testing.assert_array_equal(record.event_states[1, 2:], memory.state)
    assert record.event_states[1, 1] == memory.clock[TIME]
    count = memory.counts[NEXT_SAMPLE]
    assert record.sample_times[count - 1] <= memory.clock[TIME] < record.sample_times[count]
    tight = states_at(machine, [0.0, memory.clock[TIME]])[-1]
    np.testing.assert_allclose(lagrange.to_space(memory.state), tight, rtol=1e-9, atol=1e-12)


def test_two_watchers_of_one_level_both_see_it() -> None:
    events = [Event("speed", 100.0), Event("speed", 100.0, ends_run=True), Event("speed", 100.0)]
    run = ab.simulate(run_up(), duration=1.0, save=Samples(2), events=events)
    assert run.attrs["events_seen"] == [1, 1, 1]
    assert run.attrs["outcome"] == "event"


def test_a_run_can_go_on_after_a_terminal_event() -> None:
    machine = run_up()
    events = [Event("speed", 100.0, ends_run=True)]
    system, pair, record, memory = prepared(machine, 1.0, [SampleTimes([1.0])], events, tolerance=1e-12)
    assert advance(*PLANAR, system, pair, record, memory, 10**6) == EVENT
    assert advance(*PLANAR, system, pair, record, memory, 10**6) == FINISHED
    plain = states_at(machine, [1.0])
    np.testing.assert_allclose(lagrange.to_space(record.samples)[:, :2], plain[:, :2], rtol=0.0, atol=1e-12)


# corners --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("tolerance", [1e-3, 1e-8])
def test_steps_end_exactly_at_corners_of_profile_and_unbalance(tolerance: float) -> None:
    system, pair, record, memory = prepared(run_up(**CORNERED), 1.5, tolerance=tolerance)
    times = []
    while advance(*PLANAR, system, pair, record, memory, 1) == RUNNING:
        times.append(memory.clock[TIME])
    assert {*CORNERS, 0.77, 0.9} <= set(times)
    assert memory.clock[TIME] == 1.5


def test_corners_cost_no_accuracy() -> None:
    """The run through all corners agrees with one in which every stretch is integrated by another program."""
    from scipy.integrate import solve_ivp

    machine = run_up(**CORNERED)
    reference = lagrange.planar(machine)
    state = lagrange.to_space(assemble(machine).state)
    edges = sorted({0.0, *CORNERS, 0.77, 0.9, 1.5})
    for a, b in pairwise(edges):
        inside = 0.5 * (a + b)

        def rates(t: float, y: np.ndarray, a: float = a, b: float = b, inside: float = inside) -> np.ndarray:
            return reference.rates(min(max(t, a + 1e-12 * inside), b - 1e-12 * inside), y)

        state = solve_ivp(rates, (a, b), state, method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
    ours = states_at(machine, [1.5])[-1]
    np.testing.assert_allclose(ours[:2], state[:2], rtol=0.0, atol=1e-11)
    np.testing.assert_allclose(ours[6:8], state[6:8], rtol=0.0, atol=1e-8)


def test_a_speed_follows_its_profile_to_rounding() -> None:
    run = ab.simulate(run_up(**CORNERED), duration=1.5, save=Samples(301))
    expected = np.interp(run.time, CORNERS, [100.0, 300.0, 300.0, 150.0])
    np.testing.assert_allclose(run.speed, expected, rtol=1e-12)
