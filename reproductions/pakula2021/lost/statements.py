"""The table of statements: read, and refused if two of them cannot be true together without saying so."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass, fields
from itertools import combinations
from pathlib import Path

from autobalancer.errors import QuestionError
from reproductions.pakula2021.lost.runs import Cell

TABLE = Path(__file__).with_name("statements.toml")
COUNTS = range(1, 51)
SEARCHED = ("least", "carried", "stuck", "none", "some", "value")


@dataclass(frozen=True)
class Statement:
    """A row of the table."""

    key: str
    says: str
    where: str
    layers: str = ""
    friction: float = 0.0
    least: int | None = None
    carried: tuple[int, ...] = ()
    stuck: tuple[int, ...] = ()
    none: bool = False
    some: bool = False
    judged: tuple[int, ...] = ()
    measure: str = ""
    unit: str = ""
    value: float | None = None
    factor: float | None = None
    within: float | None = None
    most: bool = False
    least_value: bool = False
    disputed: tuple[str, ...] = ()
    weight: float = 1.0

    @property
    def cells(self) -> list[Cell]:
        """Runs that it needs."""
        counts = self.judged or self.carried + self.stuck
        return [Cell(self.layers, self.friction, n) for n in counts] if self.layers else []

    def demands(self, balls: int) -> bool | None:
        """Whether ``balls`` go around: true, false, or nothing said."""
        if self.least is not None:
            return balls >= self.least
        if self.none or balls in self.stuck:
            return False
        return True if balls in self.carried else None

    @property
    def bounds(self) -> tuple[float, float]:
        """Least and greatest value that it allows."""
        value = self.value or 0.0
        low, high = (value - self.within, value + self.within) if self.within else _by_factor(value, self.factor)
        return (0.0 if self.most else low), (float("inf") if self.least_value else high)


def _by_factor(value: float, factor: float | None) -> tuple[float, float]:
    size = factor or 1.0
    return value / size, value * size


def read(path: Path = TABLE) -> list[Statement]:
    """The statements of a table.

    Raises
    ------
    QuestionError
        For a key that is unknown or there twice, a statement that says nothing or two things, and two statements that
        contradict each other unless each names the other as ``disputed``.
    """
    rows = tomllib.loads(path.read_text(encoding="utf-8")).get("statement", [])
    known = {field.name for field in fields(Statement)}
    found: list[Statement] = []
    for number, row in enumerate(rows, 1):
        place = f"{path.name}, statement {number}"
        odd = sorted(set(row) - known)
        if odd:
            raise QuestionError(f"{place}: no key {odd[0]!r} there; known are {', '.join(sorted(known))}")
        lacking = [name for name in ("key", "says", "where") if not row.get(name)]
        if lacking:
            raise QuestionError(
                f"{place}: {lacking[0]!r} is missing; every statement has a key, what it says and where"
            )
        if sum(bool(row.get(name)) for name in SEARCHED) != 1:
            raise QuestionError(f"{place}, {row['key']!r}: give exactly one of {', '.join(SEARCHED)}")
        found.append(Statement(**{name: tuple(v) if isinstance(v, list) else v for name, v in row.items()}))
    _distinct(found, path)
    open_pairs = [pair for pair in contradictions(found) if not _admitted(*pair[:2])]
    if open_pairs:
        texts = "; ".join(
            f"{one.key!r} ({one.where}) and {two.key!r} ({two.where}): {why}" for one, two, why in open_pairs
        )
        raise QuestionError(
            f"{path.name}: statements contradict each other, so no machine meets them all: {texts}. Correct one of each pair, "
            f"or name each under 'disputed' of the other: then a search weighs both and reports which one gives way"
        )
    return found


def _distinct(statements: list[Statement], path: Path) -> None:
    keys = [statement.key for statement in statements]
    twice = sorted({key for key in keys if keys.count(key) > 1})
    if twice:
        raise QuestionError(f"{path.name}: key {twice[0]!r} is there twice; give every statement its own")
    for statement in statements:
        unknown = sorted(set(statement.disputed) - set(keys))
        if unknown:
            raise QuestionError(
                f"{path.name}, {statement.key!r}: disputed names {unknown[0]!r}, which is no statement here"
            )


def _admitted(one: Statement, two: Statement) -> bool:
    return two.key in one.disputed and one.key in two.disputed


def contradictions(statements: list[Statement]) -> list[tuple[Statement, Statement, str]]:
    """Pairs of statements that exclude each other by what they say, with the point where they do."""
    found = []
    for one, two in combinations(statements, 2):
        if (one.layers, one.friction) != (two.layers, two.friction):
            continue
        why = _clash(one, two)
        if why:
            found.append((one, two, why))
    return found


def _clash(one: Statement, two: Statement) -> str:
    where = (
        f"{one.layers} chamber, friction {one.friction:g}"
        if one.layers == "deep"
        else f"{one.layers} layer, friction {one.friction:g}"
    )
    if {one.none, two.none} == {True, False} and (one.some or two.some):
        return f"{where}: one says that no number of balls is carried, the other that some number is"
    for balls in COUNTS:
        first, second = one.demands(balls), two.demands(balls)
        if first is not None and second is not None and first != second:
            return f"{where}: {balls} balls are carried by one and stuck by the other"
    if one.measure and (one.measure, one.judged) == (two.measure, two.judged):
        (low, high), (other_low, other_high) = one.bounds, two.bounds
        if max(low, other_low) > min(high, other_high):
            return f"{where}: {one.measure} from {low:g} to {high:g}, and from {other_low:g} to {other_high:g}"
    return ""
