"""The candidates of a specification: races of the catalog or free ones, balls, fluids, how many races and which planes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from autobalancer.catalog.bearing_table import bearing
from autobalancer.errors import QuestionError
from autobalancer.machine import Machine
from autobalancer.machine.part import unknown_key
from autobalancer.studies.design.fluids import Filling, blended, known_fluid
from autobalancer.studies.design.spec import Options
from autobalancer.units import argument, shortened
from autobalancer.units.arguments import list_argument

KEYS = (
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
        if key not in KEYS:
            raise QuestionError(f"candidates.{key}: {unknown_key(key, sorted(KEYS))}")
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
