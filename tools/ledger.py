"""Discover modules, run them, keep their rows: what ``make reproduce``, ``make bench`` and the docs share."""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatch
from importlib import import_module
from pathlib import Path
from typing import Any

from reproductions import KINDS

ROOT = Path(__file__).resolve().parent.parent
Row = dict[str, Any]


@dataclass(frozen=True)
class Ledger:
    """A list of rows in ``build/<name>.json``.

    Modules match ``pattern`` below the folder ``name``; one that has ``function`` contributes rows with
    ``columns`` (and perhaps ``extra``), distinguished by ``identity``. ``group`` is the column by which they are counted, in the
    order of ``groups``; ``section`` is the column by which pages divide the table.
    """

    name: str
    pattern: str
    function: str
    columns: tuple[str, ...]
    identity: tuple[str, ...]
    extra: tuple[str, ...] = ()
    group: str = ""
    groups: tuple[str, ...] = ()
    section: str = ""

    @property
    def shown(self) -> tuple[str, ...]:
        """Columns of the tables."""
        return self.columns + self.extra

    @property
    def file(self) -> Path:
        return ROOT / "build" / f"{self.name}.json"

    def rows(self) -> list[Row]:
        """The rows kept so far."""
        return list(json.loads(self.file.read_text(encoding="utf-8"))) if self.file.exists() else []

    def modules(self, only: str = "*") -> list[str]:
        """Names of modules below the folder, as ``spannan2021.run_up``; those that fit ``only``."""
        folder = ROOT / self.name
        paths = (path.relative_to(folder).with_suffix("") for path in folder.glob(self.pattern))
        names = sorted(".".join(path.parts) for path in paths if not path.name.startswith("_"))
        return [name for name in names if fnmatch(name, only) or only in name]

    def checked(self, rows: Iterable[Row]) -> list[Row]:
        """The rows as they are kept: complete, and with plain numbers."""
        kept = []
        for row in rows:
            missing, unknown = set(self.columns) - set(row), set(row) - set(self.columns) - set(self.extra)
            if missing or unknown:
                raise ValueError(f"row {row}: missing {sorted(missing)}, unknown {sorted(unknown)}")
            kept.append({key: _plain(row[key]) for key in self.shown if key in row})
        return kept

    def keep(self, rows: list[Row], *, replace: bool) -> None:
        """Write the rows; unless they ``replace`` all, rows of other identity stay."""
        if not replace:
            new = {self._identity(row) for row in rows}
            rows = [row for row in self.rows() if self._identity(row) not in new] + rows
        self.file.parent.mkdir(parents=True, exist_ok=True)
        text = json.dumps(rows, indent=1, ensure_ascii=False, allow_nan=False)
        self.file.write_text(text + "\n", encoding="utf-8")

    def _identity(self, row: Row) -> tuple[Any, ...]:
        return tuple(row.get(key) for key in self.identity)


REPRODUCTIONS = Ledger(
    name="reproductions",
    pattern="*/*.py",
    function="reproduce",
    columns=(
        "source",
        "figure",
        "kind",
        "quantity",
        "unit",
        "target",
        "obtained",
        "deviation",
        "tolerance",
        "verdict",
    ),
    identity=("source", "figure", "quantity"),
    extra=("note",),
    group="kind",
    groups=tuple(KINDS),
    section="source",
)
BENCHMARKS = Ledger(
    name="benchmarks",
    pattern="*.py",
    function="bench",
    columns=("name", "value", "unit", "peer", "ratio"),
    identity=("name", "peer"),
    extra=("note",),
)


def main(ledger: Ledger, call: Callable[[Any, str], Iterable[Row]], arguments: Sequence[str] | None = None) -> int:
    """Run the modules of ``ledger``, show and keep their rows; 1 if a module crashed, else 0.

    ``call(module, name)`` runs one of them. A missed target is a result, not a failure.
    """
    from rich.console import Console
    from rich.progress import Progress

    parser = argparse.ArgumentParser(prog=f"python -m {ledger.name}")
    parser.add_argument("--only", default="*", metavar="PATTERN", help="modules whose name contains or fits this")
    only = parser.parse_args(arguments).only
    names = ledger.modules(only)
    if only != "*" and not names:
        parser.error(f"no module fits {only!r}; there are {', '.join(ledger.modules()) or 'none'}")
    console = Console(width=None if Console().is_terminal else 160)
    rows: list[Row] = []
    crashed: list[str] = []
    with Progress(console=console, transient=True) as progress:
        task = progress.add_task("", total=len(names))
        for name in names:
            progress.update(task, description=name)
            try:
                module = import_module(f"{ledger.name}.{name}")
                if hasattr(module, ledger.function):
                    rows += ledger.checked(call(module, name))
            except Exception:
                console.print_exception()
                crashed.append(name)
            progress.advance(task)
    ledger.keep(rows, replace=only == "*")
    console.print(_rich_table(ledger.columns, rows))
    if counted := totals(ledger, rows):
        console.print(_rich_table(list(counted[0]), counted))
    console.print(f"{len(rows)} rows in {ledger.file.relative_to(ROOT)}")
    if crashed:
        console.print(f"[red]crashed: {', '.join(crashed)}")
    return 1 if crashed else 0


def markdown(columns: Sequence[str], rows: list[Row]) -> str:
    """The rows as a Markdown table."""
    lines = [columns, ["---"] * len(columns), *([spell(row.get(key)) for key in columns] for row in rows)]
    cells = [[cell.replace("|", r"\|") for cell in line] for line in lines]
    return "".join(f"| {' | '.join(line)} |\n" for line in cells)


def totals(ledger: Ledger, rows: list[Row]) -> list[Row]:
    """How many rows of each group hit and missed, and all of them; empty if the ledger has no groups."""
    if not ledger.group:
        return []
    there = {row[ledger.group] for row in rows}
    parts = {group: [row for row in rows if row[ledger.group] == group] for group in ledger.groups if group in there}
    parts["all"] = rows
    hits = {group: sum(row["verdict"] == "hit" for row in part) for group, part in parts.items()}
    return [
        {ledger.group: group, "rows": len(part), "hits": hits[group], "missed": len(part) - hits[group]}
        for group, part in parts.items()
    ]


def spell(value: Any) -> str:
    """A cell of a table: numbers with four digits."""
    if isinstance(value, float):
        return f"{value:.4g}"
    return "" if value is None else str(value)


def _rich_table(columns: Sequence[str], rows: list[Row]) -> Any:
    from rich.table import Table
    from rich.text import Text

    table = Table()
    for key in columns:
        numeric = any(isinstance(row.get(key), (int, float)) for row in rows)
        table.add_column(key, justify="right" if numeric else "left")
    colors = {"hit": "green", "missed": "red"}
    for row in rows:
        cells = [spell(row.get(key)) for key in columns]
        table.add_row(*(Text(cell, style=colors.get(cell, "")) for cell in cells))
    return table


def _plain(value: Any) -> Any:
    """Text, integers and finite floats for JSON; what is not finite becomes text."""
    if value is None or isinstance(value, (str, int)):
        return value
    number = float(value)
    return number if math.isfinite(number) else str(number)
