"""The one place where an error or a stop becomes a message and an exit code."""

from __future__ import annotations

import inspect
import sys
import warnings
from typing import Any

import typer
from typer.core import TyperGroup

from autobalancer.cli.terminal.exit_codes import MEND, stop_code, stopped_like_ctrl_c
from autobalancer.cli.terminal.output import Command
from autobalancer.errors import AutobalancerError, CacheWarning, DurationWarning, MachineError, RangeWarning
from autobalancer.shown import printable

NOTES = (RangeWarning, CacheWarning, DurationWarning)


class Group(TyperGroup):
    """One readable message for everything a user can get wrong; warnings without lines of code."""

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        command = super().get_command(ctx, cmd_name)
        if command is not None:
            command.help = _unbroken(command.help or "")
        return command

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
