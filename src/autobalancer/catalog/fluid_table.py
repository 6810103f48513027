"""Fluids for the race: silicone oils, mineral oils, glycerol-water, water, air, and blends of two oils."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Literal

from autobalancer.catalog.small_tables import key, rows, unknown
from autobalancer.errors import CatalogError, QuestionError
from autobalancer.laws import viscosity as glycerol
from autobalancer.laws import viscosity as mineral_oil
from autobalancer.laws import viscosity as water_and_air
from autobalancer.laws.viscosity import (
    blend_fraction,
    double_log_from_slope,
    expanded_density,
    viscosity_from_double_log,
)
from autobalancer.tables import Table
from autobalancer.units import argument

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
    mixtures = tuple(glycerol_offer(float(percent), "wt") for percent in range(10, 101, 10))
    return (*_silicone_oils(), *_experiment_fluids(), *_mineral_oils(), *mixtures, _water(), _air())


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


def _silicone_oils() -> tuple[Offer, ...]:
    return tuple(_silicone_oil(row) for row in rows("silicone_oils.csv"))


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


def _experiment_fluids() -> tuple[Offer, ...]:
    return tuple(_experiment_fluid(row) for row in rows("experiment_fluids.csv"))


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


def _mineral_oils() -> tuple[Offer, ...]:
    return tuple(_mineral_oil(int(row["grade"]), float(row["density_15C_kg_m3"])) for row in rows("iso_vg_oils.csv"))


def _mineral_oil(grade: int, at_15_degc: float) -> Offer:
    entry = FluidEntry(
        f"ISO VG {grade}",
        "mineral oil",
        mineral_oil.LOWEST,
        mineral_oil.HIGHEST,
        "ISO 3448 mid-point, viscosity index 100 (ASTM D2270, D341); expansion API MPMS 11.1",
        "density typical of paraffinic oils, +/- 2 %",
    )

    def properties(temperature: float) -> tuple[float, float, str]:
        density = float(mineral_oil.lubricating_oil_density(at_15_degc, temperature))
        return density, float(mineral_oil.iso_vg_viscosity(grade, temperature)), ""

    return entry, properties


def _water() -> Offer:
    entry = FluidEntry(
        "water", "water", *water_and_air.WATER_RANGE, "density Kell (1975), viscosity Pátek et al. (2009)"
    )

    def properties(temperature: float) -> tuple[float, float, str]:
        density = float(water_and_air.water_density(temperature))
        return density, float(water_and_air.water_dynamic_viscosity(temperature)) / density, ""

    return entry, properties


def _air() -> Offer:
    source = "U.S. Standard Atmosphere (1976): ideal gas, Sutherland's law"
    entry = FluidEntry("air", "air", *water_and_air.AIR_RANGE, source, "dry, at 101325 Pa")

    def properties(temperature: float) -> tuple[float, float, str]:
        density = float(water_and_air.air_density(temperature))
        return density, float(water_and_air.air_dynamic_viscosity(temperature)) / density, ""

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
