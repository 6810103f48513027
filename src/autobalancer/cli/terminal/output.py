"""What a command leaves: files by their suffix, JSON, CSV."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from autobalancer.errors import QuestionError

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from autobalancer.machine import Machine
    from autobalancer.tables import Column

RESULT = (".nc", ".csv", ".json")
SIGNALS = (*RESULT, ".uff")
PICTURE = (".png", ".svg", ".pdf")
MACHINE = (".toml",)


class Command:
    """The command that runs in this process: its words, and the files that are complete."""

    words: list[str] = []
    written: list[Path] = []


class Files:
    """The files that were asked for; what cannot be written under its name and place is refused before the work."""

    def __init__(
        self,
        out: Sequence[Path] | Path | None = None,
        plot: Path | None = None,
        allowed: Sequence[str] = RESULT,
    ) -> None:
        self.out = [out] if isinstance(out, Path) else list(out or ())
        self.plot = plot
        for path in self.out:
            check_suffix("--out", path, allowed)
        if plot is not None:
            check_suffix("--plot", plot, PICTURE)
        from autobalancer.safe_file import ready_to_write

        paths = self._paths()
        if len({path.resolve() for path in paths}) < len(paths):
            raise QuestionError(f"--out, --plot: given {', '.join(map(str, paths))}; must be different files")
        _spare_inputs(paths)
        ready_to_write(*paths)
        self.folders = [folder for folder in {path.parent: None for path in paths} if not folder.exists()]

    def save(self, found: xr.Dataset, draw: Callable[[], Figure] | None = None, machine: Machine | None = None) -> None:
        """Write the result, the machine that came with it, and the picture."""
        from autobalancer.files.machine_file import save_machine
        from autobalancer.results.store import save_run

        for path in self.out:
            if machine is not None and path.suffix.lower() in MACHINE:
                save_machine(machine, path)
            else:
                save_run(found, path, rescue=True)
            Command.written.append(path)
        if self.plot is not None and draw is not None:
            from autobalancer.plots.drawing.style import save_picture

            save_picture(draw(), self.plot)
            Command.written.append(self.plot)

    def say(self) -> None:
        """Name what was written, and the folders that were made for it."""
        for folder in self.folders:
            if folder.is_dir():
                typer.echo(f"new folder: {folder}")
        for path in self._paths():
            if path.exists():
                typer.echo(f"written: {path}")

    def _paths(self) -> list[Path]:
        return [*self.out, *([self.plot] if self.plot is not None else [])]


def _spare_inputs(paths: Sequence[Path]) -> None:
    """Refuse to write over a file that the command reads: its name stands twice among the words."""
    for path in paths:
        places = [Path(word.removeprefix("--out=")) for word in Command.words]
        if path.exists() and sum(place.resolve() == path.resolve() for place in places) > 1:
            raise QuestionError(f"{path}: is what the command reads; write to another file")


def check_suffix(option: str, path: Path, allowed: Sequence[str]) -> None:
    """Refuse a name that does not end with one of the suffixes.

    Raises
    ------
    QuestionError
        With the suffixes that are allowed.
    """
    if path.suffix.lower() not in allowed:
        *others, last = allowed
        names = f"{', '.join(others)} or {last}" if others else last
        raise QuestionError(f"{option} {path}: the name says how it is written; end it with {names}")


def file_to_read(path: Path) -> None:
    """Refuse a folder in place of a file, from whose name those of results are made.

    Raises
    ------
    QuestionError
        If it is one.
    """
    if path.is_dir():
        raise QuestionError(f"{path}: is a folder; give the path of a file")


def one_form(as_json: bool, as_csv: bool) -> None:
    """Refuse two forms of one answer.

    Raises
    ------
    QuestionError
        If both were asked for.
    """
    if as_json and as_csv:
        raise QuestionError("--json, --csv: an answer has one form; choose one of them")


def print_json(answer: Any) -> None:
    """Print an answer as JSON: nan is null, and infinity the text "Infinity", since JSON has neither."""
    from autobalancer.results.export import plain_json

    typer.echo(json.dumps(plain_json(answer), indent=2, allow_nan=False, ensure_ascii=False))


def print_csv(columns: Sequence[Column]) -> None:
    """Print a table as CSV."""
    from autobalancer.cli.terminal.sheet import sheet_csv

    typer.echo(sheet_csv(columns), nl=False)
