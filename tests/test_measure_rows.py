"""Measures that compiled code takes from a run, against those of the labelled run and against plain arithmetic."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.test_places import DRUM, SHAFT, laid_down_rig

import autobalancer as ab
from autobalancer.assembly.places import desk_for
from autobalancer.files.machine_file import load_machine, parse_machine
from autobalancer.kernels.integrators.runge_kutta import RUNNING
from autobalancer.kernels.measures.record_series import COLUMN, MEASURED, OF_PLACES, WIDTH
from autobalancer.kernels.measures.row import measure_row
from autobalancer.machine import Machine
from autobalancer.results.measure_table import PER_BALL, SWEPT, in_row, numbers
from autobalancer.results.run_arrays import recorded_of
from autobalancer.results.time_series import compiled
from autobalancer.results.verdict import WORDS
from autobalancer.simulation import run as of_simulate
from autobalancer.studies.variations import completed, gauges_for

MACHINES = Path(__file__).parents[1] / "examples" / "machines"
OTHERS = ("chamber_cylinders", "deep_chamber", "deep_chamber_fitted", "released_body", "single_layer", "liquid_ring")
RACES = sorted(path.stem for path in MACHINES.glob("*.toml") if path.stem not in OTHERS)
SAVE = [ab.Samples(2), ab.Envelope(60), ab.LastRevolutions(3, 36)]


def sweep_row(status: int, assembly: Any, places: Any, record: Any, memory: Any, end: float, impacts: Any) -> Any:
    """All that a sweep keeps of a run with an envelope and its last revolutions."""
    gauges = gauges_for(assembly, places, end)
    hits = impacts.time.size if impacts is not None else 0
    desk = desk_for(gauges, record.turn_states.shape[0], record.bin_low.size, hits)
    desk.noted[0] = 0
    if impacts is not None:
        desk.hits[:], desk.noted[0] = (impacts.time, impacts.speed, impacts.lost, impacts.impulse), hits
    row = np.empty(WIDTH + len(assembly.balls))
    measure_row(assembly.system, record, memory, gauges, desk, status, row)
    row = completed(row, assembly, places, gauges)
    return {"verdict": WORDS[int(row[COLUMN.verdict])], **in_row(row)}


def both(machine: Machine, duration: float, monkeypatch: pytest.MonkeyPatch) -> tuple[Any, dict[str, Any]]:
    """A run, and the row that compiled code takes from the same arrays."""
    kept: list[Any] = []
    labelled = of_simulate.run_dataset

    def keep(assembly: Any, places: Any, record: Any, state: Any, *others: Any) -> Any:
        kept.append((assembly, places, record, state))
        return labelled(assembly, places, record, state, *others)

    monkeypatch.setattr(of_simulate, "run_dataset", keep)
    run = ab.simulate(machine, duration=duration, save=SAVE, tolerance=1e-6)
    found = recorded_of(run).impacts
    status = RUNNING if run.attrs["outcome"] != "finished" else 1
    return run, sweep_row(status, *kept[0], duration, found)


def assert_same(run: Any, row: dict[str, Any]) -> None:
    bins = run.drop_dims("time")  # so that balls are seen at the ends of bins, as in a sweep
    seen = recorded_of(bins)
    angle = recorded_of(run).final_angle
    expected = numbers(seen) | {PER_BALL: angle if seen.at_rest or angle is None else np.full_like(angle, np.nan)}
    for measure in SWEPT:
        if expected.get(measure.name) is not None:
            np.testing.assert_array_equal(row[measure.name], expected[measure.name], err_msg=measure.name)
        else:
            assert np.isnan(row[measure.name]).all(), measure.name
    assert row["verdict"] == ab.verdict(bins).word


def test_a_measure_made_of_others_is_their_ratio_in_a_run_in_a_sweep_and_at_each_place_at_once() -> None:
    machine = load_machine(MACHINES / "two_plane_rotor.toml")
    found = ab.run_measures(ab.simulate(machine, duration=0.3, tolerance=1e-6))
    ratio = found["vibration"].max() / found["vibration_without_balls"].max()
    assert found["vibration_share"].dims == ()
    assert float(found["vibration_share"]) == pytest.approx(float(ratio), rel=1e-14)
    swept = ab.sweep(machine, {}, seeds=2, duration=0.3)
    np.testing.assert_allclose(
        swept["vibration_share"], swept["vibration"] / swept["vibration_without_balls"], rtol=1e-14
    )


@pytest.mark.parametrize("name", RACES)
def test_a_row_of_a_sweep_has_the_numbers_of_the_run_to_the_last_bit(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    duration = 0.1 if name == "variant_incline" else 0.4  # its steps are short
    assert_same(*both(load_machine(MACHINES / f"{name}.toml"), duration, monkeypatch))


def at_speed(machine: Machine, speed: str, **parts: Any) -> Machine:
    drive = {"kind": "speed", "profile": {"kind": "constant", "speed": speed}}
    return ab.with_parameter(machine.model_copy(update=parts), "drive", drive)


def with_slow_balls(machine: Machine) -> Machine:
    """Balls that hardly feel the fluid and turn at half the speed."""
    race = "balancers[1].races[1]"
    slow = ab.with_parameter(machine, f"{race}.balls[1].start_speeds", [-250.0, -260.0])
    return ab.with_parameter(slow, f"{race}.drag.damping", 1e-6)


STEADY = {
    "two planes": lambda: at_speed(load_machine(MACHINES / "two_plane_rotor.toml"), "3000 rpm"),
    "two planes and a motor": lambda: ab.with_parameter(
        load_machine(MACHINES / "two_plane_rotor.toml").model_copy(update={"start": {"speed": 300.0}}),
        "drive",
        {"kind": "torque", "torque": 0.1, "damping": 1e-4},
    ),
    "drum, lying": lambda: parse_machine(DRUM),
    "balls that whirl, lying": lambda: with_slow_balls(
        at_speed(load_machine(MACHINES / "stall_and_release.toml"), "500 rad/s", axis="horizontal")
    ),
    "shaft": lambda: parse_machine(SHAFT),
    "several bodies": laid_down_rig,
    "resolved": lambda: at_speed(load_machine(MACHINES / "resolved_balls.toml"), "900 rpm"),
    "rubber": lambda: at_speed(load_machine(MACHINES / "rubber.toml"), "900 rpm"),
    "bearings": lambda: at_speed(load_machine(MACHINES / "coupled_drive.toml"), "900 rpm"),
}


@pytest.mark.parametrize("name", STEADY)
def test_so_it_has_where_whole_revolutions_were_kept(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    run, row = both(STEADY[name](), 0.6, monkeypatch)
    assert_same(run, row)
    assert row["vibration"] > 0.0
    if name == "balls that whirl, lying":
        turned = run["turn_ball_angle_in_rotor"]
        assert (abs(turned[-1] - turned[0]) > np.pi).all()
        assert np.isnan([row["residual_unbalance"], row["residual_share"], *row[PER_BALL]]).all(), "no ball rests"
    else:
        assert np.isfinite(row["residual_unbalance"])


def test_every_measure_of_a_sweep_is_a_column_of_a_row_or_made_of_such() -> None:
    without_greatest = {one.name for one in OF_PLACES if not one.of_all}
    assert {m.name for m in SWEPT if not m.per_ball and not m.made_of} == set(MEASURED) - without_greatest
    assert {name for m in SWEPT for name in m.made_of} <= set(MEASURED)


def test_a_rotor_crosses_the_range_of_its_resonance_as_fast_as_its_ramp() -> None:
    ramp = {"kind": "ramp", "start": 0.0, "end": 500.0, "duration": 2.0}
    machine = ab.with_parameter(
        load_machine(MACHINES / "stall_and_release.toml"), "drive", {"kind": "speed", "profile": ramp}
    )
    found = ab.run_measures(ab.simulate(machine, duration=3.0, save=ab.Envelope(77)))
    assert float(found["time_at_resonance"]) == pytest.approx(0.2 * 250.0 / 250.0, rel=1e-9)  # w_c = 250 rad/s
    # any critical speed counts, and where two are near each other the time counts once
    whirls = np.array([[100.0, 0.0], [110.0, 0.0], [300.0, 0.0]])
    time = np.linspace(0.0, 2.0, 9)
    assert compiled().time_at_resonance(time, 250.0 * time, whirls) == pytest.approx((121.0 - 90.0 + 60.0) / 250.0)
    assert compiled().time_at_resonance(time, np.full(9, 105.0), whirls) == 2.0


def test_a_stalled_ball_is_late_by_the_time_between_the_critical_speed_and_its_release() -> None:
    run = ab.simulate(MACHINES / "stall_and_release.toml", save=[ab.Samples(20_001), ab.Envelope(500)])
    found = ab.run_measures(run)
    speed, time = run["speed"].values, run["time"].values
    released = np.interp(found["break_away_speed"].values, speed[time <= 15.0], time[time <= 15.0])
    np.testing.assert_allclose(found["break_away_time"], released, rtol=1e-9)
    from_here = np.interp(1.02 * 250.0, speed[time <= 15.0], time[time <= 15.0])  # where a ball can be called stalled
    assert (found["stalled_time"] >= found["break_away_time"] - from_here - 0.2).all()
    assert (found["stalled_time"] <= found["break_away_time"] - from_here + 1.0).all()
    faster = found["greatest_ball_speed"].values
    np.testing.assert_array_equal(faster, np.abs(run["ball_speed_in_space"].values).max(axis=0))


def test_the_greatest_force_on_a_support_is_that_of_its_spring_and_damper_at_the_peak() -> None:
    run = ab.simulate(MACHINES / "stall_and_release.toml", duration=10.0, hold_balls=True)
    spring, damper = 625_000.0 * float(run["deflection"].max()), 100.0 * 250.0 / 625_000.0  # share of it near resonance
    found = float(ab.run_measures(run)["peak_force"][0])
    assert spring < found < spring * (1.0 + damper**2)
