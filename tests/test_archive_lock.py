"""Two processes and one folder: the second is told who writes it, and what a dead writer left behind is no lock."""

from __future__ import annotations

import errno
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
from autobalancer.results import folder_store
from autobalancer.results.archive import Archive
from autobalancer.results.folder_store import Store, locked
from autobalancer.studies.chamber_study import archived_run

HOLD = """
import sys
from pathlib import Path
from autobalancer.results.folder_store import locked
with locked(Path(sys.argv[1]), "run"):
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


def writer(folder: Path) -> str:
    return (folder / "lock").read_text().partition(",")[0]


def test_a_second_process_is_told_who_writes_the_run(folder: Path, other: subprocess.Popen[str]) -> None:
    told = rf"process {other.pid} on {socket.gethostname()}, since .* is writing this run; wait for it"
    with pytest.raises(ResultError, match=told):
        archived_run(Archive(folder.parent), "one", small_machine(), duration=0.02)
    assert not list(folder.glob("part-*"))
    assert other.stdin is not None
    other.stdin.close()
    other.wait(10.0)
    assert writer(folder) == ""
    assert archived_run(Archive(folder.parent), "one", small_machine(), duration=0.02).state == "finished"
    assert writer(folder) == ""


def test_the_lock_of_a_killed_process_is_none(folder: Path, other: subprocess.Popen[str]) -> None:
    other.send_signal(signal.SIGKILL)
    other.wait(10.0)
    assert writer(folder).startswith(f"process {other.pid} on")
    with locked(folder, "run"):
        assert writer(folder).startswith(f"process {os.getpid()} on")


def test_a_folder_is_written_once_in_one_process_too(folder: Path) -> None:
    told = f"process {os.getpid()} on .* is writing this run"
    with locked(folder, "run"), pytest.raises(ResultError, match=told), locked(folder, "run"):
        pass
    with locked(folder, "run"):
        pass
    with Store(folder / "study", {}, "study"), pytest.raises(ResultError, match="is writing this study"):
        Store(folder / "study", {}, "study")
    Store(folder / "study", {}, "study").close()


def test_without_locks_of_the_system_a_writer_is_believed_until_a_person_says_otherwise(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def unknown(file: int) -> None:
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(folder_store, "_system_lock", unknown)
    (folder / "lock").write_text("process 12 on far away, since 2026-01-01,")
    with (
        pytest.raises(ResultError, match=r"process 12 on far away.*If it is gone, delete .*lock"),
        locked(folder, "run"),
    ):
        pass
    (folder / "lock").unlink()
    with locked(folder, "run"):
        assert writer(folder).startswith(f"process {os.getpid()} on")
    with locked(folder, "run"):
        pass
