"""The stepper: orders, accuracy, stop and go, outcomes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.references import lagrange
from tests.references.cases import CORNERED, ORDERS, PAIRS, both, exact, oscillator, prepared, run_up
from tests.references.runs import states_at
from tests.references.trees import order_of, trees

import autobalancer as ab
from autobalancer.kernels.integrators.integrator_state import ACCEPTED, END, LONGEST, REJECTED, STEP, TIME
from autobalancer.kernels.integrators.runge_kutta import FINISHED, RUNNING, advance
from autobalancer.kernels.integrators.tableau import Tableau, dormand_prince_8
from autobalancer.machine import Machine
from autobalancer.simulation.record import Envelope, Event, LastRevolutions, Samples, SampleTimes, Sampling
from autobalancer.simulation.steppers import PLANAR

# the pairs as numbers -------------------------------------------------------------------------------------------------


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


# observed orders ------------------------------------------------------------------------------------------------------


def fixed_steps(machine: Machine, end: float, count: int, pair: Tableau, times: Any) -> np.ndarray:
    system, _, record, memory = prepared(machine, end, [SampleTimes(times)], tolerance=1e-2, pair=pair)
    memory.absolute[:] = 1e6
    memory.clock[STEP] = memory.clock[LONGEST] = end / count
    assert advance(*PLANAR, system, pair, record, memory, 10 * count) == FINISHED
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
    for count in (32, 64, 128) if method == "dormand_prince_8" else (128, 256, 512):
        miss = np.abs(fixed_steps(machine, end, count, PAIRS[method], times) - reference)
        errors.append([miss[:-1].max(), miss[-1].max()])
    rates = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    # of order eight, the next order still counts where rounding begins
    np.testing.assert_allclose(rates, ORDERS[method][0], atol=0.4 if method == "dormand_prince_8" else 0.1)


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


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8, 1e-10])
def test_step_control_rejects_hardly_a_step_of_a_smooth_run_up(tolerance: float) -> None:
    system, pair, record, memory = prepared(run_up(), 3.0, tolerance=tolerance)
    assert advance(*PLANAR, system, pair, record, memory, 10**6) == FINISHED
    assert memory.counts[REJECTED] <= 0.003 * memory.counts[ACCEPTED] + 1


def test_a_longer_run_does_not_change_its_beginning_beyond_the_tolerance() -> None:
    times = np.linspace(0.0, 1.0, 50)
    short = states_at(run_up(), times, tolerance=1e-11)
    long = states_at(run_up(), [*times, 2.0], tolerance=1e-11)
    np.testing.assert_allclose(short[:, :2], long[:-1, :2], rtol=0.0, atol=1e-12)


# stop and go ----------------------------------------------------------------------------------------------------------


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
        while advance(*PLANAR, system, pair, record, memory, budget) == RUNNING:
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
    assert advance(*PLANAR, system, pair, record, memory, 10**6) == FINISHED
    memory.clock[END] = 1.0
    assert advance(*PLANAR, system, pair, record, memory, 10**6) == FINISHED
    assert memory.clock[TIME] == 1.0
    plain = states_at(run_up(), [1.0])[-1]
    np.testing.assert_allclose(lagrange.to_space(memory.state)[:2], plain[:2], rtol=0.0, atol=1e-10)


# outcomes -------------------------------------------------------------------------------------------------------------


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
    machine = run_up()
    beyond = machine.start.model_copy(update={"speed": 1e200})  # past the bounds that a description has
    run = ab.simulate(machine.model_copy(update={"start": beyond}), duration=1.0, save=Samples(11))
    assert run.attrs["outcome"] == "not finite"
