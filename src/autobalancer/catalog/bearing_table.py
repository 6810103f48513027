"""Ball bearings whose outer ring and balls may serve as a balancer.

Dimensions and printed capabilities: Spannan (2021), Tables C.1 (SKF, deep groove) and C.2 (Schaeffler, thin
section), 412 rows recovered from a machine-read text. 315 rows are verified; 97 carry at least one value that
had to be reconstructed, and say so.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

from autobalancer.catalog.small_tables import rows, unknown
from autobalancer.errors import QuestionError
from autobalancer.laws.capabilities import ball_mass, capability, largest_useful_count, needed_count
from autobalancer.tables import Table
from autobalancer.units import argument, optional_argument

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
    min_outer = optional_argument("min_outer", min_outer, "m")
    max_outer = optional_argument("max_outer", max_outer, "m")
    min_bore = optional_argument("min_bore", min_bore, "m")
    max_width = optional_argument("max_width", max_width, "m")
    min_orbit = optional_argument("min_orbit", min_orbit, "m")
    max_orbit = optional_argument("max_orbit", max_orbit, "m")
    ball_density = argument("ball_density", ball_density, "kg/m^3")
    fluid_density = argument("fluid_density", fluid_density, "kg/m^3")
    unbalance = argument("unbalance", unbalance, "kg*m")
    if sort not in _ORDER:
        raise QuestionError(f"sort: given {sort!r}; must be one of {', '.join(_ORDER)}")
    limits = {
        "unbalance": unbalance,
        "min_outer": min_outer,
        "max_outer": max_outer,
        "min_bore": min_bore,
        "max_width": max_width,
        "min_orbit": min_orbit,
        "max_orbit": max_orbit,
    }
    for name, value in limits.items():
        if value is not None and not value > 0.0:
            raise QuestionError(f"given {name} = {value!r}; write a number greater than zero, in SI units")
    suitable_bearings = []
    for entry in bearings():
        if min_outer is not None and entry.outer < min_outer * (1.0 - 1e-9):
            continue
        if max_outer is not None and entry.outer > max_outer * (1.0 + 1e-9):
            continue
        if min_bore is not None and entry.bore < min_bore * (1.0 - 1e-9):
            continue
        if max_width is not None and entry.width > max_width * (1.0 + 1e-9):
            continue
        if min_orbit is not None and entry.orbit_radius < min_orbit * (1.0 - 1e-9):
            continue
        if max_orbit is not None and entry.orbit_radius > max_orbit * (1.0 + 1e-9):
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
