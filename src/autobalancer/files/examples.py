"""Sample machines that come with the package, as machine files to run and to change."""

from __future__ import annotations

from autobalancer.errors import CatalogError
from autobalancer.files.machine_file import parse_machine, parse_race_machine
from autobalancer.files.samples import example_path, sample_names
from autobalancer.machine import Machine
from autobalancer.machine.chamber import ChamberMachine


def examples() -> tuple[str, ...]:
    """Names of the sample machines, ascending."""
    return sample_names("machines")


def example_text(name: str) -> str:
    """The machine file of a sample machine, to save and change.

    Raises
    ------
    CatalogError
        If there is no sample machine of this name.
    """
    if name not in examples():
        meant = f"; it is a published rig: ab.catalog.rig({name!r})" if name in rigs() else ""
        raise CatalogError(f"no sample machine is called {name!r}{meant}; there are {', '.join(examples())}")
    return example_path(name).read_text(encoding="utf-8")


def example(name: str) -> Machine | ChamberMachine:
    """A sample machine; with a deep chamber a :class:`ChamberMachine`.

    Raises
    ------
    CatalogError
        If there is no sample machine of this name.
    """
    return parse_machine(example_text(name), f"sample machine {name!r}")


# Published test rigs that come with the package, as machine files.


def rigs() -> tuple[str, ...]:
    """Names of the published rigs, ascending."""
    return sample_names("rigs")


def rig_text(name: str) -> str:
    """The text of the machine file of a published rig, to save and modify.

    Raises
    ------
    CatalogError
        If there is no rig of this name.
    """
    if name not in rigs():
        raise CatalogError(f"no published rig is called {name!r}; there are {', '.join(rigs())}")
    return example_path(name).read_text(encoding="utf-8")


def rig(name: str) -> Machine:
    """A published rig.

    Its description says where the values come from and which of them were identified.

    Raises
    ------
    CatalogError
        If there is no rig of this name.
    """
    return parse_race_machine(rig_text(name), f"rig {name!r}")
