"""Machine files: TOML in which every quantity is a number in SI or a string with its unit."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from autobalancer.catalog.resolve import resolve
from autobalancer.errors import MachineError, MachineFileError
from autobalancer.files.profiles import with_profiles
from autobalancer.machine import Machine
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.machine.part import ImpossiblePart, Part, spell


def load_machine(path: str | Path) -> Any:
    """Read a machine file.

    Parameters
    ----------
    path
        A TOML file; see the page on machine files for its keys.

    Returns
    -------
    Machine
        Checked as a whole: names are known to the catalogs, the balls fit into their races. A file with ``chambers`` is a
        :class:`~autobalancer.machine.chamber.ChamberMachine`.

    Raises
    ------
    MachineFileError
        With the file, every key at fault, what was given, what is allowed and what to do.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise MachineFileError(f"{path}: no such file") from None
    except (OSError, UnicodeDecodeError) as reason:
        raise MachineFileError(f"{path}: cannot be read: {reason}") from None
    return parse_machine(text, str(path), folder=path.parent)


def parse_machine(text: str, source: str = "machine text", *, folder: str | Path = ".") -> Any:
    """Like :func:`load_machine`, from a string; ``source`` is named in errors, ``folder`` holds measured profiles."""
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as reason:
        raise MachineFileError(f"{source}: not valid TOML: {reason}") from None
    try:
        if "chambers" in data:
            return ChamberMachine(**data)
        machine = Machine(**with_profiles(data, Path(folder), source))
        resolve(machine)
    except MachineFileError:
        raise
    except ImpossiblePart as error:
        lines = "".join(f"\n  {spell(keys, message)}" for keys, message in error.problems)
        raise MachineFileError(f"{source}: the machine is not possible as described:{lines}") from None
    except MachineError as error:
        raise MachineFileError(f"{source}: {error}") from None
    return machine


def machine_text(machine: Machine | ChamberMachine) -> str:
    """The machine as the text of a machine file; quantities keep the units in which they were written."""
    import tomli_w

    return tomli_w.dumps(_plain(machine))


def save_machine(machine: Machine | ChamberMachine, path: str | Path) -> Path:
    """Write a machine file that :func:`load_machine` reads back as an equal machine. Returns the path."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(machine_text(machine), encoding="utf-8")
    return path


def _plain(value: Any) -> Any:
    """Tables, lists, numbers and texts; only what was set, and always the kind of a part."""
    if isinstance(value, Part):
        wanted = [key for key in type(value).model_fields if key in value.model_fields_set or key in ("kind", "law")]
        return {key: _plain(getattr(value, key)) for key in wanted if getattr(value, key) is not None}
    if isinstance(value, (tuple, list)):
        return [_plain(entry) for entry in value]
    return getattr(value, "text", value)
