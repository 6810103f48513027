"""The reference of the command line, read off the commands themselves."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import typer

from autobalancer.cli import app
from autobalancer.files.samples import RECIPES, sample_files, sample_names
from autobalancer.public_names import function_of

DOCS = Path(__file__).resolve().parents[1]
HEAD = "| {} | meaning | default |\n|---|---|---|\n"


def pages() -> dict[str, str]:
    """What the documentation includes."""
    return {"commands.md": commands(), "commands_and_functions.md": functions(), "recipes.md": recipes()}


def commands() -> str:
    """A section for each command: what it does, its examples, arguments and options."""
    return "".join(_section(path, command) for path, command in _walk("autobalancer", typer.main.get_command(app)))


def functions() -> str:
    """The public function of each command: its last word."""
    paths = [path.removeprefix("autobalancer ") for path, _ in _walk("autobalancer", typer.main.get_command(app))]
    return "| command | in Python |\n|---|---|\n" + "".join(
        f"| `{path}` | {f'`ab.{function_of(path)}`' if function_of(path) else '–'} |\n" for path in paths
    )


def examples() -> dict[str, list[str]]:
    """By the full name of a public function the command lines that ask it: the example of each help."""
    found: dict[str, list[str]] = {}
    for path, command in _walk("autobalancer", typer.main.get_command(app)):
        name = function_of(path.removeprefix("autobalancer "))
        lines = re.findall(r"^\$ (.*)$", _help(command.help or ""), re.MULTILINE)
        found.setdefault(f"autobalancer.{name}", []).extend(lines if name else [])
    return found


def snippets() -> dict[str, tuple[str, str]]:
    """By the full name of a public name the first lines of Python on a page that use it, and that page."""
    found: dict[str, tuple[str, str]] = {}
    for page in sorted(DOCS.glob("*.md")):
        for code in re.findall(r"^```python\n(.*?)^```", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL):
            names = [f"autobalancer.{name}" for name in re.findall(r"\bab\.(\w+(?:\.\w+)*)", code)]
            for module, listed in re.findall(r"^from (autobalancer\.\w+) import ([\w, ]+)$", code, re.MULTILINE):
                names += [f"{module}.{name}" for name in listed.split(", ")]
            for name in names:
                found.setdefault(name, (code, page.stem))
    return found


def recipes() -> str:
    """The recipes that come with the package, each a section."""
    pages = (sample_files(name, RECIPES)[0].read_text(encoding="utf-8") for name in sample_names(*RECIPES))
    return "\n".join(f"#{page}" for page in pages)


def _walk(path: str, command: Any) -> Iterator[tuple[str, Any]]:
    """The commands that do something, in the order of the help."""
    inner = getattr(command, "commands", None)
    if inner is None:
        yield path, command
        return
    for name, child in inner.items():
        yield from _walk(f"{path} {name}", child)


def _section(path: str, command: Any) -> str:
    shown = [parameter for parameter in command.params if not getattr(parameter, "hidden", False)]
    arguments = [parameter for parameter in shown if parameter.param_type_name == "argument"]
    options = [parameter for parameter in shown if parameter.param_type_name == "option"]
    usage = " ".join([path, *(_place(argument) for argument in arguments), *(["[OPTIONS]"] if options else [])])
    text = f"## {path.removeprefix('autobalancer ')}\n\n```console\n$ {usage}\n```\n\n{_help(command.help or '')}\n\n"
    for title, listed in (("argument", arguments), ("option", options)):
        if listed:
            rows = "".join(f"| {_name(one)} | {_cell(one.help or '')} | {_default(one)} |\n" for one in listed)
            text += f"{HEAD.format(title)}{rows}\n"
    return text


def _help(text: str) -> str:
    """Paragraphs as they are; examples as code."""
    blocks = []
    for block in text.replace("\b", "").replace("\f", "").strip().split("\n\n"):
        example, command = re.match(r"\s*Examples?:?\s*", block), "autobalancer "
        if example or block.lstrip().startswith(command):
            lines = block[example.end() :] if example else block
            commands = re.sub(r"\s*\\?\n\s+", " ", lines.strip()) if "\\\n" in lines else lines.strip()
            shown = [f"$ {line.strip().removeprefix('$ ')}" for line in commands.splitlines() if line.strip()]
            blocks.append("```console\n" + "\n".join(shown) + "\n```")
        else:
            blocks.append(_plain(" ".join(block.split())))
    return "\n\n".join(blocks)


def _place(argument: Any) -> str:
    name = (argument.metavar or argument.name).upper()
    return f"[{name}]" if not argument.required else name


def _name(one: Any) -> str:
    words = one.opts + one.secondary_opts if one.param_type_name == "option" else [_place(one)]
    return ", ".join(f"`{word}`" for word in words)


def _default(one: Any) -> str:
    if one.required:
        return "required"
    if one.default in (None, "", (), []) or isinstance(one.default, bool) or callable(one.default):
        return "–"
    return f"`{one.default}`"


def _cell(text: str) -> str:
    return _plain(" ".join(text.split())).replace("|", "\\|")


def _plain(text: str) -> str:
    """Without the marks that Rich understands, and with those of Markdown left as they are."""
    text = re.sub(r"(?<!\\)\[/?[a-z ]+\]", "", text)
    return text.replace("\\[", "[").replace("<", "&lt;")
