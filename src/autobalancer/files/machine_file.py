"""Machine files: TOML in which every quantity is a number in SI or a string with its unit."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import Any

from autobalancer.catalog.resolve import resolve
from autobalancer.errors import MachineError, MachineFileError, QuestionError
from autobalancer.files.bounds import refuse_out_of_bounds
from autobalancer.files.profiles import with_profiles
from autobalancer.files.text import MACHINE, parsed_toml, read_text
from autobalancer.machine import Machine
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.machine.part import ImpossiblePart, Part, spell
from autobalancer.safe_file import as_path, write_text_safely

LISTED = 20  # problems named in one message
FREE_BALLS = (
    "its balls move freely in chambers, and this question is for balls in races. For chambers there are check, simulate, "
    "plot and animate, and for many runs chamber amplitudes (in Python ab.chamber.amplitudes)"
)


def load_race_machine(path: str | Path) -> Machine:
    """Read the file of a machine with ball races.

    Raises
    ------
    MachineFileError
        As :func:`load_machine`; also for a file with chambers.
    """
    return _plain_machine(load_machine(path), str(path))


def load_chamber_machine(path: str | Path) -> ChamberMachine:
    """Read the file of a machine whose balls move freely in deep chambers.

    Raises
    ------
    MachineFileError
        As :func:`load_machine`; also for a file without chambers.
    """
    found = load_machine(path)
    if not isinstance(found, ChamberMachine):
        raise MachineFileError(
            f"{path}: has no 'chambers'; this question is for deep chambers; a sample is deep_chamber"
        )
    return found


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
    return _plain_machine(parse_machine(text, source), source)


def parse_machine(text: str, source: str = "machine text", *, folder: str | Path = ".") -> Machine | ChamberMachine:
    """Like :func:`load_machine`, from a ``text``; ``source`` is named in errors, ``folder`` holds measured profiles."""
    data = parsed_toml(text, source, MachineFileError)
    refuse_out_of_bounds(data, source)
    try:
        if "chambers" in data:
            return ChamberMachine(**data)
        machine = Machine(**with_profiles(data, Path(folder), source))
        resolve(machine)
    except MachineFileError:
        raise
    except ImpossiblePart as error:
        lines = "".join(f"\n  {spell(keys, message)}" for keys, message in error.problems[:LISTED])
        if len(error.problems) > LISTED:
            lines += f"\n  and {len(error.problems) - LISTED} more"
        raise MachineFileError(f"{source}: the machine is not possible as described:{lines}") from None
    except MachineError as error:
        raise MachineFileError(f"{source}: {error}") from None
    return machine


def _plain_machine(found: Machine | ChamberMachine, source: str) -> Machine:
    if isinstance(found, ChamberMachine):
        raise MachineFileError(f"{source}: {FREE_BALLS}")
    return found


def machine_text(machine: Machine | ChamberMachine) -> str:
    """The machine as the text of a machine file; quantities keep the units in which they were written.

    Raises
    ------
    QuestionError
        If it is no machine.
    """
    import tomli_w

    if not isinstance(machine, Machine | ChamberMachine):
        raise QuestionError(
            f"machine: given a {type(machine).__name__}; wanted is a machine, as of load_machine or example"
        )
    return tomli_w.dumps(_plain(machine))


def save_machine(machine: Machine | ChamberMachine, path: str | Path) -> Path:
    """Write a machine file that :func:`load_machine` reads back as an equal machine. Returns the path.

    Raises
    ------
    ResultError
        If the file cannot be written; an existing one is replaced only when the new one is complete.
    """
    return write_text_safely(path, machine_text(machine))


def _plain(value: Any) -> Any:
    """Tables, lists, numbers and texts; only what was set, and always the kind of a part."""
    if isinstance(value, Part):
        wanted = [key for key in type(value).model_fields if key in value.model_fields_set or key in ("kind", "law")]
        return {key: _plain(getattr(value, key)) for key in wanted if getattr(value, key) is not None}
    if isinstance(value, (tuple, list)):
        return [_plain(entry) for entry in value]
    return getattr(value, "text", value)
