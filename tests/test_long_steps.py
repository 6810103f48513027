"""Long steps by exponential collocation: the same motion as with the explicit pair, in fewer steps."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.references.cases import CORNERED, run_up

import autobalancer as ab
from autobalancer.assembly.system import assemble
from autobalancer.errors import QuestionError
from autobalancer.kernels.integrators.collocation import HANDED, LONG_STEPS, SWEEPS, radau
from autobalancer.kernels.integrators.integrator_state import ACCEPTED, END, REJECTED, TIME
from autobalancer.kernels.integrators.recording import Record
from autobalancer.kernels.integrators.runge_kutta import EVENT, FINISHED, RUNNING
from autobalancer.kernels.system import BALLS, SPEED
from autobalancer.machine import Machine
from autobalancer.simulation.record import (
    Envelope,
    Event,
    LastRevolutions,
    Samples,
    SampleTimes,
    Sampling,
    record_for,
    turns_complete,
)
from autobalancer.simulation.steppers import Stepper, stepper_for

LONG, PAIR = "exponential_collocation", "dormand_prince_8"


def balls(count: int, mass: float = 2.5e-3, beta: float = 1.5e-4, spread: float = 6.0, **race: Any) -> dict[str, Any]:
    angles = list(np.linspace(0.0, spread, count + 1)[:-1] - 2.8)
    one = {"count": count, "mass": mass, "diameter": 8e-3, "start_angles": angles}
    circle = {"collisions": False, "orbit_radius": 0.1, "drag": {"law": "viscous", "damping": beta}, "balls": [one]}
    return {"balancers": [{"races": [circle | race]}]}


def rotor(**changes: float) -> dict[str, Any]:
    return {"rotor": {"mass": 10.0, "stiffness": 6.25e5, "damping": 100.0, "inertia": 0.05} | changes}


def begun(
    machine: Machine,
    end: float,
    method: str = LONG,
    save: list[Sampling] | None = None,
    events: list[Event] | None = None,
    tolerance: float = 1e-8,
) -> tuple[Stepper, Any, Record]:
    assembly = assemble(machine)
    return (
        stepper_for(assembly, end, tolerance, method),
        assembly.system,
        record_for(save or [], events or [], assembly, end),
    )


def states(machine: Machine, end: float, method: str, tolerance: float) -> tuple[np.ndarray, Stepper]:
    times = np.linspace(0.0, end, 173)
    stepper, system, record = begun(machine, end, method, [SampleTimes(times)], tolerance=tolerance)
    assert stepper.advance(system, record, 10**7) == FINISHED
    return record.samples, stepper


def miss(found: np.ndarray, exact: np.ndarray) -> float:
    """Greatest miss of the deflection over its peak, and of a ball angle over a turn."""
    peak = np.abs(exact[:, 0] + 1j * exact[:, 1]).max()
    place = np.abs(found[:, :2] - exact[:, :2]).max() / peak
    count = (exact.shape[1] - BALLS) // 2
    angle = np.abs(found - exact)[:, BALLS : BALLS + count].max(initial=0.0) / (2.0 * np.pi)
    return float(max(place, angle))


def test_the_nodes_integrate_polynomials_up_to_degree_fourteen_over_a_step() -> None:
    numbers = radau()
    once = numbers.integrals[:64].reshape(8, 8).T
    errors = [abs((once @ numbers.nodes**k)[-1] - 1.0 / (k + 1)) for k in range(16)]
    assert max(errors[:15]) < 1e-15
    assert errors[15] > 1e-10
    for k in range(8):
        np.testing.assert_allclose(once @ numbers.nodes**k, numbers.nodes ** (k + 1) / (k + 1), rtol=0.0, atol=1e-15)


def test_speeds_that_die_out_by_themselves_are_solved_for() -> None:
    """The tables give h (1 + x A)^-1 A for any x, and with it the closed form of u' = 1 - x u, u(0) = 0, over a step of 1."""
    numbers = radau()
    once, powers = numbers.integrals[:64].reshape(8, 8).T, numbers.damped.reshape(8, 8, 8).transpose(0, 2, 1)
    for x in (0.0, 0.3, 4.0, 50.0):
        size = x ** np.arange(9)
        found = np.tensordot(size[:8], powers, 1) / (size @ numbers.determinant)
        np.testing.assert_allclose(found, np.linalg.solve(np.eye(8) + x * once, once), rtol=0.0, atol=1e-15)
        if x > 0.0:
            exact = -np.expm1(-x * numbers.nodes) / x
            np.testing.assert_allclose(found @ np.ones(8), exact, rtol=0.0, atol=1e-14 if x < 1.0 else 2e-3)


MACHINES: dict[str, dict[str, Any]] = {
    "two balls": {},
    "no balls": {"balancers": []},
    "one ball": balls(1),
    "twenty balls": balls(20, 2.5e-4),
    "heavy balls": balls(2, 0.05),
    "strong drag": balls(2, beta=1.5e-2),
    "strong damping": rotor(damping=2500.0),
    "undamped": rotor(damping=0.0),
    "off center": {"start": {"deflection": [1e-3, 5e-4], "velocity": [0.1, -0.2]}},
    "fast from the start": {"start": {"speed": 600.0, "deflection": [2e-3, 0.0]}},
    "prescribed speed with corners and jumps": CORNERED,
    "smooth profile": {
        "drive": {"kind": "speed", "profile": {"kind": "hill", "end": 400.0, "half_time": 0.5, "exponent": 3.0}}
    },
    "eccentric race": balls(2, eccentricity=2e-4, eccentricity_angle=1.0),
    "torque that falls": {"drive": {"kind": "torque_table", "speed": [0.0, 200.0, 400.0], "torque": [20.0, 15.0, 0.0]}},
    "asynchronous motor": {
        "drive": {
            "kind": "asynchronous",
            "rated_torque": 12.0,
            "overload": 2.2,
            "synchronous_speed": 400.0,
            "breakdown_slip": 0.2,
        }
    },
}


@pytest.mark.parametrize("changes", [{}, balls(2, beta=1.5e-2), {"drive": MACHINES["asynchronous motor"]["drive"]}])
def test_drag_and_a_motor_that_brakes_do_not_make_the_iteration_long(changes: dict[str, Any]) -> None:
    """Drag alone would let a ball stop within 2.5 ms, the motor the rotor within 50 ms, and steps are longer than either."""
    _, stepper = states(run_up(**changes), 3.0, LONG, 1e-6)
    assert stepper.long is not None
    tallies = stepper.long.amplitudes.tallies
    assert tallies[LONG_STEPS] == stepper.memory.counts[ACCEPTED]
    assert tallies[SWEEPS] < 8.0 * (tallies[LONG_STEPS] + stepper.memory.counts[REJECTED])
    assert stepper.memory.counts[REJECTED] < 0.2 * tallies[LONG_STEPS]


@pytest.mark.parametrize("name", MACHINES)
def test_long_steps_are_as_accurate_as_the_pair_at_the_same_tolerance(name: str) -> None:
    """Against a run of the pair at 1e-13. The pair itself may be better or worse than its tolerance, by machine."""
    machine, end = run_up(**MACHINES[name]), 1.5
    exact, _ = states(machine, end, PAIR, 1e-13)
    for tolerance in (1e-6, 1e-9):
        pair, one = states(machine, end, PAIR, tolerance)
        long, other = states(machine, end, LONG, tolerance)
        assert miss(long, exact) < max(4.0 * miss(pair, exact), 3.0 * tolerance), tolerance
        assert other.memory.counts[ACCEPTED] <= 1.2 * one.memory.counts[ACCEPTED]


def test_a_run_up_takes_a_fraction_of_the_steps() -> None:
    _, pair = states(run_up(), 3.0, PAIR, 1e-6)
    _, long = states(run_up(), 3.0, LONG, 1e-6)
    assert long.memory.counts[ACCEPTED] < 0.4 * pair.memory.counts[ACCEPTED]
    assert long.attributes()["long_steps"] == long.memory.counts[ACCEPTED]


def test_the_free_whirl_inside_long_steps_is_the_closed_form() -> None:
    """Without balls and unbalance the motion in space is e^(mu t), however long a step is."""
    machine = run_up(
        balancers=[],
        unbalances=[],
        start={"deflection": [1e-3, 0.0], "velocity": [0.0, 0.05]},
        drive={"kind": "speed", "profile": {"kind": "constant", "speed": 300.0}},
    )
    times = np.linspace(0.0, 1.0, 501)
    stepper, system, record = begun(machine, 1.0, save=[SampleTimes(times)], tolerance=1e-9)
    assert stepper.advance(system, record, 10**6) == FINISHED
    found = (record.samples[:, 0] + 1j * record.samples[:, 1]) * np.exp(1j * record.samples[:, 4])
    decay = 100.0 / 20.0
    turn = np.sqrt(6.25e4 - decay**2)
    free = np.exp(-decay * times) * (1e-3 * np.cos(turn * times) + (0.05j + decay * 1e-3) / turn * np.sin(turn * times))
    assert np.abs(found - free).max() < 3e-9 * 1e-3
    assert stepper.memory.counts[ACCEPTED] < 0.1 * turn * 1.0


# stop and go ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("contact", ["none", "soft", "rigid"])
def test_stop_and_go_gives_the_same_bits_as_one_go(contact: str) -> None:
    """Also where the pair takes over and hands back, and where balls strike."""
    soft = {"contact": {"stiffness": 1e5, "restitution": 0.14}} if contact == "soft" else {}
    machine = run_up(**(CORNERED | balls(3, spread=0.3, collisions=contact != "none", **soft)))
    save: list[Sampling] = [Samples(300), Envelope(40), LastRevolutions(3, 16)]
    events = [Event("deflection", 3e-4), Event("speed", 100.0)]
    results = []
    for budget in (10**6, 1, 7):
        stepper, system, record = begun(machine, 1.5, save=save, events=events)
        while stepper.advance(system, record, budget) == RUNNING:
            pass
        results.append((record, stepper))
    assert results[0][1].long is not None
    assert results[0][1].long.amplitudes.tallies[LONG_STEPS] > 20
    for record, stepper in results[1:]:
        for one, other in zip(record, results[0][0], strict=True):
            np.testing.assert_array_equal(one, other)
        for one, other in zip(stepper.memory[:3], results[0][1].memory[:3], strict=True):
            np.testing.assert_array_equal(one, other)


def test_the_end_can_be_moved_further_out() -> None:
    stepper, system, record = begun(run_up(), 0.5)
    assert stepper.advance(system, record, 10**6) == FINISHED
    stepper.memory.clock[END] = 1.0
    assert stepper.advance(system, record, 10**6) == FINISHED
    assert stepper.memory.clock[TIME] == 1.0
    plain, _ = states(run_up(), 1.0, PAIR, 1e-12)
    np.testing.assert_allclose(stepper.memory.state[:2], plain[-1, :2], rtol=0.0, atol=1e-10)


def test_a_terminal_event_ends_the_run_there_and_it_can_go_on() -> None:
    events = [Event("speed", 60.0), Event("speed", 100.0, ends_run=True), Event("speed", 100.1)]
    stepper, system, record = begun(run_up(), 1.0, save=[Samples(1001)], events=events, tolerance=1e-11)
    assert stepper.advance(system, record, 10**6) == EVENT
    assert stepper.memory.state[SPEED] == pytest.approx(100.0, rel=1e-13)
    assert list(record.event_seen) == [1, 1, 0]
    assert stepper.advance(system, record, 10**6) == FINISHED
    assert list(record.event_seen) == [1, 1, 1]
    plain, _ = states(run_up(), 1.0, PAIR, 1e-12)
    np.testing.assert_allclose(record.samples[-1, :2], plain[-1, :2], rtol=0.0, atol=1e-12)


def test_envelopes_and_revolutions_are_those_of_the_pair() -> None:
    machine = run_up(start={"deflection": [5e-4, 0.0]})
    runs = [
        ab.simulate(machine, duration=2.0, save=[Envelope(60), LastRevolutions(4)], tolerance=1e-10, method=method)
        for method in (LONG, PAIR)
    ]
    for name in ("envelope_low", "envelope_high", "turn_x", "turn_y", "turn_speed"):
        one, other = (run[name].values for run in runs)
        np.testing.assert_allclose(one, other, rtol=0.0, atol=1e-8 * np.abs(other).max())


def test_the_last_revolution_is_whole_where_one_step_turns_the_rotor_more_often() -> None:
    machine = run_up(start={"speed": 400.0}, drive={"kind": "torque", "torque": 0.0})  # free, and hardly moving
    stepper, system, record = begun(machine, 5.0, save=[LastRevolutions(1)], tolerance=1e-4)
    assert stepper.advance(system, record, 10**7) == FINISHED
    assert turns_complete(record, stepper.memory, assemble(machine))


# contacts and refusals ------------------------------------------------------------------------------------------------


def test_the_pair_takes_over_while_balls_touch_softly() -> None:
    machine = run_up(
        **balls(3, spread=0.3, collisions=True, contact={"stiffness": 1e5, "restitution": 0.14}),
        start={"speed": 300.0},
    )
    exact, _ = states(machine, 1.0, PAIR, 1e-13)
    found, stepper = states(machine, 1.0, LONG, 1e-11)
    assert stepper.long is not None
    tallies = stepper.long.amplitudes.tallies
    assert 0 < tallies[LONG_STEPS] < stepper.memory.counts[ACCEPTED]
    assert tallies[HANDED] > 0
    assert miss(found, exact) < 1e-8  # impacts enlarge errors about a hundredfold, of the pair too


STALLING = {"kind": "table", "time": [0.0, 2.5, 4.0, 5.0], "speed": [100.0, 240.0, 255.0, 400.0]}
TOUCHING: dict[str, dict[str, Any]] = {
    "two balls that do not rebound": balls(2, contact={"restitution": 0.0}),
    "three that do": balls(3, 1.7e-3, contact={"restitution": 0.5}),
    "eight": balls(8, 6e-4, contact={"restitution": 0.3}),
    "three and two partitions": balls(3, 1.7e-3, contact={"restitution": 0.3}, partitions={"count": 2}),
}


@pytest.mark.parametrize("name", TOUCHING)
def test_rigid_contacts_open_and_close_inside_long_steps_as_with_the_pair(name: str) -> None:
    """Balls gather while the speed is held near the critical one, then part."""
    circle = TOUCHING[name]["balancers"][0]["races"][0]
    machine = run_up(
        balancers=[{"races": [circle | {"collisions": True}]}], drive={"kind": "speed", "profile": STALLING}
    )
    exact, _ = states(machine, 5.0, PAIR, 1e-12)
    for tolerance in (1e-6, 1e-9):
        pair, one = states(machine, 5.0, PAIR, tolerance)
        long, other = states(machine, 5.0, LONG, tolerance)
        assert miss(long, exact) < max(4.0 * miss(pair, exact), 5.0 * tolerance), tolerance
        assert other.memory.counts[ACCEPTED] < 0.8 * one.memory.counts[ACCEPTED]
    stepper, system, record = begun(machine, 5.0, tolerance=1e-6)
    held = 0
    while stepper.advance(system, record, 1) == RUNNING:
        held += int(system.rigid.bound[0] > 1)
    assert held > 20


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (rotor(stiffness=[6e5, 5e5]), "equal springs"),  # type: ignore[arg-type]
        ({"axis": "horizontal"}, "gravity"),
        (rotor(damping=6000.0), "critical damping"),
    ],
)
def test_machines_for_which_there_are_no_long_steps_are_refused_by_name(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(QuestionError, match=words):
        ab.simulate(run_up(**changes), duration=0.1, method=LONG)


def test_long_steps_are_taken_unasked_where_they_are_possible() -> None:
    asked = {"duration": 0.1, "save": Samples(2)}
    run = ab.simulate(run_up(), **asked)
    assert run.attrs["method"] == LONG
    assert run.attrs["long_steps"] > 0
    assert run.attrs["sweeps"] > run.attrs["long_steps"]
    assert run.attrs["lanes"] == 8
    other = ab.simulate(run_up(**rotor(stiffness=[6e5, 5e5])), **asked)  # type: ignore[arg-type]
    assert other.attrs["method"] == PAIR


def test_an_unknown_method_is_refused_with_the_names_of_those_there_are() -> None:
    with pytest.raises(QuestionError, match="exponential_collocation"):
        ab.simulate(run_up(), duration=0.1, method="radau")
