"""``autobalancer catalog``: bearings, ball materials, fluids, and what a race of balls can compensate."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from autobalancer.catalog.fluids import FluidState

_HELP = "Look up bearings, ball materials, friction, fluids and published rigs."
app = typer.Typer(help=_HELP, no_args_is_help=True, rich_markup_mode="rich")

Json = Annotated[bool, typer.Option("--json", help="Print JSON in SI units.")]
Temperature = Annotated[str, typer.Option(help='Such as "40 degC".')]
FluidName = Annotated[str | None, typer.Option(help="Fluid around the balls, at 25 degC; without it no buoyancy.")]


@app.command()
def bearings(
    unbalance: Annotated[str | None, typer.Option(help='Unbalance to compensate, such as "594 g*mm".')] = None,
    max_outer: Annotated[str | None, typer.Option(help='Largest outer diameter, such as "80 mm".')] = None,
    min_bore: Annotated[str | None, typer.Option(help="Smallest catalog bore.")] = None,
    max_width: Annotated[str | None, typer.Option(help="Largest width.")] = None,
    material: Annotated[str, typer.Option(help="Material of the balls.")] = "steel",
    fluid: FluidName = None,
    limit: Annotated[int, typer.Option(min=0, help="Rows to print; 0 prints all.")] = 20,
    as_json: Json = False,
) -> None:
    """List bearings whose outer ring and balls compensate an unbalance in a given space.

    [dim]Example:[/dim] autobalancer catalog bearings --unbalance "594 g*mm" --max-outer "80 mm"
    """
    from autobalancer.catalog.bearings import RECONSTRUCTED, suitable_bearings
    from autobalancer.catalog.materials import material as find_material

    found = suitable_bearings(
        1e-12 if unbalance is None else _si(unbalance, "kg*m"),  # any bearing does, so all are listed
        max_outer=None if max_outer is None else _si(max_outer, "m"),
        min_bore=None if min_bore is None else _si(min_bore, "m"),
        max_width=None if max_width is None else _si(max_width, "m"),
        ball_density=find_material(material).density,
        fluid_density=_fluid_density(fluid),
    )
    shown = found[: limit or None]
    if as_json:
        needs = ("count", "capability", "ball_mass") if unbalance is None else ()
        rows = [{k: v for k, v in asdict(entry).items() if k not in needs} for entry in shown]
        typer.echo(json.dumps(rows, indent=2))
        return
    columns = [
        "bearing",
        "bore x outer\nx width mm",
        "orbit\nradius\nmm",
        "ball\nmm",
        "most\ng mm",
        "with\nballs",
    ]
    if unbalance is not None:
        columns += ["needs\nballs", "giving\ng mm", "mass\ng"]
    table = []
    for entry in shown:
        b = entry.bearing
        row = [b.designation + ("" if b.verified else " *")]
        row += [" x ".join(f"{size * 1e3:.5g}" for size in (b.bore, b.outer, b.width))]
        row += [f"{b.orbit_radius * 1e3:.5g}", f"{b.ball_diameter * 1e3:.5g}"]
        row += [_digits(entry.largest_capability * 1e6), str(entry.largest_useful_count)]
        if unbalance is not None:
            row += [str(entry.count), _digits(entry.capability * 1e6), _digits(entry.ball_mass * 1e3)]
        table.append(row)
    _table(f"{len(found)} bearings, {len(shown)} shown", columns, table)
    typer.echo(f"Source: Spannan (2021), Tables C.1 and C.2; capabilities are for balls of {material}.")
    if any(not entry.bearing.verified for entry in shown):
        typer.echo("* a value of this row was reconstructed from a damaged text: check it with the maker.")
    for entry in shown:
        if entry.bearing.remark and entry.bearing.remark != RECONSTRUCTED:
            typer.echo(f"{entry.bearing.designation}: {entry.bearing.remark}.")


@app.command()
def fluids(temperature: Temperature = "25 degC", as_json: Json = False) -> None:
    """List the fluids with their density and viscosity at a temperature.

    [dim]Example:[/dim] autobalancer catalog fluids --temperature "40 degC"
    """
    from autobalancer.catalog.fluids import fluid as find_fluid
    from autobalancer.catalog.fluids import fluids as all_fluids
    from autobalancer.errors import CatalogError

    kelvin = _si(temperature, "K")
    rows: list[dict[str, Any]] = []
    for entry in all_fluids():
        try:
            rows.append(asdict(find_fluid(entry.name, kelvin)))
        except CatalogError as reason:
            nothing = {"density": None, "viscosity": None, "temperature": kelvin}
            rows.append({"name": entry.name, **nothing, "source": entry.source, "remark": str(reason)})
    if as_json:
        typer.echo(json.dumps(rows, indent=2))
        return
    table = [
        [row["name"], "-", "-", "not known at this temperature"]
        if row["density"] is None
        else [row["name"], f"{row['density']:.4g}", f"{row['viscosity'] * 1e6:.4g}", row["remark"]]
        for row in rows
    ]
    title = f"Fluids at {kelvin - 273.15:.5g} degC"
    _table(title, ["fluid", "density\nkg/m^3", "viscosity\nmm^2/s", "remark"], table)
    typer.echo("Also: glycerol <number> wt% and glycerol <number> vol%. Sources: autobalancer catalog fluid NAME")


@app.command()
def fluid(
    name: Annotated[str, typer.Argument(help='Such as "silicone oil 20" or "glycerol 50 wt%".')],
    temperature: Temperature = "25 degC",
    as_json: Json = False,
) -> None:
    """Show one fluid with its source.

    [dim]Example:[/dim] autobalancer catalog fluid "silicone oil 20" --temperature "40 degC"
    """
    from autobalancer.catalog.fluids import fluid as find_fluid

    state = find_fluid(name, _si(temperature, "K"))
    if as_json:
        typer.echo(json.dumps(asdict(state), indent=2))
    else:
        _show(state)


@app.command()
def blend(
    first: Annotated[str, typer.Argument(help="Name of the first oil.")],
    second: Annotated[str, typer.Argument(help="Name of the second oil.")],
    viscosity: Annotated[str, typer.Option(help='Wanted viscosity, such as "5 mm^2/s".')],
    temperature: Temperature = "25 degC",
    basis: Annotated[str, typer.Option(help="What the fraction counts: mass or volume.")] = "mass",
    as_json: Json = False,
) -> None:
    """Mix two oils to a wanted viscosity.

    [dim]Example:[/dim] autobalancer catalog blend "silicone oil 1" "silicone oil 50" --viscosity "5 mm^2/s"
    """
    from autobalancer.catalog.fluids import blend as mix

    result = mix(first, second, _si(viscosity, "m^2/s"), _si(temperature, "K"), basis=basis)  # type: ignore[arg-type]
    if as_json:
        typer.echo(json.dumps(asdict(result), indent=2))
        return
    typer.echo(f"{100.0 * result.fraction:.2f} % of {result.first} by {result.basis}, the rest {result.second}")
    _show(result.fluid)


@app.command()
def materials(as_json: Json = False) -> None:
    """List the materials of balls with their densities.

    [dim]Example:[/dim] autobalancer catalog materials
    """
    from autobalancer.catalog.materials import materials as all_materials

    if as_json:
        typer.echo(json.dumps([asdict(entry) for entry in all_materials()], indent=2))
        return
    table = [[entry.name, f"{entry.density:.5g}", entry.source, entry.remark] for entry in all_materials()]
    _table("Materials of balls", ["material", "density\nkg/m^3", "source", "remark"], table)


@app.command()
def friction(as_json: Json = False) -> None:
    """List published coefficients of friction between a ball and its race, with what they were found on.

    [dim]Example:[/dim] autobalancer catalog friction
    """
    from textwrap import fill

    from autobalancer.catalog.friction import friction_coefficients

    found = friction_coefficients()
    if as_json:
        rows = [{k: None if v != v else v for k, v in asdict(entry).items()} for entry in found]
        typer.echo(json.dumps(rows, indent=2))
        return
    for entry in found:
        values = f"rolling resistance {entry.rolling_resistance:.0e}"
        if entry.adherence == entry.adherence:
            values += f", adherence {entry.adherence:.0e}"
        typer.secho(f"{entry.name}: {values}", bold=True)
        for text in (f"{entry.kind}: {entry.conditions}", entry.source, entry.remark):
            typer.echo(fill(text, 80, initial_indent="  ", subsequent_indent="    "))
    typer.echo("They differ by orders of magnitude: measure your own pair, or try both ends.")


@app.command()
def rigs(as_json: Json = False) -> None:
    """List the published rigs that come as machine files.

    [dim]Example:[/dim] autobalancer catalog rigs
    """
    from autobalancer.files.rigs import rig as find_rig
    from autobalancer.files.rigs import rigs as all_rigs

    found = {name: find_rig(name) for name in all_rigs()}
    if as_json:
        rows = [{"name": key, "title": m.name, "description": m.description} for key, m in found.items()]
        typer.echo(json.dumps(rows, indent=2))
        return
    _table("Published rigs", ["rig", "source"], [[key, m.description] for key, m in found.items()])
    typer.echo("Get one: autobalancer catalog rig NAME > machine.toml")


@app.command()
def rig(name: Annotated[str, typer.Argument(help='Such as "rodrigues_rig".')]) -> None:
    """Print the machine file of a published rig.

    [dim]Example:[/dim] autobalancer catalog rig rodrigues_rig > machine.toml
    """
    from autobalancer.files.rigs import rig_text

    typer.echo(rig_text(name), nl=False)


@app.command()
def drag(
    reynolds: Annotated[list[float] | None, typer.Option(help="Reynolds numbers to show; may be given again.")] = None,
    clear_width: Annotated[str, typer.Option(help='Of a race, such as "9.2 mm"; with ball and orbit.')] = "",
    ball_diameter: Annotated[str, typer.Option(help='Such as "12.3 mm".')] = "",
    orbit_radius: Annotated[str, typer.Option(help='Such as "77 mm".')] = "",
    plot: Annotated[str, typer.Option(help="Picture of the laws, .png, .svg or .pdf.")] = "",
    as_json: Json = False,
) -> None:
    """List the drag laws with their coefficients at some Reynolds numbers.

    [dim]Example:[/dim] autobalancer catalog drag --reynolds 100 --reynolds 24000 --plot drag.png
    """
    from autobalancer.errors import QuestionError
    from autobalancer.laws.drag import annulus_cd_re
    from autobalancer.laws.drag_coefficient import DragLaw, drag_laws, race_geometry

    laws: tuple[DragLaw, ...] = drag_laws()
    given = (clear_width, ball_diameter, orbit_radius)
    if any(given):
        if not all(given):
            raise QuestionError("give --clear-width, --ball-diameter and --orbit-radius together")
        width, diameter, orbit = (_si(text, "m") for text in given)
        laws = (*laws, race_geometry(annulus_cd_re(2.0 * width / diameter, 0.5 * diameter / orbit)))
    at = reynolds or [1.0, 10.0, 100.0, 1000.0, 20000.0]
    if min(at) <= 0.0:
        raise QuestionError(f"--reynolds: given {min(at):g}; must be greater than zero")
    rows = [
        {
            "name": law.name,
            "cd_re": law.cd_re,
            "stokes_end": law.stokes_end,
            "highest": law.highest,
            "source": law.source,
            "reynolds": at,
            "coefficient": (law.product(at) / at).tolist(),
        }
        for law in laws
    ]
    if plot:
        from autobalancer.plots.drag import plot_drag_laws
        from autobalancer.plots.save import save_picture

        save_picture(plot_drag_laws(laws), plot)
    if as_json:
        typer.echo(json.dumps(rows, indent=2))
        return
    columns = ["law", "c_d Re", "linear\nto Re", *(f"c_d at\n{re:g}" for re in at), "holds\nto Re", "source"]
    table = [
        [
            law.name,
            f"{law.cd_re:.4g}",
            f"{law.stokes_end:g}",
            *(f"{cd:.4g}" for cd in row["coefficient"]),
            f"{law.highest:.3g}",
            law.source,
        ]
        for law, row in zip(laws, rows, strict=True)
    ]
    _table("Drag laws", columns, table)
    typer.echo(
        "Also: race_geometry with clear_width, cd_re with a plateau, and table. Reynolds numbers are those of the ball diameter."
    )


@app.command()
def capability(
    orbit_radius: Annotated[str, typer.Option(help='Radius of the circle of ball centers, such as "77 mm".')],
    ball_diameter: Annotated[str, typer.Option(help='Such as "12.3 mm".')],
    material: Annotated[str, typer.Option(help="Material of the balls.")] = "steel",
    count: Annotated[int | None, typer.Option(help="Number of balls; by default the most useful one.")] = None,
    fluid: FluidName = None,
    as_json: Json = False,
) -> None:
    """Work out the unbalance that a race of balls can compensate.

    [dim]Example:[/dim] autobalancer catalog capability --orbit-radius "77 mm" --ball-diameter "12 mm"
    """
    from autobalancer.catalog.materials import material as find_material
    from autobalancer.laws import capability as laws

    radius, diameter = _si(orbit_radius, "m"), _si(ball_diameter, "m")
    density, fluid_density = find_material(material).density, _fluid_density(fluid)
    best = laws.largest_useful_count(radius, diameter)
    balls = best if count is None else count
    answer = {
        "count": balls,
        "capability": laws.capability(radius, diameter, density, balls, fluid_density=fluid_density),
        "ball_mass": balls * laws.ball_mass(diameter, density),
        "largest_useful_count": best,
        "largest_capability": laws.capability(radius, diameter, density, fluid_density=fluid_density),
        "largest_count": laws.largest_count(radius, diameter),
    }
    if as_json:
        typer.echo(json.dumps(answer, indent=2))
        return
    given, most = answer["capability"] * 1e6, answer["largest_capability"] * 1e6
    typer.echo(f"{balls} balls ({answer['ball_mass'] * 1e3:.4g} g) compensate {given:.5g} g mm")
    typer.echo(f"greatest: {most:.5g} g mm with {best} balls; room for {answer['largest_count']}")


def _si(text: str, unit: str) -> float:
    from autobalancer.units import option_to_si

    return float(option_to_si(text, unit))


def _fluid_density(name: str | None) -> float:
    from autobalancer.catalog.fluids import fluid as find_fluid

    return 0.0 if name is None else find_fluid(name).density


def _digits(value: float) -> str:
    return f"{float(f'{value:.4g}'):.10g}"


def _show(state: FluidState) -> None:
    typer.echo(f"{state.name} at {state.temperature - 273.15:.5g} degC")
    typer.echo(f"  density    {state.density:.5g} kg/m^3")
    typer.echo(f"  viscosity  {state.viscosity * 1e6:.5g} mm^2/s")
    typer.echo(f"  source     {state.source}")
    if state.remark:
        typer.echo(f"  remark     {state.remark}")


def _table(title: str, columns: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    from rich import box
    from rich.console import Console
    from rich.table import Table

    table = Table(title=title, box=box.SIMPLE_HEAD, title_justify="left", padding=(0, 1, 0, 0))
    for index, column in enumerate(columns):
        text = column in ("source", "remark")
        wraps = text or column.startswith("bore")
        table.add_column(column, justify="left" if text or index == 0 else "right", no_wrap=not wraps)
    for row in rows:
        table.add_row(*row)
    Console().print(table)
