"""Specification files: TOML, or the same as a dict, turned into a specification; every fault is named with its key."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from autobalancer.assembly.profile import highest_prescribed
from autobalancer.errors import AutobalancerError, QuestionError, UnitError
from autobalancer.files.given import balls_in_races
from autobalancer.files.rigs import rig, rigs
from autobalancer.files.samples import beside
from autobalancer.files.text import read_toml
from autobalancer.machine import Machine
from autobalancer.machine.bare_numbers import bare_entry
from autobalancer.machine.part import unknown_key
from autobalancer.results.recorded import SETTLING_FROM
from autobalancer.studies.design.contradictions import refuse_contradictions
from autobalancer.studies.design.measured import KEYS as ROTOR
from autobalancer.studies.design.measured import read_rotor, with_rotor, with_some_unbalance
from autobalancer.studies.design.option_reading import read_options
from autobalancer.studies.design.spec import (
    ENOUGH,
    MARGIN,
    MEASURED,
    OBJECTIVES,
    PRESSURE,
    SHARE,
    STALL,
    Operation,
    Search,
    Space,
    Spec,
)
from autobalancer.studies.study.entries import number, one_of, whole
from autobalancer.units import argument, shortened
from autobalancer.units.arguments import list_argument

KEYS = (
    "machine",
    "rotor",
    "name",
    "operation",
    "unbalance",
    "space",
    "temperature",
    "limits",
    "candidates",
    "search",
    "scatter",
)
SEARCH = ("members", "budget", "generations", "objectives", "seed", "tolerance", "settling_from")
UNITS = {  # of numbers that a specification has besides those of its machine
    "operation.speed": "rad/s",
    "unbalance": "kg*m",
    "temperature": "K",
    **{f"space.{key}": "m" for key in ("bore", "outer", "width", "wall")},
    **{f"limits.{name}": unit.replace(" ", "*") for name, (_, unit, _) in MEASURED.items()},
    f"limits.{PRESSURE}": "Pa",
    **{f"candidates.{key}": "m" for key in ("orbit_radius", "ball_diameter")},
    "candidates.density": "kg/m^3",
}
ROOM = 298.15  # K


def read_spec(given: str | Path | Mapping[str, Any]) -> Spec:
    """A specification from a file or a dict of the same form.

    Raises
    ------
    QuestionError
        With the file and the key at fault, what was given, and what is allowed; for limits that contradict each other.
    MachineFileError
        If its machine cannot be read.
    """
    if isinstance(given, Mapping):
        return _named_faults("specification", dict(given), Path(), "design")
    if not isinstance(given, (str, Path)):
        raise QuestionError(f"specification: given {shortened(given)}; give the path of a file, or a dict of its form")
    path = Path(given)
    data = read_toml(path)
    return _named_faults(str(path), data, path.parent, path.stem)


def _named_faults(source: str, data: dict[str, Any], folder: Path, name: str) -> Spec:
    try:
        spec = _read(data, folder, name)
        refuse_contradictions(spec)
    except AutobalancerError as error:
        raise type(error)(f"{source}: {error}") if isinstance(error, (QuestionError, UnitError)) else error from None
    return spec


def _read(data: dict[str, Any], folder: Path, name: str) -> Spec:
    _known("", data, KEYS)
    if not {"machine", "rotor"} & set(data):
        raise QuestionError(
            'machine: missing; give the path of a machine file or the name of a published rig, such as machine = "rotor.toml", '
            "or a measured [rotor]"
        )
    machine = _machine(data["machine"], folder) if "machine" in data else None
    measured = read_rotor(_table(data, "rotor", ROTOR), folder) if "rotor" in data else None
    if measured is not None:
        machine = with_rotor(machine, measured, str(data.get("name", name)))
    assert machine is not None
    unbalance = _unbalance(machine, data.get("unbalance"))
    if measured is not None:
        machine = with_some_unbalance(machine, unbalance[1])
    return Spec(
        name=str(data.get("name", name)),
        machine=machine,
        operation=_operation(machine, _table(data, "operation", ("speed", "run_up", "hold", "coast_down"))),
        unbalance=unbalance,
        space=_space(_table(data, "space", ("bore", "outer", "width", "wall"))),
        temperature=_ends("temperature", data.get("temperature", ROOM), "K"),
        limits=_limits(_table(data, "limits", (*MEASURED, STALL, MARGIN, ENOUGH, PRESSURE, SHARE))),
        options=read_options(machine, data.get("candidates")),
        search=_search(_table(data, "search", SEARCH)),
        scatter=dict(_table(data, "scatter", None)),
        measured=measured.fit if measured is not None else None,
        remarks=_read_as(data),
    )


def _read_as(data: Mapping[str, Any]) -> tuple[str, ...]:
    """How numbers without a unit were read where that is hardly meant."""
    found = list[str]()
    for path, unit in UNITS.items():
        table, _, key = path.rpartition(".")
        entries = (data.get(table) or {}) if table else data
        found += bare_entry(table, key, entries.get(key), unit)
    return tuple(found)


def _known(where: str, table: Mapping[str, Any], allowed: Any) -> None:
    for key in table:
        if key not in allowed:
            raise QuestionError(f"{where}{key}: {unknown_key(key, sorted(allowed))}")


def _table(data: Mapping[str, Any], name: str, allowed: Any) -> Mapping[str, Any]:
    given = data.get(name, {})
    if not isinstance(given, Mapping):
        raise QuestionError(f"{name}: given {shortened(given)}; must be a table [{name}]")
    if allowed is not None:
        _known(f"{name}.", given, allowed)
    return given


def _machine(given: Any, folder: Path) -> Machine:
    if isinstance(given, str) and given in rigs():
        return rig(given)
    return balls_in_races(beside(folder, given) if isinstance(given, (str, Path)) else given)


def _operation(machine: Machine, table: Mapping[str, Any]) -> Operation:
    top = highest_prescribed(machine)
    if "speed" not in table and not (top is not None and top > 0.0):
        raise QuestionError("operation.speed: missing, and the drive of the machine names no highest speed")
    speeds = list_argument("operation.speed", table["speed"], "rad/s") if "speed" in table else [float(top or 0.0)]
    if not speeds:
        raise QuestionError("operation.speed: given no speed; give at least one")
    times = {
        key: argument(f"operation.{key}", table[key], "s") for key in ("run_up", "hold", "coast_down") if key in table
    }
    for key, value in (*(("speed", speed) for speed in speeds), *times.items()):
        if not 0.0 < value < float("inf"):
            raise QuestionError(f"operation.{key}: given {value:g}; must be greater than zero")
    if bool(times) and not {"run_up", "hold"} <= set(times):
        raise QuestionError(
            "operation: 'run_up' and 'hold' belong together; give both, or neither to take the drive of the machine"
        )
    if len(speeds) > 1 and not times:
        raise QuestionError(
            "operation.speed: several speeds need 'run_up' and 'hold', which say how the machine gets to each"
        )
    if not times and machine.run is None:
        raise QuestionError("operation: the machine has no 'run.duration'; give 'run_up' and 'hold' here")
    return Operation(tuple(sorted(set(speeds))), **times)


def _unbalance(machine: Machine, given: Any) -> tuple[float, float]:
    if given is None:
        from autobalancer.assembly.quantities import value_of

        size = value_of(machine, "unbalance")
        if not size > 0.0:
            raise QuestionError(
                'unbalance: missing, and the machine has none; give it, such as { from = "0 g*mm", to = "500 g*mm" }'
            )
        return size, size
    low, high = _ends("unbalance", given, "kg*m")
    if low < 0.0 or not high > 0.0:
        raise QuestionError(
            f"unbalance: given {shortened(given)}; sizes must not be negative, and the largest greater than zero"
        )
    return low, high


def _space(table: Mapping[str, Any]) -> Space:
    found = {key: argument(f"space.{key}", value, "m") for key, value in table.items()}
    for key, value in found.items():
        if not value >= 0.0:
            raise QuestionError(f"space.{key}: given {value:g} m; must not be negative")
    return Space(**found)


def _ends(name: str, given: Any, unit: str) -> tuple[float, float]:
    """A single value, or a table with ``from`` and ``to``."""
    if not isinstance(given, Mapping):
        value = argument(name, given, unit)
        return value, value
    if set(given) != {"from", "to"}:
        raise QuestionError(
            f"{name}: given {shortened(dict(given))}; must be one value or a table with 'from' and 'to'"
        )
    return argument(f"{name}.from", given["from"], unit), argument(f"{name}.to", given["to"], unit)


def _limits(table: Mapping[str, Any]) -> dict[str, float]:
    found = {}
    for key, value in table.items():
        found[key] = argument(f"limits.{key}", value, UNITS.get(f"limits.{key}", ""))
        most = 1.0 if key in (STALL, SHARE) else float("inf")
        if not 0.0 < found[key] < most:
            said = "between 0 and 1" if most == 1.0 else "greater than zero"
            raise QuestionError(f"limits.{key}: given {shortened(value)}; must be {said}")
        if key == ENOUGH and found[key] < 1.0:
            raise QuestionError(
                f"limits.{key}: given {shortened(value)}; it is capability over largest unbalance, 1 or more, such as 1.5"
            )
    return found


def _search(table: Mapping[str, Any]) -> Search:
    objectives = table.get("objectives", ["peak_deflection", "settling_time"])
    if not isinstance(objectives, (list, tuple)) or len(set(map(str, objectives))) != 2:
        raise QuestionError(f"search.objectives: given {shortened(objectives)}; give two of {', '.join(OBJECTIVES)}")
    for one in map(str, objectives):
        one_of("search.objectives", one, tuple(OBJECTIVES))
    return Search(
        members=whole("search.members", table.get("members", 200), 10),
        budget=whole("search.budget", table.get("budget", 60), 1),
        generations=whole("search.generations", table.get("generations", 6), 1),
        objectives=(str(objectives[0]), str(objectives[1])),
        seed=whole("search.seed", table.get("seed", 0), 0),
        tolerance=number("search.tolerance", table.get("tolerance", 1e-5), 1e-13, 1e-2),
        settling_from=one_of("search.settling_from", table.get("settling_from", SETTLING_FROM[0]), SETTLING_FROM),
    )
