"""Tables of judged machines: what each statement gets on each machine, written from runs and read by pictures and rows."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from reproductions.pakula2021.lost.candidate import Candidate
from reproductions.pakula2021.lost.scores import Held, agreeing, interval, log_chance, number
from reproductions.pakula2021.lost.statements import Statement

DATA = Path(__file__).parents[1] / "data"
MACHINES, JUDGED, SENSITIVITY, SEARCHED = (
    DATA / f"lost_machine_{name}.csv" for name in ("candidates", "statements", "sensitivity", "searched")
)


class Entry(NamedTuple):
    """A statement on a machine: chance that a run says the same, and how it came about.

    ``low``, ``high`` and ``runs`` are those of the count of balls that agrees least.
    """

    machine: str
    statement: str
    chance: float
    low: float
    high: float
    runs: int
    shown: str  # fillings that agree of those run, for each count of balls, or the number


def judged(name: str, statements: Iterable[Statement], candidate: Candidate, held: Held) -> list[Entry]:
    """All statements that can be judged on a machine. The chance of several counts of balls is their geometric mean."""
    found = []
    for statement in statements:
        value = log_chance(statement, candidate, held)
        if math.isnan(value):
            continue
        if statement.value is None:
            cells = [(cell.balls, *agreeing(statement, cell, held)) for cell in statement.cells]
            cells = [cell for cell in cells if cell[2]]
            _, hits, runs = (max if statement.some else min)(cells, key=lambda cell: cell[1] / cell[2])
            text = " ".join(f"{balls}: {a}/{b}" for balls, a, b in cells)
            found.append(Entry(name, statement.key, math.exp(value), *interval(hits, runs), runs, text))
        else:
            own = number(statement, candidate, held)
            text = (
                f"{float(f'{own * UNITS[statement.unit]:.3g}'):g} {statement.unit}" if math.isfinite(own) else "never"
            )
            found.append(Entry(name, statement.key, math.exp(value), math.nan, math.nan, 0, text.removesuffix(" 1")))
    return found


UNITS: Mapping[str, float] = {"um": 1e6, "mm": 1e3, "%": 1.0, "s": 1.0, "N": 1.0, "1": 1.0}


def write(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """A table with the keys of its first row in its head."""
    with path.open("w", encoding="utf-8", newline="") as file:
        out = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        out.writeheader()
        out.writerows({name: f"{v:.6g}" if isinstance(v, float) else v for name, v in row.items()} for row in rows)


def read_rows(path: Path) -> list[dict[str, str]]:
    """The rows of a table, as text."""
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def entries(path: Path = JUDGED) -> list[Entry]:
    """Judged statements of a table."""
    kinds: tuple[Callable[[str], Any], ...] = (str, str, float, float, float, int, str)
    return [
        Entry(*(kind(row[name]) for kind, name in zip(kinds, Entry._fields, strict=True))) for row in read_rows(path)
    ]


def candidates() -> dict[str, Candidate]:
    """Machines of the table by their names."""
    return {
        row["machine"]: Candidate(
            **{name: float(value) for name, value in row.items() if name not in ("machine", "score")}
        )
        for row in read_rows(MACHINES)
    }


def sensitivity() -> tuple[dict[str, float], list[tuple[str, str, float]]]:
    """Chance of being carried of each cell of the fitted machine, and (change, cell, chance) of each change."""
    rows = [row for row in read_rows(SENSITIVITY) if int(row["runs"])]
    found = [(row["change"], row["what"], float(row["value"]) / int(row["runs"])) for row in rows]
    base = {what: chance for change, what, chance in found if change == "as it is"}
    return base, [one for one in found if one[0] != "as it is"]
