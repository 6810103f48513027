"""The one place where an error or a stop becomes a message and an exit code."""

from __future__ import annotations

import inspect
import re
import signal
import sys
import threading
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, ClassVar

import typer
from typer.core import TyperCommand, TyperGroup

from autobalancer.errors import AutobalancerError, CacheWarning, DurationWarning, MachineError, RangeWarning
from autobalancer.tables import printable

NOTES = (RangeWarning, CacheWarning, DurationWarning)


class Command:
    """The command that runs in this process: its words, and the files that are complete."""

    words: list[str] = []
    written: list[Path] = []


HEAD = re.compile(r"^@command\((.*?)\)\ndef (\w+)\(", re.MULTILINE | re.DOTALL)


@cache
def places() -> dict[str, dict[str, str]]:
    """By topic, or group, its commands and where they are below autobalancer.cli: as the sources say, none is imported."""
    found: list[tuple[str, str, str]] = []
    for file in sorted(Path(__file__).parents[1].glob("*.py")):
        text = file.read_text(encoding="utf-8")
        usual = re.search(r'^TOPIC = "(.*)"', text, re.MULTILINE)
        for options, name in HEAD.findall(text):
            said = re.search(r'topic="(.*?)"', options) or usual
            found.append((said[1] if said else "Others", name, f"{file.stem}.{name}"))
    listed: dict[str, dict[str, str]] = {}
    for topic, name, place in sorted(found, key=lambda one: one[0] if one[0][-1].isdigit() else ""):
        listed.setdefault(topic.rstrip(" 0123456789"), {})[name.rstrip("_").replace("_", "-")] = place
    return listed


class OnDemand(Mapping[str, Any]):
    """Commands by name, each imported and its options read when it is asked for: that of all takes longer than most answers."""

    def __init__(self, topics: Mapping[str, Mapping[str, str]], groups: Mapping[str, str]) -> None:
        self._places = {name: place for commands in topics.values() for name, place in commands.items()}
        self._topics = {name: topic for topic, commands in topics.items() for name in commands}
        self._groups, self._read = groups, dict[str, Any]()

    def __getitem__(self, name: str) -> Any:
        if name not in self._read and name in self._groups:
            inner, text = OnDemand({"": places()[name]}, {}), self._groups[name]
            self._read[name] = Listing(
                name=name, commands=inner, help=text, no_args_is_help=True, rich_markup_mode="rich"
            )
        elif name not in self._read:
            alone = typer.Typer(add_completion=False, rich_markup_mode="rich")
            alone.command(name)(self._imported(name))
            command = typer.main.get_command(alone)
            command.help = _unbroken(command.help or "")
            self._read[name] = command
        return self._read[name]

    def __contains__(self, name: object) -> bool:  # that of a mapping would import the command
        return name in self._places

    def __iter__(self) -> Iterator[str]:
        return iter(self._places)

    def __len__(self) -> int:
        return len(self._places)

    def listed(self, name: str) -> Any:
        """A command as a list of commands shows it: its name and its help."""
        text = self._groups[name] if name in self._groups else self._imported(name).__doc__
        return TyperCommand(name, help=_unbroken(text or ""), rich_help_panel=self._topics[name] or None)

    def _imported(self, name: str) -> Any:
        module, _, attribute = self._places[name].rpartition(".")
        return getattr(import_module(f"autobalancer.cli.{module}"), attribute)


class Listing(TyperGroup):
    """A list of commands, which are imported when they are asked for."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self._listing = False

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        if cmd_name not in self.commands:
            return None
        return self.commands.listed(cmd_name) if self._listing else self.commands[cmd_name]  # type: ignore[attr-defined]

    def list_commands(self, ctx: Any) -> list[str]:
        """Their names; nothing is imported for them."""
        return list(self.commands)

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """The help, with the list of commands."""
        self._listing = True
        super().format_help(ctx, formatter)
        self._listing = False

    def shell_complete(self, ctx: Any, incomplete: str) -> Any:
        """The commands and options that a shell offers."""
        self._listing = True
        found = super().shell_complete(ctx, incomplete)
        self._listing = False
        return found


class Group(Listing):
    """One readable message for everything a user can get wrong; warnings without lines of code."""

    topics: ClassVar[
        Mapping[str, Mapping[str, str]]
    ]  # in their order; by topic the groups of commands, with their help

    def __init__(self, *, commands: Any = None, **options: Any) -> None:
        known, groups = places(), {name: text for inner in self.topics.values() for name, text in inner.items()}
        order = dict.fromkeys([*self.topics, *(topic for topic in known if topic not in groups)])
        listed = {topic: {**dict.fromkeys(self.topics.get(topic, ()), ""), **known.get(topic, {})} for topic in order}
        super().__init__(commands=OnDemand(listed, groups), **options)

    def invoke(self, ctx: Any) -> Any:
        words = [*getattr(ctx, "_protected_args", ()), *ctx.args]  # gone when a command has run
        Command.words, Command.written = words, []
        try:
            with stopped_like_ctrl_c(), warnings.catch_warnings():
                others = warnings.showwarning

                def show(message: Any, category: type[Warning], *place: Any) -> None:
                    if issubclass(category, NOTES):
                        typer.secho(f"note: {printable(message)}", fg="yellow", err=True)
                    else:
                        others(message, category, *place)

                warnings.showwarning = show  # type: ignore[assignment]
                return super().invoke(ctx)
        except AutobalancerError as error:
            typer.secho(f"autobalancer: {_file_of(error, words)}{printable(error)}", fg="red", err=True)
            sys.exit(MEND)
        except KeyboardInterrupt:
            typer.echo("stopped", err=True)
            for path in Command.written:
                typer.echo(f"written before: {path}", err=True)
            sys.exit(stop_code())
        except EOFError as reason:  # click takes it for the end of the input and says no more than "Aborted"
            raise RuntimeError(f"a file ended too early: {reason}") from reason
        except Exception as error:
            name = getattr(error, "option_name", None)  # of an option that the command does not have
            if isinstance(name, str) and any(name in option.opts for option in ctx.command.params):
                error.message = f"{name} stands before the command: autobalancer {name} ... {words[0]} ..."  # type: ignore[attr-defined]
            raise


def _file_of(error: AutobalancerError, words: list[str]) -> str:
    """The machine file that was given, if an error of the machine does not name it."""
    named = [word for word in words if word.endswith(".toml")]
    unsaid = isinstance(error, MachineError) and named and named[0] not in str(error)
    return f"{printable(named[0])}: " if unsaid else ""


def _unbroken(text: str) -> str:
    """A help whose lines end where the screen ends, not where they end in the code; an example keeps its lines."""
    parts = inspect.cleandoc(text).split("\n\n")
    return "\n\n".join(part if part.startswith("Example:") else part.replace("\n", " ") for part in parts)


# Exit codes of the command line.
#
# 0 finished, or ended by an event; 1 a fault of the program; 2 something the user can mend; 3 to 5 a run that did not
# come to its end; 128 and the number of the signal: stopped from outside (130 for Ctrl-C, 143 for SIGTERM).


FAULT, MEND = 1, 2
_stopped_by: list[int] = []


@contextmanager
def stopped_like_ctrl_c() -> Iterator[None]:
    """While it lasts, SIGTERM (of batch systems and containers) and SIGHUP stop as Ctrl-C does, which keeps what was computed."""
    taken = []
    if threading.current_thread() is threading.main_thread():
        numbers = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]  # Windows has one
        taken = [number for number in numbers if signal.getsignal(number) is signal.SIG_DFL]
    for number in taken:
        signal.signal(number, _stop)
    try:
        yield
    finally:
        for number in taken:
            signal.signal(number, signal.SIG_DFL)


def _stop(number: int, _frame: Any) -> None:
    _stopped_by.append(number)
    raise KeyboardInterrupt


def stop_code() -> int:
    """The exit code of a command that was stopped."""
    return 128 + (_stopped_by[-1] if _stopped_by else int(signal.SIGINT))
