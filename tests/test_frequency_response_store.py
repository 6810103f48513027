"""A stepped response that was interrupted goes on as if it had not been."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import autobalancer as ab
from autobalancer.assembly.quantities import with_value_at
from autobalancer.errors import QuestionError, ResultError
from autobalancer.files.examples import example_text, rig
from autobalancer.studies.stepped_response import stepped_response

RIG = rig("rodrigues_rig")
SPEEDS = np.linspace(130.0, 260.0, 7)
QUESTION: dict[str, Any] = {"dwell": 0.5, "window": 0.2}


def interrupted_after(count: int) -> Any:
    def progress(done: int, total: int) -> None:
        if done == count:
            raise KeyboardInterrupt

    return progress


def same(one: xr.Dataset, two: xr.Dataset) -> bool:
    return bool(one.drop_attrs().equals(two.drop_attrs()))


@pytest.mark.parametrize(
    "way",
    [{"direction": "both"}, {"direction": "down", "acceleration": 50.0, "without_balls": True}, {"start": "fixed"}],
)
def test_an_interrupted_study_ends_with_the_same_bits(way: dict[str, Any], tmp_path: Path) -> None:
    whole = stepped_response(RIG, SPEEDS, **QUESTION, **way)
    store = tmp_path / "steps.nc"
    with pytest.raises(KeyboardInterrupt):
        stepped_response(RIG, SPEEDS, **QUESTION, **way, store=store, progress=interrupted_after(3))
    assert not store.exists()
    seen: list[int] = []
    resumed = stepped_response(RIG, SPEEDS, **QUESTION, **way, store=store, progress=lambda done, _: seen.append(done))
    assert seen[0] >= 3  # what was finished is not done again
    assert same(resumed, whole)
    assert [path.name for path in tmp_path.iterdir()] == ["steps.nc"]
    again = stepped_response(RIG, SPEEDS, **QUESTION, **way, store=store, progress=interrupted_after(0))
    np.testing.assert_array_equal(again["amplitude"], whole["amplitude"])
    np.testing.assert_array_equal(again["greatest_ball_angle_in_rotor"], whole["greatest_ball_angle_in_rotor"])


def test_a_part_that_a_crash_left_half_is_measured_again(tmp_path: Path) -> None:
    whole, store = stepped_response(RIG, SPEEDS, **QUESTION), tmp_path / "steps.nc"
    with pytest.raises(KeyboardInterrupt):
        stepped_response(RIG, SPEEDS, **QUESTION, store=store, progress=interrupted_after(4))
    *_, last = sorted((tmp_path / "steps.nc.parts" / "parts").iterdir())
    last.rename(last.with_name(f"unfinished-{last.name}"))
    part = stepped_response(RIG, SPEEDS, **QUESTION, store=store, progress=interrupted_after(5), keep_on_interrupt=True)
    assert part.attrs["outcome"] == "interrupted"
    assert np.isfinite(part["amplitude"]).values.tolist() == [True] * 5 + [False] * 2
    assert same(stepped_response(RIG, SPEEDS, **QUESTION, store=store), whole)


def test_a_store_of_another_machine_or_question_is_refused(tmp_path: Path) -> None:
    store = tmp_path / "steps.nc"
    with pytest.raises(KeyboardInterrupt):
        stepped_response(RIG, SPEEDS, **QUESTION, store=store, progress=interrupted_after(2))
    heavier = with_value_at(RIG, "rotor.mass", 1.3)

    def refused() -> None:
        with pytest.raises(QuestionError, match="different: machine"):
            stepped_response(heavier, SPEEDS, **QUESTION, store=store)
        with pytest.raises(QuestionError, match=r"window \(0.2 there, 0.3 now\)"):
            stepped_response(RIG, SPEEDS, dwell=0.5, window=0.3, store=store)
        with pytest.raises(QuestionError, match="different: speeds"):
            stepped_response(RIG, SPEEDS[:-1], **QUESTION, store=store)

    refused()
    stepped_response(RIG, SPEEDS, **QUESTION, store=store)
    refused()


def test_a_damaged_note_and_a_foreign_result_are_refused(tmp_path: Path) -> None:
    (tmp_path / "a.nc.parts").mkdir()
    (tmp_path / "a.nc.parts" / "note.json").write_text("no note\n")
    with pytest.raises(ResultError, match=r"note.json: cannot be read"):
        stepped_response(RIG, SPEEDS, **QUESTION, store=tmp_path / "a.nc")
    ab.save_run(ab.simulate(RIG, duration=0.1), tmp_path / "b.nc")
    with pytest.raises(QuestionError, match="not a stepped response"):
        stepped_response(RIG, SPEEDS, **QUESTION, store=tmp_path / "b.nc")


@pytest.mark.slow
def test_the_command_stops_at_ctrl_c_and_goes_on_when_called_again(tmp_path: Path) -> None:
    (tmp_path / "rig.toml").write_text(example_text("rodrigues_rig"), encoding="utf-8")
    command = [
        sys.executable, "-m", "autobalancer", "stepped-response", "rig.toml", "--speeds", "1000rpm:3000rpm:7", "--dwell",
        "60 s", "--window", "3 s", "--out", "s.nc", "--json",
    ]  # fmt: skip
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # what a process in the background ignores,
    running = subprocess.Popen(command, cwd=tmp_path, env=os.environ | {"COLUMNS": "200"})
    signal.signal(signal.SIGINT, before)  # its children ignore as well
    parts = tmp_path / "s.nc.parts"
    end = time.monotonic() + 300.0
    while running.poll() is None and time.monotonic() < end:
        if len(list(parts.glob("parts/0*.npz"))) >= 2:
            running.send_signal(signal.SIGINT)
            break
        time.sleep(0.01)
    assert running.wait(60.0) == 130
    left = len(list(parts.glob("parts/0*.npz")))
    assert 2 <= left < 7
    ended = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    numbers = json.loads(ended.stdout)
    whole = stepped_response(RIG, np.linspace(1000.0, 3000.0, 7) * np.pi / 30.0, dwell=60.0, window=3.0)
    assert numbers["outcome"] == "finished"
    assert not parts.exists()
    assert max(numbers["amplitude_without_balls"]) > 0.0
    np.testing.assert_allclose(numbers["amplitude"], whole["amplitude"], rtol=1e-6)
