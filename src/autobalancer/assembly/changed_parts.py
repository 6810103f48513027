"""Parts of a race with another value of one quantity; refused by name where it has none."""

from __future__ import annotations

from typing import Any

from autobalancer.catalog.resolve import fluid_numbers
from autobalancer.catalog.resolve_bodies import roller_face
from autobalancer.errors import QuestionError
from autobalancer.machine import Balls, Fluid, Friction, Race


def race_with_viscosity(where: str, race: Race, value: float) -> dict[str, Any]:
    """The fluid of a race with another kinematic viscosity."""
    if race.fluid is None or not race.drag.needs_fluid:
        raise QuestionError(
            f"quantity 'viscosity': the drag of {where} is given by its torque, which no viscosity changes; "
            "vary 'drag', or describe fluid and drag law"
        )
    density, _ = fluid_numbers(race.fluid)
    shear = race.fluid.shear
    if shear is not None and shear.measured_at is not None:
        raise QuestionError(
            f"quantity 'viscosity': the rates of shear of the fluid of {where} change with its temperature; vary 'temperature'"
        )
    return {"fluid": Fluid(density=density, viscosity=value, virtual_mass=race.fluid.virtual_mass, shear=shear)}


def race_with_rolling(race: Race, value: float) -> Friction:
    """The friction of a race with another rolling resistance."""
    given = race.friction or Friction()
    held = None if given.adherence is None else max(float(given.adherence), value)
    return Friction(rolling_resistance=value, adherence=held)


def race_with_temperature(where: str, race: Race, value: float) -> Fluid:
    """The fluid of a race at another temperature."""
    if race.fluid is None or race.fluid.name is None:
        raise QuestionError(
            f"quantity 'temperature': {where} has no fluid of the catalog, whose density and viscosity would change with it; "
            "name one"
        )
    changed: Fluid = changed_part(race.fluid, temperature=value)
    return changed


def race_with_plateau(where: str, race: Race, value: float) -> Any:
    """The law of drag of a race with another plateau."""
    if "plateau" not in type(race.drag).model_fields:
        raise QuestionError(f"quantity 'plateau': the law of drag of {where}, {race.drag.word()!r}, has none")
    return changed_part(race.drag, plateau=value)


def group_with_ball(group: Balls, ball: Any, name: str, value: float, where: str) -> Balls:
    """A group of balls with another count, mass or diameter."""
    if name == "count":
        kept = {key: getattr(group, key) for key in group.model_fields_set if not key.startswith("start")}
        return Balls(**{**kept, "count": int(value)})
    size = ("diameter", "mass", "density", "material")
    others = {key: getattr(group, key) for key in group.model_fields_set if key not in size}
    if name == "ball_mass":
        sized = {"diameter": ball.diameter} if ball.diameter else {}
        return Balls(**others, mass=value, **sized)
    if not ball.volume:
        raise QuestionError(f"quantity 'ball_diameter': the density of the {group.body}s of {where} is not known")
    if group.body == "roller":
        others["length"] = ball.volume / roller_face(group)
    return Balls(**others, diameter=value, density=ball.mass / ball.volume)


def changed_part(part: Any, **new: Any) -> Any:
    """A part with other entries, checked anew."""
    return type(part)(**{**{key: getattr(part, key) for key in part.model_fields_set}, **new})
