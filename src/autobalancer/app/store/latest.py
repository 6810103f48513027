"""The latest answer of each analysis of a user, kept as a result file, so that it is there when the page is opened again."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from datetime import UTC, datetime
from functools import cached_property
from pathlib import Path
from typing import Any

from autobalancer.app.store.analyses import ANALYSES
from autobalancer.app.store.archive import FILES
from autobalancer.app.store.jobs import Job
from autobalancer.files.machine_file import parse_race_machine
from autobalancer.machine import Machine
from autobalancer.results.store import load_run, save_run
from autobalancer.safe_file import write_text_safely


@dataclass
class About:
    """Of which machine an answer is, and how it was asked."""

    name: str  # of the machine
    text: str  # of the machine
    given: dict[str, str]
    made: str
    seconds: float = 0.0
    notes: list[str] = field(default_factory=list)

    @cached_property
    def machine(self) -> Machine:
        """The machine itself."""
        return parse_race_machine(self.text)


class LatestAnswers:
    """Below the folder of a user, one answer for each analysis; a newer one takes its place."""

    def __init__(self, home: Path) -> None:
        self.folder = home / "stability"

    def ask(
        self, name: str, machine: Machine, text: str, asked: dict[str, Any], given: Mapping[str, str], job: Job
    ) -> str:
        """Work out an answer and keep it; what a cancelled job measured is kept, too. Gives the name of the analysis."""
        found = ANALYSES[name].ask(machine, asked, job.progress)
        about = About(machine.name, text, dict(given), f"{datetime.now(UTC):%Y-%m-%d %H:%M} UTC", notes=job.notes)
        self.folder.mkdir(parents=True, exist_ok=True)
        with FILES:
            save_run(found, self.path(name))
        write_text_safely(self.folder / f"{name}.json", json.dumps(asdict(about), indent=1))
        return name

    def about(self, name: str) -> About | None:
        """What is known of the latest answer; none if there is none."""
        try:
            found = About(**json.loads((self.folder / f"{name}.json").read_text(encoding="utf-8")))
            return found if self.path(name).is_file() else None
        except (OSError, ValueError, TypeError):
            return None

    def answer(self, name: str) -> Any:
        """The latest answer itself.

        Raises
        ------
        ResultError
            If it cannot be read.
        """
        with FILES:
            return load_run(self.path(name))

    def path(self, name: str) -> Path:
        """The result file of an answer."""
        return self.folder / f"{name}.nc"
