"""Machine files: TOML in which every quantity is a number in SI or a string with its unit."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autobalancer.catalog.resolve import resolve
from autobalancer.errors import KeyPath, MachineError, MachineFileError, Problem, QuestionError
from autobalancer.files.text_files import MACHINE, parsed_toml, read_table, read_text
from autobalancer.machine import Disk, Machine, ShaftMaterial, ShaftSegment, Support
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.machine.part import Part, quantity_of, unknown_key
from autobalancer.machine.schema import OTHERS, other_kind, schema_line
from autobalancer.machine_kinds import CHAMBERS, RACES, Kind, machine_kind
from autobalancer.safe_file import as_path, write_text_safely
from autobalancer.units import shortened


def load_race_machine(path: str | Path) -> Machine:
    """Read the file of a machine with ball races.

    Raises
    ------
    MachineFileError
        As :func:`load_machine`; also for a file with chambers.
    """
    machine: Machine = of_kind(load_machine(path), RACES, path)
    return machine


def load_machine(path: str | Path) -> Machine | ChamberMachine:
    """Read a machine file, with ball races or deep chambers.

    Parameters
    ----------
    path
        A TOML file; see the page on machine files for its keys.

    Returns
    -------
    Machine or ChamberMachine
        Checked as a whole: names are found in the catalogs, and the balls fit into their races.

    Raises
    ------
    MachineFileError
        With the file, every key at fault, what was given, what is allowed and what to do.
    """
    path = as_path(path)
    _refuse_result(path)
    return parse_machine(read_text(path, MACHINE, MachineFileError), str(path), folder=path.parent)


def _refuse_result(path: Path) -> None:
    """A result given for a machine is recognized by how it begins."""
    begin = b""
    if path.is_file():
        with contextlib.suppress(OSError), path.open("rb") as file:
            begin = file.read(4)
    if begin == b"\x89HDF" or begin[:3] == b"CDF":
        raise MachineFileError(
            f"{path}: is a result, not a machine file; 'autobalancer plot {path}' draws it, and its machine is "
            "the attribute 'machine' of load_run(path)"
        )


def parse_race_machine(text: str, source: str = "machine text") -> Machine:
    """Like :func:`parse_machine`, but refuses chambers."""
    machine: Machine = of_kind(parse_machine(text, source), RACES, source)
    return machine


def parse_machine(text: str, source: str = "machine text", *, folder: str | Path = ".") -> Machine | ChamberMachine:
    """Like :func:`load_machine`, from a ``text``; ``source`` is named in errors, ``folder`` holds measured profiles."""
    data = parsed_toml(text, source, MachineFileError)
    if kind := other_kind(data):
        noun, *_, question = OTHERS[kind]
        raise MachineFileError(
            f"{source}: is a {noun}, not a machine file; 'autobalancer {question.format(source)}' answers it, "
            f"'autobalancer check {source}' checks it"
        )
    refuse_out_of_bounds(data, source)
    try:
        machine: Machine | ChamberMachine = machine_kind(data).part(**with_profiles(data, Path(folder), source))
        if isinstance(machine, Machine):
            resolve(machine)
    except MachineFileError:
        raise
    except MachineError as error:
        raise MachineFileError.of(source, error.problems, "the machine is not possible as described") from None
    return machine


def of_kind(machine: Machine | ChamberMachine, kind: Kind, source: object) -> Any:
    """The ``machine``, if it is of a ``kind``.

    Raises
    ------
    MachineFileError, QuestionError
        If it is of another one: with its ``source``, if that is a path or a text, else as an argument.
    """
    found = machine_kind(machine)
    if found is kind:
        return machine
    if isinstance(source, str | Path):
        raise MachineFileError(f"{source}: {found.instead}")
    raise QuestionError(f"machine: {found.instead}")


def machine_text(machine: Machine | ChamberMachine) -> str:
    """The machine as the text of a machine file; quantities keep the units in which they were written.

    Raises
    ------
    QuestionError
        If it is no machine.
    """
    if not isinstance(machine, Machine | ChamberMachine):
        raise QuestionError(
            f"machine: given a {type(machine).__name__}; wanted is a machine, as of load_machine or example"
        )
    return part_text(machine)


def part_text(part: Part) -> str:
    """The text of a file that describes a part; quantities keep the units in which they were written."""
    import tomli_w

    return tomli_w.dumps(_plain(part))


def save_machine(machine: Machine | ChamberMachine, path: str | Path) -> Path:
    """Write a machine file that :func:`load_machine` reads back as an equal machine. Returns the path.

    Raises
    ------
    ResultError
        If the file cannot be written; an existing one is replaced only when the new one is complete.
    """
    text = machine_text(machine)
    return write_text_safely(
        path, schema_line(as_path(path).parent, parsed_toml(text, str(path), MachineFileError)) + text
    )


def _plain(value: Any) -> Any:
    """Tables, lists, numbers and texts; only what was set, and always the kind of a part."""
    if isinstance(value, Part):
        wanted = [key for key in type(value).model_fields if key in value.model_fields_set or key in ("kind", "law")]
        return {key: _plain(getattr(value, key)) for key in wanted if getattr(value, key) is not None}
    if isinstance(value, (tuple, list)):
        return [_plain(entry) for entry in value]
    return getattr(value, "text", value)


# Measured profiles in files beside the machine file: roundness of a race, recorded motion of the base or force.
#
# An entry ``file = "name.csv"`` is replaced by the numbers of the table before the machine is checked, so a result
# that carries its machine needs no other file.


RECORDS = {"recorded_base_motion": ("acceleration", "m/s^2"), "recorded_force": ("force", "N")}
EVEN = 1e-3  # greatest deviation of a step of the angle from the mean step, relative


def with_profiles(data: dict[str, Any], folder: Path, source: str) -> dict[str, Any]:
    """The content of a machine file with every ``file`` entry replaced by its numbers.

    Raises
    ------
    MachineFileError
        If a file is not there, or a column, its unit or a number is missing or not understood.
    """
    rotor = data.get("rotor")
    if isinstance(rotor, dict) and isinstance(rotor.get("files"), dict):
        from autobalancer.files.matrix_files import rotor_from_files

        with _problem_at(source, ("rotor", "files")):
            data["rotor"] = rotor_from_files(rotor.pop("files"), rotor, folder)
    for name, part in (("segments", ShaftSegment), ("disks", Disk), ("supports", Support)):
        if isinstance(rotor, dict) and isinstance(given := rotor.get(name), dict) and "file" in given:
            with _problem_at(source, ("rotor", name)):
                _alone(given, [key for key in given if key != "file"])
                rotor[name] = _parts(folder / str(given["file"]), part)
    for b, balancer in enumerate(_tables(data.get("balancers"))):
        for r, race in enumerate(_tables(balancer.get("races"))):
            place = ("balancers", b, "races", r, "roundness")
            given = race.get("roundness")
            if isinstance(given, dict) and "file" in given:
                with _problem_at(source, place):
                    _alone(given, ("deviations", "angle"))
                    path = folder / str(given.pop("file"))
                    angle, deviation = _columns(path, (("angle", "rad"), ("deviation", "m")))
                    given |= _even(angle, deviation, path)
    for i, entry in enumerate(_tables(data.get("excitations"))):
        if "file" in entry:
            with _problem_at(source, ("excitations", i)):
                if entry.get("kind") not in RECORDS:
                    known = ", ".join(map(repr, RECORDS))
                    raise MachineFileError(f"only the kinds {known} can be read from a file", ("file",))
                name, unit = RECORDS[entry["kind"]]
                _alone(entry, ("time", name))
                path = folder / str(entry.pop("file"))
                entry["time"], entry[name] = (
                    column.tolist() for column in _columns(path, (("time", "s"), (name, unit)))
                )
    return data


@contextlib.contextmanager
def _problem_at(source: str, path: KeyPath) -> Iterator[None]:
    """Problems of an entry at a path of a file."""
    try:
        yield
    except MachineError as error:
        raise MachineFileError.of(source, error.within(*path).problems) from None


def _tables(value: Any) -> list[dict[str, Any]]:
    entries = value if isinstance(value, list) else [value]
    return [entry for entry in entries if isinstance(entry, dict)]


def _alone(entry: dict[str, Any], others: Sequence[str]) -> None:
    both = [key for key in others if key in entry]
    if both:
        raise MachineFileError("is read from 'file'; leave one of them out", (both[0],))


def _columns(path: Path, wanted: Sequence[tuple[str, str]]) -> list[NDArray[np.float64]]:
    """The columns of a table beside the machine file, in SI."""
    example = ", ".join(f"{name} [{unit}]" for name, unit in wanted)
    try:
        table = read_table(path, example, str(path), MachineFileError)
        return [table.numbers(name, unit) for name, unit in wanted]
    except MachineFileError as error:
        raise error.within("file") from None


def _parts(path: Path, part: type[Part]) -> list[dict[str, Any]]:
    """A part for each line of a table; its columns are keys of the part, of a segment also those of its material."""
    required = [name for name, field in part.model_fields.items() if field.is_required()]
    example = ", ".join(f"{name} [{quantity_of(part, name).unit}]" for name in required if quantity_of(part, name))  # type: ignore[union-attr]
    try:
        table, entries = read_table(path, example, str(path), MachineFileError), []
        for name, (column, unit) in table.heads.items():
            inner = ShaftMaterial if part is ShaftSegment and name in ShaftMaterial.model_fields else part
            if name not in inner.model_fields or (inner is part and name == "material"):
                raise MachineFileError(f"{path}: column {name!r}: {unknown_key(name, sorted(part.model_fields))}")
            quantity = quantity_of(inner, name)
            if quantity is not None and quantity.unit and not unit:
                raise MachineFileError(f"{path}: column {name!r} has no unit; write it so: {name} [{quantity.unit}]")
            whole = inner.model_fields[name].annotation is int
            cells = table.cells(column) if quantity is None and not whole else table.values(column).tolist()
            entries.append((inner is ShaftMaterial, name, unit, whole, cells))
    except MachineFileError as error:
        raise error.within("file") from None
    rows: list[dict[str, Any]] = []
    for line in range(len(table.lines)):
        row: dict[str, Any] = {}
        for of_material, name, unit, whole, cells in entries:
            cell = cells[line]
            if cell == "" or cell != cell:  # empty: what holds without the key
                continue
            value = int(cell) if whole and cell == int(cell) else f"{cell!r} {unit}" if unit else cell
            (row.setdefault("material", {}) if of_material else row)[name] = value
        rows.append(row)
    return rows


def _even(angle: NDArray[np.float64], deviation: NDArray[np.float64], path: Path) -> dict[str, Any]:
    """One turn at equal steps; a last point that repeats the first is left out."""
    if angle.size > 2 and abs(angle[-1] - angle[0] - 2.0 * math.pi) < 1e-3 * (angle[1] - angle[0]):
        angle, deviation = angle[:-1], deviation[:-1]
    step = 2.0 * math.pi / angle.size
    miss = float(np.abs(np.diff(angle) - step).max(initial=0.0))
    if miss > EVEN * step:
        raise MachineFileError(
            f"{path}: {angle.size} angles must have equal steps of {math.degrees(step):.6g} deg over one turn, "
            f"ascending; one step differs by {math.degrees(miss):.3g} deg",
            ("file",),
        )
    return {"deviations": deviation.tolist(), "angle": float(angle[0])}


# Bounds of what a machine file may hold, looked at before anything is built from it.
#
# They are far above what a machine has, and keep a slip or a hostile file from taking hours or all memory.


NAME = 200  # characters of a text; a description may have more
DEPTH = 20  # tables within tables
ENTRIES = 1000  # tables in a list
VALUES = 200_000  # numbers in a list, such as a recorded motion
MOST_RACES = 100  # of a machine, and balancers
MOST_BALLS = 1000  # of a machine with races
MOST_FREE_BALLS = 100_000  # of a machine with chambers


def refuse_out_of_bounds(data: dict[str, Any], source: str) -> None:
    """Refuse the content of a file that is out of bounds.

    Raises
    ------
    MachineFileError
        With the place and the bound.
    """
    for problem in (*_lists_and_texts(data, ()), *_counts(data)):
        raise MachineFileError.of(source, [problem])


def _lists_and_texts(value: Any, path: KeyPath) -> Iterator[Problem]:
    if len(path) > DEPTH:
        yield path[:3], f"tables and lists are nested more than {DEPTH} deep; a machine needs fewer levels"
    elif isinstance(value, dict):
        for key, entry in value.items():
            if len(key) > NAME:
                yield path, f"a key of {len(key)} characters: {shortened(key)}; no key is that long"
            yield from _lists_and_texts(entry, (*path, key))
    elif isinstance(value, list):
        races = path[-1:] in (("balancers",), ("races",))
        tables = any(isinstance(entry, dict) for entry in value[:1])
        most = MOST_RACES if races else ENTRIES if tables else VALUES
        if len(value) > most:
            yield path, f"given a list of {len(value)} entries; at most {most} are possible"
        elif tables or any(isinstance(entry, (dict, list, str)) for entry in value):
            for number, entry in enumerate(value):
                yield from _lists_and_texts(entry, (*path, number))
    elif isinstance(value, str) and len(value) > NAME and path[-1:] != ("description",):
        yield path, f"given a text of {len(value)} characters: {shortened(value)}; at most {NAME} are possible"


def _counts(data: dict[str, Any]) -> Iterator[Problem]:
    """How many races and balls there are in all."""
    races = [race for balancer in _tables(data.get("balancers")) for race in _tables(balancer.get("races"))]
    if len(races) > MOST_RACES:
        yield ("balancers",), f"given {len(races)} races in all; at most {MOST_RACES} are possible"
    for kind, holders, most in (
        ("balancers", races, MOST_BALLS),
        ("chambers", _tables(data.get("chambers")), MOST_FREE_BALLS),
    ):
        groups = [group for holder in holders for group in _tables(holder.get("balls"))]
        counts = [group.get("count", 1) for group in groups]
        total = sum(count for count in counts if isinstance(count, int))
        if total > most:
            yield (kind,), f"given {shortened(total)} balls in all; at most {most} are possible"


# A machine as functions are given it: described, or as the path of its file; and what they say of anything else.


def any_machine(argument: Machine | ChamberMachine | str | Path) -> Machine | ChamberMachine:
    """The machine, read if ``argument`` is a path.

    Raises
    ------
    QuestionError
        If it is neither a machine nor a path.
    MachineFileError
        If the file cannot be read, or its machine is not possible.
    """
    if isinstance(argument, Machine | ChamberMachine):
        return argument
    if isinstance(argument, str | Path):
        return load_machine(argument)
    raise QuestionError(_wanted(argument))


def balls_in_races(argument: Machine | ChamberMachine | str | Path, *, rings: bool = False) -> Machine:
    """The machine with races, read if ``argument`` is a path; raises as :func:`any_machine`, also for deep chambers.

    One with rings of liquid is refused unless ``rings``.
    """
    machine: Machine = of_kind(any_machine(argument), RACES, argument)
    if machine.liquid_rings and not rings:
        raise QuestionError(
            "liquid_rings: this question does not know liquid with a free surface; liquid-response (ab.rotor.liquid_response) "
            "does, and without 'liquid_rings' this one answers for the rotor alone"
        )
    return machine


def balls_in_chambers(argument: Machine | ChamberMachine | str | Path) -> ChamberMachine:
    """The machine with deep chambers, read if ``argument`` is a path; raises as :func:`any_machine`, also for races."""
    machine: ChamberMachine = of_kind(any_machine(argument), CHAMBERS, argument)
    return machine


def _wanted(argument: object) -> str:
    kind = type(argument).__name__
    said = (
        shortened(argument)
        if isinstance(argument, int | float)
        else f"{'an' if kind[0] in 'aeiouAEIOU' else 'a'} {kind}"
    )
    return f"machine: given {said}; wanted is a machine, as of load_machine or example, or the path of a machine file"
