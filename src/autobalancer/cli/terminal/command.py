"""A command made of a public function, in one place: its options, reading them, asking, files, JSON, CSV, tables, notes.

A command is a function with the options that differ from those of the public function, and its help. What is taken as it is
has type, default and help from the source of the public function, which is read, not imported: a help loads nothing heavy.
"""

from __future__ import annotations

import ast
import inspect
import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass, fields, is_dataclass
from functools import cache, cached_property
from inspect import Parameter, Signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_type_hints

import typer

from autobalancer.cli.terminal.group import Command, stop_code
from autobalancer.cli.terminal.options import (
    Csv,
    FrequencyUnit,
    In,
    Json,
    MachineFile,
    Outs,
    Plot,
    Reader,
    Seed,
    SpeedUnit,
    Unit,
)
from autobalancer.errors import AutobalancerError, QuestionError
from autobalancer.progress import interrupts_noted

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from autobalancer.machine import Machine
    from autobalancer.machine.chamber import ChamberMachine
    from autobalancer.tables import Column

    AnyMachine = Machine | ChamberMachine | str

RESULT = (".nc", ".csv", ".json")
SIGNALS = (*RESULT, ".uff")
PICTURE = (".png", ".svg", ".pdf")
MACHINE = (".toml",)


class Files:
    """The files that were asked for; what cannot be written under its name and place is refused before the work."""

    def __init__(
        self,
        out: Sequence[Path] | Path | None = None,
        plot: Path | None = None,
        allowed: Sequence[str] = RESULT,
    ) -> None:
        self.out = [out] if isinstance(out, Path) else list(out or ())
        self.plot = plot
        for path in self.out:
            check_suffix("--out", path, allowed)
        if plot is not None:
            check_suffix("--plot", plot, PICTURE)
        from autobalancer.safe_file import ready_to_write

        paths = self._paths()
        if len({path.resolve() for path in paths}) < len(paths):
            raise QuestionError(f"--out, --plot: given {', '.join(map(str, paths))}; must be different files")
        _spare_inputs(paths)
        ready_to_write(*paths)
        self.folders = [folder for folder in {path.parent: None for path in paths} if not folder.exists()]

    def save(self, found: Any, draw: Callable[[], Figure] | None = None, machine: AnyMachine | None = None) -> None:
        """Write the result, the machine that came with it or lines of its file, and the picture."""
        for path in (path for path in self.out if path not in Command.written):
            if machine is None or path.suffix.lower() not in MACHINE:
                from autobalancer.results.store import save_run

                save_run(found, path, rescue=True)
            elif isinstance(machine, str):
                from autobalancer.safe_file import write_text_safely

                write_text_safely(path, machine)
            else:
                from autobalancer.files.machine_file import save_machine

                save_machine(machine, path)
            Command.written.append(path)
        if self.plot is not None and draw is not None:
            from autobalancer.plots.style import save_picture

            save_picture(draw(), self.plot)
            Command.written.append(self.plot)

    def say(self) -> None:
        """Name what was written, and the folders that were made for it."""
        for folder in self.folders:
            if folder.is_dir():
                typer.echo(f"new folder: {folder}")
        for path in self._paths():
            if path.exists():
                typer.echo(f"written: {path}")

    def _paths(self) -> list[Path]:
        return [*self.out, *([self.plot] if self.plot is not None else [])]


def _spare_inputs(paths: Sequence[Path]) -> None:
    """Refuse to write over a file that the command reads: its name stands twice among the words."""
    for path in paths:
        places = [Path(word.removeprefix("--out=")) for word in Command.words]
        if path.exists() and sum(place.resolve() == path.resolve() for place in places) > 1:
            raise QuestionError(f"{path}: is what the command reads; write to another file")


def check_suffix(option: str, path: Path, allowed: Sequence[str]) -> None:
    """Refuse a name that does not end with one of the suffixes.

    Raises
    ------
    QuestionError
        With the suffixes that are allowed.
    """
    if path.suffix.lower() not in allowed:
        *others, last = allowed
        names = f"{', '.join(others)} or {last}" if others else last
        raise QuestionError(f"{option} {path}: the name says how it is written; end it with {names}")


def file_to_read(path: Path) -> None:
    """Refuse a folder in place of a file, from whose name those of results are made.

    Raises
    ------
    QuestionError
        If it is one.
    """
    if path.is_dir():
        raise QuestionError(f"{path}: is a folder; give the path of a file")


def print_json(answer: Any) -> None:
    """Print an answer as JSON: nan is null, and infinity the text "Infinity", since JSON has neither."""
    from autobalancer.results.store import plain_json

    typer.echo(json.dumps(plain_json(answer), indent=2, allow_nan=False, ensure_ascii=False))


# A public function as its source says: parameters with type and default, and what its docstring says of each.


@dataclass(frozen=True)
class Public:
    """A public function, read but not imported."""

    name: str  # such as "rotor.response"
    kinds: Mapping[str, str]  # of each parameter the annotation
    defaults: Mapping[str, Any]  # of those that have one; None where it is no plain value
    meanings: Mapping[str, str]

    def __call__(self, *values: Any, **named: Any) -> Any:
        import autobalancer

        function: Any = autobalancer
        for part in self.name.split("."):
            function = getattr(function, part)
        return function(*values, **named)

    def option(self, word: str) -> Parameter:
        """A parameter as an option, by a word of ``take``."""
        name, _, unit = word.partition(":")
        many, name = name.endswith("*"), name.removesuffix("*")
        if name == "seed":  # means the same everywhere
            return Parameter(name, Parameter.KEYWORD_ONLY, annotation=Seed, default=0)
        kind, default, text = self.kinds[name], self.defaults.get(name), self.meanings[name]
        if unit:
            said = rf"(?:^|,? )\(?{re.escape(unit.replace('*', ' '))}\)?(?:,? or (?:a )?texts?)?(?=[.,;:]|$)"
            text = re.sub(said, "", text, count=1).lstrip(",; ")
            text = text[:1].upper() + text[1:]
            if "such as" not in text:
                from autobalancer.units.quantity import sample

                text = f"{text} Such as {sample(unit)}."
        kinds = kind.split(" | ")
        plain: Any = next((type_ for type_ in (Path, str, bool, int, float) if type_.__name__ in kinds), str)
        plain, missing = str if unit else plain, name not in self.defaults
        if unit and isinstance(default, float):
            default = f"{default:g} {unit}"
        if many:
            plain, default, text, name = list[plain], None, f"{text} May be repeated.", name.removesuffix("s")
        if default is None and not missing:
            plain = plain | None
        annotation: Any = Annotated[plain, *([In(unit)] if unit else []), text]
        value = Parameter.empty if missing else default
        return Parameter(name, Parameter.KEYWORD_ONLY, annotation=annotation, default=value)


@cache
def public(name: str) -> Public:
    """The public function of this name."""
    from autobalancer.public_names import NAMES

    space, _, own = name.rpartition(".")
    tree = _parsed(NAMES[space][own])
    node = next(part for part in tree.body if isinstance(part, ast.FunctionDef) and part.name == own)
    positional, named = [*node.args.posonlyargs, *node.args.args], node.args.kwonlyargs
    late = positional[len(positional) - len(node.args.defaults) :]
    pairs = [*zip(late, node.args.defaults, strict=True), *zip(named, node.args.kw_defaults, strict=True)]
    defaults = {entry.arg: _plain_value(value) for entry, value in pairs if value is not None}
    kinds = {entry.arg: ast.unparse(entry.annotation) if entry.annotation else "" for entry in (*positional, *named)}
    meanings = _meanings(ast.get_docstring(node) or "")
    if node.args.kwarg and (
        shared := re.fullmatch(r"Unpack\[(\w+)\]", ast.unparse(node.args.kwarg.annotation or node))
    ):
        homes = {
            alias.name: part.module for part in tree.body if isinstance(part, ast.ImportFrom) for alias in part.names
        }
        home = str(homes.get(shared[1], "")).removeprefix("autobalancer.")
        _add_options(_parsed(home) if home else tree, shared[1], kinds, defaults, meanings)
    return Public(name, kinds, defaults, meanings)


def _parsed(module: str) -> ast.Module:
    """The source of a module of this package."""
    import autobalancer

    place = Path(str(autobalancer.__file__)).parent.joinpath(*module.split("."))
    file = place.with_suffix(".py") if place.with_suffix(".py").is_file() else place / "__init__.py"
    return ast.parse(file.read_text(encoding="utf-8"))


def _add_options(
    tree: ast.Module, name: str, kinds: dict[str, str], defaults: dict[str, Any], meanings: dict[str, str]
) -> None:
    """Add the options of a ``TypedDict``; their defaults are the constant of that type beside it."""
    for node in tree.body:
        if isinstance(node, ast.AnnAssign) and ast.unparse(node.annotation) == name and node.value is not None:
            defaults |= ast.literal_eval(node.value)
        if isinstance(node, ast.ClassDef) and node.name == name:
            for base in node.bases:
                _add_options(tree, ast.unparse(base), kinds, defaults, meanings)
            fields_ = [part for part in node.body if isinstance(part, ast.AnnAssign)]
            kinds |= {ast.unparse(part.target): ast.unparse(part.annotation) for part in fields_}
            meanings |= _meanings(ast.get_docstring(node) or "")


def _plain_value(node: ast.expr) -> Any:
    try:
        return ast.literal_eval(node)
    except ValueError:  # the name of a constant, which the docstring explains
        return None


def _meanings(docstring: str) -> dict[str, str]:
    """What a numpy docstring says of each parameter, without its marks."""
    _, _, rest = docstring.partition("Parameters\n----------\n")
    rest = re.split(r"\n\n\w+\n-{3,}", rest)[0]
    found: dict[str, str] = {}
    for names, text in re.findall(r"^(\S[^\n]*)\n((?:(?:    [^\n]*)?(?:\n|$))+)", rest, re.MULTILINE):
        plain = re.sub(r":\w+:`~?(?:[^`<.]*\.)*([^`]+)`", r"\1", " ".join(text.split()))
        plain = re.sub(r"``\"([^`]*)\"``", r'"\1"', plain).replace("``", "").replace("[", "\\[")
        plain = re.sub(r"(?<![\w*])\*(\w[^*]*)\*(?![\w*])", r"\1", plain)  # emphasis
        found |= dict.fromkeys(names.split(", "), plain)
    return found


# The command itself.


@dataclass
class Reply:
    """What a command found; what is left out is that of the answer itself."""

    answer: Any
    json: Any = None
    heading: str | None = None
    facts: Sequence[tuple[str, str]] | None = None
    columns: Sequence[Column] | None = None
    more: Sequence[tuple[str, Sequence[Column]]] = ()  # further tables with their headings
    lines: Sequence[str] = ()  # sentences below the tables
    brief: bool = False  # whether the sentences say what the first table does
    show: Callable[[], None] | None = None  # what prints something before all else
    last: str = ""  # a sentence below the notes
    written: Files | None = None  # files that the function itself wrote
    code: str = ""  # lines that are to be copied, which are not broken
    notes: Sequence[str] | None = None
    csv: str | None = None  # in place of the first table
    draw: Callable[[], Figure] | None = None
    machine: AnyMachine | None = None  # what is written as .toml: a machine, or lines of its file
    also: Sequence[FurtherFiles] = ()
    outcome: str = ""  # of a run or a study, which the exit code says
    exit: int = 0  # code of what was not all there
    stopped: str = ""  # what is said where it was interrupted


@dataclass
class FurtherFiles:
    """Further files of an answer, which were asked for by options of their own."""

    files: Files
    answer: Any = None
    draw: Callable[[], Figure] | None = None
    machine: AnyMachine | None = None

    def save(self) -> None:
        """Write them."""
        self.files.save(self.answer, self.draw, self.machine)


def command(
    function: str = "",
    *,
    take: str = "",
    draw: bool = False,
    out: str | None = "",
    allowed: Sequence[str] = RESULT,
    unit: str = "",
    bar: str = "",
    csv: bool = True,
    topic: str = "",
) -> Callable[[Callable[..., Any]], Asking]:
    """Make a command of a function, which returns an answer or a :class:`Reply`; one without a body asks ``function``.

    Parameters
    ----------
    function
        Name of the public function that is asked.
    take
        Options that are as its parameters, with blanks between; ``hold:s`` is a quantity in seconds, ``planes*`` is --plane,
        which may be repeated.
    draw
        Whether there is --plot: ``ab.plot.answer``, where the reply does not say how.
    out
        End of the name of the result file that is written unasked; ``None``: no --out.
    allowed
        Suffixes of result files.
    unit
        Whether there is a --speed-unit ("speed"), a --frequency-unit ("frequency"), or "both".
    bar
        Text of the progress bar of a function with ``progress``.
    csv
        Whether there is --csv.
    topic
        Under which the help lists it, or its group; by default TOPIC of the module. ``group.py`` reads it off the source.
    """
    return lambda body: Asking(body, function, take, draw, out, allowed, unit, bar, csv)


@dataclass(eq=False)
class Asking:
    """A command as a function of its options, which are worked out when they are asked for."""

    body: Callable[..., Any]
    function: str
    take: str
    draw: bool
    out: str | None
    allowed: Sequence[str]
    unit: str
    bar: str
    csv: bool

    def __post_init__(self) -> None:
        self.__name__, self.__doc__, self.__module__ = self.body.__name__, self.body.__doc__, self.body.__module__
        self.__annotations__ = {}

    @cached_property
    def asked(self) -> Public | None:
        """The public function, if there is one."""
        return public(self.function) if self.function else None

    @cached_property
    def options(self) -> tuple[list[Parameter], list[Parameter], dict[str, type]]:
        """Parameters of the command's own, those that are taken, and blocks."""
        own, blocks = _own_parameters(self.body)
        taken = [self.asked.option(word) for word in self.take.split()] if self.asked else []
        if self.asked and "machine" in self.asked.kinds and "machine" not in [one.name for one in own]:
            own.insert(0, Parameter("machine", Parameter.KEYWORD_ONLY, annotation=MachineFile))
        return own, taken, blocks

    @cached_property
    def __signature__(self) -> Signature:
        own, taken, _ = self.options
        shown = [one if one.annotation is typer.Context else _as_option(one) for one in (*own, *taken)]
        return Signature([*shown, *_shared(self.draw, self.out, self.allowed, self.unit, self.csv)])

    def __call__(self, **words: Any) -> None:
        """Read the options, ask, and answer in the form that was asked for."""
        own, taken, blocks = self.options
        forms = {name: words.pop(name, None) for name in ("as_json", "as_csv")}
        if all(forms.values()):
            raise QuestionError("--json, --csv: an answer has one form; choose one of them")
        needed = next((one for one in own if one.annotation is not typer.Context), None)
        first = needed.name if needed is not None and needed.default is Parameter.empty else ""
        path, picture = (words.pop("out", None) if self.out is not None else None), words.pop("plot", None)
        if self.out:
            path = path or Path(f"{Path(words[first]).stem}{self.out}")
        files = Files(path, picture, self.allowed)
        units = {name: words.pop(name, "") for name in ("speed_unit", "frequency_unit")}
        readers = {one.name: reader for one in (*own, *taken) if (reader := _reader(one)) is not None}
        options = {name: _read(name, value, readers) for name, value in words.items()}
        for name, kind in blocks.items():
            options[name] = kind(**{part.name: options.pop(part.name) for part in fields(kind)})
        takes = {one.name for one in taken}
        options = {name: value for name, value in options.items() if name not in takes or value is not None}
        several = {f"{name}s": name for word in self.take.split() if "*" in word for name in [word.partition("s*")[0]]}
        options |= {plural: options.pop(name) for plural, name in several.items() if name in options}
        with interrupts_noted(written=True):
            with _named_options(options, several), ExitStack() as stack:
                if self.asked and "progress" in self.asked.kinds:
                    from autobalancer.cli.terminal.progress_bar import progress_bar

                    options["progress"] = stack.enter_context(progress_bar(self.bar or "done"))
                wanted = inspect.signature(self.body).parameters
                options |= {
                    name: value for name, value in (("files", files), ("as_json", forms["as_json"])) if name in wanted
                }
                found = self.body(**options)
                if found is None:
                    assert self.asked is not None
                    found = self.asked(**options)
            reply = found if isinstance(found, Reply) else Reply(found)
            if self.draw and reply.draw is None:
                reply.draw = lambda: _figure(reply.answer, units)
            files.save(reply.answer, reply.draw, reply.machine)
            for more in reply.also:
                more.save()
        word = words.get(first)
        about = {first: [*map(str, word)] if isinstance(word, list) else str(word)} if first else {}
        answered(reply, files, units["frequency_unit"] or units["speed_unit"], about, **forms)


OUTCOMES = {"not finite": 3, "too dense": 3, "step too small": 4, "budget spent": 5}


def answered(
    reply: Reply, files: Files, unit: str, about: Mapping[str, Any], *, as_json: bool | None, as_csv: bool | None
) -> None:
    """Print the answer in the form that was asked for, and leave with the code of its outcome."""
    answer = reply.answer
    if as_json:
        print_json(json_of(reply, about))
    elif as_csv:
        from autobalancer.cli.terminal.sheet import sheet_csv

        columns = (reply.columns if reply.columns is not None else _columns(answer, unit)) or _facts(reply)
        typer.echo(reply.csv if reply.csv is not None else sheet_csv(columns), nl=False)
    else:
        _show(reply, unit)
        for each in (files, reply.written, *(more.files for more in reply.also)):
            if each is not None:
                each.say()
    if reply.outcome == "interrupted" and reply.stopped:
        typer.echo(f"interrupted; {reply.stopped}", err=True)
    if reply.outcome:
        # end the command with the code of the outcome of a run, if that is not 0
        code = stop_code() if reply.outcome == "interrupted" else OUTCOMES.get(reply.outcome, 0)
        if code:
            raise typer.Exit(code)
    if reply.exit:
        raise typer.Exit(reply.exit)


def json_of(reply: Reply, about: Mapping[str, Any]) -> Any:
    """What --json prints: the answer in SI, with what was asked ``about``."""
    plain = reply.json if reply.json is not None else as_plain(reply.answer)
    return {**about, **plain} if isinstance(plain, dict) else plain


def _show(reply: Reply, unit: str) -> None:
    """Heading, facts, tables, sentences and notes."""
    from autobalancer.cli.terminal.sheet import note, print_facts, print_sentences, print_sheet

    if reply.show is not None:
        reply.show()
    answer = reply.answer if reply.show is None else None
    heading = reply.heading if reply.heading is not None else _asked(answer, "heading", "")
    facts = reply.facts if reply.facts is not None else _asked(answer, "facts", ())
    if facts:
        print_facts(facts, heading)
    columns = reply.columns if reply.columns is not None and reply.show is None else _columns(answer, unit)
    if columns and not reply.brief:
        print_sheet(columns, "" if facts else heading)
    elif heading and not facts:
        typer.secho(heading, bold=True)
    for title, table in reply.more:
        print_sheet(table, title)
    for text in reply.lines:
        print_sentences(text, indent="  ")
    if reply.code:
        typer.echo(reply.code)
    for text in reply.notes if reply.notes is not None else _asked(answer, "remarks", ()):
        note(text)
    if reply.last:
        print_sentences(reply.last)


def _facts(reply: Reply) -> list[Column]:
    """The facts as a table."""
    from autobalancer.tables import Column

    facts = reply.facts if reply.facts is not None else _asked(reply.answer, "facts", ())
    return [Column("quantity", [name for name, _ in facts]), Column("value", [text for _, text in facts])]


def _asked(answer: Any, name: str, otherwise: Any) -> Any:
    found = getattr(answer, name, otherwise)
    return found() if callable(found) else found


def as_plain(answer: Any) -> Any:
    """An answer as numbers, texts, lists and dictionaries, in SI."""
    if hasattr(answer, "data_vars"):
        about = {str(key): value for key, value in answer.attrs.items() if key not in ABOUT_FILE}
        found = {**about, **{str(name): entry.values for name, entry in answer.variables.items()}}
        return found | ({"remarks": list(answer.remarks())} if hasattr(answer, "remarks") else {})
    if hasattr(answer, "as_dict"):
        return answer.as_dict()
    return (
        asdict(answer) if is_dataclass(answer) and not isinstance(answer, type) else [as_plain(one) for one in answer]
    )


ABOUT_FILE = ("answer", "title", "source", "created")  # attributes of an answer that say where it comes from


def _columns(answer: Any, unit: str) -> Sequence[Column]:
    """The table of an answer, however wide."""
    if not hasattr(answer, "columns"):
        return []
    known = inspect.signature(answer.columns).parameters
    found: Sequence[Column] = answer.columns(
        **{key: value for key, value in (("unit", unit), ("width", 1e9)) if key in known}
    )
    return found


def _figure(found: Any, units: Mapping[str, str]) -> Figure:
    from autobalancer.plots.answer import answer, pictures_of

    known = next(iter(pictures_of(found).values())).options
    return answer(found, **{key: value for key, value in units.items() if value and key in known})


def _own_parameters(body: Callable[..., Any]) -> tuple[list[Parameter], dict[str, type]]:
    """Parameters of a command, and the blocks of options among them, whose fields stand in their place."""
    hints, blocks, found = get_type_hints(body, include_extras=True), dict[str, type](), list[Parameter]()
    for one in inspect.signature(body).parameters.values():
        if one.kind is Parameter.VAR_KEYWORD or one.name in ("files", "progress", "as_json"):
            continue
        kind = hints[one.name]
        if kind is typer.Context:
            found.insert(0, one.replace(annotation=kind, kind=Parameter.KEYWORD_ONLY))
            continue
        if not is_dataclass(kind):
            found.append(one.replace(annotation=kind, kind=Parameter.KEYWORD_ONLY))
            continue
        blocks[one.name], options = kind, get_type_hints(kind, include_extras=True)  # type: ignore[assignment]
        found += [
            Parameter(part.name, Parameter.KEYWORD_ONLY, default=part.default, annotation=options[part.name])
            for part in fields(kind)
        ]
    return found, blocks


def _as_option(one: Parameter) -> Parameter:
    """With a help alone it is an option; what is read in a unit is a text to the command line."""
    marks = getattr(one.annotation, "__metadata__", ())
    kind = one.annotation.__origin__ if marks else one.annotation
    if any(isinstance(mark, Reader) for mark in marks):
        many, may_lack = "list[" in str(kind), "None" in str(kind)
        kind = list[str] if many else str
        kind = kind | None if may_lack else kind
    info = next((mark for mark in marks if not isinstance(mark, (str, Reader))), None)
    text = next((mark for mark in marks if isinstance(mark, str)), None)
    return one.replace(annotation=Annotated[kind, info if info is not None else typer.Option(help=text)])


def _reader(one: Parameter) -> Reader | None:
    return next((mark for mark in getattr(one.annotation, "__metadata__", ()) if isinstance(mark, Reader)), None)


def _read(name: str, value: Any, readers: Mapping[str, Reader]) -> Any:
    if name not in readers or value is None:
        return value
    option = _option(name)
    return (
        [readers[name].read(option, one) for one in value]
        if isinstance(value, list)
        else readers[name].read(option, value)
    )


def _shared(draw: bool, out: str | None, allowed: Sequence[str], unit: str, csv: bool) -> list[Parameter]:
    """The options that commands share."""
    *others, last = allowed
    suffixes = f"{', '.join(others)} or {last}" if others else last
    by_default = f"; by default the name of the file with {out} here" if out else ""
    written: Any = (
        Outs
        if allowed == RESULT and not out
        else Annotated[
            list[Path] | None, typer.Option("--out", help=f"Result file: {suffixes}{by_default}. May be repeated.")
        ]
    )
    known: list[tuple[str, Any, Any, bool]] = [
        ("out", written, None, out is not None),
        ("plot", Plot, None, draw),
        ("speed_unit", Unit, SpeedUnit.RPM, unit in ("speed", "both")),
        ("frequency_unit", FrequencyUnit, SpeedUnit.HZ, unit in ("frequency", "both")),
        ("as_json", Json, False, True),
        ("as_csv", Csv, False, csv),
    ]
    return [
        Parameter(name, Parameter.KEYWORD_ONLY, default=default, annotation=kind)
        for name, kind, default, there in known
        if there
    ]


@contextmanager
def _named_options(options: Mapping[str, Any], several: Mapping[str, str]) -> Iterator[None]:
    """While it lasts, an error that begins with the name of an argument begins with that of its option, or with its file.

    ``several`` has the options of arguments that may be repeated.
    """
    try:
        yield
    except AutobalancerError as error:
        name, colon, reason = str(error).partition(":")
        plain = name.partition("[")[0]
        if not colon or plain not in options:
            raise
        raise type(error)(
            f"{options[plain] if plain == 'machine' else _option(several.get(name, name))}:{reason}"
        ) from error


@contextmanager
def on_interrupt(text: str, kept: Path = Path()) -> Iterator[None]:
    """Says what an interruption leaves, if something is ``kept``."""
    try:
        yield
    except KeyboardInterrupt:
        if kept.is_dir():
            typer.secho(f"interrupted; {text}", fg="yellow", err=True)
        raise


def _option(name: str) -> str:
    return f"--{name.replace('_', '-')}"
