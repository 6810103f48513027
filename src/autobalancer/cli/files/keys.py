"""``autobalancer keys``: what a machine file may contain."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from autobalancer.cli.terminal.options import Csv, Json
from autobalancer.cli.terminal.output import check_suffix, print_json


def keys(
    table: Annotated[
        str, typer.Argument(help='Table of the file, such as "rotor" or "balancers.races"; without one all tables.')
    ] = "",
    chambers: Annotated[bool, typer.Option("--chambers", help="Of machines with deep chambers.")] = False,
    out: Annotated[Path | None, typer.Option(help="JSON schema to write (.json), for editors.")] = None,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """List the keys of a machine file: value with unit and bounds, default, meaning.

    Example: autobalancer keys balancers.races
    """
    import json
    from dataclasses import asdict

    from autobalancer.cli.terminal.sheet import Column, Facts, sheet_csv
    from autobalancer.machine.schema import Kind, keys, machine_schema
    from autobalancer.safe_file import write_text_safely
    from autobalancer.shown import in_plain_letters

    kind: Kind = "chambers" if chambers else "races"
    if out is not None:
        check_suffix("--out", out, (".json",))
        typer.echo(f"written: {write_text_safely(out, json.dumps(machine_schema(kind), indent=1) + chr(10))}")
        return
    found = keys(table, kind)
    rows = [(head, key) for head, listed in found.items() for key in listed]
    if as_json:
        print_json([{"table": head, **asdict(key)} for head, key in rows])
    elif as_csv:
        heads = Column("table", [head for head, _ in rows])
        rest = [
            Column(name, [getattr(key, name) for _, key in rows]) for name in ("name", "value", "default", "meaning")
        ]
        typer.echo(sheet_csv([heads, *rest]), nl=False)
    else:
        for head, listed in found.items():
            facts = Facts(head or "at the top")
            for key in listed:
                facts.add_row(key.name, f"{key.value_and_default}\n{in_plain_letters(key.meaning)}")
            facts.print()
