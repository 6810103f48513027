"""Runs of a deep chamber that are stopped, crash or fill the disk go on to the same end."""

from __future__ import annotations

import errno
import signal
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.references.chamber_machines import small_machine

import autobalancer as ab
from autobalancer.errors import QuestionError, ResultError
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.results.archive import Archive, write_part
from autobalancer.results.chamber_measures import READ
from autobalancer.simulation.chamber import chamber_run, simulate_chamber
from autobalancer.studies.chamber_study import archived_run
from autobalancer.studies.variations import in_threads

MACHINE = small_machine()
ASKED: dict[str, Any] = {"duration": 0.3, "part": 50}


@pytest.fixture(scope="module")
def whole() -> xr.Dataset:
    return simulate_chamber(MACHINE, duration=0.3)


def same(one: xr.Dataset, two: xr.Dataset) -> None:
    xr.testing.assert_identical(one.drop_attrs(), two.drop_attrs())


def test_an_archived_run_is_the_run(whole: xr.Dataset, tmp_path: Path) -> None:
    run = archived_run(Archive(tmp_path), "one", MACHINE, **ASKED)
    same(run.samples(), whole)
    assert len(run.parts()) == 6
    assert run.state == "finished"
    row = Archive(tmp_path).runs("balls == 3 and friction == 0.5")
    assert row["run"].values.tolist() == ["one"]
    assert float(row["vertical_amplitude"][0]) > 0.0
    assert np.isnan(row["residual_unbalance"][0]), "its balls still lie at the bottom"
    again = archived_run(Archive(tmp_path), "one", MACHINE, **ASKED, progress=lambda now, end: pytest.fail("ran again"))
    same(again.samples(), whole)


def test_an_interrupted_run_goes_on_to_the_same_bits(whole: xr.Dataset, tmp_path: Path) -> None:
    def stop(now: float, end: float) -> None:
        if now > 0.12:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        archived_run(Archive(tmp_path), "one", MACHINE, **ASKED, progress=stop)
    stopped = Archive(tmp_path).run("one")
    assert stopped.state == "interrupted"
    kept = stopped.samples().sizes["time"]
    assert 100 < kept < 301
    same(stopped.samples(), whole.isel(time=slice(0, kept)))
    begun: list[float] = []
    ended = archived_run(Archive(tmp_path), "one", MACHINE, **ASKED, progress=lambda now, end: begun.append(now))
    assert begun[0] > 0.12
    same(ended.samples(), whole)


def test_ctrl_c_keeps_all_samples_up_to_it_not_only_whole_parts(
    whole: xr.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop(now: float, end: float) -> None:
        if now > 0.1165:
            raise KeyboardInterrupt

    monkeypatch.setattr(chamber_run, "AT_ONCE", 0.0)  # looked for after every sample
    with pytest.raises(KeyboardInterrupt):
        archived_run(Archive(tmp_path), "one", MACHINE, **ASKED, progress=stop)
    stopped = Archive(tmp_path).run("one")
    assert float(stopped.samples()["time"][-1]) == pytest.approx(0.117)
    same(archived_run(Archive(tmp_path), "one", MACHINE, **ASKED).samples(), whole)
    short = simulate_chamber(MACHINE, duration=0.3, progress=stop, keep_on_interrupt=True)
    assert "interrupted at 0.117 s" in short.attrs["outcome_text"]
    same(short, whole.isel(time=slice(0, 118)))


@pytest.fixture
def _hears_ctrl_c() -> Iterator[None]:
    """A process that a shell began in the background ignores Ctrl-C."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("_hears_ctrl_c")
@pytest.mark.skipif(not hasattr(signal, "pthread_kill"), reason="signals of Posix")
def test_ctrl_c_stops_the_runs_of_all_threads_and_the_study_goes_on_to_the_same_bits(tmp_path: Path) -> None:
    question: dict[str, Any] = {"counts": [1, 2], "frictions": [0.5], "duration": 6.0, "layers": ["deep"]}

    pressed = threading.Event()

    def press(chunk: xr.Dataset, path: Path) -> None:
        write_part(chunk, path)
        if pressed.is_set():
            time.sleep(0.1)  # a slow disk, so that the signal comes before the end
        else:  # after one of six parts
            pressed.set()
            signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        ab.chamber.amplitudes(MACHINE, **question, archive=Archive(tmp_path, write=press), workers=2)
    states = [Archive(tmp_path).run(name).state for name in Archive(tmp_path).names()]
    assert len(states) == 2
    assert "interrupted" in states
    assert "running" not in states  # nothing is left to run in a thread
    kept = ab.chamber.amplitudes(MACHINE, **question, archive=tmp_path, workers=2)
    plain = ab.chamber.amplitudes(MACHINE, **question, workers=1)
    xr.testing.assert_identical(kept.drop_attrs(), plain.drop_attrs())


def test_the_longest_jobs_begin_first_and_answers_keep_their_order() -> None:
    begun: list[int] = []

    def work(job: int) -> int:
        begun.append(job)
        return 10 * job

    assert in_threads(work, [2, 5, 1, 5], 1, cost=float) == [20, 50, 10, 50]
    assert begun == [5, 5, 2, 1]
    assert in_threads(work, [2, 5, 1, 5], 2, cost=float) == [20, 50, 10, 50]


def test_measures_of_an_archived_run_open_each_part_once(tmp_path: Path) -> None:
    run = archived_run(Archive(tmp_path), "one", MACHINE, **ASKED)
    read, wanted = run.samples(READ), ab.run_measures(run.samples())
    for part in run.parts():
        part.unlink()
    xr.testing.assert_identical(ab.run_measures(read), wanted)


def test_a_run_that_filled_the_disk_goes_on_when_there_is_room(whole: xr.Dataset, tmp_path: Path) -> None:
    def full(chunk: xr.Dataset, path: Path) -> None:
        if float(chunk["time"][-1]) > 0.22:
            raise OSError(errno.ENOSPC, "No space left on device")
        write_part(chunk, path)

    with pytest.raises(ResultError, match="the disk is full; the 4 parts written before are kept"):
        archived_run(Archive(tmp_path, write=full), "one", MACHINE, **ASKED)
    stopped = Archive(tmp_path).run("one")
    assert stopped.state == "failed"
    assert float(stopped.samples()["time"][-1]) == pytest.approx(0.2)
    same(archived_run(Archive(tmp_path), "one", MACHINE, **ASKED).samples(), whole)


def test_another_question_under_the_same_name_is_refused(tmp_path: Path) -> None:
    archived_run(Archive(tmp_path), "one", MACHINE, duration=0.05)
    with pytest.raises(QuestionError, match=r"seed \(0 there, 3 now\)"):
        archived_run(Archive(tmp_path), "one", MACHINE, duration=0.05, seed=3)


def test_a_finished_run_is_measured_again_over_another_time_but_not_run_again(tmp_path: Path) -> None:
    archived_run(Archive(tmp_path), "one", MACHINE, duration=0.05, last=0.01)
    run = archived_run(
        Archive(tmp_path), "one", MACHINE, duration=0.05, last=0.03, progress=lambda now, end: pytest.fail("ran again")
    )
    wanted = ab.run_measures(run.samples(), last=0.03)
    short = ab.run_measures(run.samples(), last=0.01)
    kept = Archive(tmp_path).run("one").note.measures["vertical_amplitude"]
    assert kept == pytest.approx(float(wanted["vertical_amplitude"]), rel=1e-12)
    assert kept != pytest.approx(float(short["vertical_amplitude"]), rel=1e-3)


def test_variants_keep_the_mass_of_the_balls_and_change_their_size() -> None:
    total = sum(group.count * group.ball_mass for group in MACHINE.chambers[0].balls)
    for layers in ("deep", "single"):
        varied = ab.chamber.variant(MACHINE, balls=8, friction=0.7, layers=layers)
        (group,) = varied.chambers[0].balls
        assert group.count == 8
        assert group.count * group.ball_mass == pytest.approx(total)
        assert float(varied.contact.friction) == 0.7
        depth = varied.chambers[0].inner_depth
        assert depth == pytest.approx(0.2 if layers == "deep" else 2.02 * group.radius)
    with pytest.raises(QuestionError, match="layers: given 'double'"):
        ab.chamber.variant(MACHINE, balls=8, layers="double")
    with pytest.raises(QuestionError, match="is one of a single layer"):
        ab.chamber.variant(ab.chamber.variant(MACHINE, balls=8, layers="single"), balls=3)


def test_a_study_that_was_stopped_goes_on_and_does_not_depend_on_threads(tmp_path: Path) -> None:
    question: dict[str, Any] = {"counts": [2, 3], "frictions": [0.3, 0.7], "duration": 0.1, "layers": ["deep"]}
    plain = ab.chamber.amplitudes(MACHINE, **question, workers=1)
    assert set(plain["outcome"].values.ravel()) == {"finished"}

    def stop(done: int, total: int) -> None:
        if done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        ab.chamber.amplitudes(MACHINE, **question, archive=tmp_path, workers=1, progress=stop)
    assert Archive(tmp_path).runs("state == 'finished'").sizes["run"] == 2
    kept = ab.chamber.amplitudes(MACHINE, **question, archive=tmp_path, workers=2)
    xr.testing.assert_identical(kept.drop_attrs(), plain.drop_attrs())
    assert Archive(tmp_path).runs("friction == 0.7 and layers == 'deep'").sizes["run"] == 2


def test_balls_that_do_not_fit_are_a_gap_in_the_study() -> None:
    heavy = small_machine(
        chambers=[{"radius": 0.1, "depth": 0.2, "balls": [{"count": 1, "density": 7800.0, "mass": 20.0}]}]
    )
    found = ab.chamber.amplitudes(heavy, [1, 3], [0.5], duration=0.02, layers=["single"], workers=1)
    assert "does not fit" in str(found["outcome"].values[0, 0, 1, 0])
    assert np.isnan(found["vertical_amplitude"].values[0, 0, 1, 0])
    assert np.isfinite(found["vertical_amplitude"].values[0, 0, 0, 0])
    with pytest.raises(QuestionError, match="frictions: given none"):
        ab.chamber.amplitudes(MACHINE, [2], [], duration=0.02)


def test_the_machine_of_a_run_says_its_chambers_and_unbalance(whole: xr.Dataset) -> None:
    from autobalancer.results.chamber_measures import chambers_of, unbalance_of

    (shape,) = chambers_of(whole)
    assert (shape.radius, shape.depth, shape.place) == (0.1, 0.2, 0.0)
    assert unbalance_of(whole) == (pytest.approx(0.06), 0.0)
    assert isinstance(MACHINE, ChamberMachine)
