"""Where the fluids of the catalog come from: one function per family, each a tuple of sources of fluids."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

from autobalancer.catalog.tables import rows
from autobalancer.laws import glycerol, mineral_oil, water_and_air
from autobalancer.laws.viscosity import double_log_from_slope, expanded_density, viscosity_from_double_log

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
