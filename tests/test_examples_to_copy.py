"""Commands that help texts and pages show can be copied into an empty folder."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
import typer

import autobalancer as ab
from autobalancer.cli import app
from autobalancer.files.samples import KINDS, sample_files, sample_names

ROOT = Path(__file__).resolve().parent.parent
CLI: Any = typer.main.get_command(app)
SAMPLES = {path.name for kind in KINDS for name in sample_names(kind) for path in sample_files(name)}
WRITES = ("--out", "--plot", "--archive", "--worst", "--best")
READ = (".toml", ".csv", ".nc", ".unv")
INCLUDED = r"^```\{literalinclude\} (?:machines/(\S+)|reference/generated/tables/(\S+\.txt))"
BLOCKS = re.compile(INCLUDED + r"|^```console\n(.*?)^```", re.MULTILINE | re.DOTALL)
COMMAND = re.compile(r"^(?:\$ )?(autobalancer [a-z](?:.*\\\n)*.*)", re.MULTILINE)
HANDED = {"machine.toml", "rig.toml"}  # the reader's own


def leaves(group: Any) -> Iterator[Any]:
    for command in group.commands.values():
        yield from leaves(command) if hasattr(command, "commands") else [command]


def example_of(command: Any) -> str:
    found = re.search(r"Example: (autobalancer .*?)(?:\n\s*\n|$)", command.help, re.DOTALL)
    assert found, command.name
    return found[1].replace("\b", "")


def words(line: str) -> list[str]:
    return shlex.split(line.replace("\\\n", " "), comments=True)[1:]


def understood(line: str) -> None:
    """The command line as the program would read it, nothing done; raises if a word is not known."""
    command, rest = CLI, words(line)
    while hasattr(command, "commands"):
        command, rest = command.commands[rest[0]], rest[1:]
    command.make_context("x", rest)


def files(line: str) -> tuple[set[str], set[str]]:
    """Files that a command reads, and what it writes."""
    rest = words(line)
    written = {word for option, word in pairwise(rest) if option in WRITES}
    if rest[0] == "animate":
        written |= {rest[1].removesuffix(".nc") + ".mp4"}
    if rest[:2] == ["measure", "film"]:  # with its set-up
        written |= {path.removesuffix(".mp4") + ".toml" for path in written}
    if rest[0] in ("study", "design"):
        written |= {rest[1].removesuffix(".toml") + ".nc"}
    if rest[0] == "design":  # with the machine of the best design
        written |= {rest[1].removesuffix(".toml") + "_1.toml"}
    if rest[0] == "example":
        named = [word for word in rest[1:] if not word.startswith("--") and word not in written]
        written |= SAMPLES if "--all" in rest else {path.name for name in named for path in sample_files(name)}
    return {word for word in rest if word.endswith(READ) and word not in written}, written


@pytest.mark.parametrize("command", list(leaves(CLI)), ids=lambda command: command.name)
def test_the_example_of_every_help_text_is_understood_and_has_its_files(command: Any) -> None:
    line = example_of(command)
    understood(line)
    made = {name for each in leaves(CLI) for name in files(example_of(each))[1]}
    designed = {f"{name}.nc" for name in sample_names("designs")}  # the command design writes it, of whichever sample
    assert files(line)[0] <= SAMPLES | made | designed


@pytest.fixture
def transcripts(monkeypatch: pytest.MonkeyPatch) -> dict[str, str]:
    """The commands whose output pages include, by the name of that file."""
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "_ext"))
    import console

    return {f"{name}.txt": f"$ autobalancer {command}" for name, command in console.COMMANDS.items()}


@pytest.mark.parametrize("page", sorted((ROOT / "docs").glob("*.md")), ids=lambda page: page.stem)
def test_commands_of_a_page_can_be_copied_in_an_empty_folder(page: Path, transcripts: dict[str, str]) -> None:
    there = set(HANDED)
    for machine, transcript, typed in BLOCKS.findall(page.read_text(encoding="utf-8")):
        there |= {machine}
        for line in COMMAND.findall(transcripts.get(transcript, typed)):
            understood(line)
            read, written = files(line)
            assert read <= there, f"{line}: {read - there} is written by no command before it"
            there |= written


def test_no_page_names_files_of_a_checkout() -> None:
    pages = [*(ROOT / "docs").glob("*.md"), *(ROOT / "src" / "autobalancer" / "cli").glob("*.py")]
    named = re.compile(r"(?:examples|docs)/(?:machines|measurements)/\S+")
    assert {page.name: found for page in pages if (found := named.findall(page.read_text(encoding="utf-8")))} == {}


def test_every_sample_measurement_is_what_a_command_reads() -> None:
    assert set(sample_names("measurements")) == {
        "ball_lag",
        "discoidal_hammer",
        "equilibrium_angles",
        "four_runs",
        "race_profile",
        "rest_positions",
        "rodrigues_critical_speeds",
        "rodrigues_plain_rotor",
        "rubber_loops",
        "rubber_signals",
        "run_down_orders",
        "run_up_signals",
        "decay_signals",
        "two_plane_job",
        "later_run",
        "recorded_job",
        "as_found",
        "trial_lower",
        "trial_upper",
    }
    assert len(ab.measure.load_rubber(ab.catalog.example_path("rubber_loops"))) == 18
    assert ab.measure.load_receptance(ab.catalog.example_path("discoidal_hammer")).sizes["frequency"] > 50
