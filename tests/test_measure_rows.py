"""Measures that compiled code takes from a run, against those of the labelled run and against plain arithmetic."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import autobalancer as ab
from autobalancer.files.machine_file import load_machine
from autobalancer.kernels.integrators.runge_kutta import RUNNING
from autobalancer.kernels.measures.columns import COLUMNS, STATUS
from autobalancer.machine import Machine
from autobalancer.results.measure_table import SWEPT, numbers
from autobalancer.results.recorded_of import recorded_of
from autobalancer.simulation import run as of_simulate
from autobalancer.studies.sweep_row import sweep_row

MACHINES = Path(__file__).parents[1] / "examples" / "machines"
OTHERS = ("chamber_cylinders", "deep_chamber", "deep_chamber_fitted", "released_body", "single_layer", "liquid_ring")
RACES = sorted(path.stem for path in MACHINES.glob("*.toml") if path.stem not in OTHERS)
SAVE = [ab.Samples(2), ab.Envelope(60), ab.LastRevolutions(3, 36)]


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
    expected = numbers(recorded_of(bins)) | {"ball_angle_to_unbalance": recorded_of(run).final_angle}
    for measure in SWEPT:
        if expected.get(measure.name) is not None:
            np.testing.assert_array_equal(row[measure.name], expected[measure.name], err_msg=measure.name)
        else:
            assert np.isnan(row[measure.name]).all(), measure.name
    assert row["verdict"] == ab.verdict(bins).word


@pytest.mark.parametrize("name", RACES)
def test_a_row_of_a_sweep_has_the_numbers_of_the_run_to_the_last_bit(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert_same(*both(load_machine(MACHINES / f"{name}.toml"), 0.4, monkeypatch))


def test_every_measure_of_a_sweep_is_a_column_of_a_row() -> None:
    assert [m.name for m in SWEPT if not m.per_ball] == list(COLUMNS[:STATUS])
