"""Fluids for the race: silicone oils, mineral oils, glycerol-water, water, air, and blends of two oils."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

from autobalancer.catalog.fluid_families import ROOM, FluidEntry, Offer, glycerol_offer, offers
from autobalancer.catalog.tables import key, unknown
from autobalancer.errors import CatalogError, QuestionError
from autobalancer.laws.viscosity import blend_fraction
from autobalancer.shown import Table
from autobalancer.units import argument

__all__ = ["Blend", "FluidEntry", "FluidState", "blend", "fluid", "fluids"]

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
