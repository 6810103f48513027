"""Samples, envelopes and last revolutions tell the same motion, in bounded memory."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from tests.references.cases import PAIRS, exact, oscillator, prepared, run_up

import autobalancer as ab
from autobalancer.kernels.integrators.runge_kutta import FINISHED, advance
from autobalancer.simulation.record import Envelope, Event, LastRevolutions, Samples, SampleTimes, Sampling
from autobalancer.simulation.steppers import PLANAR


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


@pytest.mark.parametrize("method", ["dormand_prince_8", "exponential_collocation"])
def test_an_event_that_never_happens_changes_no_bit_of_the_last_revolutions(method: Any) -> None:
    """Where none can end a run, revolutions that cannot be the last ones are left out."""
    runs = [
        ab.simulate(run_up(), duration=6.0, save=LastRevolutions(2, 24), method=method, events=events)
        for events in ([], [Event("speed", 1e6, ends_run=True)])
    ]
    assert runs[0].turn_time.size == 2 * 24 + 1
    for name in ("turn_time", "turn_x", "turn_y", "turn_ball_angle_in_rotor", "turn_rotor_angle"):
        assert runs[0][name].values.tobytes() == runs[1][name].values.tobytes(), name


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
        assert advance(*PLANAR, system, pair, record, memory, 10**9) == FINISHED
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < peaks[0] + 10_000
