"""An archive: a folder of long runs and the catalogue of what they asked and found."""

from __future__ import annotations

import ast
import json
import operator
import re
from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.errors import QuestionError, ResultError
from autobalancer.results.answers.answer import Labeled
from autobalancer.results.archive.run import RunFolder, RunLock, Write, plain, read_note, write_part
from autobalancer.results.chamber_measures import catalog_unit
from autobalancer.results.provenance import provenance
from autobalancer.results.store import save_run
from autobalancer.safe_file import write_text_safely
from autobalancer.units import shortened

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._+-]*")


class Archive:
    """A folder of runs; it is created with the first run.

    The catalogue is read from the notes of the runs, so runs can be copied, moved or deleted by hand.

    Parameters
    ----------
    folder
        Where the archive is.
    write
        Function that writes a part of the samples to a file; by default as netCDF.
    """

    def __init__(self, folder: str | Path, write: Write = write_part) -> None:
        self.folder, self.write = Path(folder), write
        if self.folder.exists() and not self.folder.is_dir():
            raise ResultError(f"{self.folder}: is a file; an archive is a folder")

    def start(self, name: str, machine: str, parameters: Mapping[str, Any], question: Mapping[str, Any]) -> RunFolder:
        """A run to write into: a new one, or the existing one of this name if it has the same settings.

        Parameters
        ----------
        name
            Of the run; letters, digits, ``.``, ``_``, ``+`` and ``-``.
        machine
            Text of the machine file.
        parameters
            Numbers and texts by which the run is found in the catalogue.
        question
            Other settings on which the result depends: duration, step, seed and so on.

        Raises
        ------
        QuestionError
            If the name is not possible, or a run of this name has other settings.
        ResultError
            If the folder cannot be written, or another process is writing the run.
        """
        if not NAME.fullmatch(name):
            raise QuestionError(f"name: given {name!r}; use letters, digits, and . _ + - after the first")
        path = self.folder / name
        if (path / "run.json").exists():
            run = RunFolder(path, self.write)
            _compare(run, machine, question)
            return run
        note = {
            "state": "running",
            "parameters": {str(key): plain(value) for key, value in parameters.items()},
            "question": {str(key): plain(value) for key, value in question.items()},
            "measures": {},
            **provenance(),
        }
        try:
            path.mkdir(parents=True, exist_ok=True)
            with RunLock(path):
                if not (path / "run.json").exists():
                    write_text_safely(path / "machine.toml", machine)
                    write_text_safely(path / "run.json", json.dumps(note, indent=1) + "\n")
        except OSError as reason:
            raise ResultError(f"{path}: cannot be written: {reason}") from None
        run = RunFolder(path, self.write)
        _compare(run, machine, question)
        return run

    def names(self) -> list[str]:
        """Names of the runs."""
        return sorted(path.parent.name for path in self.folder.glob("*/run.json"))

    def run(self, name: str) -> RunFolder:
        """A run by its name.

        Raises
        ------
        QuestionError
            If there is none of this name.
        """
        if name not in self.names():
            raise QuestionError(f"run: given {name!r}; {self.folder} has {', '.join(self.names()) or 'no runs'}")
        return RunFolder(self.folder / name, self.write)

    def samples(self, name: str) -> xr.Dataset:
        """All samples of a run as one dataset, read from disk when used."""
        return self.run(name).samples()

    def runs(self, where: str | Mapping[str, Any] = "") -> xr.Dataset:
        """The catalogue: parameters and measures of the runs for which ``where`` holds.

        Parameters
        ----------
        where
            A condition such as ``"friction >= 0.5 and state == 'finished'"``, or values that must be met.

        Returns
        -------
        xarray.Dataset
            Along ``run``, its name: ``state``, and every parameter and every measure of one number or text. A number
            that a run does not have is nan, a text empty.

        Raises
        ------
        QuestionError
            If the condition cannot be read, or contains a name that no run has.
        """
        rows = {name: self._row(name) for name in self.names()}
        known = {key for row in rows.values() for key in row}
        if isinstance(where, Mapping):
            unknown = [key for key in where if key not in known]
            if unknown:
                raise QuestionError(
                    f"where: given {unknown[0]!r}; the runs have {', '.join(sorted(known)) or 'no values'}"
                )
            rows = {n: row for n, row in rows.items() if all(row.get(key) == plain(v) for key, v in where.items())}
        elif where.strip():
            holds = condition(where, known)
            rows = {name: row for name, row in rows.items() if holds(row)}
        table = xr.Dataset(coords={"run": ("run", np.array(list(rows), dtype=object))})
        for key in sorted(known, key=lambda key: (key != "state", key)):
            cells = [row.get(key) for row in rows.values()]
            unit = catalog_unit(key)
            table[key] = ("run", _column(cells), {"units": unit} if unit else {})
        table.attrs.update(title=f"Runs of {self.folder}", **provenance())
        return Labeled.of(table)

    def export(self, name: str, path: str | Path) -> Path:
        """Write a run as one result file, one variable at a time."""
        found = self.samples(name)
        found.attrs.setdefault("source", provenance()["source"])
        return save_run(found, path)

    def _row(self, name: str) -> dict[str, Any]:
        """What the note of a run says; of one that cannot be read only that."""
        try:
            note = read_note(self.folder / name)
        except ResultError as reason:
            return {"state": str(reason).replace(f"{self.folder / name / 'run.json'}: ", "")}
        values = {**note.get("parameters", {}), **note.get("measures", {})}
        single = {key: value for key, value in values.items() if not isinstance(value, (list, dict))}
        return {**single, "state": note.get("state", "running")}


def _column(cells: list[Any]) -> np.ndarray:
    if any(isinstance(cell, str) for cell in cells):
        return np.array(["" if cell is None else str(cell) for cell in cells], dtype=object)
    return np.array([_number(cell) for cell in cells], np.float64)


def _number(cell: Any) -> float:
    try:
        return np.nan if cell is None else float(cell)
    except OverflowError:
        return np.nan


def _compare(run: RunFolder, machine: str, question: Mapping[str, Any]) -> None:
    there, now = run.note.get("question", {}), {str(key): plain(value) for key, value in question.items()}
    told = [f"{key} ({there.get(key)!r} there, {value!r} now)" for key, value in now.items() if there.get(key) != value]
    if run.machine != machine:
        told.insert(0, "machine")
    if told:
        raise QuestionError(
            f"archive: the run {run.name!r} in {run.path.parent} was started with other settings; different: {', '.join(told)}. "
            "Give another name, or delete that run"
        )


# Which runs of a catalogue: conditions such as ``friction >= 0.5 and balls in [8, 9]``.


COMPARE: dict[type[ast.cmpop], Callable[[Any, Any], Any]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.In: lambda value, among: value in among,
    ast.NotIn: lambda value, among: value not in among,
}
COMBINE: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}
NODES: tuple[type[Any], ...] = (
    *(ast.BoolOp, ast.UnaryOp, ast.Compare, ast.BinOp, ast.Name, ast.Constant, ast.List, ast.Tuple),
    *(ast.boolop, ast.unaryop, ast.expr_context),
    *tuple(COMPARE),
    *tuple(COMBINE),
)
LONGEST = 500  # characters of a condition
FORM = 'write conditions such as "friction >= 0.5 and balls == 8", with and, or, not, in, numbers and quoted texts'


def condition(text: str, known: Collection[str]) -> Callable[[Mapping[str, Any]], bool]:
    """A function that says of a run, given as a mapping of names to values, whether ``text`` holds.

    A comparison with a value that a run does not have does not hold. Only comparisons and arithmetic are possible;
    nothing is executed.

    Raises
    ------
    QuestionError
        If the text is no condition, or names a value that none of ``known`` is.
    """
    try:
        if len(text) > LONGEST:
            raise ValueError
        tree = ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise _no_condition(text) from None
    for node in ast.walk(tree):
        if isinstance(node, ast.Name) and node.id not in known:
            raise QuestionError(
                f"where: given {node.id!r}; the runs have {', '.join(sorted(known)) or 'no values yet'}"
            )
    _check(tree, text)
    return lambda row: _holds(tree, row, text)


def _check(node: ast.AST, text: str) -> None:
    for part in ast.walk(node):
        if not isinstance(part, NODES):
            raise _no_condition(text)


def _no_condition(text: str) -> QuestionError:
    return QuestionError(f"where: given {shortened(text)}; {FORM}")


def _holds(tree: ast.expr, row: Mapping[str, Any], text: str) -> bool:
    try:
        return bool(_value(tree, row))
    except (TypeError, RecursionError):
        raise _no_condition(text) from None


def _value(node: ast.AST, row: Mapping[str, Any]) -> Any:
    match node:
        case ast.Constant():
            return node.value
        case ast.Name():
            return row.get(node.id)
        case ast.List() | ast.Tuple():
            return [_value(entry, row) for entry in node.elts]
        case ast.BoolOp():
            test = all if isinstance(node.op, ast.And) else any
            return test(bool(_value(entry, row)) for entry in node.values)
        case ast.UnaryOp():
            return _unary(node, _value(node.operand, row))
        case ast.BinOp():
            left, right = _value(node.left, row), _value(node.right, row)
            return _combined(node.op, left, right)
        case ast.Compare():
            return _compared(node, row)
    return None


def _combined(sign: ast.operator, left: Any, right: Any) -> Any:
    """Arithmetic with numbers; nothing where a value is missing, or divided by zero."""
    if left is None or right is None:
        return None
    if not all(isinstance(value, (int, float)) for value in (left, right)):
        raise TypeError
    try:
        return COMBINE[type(sign)](left, right)
    except ArithmeticError:
        return None


def _unary(node: ast.UnaryOp, value: Any) -> Any:
    if isinstance(node.op, ast.Not):
        return not value
    if value is None:
        return None
    if not isinstance(value, (int, float)):
        raise TypeError
    return -value if isinstance(node.op, ast.USub) else value


def _compared(node: ast.Compare, row: Mapping[str, Any]) -> bool:
    left = _value(node.left, row)
    for kind, other in zip(node.ops, node.comparators, strict=True):
        right = _value(other, row)
        if left is None or right is None:
            return False
        try:
            if not COMPARE[type(kind)](left, right):
                return False
        except TypeError:
            raise QuestionError(f"where: {left!r} and {right!r} cannot be compared; {FORM}") from None
        left = right
    return True
