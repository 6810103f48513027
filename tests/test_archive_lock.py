"""Two processes and one run of an archive: the second is told who writes it, and what a dead writer left behind is no lock."""

from __future__ import annotations

import ctypes
import json
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from tests.references.chamber_machines import small_machine

from autobalancer.errors import ResultError
from autobalancer.results.archive import run as archive_lock
from autobalancer.results.archive.folder import Archive
from autobalancer.results.archive.run import RunLock
from autobalancer.studies.chamber_study import archived_run

HOLD = """
import sys
from pathlib import Path
from autobalancer.results.archive.run import RunLock
with RunLock(Path(sys.argv[1])):
    print("held", flush=True)
    sys.stdin.read()
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "one").mkdir()
    return tmp_path / "one"


@pytest.fixture
def other(folder: Path) -> Iterator[subprocess.Popen[str]]:
    held = subprocess.Popen(
        [sys.executable, "-c", HOLD, str(folder)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert held.stdout is not None
    assert held.stdout.readline() == "held\n"
    yield held
    held.kill()
    held.wait()
    for pipe in (held.stdin, held.stdout):
        if pipe is not None:
            pipe.close()


def note(folder: Path, process: int, host: str) -> None:
    (folder / "lock").write_text(json.dumps({"process": process, "host": host, "since": "2026-01-01"}))


def test_a_second_process_is_told_who_writes_the_run(folder: Path, other: subprocess.Popen[str]) -> None:
    told = rf"process {other.pid} on {socket.gethostname()}, since .* is writing this run; wait for it"
    with pytest.raises(ResultError, match=told):
        archived_run(Archive(folder.parent), "one", small_machine(), duration=0.02)
    assert not list(folder.glob("part-*"))
    assert other.stdin is not None
    other.stdin.close()
    other.wait(10.0)
    assert not (folder / "lock").exists()
    assert archived_run(Archive(folder.parent), "one", small_machine(), duration=0.02).state == "finished"
    assert not (folder / "lock").exists()


def test_the_lock_of_a_killed_process_is_none(folder: Path, other: subprocess.Popen[str]) -> None:
    other.send_signal(signal.SIGKILL)
    other.wait(10.0)
    assert json.loads((folder / "lock").read_text())["process"] == other.pid
    with RunLock(folder):
        assert json.loads((folder / "lock").read_text())["process"] == os.getpid()


def test_a_run_is_written_once_in_one_process_too(folder: Path) -> None:
    with RunLock(folder), pytest.raises(ResultError, match=f"process {os.getpid()} on"), RunLock(folder):
        pass
    with RunLock(folder):
        pass


def test_where_the_system_locks_files_the_note_of_a_dead_writer_on_another_host_counts_for_nothing(
    folder: Path,
) -> None:
    note(folder, 12, "far away")
    with RunLock(folder):
        assert json.loads((folder / "lock").read_text())["process"] == os.getpid()


def test_without_locks_a_writer_on_another_host_is_believed_until_a_person_says_otherwise(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(archive_lock, "fcntl", None)
    note(folder, 12, "far away")
    with pytest.raises(ResultError, match=r"process 12 on far away.*If it is gone, delete .*lock"), RunLock(folder):
        pass
    (folder / "lock").unlink()
    with RunLock(folder):
        pass
    assert not (folder / "lock").exists()


class Kernel:
    """The calls of Windows on a process: which handle opens, what waiting for it answers, what was closed."""

    def __init__(self, handle: int, waited: int) -> None:
        self.handle, self.waited, self.closed = handle, waited, 0

    def OpenProcess(self, rights: int, inherit: bool, number: int) -> int:
        return self.handle

    def WaitForSingleObject(self, handle: int, time: int) -> int:
        assert (handle, time) == (self.handle, 0)
        return self.waited

    def CloseHandle(self, handle: int) -> None:
        self.closed += handle


@pytest.mark.parametrize(
    ("handle", "waited", "error", "alive"), [(7, 0x102, 0, True), (7, 0, 0, False), (0, 0, 87, False), (0, 0, 5, True)]
)
def test_on_windows_no_signal_asks_whether_a_writer_lives(
    handle: int, waited: int, error: int, alive: bool, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kernel = Kernel(handle, waited)
    monkeypatch.setattr(archive_lock, "fcntl", None)
    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setattr(ctypes, "WinDLL", lambda name, use_last_error: kernel, raising=False)
    monkeypatch.setattr(ctypes, "get_last_error", lambda: error, raising=False)
    monkeypatch.setattr(os, "kill", lambda number, signal: pytest.fail("Ctrl-C to the writer"))
    note(folder, 12, socket.gethostname())
    if alive:
        with pytest.raises(ResultError, match="process 12 on"), RunLock(folder):
            pass
    else:
        with RunLock(folder):
            pass
    assert kernel.closed == handle


@pytest.mark.parametrize("writer", ["alive", "dead"])
def test_without_locks_of_the_system_the_number_of_the_process_counts(
    writer: str, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(archive_lock, "fcntl", None)
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    note(folder, os.getppid() if writer == "alive" else ended.pid, socket.gethostname())
    if writer == "dead":
        with RunLock(folder):
            assert json.loads((folder / "lock").read_text())["process"] == os.getpid()
        return
    with pytest.raises(ResultError, match=f"process {os.getppid()} on"), RunLock(folder):
        pass


def test_a_note_cut_off_in_the_middle_is_no_writer(folder: Path) -> None:
    (folder / "lock").write_text('{"proc')
    with RunLock(folder):
        assert json.loads((folder / "lock").read_text())["process"] == os.getpid()
