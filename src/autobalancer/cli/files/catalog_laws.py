"""``autobalancer catalog drag-laws`` and ``capability``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import autobalancer as ab
from autobalancer.cli.files.catalog_fluids import FluidName, Temperature, fluid_density
from autobalancer.cli.terminal.options import Csv, Json
from autobalancer.cli.terminal.output import one_form, print_csv, print_json
from autobalancer.cli.terminal.quantities import quantity
from autobalancer.cli.terminal.words import say
from autobalancer.results.number_text import moment_text

if TYPE_CHECKING:
    from autobalancer.cli.terminal.sheet import Column


def drag(
    reynolds: Annotated[list[float] | None, typer.Option(help="Reynolds number to show. May be repeated.")] = None,
    clear_width: Annotated[str, typer.Option(help='Of a race, such as "9.2 mm"; with ball and orbit.')] = "",
    ball_diameter: Annotated[str, typer.Option(help='Such as "12.3 mm".')] = "",
    orbit_radius: Annotated[str, typer.Option(help='Such as "77 mm".')] = "",
    plot: Annotated[Path | None, typer.Option(help="Picture of the laws: .png, .svg or .pdf.")] = None,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """List the drag laws with their coefficients at some Reynolds numbers.

    Example: autobalancer catalog drag-laws --reynolds 100 --reynolds 24000 --plot drag.png
    """
    from autobalancer.cli.terminal.output import Files
    from autobalancer.cli.terminal.sheet import print_sheet
    from autobalancer.drag import drag_laws
    from autobalancer.drag.race_geometry import race_geometry
    from autobalancer.errors import QuestionError
    from autobalancer.laws.drag import annulus_cd_re
    from autobalancer.laws.drag_coefficient import DragLaw

    one_form(as_json, as_csv)
    files = Files(plot=plot)
    laws: tuple[DragLaw, ...] = drag_laws()
    given = (clear_width, ball_diameter, orbit_radius)
    if any(given):
        if not all(given):
            raise QuestionError("give --clear-width, --ball-diameter and --orbit-radius together")
        width, diameter, orbit = (
            float(quantity(option, text, "m"))
            for option, text in zip(("--clear-width", "--ball-diameter", "--orbit-radius"), given, strict=True)
        )
        laws = (*laws, race_geometry(annulus_cd_re(2.0 * width / diameter, 0.5 * diameter / orbit)))
    at = reynolds or [1.0, 10.0, 100.0, 1000.0, 20000.0]
    if min(at) <= 0.0:
        raise QuestionError(f"--reynolds: given {min(at):g}; must be greater than zero")
    rows = [
        {
            "name": law.name,
            "cd_re": law.cd_re,
            "stokes_end": law.stokes_end,
            "plateau": _plateau(law),
            "highest": law.highest,
            "source": law.source,
            "reynolds": at,
            "coefficient": (law.product(at) / at).tolist(),
        }
        for law in laws
    ]
    if plot is not None:
        from autobalancer.plots.drawing.save import save_picture

        save_picture(ab.plot.drag_laws(laws), plot)
    if as_json:
        print_json(rows)
        return
    columns = _drag_columns(laws, at, [row["coefficient"] for row in rows])
    if as_csv:
        print_csv(columns)
        return
    print_sheet(columns, "Drag laws")
    say(
        "Also: race_geometry with clear_width, cd_re with a plateau, and table. Reynolds numbers are those of the ball "
        "diameter."
    )
    files.say()


def _drag_columns(laws: tuple[Any, ...], at: list[float], coefficients: list[list[float]]) -> list[Column]:
    from autobalancer.cli.terminal.sheet import Column

    return [
        Column("law", [law.name for law in laws]),
        Column("c_d Re", [law.cd_re for law in laws], form=".4g"),
        Column("linear to Re", [law.stokes_end for law in laws], form="g"),
        *(Column(f"c_d at Re {re:g}", [row[i] for row in coefficients], form=".4g") for i, re in enumerate(at)),
        Column("plateau", [_plateau(law) for law in laws], form=".3g"),
        Column("holds to Re", [law.highest for law in laws], form=".3g"),
        Column("source", [law.source for law in laws], wraps=True),
    ]


def _plateau(law: Any) -> float | None:
    """Drag coefficient at high Reynolds numbers; ``None`` where the law has none."""
    import math

    end = float(law.kept_from)
    return float(law.product(end)) / end if 0.0 < end < math.inf else None


def capability(
    orbit_radius: Annotated[str, typer.Option(help='Radius of the circle of ball centers, such as "77 mm".')],
    ball_diameter: Annotated[str, typer.Option(help='Such as "12.3 mm".')],
    material: Annotated[str, typer.Option(help="Material of the balls.")] = "steel",
    count: Annotated[int | None, typer.Option(help="Number of balls; by default the most useful one.")] = None,
    fluid: FluidName = None,
    temperature: Temperature = "25 degC",
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Work out the unbalance that a race of balls can compensate.

    Example: autobalancer catalog capability --orbit-radius "77 mm" --ball-diameter "12 mm"
    """
    from autobalancer.catalog.material_table import material as find_material
    from autobalancer.laws import ball_capability as laws

    one_form(as_json, as_csv)
    radius, diameter = (
        float(quantity("--orbit-radius", orbit_radius, "m")),
        float(quantity("--ball-diameter", ball_diameter, "m")),
    )
    density, around = find_material(material).density, fluid_density(fluid, temperature)
    best = laws.largest_useful_count(radius, diameter)
    balls = best if count is None else count
    answer = {
        "count": balls,
        "capability": laws.capability(radius, diameter, density, balls, fluid_density=around),
        "ball_mass": balls * laws.ball_mass(diameter, density),
        "largest_useful_count": best,
        "largest_capability": laws.capability(radius, diameter, density, fluid_density=around),
        "largest_count": laws.largest_count(radius, diameter),
    }
    if as_json:
        print_json(answer)
        return
    if as_csv:
        from autobalancer.cli.terminal.sheet import Column

        units = {"capability": "kg m", "largest_capability": "kg m", "ball_mass": "kg"}
        print_csv([Column(key.replace("_", " "), [value], units.get(key, "")) for key, value in answer.items()])
        return
    given, most = moment_text(answer["capability"], 5), moment_text(answer["largest_capability"], 5)
    typer.echo(f"{balls} balls ({answer['ball_mass'] * 1e3:.4g} g) compensate {given}")
    typer.echo(f"greatest: {most} with {best} balls; room for {answer['largest_count']}")
