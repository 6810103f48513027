"""What a file may contain, for editors and other programs."""

from __future__ import annotations

import json
from collections.abc import Mapping
from importlib import import_module
from importlib.resources import files
from pathlib import Path
from typing import Any, Literal, NamedTuple

from autobalancer.errors import QuestionError, one_of
from autobalancer.machine.keys import Key, keys_of, tables_of
from autobalancer.machine.part import Part
from autobalancer.tables import facts_text, html_table, in_plain_letters

Kind = Literal[
    "races", "chambers", "design", "chamber_design", "study", "film", "balancing", "measurements", "channels"
]
ROOTS: dict[Kind, tuple[str, str]] = {  # module and class that check a file of each kind
    "races": ("machine.machine", "Machine"),
    "chambers": ("machine.chamber", "ChamberMachine"),
    "design": ("studies.design.specification", "Specification"),
    "chamber_design": ("studies.design.chambers", "ChamberSpecification"),
    "study": ("studies.study.study_file", "StudyFile"),
    "film": ("measurement.film.setup", "FilmSetup"),
    "channels": ("measurement.load_signals", "ChannelFile"),
    "measurements": ("measurement.run_up_fit", "RunUpFile"),
    "balancing": ("measurement.balancing.runs", "BalanceJob"),
}


class FileKind(NamedTuple):
    """What a file that is no machine is called, module and function that read it, and the command that answers it."""

    noun: str
    module: str
    reader: str
    command: str


OTHERS: dict[Kind, FileKind] = {
    "design": FileKind("design specification", "studies.design.design_file", "read_spec", "design {}"),
    "chamber_design": FileKind(
        "design specification of a deep chamber", "studies.design.chambers", "read_chamber_spec", "design {}"
    ),
    "study": FileKind("study", "studies.study.study_file", "read_study", "study {}"),
    "film": FileKind("set-up of a film", "measurement.film.setup", "load_film_setup", "measure balls FILM {}"),
    "channels": FileKind(
        "description of channels",
        "measurement.load_signals",
        "described_channels",
        "measure signals SIGNALS --channels {}",
    ),
    "measurements": FileKind("measurement file", "measurement.run_up_fit", "load_measurements", "identify MACHINE {}"),
    "balancing": FileKind("balancing job", "measurement.balancing.runs", "load_balance_runs", "measure balance {}"),
}
OF_MACHINES = {"axis", "rotor", "drive", "balancers", "chambers"}  # at the top of a machine file; one or none of others
OF_ALL = {"name", "description"}

DIALECT = "https://json-schema.org/draft/2020-12/schema"
ANSWERS = Path(str(files("autobalancer"))) / "catalog" / "data" / "answers.json"  # of what commands print with --json


def schema_line(folder: Path, data: Mapping[str, Any]) -> str:
    """The line that names to editors the schema of a file with these keys, if it lies there as KIND.schema.json."""
    if not any(folder.glob("*.schema.json")):
        return ""
    kind = other_kind(data) or ("chambers" if "chambers" in data else "races")
    return f"#:schema ./{kind}.schema.json\n" if (folder / f"{kind}.schema.json").is_file() else ""


def answer_schema(command: str = "") -> dict[str, Any]:
    """The JSON schema of what a command prints with --json; without a name of all, by their names in ``$defs``."""
    whole: dict[str, Any] = json.loads(ANSWERS.read_text(encoding="utf-8"))
    if command and command not in whole["$defs"]:
        known = ", ".join(name for name in whole["$defs"] if name != "number")
        raise QuestionError(f"command {command!r}: has no schema of its answer; there are {known}")
    return {**whole["$defs"][command], **whole, "title": f"autobalancer {command} --json"} if command else whole


def file_schema(kind: Kind = "races") -> dict[str, Any]:
    """The JSON schema of a file: keys, meanings, units, bounds, defaults.

    An editor that knows JSON schemas completes the keys of a TOML file with it and shows what they mean. Each quantity has
    its SI ``unit``; a text with a unit may stand in place of a number.

    Parameters
    ----------
    kind
        ``"races"`` for machines with ball races, ``"chambers"`` for those with deep chambers, ``"design"`` for specifications,
        ``"chamber_design"`` for those of deep chambers, ``"study"`` for studies, ``"film"`` for set-ups of films,
        ``"balancing"`` for balancing jobs, ``"measurements"`` for measurement files, ``"channels"`` for what the columns of
        signals are.

    Returns
    -------
    dict
        Ready for :func:`json.dumps`.
    """
    file_schema: dict[str, Any] = _without_keys(_root(kind).model_json_schema())
    return {"$schema": DIALECT, **file_schema}


def _without_keys(schema: Any) -> Any:
    """A schema whose descriptions do not repeat the keys, which have their own."""
    if isinstance(schema, list):
        return [_without_keys(entry) for entry in schema]
    if not isinstance(schema, dict):
        return schema
    told = schema.get("description")
    short = {"description": told.split("\n\nParameters\n")[0]} if isinstance(told, str) else {}
    return {key: _without_keys(entry) for key, entry in schema.items()} | short


class KeyTables(dict[str, list[Key]]):
    """Header of each table to its keys; shows itself as text, and as tables in a notebook."""

    def __repr__(self) -> str:
        return "\n\n".join(f"{head or 'at the top'}\n{facts_text(_facts(keys))}" for head, keys in self.items())

    def _repr_html_(self) -> str:
        return "".join(html_table(("", ""), _facts(keys), head or "at the top") for head, keys in self.items())


def keys(path: str = "", kind: Kind = "races") -> KeyTables:
    """The keys of a file, table by table.

    Parameters
    ----------
    path
        Of one table, such as ``"rotor"`` or ``"balancers.races"``; all tables without one.
    kind
        As for :func:`file_schema`.

    Returns
    -------
    KeyTables
        A dict of the header of a table, such as ``[[unbalances]]``, empty for the top of the file, to its keys. It prints itself.

    Raises
    ------
    QuestionError
        If there is no such table; the message lists what there is.
    """
    tables = list(tables_of(_root(kind)))
    wanted = [table for table in tables if path in ("", table.path)]
    if not wanted:
        known = ", ".join(table.path for table in tables if table.path)
        raise QuestionError(f"table {path!r}: no such table in a file of this kind; there are {known}")
    return KeyTables({table.header: [key for part in table.parts for key in keys_of(part)] for table in wanted})


def _facts(keys: list[Key]) -> list[tuple[str, str]]:
    return [(key.name, f"{key.value_and_default}\n{in_plain_letters(key.meaning)}") for key in keys]


def other_kind(data: Mapping[str, Any]) -> Kind | None:
    """Of which other kind a file with these keys at its top is: of the one that knows most of them; ``None`` if none does.

    Where as many keys are known it is a machine, then a kind that lacks no key.
    """
    names = set(data) - OF_ALL
    if len(names & OF_MACHINES) > 1:
        return None

    def rank(kind: Kind) -> tuple[int, bool, bool]:
        known = _root(kind).model_fields
        needed = {name for name, about in known.items() if about.is_required()}
        return len(names & set(known)), kind not in OTHERS, needed <= set(data)

    kind = max(ROOTS, key=rank)
    return kind if kind in OTHERS else None


def _root(kind: Kind) -> type[Part]:
    one_of("kind", kind, *ROOTS)
    module, name = ROOTS[kind]
    root: type[Part] = getattr(import_module(f"autobalancer.{module}"), name)
    return root
