"""``autobalancer example``: the sample machines, rigs and measurements that come with the package."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated

import typer

from autobalancer.cli.terminal.options import Json
from autobalancer.cli.terminal.output import check_suffix, print_json

SINGULAR = {
    "machines": "machine",
    "rigs": "rig",
    "measurements": "measurement",
    "studies": "study",
    "designs": "design",
}


def example(
    names: Annotated[list[str] | None, typer.Argument(help='Such as "discoidal"; without one all are listed.')] = None,
    out: Annotated[Path | None, typer.Option(help="Other name for one file, or a folder.")] = None,
    everything: Annotated[bool, typer.Option("--all", help="Write all of them.")] = False,
    show: Annotated[bool, typer.Option("--print", help="Print the file and write nothing.")] = False,
    as_json: Json = False,
) -> None:
    """List the samples that come with the package, or write some into this folder: machines, rigs, measurements.

    Example: autobalancer example discoidal
    """
    from autobalancer.errors import QuestionError
    from autobalancer.files.samples import KINDS, sample_files, sample_names, write_example

    wanted = [name for kind in KINDS for name in sample_names(kind)] if everything else names or []
    if not wanted:
        _list(as_json)
        return
    if show or as_json:
        if len(wanted) > 1:
            raise QuestionError(f"--print, --json: given {len(wanted)} names; must be one")
        _print(sample_files(wanted[0])[0], as_json)
        return
    if out is not None and out.suffix:
        if len(wanted) > 1 or len(sample_files(wanted[0])) > 1:
            raise QuestionError(f"--out: given {out}; must be a folder for several files")
        _write_as(sample_files(wanted[0])[0], out)
        return
    for name in wanted:
        for path in write_example(name, out or Path()):
            typer.echo(f"written: {path}")


def _write_as(sample: Path, out: Path) -> None:
    from autobalancer.safe_file import write_text_safely

    check_suffix("--out", out, (sample.suffix,))
    typer.echo(f"written: {write_text_safely(out, sample.read_text(encoding='utf-8'))}")


def _print(sample: Path, as_json: bool) -> None:
    import tomllib

    text = sample.read_text(encoding="utf-8")
    if as_json and sample.suffix == ".toml":
        print_json(tomllib.loads(text))
    elif as_json:
        print_json(text.splitlines())
    else:
        typer.echo(text, nl=False)


def _list(as_json: bool) -> None:
    from autobalancer.cli.terminal.words import say
    from autobalancer.files.samples import KINDS, sample_names

    found = {kind: {name: _about(name) for name in sample_names(kind)} for kind in KINDS}
    if as_json:
        print_json(
            [
                {"name": name, "kind": SINGULAR[kind], "title": title, "description": text}
                for kind, listed in found.items()
                for name, (title, text) in listed.items()
            ]
        )
        return
    for kind, listed in found.items():
        typer.secho(kind, bold=True, underline=True)
        for name, (title, text) in listed.items():
            typer.secho(name, bold=True)
            say(_first_sentence(text) or title, indent="  ", first="  ")
    typer.echo("Get one: autobalancer example NAME; all of them: autobalancer example --all")


def _first_sentence(text: str) -> str:
    return re.split(r"(?<=\.)\s+(?=[A-Z])", text, maxsplit=1)[0]


def _about(name: str) -> tuple[str, str]:
    """Name and description of a sample: of a table the lines of comment at its beginning."""
    import tomllib
    from itertools import takewhile

    from autobalancer.files.samples import example_path

    text = example_path(name).read_text(encoding="utf-8")
    if example_path(name).suffix == ".toml":
        about = tomllib.loads(text)
        return about.get("name", name), about.get("description", "")
    said = takewhile(lambda line: line.startswith("#"), text.splitlines())
    return name, " ".join(line.removeprefix("#").strip() for line in said)
