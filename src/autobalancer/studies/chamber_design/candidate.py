"""One design of a deep chamber: balls, friction, fluid; and the machine with them."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import machine_text
from autobalancer.laws.deep_chamber.fluid import free_drag
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.units.arguments import list_argument
from autobalancer.units.ranges import is_range, listed, whole

UNITS = {
    "balls": "",
    "diameter": "m",
    "total_mass": "kg",
    "density": "kg/m^3",
    "friction": "",
    "ball_friction": "",
    "viscosity": "Pa*s",
    "fluid_density": "kg/m^3",
    "fill": "",
}
MOST = 2000  # designs


@dataclass(frozen=True, order=True)
class Candidate:
    """Number of balls, their diameter (m) and density; friction, that of balls on balls; viscosity (Pa s) and density of a fluid,
    share that it fills.

    What is nan stays as the machine has it. With a viscosity of 0 the chamber is dry.
    """

    balls: int
    diameter: float
    density: float
    friction: float
    ball_friction: float = math.nan
    viscosity: float = math.nan
    fluid_density: float = 0.0
    fill: float = 0.0

    @property
    def total_mass(self) -> float:
        """Of the balls, kg."""
        return self.balls * self.density * math.pi / 6.0 * self.diameter**3

    @property
    def label(self) -> str:
        """``8 × 31.3 mm, friction 0.7``."""
        fluid = f", {1e3 * self.viscosity:.4g} mPa s" if self.viscosity > 0.0 else ""
        between = "" if math.isnan(self.ball_friction) else f" ({self.ball_friction:g} between balls)"
        return f"{self.balls} × {1e3 * self.diameter:.3g} mm, friction {self.friction:g}{between}{fluid}"

    def run_name(self, unbalance: float, duration: float, last: float, seed: int) -> str:
        """Of a run in an archive: all on which its measures depend."""
        return f"{self.name}-u{unbalance:g}-t{duration:g}-l{last:g}-s{seed}"

    @property
    def name(self) -> str:
        """The first part of the names of its runs in an archive."""
        fluid = f"-v{self.viscosity:g}-d{self.fluid_density:g}-f{self.fill:g}" if self.viscosity >= 0.0 else ""
        between = "" if math.isnan(self.ball_friction) else f"-b{self.ball_friction:g}"
        return f"n{self.balls}-{1e3 * self.diameter:.6g}mm-{self.density:g}-mu{self.friction:g}{between}{fluid}"


def candidates(machine: ChamberMachine, shelf: Mapping[str, Any]) -> list[Candidate]:
    """All combinations of what there is to choose from, each once, ascending; what is not on the shelf is as in the machine."""
    if len(machine.chambers) != 1 or len(machine.chambers[0].balls) != 1:
        raise QuestionError(
            "machine: has several chambers or groups of balls; a design is of one chamber with equal balls"
        )
    group, chamber = machine.chambers[0].balls[0], machine.chambers[0]
    if group.body != "ball":
        raise QuestionError(
            "machine: its chamber has cylinders; designs are compared for balls only; simulate runs cylinders"
        )
    if chamber.depth is None:
        raise QuestionError("machine: its chamber has no depth, so it would change with the balls; give chambers.depth")
    if group.positions is not None:
        raise QuestionError("machine: its balls have positions; leave them out, so that other balls can be filled in")
    values = _read(shelf)
    balls = [int(value) for value in values.pop("balls", [group.count])]
    density = values.pop("density", [float(group.density)])
    friction = values.pop("friction", [float(machine.contact.friction)])
    between = values.pop("ball_friction", [math.nan])
    fluids = _fluids(values, chamber.drag > 0.0 or chamber.square_drag > 0.0)
    sizes = values if values else {"total_mass": [group.count * group.ball_mass]}
    found: dict[tuple[float | None, ...], None] = {}
    for count, heavy, rough, own, fluid in product(balls, density, friction, between, fluids):
        for kind, several in sizes.items():
            for size in several:
                wide = size if kind == "diameter" else (6.0 * size / (math.pi * heavy * count)) ** (1.0 / 3.0)
                found[
                    tuple(None if math.isnan(value) else value for value in (count, wide, heavy, rough, own, *fluid))
                ] = None
    if len(found) > MOST:
        raise QuestionError(f"candidates: {len(found)} designs; at most {MOST} are possible. Take fewer values of each")
    ordered = sorted(found, key=lambda entry: tuple(-1.0 if value is None else value for value in entry))
    plain = [[math.nan if value is None else value for value in entry] for entry in ordered]
    return [Candidate(int(entry[0]), *entry[1:]) for entry in plain]


def machine_of(machine: ChamberMachine, candidate: Candidate, unbalance: float | None = None) -> ChamberMachine:
    """The machine with these balls, friction and fluid, and with its unbalances in proportion up to ``unbalance`` (kg m).

    Raises
    ------
    MachineError
        If such balls do not go into the chamber.
    """
    data: dict[str, Any] = tomllib.loads(machine_text(machine))
    chamber = data["chambers"][0] if isinstance(data["chambers"], list) else data["chambers"]
    balls = {"count": candidate.balls, "density": candidate.density, "diameter": candidate.diameter}
    chamber["balls"] = [balls]
    data["contact"]["friction"] = candidate.friction
    if not math.isnan(candidate.ball_friction):
        data["contact"]["ball_friction"] = candidate.ball_friction
    if not math.isnan(candidate.viscosity):
        drag = free_drag(candidate.viscosity, candidate.fluid_density, 0.5 * candidate.diameter)
        chamber["drag"], chamber["square_drag"] = drag if candidate.viscosity > 0.0 else (0.0, 0.0)
        if chamber.get("viscosity") is not None and candidate.viscosity > 0.0:
            chamber["viscosity"] = candidate.viscosity
    if unbalance is not None:
        factor = unbalance / abs(sum(part.vector for part in machine.unbalances))
        data["unbalances"] = [
            {"moment": part.size * factor, "angle": float(part.angle), "position": float(part.position)}
            for part in machine.unbalances
        ]
    return ChamberMachine(**data)


def _read(shelf: Mapping[str, Any]) -> dict[str, list[float]]:
    values = {}
    for name, given in shelf.items():
        if name not in UNITS:
            raise QuestionError(f"candidates: given {name!r}; must be one of {', '.join(UNITS)}")
        if name == "balls":
            given = whole("balls", given) if isinstance(given, str) and not is_range(given) else given
            read = [float(value) for value in list_argument("balls", given, "")]
            if any(value != round(value) or value < 1.0 for value in read):
                raise QuestionError(f"balls: given {given!r}; must be whole numbers from 1 on")
        else:
            listing = isinstance(given, str) and "," in given
            read = listed(name, given, UNITS[name]) if listing else list_argument(name, given, UNITS[name])
        if not read:
            raise QuestionError(f"{name}: given none; give at least one, or leave it out")
        low = 0.0 if name in ("friction", "ball_friction", "viscosity", "fill", "fluid_density") else math.ulp(0.0)
        if any(not value >= low or math.isinf(value) for value in read):
            raise QuestionError(
                f"{name}: given {min(read):g}; must be {'above' if low else 'at least'} zero, and finite"
            )
        values[name] = [float(value) for value in read]  # however it was written, the machine is the same
    if "diameter" in values and "total_mass" in values:
        raise QuestionError("candidates: given diameter and total_mass; give one of them, the other one follows")
    if any(value > 1.0 for value in values.get("fill", ())):
        raise QuestionError(f"fill: given {max(values['fill']):g}; the share that the fluid fills is at most 1")
    return values


def _fluids(values: dict[str, list[float]], has_drag: bool) -> Sequence[tuple[float, float, float]]:
    """Viscosity, density and fill of each fluid; those of a dry chamber are zero."""
    viscosity = values.pop("viscosity", None)
    density, fill = values.pop("fluid_density", None), values.pop("fill", None)
    if viscosity is None:
        if density is not None or fill is not None:
            raise QuestionError("viscosity: missing; fluid_density and fill are of a fluid that has one")
        return [(math.nan, 0.0, 0.0)]
    if has_drag:
        raise QuestionError("viscosity: the chamber of the machine has a drag already; leave out one of them")
    wet = [value for value in viscosity if value > 0.0]
    if wet and (density is None or fill is None):
        raise QuestionError("fluid_density, fill: missing; a fluid with a viscosity needs both")
    dry = [(0.0, 0.0, 0.0)] if len(wet) < len(viscosity) else []
    return [*dry, *product(wet, density or (), fill or ())]
