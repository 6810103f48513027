"""Studies in a folder survive kills, full disks and lost workers, and have the same bits afterwards."""

from __future__ import annotations

import errno
import multiprocessing
import os
import signal
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import autobalancer as ab
from autobalancer.errors import QuestionError, ResultError
from autobalancer.studies.study import study as execute

ROOT = Path(__file__).parents[1]
MACHINE = str(ROOT / "examples/machines/discoidal.toml")
MASS = {"distribution": "normal", "standard_deviation": "5 %"}
SHORT: dict[str, Any] = {"machine": MACHINE, "duration": "0.5 s", "members": 40, "vary": {"unbalances[1].mass": MASS}}


def same_bits(one: xr.Dataset, other: xr.Dataset) -> None:
    for name in one.variables:
        assert np.array_equal(one[name].values, other[name].values, equal_nan=one[name].dtype.kind == "f"), name


def test_chunks_and_threads_change_no_bit(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = {**SHORT, "vary": {**SHORT["vary"], "viscosity": ["10 mm^2/s", "50 mm^2/s"]}}
    one = ab.study(asked, workers=1)
    monkeypatch.setattr(execute, "MOST", 7)
    monkeypatch.setattr(execute, "FIRST", 3)
    other = ab.study(asked, workers=2)
    same_bits(one, other)


def test_a_study_goes_on_where_it_was_and_gives_the_same_bits(tmp_path: Path) -> None:
    whole = ab.study(SHORT, folder=tmp_path / "a", workers=1)
    chunks = sorted((tmp_path / "a" / "parts").glob("*.npz"))
    chunks[0].unlink()
    before = {path: path.stat().st_mtime_ns for path in chunks[1:]}
    again = ab.study(SHORT, folder=tmp_path / "a", workers=2)
    assert before == {path: path.stat().st_mtime_ns for path in chunks[1:]}
    assert np.array_equal(whole["peak_deflection"], again["peak_deflection"])
    more = ab.study({**SHORT, "members": 50}, folder=tmp_path / "a")
    assert np.array_equal(whole["peak_deflection"], more["peak_deflection"][:40])


def test_the_folder_of_another_study_is_left_alone(tmp_path: Path) -> None:
    ab.study({**SHORT, "members": 4}, folder=tmp_path / "a")
    with pytest.raises(QuestionError, match=r"holds another study; different: seed \(0 there, 1 now\)"):
        ab.study({**SHORT, "members": 4, "seed": 1}, folder=tmp_path / "a")
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "notes.txt").write_text("mine")
    with pytest.raises(QuestionError, match="has other files in it"):
        ab.study({**SHORT, "members": 4}, folder=tmp_path / "b")


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "localhost", "http://localhost:1", "a b"])
def test_no_scheduler_is_said(monkeypatch: pytest.MonkeyPatch, address: str) -> None:
    pytest.importorskip("distributed")
    monkeypatch.setattr(execute, "WAIT", 0.2)
    with pytest.raises(QuestionError, match=f"no Dask scheduler answers at {address!r}"):
        ab.study(SHORT, scheduler=address)


def test_a_folder_that_is_none_and_a_damaged_chunk_are_said(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(ResultError, match=r"notes.txt: is no folder"):
        ab.study({**SHORT, "members": 4}, folder=tmp_path / "notes.txt")
    ab.study({**SHORT, "members": 4}, folder=tmp_path / "a")
    (chunk,) = (tmp_path / "a" / "parts").glob("*.npz")
    chunk.write_bytes(chunk.read_bytes()[:1000])
    with pytest.raises(ResultError, match=r"is damaged: .*; delete it, and it is computed again"):
        ab.study({**SHORT, "members": 4}, folder=tmp_path / "a")
    np.savez(chunk, outcome=np.zeros(4))  # readable, but another's
    with pytest.raises(ResultError, match="was not written here"):
        ab.study({**SHORT, "members": 4}, folder=tmp_path / "a")


def chunks_in(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in (folder / "parts").glob("0*.npz")}


def run_apart(asked: dict[str, Any], folder: Path) -> None:
    """In a process of its own: chunks of a few milliseconds, so that many are finished and many are in flight."""
    execute.WORTH = 0.005
    ab.study(asked, folder=folder, workers=1, progress=False)


@pytest.mark.slow
@pytest.mark.skipif("fork" not in multiprocessing.get_all_start_methods(), reason="processes cannot be copied here")
def test_a_study_that_is_killed_thirty_times_loses_nothing_and_has_the_same_bits(tmp_path: Path) -> None:
    asked = {**SHORT, "members": 600, "duration": "1 s"}
    whole = ab.study(asked, workers=2)  # copies of this process need not load the package again
    random, folder = np.random.default_rng(0), tmp_path / "0"
    killed, grown, kept = 0, 0, dict[str, bytes]()
    while killed < 30:
        process = multiprocessing.get_context("fork").Process(target=run_apart, args=(asked, folder))
        process.start()
        while killed % 3 == 0 and process.is_alive() and len(chunks_in(folder)) <= len(kept):
            time.sleep(0.005)  # each third one is killed while it works, the others also while they begin
        process.join(0.03 * random.random())
        ended = not process.is_alive()
        process.kill()
        process.join()
        now = chunks_in(folder)
        assert all(now.get(name) == content for name, content in kept.items())
        grown += len(now) > len(kept)
        killed, kept = killed + (not ended), now
        if ended:  # on a quick computer before the last; then a new one begins
            same_bits(whole, ab.study(asked, folder=folder, workers=2))
            folder, kept = tmp_path / str(killed), {}
    assert grown >= 7
    same_bits(whole, ab.study(asked, folder=folder, workers=2))


def test_a_full_disk_is_said_and_what_was_finished_is_kept(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(execute, "MOST", 10)
    monkeypatch.setattr(execute, "FIRST", 10)
    write, written = np.savez, list[Any]()

    def full_after_two(file: Any, **arrays: Any) -> None:
        if len(written) == 2:
            file.write(b"half of it")
            raise OSError(errno.ENOSPC, "No space left on device")
        written.append(file)
        write(file, **arrays)

    monkeypatch.setattr(np, "savez", full_after_two)
    with pytest.raises(ResultError, match="disk is full"):
        ab.study(SHORT, folder=tmp_path / "a")
    kept = chunks_in(tmp_path / "a")
    assert len(kept) == 2
    assert not [path for path in (tmp_path / "a" / "parts").iterdir() if path.name not in kept]
    monkeypatch.setattr(np, "savez", write)
    found = ab.study(SHORT, folder=tmp_path / "a", workers=2)
    assert {name: content for name, content in chunks_in(tmp_path / "a").items() if name in kept} == kept
    same_bits(ab.study(SHORT, workers=1), found)


@pytest.mark.slow
def test_a_cluster_of_two_processes_gives_the_same_bits_even_if_both_are_killed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    distributed, dask = pytest.importorskip("distributed"), pytest.importorskip("dask")
    copied = dask.config.set({"distributed.worker.multiprocessing-method": "forkserver"})  # loads the packages once
    monkeypatch.setattr(execute, "WORTH", 0.05)
    asked, killed = {**SHORT, "members": 400, "duration": "1 s"}, list[int]()
    workers = {"n_workers": 2, "threads_per_worker": 1, "processes": True, "dashboard_address": None}
    with copied, distributed.LocalCluster(**workers) as cluster:

        def kill_both(done: int, _: int) -> None:
            if done and not killed:
                killed.extend(worker.pid for worker in cluster.workers.values())
                for number in killed:
                    os.kill(number, signal.SIGKILL)

        found = ab.study(asked, scheduler=cluster.scheduler_address, folder=tmp_path / "a", progress=kill_both)
    assert len(killed) == 2
    same_bits(ab.study(asked), found)
