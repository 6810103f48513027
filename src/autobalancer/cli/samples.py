"""``autobalancer example`` and ``recipe``: what comes with the package; ``keys``: what a file may contain."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path
from typing import Annotated, Any, cast

import typer

from autobalancer.cli.terminal.command import Reply, check_suffix, command, print_json


@command(out=None, csv=False, topic="First 1")
def example(
    names: Annotated[list[str] | None, typer.Argument(help='Such as "discoidal"; without one all are listed.')] = None,
    out: Annotated[Path | None, "Other name for one file, or a folder."] = None,
    everything: Annotated[bool, typer.Option("--all", help="Write all of them.")] = False,
    show: Annotated[bool, typer.Option("--print", help="Print the file and write nothing.")] = False,
    as_json: bool = False,
) -> Reply:
    """List the samples that come with the package, or write some into this folder: machines, rigs, measurements.

    Example: autobalancer example discoidal
    """
    from autobalancer.files.samples import KINDS

    if not (names or everything):
        return _list()
    return _samples(KINDS, names or [], out, everything, show or as_json)


@command(out=None, csv=False, topic="Files and results")
def recipe(
    names: Annotated[
        list[str] | None, typer.Argument(help='Such as "choose_the_oil"; without one all are listed.')
    ] = None,
    out: Annotated[Path | None, "Folder to write to."] = None,
    everything: Annotated[bool, typer.Option("--all", help="Write all of them.")] = False,
    show: Annotated[bool, typer.Option("--print", help="Print the recipe and write nothing.")] = False,
    as_json: bool = False,
) -> Reply:
    """List recipes for common tasks, or write some with their samples: question, commands, expected answer.

    Example: autobalancer recipe stalled_drum
    """
    from dataclasses import asdict

    from autobalancer.files.samples import RECIPES, sample_names
    from autobalancer.files.samples import recipe as find
    from autobalancer.tables import Column

    if not (names or everything):
        found = [find(name) for name in sample_names(*RECIPES)]
        columns = [
            Column(head, [getattr(one, head) for one in found], wraps=head != "name") for head in ("name", "title")
        ]
        plain = [{"name": one.name, "title": one.title, "question": one.question} for one in found]
        last = "Read one: autobalancer recipe NAME --print; write it with its samples: autobalancer recipe NAME"
        return Reply(None, plain, "Recipes", columns=columns, last=last)
    reply = _samples(RECIPES, names or [], out, everything, show or as_json)
    if as_json:
        one = find(*(names or []))
        reply.json = {**asdict(one), "samples": list(one.samples)}
    return reply


def _samples(kinds: tuple[str, ...], names: list[str], out: Path | None, everything: bool, show: bool) -> Reply:
    """Samples of some kinds shown or written."""
    import tomllib

    from autobalancer.errors import QuestionError
    from autobalancer.files.samples import sample_files, sample_names, write_example
    from autobalancer.safe_file import write_text_safely

    wanted = [name for kind in kinds for name in sample_names(kind)] if everything else names
    if show:
        if len(wanted) > 1:
            raise QuestionError(f"--print, --json: given {len(wanted)} names; must be one")
        sample = sample_files(wanted[0], kinds)[0]
        text = sample.read_text(encoding="utf-8")
        return Reply(
            None, tomllib.loads(text) if sample.suffix == ".toml" else text.splitlines(), code=text.rstrip("\n")
        )
    if out is not None and out.suffix:
        if len(wanted) > 1 or len(sample_files(wanted[0], kinds)) > 1:
            raise QuestionError(f"--out: given {out}; must be a folder for several files")
        sample = sample_files(wanted[0], kinds)[0]
        check_suffix("--out", out, (sample.suffix,))
        written = [write_text_safely(out, sample.read_text(encoding="utf-8"))]
    else:
        written = list(dict.fromkeys(path for name in wanted for path in write_example(name, out or Path(), kinds)))
    return Reply(None, code="\n".join(f"written: {path}" for path in written))


def _list() -> Reply:
    from autobalancer.cli.terminal.sheet import print_sentences
    from autobalancer.files.samples import KINDS, sample_names

    found = {kind: {name: _about(name) for name in sample_names(kind)} for kind in KINDS}
    plain = [
        {"name": name, "kind": {"studies": "study"}.get(kind, kind[:-1]), "title": title, "description": text}
        for kind, listed in found.items()
        for name, (title, text) in listed.items()
    ]

    def show() -> None:
        for kind, listed in found.items():
            typer.secho(kind, bold=True, underline=True)
            for name, (title, text) in listed.items():
                typer.secho(name, bold=True)
                sentence = re.split(r"(?<=\.)\s+(?=[A-Z])", text, maxsplit=1)[0]
                print_sentences(sentence or title, indent="  ", first="  ")
        typer.echo("Get one: autobalancer example NAME; all of them: autobalancer example --all")

    return Reply(None, plain, show=show)


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


# ``autobalancer cite``: what a run rests on.


@command(out=None, csv=False, topic="Files and results")
def cite(
    what: Annotated[
        str,
        typer.Argument(
            help="Machine file, result, or a command or function such as borders; without one the program itself.",
            show_default=False,
        ),
    ] = "",
    everything: Annotated[bool, typer.Option("--all", help="Every source of the package.")] = False,
    out: Annotated[Path | None, "BibTeX file to write (.bib)."] = None,
) -> Reply:
    """Print as BibTeX what to cite for a machine or a result: the program, and the sources of methods, laws, parts and products.

    Example: autobalancer cite stall.nc
    """
    from autobalancer.assembly.terms import SOFTWARE, bibliography, methods, sources
    from autobalancer.files.machine_file import load_machine, parse_machine
    from autobalancer.plots.answer import made_by
    from autobalancer.public_names import function_of
    from autobalancer.results.run_argument import open_run
    from autobalancer.safe_file import write_text_safely

    machine, about, made = None, dict[str, Any](), what and (function_of(what) or what)
    if what and not any(made in results for results, _ in methods().values()):
        made = ""
        if Path(what).suffix == ".toml":
            machine = load_machine(what)
        else:
            found = open_run(what)
            about, made = dict(found.attrs), made_by(found)
            machine = parse_machine(str(about["machine"]), what) if "machine" in about else None
    used = sources(machine, about, {made})
    own, version = bibliography()[SOFTWARE], str(about.get("source", "")).partition(" ")[2]  # of what made the result
    entries = bibliography() | {SOFTWARE: re.sub(r"Version [\w.+]+", f"Version {version}", own) if version else own}
    keys = dict.fromkeys((*used, *(entries if everything else ())))
    rows = [{"key": key, "used_for": list(used.get(key, ())), "bibtex": entries.get(key, f"% {key}")} for key in keys]
    text = "\n\n".join("".join(f"% {use}\n" for use in row["used_for"]) + str(row["bibtex"]) for row in rows)
    if out is not None:
        check_suffix("--out", out, (".bib",))
        text = f"written: {write_text_safely(out, text + chr(10))}"
    return Reply(None, rows, code=text)


# ``autobalancer keys``: what a file may contain.


@command(out=None, topic="Files and results")
def keys(
    table: Annotated[
        str,
        typer.Argument(
            help='Table of the file, such as "rotor" or "balancers.races", or of answers a command; without one all.'
        ),
    ] = "",
    kind: Annotated[
        str,
        "Of file: races or chambers (machines), design, chamber_design, study, film, balancing, measurements or channels; "
        "or answers: what a command prints with --json, as JSON schema.",
    ] = "races",
    out: Annotated[Path | None, "JSON schema to write; named races.schema.json, files written there name it."] = None,
) -> Reply:
    """List the keys of a machine file, or of another kind: value with unit and bounds, default, meaning.

    Example: autobalancer keys balancers.races
    """
    import json
    from dataclasses import asdict

    from autobalancer.cli.terminal.sheet import print_facts
    from autobalancer.machine.schema import Kind, answer_schema, file_schema, keys
    from autobalancer.safe_file import write_text_safely
    from autobalancer.tables import Column, in_plain_letters

    if out is not None:
        check_suffix("--out", out, (".json",))
        schema = answer_schema(table) if kind == "answers" else file_schema(cast(Kind, kind))
        path = write_text_safely(out, json.dumps(schema, indent=1) + chr(10))
        return Reply(None, {"written": str(path)}, code=f"written: {path}")
    if kind == "answers":
        return Reply(None, answer_schema(table), code=json.dumps(answer_schema(table), indent=1))
    found = keys(table, cast(Kind, kind))
    rows = [(head, key) for head, listed in found.items() for key in listed]
    names = ("name", "value", "default", "meaning")

    def show() -> None:
        for head, listed in found.items():
            texts = [(key.name, f"{key.value_and_default}\n{in_plain_letters(key.meaning)}") for key in listed]
            print_facts(texts, head or "at the top")

    heads = Column("table", [head for head, _ in rows])
    return Reply(
        None,
        [{"table": head, **asdict(key)} for head, key in rows],
        columns=[heads, *(Column(name, [getattr(key, name) for _, key in rows]) for name in names)],
        brief=True,
        show=show,
    )


# ``autobalancer app``: the bench as a web page.


@command(out=None, csv=False, topic="Files and results")
def app(
    port: Annotated[int, "At which the page is served."] = 8123,
    host: Annotated[str, "Address to listen on; any but this computer's own needs a token."] = "127.0.0.1",
    token: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME:TOKEN",
            help="Who may use the page; each name has runs of its own. May be repeated. "
            "With another host and without it, one is made and printed.",
        ),
    ] = None,
    folder: Annotated[Path | None, "Where runs are kept; by default autobalancer-bench in your home folder."] = None,
    time_limit: Annotated[float, typer.Option(min=1.0, help="Seconds that a run may take.")] = 600.0,
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Do not open a browser.")] = False,
    as_json: bool = False,
) -> None:
    """Open the bench in a browser: describe, check and run machines on one page. Ctrl-C ends it.

    It answers this computer only, unless you name another host. Needs pip install 'autobalancer\\[app]'.

    Example: autobalancer app
    """
    from autobalancer.app.serve import FOLDER, serve
    from autobalancer.cli.terminal.group import stop_code
    from autobalancer.cli.terminal.sheet import print_sentences

    def announce(address: str, home: Path) -> None:
        if as_json:
            print_json({"address": address, "folder": str(home)})
        else:
            print_sentences(f"the bench is at {address}")
            print_sentences(f"runs are kept in {home}; Ctrl-C ends the server")

    browser, code = not no_browser, 0
    try:
        serve(
            folder or FOLDER,
            host=host,
            port=port,
            tokens=token or [],
            browser=browser,
            limit=time_limit,
            announce=announce,
        )
    except KeyboardInterrupt:
        typer.echo("stopped", err=True)
        code = stop_code()
    _leave(code)


def _leave(code: int) -> None:
    """End the process now: a thread that compiles cannot be interrupted, and every file is complete at any time."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)
