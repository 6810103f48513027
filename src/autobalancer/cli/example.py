"""``autobalancer example``: the sample machines that come with the package."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from autobalancer.cli.options import Json
from autobalancer.cli.output import MACHINE, check_suffix, print_json


def example(
    name: Annotated[str, typer.Argument(help='Name of a sample machine, such as "discoidal"; without one all.')] = "",
    out: Annotated[Path | None, typer.Option(help="Machine file to write; without it the file is printed.")] = None,
    as_json: Json = False,
) -> None:
    """List the sample machines, or print or write one of them.

    Example: autobalancer example discoidal --out discoidal.toml
    """
    import tomllib
    from textwrap import shorten

    from autobalancer.files.examples import example as machine_of
    from autobalancer.files.examples import example_text, examples
    from autobalancer.safe_file import write_text_safely

    if name:
        text = example_text(name)
        if out is not None:
            check_suffix("--out", out, MACHINE)
        if as_json:
            print_json(tomllib.loads(text))
            return
        if out is None:
            typer.echo(text, nl=False)
        else:
            typer.echo(f"written: {write_text_safely(out, text)}")
        return
    found = {key: machine_of(key) for key in examples()}
    if as_json:
        print_json([{"name": key, "title": m.name, "description": m.description} for key, m in found.items()])
        return
    for key, machine in found.items():
        typer.secho(key, bold=True)
        typer.echo("  " + shorten(machine.description or machine.name, 76, placeholder=" ..."))
    typer.echo("Get one: autobalancer example NAME --out NAME.toml")
