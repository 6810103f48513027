"""What is wrong with the text of a machine, key by key, in the words of the reader of machine files."""

from __future__ import annotations

import math
import shutil
import tomllib
from collections.abc import Callable, Iterator, Sequence
from copy import deepcopy
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import tomli_w

from autobalancer.errors import ON_THE_PAGE, AutobalancerError, KeyPath, QuestionError
from autobalancer.files.machine_file import machine_text, parse_machine
from autobalancer.files.samples import example_path, sample_names
from autobalancer.machine import Machine
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.studies.design.chambers import ChamberSpec, read_chamber_spec
from autobalancer.studies.design.design_file import read_spec
from autobalancer.studies.design.specification import Spec
from autobalancer.studies.study.chunk import RUN
from autobalancer.studies.study.study_file import read_study
from autobalancer.studies.study.study_spec import Study

SOURCE = "machine"
STAND_INS = {  # for keys of the rotor, the drive and the race that its drawing does not show
    "mass": "1 kg",
    "stiffness": "1 N/m",
    "damping": "1 N*s/m",
    "end": "1 rpm",
    "duration": "1 s",
    "fluid": {"name": "water"},
}
STAGES = 4  # in which a machine is read: what belongs to a part is looked at when the part itself is right
LARGEST = 1_000_000  # characters of a text on the page


@dataclass(frozen=True)
class Reading:
    """A text that was read: the machine, or what is wrong with it."""

    machine: Machine | ChamberMachine | None
    message: str = ""
    problems: dict[KeyPath, str] = field(default_factory=dict)


def read(text: str, files: Path = Path("no files")) -> Reading:
    """Read the text of a machine, with the ``files`` of the user that it names; what is wrong is an answer, not an error."""
    if len(text) > LARGEST:
        return Reading(None, f"the text has more than {LARGEST} characters; machine files are smaller")
    samples, named = example_path("discoidal").parent, dict(files_in(data_of(text)))
    for path, name in named.items():  # samples name tables beside them; no other file of the server is read
        if Path(name).name != name or "\\" in name or not any((folder / name).is_file() for folder in (files, samples)):
            why = f"file {name[:80]!r}: is not here; give it on the page, beside its field of the form"
            return Reading(None, why, {path: why})
    folder = files if any((files / name).is_file() for name in named.values()) else samples
    for name in named.values():
        if not (folder / name).is_file():  # both a table of a sample and a file of the user
            shutil.copy(samples / name, folder / name)
    try:
        return Reading(parse_machine(text, SOURCE, folder=folder))
    except AutobalancerError as error:
        found = {path: message.replace(f"{folder}/", "") for path, message in by_path(error).items()}
        return Reading(None, str(error).removeprefix(f"{SOURCE}: ").replace(f"{folder}/", ""), found)


def drawable(text: str) -> Machine | ChamberMachine | None:
    """The machine of a text that is still being filled in, with stand-ins for what no drawing shows; ``None`` without lengths."""
    for _ in range(STAGES):
        reading = read(text)
        if reading.machine is not None or not reading.problems:
            return reading.machine
        for path in reading.problems:
            if path[0] == "unbalances":
                text = without(text, path[:1]) if "unbalances" in (data_of(text) or {}) else text
            elif path[-1] in STAND_INS and (path[0] in ("rotor", "drive")) != (path[-1] == "fluid"):
                text = with_value(text, path, STAND_INS[str(path[-1])])
            else:
                return None
    return None


def for_page(text: str) -> str:
    """What is said of a run or a machine, with the way on the page in place of that in Python or on the command line."""
    for words, here in ON_THE_PAGE.items():
        text = text.replace(words, here)
    return text


# keys of `rotor.files` that name one
ROTOR_FILES = ("file", "mass", "stiffness", "damping", "gyroscopic", "nodes", "rows")


def files_in(data: Any, path: KeyPath = ()) -> Iterator[tuple[KeyPath, str]]:
    """Every file that a machine names, with the path of its key."""
    named = ROTOR_FILES if path[-1:] == ("files",) else ("file",)
    for key, value in data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ():
        if key in named:
            yield (*path, key), str(value)
        yield from files_in(value, (*path, key))


def by_path(error: AutobalancerError) -> dict[KeyPath, str]:
    """What is wrong at each key at fault."""
    found: dict[KeyPath, str] = {}
    for path, message in error.problems:
        if path:
            found[path] = f"{found[path]}; {message}" if path in found else message
    return found


def by_key(error: AutobalancerError) -> dict[str, str]:
    """The same by the names of the keys, such as ``limits.share``."""
    return {".".join(map(str, path)): message for path, message in by_path(error).items()}


# What is wrong with the text of a study, key by key, in the words of the reader of study files; the machine it is of.


PAGE = "machine.toml"  # what a study calls the machine of the page Describe
MOST = 200_000  # members of a study on the page


@dataclass(frozen=True)
class NamedMachine:
    """The machine that a study or design names."""

    file: str = PAGE
    machine: Any = None
    text: str = ""
    message: str = ""  # why there is none


@dataclass(frozen=True)
class StudyReading:
    """A text that was read: the study, or what is wrong with it and the key where."""

    of: NamedMachine
    study: Study | None = None
    message: str = ""
    problems: dict[str, str] = field(default_factory=dict)  # by their keys


def read_study_text(text: str, page: str) -> StudyReading:
    """Read the text of a study; ``page`` is the text of the machine of the page. What is wrong is an answer, not an error."""
    data, wrong = tables_of(text)
    if data is None:
        return StudyReading(NamedMachine(), None, wrong)
    of = named_machine(data, page)
    if of.machine is None:
        return StudyReading(of, None, of.message, {"machine": of.message})
    try:
        refuse_files(data)
        study = read_study({**data, "machine": of.machine})
        if RUN in study.results and not study.duration > 0.0:
            raise QuestionError("the machine has no 'run.duration'; give one in the study", ("duration",))
        if study.count > MOST:
            raise QuestionError(f"{study.count} in all are asked for; on the page at most {MOST} run", ("members",))
    except AutobalancerError as error:
        return StudyReading(of, None, str(error).removeprefix("study: "), by_key(error))
    return StudyReading(of, study)


def tables_of(text: str) -> tuple[dict[str, Any] | None, str]:
    """The tables of a text, or why there are none."""
    if len(text) > LARGEST:
        return None, f"the text has more than {LARGEST} characters; such files are smaller"
    try:
        return tomllib.loads(text), ""
    except (ValueError, RecursionError) as reason:
        return None, f"not valid TOML: {reason}"


def named_machine(data: dict[str, Any], page: str, *, design: bool = False) -> NamedMachine:
    """The machine of the page, or a sample of the package; no other file of the server is read.

    In a ``design`` a published rig may be named without the ending of its file, and balls may move in chambers.
    """
    given, possible = data.get("machine"), Machine | ChamberMachine if design else Machine
    if given == PAGE:
        reading = read(page)
        if not isinstance(reading.machine, possible):
            why = reading.message or "its balls move in chambers, and this question is for balls in races"
            return NamedMachine(message=f"the machine of the page Describe is not possible here: {why}")
        return NamedMachine(PAGE, reading.machine, self_contained(page, reading.machine))
    name = str(given).removesuffix(".toml")
    known = given != name and name in (*sample_names("machines"), *sample_names("rigs"))
    if not (known or (design and given in sample_names("rigs"))):
        said = f"given {str(given)[:60]!r}" if given is not None else "missing"
        return NamedMachine(
            message=f'machine: {said}; take machine = "{PAGE}" for the machine of the page Describe, or a sample, such as '
            'machine = "discoidal.toml"'
        )
    path = example_path(name)
    text = path.read_text(encoding="utf-8")
    try:
        machine = parse_machine(text, path.name, folder=path.parent)
    except AutobalancerError as error:
        return NamedMachine(message=str(error))
    if not isinstance(machine, possible):
        return NamedMachine(
            message=f"machine: {path.name} has balls in chambers, and this question is for balls in races"
        )
    return NamedMachine(path.name, machine, self_contained(text, machine))


def refuse_files(data: dict[str, Any]) -> None:
    """Refuse entries that name a file.

    Raises
    ------
    QuestionError
        With its name.
    """
    for _, name in files_in({key: value for key, value in data.items() if key != "machine"}):
        raise QuestionError(f"file {name[:80]!r}: on this page a study names no files; give the numbers in the text")


def about(study: Study) -> str:
    """How much a study asks for, in words."""
    points = math.prod(map(len, study.grid.values()))
    draws = f"{study.draws} draw{'s' * (study.draws != 1)}"
    where = f" at each of {points} points" if points > 1 else ""
    most = ", at most" if study.stop is not None else ""
    return f"{study.count} members: {draws}{where}{most}"


def self_contained(text: str, machine: Machine | ChamberMachine) -> str:
    """The text of a machine that needs no file beside it."""
    try:
        data = tomllib.loads(text)
    except ValueError:
        return machine_text(machine)
    return machine_text(machine) if next(files_in(data), None) is not None else text


# What is wrong with the text of a design's specification, key by key, in the words of its reader.


DESIGN_CANDIDATES_MOST = 2000  # runs of a candidate on the page
Find = Callable[[str], Path | None]  # a measured file of the user by its name


@dataclass(frozen=True)
class DesignReading:
    """A text that was read: the specification, or what is wrong with it and the key where."""

    of: NamedMachine
    spec: Spec | ChamberSpec | None = None
    message: str = ""
    problems: dict[str, str] = field(default_factory=dict)  # by their keys
    measured: Path | None = None  # the receptance that it names


def read_design_text(text: str, page: str, find: Find = lambda _name: None) -> DesignReading:
    """Read the text of a specification; ``page`` is the text of the machine of the page.

    What is wrong is an answer, not an error. ``find`` gives measured files of the user; those of the package are known.
    """
    data, wrong = tables_of(text)
    if data is None:
        return DesignReading(NamedMachine(), None, wrong)
    rotor = data.get("rotor")
    alone = "machine" not in data and isinstance(rotor, dict)
    of = NamedMachine(file="") if alone else named_machine(data, page, design=True)
    if of.machine is None and not alone:
        return DesignReading(of, None, of.message, {"machine": of.message})
    measured = None
    try:
        refuse_files(data)
        asked: dict[str, Any] = {**data} if alone else {**data, "machine": of.machine}
        if isinstance(rotor, dict) and "receptance" in rotor:
            measured = _measured(str(rotor["receptance"]), find)
            asked["rotor"] = {**rotor, "receptance": measured}
        if isinstance(of.machine, ChamberMachine):
            return DesignReading(of, read_chamber_spec(asked))
        spec = read_spec(asked)
        if spec.search.members > DESIGN_CANDIDATES_MOST:
            most = f"given {spec.search.members}; on the page at most {DESIGN_CANDIDATES_MOST} run"
            raise QuestionError(most, ("search", "members"))
    except AutobalancerError as error:
        return DesignReading(of, None, str(error).removeprefix("specification: "), by_key(error), measured)
    return DesignReading(of, spec, measured=measured)


def _measured(name: str, find: Find) -> Path:
    """The file of a receptance: one of the package, or of the user.

    Raises
    ------
    QuestionError
        If there is none of this name.
    """
    found = find(name)
    if found is not None:
        return found
    stem = name.rpartition(".")[0]
    if stem in sample_names("measurements") and example_path(stem).name == name:
        return example_path(stem)
    known = ", ".join(sorted(f"{one}.csv" for one in sample_names("measurements") if "hammer" in one))
    said = f"given {name[:60]!r}; name a file of the page Measured, or a sample of the package: {known}"
    raise QuestionError(said, ("rotor", "receptance"))


# Edits of a machine file as text: its comments and its order stay where they can.


EntryPath = KeyPath
EMPTY = """name = "New machine"
axis = "horizontal"

[rotor]
kind = "planar"

[[unbalances]]

[[balancers]]

[[balancers.races]]

[balancers.races.fluid]

[balancers.races.drag]
law = "discoidal"

[[balancers.races.balls]]
count = 2
material = "steel"

[drive]
kind = "speed"

[drive.profile]
kind = "ramp"

[run]
duration = "10 s"
"""


def data_of(text: str) -> dict[str, Any] | None:
    """The tables of a text; ``None`` if it is not TOML."""
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError):
        return None


def value_at(data: Any, path: EntryPath) -> Any:
    """What stands at a path; ``None`` if nothing does."""
    for step in path:
        if isinstance(step, str):
            data = data.get(step) if isinstance(data, dict) else None
        elif isinstance(data, list):
            data = data[step] if step < len(data) else None
        elif step != 0:  # one entry stands for a list of one
            return None
    return data


def with_value(text: str, path: EntryPath, value: Any) -> str:
    """The text with another value at a path; tables on the way are made."""

    def change(owner: Any) -> None:
        owner[path[-1]] = value

    return _changed(text, path[:-1], change)


def without(text: str, path: EntryPath) -> str:
    """The text without the key or the entry of a list at a path; a list that becomes empty goes with it."""

    def change(owner: Any) -> None:
        if isinstance(owner, dict) or isinstance(path[-1], int):
            del owner[path[-1]]

    where = path
    if isinstance(path[-1], int):
        held = value_at(data_of(text) or {}, path[:-1])
        if not isinstance(held, list) or len(held) == 1:
            where = path[:-1]
    return _changed(text, where[:-1], change if where is path else lambda owner: owner.__delitem__(where[-1]))


def with_entry(text: str, path: EntryPath, entry: dict[str, Any]) -> str:
    """The text with one more entry at the end of a list of tables."""

    def change(owner: Any) -> None:
        held = owner.get(path[-1])
        if held is None:
            owner[path[-1]] = [entry]
        elif isinstance(held, list):
            held.append(entry)
        else:
            owner[path[-1]] = [held.unwrap() if hasattr(held, "unwrap") else held, entry]

    return _changed(text, path[:-1], change)


def _changed(text: str, path: EntryPath, change: Callable[[Any], None]) -> str:
    """Change the owner at ``path``, in the text with its comments; without them where that does not give the same machine."""
    plain = deepcopy(tomllib.loads(text))
    change(_owner(plain, path))
    try:
        import tomlkit

        document: Any = tomlkit.parse(text)
        change(_owner(document, path))
        found = tomlkit.dumps(document)
        if tomllib.loads(found) == plain:
            return found
    except Exception:
        pass  # what keeps comments is a convenience; the plain way is always possible
    return tomli_w.dumps(plain)


def _owner(data: Any, path: Sequence[str | int]) -> Any:
    for step in path:
        if isinstance(step, int):
            data = data[step] if isinstance(data, list) else data
        else:
            data = data.setdefault(step, {})
    return data
