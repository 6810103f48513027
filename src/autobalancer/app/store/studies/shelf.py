"""The studies and designs of a user, each in a folder of its own: what was asked, its machine, finished parts, result.

Whatever happens to the server, the finished parts are there, and the same study goes on with the same bits.
"""

from __future__ import annotations

import json
import re
import shutil
from dataclasses import asdict, dataclass, field
from datetime import UTC, datetime
from pathlib import Path

from autobalancer.app.store.names import RUN, new_name
from autobalancer.errors import QuestionError
from autobalancer.files.samples import example_path, sample_names
from autobalancer.safe_file import write_safely, write_text_safely

STUDY, DESIGN = "study", "design"
MOST, ROOM = 200, 4_000_000_000  # of one user, and their bytes
RESULT, PARTS = "result.nc", "parts"
MADE = re.compile(r"result\.nc|report_\d{1,4}\.(?:html|pdf)")  # files beside the texts


@dataclass
class Kept:
    """What a list shows of a study or a design."""

    name: str
    kind: str  # study or design
    title: str
    machine: str
    machine_file: str
    made: str
    total: int = 0  # members of a study, runs of a design; at most, and 0 while it is not known
    seconds: float = 0.0  # that it worked, in all
    finished: bool = False
    message: str = ""  # why it stopped
    notes: list[str] = field(default_factory=list)
    more: list[str] = field(default_factory=list)  # other files that it names

    @property
    def file(self) -> str:
        """The name of its text."""
        return f"{self.kind}.toml"

    @property
    def command(self) -> str:
        """The command that does the same."""
        return f"autobalancer {self.kind} {self.file}"


class Studies:
    """All studies and designs below the folder of a user; what is on the disk is all there is."""

    def __init__(self, home: Path) -> None:
        self.home = home / "studies"

    def folder(self, name: str) -> Path:
        """The folder of one of them.

        Raises
        ------
        QuestionError
            If there is none of this name.
        """
        place = self.home / name
        if not RUN.fullmatch(name) or place.is_symlink() or not place.is_dir():
            raise QuestionError(f"study {name[:40]!r}: there is none of this name; it may have been deleted")
        return place

    def entry(self, name: str) -> Kept:
        """What is known of one."""
        try:
            return Kept(**json.loads((self.folder(name) / "about.json").read_text(encoding="utf-8")))
        except (OSError, ValueError, TypeError) as reason:
            raise QuestionError(f"study {name}: cannot be read: {reason}") from None

    def entries(self) -> list[Kept]:
        """All of them, the latest first; a damaged folder is left out."""
        found = []
        for folder in sorted(self.home.glob("*"), reverse=True):
            try:
                found.append(self.entry(folder.name))
            except QuestionError:
                continue
        return found

    def add(self, entry: Kept, text: str, machine: str, more: dict[str, bytes] | None = None) -> str:
        """Keep what is asked, with the text of its machine and other files that it names; gives its name.

        Raises
        ------
        QuestionError
            If there are too many, or they take too much room.
        """
        there = [path.stat().st_size for path in self.home.rglob("*") if path.is_file()]
        if len(list(self.home.glob("*"))) >= MOST or sum(there) > ROOM:
            raise QuestionError("too many studies are kept already; delete some of them first")
        entry.name, entry.made = new_name(), f"{datetime.now(UTC):%Y-%m-%d %H:%M:%S}"
        folder = self.home / entry.name
        folder.mkdir(parents=True)
        write_text_safely(folder / entry.file, text)
        if machine:
            write_text_safely(folder / entry.machine_file, machine)
        for file, content in (more or {}).items():
            write_safely(folder / file, lambda path, content=content: path.write_bytes(content))  # type: ignore[misc]
        entry.more = list(more or {})
        self.note(entry)
        return entry.name

    def note(self, entry: Kept) -> None:
        """Keep what is known of one."""
        write_text_safely(self.folder(entry.name) / "about.json", json.dumps(asdict(entry), indent=1))

    def text(self, name: str) -> str:
        """The study or the specification as it was asked."""
        return (self.folder(name) / self.entry(name).file).read_text(encoding="utf-8")

    def file(self, name: str, kind: str) -> Path:
        """A file of a study or design: its text, its machine, its result, a report.

        Raises
        ------
        QuestionError
            If there is no such file.
        """
        entry = self.entry(name)
        known = kind in (entry.file, "machine.toml", *entry.more) or MADE.fullmatch(kind)
        path = self.folder(name) / (entry.machine_file if kind == "machine.toml" else kind)
        if not known or not path.is_file():
            raise QuestionError(f"study {name}: has no {kind[:20]!r}")
        return path

    def delete(self, name: str) -> None:
        """Remove one for good, with all its parts."""
        shutil.rmtree(self.folder(name))


def sample_text(name: str) -> str:
    """The text of a study or design that comes with the package.

    Raises
    ------
    QuestionError
        If there is none of this name.
    """
    if name not in (*sample_names("studies"), *sample_names("designs")):
        raise QuestionError(f"{name[:40]!r}: no such sample")
    return example_path(name).read_text(encoding="utf-8")
