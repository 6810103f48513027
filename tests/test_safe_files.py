"""Files are complete or not there: full disks, read-only folders, devices."""

from __future__ import annotations

import errno
import resource
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from tests.references.chamber_runs import MACHINE, chamber_run
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.cli import app
from autobalancer.errors import ResultError
from autobalancer.files import machine_file as given
from autobalancer.plots.style import save_picture
from autobalancer.results.archive import Archive
from autobalancer.results.store import save_run
from autobalancer.safe_file import ready_to_write, write_safely, write_text_safely

MACHINES = Path(__file__).parents[1] / "examples" / "machines"


@contextmanager
def room_for(size: int) -> Iterator[None]:
    """No file of this process may become larger, as on a disk with so much room left."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def result(size: int) -> xr.Dataset:
    return xr.Dataset({"x": ("time", np.arange(float(size)))}, attrs={"source": "autobalancer test"})


def test_a_file_that_could_not_be_completed_leaves_the_old_one_and_nothing_else(tmp_path: Path) -> None:
    path = write_text_safely(tmp_path / "new" / "note.txt", "old")

    def half(file: Path) -> None:
        file.write_text("half")
        raise OSError(errno.ENOSPC, "No space left on device")

    with pytest.raises(ResultError, match=r"note.txt: the disk is full"):
        write_safely(path, half)
    assert [entry.name for entry in path.parent.iterdir()] == ["note.txt"]
    assert path.read_text() == "old"


def test_a_full_disk_while_a_result_is_saved_keeps_the_result_among_the_temporary_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    other = tmp_path / "other"
    other.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(other))

    def place(prefix: str) -> str:
        resource.setrlimit(resource.RLIMIT_FSIZE, (-1, -1))  # the second place has room
        return str(other)

    monkeypatch.setattr("tempfile.mkdtemp", place)
    with room_for(20_000), pytest.raises(ResultError, match=r"r\.nc: .*(\n.*)?is kept in .*other/r\.nc"):
        save_run(result(100_000), tmp_path / "r.nc", rescue=True)
    assert [entry.name for entry in tmp_path.iterdir()] == ["other"]
    xr.testing.assert_identical(ab.load_run(other / "r.nc"), result(100_000))
    with room_for(20_000), pytest.raises(ResultError, match=r"r\.nc: [^\n]*$"):
        save_run(result(100_000), tmp_path / "r.nc")
    assert save_run(result(100_000), tmp_path / "r.nc").stat().st_size > 500_000


def test_an_older_picture_and_an_older_machine_survive_a_full_disk(tmp_path: Path) -> None:
    machine = ab.load_machine(MACHINES / "discoidal.toml")
    picture, file = save_picture(Figure(), tmp_path / "a.png"), ab.save_machine(machine, tmp_path / "m.toml")
    before = picture.read_bytes(), file.read_bytes()
    with room_for(100):
        for write in (lambda: save_picture(Figure(), picture), lambda: ab.save_machine(machine, file)):
            with pytest.raises(ResultError, match="the disk is full"):
                write()
    assert (picture.read_bytes(), file.read_bytes()) == before
    assert len(list(tmp_path.iterdir())) == 2


def test_a_disk_that_was_full_when_a_run_began_does_not_spoil_its_archive(tmp_path: Path) -> None:
    for size in (150, 400):  # too little for the machine, then for the note
        with room_for(size), pytest.raises(ResultError, match="the disk is full"):
            Archive(tmp_path).start("one", MACHINE[:300], {"text": "x" * 500}, {})
        assert list(Archive(tmp_path).runs()["run"].values) == []
    run = Archive(tmp_path).start("one", MACHINE[:300], {"text": "x" * 500}, {})
    assert run.state == "running"
    assert list(Archive(tmp_path).runs()["run"].values) == ["one"]


@pytest.mark.parametrize("place", ["/dev/null", "/dev/full", "/etc"])
def test_devices_and_folders_are_refused_and_stay(place: str) -> None:
    kind = Path(place).stat().st_mode
    for write in (
        lambda: save_run(result(3), place),
        lambda: write_text_safely(place, "x"),
        lambda: ready_to_write(place),
    ):
        with pytest.raises(ResultError, match=r"is a (device|folder)"):
            write()
    assert Path(place).stat().st_mode == kind


def test_a_link_is_followed_and_stays_a_link(tmp_path: Path) -> None:
    (tmp_path / "link.txt").symlink_to(tmp_path / "file.txt")
    write_text_safely(tmp_path / "link.txt", "text")
    assert (tmp_path / "link.txt").is_symlink()
    assert (tmp_path / "file.txt").read_text() == "text"


@pytest.mark.parametrize("command", ["simulate", "map"])
def test_a_place_that_cannot_be_written_is_refused_before_the_work(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for place in (
        "autobalancer.files.machine_file",
        given.__name__,
    ):  # loaded by now, so that neither keeps the stand-in
        monkeypatch.setattr(f"{place}.load_machine", lambda path: pytest.fail("it began"))
    (tmp_path / "file").write_text("in the way")
    out = str(tmp_path / "file" / "r.nc")
    file = str(MACHINES / "discoidal.toml")
    more = ["--x", "speed=1:2 rpm:2", "--y", "drag=1:2 N*m*s:2"] if command == "map" else []
    answer = CliRunner().invoke(app, [command, file, *more, "--out", out])
    assert answer.exit_code == 2, answer.output
    assert "r.nc: cannot be written" in answer.stderr
    assert [entry.name for entry in tmp_path.iterdir()] == ["file"]


def test_pictures_of_runs_whose_names_hold_a_point_do_not_replace_each_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("n3-mu0.3-s0", "n3-mu0.5-s0"):
        run = Archive(tmp_path / "runs").start(name, MACHINE, {}, {})
        run.append(chamber_run())
        answer = CliRunner().invoke(app, ["plot", f"runs/{name}", "--out", "p", "--kind", "energy"])
        assert answer.exit_code == 0, answer.output
    assert sorted(entry.name for entry in Path("p").iterdir()) == ["n3-mu0.3-s0_energy.png", "n3-mu0.5-s0_energy.png"]


def test_a_small_result_that_claims_a_huge_array_is_refused_before_it_is_read(tmp_path: Path) -> None:
    with netCDF4.Dataset(tmp_path / "r.nc", "w") as file:
        file.source = "autobalancer 1"
        file.createDimension("n", 40_000_000_000)
        file.createVariable("deep", "f8", ("n",), chunksizes=(1000,))
    assert (tmp_path / "r.nc").stat().st_size < 100_000
    with pytest.raises(ResultError, match=r"r\.nc: not a readable result file: it claims 320 GB"):
        ab.load_run(tmp_path / "r.nc")


def test_a_result_whose_heap_of_texts_has_no_end_is_refused_before_its_library_follows_it_for_ever(
    tmp_path: Path,
) -> None:
    path = ab.save_run(ab.simulate(ab.example("stall_and_release"), duration=0.05), tmp_path / "run.nc")
    whole = path.read_bytes()
    assert ab.load_run(path).sizes["time"] > 1
    heap = whole.index(b"GCOL") + 16
    path.write_bytes(whole[:heap] + bytes(500) + whole[heap + 500 :])
    with pytest.raises(
        ResultError, match=rf"run.nc: not a readable .*a heap in it has no end, {heap} bytes from its begin"
    ):
        ab.load_run(path)


def test_a_result_whose_times_are_texts_is_damaged(tmp_path: Path) -> None:
    odd = xr.Dataset({"time": ("time", np.array(["a", "b"], dtype=object))}, attrs={"source": "autobalancer 1"})
    save_run(odd, tmp_path / "r.nc")
    with pytest.raises(ResultError, match="'time' does not hold numbers"):
        ab.load_run(tmp_path / "r.nc")


def test_an_option_that_cannot_be_met_is_no_success(tmp_path: Path) -> None:
    run = ab.simulate(MACHINES / "discoidal.toml", duration=0.1)
    save_run(run, tmp_path / "r.nc")
    for option in (["--deflection-unit", "parsec"], ["--frame", "x"], ["--start", "1e30 s"]):
        answer = CliRunner().invoke(app, ["plot", str(tmp_path / "r.nc"), "--out", str(tmp_path / "p"), *option])
        assert answer.exit_code == 2, answer.output


def test_a_folder_without_runs_is_no_archive(tmp_path: Path) -> None:
    answer = CliRunner().invoke(app, ["chamber", "archive", str(tmp_path)])
    assert answer.exit_code == 2
    assert "holds no runs" in answer.stderr


def test_a_result_that_cannot_be_drawn_is_said_to_be_damaged(tmp_path: Path) -> None:
    run = ab.simulate(MACHINES / "discoidal.toml", duration=0.1)
    run["ball_angle_in_rotor"][:] = np.nan
    save_run(run, tmp_path / "r.nc")
    answer = CliRunner().invoke(app, ["plot", str(tmp_path / "r.nc"), "--out", str(tmp_path / "p"), "--kind", "run-up"])
    assert answer.exit_code == 2, answer.output
    assert "cannot be drawn; is it damaged?" in answer.stderr
