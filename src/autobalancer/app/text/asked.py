"""What is wrong with the text of a study, key by key, in the words of the reader of study files; the machine it is of."""

from __future__ import annotations

import math
import re
import tomllib
from dataclasses import dataclass
from typing import Any

from autobalancer.app.text.problems import LARGEST, files_in, read
from autobalancer.errors import AutobalancerError, QuestionError
from autobalancer.files.machine_file import machine_text, parse_machine
from autobalancer.files.samples import example_path, sample_names
from autobalancer.machine import Machine
from autobalancer.studies.study.outputs import RUN
from autobalancer.studies.study.reading import read_study
from autobalancer.studies.study.spec import Study

PAGE = "machine.toml"  # what a study calls the machine of the page Describe
MOST = 200_000  # members of a study on the page
FAULT = re.compile(r'(vary\."[^"]+"|vary\.\S+?|[a-z_]+(?:\[\d+\])?(?:\.[a-z_]+)*): (.+)', re.DOTALL)
BOTH = re.compile(r"([a-z_.]+) and [a-z_.]+ contradict each other")


@dataclass(frozen=True)
class MachineAsked:
    """The machine that a study or design names."""

    file: str = PAGE
    machine: Machine | None = None
    text: str = ""
    message: str = ""  # why there is none


@dataclass(frozen=True)
class StudyReading:
    """A text that was read: the study, or what is wrong with it and the key where."""

    of: MachineAsked
    study: Study | None = None
    message: str = ""
    key: str = ""


def read_study_text(text: str, page: str) -> StudyReading:
    """Read the text of a study; ``page`` is the text of the machine of the page. What is wrong is an answer, not an error."""
    data, wrong = tables_of(text)
    if data is None:
        return StudyReading(MachineAsked(), None, wrong)
    of = machine_asked(data, page)
    if of.machine is None:
        return StudyReading(of, None, of.message, "machine")
    try:
        refuse_files(data)
        study = read_study({**data, "machine": of.machine})
        if RUN in study.results and not study.duration > 0.0:
            raise QuestionError("study: duration: the machine has no 'run.duration'; give one in the study")
        if study.count > MOST:
            raise QuestionError(f"study: members: {study.count} in all are asked for; on the page at most {MOST} run")
    except AutobalancerError as error:
        message = str(error).removeprefix("study: ")
        return StudyReading(of, None, message, key_at_fault(message))
    return StudyReading(of, study)


def tables_of(text: str) -> tuple[dict[str, Any] | None, str]:
    """The tables of a text, or why there are none."""
    if len(text) > LARGEST:
        return None, f"the text has more than {LARGEST} characters; such files are smaller"
    try:
        return tomllib.loads(text), ""
    except (ValueError, RecursionError) as reason:
        return None, f"not valid TOML: {reason}"


def machine_asked(data: dict[str, Any], page: str, *, rigs: bool = False) -> MachineAsked:
    """The machine of the page, or a sample of the package; no other file of the server is read.

    With ``rigs`` a published rig may be named without the ending of its file.
    """
    given = data.get("machine")
    if given == PAGE:
        reading = read(page)
        if not isinstance(reading.machine, Machine):
            why = reading.message or "its balls move in chambers, and this question is for balls in races"
            return MachineAsked(message=f"the machine of the page Describe is not possible here: {why}")
        return MachineAsked(PAGE, reading.machine, _alone(page, reading.machine))
    name = str(given).removesuffix(".toml")
    known = given != name and name in (*sample_names("machines"), *sample_names("rigs"))
    if not (known or (rigs and given in sample_names("rigs"))):
        said = f"given {str(given)[:60]!r}" if given is not None else "missing"
        return MachineAsked(
            message=f'machine: {said}; take machine = "{PAGE}" for the machine of the page Describe, or a sample, such as '
            'machine = "discoidal.toml"'
        )
    path = example_path(name)
    text = path.read_text(encoding="utf-8")
    try:
        machine = parse_machine(text, path.name, folder=path.parent)
    except AutobalancerError as error:
        return MachineAsked(message=str(error))
    if not isinstance(machine, Machine):
        return MachineAsked(
            message=f"machine: {path.name} has balls in chambers, and this question is for balls in races"
        )
    return MachineAsked(path.name, machine, _alone(text, machine))


def refuse_files(data: dict[str, Any]) -> None:
    """Refuse entries that name a file.

    Raises
    ------
    QuestionError
        With its name.
    """
    for name in files_in({key: value for key, value in data.items() if key != "machine"}):
        raise QuestionError(f"file {name[:80]!r}: on this page a study names no files; give the numbers in the text")


def key_at_fault(message: str) -> str:
    """The key with which a message begins, such as ``members`` or ``vary.stiffness``; empty if it names none."""
    found = BOTH.match(message) or FAULT.match(message)
    return found[1].replace('"', "") if found else ""


def about(study: Study) -> str:
    """How much a study asks for, in words."""
    points = math.prod(map(len, study.grid.values()))
    draws = f"{study.draws} draw{'s' * (study.draws != 1)}"
    where = f" at each of {points} points" if points > 1 else ""
    most = ", at most" if study.stop is not None else ""
    return f"{study.count} members: {draws}{where}{most}"


def _alone(text: str, machine: Machine) -> str:
    """The text of a machine that needs no file beside it."""
    try:
        data = tomllib.loads(text)
    except ValueError:
        return machine_text(machine)
    return machine_text(machine) if next(files_in(data), None) is not None else text
