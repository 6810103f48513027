"""The tables of keys of files, read off the classes that check them."""

from __future__ import annotations

import re

from autobalancer.machine import Machine
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.machine.keys import TAGS, Key, Table, keys_of, prose_of, tables_of
from autobalancer.machine.part import Part
from autobalancer.measurement.balancing.runs import BalanceJob
from autobalancer.measurement.film.setup import FilmSetup
from autobalancer.measurement.run_up_fit import RunUpFile
from autobalancer.studies.design.chambers import ChamberSpecification
from autobalancer.studies.design.specification import Specification
from autobalancer.studies.study.study_file import StudyFile
from autobalancer.units.trade import WORDS

HEAD = "| key | value | default | meaning |\n|---|---|---|---|\n"

ROOTS: dict[str, type[Part]] = {
    "machine_keys.md": Machine,
    "chamber_keys.md": ChamberMachine,
    "design_keys.md": Specification,
    "chamber_design_keys.md": ChamberSpecification,
    "study_keys.md": StudyFile,
    "film_keys.md": FilmSetup,
    "balancing_keys.md": BalanceJob,
    "measurement_keys.md": RunUpFile,
}


def pages() -> dict[str, str]:
    """What the documentation includes."""
    return {name: machine_keys(root) for name, root in ROOTS.items()} | {
        "force_place.md": place_of_a_ball(),
        "units.md": units(),
    }


def units() -> str:
    """Every word that is read as a unit; the first of each meaning has the prefixes."""
    rows = ""
    for kind, meanings in WORDS.items():
        words = "; ".join(" ".join(f"`{word}`" for word in spellings.split()) for spellings, *_ in meanings)
        prefixes = "; ".join(f"`{spellings.split()[0]}`: {before}" for spellings, _, _, before in meanings if before)
        rows += f"| {kind} | {words} | {prefixes} |\n"
    return f"| of | words | prefixes |\n|---|---|---|\n{rows}"


def place_of_a_ball() -> str:
    """What a force on a ball is given."""
    from autobalancer.kernels.records import PLACE

    rows = "".join(f"| `{field.name}` | {field.unit} | {field.meaning} |\n" for field in PLACE.fields)
    return f"| field | unit | meaning |\n|---|---|---|\n{rows}"


def machine_keys(root: type[Part]) -> str:
    """One section for each table of the file, in the order in which the classes contain each other."""
    return "".join(_section(table) for table in tables_of(root))


def _section(table: Table) -> str:
    one = len(table.parts) == 1
    lead = f"{_prose(table.parts[0])}\n\n" if one else ""
    rows = "".join(_row(key, one) for part in table.parts for key in keys_of(part))
    return f"### {f'`{table.header}`' if table.header else 'At the top'}\n\n{lead}{HEAD}{rows}\n"


def _row(key: Key, one: bool) -> str:
    if key.name in TAGS:
        meaning = "the only one so far" if one else _code(key.meaning)
        return f"| **`{key.name} = {key.value}`** | | | {meaning} |\n"
    return f"| `{key.name}` | {_words(key.value)} | {_words(key.default)} | {key.meaning} |\n"


def _words(text: str) -> str:
    """Words that are typed as they stand, as code."""
    return re.sub(r'"\S+"|\b(true|false)\b', lambda found: f"`{found[0]}`", text)


def _code(text: str) -> str:
    return re.sub(r"``(.+?)``", r"`\1`", text)


def _prose(part: type[Part]) -> str:
    """The docstring of a class as Markdown."""
    return "\n\n".join(" ".join(block.split()) for block in _code(prose_of(part)).split("\n\n"))
