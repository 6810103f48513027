"""Reading the tables of the catalog, and the message for a name that none of them has."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from importlib.resources import files
from typing import Any, Literal, NoReturn

from autobalancer.errors import FRICTIONS, CatalogError, QuestionError, one_of
from autobalancer.laws import viscosity as glycerol
from autobalancer.laws.capabilities import ball_mass, capability, largest_useful_count, needed_count
from autobalancer.laws.viscosity import (
    blend_fraction,
    double_log_from_slope,
    expanded_density,
    viscosity_from_double_log,
)
from autobalancer.tables import Table
from autobalancer.units import argument, optional_argument


@cache
def rows(name: str) -> tuple[dict[str, str], ...]:
    """Rows of ``catalog/data/<name>``, column title to text."""
    text = files("autobalancer.catalog").joinpath("data", name).read_text(encoding="utf-8")
    return tuple(csv.DictReader(text.splitlines()))


def key(name: str) -> str:
    """The form in which names are compared: case and spacing do not matter."""
    return " ".join(name.lower().replace("%", " %").split())


def unknown(kind: str, argument: object, names: Iterable[str], hint: str) -> NoReturn:
    """Raise the ``CatalogError`` for a name that is not there, with the names that look like it."""
    by_key = {key(name): name for name in names}
    close = [by_key[match] for match in get_close_matches(key(str(argument)), by_key, n=4, cutoff=0.5)]
    similar = f"similar names: {', '.join(map(repr, close))}" if close else "no name is similar"
    raise CatalogError(f"no {kind} is called {argument!r}; {similar}; {hint}")


# Materials of balls: what counts is their density.


@dataclass(frozen=True)
class Material:
    """A material of balls: ``density`` in kg/m^3, where it comes from and how far it may be off."""

    name: str
    density: float
    source: str
    remark: str = ""


class Materials(Table[Material]):
    """Materials of the catalog, a tuple."""

    head = ("material", "density kg/m³", "source")

    def row(self, entry: Material) -> tuple[str, ...]:
        """Name, density and source."""
        return (entry.name, f"{entry.density:g}", entry.source)


@cache
def materials() -> Materials:
    """All materials of the catalog. Each entry names the source of its density."""
    return Materials(
        Material(row["name"], float(row["density_kg_m3"]), row["source"], row["remark"])
        for row in rows("materials.csv")
    )


def material(name: str) -> Material:
    """One material by its name, upper or lower case. Raises ``CatalogError`` with similar names."""
    material = _by_key().get(key(name))
    if material is None:
        unknown(
            "material",
            name,
            [entry.name for entry in materials()],
            "`autobalancer catalog materials` lists them",
        )
    return material


@cache
def _by_key() -> dict[str, Material]:
    return {key(entry.name): entry for entry in materials()}


# Published coefficients of friction between a ball and its race: what they were found on, and where.


NONE_GIVEN = f"no friction given: residuals are those of ideal balls{FRICTIONS}"
"""What every answer about a machine without friction says."""


@dataclass(frozen=True)
class FrictionCoefficients:
    """Rolling resistance and adherence of one pair, as in ``friction`` of a race; nan where the source has none.

    ``kind`` says how they were found: measured, fitted, inferred, or an order of magnitude only; ``conditions`` on what.
    """

    name: str
    rolling_resistance: float
    adherence: float
    kind: str
    conditions: str
    source: str
    remark: str = ""


class Frictions(Table[FrictionCoefficients]):
    """Coefficients of friction of the catalog, a tuple."""

    head = ("pair", "rolling resistance", "adherence", "found")

    def row(self, entry: FrictionCoefficients) -> tuple[str, ...]:
        """Name, coefficients, and how they were found."""
        values = (entry.rolling_resistance, entry.adherence)
        return (entry.name, *("-" if math.isnan(value) else f"{value:g}" for value in values), entry.kind)


@cache
def friction() -> Frictions:
    """All coefficients of the catalog, from the smoothest pair to the roughest. They span more than three orders of magnitude."""
    found: list[dict[str, Any]] = [*rows("friction.csv")]
    numbers = ("rolling_resistance", "adherence")
    return Frictions(
        FrictionCoefficients(**row | {name: float(row[name] or "nan") for name in numbers}) for row in found
    )


# How far off center a race may be: half of the run-out that a standard permits, for bearing rings and for turned
# parts.


RING = "half the run-out that ISO 492, class Normal, permits for a bearing ring of this size"
TURNED = "half the run-out that ISO 2768-2, class H, permits for a turned part"
TURNED_ECCENTRICITY = 50e-6  # m, for parts of any size; checked as the page on typical values says


def ring_eccentricity(diameter: float) -> float:
    """Eccentricity (m) that the permissible radial run-out of an outer ring of this diameter (m) allows.

    Radial bearings of the class Normal, ISO 492; above 800 mm the value of 800 mm. The seat of the ring adds its own.
    """
    table = _table()
    return 0.5 * next((run_out for largest, run_out in table if diameter <= largest), table[-1][1])


@cache
def _table() -> tuple[tuple[float, float], ...]:
    """Largest outside diameter and radial run-out, m; checked as the page on typical values says."""
    return tuple((1e-3 * float(row["up_to_mm"]), 1e-6 * float(row["run_out_um"])) for row in rows("ring_run_out.csv"))


# Ball bearings whose outer ring and balls may serve as a balancer.
#
# Dimensions and printed capabilities: Spannan (2021), Tables C.1 (SKF, deep groove) and C.2 (Schaeffler, thin
# section), 412 rows recovered from a machine-read text. 315 rows are verified; 97 carry at least one value that had to
# be reconstructed, and say so.


TABLE_DENSITY = 7860.0
"""Density of the steel balls in the printed capabilities [kg/m^3]: Spannan (2021), footnote of Table C.1."""

RECONSTRUCTED = "reconstructed from a damaged text"
"""Remark of every row that is not verified."""

_REMARKS = {
    "CSCC": "printed orbit radius is 1/32 in above that of a symmetric section; if it is one, the capability "
    "is 1.0 to 2.8 % high",
    "CSCG 250": "bore contradicts the designation (365 mm printed, 635 mm by the size code); outer diameter "
    "and orbit radius follow the printed bore",
}


@dataclass(frozen=True)
class Bearing:
    """One ball bearing. Lengths in m, ``capability_printed`` in kg m (steel balls of 7860 kg/m^3).

    ``verified`` is False if a value was reconstructed from a damaged text; ``remark`` gives known doubts.
    """

    designation: str
    family: str
    bore: float
    outer: float
    width: float
    orbit_radius: float
    ball_diameter: float
    capability_printed: float
    verified: bool
    remark: str = ""


@dataclass(frozen=True)
class SuitableBearing:
    """A bearing for a given unbalance: how many balls it needs and what they can do.

    ``count`` is the smallest number of balls, from two up, for the unbalance, ``capability`` [kg m] what they
    compensate and ``ball_mass`` [kg] the mass of all of them. ``largest_useful_count`` and
    ``largest_capability`` [kg m] belong to the number with the greatest capability.
    """

    bearing: Bearing
    count: int
    capability: float
    largest_useful_count: int
    largest_capability: float
    ball_mass: float


class SuitableBearings(Table[SuitableBearing]):
    """Bearings that suit, a tuple."""

    head = ("bearing", "bore mm", "outer mm", "width mm", "balls", "g mm", "most balls", "most g mm")

    def row(self, entry: SuitableBearing) -> tuple[str, ...]:
        """Designation, size, fewest balls that do and what they can balance, most balls and what those can."""
        ring = entry.bearing
        sizes = tuple(f"{1e3 * value:g}" for value in (ring.bore, ring.outer, ring.width))
        able = f"{1e6 * entry.capability:.4g}", f"{1e6 * entry.largest_capability:.4g}"
        return (ring.designation, *sizes, str(entry.count), able[0], str(entry.largest_useful_count), able[1])


_ORDER: dict[str, Callable[[SuitableBearing], float]] = {
    "outer": lambda choice: choice.bearing.outer,
    "mass": lambda choice: choice.ball_mass,
    "capability": lambda choice: choice.largest_capability,
    "orbit": lambda choice: choice.bearing.orbit_radius,
    "bore": lambda choice: choice.bearing.bore,
    "width": lambda choice: choice.bearing.width,
}


_LIMITS = {  # of which size, and in which sense
    "min_outer": ("outer", -1.0),
    "max_outer": ("outer", 1.0),
    "min_bore": ("bore", -1.0),
    "max_width": ("width", 1.0),
    "min_orbit": ("orbit_radius", -1.0),
    "max_orbit": ("orbit_radius", 1.0),
}


class Bearings(Table[Bearing]):
    """Bearings of the catalog, a tuple."""

    head = ("bearing", "family", "bore mm", "outer mm", "width mm", "orbit radius mm", "ball mm")

    def row(self, entry: Bearing) -> tuple[str, ...]:
        """Designation, family and sizes."""
        sizes = (entry.bore, entry.outer, entry.width, entry.orbit_radius, entry.ball_diameter)
        return (entry.designation, entry.family, *(f"{1e3 * size:.5g}" for size in sizes))


@cache
def bearings() -> Bearings:
    """All 412 bearings, in the order of the source. Source: Spannan (2021), Tables C.1 and C.2."""
    return Bearings(_bearing(row) for row in rows("bearings.csv"))


def bearing(designation: str) -> Bearing:
    """One bearing by its designation, such as ``"6203"``. Raises ``CatalogError`` with similar ones."""
    bearing = [entry for entry in bearings() if entry.designation.lower() == designation.strip().lower()]
    if not bearing:
        names = [entry.designation for entry in bearings()]
        unknown("bearing", designation, names, "`autobalancer catalog bearings` lists them")
    return bearing[0]


def suitable_bearings(
    unbalance: float | str,
    *,
    min_outer: float | str | None = None,
    max_outer: float | str | None = None,
    min_bore: float | str | None = None,
    max_width: float | str | None = None,
    min_orbit: float | str | None = None,
    max_orbit: float | str | None = None,
    ball_density: float | str = TABLE_DENSITY,
    fluid_density: float | str = 0.0,
    sort: str = "outer",
) -> SuitableBearings:
    """Bearings whose outer ring and balls can compensate an unbalance in a given space.

    Parameters
    ----------
    unbalance
        Unbalance to be compensated by one race [kg m].
    min_outer, max_outer, max_width, min_bore
        Space [m]; None means no limit. The inner ring is left out, so the free bore of a balancer is
        larger than the catalog bore that is compared here: the choice is on the safe side.
    min_orbit, max_orbit
        Limits of the orbit radius of the ball centers [m]; None means no limit.
    ball_density
        Density of the balls [kg/m^3]; by default that of the bearing's own steel balls in the source.
    fluid_density
        Density of the fluid around the balls [kg/m^3]; zero neglects the buoyancy.
    sort
        First ``"outer"`` diameter, ``"mass"`` of the balls, greatest ``"capability"``, ``"orbit"`` radius, ``"bore"`` or
        ``"width"``; ascending.

    Returns
    -------
    tuple of SuitableBearing
        Equal ones by outer diameter, then by mass of the balls; empty if nothing fits.

    Raises
    ------
    QuestionError
        If a value is not positive or the balls float.
    """
    ball_density = argument("ball_density", ball_density, "kg/m^3")
    fluid_density = argument("fluid_density", fluid_density, "kg/m^3")
    unbalance = argument("unbalance", unbalance, "kg*m")
    one_of("sort", sort, *_ORDER)
    asked = dict(zip(_LIMITS, (min_outer, max_outer, min_bore, max_width, min_orbit, max_orbit), strict=True))
    limits = {name: number for name in asked if (number := optional_argument(name, asked[name], "m")) is not None}
    for name, value in {"unbalance": unbalance, **limits}.items():
        if not value > 0.0:
            raise QuestionError(f"given {name} = {value!r}; write a number greater than zero, in SI units")
    suitable_bearings = []
    for entry in bearings():
        beyond = (
            sign * (getattr(entry, size) / limits[name] - 1.0)
            for name, (size, sign) in _LIMITS.items()
            if name in limits
        )
        if any(share > 1e-9 for share in beyond):
            continue
        race = (entry.orbit_radius, entry.ball_diameter, ball_density)
        greatest = capability(*race, fluid_density=fluid_density)
        if greatest < unbalance:
            continue
        count = needed_count(unbalance, *race, fluid_density=fluid_density)
        suitable_bearings.append(
            SuitableBearing(
                bearing=entry,
                count=count,
                capability=capability(*race, count, fluid_density=fluid_density),
                largest_useful_count=largest_useful_count(entry.orbit_radius, entry.ball_diameter),
                largest_capability=greatest,
                ball_mass=count * ball_mass(entry.ball_diameter, ball_density),
            )
        )
    return SuitableBearings(
        sorted(suitable_bearings, key=lambda choice: (_ORDER[sort](choice), choice.bearing.outer, choice.ball_mass))
    )


def _bearing(row: dict[str, str]) -> Bearing:
    designation = row["designation"]
    remark = _REMARKS.get(designation) or _REMARKS.get(designation.split()[0], "")
    verified = row["verified"] == "yes"
    if not verified:
        remark = "; ".join(filter(None, (RECONSTRUCTED, remark)))

    def si(column: str, unit: float) -> float:
        return float(f"{float(row[column]) * unit:.12g}")

    return Bearing(
        designation=designation,
        family=row["family"],
        bore=si("bore_mm", 1e-3),
        outer=si("outer_mm", 1e-3),
        width=si("width_mm", 1e-3),
        orbit_radius=si("orbit_radius_mm", 1e-3),
        ball_diameter=si("ball_diameter_mm", 1e-3),
        capability_printed=si("max_compensation_gmm", 1e-6),
        verified=verified,
        remark=remark,
    )


# Fluids for the race: silicone oils, mineral oils, glycerol-water, water, air, and blends of two oils.


# Where the fluids of the catalog come from: one function per family, each a tuple of sources of fluids.


ROOM = 298.15
"""Temperature of the tables of Spannan (2021) [K]."""


@dataclass(frozen=True)
class FluidEntry:
    """A fluid of the catalog: name, family, range of temperatures [K], source, and what to keep in mind."""

    name: str
    family: str
    lowest_temperature: float
    highest_temperature: float
    source: str
    remark: str = ""


Properties = Callable[[float], tuple[float, float, str]]
"""Temperature [K] to density [kg/m^3], kinematic viscosity [m^2/s] and a remark on this temperature."""

Offer = tuple[FluidEntry, Properties]


@cache
def offers() -> tuple[Offer, ...]:
    """Every fluid that has a fixed name."""
    mixtures = (glycerol_offer(float(percent), "wt") for percent in range(10, 101, 10))
    families = {
        "silicone_oils.csv": _silicone_oil,
        "experiment_fluids.csv": _experiment_fluid,
        "iso_vg_oils.csv": _mineral_oil,
    }
    oils = (offer(row) for table, offer in families.items() for row in rows(table))
    water = FluidEntry("water", "water", *glycerol.WATER_RANGE, "density Kell (1975), viscosity Pátek et al. (2009)")
    source = "U.S. Standard Atmosphere (1976): ideal gas, Sutherland's law"
    air = FluidEntry("air", "air", *glycerol.AIR_RANGE, source, "dry, at 101325 Pa")
    return (
        *oils,
        *mixtures,
        _pure(water, glycerol.water_density, glycerol.water_dynamic_viscosity),
        _pure(air, glycerol.air_density, glycerol.air_dynamic_viscosity),
    )


def glycerol_offer(percent: float, kind: str) -> Offer:
    """A glycerol-water mixture; ``kind`` is ``"wt"`` or ``"vol"`` (volumes before mixing, at 20 degC)."""
    share = percent / 100.0
    w = share if kind == "wt" else float(glycerol.glycerol_mass_fraction(share))
    entry = FluidEntry(
        f"glycerol {percent:g} {kind}%",
        "glycerol-water",
        glycerol.LOWEST,
        glycerol.HIGHEST,
        "viscosity Cheng (2008), density Volk and Kähler (2018)",
        "" if kind == "wt" else f"volumes before mixing, at 20 degC: {100.0 * w:.2f} wt%",
    )

    def properties(temperature: float) -> tuple[float, float, str]:
        density = float(glycerol.glycerol_density(w, temperature))
        remark = "" if 288.15 <= temperature <= 303.15 else "density extrapolated: law fitted from 15 to 30 degC"
        return density, float(glycerol.glycerol_dynamic_viscosity(w, temperature)) / density, remark

    return entry, properties


def _silicone_oil(row: dict[str, str]) -> Offer:
    nominal, p2 = float(row["nu_nominal_mm2_s"]) * 1e-6, float(row["P2_full"])
    p1 = double_log_from_slope(ROOM, nominal, p2)  # the nominal viscosity holds exactly at 25 degC
    at_25 = float(f"{float(row['density_25C_g_cm3']) * 1e3:.12g}")
    expansion = float(row["expansion_1e-4_per_C"]) * 1e-4 if row["expansion_1e-4_per_C"] else None
    entry = FluidEntry(
        f"silicone oil {row['nu_nominal_mm2_s']}",
        "silicone oil",
        273.15,
        373.15,
        "Spannan (2021), Table 6.1 and eq. (6.1), after Mark (1999)",
        "" if expansion else "density of 25 degC: the source has no expansion coefficient",
    )

    def properties(temperature: float) -> tuple[float, float, str]:
        density = at_25 if expansion is None else float(expanded_density(at_25, expansion, temperature))
        remark = "" if temperature >= ROOM else "viscosity extrapolated: law fitted from 25 to 99 degC"
        return density, float(viscosity_from_double_log(temperature, p1, p2)), remark

    return entry, properties


def _experiment_fluid(row: dict[str, str]) -> Offer:
    name = row["fluid"].removesuffix(" cSt")
    origin = {"nominal": "experiment", "from eq 6.7": "blend", "measured": "measured"}[row["nu_status"]]
    if name.startswith("silicone") and name != "silicone oil 0.65":
        name = f"{name} ({origin})"
    remark = f"viscosity {row['nu_status']}" + (f"; {row['remark']}" if row["remark"] else "")
    family = "silicone oil" if name.startswith("silicone") else "mineral oil"
    entry = FluidEntry(name, family, ROOM, ROOM, "Spannan (2021), Table 6.3", remark)
    density, viscosity = float(row["density_kg_m3"]), float(f"{float(row['nu_mm2_s']) * 1e-6:.12g}")
    return entry, lambda temperature: (density, viscosity, "")


def _mineral_oil(row: dict[str, str]) -> Offer:
    grade, at_15_degc = int(row["grade"]), float(row["density_15C_kg_m3"])
    entry = FluidEntry(
        f"ISO VG {grade}",
        "mineral oil",
        glycerol.LOWEST,
        glycerol.HIGHEST,
        "ISO 3448 mid-point, viscosity index 100 (ASTM D2270, D341); expansion API MPMS 11.1",
        "density typical of paraffinic oils, +/- 2 %",
    )

    def properties(temperature: float) -> tuple[float, float, str]:
        density = float(glycerol.lubricating_oil_density(at_15_degc, temperature))
        return density, float(glycerol.iso_vg_viscosity(grade, temperature)), ""

    return entry, properties


def _pure(entry: FluidEntry, density: Callable[[float], Any], dynamic_viscosity: Callable[[float], Any]) -> Offer:
    def properties(temperature: float) -> tuple[float, float, str]:
        at = float(density(temperature))
        return at, float(dynamic_viscosity(temperature)) / at, ""

    return entry, properties


_GLYCEROL = re.compile(r"glycerol (\d+(?:\.\d+)?) ?(wt|vol) ?%")
_HINT = "`autobalancer catalog fluids` lists them; any mixture is `glycerol <number> wt%` or `vol%`"


@dataclass(frozen=True)
class FluidState:
    """A fluid at a ``temperature`` [K]: ``density`` [kg/m^3] and kinematic ``viscosity`` [m^2/s]."""

    name: str
    density: float
    viscosity: float
    temperature: float
    source: str
    remark: str = ""


@dataclass(frozen=True)
class Blend:
    """Two fluids mixed to a wanted viscosity.

    ``fraction`` is the share of ``first``, by mass or by volume as ``basis`` says; ``fluid`` is the result.
    """

    first: str
    second: str
    fraction: float
    basis: str
    fluid: FluidState


class Fluids(Table[FluidEntry]):
    """Fluids of the catalog, a tuple."""

    head, most = ("fluid", "family", "from °C", "to °C"), 60

    def row(self, entry: FluidEntry) -> tuple[str, ...]:
        """Name, family, and range of temperatures."""
        ends = (entry.lowest_temperature, entry.highest_temperature)
        return (entry.name, entry.family, *(f"{end - 273.15:.4g}" for end in ends))


def fluids() -> Fluids:
    """Every fluid with a fixed name, with its range of temperatures, source and remark.

    In addition, any glycerol-water mixture can be used: ``fluid("glycerol 62.5 wt%")``, ``fluid("glycerol 50 vol%")``.
    """
    return Fluids(entry for entry, _ in offers())


def fluid(name: str, temperature: float | str = ROOM) -> FluidState:
    """Density and viscosity of a fluid at a temperature.

    Parameters
    ----------
    name
        A name of :func:`fluids`, such as ``"silicone oil 20"`` or ``"ISO VG 32"``, or of a glycerol-water
        mixture. Upper and lower case do not matter.
    temperature
        In K; by default 25 degC, the temperature of the tables.

    Raises
    ------
    CatalogError
        If no fluid has this name (the message proposes similar ones), or it is not available at this temperature.

    Source: that of the entry; see ``source`` and ``remark`` of the result.
    """
    temperature = argument("temperature", temperature, "K")
    entry, properties = _offer(name)
    low, high = entry.lowest_temperature, entry.highest_temperature
    if not low - 1e-6 <= temperature <= high + 1e-6:
        if low == high:
            raise CatalogError(
                f"{entry.name!r} is known at {_celsius(low)} only, not at {_celsius(temperature)}: "
                f"{entry.source} gives no law for other temperatures; use that one or "
                "another fluid"
            )
        raise CatalogError(
            f"{entry.name!r} is available from {_celsius(low)} to {_celsius(high)}, not at "
            f"{_celsius(temperature)} ({temperature!r} K); in Python a temperature is in K, elsewhere it "
            "has a unit"
        )
    density, viscosity, remark = properties(min(max(temperature, low), high))
    remarks = "; ".join(filter(None, (entry.remark, remark)))
    return FluidState(entry.name, density, viscosity, float(temperature), entry.source, remarks)


def blend(
    first: str | FluidState,
    second: str | FluidState,
    viscosity: float | str,
    temperature: float | str = ROOM,
    *,
    basis: Literal["mass", "volume"] = "mass",
) -> Blend:
    """Mix two oils to a wanted viscosity.

    Parameters
    ----------
    first, second
        Names of the catalog, or :class:`FluidState` of fluids that were measured.
    viscosity
        Wanted kinematic viscosity [m^2/s], between those of the two.
    temperature
        In K; a :class:`FluidState` must have this temperature.
    basis
        Whether the fraction is of mass or of volume, which the source does not say. It affects only the density.

    Raises
    ------
    CatalogError
        For an unknown name or temperature.
    QuestionError
        If no mixture has this viscosity, or the two fluids belong to different families.

    Source: Spannan (2021), eqs. (6.7) and (6.8), after Zhmud (2014); density by ideal mixing of volumes.
    """
    viscosity = argument("viscosity", viscosity, "m^2/s")
    temperature = argument("temperature", temperature, "K")
    if basis not in ("mass", "volume"):
        raise QuestionError(f"given basis = {basis!r}; it is 'mass' or 'volume'")
    families = {_offer(one)[0].family for one in (first, second) if isinstance(one, str)}
    if len(families) > 1 or families & {"air", "water", "glycerol-water"}:
        raise QuestionError(
            f"{_name(first)!r} and {_name(second)!r} are no pair of oils of one family "
            f"({', '.join(sorted(families))}), for which alone the law holds; for glycerol and water ask for "
            "the fluid `glycerol <number> wt%`"
        )
    one, two = (_state(part, temperature) for part in (first, second))
    w = blend_fraction(viscosity, (one.viscosity, one.density), (two.viscosity, two.density))
    if not 0.0 <= w <= 1.0 + 1e-12:
        raise QuestionError(
            f"a viscosity of {viscosity!r} m^2/s requires the fraction {w:.4g}, which is not between 0 and 1"
        )
    density = w * one.density + (1.0 - w) * two.density
    if basis == "mass":
        density = 1.0 / (w / one.density + (1.0 - w) / two.density)
    result = FluidState(
        f"{one.name} + {two.name}, {100.0 * w:.1f} % of the first by {basis}",
        density,
        float(viscosity),
        float(temperature),
        "Spannan (2021), eq. (6.8)",
        f"the source does not say whether the fraction is of mass or volume; {basis} assumed; ideal mixture, "
        "measure the viscosity",
    )
    return Blend(one.name, two.name, w, basis, result)


def catalog_name(name: str) -> str:
    """The name of a fluid as the catalog writes it.

    Raises
    ------
    CatalogError
        If the catalog has no such fluid.
    """
    return _offer(name)[0].name


def _offer(name: str) -> Offer:
    wanted = key(name)
    for entry, properties in offers():
        if key(entry.name) == wanted:
            return entry, properties
    mixture = _GLYCEROL.fullmatch(wanted)
    if mixture and float(mixture[1]) <= 100.0:
        return glycerol_offer(float(mixture[1]), mixture[2])
    unknown("fluid", name, [entry.name for entry, _ in offers()], _HINT)


def _state(part: str | FluidState, temperature: float) -> FluidState:
    if isinstance(part, str):
        return fluid(part, temperature)
    if abs(part.temperature - temperature) > 1e-6:
        raise QuestionError(
            f"{part.name!r} is given at {_celsius(part.temperature)}, the blend is wanted at "
            f"{_celsius(temperature)}; give both at one temperature"
        )
    return part


def _name(part: str | FluidState) -> str:
    return part if isinstance(part, str) else part.name


def _celsius(temperature: float) -> str:
    return f"{temperature - 273.15:.6g} degC"
