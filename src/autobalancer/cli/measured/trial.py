"""``autobalancer measure trial-mass`` and ``split-mass``: before and after a balancing job."""

from __future__ import annotations

from math import degrees, isnan
from pathlib import Path
from typing import Annotated

import typer

import autobalancer as ab
from autobalancer.cli.terminal.options import Json
from autobalancer.cli.terminal.words import note
from autobalancer.shown import whole_degrees


def trial_mass(
    radius: Annotated[str, typer.Option(help='At which it will be, such as "100 mm".')],
    speed: Annotated[str, typer.Option(help='At which it will run, such as "1500 rpm".')],
    rotor_mass: Annotated[str | None, typer.Option(help='Of the rotor, such as "20 kg".')] = None,
    grade: Annotated[str | None, typer.Option(help='Balance quality grade, such as "G 6.3" or 6.3 (mm/s).')] = None,
    machine: Annotated[Path | None, typer.Option(help="Machine file, as a model.")] = None,
    reading: Annotated[str | None, typer.Option(help='Without trial mass, such as "0.1 mm" (peak).')] = None,
    phase: Annotated[str | None, typer.Option(help="Of this reading, lead over the mark.")] = None,
    running: Annotated[str | None, typer.Option(help="Below or above the critical speed.")] = None,
    as_json: Json = False,
) -> None:
    """How large a trial mass should be, and where it should go.

    Example: autobalancer measure trial-mass --radius "100 mm" --speed "1500 rpm" --rotor-mass "20 kg"
    """
    from dataclasses import asdict

    from autobalancer.cli.terminal.output import print_json
    from autobalancer.cli.terminal.quantities import quantity
    from autobalancer.cli.terminal.sheet import print_facts

    plan = ab.measure.trial_mass(
        radius=float(quantity("--radius", radius, "m")),
        speed=float(quantity("--speed", speed, "rad/s")),
        rotor_mass=None if rotor_mass is None else float(quantity("--rotor-mass", rotor_mass, "kg")),
        grade=grade,
        machine=machine,
        reading=reading,
        phase=None if phase is None else float(quantity("--phase", phase, "rad")),
        running=running,  # type: ignore[arg-type]
    )
    if as_json:
        print_json(asdict(plan))
        return
    rows = [
        (
            "mass",
            f"{1e3 * plan.mass:.3g} g at a radius of {1e3 * plan.radius:.4g} mm ({1e6 * plan.unbalance:.4g} g mm)",
        ),
        ("from", plan.rule),
        ("pulls with", f"{plan.force:.3g} N at this speed"),
    ]
    if not isnan(plan.angle):
        rows.append(("place", f"{whole_degrees(plan.angle)} deg from the mark, in the sense of rotation"))
    if not isnan(plan.change):
        rows.append(("changes the reading by", f"{100.0 * plan.change:.3g} %"))
    print_facts(rows, "Trial mass")
    for text in plan.remarks:
        note(text)


def split_mass(
    mass: Annotated[str, typer.Argument(help='Wanted, such as "15 g" or "900 g*mm".')],
    angle: Annotated[str, typer.Argument(help='Of it, such as "40 deg".')],
    holes: Annotated[int, typer.Option(help="Evenly spaced ones.")],
    first: Annotated[str, typer.Option(help="Angle of one of them.")] = "0 deg",
    available: Annotated[list[str] | None, typer.Option("--mass", help="That there is. May be repeated.")] = None,
    largest: Annotated[str | None, typer.Option(help="Greatest mass in a hole, where any size is possible.")] = None,
    most: Annotated[int, typer.Option(help="Holes that may be used with given masses.")] = 3,
    as_json: Json = False,
) -> None:
    """Split a correction over holes: exactly, or as near as the masses that there are can come.

    Example: autobalancer measure split-mass "15 g" "40 deg" --holes 6
    """
    from dataclasses import asdict

    from autobalancer.cli.terminal.output import print_json
    from autobalancer.cli.terminal.quantities import quantity
    from autobalancer.cli.terminal.sheet import Column, print_sheet
    from autobalancer.cli.terminal.words import say

    found = ab.measure.split_mass(
        mass,
        float(quantity("ANGLE", angle, "rad")),
        holes=holes,
        first=float(quantity("--first", first, "rad")),
        masses=available or None,
        largest=largest,
        most=most,
    )
    if as_json:
        print_json(asdict(found))
        return
    sign, factor = ("g", 1e3) if found.unit == "kg" else ("g mm", 1e6)
    print_sheet(
        [
            Column("hole at", [degrees(at) % 360.0 for at in found.angles], "deg", ".4g"),
            Column("mass", [factor * one for one in found.masses], sign, ".4g"),
        ]
    )
    say(f"left: {factor * found.residual:.3g} {sign} at {whole_degrees(found.residual_angle)} deg")
