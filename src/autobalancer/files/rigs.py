"""Published test rigs that come with the package, as machine files."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

from autobalancer.errors import CatalogError
from autobalancer.files.machine_file import parse_machine
from autobalancer.machine import Machine

_FOLDER = files("autobalancer") / "catalog" / "data" / "rigs"


def rigs() -> tuple[str, ...]:
    """Names of the published rigs, ascending."""
    return tuple(sorted(Path(entry.name).stem for entry in _FOLDER.iterdir() if entry.name.endswith(".toml")))


def rig_text(name: str) -> str:
    """The text of the machine file of a published rig, to save and modify.

    Raises
    ------
    CatalogError
        If there is no rig of this name.
    """
    if name not in rigs():
        raise CatalogError(f"no published rig is called {name!r}; there are {', '.join(rigs())}")
    return (_FOLDER / f"{name}.toml").read_text(encoding="utf-8")


def rig(name: str) -> Machine:
    """A published rig.

    Its description says where the values come from and which of them were identified.

    Raises
    ------
    CatalogError
        If there is no rig of this name.
    """
    return parse_machine(rig_text(name), f"rig {name!r}")
