"""The stepper: orders, dense output, events, corners, records, outcomes, and that it compiles once."""

from __future__ import annotations

import os
import subprocess
import sys
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar
from tests.references import lagrange
from tests.references.runs import states_at
from tests.references.trees import order_of, trees

import autobalancer as ab
from autobalancer.assembly.system import assemble
from autobalancer.kernels.guided_balls import planar
from autobalancer.kernels.integrators.memory import ACCEPTED, END, LONGEST, NEXT_SAMPLE, STEP, TIME, Memory
from autobalancer.kernels.integrators.record import Record
from autobalancer.kernels.integrators.runge_kutta import EVENT, FINISHED, RUNNING, advance
from autobalancer.kernels.integrators.tableau import Tableau, dormand_prince_8, tsitouras
from autobalancer.machine import Machine
from autobalancer.simulation.events import Event
from autobalancer.simulation.record import record_for
from autobalancer.simulation.run import memory_for
from autobalancer.simulation.sampling import Envelope, LastRevolutions, Samples, SampleTimes, Sampling

PAIRS = {"tsitouras": tsitouras(), "dormand_prince_8": dormand_prince_8()}
ORDERS = {"tsitouras": (5, 4, 4), "dormand_prince_8": (8, 5, 7)}  # solution, embedded, dense output
both = pytest.mark.parametrize("method", PAIRS)


def run_up(**changes: Any) -> Machine:
    """Two rolling balls, driven by a torque through the critical speed of 250 rad/s."""
    data: dict[str, Any] = {
        "name": "run-up",
        "axis": "vertical",
        "rotor": {"mass": 10.0, "stiffness": 6.25e5, "damping": 100.0, "inertia": 0.05},
        "unbalances": [{"mass": 5e-3, "radius": 0.1}],
        "balancers": [
            {
                "races": [
                    {
                        "orbit_radius": 0.1,
                        "drag": {"law": "beta", "beta": 1.5e-4},
                        "balls": [{"count": 2, "mass": 2.5e-3, "diameter": 8e-3, "start_angles": [1.0, -1.9]}],
                    }
                ]
            }
        ],
        "drive": {"kind": "torque", "torque": 15.0, "damping": 0.0},
    }
    return Machine(**(data | changes))


def oscillator(speed: float = 100.0, **start: Any) -> Machine:
    """No balls, a constant speed: linear, with a solution in closed form."""
    return Machine(
        name="oscillator",
        axis="vertical",
        rotor={"mass": 2.0, "stiffness": [8e4, 5e4], "damping": [10.0, 6.0]},
        unbalances=[{"moment": 1e-3, "angle": 0.5}],
        drive={"kind": "speed", "profile": {"kind": "constant", "speed": speed}},
        start={"deflection": [1e-3, -5e-4], "velocity": [0.1, 0.2], **start},
    )


def exact(machine: Machine, t: Any) -> tuple[Any, Any]:
    """x and y of the oscillator."""
    result = []
    w, u = machine.drive.profile.speed, machine.unbalances[0]  # type: ignore[union-attr]
    for i in range(2):
        m, k, b = 2.0, machine.rotor.stiffness_xy[i], machine.rotor.damping_xy[i]
        force = u.size * w**2 * np.exp(1j * (u.angle - i * np.pi / 2))
        forced = force / (k - m * w**2 + 1j * b * w)
        root = -b / (2 * m) + 1j * np.sqrt(k / m - (b / (2 * m)) ** 2)
        x0 = machine.start.deflection[i] - forced.real
        v0 = machine.start.velocity[i] - (1j * w * forced).real
        free = x0 + 1j * (root.real * x0 - v0) / root.imag
        result.append((forced * np.exp(1j * w * t)).real + (free * np.exp(root * t)).real)
    return result[0], result[1]


def prepared(
    machine: Machine,
    end: float,
    save: list[Sampling] | None = None,
    events: list[Event] | None = None,
    *,
    tolerance: float = 1e-8,
    pair: Tableau | None = None,
    rotating: bool | None = None,
) -> tuple[Any, Tableau, Record, Memory]:
    pair = pair or dormand_prince_8()
    assembly = assemble(machine, rotating=rotating)
    return (
        assembly.system,
        pair,
        record_for(save or [], events or [], assembly, end),
        memory_for(assembly, end, tolerance, pair),
    )


# the pairs as numbers ---------------------------------------------------------------------------------------------------


def test_there_are_as_many_rooted_trees_as_cayley_counted() -> None:
    assert [len(trees(n)) for n in range(1, 9)] == [1, 1, 2, 4, 9, 20, 48, 115]


@both
def test_a_pair_satisfies_the_order_conditions_of_all_rooted_trees(method: str) -> None:
    pair, (order, embedded, _) = PAIRS[method], ORDERS[method]
    a = pair.matrix[: pair.total]
    weights = a[pair.main - 1]
    np.testing.assert_allclose(a.sum(axis=1), pair.nodes, rtol=0.0, atol=1e-14)
    assert order_of(weights, a, order + 1 if order < 8 else 8) == order
    assert order_of(weights - pair.matrix[pair.total], a, embedded + 1) == embedded


def test_the_correction_of_the_error_estimate_has_order_three() -> None:
    pair = dormand_prince_8()
    a = pair.matrix[: pair.total]
    assert order_of(a[pair.main - 1] - pair.matrix[pair.total + 1], a, 4) == 3


@both
@pytest.mark.parametrize("x", [0.21, 0.5, 0.83, 1.0])
def test_dense_output_satisfies_the_order_conditions_inside_the_step(method: str, x: float) -> None:
    pair, (_, _, dense) = PAIRS[method], ORDERS[method]
    weights = pair.dense @ x ** np.arange(1, pair.degree + 1)
    assert order_of(weights, pair.matrix[: pair.total], dense, x=x) == dense


@both
def test_dense_output_ends_in_the_solution_and_with_its_slope(method: str) -> None:
    pair = PAIRS[method]
    np.testing.assert_allclose(pair.dense.sum(axis=1), pair.matrix[pair.main - 1], rtol=0.0, atol=1e-12)
    slope = pair.dense @ np.arange(1, pair.degree + 1)
    np.testing.assert_allclose(slope, np.eye(pair.total)[pair.main - 1], rtol=0.0, atol=1e-12)


# observed orders --------------------------------------------------------------------------------------------------------


def fixed_steps(machine: Machine, end: float, count: int, pair: Tableau, times: Any) -> np.ndarray:
    system, _, record, memory = prepared(machine, end, [SampleTimes(times)], tolerance=1e-2, pair=pair)
    memory.absolute[:] = 1e6
    memory.clock[STEP] = memory.clock[LONGEST] = end / count
    assert advance(planar, system, pair, record, memory, 10 * count) == FINISHED
    assert memory.counts[ACCEPTED] == count
    return record.samples


@both
def test_halving_the_step_divides_the_error_by_two_to_the_order(method: str) -> None:
    """At the end of steps and in between, on the nonlinear machine with balls on unequal supports."""
    machine = run_up(
        rotor={"mass": 10.0, "stiffness": [6.25e5, 5e5], "damping": 100.0, "inertia": 0.05}, start={"speed": 200.0}
    )
    end = 0.1
    times = [*np.linspace(0.0, end, 2000, endpoint=False), end]
    reference = states_at(machine, times, tolerance=1e-13)
    errors = []
    for count in (16, 32, 64) if method == "dormand_prince_8" else (64, 128, 256):
        miss = np.abs(fixed_steps(machine, end, count, PAIRS[method], times) - reference)
        errors.append([miss[:-1].max(), miss[-1].max()])
    rates = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    order = ORDERS[method][0]
    assert rates.min() > order - 0.5, rates
    assert rates.max() < order + 1.5, rates


@both
@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10, 1e-12])
def test_the_error_of_a_linear_oscillator_is_of_the_size_of_the_tolerance(method: str, tolerance: float) -> None:
    machine = oscillator()
    times = np.linspace(0.0, 2.0, 501)
    states = states_at(machine, times, tolerance=tolerance, pair=PAIRS[method])
    x, y = exact(machine, times)
    error = max(np.abs(states[:, 0] - x).max(), np.abs(states[:, 1] - y).max())
    assert error < 300.0 * tolerance * 1e-3  # 200 rad/s for 2 s, deflections of 1 mm
    assert error > 1e-5 * tolerance * 1e-3 or error < 1e-15


def test_both_methods_and_both_frames_give_the_same_run() -> None:
    machine = run_up()
    times = np.linspace(0.0, 2.0, 101)
    reference = states_at(machine, times, tolerance=1e-13)
    for method in PAIRS:
        for rotating in (True, False):
            states = states_at(machine, times, tolerance=1e-12, pair=PAIRS[method], rotating=rotating)
            np.testing.assert_allclose(states[:, :2], reference[:, :2], rtol=0.0, atol=1e-10 * 1e-3)
            np.testing.assert_allclose(states[:, 4:8], reference[:, 4:8], rtol=0.0, atol=1e-8)


def test_a_longer_run_does_not_change_its_beginning_beyond_the_tolerance() -> None:
    times = np.linspace(0.0, 1.0, 50)
    short = states_at(run_up(), times, tolerance=1e-11)
    long = states_at(run_up(), [*times, 2.0], tolerance=1e-11)
    np.testing.assert_allclose(short[:, :2], long[:-1, :2], rtol=0.0, atol=1e-12)


# events -----------------------------------------------------------------------------------------------------------------


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
    assert advance(planar, system, pair, record, memory, 10**6) == EVENT
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
    assert advance(planar, system, pair, record, memory, 10**6) == EVENT
    assert advance(planar, system, pair, record, memory, 10**6) == FINISHED
    plain = states_at(machine, [1.0])
    np.testing.assert_allclose(lagrange.to_space(record.samples)[:, :2], plain[:, :2], rtol=0.0, atol=1e-12)


# corners ----------------------------------------------------------------------------------------------------------------

CORNERS = [0.2, 0.35, 0.5123, 1.1]
CORNERED = {
    "drive": {"kind": "speed", "profile": {"kind": "table", "time": CORNERS, "speed": [100.0, 300.0, 300.0, 150.0]}},
    "unbalances": [
        {"moment": 4e-4, "schedule": {"time": [0.77, 0.77, 0.9], "factor": [1.0, 0.2, 1.5]}},
    ],
}


@pytest.mark.parametrize("tolerance", [1e-3, 1e-8])
def test_steps_end_exactly_at_corners_of_profile_and_unbalance(tolerance: float) -> None:
    system, pair, record, memory = prepared(run_up(**CORNERED), 1.5, tolerance=tolerance)
    times = []
    while advance(planar, system, pair, record, memory, 1) == RUNNING:
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


# stop and go ------------------------------------------------------------------------------------------------------------


@both
@pytest.mark.parametrize("rotating", [True, False])
def test_stop_and_go_gives_the_same_bits_as_one_go(method: str, rotating: bool) -> None:
    save: list[Sampling] = [Samples(300), Envelope(40), LastRevolutions(3, 16)]
    events = [Event("deflection", 3e-4), Event("speed", 100.0)]
    results = []
    for budget in (10**6, 1, 7):
        system, pair, record, memory = prepared(
            run_up(**CORNERED), 1.5, save, events, pair=PAIRS[method], rotating=rotating
        )
        while advance(planar, system, pair, record, memory, budget) == RUNNING:
            pass
        results.append((record, memory))
    for record, memory in results[1:]:
        for one, other in zip(record, results[0][0], strict=True):
            np.testing.assert_array_equal(one, other)
        np.testing.assert_array_equal(memory.state, results[0][1].state)
        np.testing.assert_array_equal(memory.counts, results[0][1].counts)
        np.testing.assert_array_equal(memory.clock, results[0][1].clock)


def test_the_end_can_be_moved_further_out() -> None:
    system, pair, record, memory = prepared(run_up(), 0.5)
    assert advance(planar, system, pair, record, memory, 10**6) == FINISHED
    memory.clock[END] = 1.0
    assert advance(planar, system, pair, record, memory, 10**6) == FINISHED
    assert memory.clock[TIME] == 1.0
    plain = states_at(run_up(), [1.0])[-1]
    np.testing.assert_allclose(lagrange.to_space(memory.state)[:2], plain[:2], rtol=0.0, atol=1e-10)


# samples, envelope, last revolutions ------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", PAIRS)
@pytest.mark.parametrize("frame", ["rotor", "space"])
def test_the_envelope_is_that_of_a_dense_oversampling(method: str, frame: str) -> None:
    run = ab.simulate(
        run_up(), duration=2.0, save=[Samples(200_001), Envelope(40)], tolerance=1e-9, method=method, frame=frame
    )
    deflection = run.deflection.values
    per_bin = 200_000 // 40
    for b in range(40):
        inside = deflection[b * per_bin : (b + 1) * per_bin + 1]
        assert run.envelope_high[b] >= inside.max() * (1.0 - 1e-12)
        assert run.envelope_low[b] <= inside.min() * (1.0 + 1e-12) + 1e-15
        assert run.envelope_high[b] == pytest.approx(inside.max(), rel=1e-5)
        assert run.envelope_low[b] == pytest.approx(inside.min(), rel=1e-3, abs=1e-8)


def test_the_envelope_of_the_oscillator_has_the_extrema_of_the_closed_form() -> None:
    machine = oscillator()
    run = ab.simulate(machine, duration=1.0, save=Envelope(10), tolerance=1e-13)
    times = np.linspace(0.0, 1.0, 2_000_001)
    deflection = np.hypot(*exact(machine, times))
    for b in range(10):
        inside = deflection[b * 200_000 : (b + 1) * 200_000 + 1]
        assert run.envelope_high.values[b] == pytest.approx(inside.max(), rel=1e-9)
        near = times[b * 200_000 + int(np.argmin(inside))]
        bounds = max(near - 1e-6, 0.1 * b), min(near + 1e-6, 0.1 * (b + 1))
        least = minimize_scalar(lambda t: np.hypot(*exact(machine, t)), bounds=bounds, options={"xatol": 1e-15})
        assert run.envelope_low.values[b] == pytest.approx(min(least.fun, inside.min()), rel=1e-6)


def test_states_at_the_ends_of_bins_are_the_samples_there() -> None:
    run = ab.simulate(run_up(), duration=2.0, save=[Samples(41), Envelope(40)])
    np.testing.assert_allclose(run.envelope_speed, run.speed[1:], rtol=1e-13)
    np.testing.assert_allclose(run.envelope_ball_angle_in_rotor, run.ball_angle_in_rotor[1:], rtol=0.0, atol=1e-12)


def test_last_revolutions_stand_at_equal_rotor_angles_and_on_the_motion() -> None:
    run = ab.simulate(run_up(), duration=2.0, save=LastRevolutions(5, 24), tolerance=1e-11)
    angle = run.turn_rotor_angle.values
    assert angle.size == 5 * 24 + 1
    np.testing.assert_allclose(angle / (2 * np.pi / 24), np.round(angle / (2 * np.pi / 24)), rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(np.diff(angle), 2 * np.pi / 24, rtol=1e-9)
    again = ab.simulate(run_up(), duration=2.0, save=SampleTimes(run.turn_time.values), tolerance=1e-11)
    np.testing.assert_allclose(again.rotor_angle, angle, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(again.x, run.turn_x, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(again.y, run.turn_y, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(again.ball_angle_in_rotor, run.turn_ball_angle_in_rotor, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize(
    "case",
    [
        {"drive": {"kind": "torque", "torque": 0.0, "damping": 0.05}, "start": {"speed": 300.0}},
        {
            "drive": {
                "kind": "speed",
                "profile": {"kind": "table", "time": [0.0, 1.0, 1.1], "speed": [300.0, 300.0, 0.0]},
            }
        },
        {"drive": {"kind": "speed", "profile": {"kind": "constant", "speed": -200.0}}},
        {},
    ],
    ids=["coasts down", "is stopped", "turns backwards", "runs up"],
)
def test_the_last_revolutions_are_whole_however_the_rotor_turns(case: dict[str, Any]) -> None:
    run = ab.simulate(run_up(**case), duration=4.0, save=LastRevolutions(6, 12))
    step = np.diff(run.turn_rotor_angle) / (2 * np.pi / 12)
    assert run.turn_time.size == 6 * 12 + 1
    assert np.all(np.diff(run.turn_time) > 0.0)
    np.testing.assert_allclose(step, np.sign(step[0]), rtol=1e-9)


def test_the_last_revolutions_before_an_event_are_kept() -> None:
    event = Event("speed", 200.0, ends_run=True)
    run = ab.simulate(run_up(), duration=10.0, save=LastRevolutions(3, 12), events=[event])
    assert run.turn_time.size == 37
    assert run.attrs["end_time"] - run.turn_time[-1] < 2 * np.pi / 12 / 200.0 * 1.01


def test_what_a_run_keeps_does_not_grow_with_its_length() -> None:
    save: list[Sampling] = [Samples(100), Envelope(20), LastRevolutions(2, 8)]
    sizes = []
    for end in (1.0, 1e6):
        _, _, record, memory = prepared(run_up(), end, save, [Event("speed", 10.0)])
        sizes.append(sum(np.asarray(a).nbytes for a in (*record, *memory)))
    assert sizes[0] == sizes[1]


def test_a_day_of_a_slow_rotor_passes_in_the_memory_of_a_second() -> None:
    import tracemalloc

    machine = run_up(drive={"kind": "speed", "profile": {"kind": "constant", "speed": 20.0}})
    peaks = []
    for end in (1.0, 200.0):
        system, pair, record, memory = prepared(machine, end, [Samples(10), Envelope(10)], tolerance=1e-6)
        tracemalloc.start()
        assert advance(planar, system, pair, record, memory, 10**9) == FINISHED
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < peaks[0] + 10_000


# outcomes ---------------------------------------------------------------------------------------------------------------


def test_a_run_that_reaches_its_end_is_finished() -> None:
    run = ab.simulate(run_up(), duration=0.1)
    assert run.attrs["outcome"] == "finished"
    assert run.attrs["end_time"] == 0.1


def test_a_run_ended_by_an_event_names_it() -> None:
    run = ab.simulate(run_up(), duration=10.0, events=[Event("speed", 50.0), Event("speed", 100.0, ends_run=True)])
    assert run.attrs["outcome"] == "event"
    assert "speed through 100" in run.attrs["outcome_text"]


def test_a_run_out_of_budget_keeps_what_it_has_and_says_so() -> None:
    run = ab.simulate(run_up(), duration=10.0, save=Samples(1001), max_steps=50)
    assert run.attrs["outcome"] == "budget spent"
    assert run.attrs["steps"] == 50
    assert 0 < run.time.size < 1001
    assert np.isfinite(run.x).all()
    assert "max_steps" in run.attrs["outcome_text"]


def test_a_torque_that_jumps_back_and_forth_makes_the_step_too_small() -> None:
    table = {"kind": "torque_table", "speed": [100.0, 100.00000000000003], "torque": [1e25, -1e25]}
    run = ab.simulate(run_up(drive=table, start={"speed": 100.0}), duration=1.0, save=Samples(11), max_steps=10**5)
    assert run.attrs["outcome"] == "step too small"
    assert run.attrs["end_time"] < 1.0


def test_motion_beyond_all_bounds_is_not_finite_and_no_exception() -> None:
    run = ab.simulate(run_up(start={"speed": 1e200}), duration=1.0, save=Samples(11))
    assert run.attrs["outcome"] == "not finite"


# compiled once ----------------------------------------------------------------------------------------------------------

SECOND = """
import autobalancer as ab
from autobalancer.machine import Machine
from autobalancer.simulation.sampling import Envelope, LastRevolutions, Samples
from autobalancer.simulation.events import Event
rotor = {"mass": 10.0, "stiffness": 6e5, "damping": 80.0, "inertia": 0.05}
drive = {"kind": "torque", "torque": 3.0}
machine = Machine(name="second", axis="vertical", rotor=rotor, unbalances=[{"moment": 4e-4}], drive=drive)
run = ab.simulate(machine, duration=1.0, save=[Samples(30), Envelope(5), LastRevolutions(1, 8)],
                  events=[Event("speed", 20.0)])
print("values", [float(v).hex() for v in run.x.values[-3:]], run.attrs["steps"])
"""


def fresh_process(**environment: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", SECOND], env=os.environ | environment, capture_output=True, text=True, check=True
    )
    return done.stdout


def test_a_second_process_compiles_nothing() -> None:
    fresh_process()
    said = fresh_process(NUMBA_DEBUG_CACHE="1")
    assert "data loaded from" in said
    assert "data saved to" not in said
    assert "index saved to" not in said
    loaded = [line for line in said.splitlines() if "data loaded from" in line]
    assert any("planar" in line for line in loaded)
    assert any("advance" in line for line in loaded)


def test_kernels_compiled_before_the_newest_change_in_any_kernel_are_forgotten(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Numba would keep a stepper although a function compiled into it has changed."""
    from autobalancer.kernels.cache import compiled_before, forget_outdated

    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    folder = tmp_path / "integrators_0123"
    folder.mkdir()
    old, new = folder / "runge_kutta.advance-1.py311.nbi", folder / "guided_balls.planar-2.py311.nbi"
    foreign = folder / "someone.else-3.py311.nbi"
    for path in (old, new, foreign):
        path.touch()
    for path in (old, foreign):
        os.utime(path, (1e9, 1e9))
    assert compiled_before()
    forget_outdated()
    assert not compiled_before()
    assert [old.exists(), new.exists(), foreign.exists()] == [False, True, True]


def test_interpreted_kernels_do_the_same_as_compiled_ones() -> None:
    compiled, interpreted = fresh_process(), fresh_process(NUMBA_DISABLE_JIT="1")
    values = [[float.fromhex(word.strip("[',]")) for word in said.split()[1:4]] for said in (compiled, interpreted)]
    np.testing.assert_allclose(values[0], values[1], rtol=1e-9, atol=1e-16)
    assert compiled.split()[-1] == interpreted.split()[-1]
