"""``autobalancer catalog``: bearings, ball materials, fluids, and what a race of balls can compensate."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from autobalancer.cli.files.catalog_fluids import FluidName, Temperature, blend, fluid, fluid_density, fluids
from autobalancer.cli.files.catalog_laws import capability, drag
from autobalancer.cli.terminal.options import Csv, Json
from autobalancer.cli.terminal.output import one_form, print_csv, print_json
from autobalancer.cli.terminal.quantities import quantity
from autobalancer.cli.terminal.words import say

if TYPE_CHECKING:
    from autobalancer.catalog.bearing_table import SuitableBearing
    from autobalancer.cli.terminal.sheet import Column

_HELP = "Look up bearings, ball materials, friction, fluids and published rigs."
app = typer.Typer(help=_HELP, no_args_is_help=True, rich_markup_mode="rich")


@app.command()
def bearings(
    unbalance: Annotated[str, typer.Option(help='Unbalance to compensate, such as "594 g*mm".')] = "",
    min_outer: Annotated[str, typer.Option(help='Smallest outer diameter, such as "60 mm".')] = "",
    max_outer: Annotated[str, typer.Option(help="Largest outer diameter.")] = "",
    min_bore: Annotated[str, typer.Option(help="Smallest catalog bore.")] = "",
    max_width: Annotated[str, typer.Option(help="Largest width.")] = "",
    min_orbit: Annotated[str, typer.Option(help='Smallest orbit radius of the balls, such as "40 mm".')] = "",
    max_orbit: Annotated[str, typer.Option(help="Largest orbit radius of the balls.")] = "",
    material: Annotated[str, typer.Option(help="Material of the balls.")] = "steel",
    fluid: FluidName = None,
    temperature: Temperature = "25 degC",
    sort: Annotated[str, typer.Option(help="outer, mass (of the balls), capability, orbit, bore or width.")] = "outer",
    limit: Annotated[int, typer.Option(min=0, help="Rows to print; 0 prints all.")] = 20,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """List bearings whose outer ring and balls compensate an unbalance in a given space.

    Example: autobalancer catalog bearings --unbalance "594 g*mm" \\
      --max-outer "80 mm" --sort mass
    """
    from autobalancer.catalog.bearing_table import RECONSTRUCTED, suitable_bearings
    from autobalancer.catalog.material_table import material as find_material
    from autobalancer.cli.terminal.sheet import print_sheet

    one_form(as_json, as_csv)
    limits = {
        "min_outer": min_outer,
        "max_outer": max_outer,
        "min_bore": min_bore,
        "max_width": max_width,
        "min_orbit": min_orbit,
        "max_orbit": max_orbit,
    }
    found = suitable_bearings(
        float(quantity("--unbalance", unbalance, "kg*m"))
        if unbalance
        else 1e-12,  # any bearing does, so all are listed
        **{name: float(quantity(f"--{name.replace('_', '-')}", text, "m")) for name, text in limits.items() if text},
        ball_density=find_material(material).density,
        fluid_density=fluid_density(fluid, temperature),
        sort=sort,
    )
    shown = found[: limit or None]
    if as_json:
        needs = ("count", "capability", "ball_mass") if not unbalance else ()
        print_json([{k: v for k, v in asdict(entry).items() if k not in needs} for entry in shown])
        return
    columns = _bearing_columns(shown, bool(unbalance))
    if as_csv:
        print_csv(columns)
        return
    print_sheet(columns, f"{len(found)} bearings, {len(shown)} shown")
    say(f"Source: Spannan (2021), Tables C.1 and C.2; capabilities are for balls of {material}.")
    if any(not entry.bearing.verified for entry in shown):
        say("* a value of this row was reconstructed from a damaged text: check it with the maker.")
    for entry in shown:
        if entry.bearing.remark and entry.bearing.remark != RECONSTRUCTED:
            say(f"{entry.bearing.designation}: {entry.bearing.remark}.", indent="  ")


def _bearing_columns(shown: tuple[SuitableBearing, ...], needs: bool) -> list[Column]:
    from autobalancer.cli.terminal.sheet import Column

    found = [entry.bearing for entry in shown]
    columns = [
        Column("bearing", [b.designation + ("" if b.verified else " *") for b in found]),
        Column("bore", [1e3 * b.bore for b in found], "mm"),
        Column("outer", [1e3 * b.outer for b in found], "mm"),
        Column("width", [1e3 * b.width for b in found], "mm"),
        Column("orbit radius", [1e3 * b.orbit_radius for b in found], "mm"),
        Column("ball", [1e3 * b.ball_diameter for b in found], "mm"),
        Column("most", [_digits(entry.largest_capability * 1e6) for entry in shown], "g mm", ".10g"),
        Column("with balls", [entry.largest_useful_count for entry in shown]),
    ]
    if needs:
        columns += [
            Column("needs balls", [entry.count for entry in shown]),
            Column("giving", [_digits(entry.capability * 1e6) for entry in shown], "g mm", ".10g"),
            Column("mass", [_digits(entry.ball_mass * 1e3) for entry in shown], "g", ".10g"),
        ]
    return columns


@app.command()
def bearing(
    name: Annotated[str, typer.Argument(help='Designation, such as "16021".')],
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Show one bearing and what a race with bearing = "..." takes from it.

    Example: autobalancer catalog bearing 16021
    """
    from autobalancer.catalog.bearing_table import bearing as find_bearing
    from autobalancer.cli.terminal.sheet import Column, print_facts
    from autobalancer.laws.ball_capability import largest_count, largest_useful_count

    one_form(as_json, as_csv)
    b = find_bearing(name)
    wall = b.orbit_radius + 0.5 * b.ball_diameter
    most, useful = (ask(b.orbit_radius, b.ball_diameter) for ask in (largest_count, largest_useful_count))
    if as_json:
        print_json({**asdict(b), "wall_radius": wall, "largest_count": most, "largest_useful_count": useful})
        return
    sizes = {
        "bore": b.bore,
        "outer": b.outer,
        "width": b.width,
        "orbit radius": b.orbit_radius,
        "ball": b.ball_diameter,
    }
    if as_csv:
        lengths = [Column(head, [1e3 * size], "mm") for head, size in sizes.items()]
        print_csv([Column("bearing", [b.designation]), *lengths, Column("largest count", [most])])
        return
    rows = [
        ("sizes", ", ".join(f"{head} {1e3 * size:.5g} mm" for head, size in sizes.items())),
        (
            "the race takes",
            f"orbit_radius {1e3 * b.orbit_radius:.5g} mm, diameter of the balls {1e3 * b.ball_diameter:.5g} mm",
        ),
        ("room for", f"{most} balls; {useful} compensate the most"),
        (
            "not known",
            "the chamber. Its wall has a radius of "
            f'{1e3 * wall:.5g} mm; with lids on the faces of the ring height = "{1e3 * b.width:.5g} mm"; width depends on what '
            f"stands in place of the inner ring, {1e3 * (wall - 0.5 * b.bore):.5g} mm down to the bore",
        ),
        ("source", "Spannan (2021), Tables C.1 and C.2" + (f"; {b.remark}" if b.remark else "")),
    ]
    print_facts(rows, f"{b.designation} ({b.family.replace('_', ' ')})")
    say(f'In a machine file: bearing = "{b.designation}" in a race, and balls = [{{ count = 2, material = "steel" }}]')


app.command()(fluids)
app.command()(fluid)
app.command()(blend)


@app.command()
def materials(as_json: Json = False, as_csv: Csv = False) -> None:
    """List the materials of balls with their densities.

    Example: autobalancer catalog materials
    """
    from autobalancer.catalog.material_table import materials as all_materials
    from autobalancer.cli.terminal.sheet import Column, print_sheet

    one_form(as_json, as_csv)
    found = all_materials()
    if as_json:
        print_json([asdict(entry) for entry in found])
        return
    columns = [
        Column("material", [entry.name for entry in found]),
        Column("density", [entry.density for entry in found], "kg/m^3"),
        Column("source", [entry.source for entry in found], wraps=True),
        Column("remark", [entry.remark for entry in found], wraps=True),
    ]
    if as_csv:
        print_csv(columns)
        return
    print_sheet(columns, "Materials of balls")


@app.command()
def friction(as_json: Json = False, as_csv: Csv = False) -> None:
    """List published coefficients of friction between a ball and its race, with what they were found on.

    Example: autobalancer catalog friction
    """
    from autobalancer.catalog.friction_table import friction
    from autobalancer.cli.terminal.sheet import Column

    one_form(as_json, as_csv)
    found = friction()
    if as_json:
        print_json([asdict(entry) for entry in found])
        return
    if as_csv:
        names = ("name", "kind", "rolling_resistance", "adherence", "conditions", "source", "remark")
        print_csv([Column(name.replace("_", " "), [getattr(entry, name) for entry in found]) for name in names])
        return
    for entry in found:
        values = f"rolling resistance {entry.rolling_resistance:.0e}"
        if entry.adherence == entry.adherence:
            values += f", adherence {entry.adherence:.0e}"
        typer.secho(f"{entry.name}: {values}", bold=True)
        for text in (f"{entry.kind}: {entry.conditions}", entry.source, entry.remark):
            if text:
                say(text, indent="    ", first="  ")
    say("They differ by orders of magnitude: measure your own pair, or try both ends.")


@app.command()
def rigs(as_json: Json = False, as_csv: Csv = False) -> None:
    """List the published rigs that come as machine files.

    Example: autobalancer catalog rigs
    """
    from autobalancer.cli.terminal.sheet import Column, print_sheet
    from autobalancer.files.rigs import rig as find_rig
    from autobalancer.files.rigs import rigs as all_rigs

    one_form(as_json, as_csv)
    found = {name: find_rig(name) for name in all_rigs()}
    if as_json:
        print_json([{"name": key, "title": m.name, "description": m.description} for key, m in found.items()])
        return
    columns = [Column("rig", list(found)), Column("source", [m.description for m in found.values()], wraps=True)]
    if as_csv:
        print_csv(columns)
        return
    print_sheet(columns, "Published rigs")
    typer.echo("Get one: autobalancer catalog rig NAME --out machine.toml")


@app.command()
def rig(
    name: Annotated[str, typer.Argument(help='Such as "rodrigues_rig"; without one all are listed.')] = "",
    out: Annotated[Path | None, typer.Option(help="Machine file to write (.toml).")] = None,
    as_json: Json = False,
) -> None:
    """Print or write the machine file of a published rig; without a name list the rigs.

    Example: autobalancer catalog rig rodrigues_rig --out machine.toml
    """
    import tomllib

    from autobalancer.cli.terminal.output import MACHINE, check_suffix
    from autobalancer.files.rigs import rig_text
    from autobalancer.safe_file import write_text_safely

    if not name:
        rigs(as_json)
    elif out is not None:
        check_suffix("--out", out, MACHINE)
        typer.echo(f"written: {write_text_safely(out, rig_text(name))}")
    elif as_json:
        print_json(tomllib.loads(rig_text(name)))
    else:
        typer.echo(rig_text(name), nl=False)


def _digits(value: float) -> float:
    return float(f"{value:.4g}")


app.command("drag-laws")(drag)
app.command()(capability)
