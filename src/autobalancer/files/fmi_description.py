"""The description of an exported machine by the standard FMI (2.0 and 3.0), and its archive."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

from autobalancer.results.labels import Variable
from autobalancer.safe_file import write_safely

# value references, as in fmi.c
FIRST = {
    "state": 1000,
    "rate": 2000,
    "output": 3000,
    "parameter": 4000,
    "input": 5000,
    "indicator": 6000,
}  # value references, as in fmi.c
FOLDERS = {
    "2.0": {"linux": "linux64", "windows": "win64"},
    "3.0": {"linux": "x86_64-linux", "windows": "x86_64-windows"},
}
ENDINGS = {"linux": ".so", "windows": ".dll"}
_BASE = {
    "kg": {"kg": 1}, "m": {"m": 1}, "s": {"s": 1}, "rad": {"rad": 1}, "K": {"K": 1}, "Hz": {"s": -1},
    "N": {"kg": 1, "m": 1, "s": -2}, "Pa": {"kg": 1, "m": -1, "s": -2}, "J": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
}  # fmt: skip


class Description(NamedTuple):
    """What an importer is told of the whole."""

    identifier: str  # of files
    name: str
    token: str
    version: str
    end: float
    tolerance: float
    indicators: int = 0  # of events, for an importer that integrates it


def write_unit(
    out: Path,
    folder: Path,
    about: Description,
    states: Sequence[Variable],
    outputs: Sequence[Variable],
    parameters: Sequence[Variable],
    inputs: Sequence[Variable],
    libraries: Mapping[str, Path],
) -> None:
    """The archive with description, libraries and sources, which stand in a folder."""
    description = model_description(about, states, outputs, parameters, inputs)

    def write(path: Path) -> None:
        with ZipFile(path, "w", ZIP_DEFLATED) as archive:
            _add(archive, "modelDescription.xml", description.encode())
            for system, library in libraries.items():
                place = f"binaries/{FOLDERS[about.version][system]}/{about.identifier}{ENDINGS[system]}"
                _add(archive, place, library.read_bytes())
            for source in sorted(folder.iterdir()):
                if source.suffix in (".c", ".h", ".ll"):
                    _add(archive, f"sources/{source.name}", source.read_bytes())

    write_safely(out, write)


def _add(archive: ZipFile, name: str, content: bytes) -> None:
    """An entry without the time at which it was made, so that the same machine gives the same file."""
    entry = ZipInfo(name)
    entry.compress_type, entry.external_attr = ZIP_DEFLATED, 0o644 << 16
    archive.writestr(entry, content)


def model_description(
    about: Description,
    states: Sequence[Variable],
    outputs: Sequence[Variable],
    parameters: Sequence[Variable],
    inputs: Sequence[Variable],
) -> str:
    """``modelDescription.xml``."""
    three = about.version == "3.0"
    root = ElementTree.Element("fmiModelDescription", {
        "fmiVersion": about.version, "modelName": about.name or about.identifier,
        "instantiationToken" if three else "guid": about.token,
        "description": "Rotor with an automatic ball balancer", "generationTool": "autobalancer",
        "variableNamingConvention": "flat",
    })  # fmt: skip
    if not three:
        root.set("numberOfEventIndicators", str(about.indicators))
    able = {"canGetAndSetFMUState" if three else "canGetAndSetFMUstate": "true",
            "canSerializeFMUState" if three else "canSerializeFMUstate": "true",
            "providesDirectionalDerivatives" if three else "providesDirectionalDerivative": "true"}  # fmt: skip
    ElementTree.SubElement(root, "ModelExchange", {"modelIdentifier": about.identifier, **able})
    ElementTree.SubElement(
        root,
        "CoSimulation",
        {"modelIdentifier": about.identifier, "canHandleVariableCommunicationStepSize": "true", **able},
    )
    _units(
        root, {v.unit for v in (*states, *outputs, *parameters, *inputs)} | {_rate(v.unit) for v in states} | {"s", "1"}
    )
    ElementTree.SubElement(
        root, "DefaultExperiment", {"startTime": "0", "stopTime": repr(about.end), "tolerance": repr(about.tolerance)}
    )
    # all numbers in one list: time, states, rates, outputs, parameters, input
    listed = ElementTree.SubElement(root, "ModelVariables")
    add = _listed_3 if three else _listed_2
    add(listed, Variable("time", "s", "time"), 0, causality="independent", variability="continuous")
    for number, state in enumerate(states):
        add(listed, state._replace(start=math.nan), FIRST["state"] + number, causality="local", variability="continuous",
            initial="calculated")  # fmt: skip
    for number, state in enumerate(states):
        rate = Variable(f"der({state.name})", _rate(state.unit), f"rate of {state.name}", math.nan)
        add(listed, rate, FIRST["rate"] + number, causality="local", variability="continuous", initial="calculated",
            derivative=str(FIRST["state"] + number if three else 2 + number))  # fmt: skip
    for number, output in enumerate(outputs):
        add(listed, output._replace(start=math.nan), FIRST["output"] + number, causality="output", variability="continuous",
            initial="calculated")  # fmt: skip
    for number, parameter in enumerate(parameters):
        add(listed, parameter, FIRST["parameter"] + number, causality="parameter", variability="fixed", initial="exact")
    for number, variable in enumerate(inputs):
        add(listed, variable, FIRST["input"] + number, causality="input", variability="continuous")
    for number in range(about.indicators if three else 0):
        indicator = Variable(
            f"event_indicator[{number + 1}]", "1", "positive until a ball stops, leaves or touches", math.nan
        )
        add(
            listed,
            indicator,
            FIRST["indicator"] + number,
            causality="local",
            variability="continuous",
            initial="calculated",
        )
    _structure(root, len(states), len(outputs), about.indicators if three else 0, three)
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def _rate(unit: str) -> str:
    return "1/s" if unit in ("", "1") else f"{unit}/s" if "/s" not in unit else f"{unit}^2"


def _listed_2(listed: ElementTree.Element, variable: Variable, reference: int, **kinds: str) -> None:
    derivative = kinds.pop("derivative", None)
    its = ElementTree.SubElement(
        listed, "ScalarVariable",
        {"name": variable.name, "valueReference": str(reference), "description": variable.meaning, **kinds},
    )  # fmt: skip
    ElementTree.SubElement(
        its, "Real", {**_numbers(variable, kinds), **({"derivative": derivative} if derivative else {})}
    )


def _listed_3(listed: ElementTree.Element, variable: Variable, reference: int, **kinds: str) -> None:
    if kinds["causality"] == "independent":
        kinds.pop("initial", None)
    names = {"name": variable.name, "valueReference": str(reference), "description": variable.meaning}
    ElementTree.SubElement(listed, "Float64", {**names, **kinds, **_numbers(variable, kinds)})


def _numbers(variable: Variable, kinds: Mapping[str, str]) -> dict[str, str]:
    """Unit, bounds and start."""
    found = {"unit": variable.unit or "1"}
    found |= {"min": repr(variable.least)} if math.isfinite(variable.least) else {}
    found |= {"max": repr(variable.greatest)} if math.isfinite(variable.greatest) else {}
    given = kinds.get("initial") == "exact" or kinds["causality"] == "input"
    return found | ({"start": repr(variable.start)} if given else {})


def _structure(root: ElementTree.Element, states: int, outputs: int, indicators: int, three: bool) -> None:
    structure = ElementTree.SubElement(root, "ModelStructure")
    references = {
        "Output": range(FIRST["output"], FIRST["output"] + outputs),
        "ContinuousStateDerivative": range(FIRST["rate"], FIRST["rate"] + states),
    }
    initial = [
        *range(FIRST["state"], FIRST["state"] + states),
        *references["ContinuousStateDerivative"],
        *references["Output"],
    ]
    if three:
        events = range(FIRST["indicator"], FIRST["indicator"] + indicators)
        for kind, these in {**references, "InitialUnknown": initial, "EventIndicator": events}.items():
            for reference in these:
                ElementTree.SubElement(structure, kind, {"valueReference": str(reference)})
        return
    # version 2 counts places in the list, from 1: time, states, rates, outputs
    places = {
        "Outputs": range(2 + 2 * states, 2 + 2 * states + outputs),
        "Derivatives": range(2 + states, 2 + 2 * states),
        "InitialUnknowns": range(2, 2 + 2 * states + outputs),
    }
    for kind, these in places.items():
        each = ElementTree.SubElement(structure, kind)
        for place in these:
            ElementTree.SubElement(each, "Unknown", {"index": str(place)})


def _units(root: ElementTree.Element, names: Iterable[str]) -> None:
    """Each unit with its exponents of the base units, as far as they are known."""
    listed = ElementTree.SubElement(root, "UnitDefinitions")
    for name in sorted({name or "1" for name in names}):
        its = ElementTree.SubElement(listed, "Unit", {"name": name})
        powers = _powers(name)
        if powers is not None:
            ElementTree.SubElement(its, "BaseUnit", {base: str(power) for base, power in powers.items() if power})


def _powers(unit: str) -> dict[str, int] | None:
    """Exponents of ``kg m^2/s`` and the like; None for anything else."""
    found: dict[str, int] = {}
    for sign, part in zip((1, -1), unit.split("/", 1), strict=False):
        for word in re.split(r"[ *]+", part.strip("() ")):
            match = re.fullmatch(r"([A-Za-z]+)(?:\^(-?\d+))?|1", word)
            if match is None or (match[1] and match[1] not in _BASE):
                return None
            for base, power in (_BASE[match[1]] if match[1] else {}).items():
                found[base] = found.get(base, 0) + sign * power * int(match[2] or 1)
    return found
