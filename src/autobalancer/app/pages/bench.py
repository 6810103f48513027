"""What one open page works on: the text of a machine, its history, and who wants to know of changes."""

from __future__ import annotations

from pathlib import Path

from autobalancer.app.pages.typed import Typed
from autobalancer.app.store.jobs import Jobs
from autobalancer.app.text.document import EMPTY
from autobalancer.app.text.problems import Reading, read
from autobalancer.files.examples import example_text

FIRST = "stall_and_release"  # what a new user sees


class Bench(Typed):
    """The machine of a page; ``set_text`` is the only way in which it changes."""

    def __init__(self, user: str, home: Path, jobs: Jobs, long: Jobs | None = None) -> None:
        super().__init__(home / "draft.toml", example_text(FIRST))
        self.user, self.home, self.jobs = user, home, jobs
        self.long = long if long is not None else jobs  # of studies, one at a time, as each takes all cores
        self._reading: Reading = read(self._text)
        self.begun = self._text == EMPTY  # a machine from nothing: what is not filled in yet is no mistake

    @property
    def reading(self) -> Reading:
        """What the text says, with all that was typed."""
        self.take()
        return self._reading

    def _understand(self) -> None:
        self._reading = read(self._text)
        self.begun = self._reading.machine is None and (self.begun or self._text == EMPTY)

    def insist(self) -> None:
        """From now on, what is missing is wrong."""
        if self.begun:
            self.begun = False
            self.tell(None)
