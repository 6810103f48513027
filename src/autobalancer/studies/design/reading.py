"""Specification files: TOML, or the same as a dict, turned into a specification; every fault is named with its key."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from autobalancer.assembly.profile import highest_prescribed
from autobalancer.assembly.quantities import changed_part
from autobalancer.catalog.bearing_table import bearing
from autobalancer.errors import AutobalancerError, QuestionError, UnitError
from autobalancer.files.examples import rig, rigs
from autobalancer.files.machine_file import balls_in_races
from autobalancer.files.samples import beside
from autobalancer.files.text import read_toml
from autobalancer.machine import Machine, PrescribedSpeed, Unbalance
from autobalancer.machine.bare_numbers import bare_entry
from autobalancer.machine.drive import Constant
from autobalancer.machine.part import unknown_key
from autobalancer.results.number_text import moment_text
from autobalancer.results.recorded import SETTLING_FROM
from autobalancer.results.shares import wilson_interval
from autobalancer.rotordynamics.receptance.answer import FittedReceptance
from autobalancer.rotordynamics.receptance.measured import hertz, load_receptance
from autobalancer.rotordynamics.receptance.rational_fit import receptance
from autobalancer.rotordynamics.receptance.rotor import MeasuredRotor, measured_rotor, said_of, with_measured_rotor
from autobalancer.studies.design.spec import (
    ENOUGH,
    MARGIN,
    MEASURED,
    OBJECTIVES,
    PRESSURE,
    SHARE,
    STALL,
    Filling,
    Operation,
    Options,
    Search,
    Space,
    Spec,
    blended,
    known_fluid,
)
from autobalancer.studies.study.reading import number, one_of, whole
from autobalancer.tables import rpm_and_si
from autobalancer.units import argument, shortened
from autobalancer.units.quantity import list_argument

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
    measured = read_rotor(_table(data, "rotor", MEASURED_KEYS), folder) if "rotor" in data else None
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


# What a specification asks for that cannot be had together; both keys are named.


def refuse_contradictions(spec: Spec) -> None:
    """Refuse what no design can keep.

    Raises
    ------
    QuestionError
        With the two keys that contradict each other.
    """
    ends: list[tuple[str, float, float, Callable[[float], str]]]
    ends = [("unbalance", *spec.unbalance, moment_text), ("temperature", *spec.temperature, _celsius)]
    for name, low, high, said in ends:
        if low > high:
            given = f"given {said(low)} and {said(high)}"
            raise QuestionError(
                f"{name}.from and {name}.to contradict each other: {given}; 'from' must not be above 'to'"
            )
    space = spec.space
    if not space.bore + 2.0 * space.wall < space.outer:
        raise QuestionError(
            f"space.bore and space.outer contradict each other: a bore of {1e3 * space.bore:g} mm leaves no room within an outer "
            f"diameter of {1e3 * space.outer:g} mm"
        )
    _enough_members(spec)
    settling, hold = spec.limits.get("settling_time"), spec.operation.hold
    if settling is not None and hold and settling > hold:
        raise QuestionError(
            f"limits.settling_time and operation.hold contradict each other: after the run-up the speed is held for {hold:g} s, "
            f"which cannot show a settling time of {settling:g} s; hold it longer"
        )
    if spec.measured is not None:
        refuse_beyond(spec.measured, spec.fastest)
    _fast_enough(spec)


def _celsius(temperature: float) -> str:
    return f"{temperature - 273.15:.4g} °C"


def _enough_members(spec: Spec) -> None:
    """Shares that so few runs can never show, even without a single failure."""
    members = spec.search.members
    _, most = wilson_interval(np.array([0]), members)
    for key, allowed in ((STALL, spec.limits.get(STALL)), (SHARE, 1.0 - spec.share)):
        if allowed is not None and float(most[0]) > allowed:
            needed = math.ceil(1.959964**2 * (1.0 - allowed) / allowed)
            raise QuestionError(
                f"limits.{key} and search.members contradict each other: {members} runs without a failure still leave a share of "
                f"{100.0 * float(most[0]):.3g} % possible (95 %), and {100.0 * allowed:.3g} % is asked for; take {needed} members"
            )


def _fast_enough(spec: Spec) -> None:
    """No border lies below the lowest critical speed of rotor and supports."""
    margin = spec.limits.get(MARGIN)
    if margin is None or not spec.machine.balancers:
        return
    from autobalancer.rotordynamics.campbell import critical_speeds

    found = critical_speeds(spec.machine)["critical_speed"].values
    if found.size and spec.slowest < (1.0 + margin) * float(found[0]):
        raise QuestionError(
            f"limits.{MARGIN} and operation.speed contradict each other: balls balance above the critical speed of "
            f"{rpm_and_si(float(found[0]))} only, and {100.0 * margin:g} % above it is more than {rpm_and_si(spec.slowest)}"
        )


# The candidates of a specification: races of the catalog or free ones, balls, fluids, how many races and which
# planes.


OPTION_READING_KEYS = (
    "bearings",
    "orbit_radius",
    "ball_diameter",
    "count",
    "fluids",
    "races",
    "planes",
    "material",
    "density",
    "drag",
)
SIZES = {"orbit_radius": "m", "ball_diameter": "m"}
EXAMPLE = 'fluids = ["silicone oil 5", "silicone oil 20"]'


def read_options(machine: Machine, given: Any) -> Options:
    """What there is to choose from.

    Raises
    ------
    QuestionError
        For unknown names and keys, empty lists, sizes that make no sense.
    """
    if not isinstance(given, Mapping) or not given:
        raise QuestionError(f"candidates: missing or no table; say what there is to choose from, such as {EXAMPLE}")
    for key in given:
        if key not in OPTION_READING_KEYS:
            raise QuestionError(f"candidates.{key}: {unknown_key(key, sorted(OPTION_READING_KEYS))}")
    if "bearings" in given and set(SIZES) & set(given):
        raise QuestionError(
            "candidates: 'bearings' have their own sizes; give them, or 'orbit_radius' and 'ball_diameter'"
        )
    if len(set(SIZES) & set(given)) == 1 and not machine.balancers:
        raise QuestionError(
            "candidates: 'orbit_radius' and 'ball_diameter' belong together; the machine has no race to take one from"
        )
    if not machine.balancers and not set(given) & {"bearings", *SIZES}:
        raise QuestionError(
            "candidates: the machine has no race; give 'bearings', or 'orbit_radius' and 'ball_diameter'"
        )
    if not machine.balancers and "drag" not in given:
        raise QuestionError(
            'candidates.drag: missing, and the machine has no race to take it from; such as { law = "cd_re", cd_re = 387 }'
        )
    free, sizes = [], {}
    for name, unit in SIZES.items():
        found = _size(name, given.get(name), unit)
        if isinstance(found, list):
            sizes[name] = tuple(found)
        else:
            free.append((name, *found))
    fillings, blend, blends = _fluids(given.get("fluids"))
    races = _whole("races", given.get("races", [1]))
    _fluids_for_races(fillings, races)
    return Options(
        bearings=_bearings(given.get("bearings", ())),
        orbit_radii=sizes.get("orbit_radius", ()),
        ball_diameters=sizes.get("ball_diameter", ()),
        counts=() if given.get("count", "fewest") == "fewest" else _whole("count", given["count"]),
        fluids=fillings,
        races=races,
        planes=_planes(machine, given.get("planes")),
        balls={key: given[key] for key in ("material", "density") if key in given},
        drag=dict(given["drag"]) if "drag" in given else None,
        free=(*free, *blends),
        blend=blend,
    )


def _size(name: str, given: Any, unit: str) -> list[float] | tuple[float, float]:
    if isinstance(given, Mapping):
        if set(given) != {"from", "to"}:
            raise QuestionError(
                f"candidates.{name}: given {shortened(dict(given))}; must be values, or a table with 'from' and 'to'"
            )
        low, high = (argument(f"candidates.{name}.{end}", given[end], unit) for end in ("from", "to"))
        if not 0.0 < low < high:
            raise QuestionError(f"candidates.{name}: 'from' must be above zero and below 'to'")
        return low, high
    found = [] if given is None else list_argument(f"candidates.{name}", given, unit)
    if given is not None and (not found or not min(found) > 0.0):
        raise QuestionError(f"candidates.{name}: given {shortened(given)}; give one or more values above zero")
    return found


def _bearings(given: Any) -> tuple[str, ...]:
    if given == "all":
        from autobalancer.catalog.bearing_table import bearings

        return tuple(one.designation for one in bearings())
    names = _listed("bearings", given, "designations of the catalog, or 'all'") if given != () else ()
    return tuple(bearing(str(name)).designation for name in names)


def _whole(name: str, given: Any) -> tuple[int, ...]:
    values = given if isinstance(given, (list, tuple)) else [given]
    if not values or any(isinstance(one, bool) or not isinstance(one, int) or one < 1 for one in values):
        raise QuestionError(f"candidates.{name}: given {shortened(given)}; give whole numbers, 1 or more")
    return tuple(dict.fromkeys(values))


def _planes(machine: Machine, given: Any) -> tuple[tuple[str, ...], ...]:
    """Choices of stations that hold a balancer each; an empty one keeps the balancers of the machine."""
    if given is None:
        stations = tuple(str(one.station) for one in machine.balancers if one.station is not None)
        if machine.balancers or machine.rotor.kind in ("planar", "modal"):
            return ((),)
        raise QuestionError(f"candidates.planes: missing; name the stations that may hold a balancer{stations or ''}")
    known = [one.name for one in machine.stations]
    choices = _listed("planes", given, "lists of stations")
    found = []
    for choice in choices:
        names = (choice,) if isinstance(choice, str) else tuple(map(str, choice))
        for name in names:
            if name not in known:
                said = ", ".join(map(repr, known)) or "none"
                raise QuestionError(f"candidates.planes: no station is called {name!r}; there are {said}")
        found.append(names)
    return tuple(found)


def _listed(name: str, given: Any, wanted: str) -> list[Any]:
    if not isinstance(given, (list, tuple)) or not given:
        raise QuestionError(f"candidates.{name}: given {shortened(given)}; must be a list of {wanted}")
    return list(given)


def _fluids(
    given: Any,
) -> tuple[tuple[tuple[Filling, ...], ...], tuple[str, str] | None, list[tuple[str, float, float]]]:
    """Choices of fluids; the pair of oils whose blend is searched, with its viscosities at 25 °C."""
    if given is None:
        return (), None, []
    found: list[tuple[Filling, ...]] = []
    blend, free = None, []
    for place, entry in enumerate(_listed("fluids", given, f"names, as in {EXAMPLE}"), start=1):
        where = f"candidates.fluids[{place}]"
        if isinstance(entry, Mapping) and isinstance(entry.get("viscosity"), Mapping):
            if len(given) > 1:
                raise QuestionError(f"{where}: a blend with 'from' and 'to' stands alone")
            blend, ends = _pair(where, entry), _size("fluids", entry["viscosity"], "m^2/s")
            low, high = (float(one) for one in ends)
            for viscosity in (low, high):
                blended(*blend, viscosity)  # refuses what the two cannot make
            free.append(("viscosity", low, high))
        elif isinstance(entry, Mapping):
            oils = _pair(where, entry)
            found += [(blended(*oils, one),) for one in list_argument(where, entry["viscosity"], "m^2/s")]
        else:
            names = (
                [entry] if isinstance(entry, str) else _listed(f"fluids[{place}]", entry, "names, one for each race")
            )
            found.append(tuple(Filling(known_fluid(where, str(name))) for name in names))
    return tuple(dict.fromkeys(found)), blend, free


def _pair(where: str, entry: Mapping[str, Any]) -> tuple[str, str]:
    oils = entry.get("blend")
    if set(entry) != {"blend", "viscosity"} or not isinstance(oils, (list, tuple)) or len(oils) != 2:
        raise QuestionError(
            f"{where}: given {shortened(dict(entry))}; a blend has 'blend', two oils, and 'viscosity' at 25 °C"
        )
    return known_fluid(where, str(oils[0])), known_fluid(where, str(oils[1]))


def _fluids_for_races(fillings: tuple[tuple[Filling, ...], ...], races: tuple[int, ...]) -> None:
    for choice in fillings:
        if len(choice) > 1 and len(choice) not in races:
            raise QuestionError(
                f"candidates.fluids: {', '.join(one.label for one in choice)} are fluids of {len(choice)} races, and 'races' is "
                f"{list(races)}; allow {len(choice)} there"
            )


# The rotor of a specification from a measured receptance: read, fitted, and refused where it was not measured.


MEASURED_KEYS = ("receptance", "band", "modes", "function", "mass_added", "inertia")
PREFIX = "rotor_"  # of names in the answer of a design
KEPT = ("title", "fit_error", "free_error", "modes", "band_low", "band_high", "warnings", "noise")


def read_rotor(table: Mapping[str, Any], folder: Path) -> MeasuredRotor:
    """Read a measured receptance and fit a rotor to it; paths are seen from ``folder``.

    Raises
    ------
    QuestionError
        With the key at fault; if no rotor has such a receptance, or its lowest mode was not measured.
    ResultError
        If the file cannot be read.
    """
    if not isinstance(table.get("receptance"), (str, Path)):
        raise QuestionError(
            f"rotor.receptance: given {shortened(table.get('receptance'))}; give the file of a measured frequency response, "
            'such as receptance = "hammer.csv"'
        )
    counts = {key: whole(f"rotor.{key}", table[key], 1) for key in ("modes", "function") if key in table}
    try:
        measured = load_receptance(
            beside(folder, table["receptance"]), function=counts.get("function"), mass_added=table.get("mass_added")
        )
        fit = receptance(measured, modes=counts.get("modes"), band=table.get("band"))
        found = measured_rotor(fit, inertia=table.get("inertia"))
    except QuestionError as reason:
        raise QuestionError(f"rotor: {reason}") from None
    low, lowest = float(found.fit.attrs["band_low"]), float(found.fit["mode_frequency"].values[0])
    if lowest < low:
        raise QuestionError(
            f"rotor.receptance: the lowest mode, at {hertz(lowest)} Hz, lies below what was measured, from {hertz(low)} Hz "
            "on; a run-up passes it, so measure from lower frequencies on"
        )
    return found


def with_rotor(machine: Machine | None, measured: MeasuredRotor, name: str) -> Machine:
    """A machine with the measured rotor in place of its own; without one a machine that is nothing but this rotor.

    Raises
    ------
    QuestionError
        If the machine has what a rotor known in one plane cannot carry.
    """
    if machine is None:
        still = PrescribedSpeed(profile=Constant(speed=0.0))
        machine = Machine(name=name, axis="vertical", rotor=measured.rotor, drive=still)
    return with_measured_rotor(machine, measured)


def with_some_unbalance(machine: Machine, size: float) -> Machine:
    """The machine itself, or with an unbalance (kg m) if it has none that could be changed."""
    if machine.unbalances:
        return machine
    changed: Machine = changed_part(machine, unbalances=(Unbalance(moment=size),))
    return changed


def refuse_beyond(fit: FittedReceptance, fastest: float) -> None:
    """Refuse speeds (rad/s) whose frequency was not measured.

    Raises
    ------
    QuestionError
        With both keys.
    """
    high = float(fit.attrs["band_high"])
    if fastest > high * (1.0 + 1e-6):
        raise QuestionError(
            f"operation.speed and rotor.receptance contradict each other: {rpm_and_si(fastest)} are {hertz(fastest)} Hz, and the "
            f"receptance is known up to {hertz(high)} Hz; measure further, or run slower"
        )


def labelled(fit: FittedReceptance) -> tuple[dict[str, Any], dict[str, Any]]:
    """Variables and attributes under names that no other of a design has."""
    variables = {f"{PREFIX}{name}": fit[name].rename(None) for name in map(str, fit.data_vars)}
    return variables, {f"{PREFIX}{name}": fit.attrs[name] for name in KEPT if name in fit.attrs} | {
        "rotor": said_of(fit)
    }


def read_back(designs: Any) -> FittedReceptance | None:
    """The fit in the answer of a design; None if its rotor was no measured one."""
    if f"{PREFIX}receptance_real" not in designs:
        return None
    names = {name: str(name)[len(PREFIX) :] for name in designs.data_vars if str(name).startswith(PREFIX)}
    attrs = {str(name)[len(PREFIX) :]: value for name, value in designs.attrs.items() if str(name).startswith(PREFIX)}
    found = designs[list(names)].rename(names)
    found.attrs = {**attrs, "rotor": designs.attrs["rotor"], "modes": int(np.asarray(attrs["modes"]))}
    return FittedReceptance.of(found)
