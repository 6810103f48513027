"""The same machine with other balls, another friction, a chamber of one layer."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from autobalancer.errors import QuestionError
from autobalancer.files.given import balls_in_chambers
from autobalancer.files.machine_file import machine_text
from autobalancer.machine.chamber import ChamberMachine

LAYERS = ("deep", "single")


def variant(
    machine: ChamberMachine | str | Path,
    *,
    balls: int,
    friction: float | None = None,
    layers: str = "deep",
    body: str | None = None,
) -> ChamberMachine:
    """A machine with another number of balls of the same total mass, in its deep chamber or in one of a single layer.

    Parameters
    ----------
    machine
        With one chamber and one group of balls.
    balls
        How many; the smaller, the more there are. Cylinders keep their length over their diameter.
    friction
        Of all contacts; by default that of the machine.
    layers
        ``"deep"``: depth as described; ``"single"``: as deep as a ball and a hundredth.
    body
        ``"ball"`` for balls in place of cylinders, of the same mass together; by default as the machine has them.

    Raises
    ------
    QuestionError
        If the machine has several chambers or groups of balls, or ``layers`` or ``body`` is none of these.
    MachineError
        If balls of this size do not go into the chamber.
    """
    if layers not in LAYERS:
        raise QuestionError(f"layers: given {layers!r}; must be one of {', '.join(LAYERS)}")
    machine = balls_in_chambers(machine)
    if len(machine.chambers) != 1 or len(machine.chambers[0].balls) != 1:
        raise QuestionError(
            "machine: has several chambers or groups of balls; the study is of one chamber with equal balls"
        )
    data: dict[str, Any] = tomllib.loads(machine_text(machine))
    chamber = data["chambers"][0] if isinstance(data["chambers"], list) else data["chambers"]
    group = machine.chambers[0].balls[0]
    chamber["balls"] = [{"count": balls, "density": group.density, "total_mass": group.count * group.ball_mass}]
    body = group.body if body is None else body
    if body not in ("ball", group.body):
        raise QuestionError(
            f"body: given {body!r}; a machine with {group.body}s has variants with {_and_balls(group.body)}"
        )
    if group.length is not None and body != "ball":
        same = {"body": group.body, "length": group.length * (group.count / balls) ** (1.0 / 3.0)}
        chamber["balls"][0].update(same)
    if layers == "single":
        chamber.pop("depth", None)
    elif machine.chambers[0].depth is None:
        raise QuestionError(
            "machine: its chamber has no depth, so it is one of a single layer; give chambers.depth, or ask for the "
            "single layer alone"
        )
    if friction is not None:
        data["contact"]["friction"] = friction
    return ChamberMachine(**data)


def _and_balls(body: str) -> str:
    return "'ball'; describe cylinders in the machine file" if body == "ball" else f"'ball' and {body!r}"
