"""What is wrong with the text of a machine, key by key, in the words of the reader of machine files."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from autobalancer.app.text.document import data_of, with_value, without
from autobalancer.errors import AutobalancerError
from autobalancer.files.machine_file import parse_machine
from autobalancer.files.samples import example_path
from autobalancer.machine.path import path_steps

if TYPE_CHECKING:
    from autobalancer.machine import Machine
    from autobalancer.machine.chamber import ChamberMachine

SOURCE = "machine"
LINE = re.compile(r"^\s*(?:machine: )?([a-z_]+(?:\[\d+\])*(?:\.[a-z_]+(?:\[\d+\])*)*): (.+)$")
STAND_INS = {  # for keys of the rotor, the drive and the race that its drawing does not show
    "mass": "1 kg",
    "stiffness": "1 N/m",
    "damping": "1 N*s/m",
    "end": "1 rpm",
    "duration": "1 s",
    "fluid": {"name": "water"},
}
ON_THE_PAGE = (
    (r"; in Python, save must hold \w+\(\)", ""),
    (r"simulate it instead, or ask basin with random starts", "run it, or take the basin of the page Stability"),
    (r"; typical coefficients: autobalancer catalog friction", ""),
    (r"ask basin with random starts", "take the basin of the page Stability"),
)
STAGES = 4  # in which a machine is read: what belongs to a part is looked at when the part itself is right
LARGEST = 1_000_000  # characters of a text on the page


@dataclass(frozen=True)
class Reading:
    """A text that was read: the machine, or what is wrong with it."""

    machine: Machine | ChamberMachine | None
    message: str = ""
    problems: dict[tuple[str | int, ...], str] = field(default_factory=dict)


def read(text: str) -> Reading:
    """Read the text of a machine; what is wrong is an answer, not an error."""
    if len(text) > LARGEST:
        return Reading(None, f"the text has more than {LARGEST} characters; machine files are smaller")
    folder = example_path("discoidal").parent  # samples name tables beside them; no other file of the server is read
    for name in files_in(data_of(text)):
        if "/" in name or "\\" in name or not (folder / name).is_file():
            text = f"file {name[:80]!r}: on this page a machine names no files; give the numbers in the text"
            return Reading(None, text)
    try:
        return Reading(parse_machine(text, SOURCE, folder=folder))
    except AutobalancerError as error:
        return Reading(None, str(error).removeprefix(f"{SOURCE}: "), by_path(str(error)))


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
    for words, here in ON_THE_PAGE:
        text = re.sub(words, here, text)
    return text


def files_in(data: Any) -> Iterator[str]:
    """Every file that a machine names."""
    if isinstance(data, dict):
        for key, value in data.items():
            if key == "file":
                yield str(value)
            yield from files_in(value)
    elif isinstance(data, list):
        for value in data:
            yield from files_in(value)


def by_path(message: str) -> dict[tuple[str | int, ...], str]:
    """The lines of a message that begin with the path of a key, by that path."""
    found: dict[tuple[str | int, ...], str] = {}
    for line in message.splitlines():
        match = LINE.match(line)
        if match and match[1] != SOURCE:
            steps = tuple(path_steps(match[1]))
            found[steps] = f"{found[steps]}; {match[2]}" if steps in found else match[2]
    return found
