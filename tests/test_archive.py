"""An archive keeps long runs: in parts, through crashes and full disks, and finds them again."""

from __future__ import annotations

import errno
import itertools
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.references.chamber_runs import MACHINE, chamber_run

from autobalancer.errors import QuestionError, ResultError
from autobalancer.results.archive import Archive, RunFolder, write_part
from autobalancer.results.store import load_run

QUESTION = {"duration": 4.0, "step": 1e-6, "seed": 0}


def chunks(run: xr.Dataset, count: int = 5) -> list[xr.Dataset]:
    edges = np.linspace(0, run.sizes["time"], count + 1).astype(int)
    return [run.isel(time=slice(a, b)) for a, b in itertools.pairwise(edges)]


def filled(archive: Archive, name: str = "one", parameters: dict[str, Any] | None = None) -> RunFolder:
    run = archive.start(name, MACHINE, parameters or {"balls": 3, "friction": 0.5}, QUESTION)
    for number, chunk in enumerate(chunks(chamber_run())):
        run.append(chunk, {"state": np.array([1.0 + number])})
    return run


def test_a_run_written_in_parts_is_read_as_it_was(tmp_path: Path) -> None:
    filled(Archive(tmp_path))
    read = Archive(tmp_path).samples("one")
    xr.testing.assert_identical(read.drop_attrs(), chamber_run().drop_attrs())
    assert read.attrs["machine"] == MACHINE


def test_any_selection_of_a_stored_run_is_the_selection_of_the_run(tmp_path: Path) -> None:
    filled(Archive(tmp_path))
    read, whole = Archive(tmp_path).samples("one"), chamber_run()
    for choice in (
        {"time": -1},
        {"time": slice(700, 2900, 300)},
        {"time": slice(None, None, -500)},
        {"time": [3999, 5, 801, 800], "ball": 1, "axis": [2, 0]},
        {"ball": [2, 0], "axis": slice(1, 3)},
        {"time": 801, "ball": slice(0, 2), "axis": 0},
        {"time": slice(0, 0)},
    ):
        part = read["ball_position"].isel(choice)
        np.testing.assert_array_equal(part.values, whole["ball_position"].isel(choice).values, err_msg=str(choice))


def test_only_the_parts_that_are_asked_for_are_read(tmp_path: Path) -> None:
    run = filled(Archive(tmp_path))
    read = run.samples()
    for part in run.parts()[1:]:
        part.write_bytes(b"damaged")
    assert read["ball_position"].isel(time=slice(0, 500)).values.shape == (500, 3, 3)
    with pytest.raises(ResultError, match=r"part-00001.nc: not a readable part"):
        _ = read["ball_position"].isel(time=1000).values


def test_a_full_disk_is_told_and_what_was_written_stays_readable(tmp_path: Path) -> None:
    written = 0

    def full_after_two(chunk: xr.Dataset, path: Path) -> None:
        nonlocal written
        if written == 2:
            path.write_bytes(b"half a part")
            raise OSError(errno.ENOSPC, "No space left on device")
        written += 1
        write_part(chunk, path)

    run = Archive(tmp_path, write=full_after_two).start("one", MACHINE, {}, QUESTION)
    parts = chunks(chamber_run())
    run.append(parts[0], {"state": np.array([1.0])})
    run.append(parts[1], {"state": np.array([2.0])})
    with pytest.raises(ResultError, match=r"disk is full; the 2 parts written before are kept.*its last checkpoint"):
        run.append(parts[2], {"state": np.array([3.0])})
    again = Archive(tmp_path).run("one")
    assert not list(tmp_path.glob("*/unfinished*"))
    assert again.samples().sizes["time"] == parts[0].sizes["time"] + parts[1].sizes["time"]
    held = again.checkpoint()
    assert held is not None
    np.testing.assert_array_equal(held["state"], [2.0])
    for part in parts[2:]:
        again.append(part, {"state": np.array([3.0])})
    xr.testing.assert_identical(again.samples().drop_attrs(), chamber_run().drop_attrs())


def test_a_part_without_its_checkpoint_is_computed_again(tmp_path: Path) -> None:
    run = Archive(tmp_path).start("one", MACHINE, {}, QUESTION)
    parts = chunks(chamber_run())
    run.append(parts[0], {"state": np.array([1.0])})
    run.append(parts[1])  # killed before the checkpoint after it was written
    again = Archive(tmp_path).start("one", MACHINE, {}, QUESTION)
    held = again.checkpoint()
    assert held is not None
    assert list(held) == ["state"]
    again.append(parts[1], {"state": np.array([2.0])})
    assert len(run.parts()) == 2
    assert run.samples().sizes["time"] == parts[0].sizes["time"] + parts[1].sizes["time"]


def test_a_run_that_was_killed_before_its_first_checkpoint_begins_anew(tmp_path: Path) -> None:
    run = Archive(tmp_path).start("one", MACHINE, {}, QUESTION)
    run.append(chunks(chamber_run())[1])
    assert run.checkpoint() is None
    run.append(chunks(chamber_run())[0])
    assert run.samples()["time"][0] == chamber_run()["time"][0]
    with pytest.raises(ResultError, match="no samples yet"):
        Archive(tmp_path).start("two", MACHINE, {}, QUESTION).samples()


def test_a_part_that_is_missing_or_exchanged_is_noticed(tmp_path: Path) -> None:
    run = filled(Archive(tmp_path))
    run.end("finished")
    files = run.parts()
    for hole in (1, len(files) - 1):
        files[hole].rename(tmp_path / "away")
        with pytest.raises(ResultError, match=f"part-0000{hole}.nc is missing"):
            run.samples()
        (tmp_path / "away").rename(files[hole])
    run.samples()
    content = [file.read_bytes() for file in files]
    files[1].write_bytes(content[2])
    files[2].write_bytes(content[1])
    with pytest.raises(ResultError, match=r"part-00002.nc: its times do not follow"):
        run.samples()
    pieces = chunks(chamber_run())
    for number, other, words in (
        (
            1,
            chunks(chamber_run(angles=(1.0, 2.0), axial=(0.0, 0.0)))[1],
            "'ball.*' is of another size than in the first part",
        ),
        (1, pieces[1].drop_vars("body_position"), "has no 'body_position'"),
        (1, pieces[1].assign_attrs(machine="x"), "its machine is not that of the first part"),
        (0, pieces[0].assign_attrs(machine="x"), "part-00001.nc.*its machine is not that of the first part"),
    ):
        for file, kept in zip(files, content, strict=True):
            file.write_bytes(kept)
        write_part(other, files[number])
        with pytest.raises(ResultError, match=words):
            run.samples()
    alone = filled(Archive(tmp_path), "alone")
    for file in alone.parts()[1:]:
        file.unlink()
    for other in (pieces[0].drop_vars("body_position"), pieces[0].assign_attrs(machine="x")):
        write_part(other, alone.parts()[0])
        with pytest.raises(ResultError, match=r"part-00000.nc: is not of this run"):
            alone.samples()


@pytest.mark.parametrize("damage", ["other keys", "cut", "empty", "two numbers", "text", "too many"])
def test_a_damaged_checkpoint_is_refused_and_no_part_is_lost(damage: str, tmp_path: Path) -> None:
    run = filled(Archive(tmp_path))
    file = run.path / "checkpoint.npz"
    content = {"other keys": {"a": 1}, "two numbers": {"archive_parts": [1, 2]}, "text": {"archive_parts": "x"}}
    if damage in ("cut", "empty"):
        file.write_bytes(file.read_bytes()[:50] if damage == "cut" else b"")
    else:
        np.savez(file, **{key: np.array(value) for key, value in content.get(damage, {"archive_parts": 9}).items()})
    again = Archive(tmp_path).run("one")
    with pytest.raises(ResultError, match=r"checkpoint.npz: cannot be read|part-00005.nc is missing"):
        again.checkpoint()
    again.samples()
    assert len(run.parts()) == 5


@pytest.mark.parametrize(
    "note",
    [
        *("", "{", "[]", "1", "null", "[" * 5000, '{"measures": null}', '{"parameters": [1]}', '{"outcome": []}'),
        *(
            '{"state": 3}',
            '{"archive_parts": "x"}',
            '{"question": 1}',
            "\xff",
            '{"measures": {"a": "x"}}',
            '{"measures": {"a": [1]}}',
            '{"outcome": {"outcome": [1]}}',
            r'{"parameters": {"a": "\ud800"}}',
            '{"measures": {"a": 1' + "0" * 5000 + "}}",
        ),
    ],
)
def test_a_damaged_note_is_a_row_that_says_so_and_stops_no_other(note: str, tmp_path: Path) -> None:
    archive = Archive(tmp_path)
    filled(archive, "good").end("finished", {}, {"peak": 1.0})
    bad = filled(archive, "bad")
    (bad.path / "note.json").write_bytes(note.encode("latin-1"))
    table = archive.runs()
    assert list(table["run"].values) == ["bad", "good"]
    assert str(table["state"].values[0]).startswith("cannot be read: ")
    assert str(table["state"].values[1]) == "finished"
    assert list(archive.runs("peak > 0")["run"].values) == ["good"]
    with pytest.raises(ResultError, match="cannot be read"):
        archive.samples("bad")


def test_numbers_and_machines_that_cannot_be_read_are_told(tmp_path: Path) -> None:
    archive = Archive(tmp_path)
    run = filled(archive, parameters={"huge": 10**400})
    assert np.isnan(archive.runs()["huge"].values[0])
    (run.path / "machine.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(ResultError, match=r"machine.toml: cannot be read"):
        run.samples()
    (run.path / "machine.toml").unlink()
    with pytest.raises(ResultError, match=r"machine.toml: cannot be read"):
        run.samples()


def test_a_name_is_not_given_to_two_questions(tmp_path: Path) -> None:
    archive = Archive(tmp_path)
    filled(archive)
    with pytest.raises(QuestionError, match=r"different: duration \(4.0 there, 5.0 now\)"):
        archive.start("one", MACHINE, {}, QUESTION | {"duration": 5.0})
    with pytest.raises(QuestionError, match="different: machine"):
        archive.start("one", MACHINE + "\n", {}, QUESTION)
    with pytest.raises(QuestionError, match=r"name: given '../one'"):
        archive.start("../one", MACHINE, {}, QUESTION)
    with pytest.raises(QuestionError, match=r"given 'two'; .* has one"):
        archive.run("two")


@pytest.fixture
def stocked(tmp_path: Path) -> Archive:
    archive = Archive(tmp_path / "runs")
    for balls in (3, 8, 20):
        for friction in (0.3, 0.5):
            name = f"b{balls}-f{friction:g}"
            run = archive.start(name, MACHINE, {"balls": balls, "friction": friction, "chamber": "deep"}, QUESTION)
            if friction > 0.4:
                run.end("finished", {"outcome": "finished"}, {"amplitude": 1e-6 * balls, "settling_time": np.nan})
    return archive


def test_the_catalogue_finds_runs_by_parameters_and_measures(stocked: Archive) -> None:
    everything = stocked.runs()
    assert everything.sizes["run"] == 6
    assert np.isnan(everything["amplitude"].sel(run="b3-f0.3"))
    for where, expected in (
        ("friction >= 0.5 and balls > 3", ["b20-f0.5", "b8-f0.5"]),
        ("amplitude < 5e-6", ["b3-f0.5"]),
        ("not state == 'finished' and balls in [3, 20]", ["b20-f0.3", "b3-f0.3"]),
        ("3 < balls <= 8 or friction * 10 == 3", ["b20-f0.3", "b3-f0.3", "b8-f0.3", "b8-f0.5"]),
        ("chamber == 'deep' and balls == -(-8)", ["b8-f0.3", "b8-f0.5"]),
        ("balls == 99", []),
    ):
        assert list(stocked.runs(where)["run"].values) == expected, where
    assert list(stocked.runs({"balls": 8, "friction": np.float64(0.5)})["run"].values) == ["b8-f0.5"]


@pytest.mark.parametrize(
    "where", ["balls =", "__import__('os')", "balls.real", "lambda: 1", "balls ** 2", "f'{balls}'"]
)
def test_what_is_no_condition_is_refused(stocked: Archive, where: str) -> None:
    with pytest.raises(QuestionError, match="where: given"):
        stocked.runs(where)


def test_an_unknown_value_and_unlike_kinds_are_named(stocked: Archive) -> None:
    with pytest.raises(QuestionError, match=r"given 'speed'; the runs have amplitude, balls, .*friction"):
        stocked.runs("speed > 1")
    with pytest.raises(QuestionError, match="speed"):
        stocked.runs({"speed": 1})
    with pytest.raises(QuestionError, match="cannot be compared"):
        stocked.runs("chamber > 3")


def test_an_exported_run_is_a_result_file(tmp_path: Path) -> None:
    archive = Archive(tmp_path / "runs")
    filled(archive)
    found = load_run(archive.export("one", tmp_path / "one.nc"))
    xr.testing.assert_identical(found.drop_attrs(), chamber_run().drop_attrs())


def test_a_damaged_note_and_a_file_in_place_of_an_archive_are_told(tmp_path: Path) -> None:
    run = filled(Archive(tmp_path / "runs"))
    (run.path / "note.json").write_text("{")
    with pytest.raises(ResultError, match=r"note.json: cannot be read"):
        Archive(tmp_path / "runs").run("one")
    (tmp_path / "file").write_text("")
    with pytest.raises(ResultError, match="is a file; an archive is a folder"):
        Archive(tmp_path / "file")


def test_numbers_that_json_cannot_say_do_not_break_the_note(tmp_path: Path) -> None:
    run = filled(Archive(tmp_path))
    run.end("finished", {"outcome": "finished", "steps": np.int64(5)}, {"a": np.nan, "b": xr.DataArray(2.0)})
    note = json.loads((run.path / "note.json").read_text())
    assert note["measures"] == {"a": None, "b": 2.0}
    assert note["outcome"] == {"outcome": "finished", "steps": 5}
    assert run.samples().attrs["outcome"] == "finished"
    assert not (run.path / "checkpoint.npz").exists()


@pytest.mark.parametrize(
    "where",
    [
        *("friction + 'a' > 1", "-state == 1", "'a' * 1000000000000 == 1", "'a' * 3 == 'aaa'"),
        *("not " * 5000 + "balls", "-" * 100_000 + "balls", "-" * 450 + "balls > 1", "(" * 400 + "balls"),
    ],
)
def test_a_condition_that_is_none_is_refused_in_words(where: str, tmp_path: Path) -> None:
    filled(Archive(tmp_path))
    with pytest.raises(QuestionError, match=r"where: given .*; write conditions such as") as reason:
        Archive(tmp_path).runs(where if "balls >" not in where else where * 2)
    assert len(str(reason.value)) < 400


def test_a_number_divided_by_zero_is_infinite(tmp_path: Path) -> None:
    filled(Archive(tmp_path))
    assert Archive(tmp_path).runs("balls / (balls - 3) > 1e300").sizes["run"] == 1


def test_neither_a_comparison_with_a_missing_value_holds_nor_its_contrary(stocked: Archive) -> None:
    for where in ("amplitude < 1", "not amplitude > 1", "amplitude != 0"):
        assert list(stocked.runs(where)["run"].values) == ["b20-f0.5", "b3-f0.5", "b8-f0.5"], where
    assert list(stocked.runs("settling_time != 1")["run"].values) == []
    with pytest.raises(QuestionError, match="where: given 'balls'"):
        stocked.runs("balls")
