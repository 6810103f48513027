"""Finished speeds of a stepped response on disk, so that nothing is lost and a second call goes on.

Beside the result file grows a journal: a line that says what was asked, then one line for each speed, written and
flushed as soon as it is known. Numbers in it are exact. A line that was cut short by a crash is dropped.
"""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import xarray as xr

from autobalancer.errors import QuestionError, ResultError
from autobalancer.results.store import load_run, save_run
from autobalancer.safe_file import as_path
from autobalancer.studies.stepping import Row


class StepStore:
    """The store of one question.

    Attributes
    ----------
    rows
        What earlier calls found, by (leg, number of the speed).
    finished
        The result if an earlier call came to its end.
    """

    def __init__(self, path: str | Path, question: dict[str, Any]) -> None:
        self.path = as_path(path)
        if self.path.suffix != ".nc":
            raise QuestionError(f"store: given {str(path)!r}; give a result file that ends with .nc")
        self.journal = self.path.with_name(self.path.name + ".journal")
        self.question = question
        self.rows: dict[tuple[int, int], Row] = {}
        self.finished: xr.Dataset | None = None
        if self.path.exists():
            found = load_run(self.path)
            self._compare(self.path, found.attrs.get("question", "null"))
            self.finished = found
        elif self.journal.exists():
            self._read()

    def append(self, leg: int, number: int, row: Row) -> None:
        """Keep one speed."""
        lines = [json.dumps({"leg": leg, "number": number, **row})]
        if not self.journal.exists():
            lines.insert(0, json.dumps({"question": self.question}))
        try:
            self.journal.parent.mkdir(parents=True, exist_ok=True)
            with self.journal.open("a", encoding="utf-8") as file:
                file.write("\n".join(lines) + "\n")
                file.flush()
                os.fsync(file.fileno())
        except OSError as reason:
            raise ResultError(f"{self.journal}: cannot be written: {reason}") from None

    def finish(self, result: xr.Dataset) -> None:
        """Write the result; the journal is no longer needed."""
        save_run(result, self.path)
        self.journal.unlink(missing_ok=True)

    def _read(self) -> None:
        try:
            data = self.journal.read_bytes()
        except OSError as reason:
            raise ResultError(f"{self.journal}: cannot be read: {reason}") from None
        whole = data.rfind(b"\n") + 1
        lines = data[:whole].splitlines()
        if not lines:
            self.journal.unlink()
            return
        try:
            asked = json.loads(lines[0])["question"]
            rows = [json.loads(line) for line in lines[1:]]
            self.rows = {(row.pop("leg"), row.pop("number")): row for row in rows}
        except (ValueError, KeyError, TypeError, AttributeError):
            raise ResultError(
                f"{self.journal}: is damaged, or not a journal of a stepped response; delete it to start again"
            ) from None
        self._compare(self.journal, json.dumps(asked))
        if whole < len(data):
            with self.journal.open("r+b") as file:
                file.truncate(whole)

    def _compare(self, path: Path, stored: str) -> None:
        asked = json.loads(stored)
        if not isinstance(asked, dict):
            raise QuestionError(f"store: {path} is not a stepped response; give another file")
        # through the same text, so that numbers and lists compare alike
        now = json.loads(json.dumps(self.question))
        differ = [key for key in now if now[key] != asked.get(key)]
        if differ:
            told = ", ".join(
                key
                if isinstance(now[key], list) or key == "machine"
                else f"{key} ({asked.get(key)!r} there, {now[key]!r} now)"
                for key in differ
            )
            raise QuestionError(
                f"store: {path} holds the result of another study; different: {told}. Give another file, or delete this one"
            )
