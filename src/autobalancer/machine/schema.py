"""What a machine file may contain, for editors and other programs."""

from __future__ import annotations

from typing import Any, Literal

from autobalancer.errors import QuestionError
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.machine.keys import Key, keys_of, tables_of
from autobalancer.machine.machine import Machine

Kind = Literal["races", "chambers"]

DIALECT = "https://json-schema.org/draft/2020-12/schema"


def machine_schema(kind: Kind = "races") -> dict[str, Any]:
    """The JSON schema of a machine file: keys, meanings, units, bounds, defaults.

    An editor that knows JSON schemas completes the keys of a TOML file with it and shows what they mean. Each quantity has
    its SI ``unit``; a text with a unit may stand in place of a number.

    Parameters
    ----------
    kind
        ``"races"`` for machines with ball races, ``"chambers"`` for those with deep chambers.

    Returns
    -------
    dict
        Ready for :func:`json.dumps`.
    """
    schema = _root(kind).model_json_schema()
    for part in (schema, *schema["$defs"].values()):
        part["description"] = part.get("description", "").split("\n\nParameters\n")[0]
    return {"$schema": DIALECT, **schema}


def file_tables(path: str = "", kind: Kind = "races") -> dict[str, list[Key]]:
    """The keys of a machine file, table by table.

    Parameters
    ----------
    path
        Of one table, such as ``"rotor"`` or ``"balancers.races"``; all tables without one.
    kind
        As for :func:`machine_schema`.

    Returns
    -------
    dict
        Header of a table, such as ``[[unbalances]]``, to its keys; empty for the top of the file.

    Raises
    ------
    QuestionError
        If there is no such table; the message lists what there is.
    """
    tables = list(tables_of(_root(kind)))
    wanted = [table for table in tables if path in ("", table.path)]
    if not wanted:
        known = ", ".join(table.path for table in tables if table.path)
        raise QuestionError(f"table {path!r}: no such table in a machine file; there are {known}")
    return {table.header: [key for part in table.parts for key in keys_of(part)] for table in wanted}


def _root(kind: Kind) -> type[Machine] | type[ChamberMachine]:
    return ChamberMachine if kind == "chambers" else Machine
