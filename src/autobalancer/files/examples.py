"""Sample machines and published rigs that come with the package, as machine files to run and to change."""

from __future__ import annotations

from autobalancer.errors import CatalogError
from autobalancer.files.machine_file import parse_machine, parse_race_machine
from autobalancer.files.samples import example_path, sample_names
from autobalancer.machine import Machine
from autobalancer.machine.chamber import ChamberMachine


def examples(kind: str = "machines") -> tuple[str, ...]:
    """Names of the sample machines, ascending; with the ``kind`` ``"rigs"`` those of the published rigs."""
    return sample_names(kind)


def example_text(name: str) -> str:
    """The machine file of a sample machine or a published rig, to save and change.

    Raises
    ------
    CatalogError
        If there is none of this name.
    """
    if name not in (*examples(), *examples("rigs")):
        known = f"{', '.join(examples())}; and the rigs {', '.join(examples('rigs'))}"
        raise CatalogError(f"no sample machine is called {name!r}; there are {known}")
    return example_path(name).read_text(encoding="utf-8")


def example(name: str) -> Machine | ChamberMachine:
    """A sample machine, with a deep chamber a :class:`ChamberMachine`; or a published rig, by its ``name``.

    The description of a rig says where the values come from and which of them were identified.

    Raises
    ------
    CatalogError
        If there is none of this name.
    """
    return parse_machine(example_text(name), f"sample machine {name!r}")


def rig(name: str) -> Machine:
    """A published rig; raises as :func:`example`."""
    return parse_race_machine(example_text(name), f"rig {name!r}")
