"""``autobalancer catalog``: bearings, ball materials, fluids, and what a race of balls can compensate."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import autobalancer as ab
from autobalancer.cli.terminal.command import one_form, print_csv, print_json
from autobalancer.cli.terminal.options import Csv, Json, quantity
from autobalancer.cli.terminal.sheet import say
from autobalancer.results.number_text import moment_text

if TYPE_CHECKING:
    from autobalancer.catalog.bearing_table import SuitableBearing
    from autobalancer.catalog.fluid_table import FluidState
    from autobalancer.tables import Column


# ``autobalancer catalog fluids``, ``fluid`` and ``blend``.


FluidName = Annotated[
    str | None, typer.Option(help="Fluid around the balls, at --temperature; without it no buoyancy.")
]
Temperature = Annotated[str, typer.Option(help='Such as "40 degC".')]


def fluids(
    temperature: Annotated[
        list[str] | None, typer.Option(help='Such as "40 degC"; by default 25 degC. May be repeated.')
    ] = None,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """List the fluids with their density and viscosity at a temperature, or at several.

    Example: autobalancer catalog fluids \\
      --temperature "20 degC" --temperature "40 degC"
    """
    from autobalancer.catalog.fluid_table import fluids as all_fluids
    from autobalancer.cli.terminal.sheet import print_sheet
    from autobalancer.tables import Column

    one_form(as_json, as_csv)
    kelvins = [float(quantity("--temperature", text, "K")) for text in temperature or ["25 degC"]]
    states = [[_state(entry, kelvin) for entry in all_fluids()] for kelvin in kelvins]
    if as_json:
        print_json([row for rows in states for row in rows])
        return
    columns = [Column("fluid", [row["name"] for row in states[0]])]
    for kelvin, rows in zip(kelvins, states, strict=True):
        at = f" at {kelvin - 273.15:.5g} degC" if len(kelvins) > 1 else ""
        columns.append(Column(f"density{at}", [row["density"] for row in rows], "kg/m^3", ".4g"))
        numbers = [None if row["viscosity"] is None else 1e6 * row["viscosity"] for row in rows]
        columns.append(Column(f"viscosity{at}", numbers, "mm^2/s", ".4g"))
    remarks = [next((row["remark"] for row in rows if row["remark"]), "") for rows in zip(*states, strict=True)]
    columns.append(Column("remark", remarks, wraps=True))
    if as_csv:
        print_csv(columns)
        return
    print_sheet(columns, "Fluids" + (f" at {kelvins[0] - 273.15:.5g} degC" if len(kelvins) == 1 else ""))
    say("Also: glycerol <number> wt% and glycerol <number> vol%. Sources: autobalancer catalog fluid NAME")


def _state(entry: Any, kelvin: float) -> dict[str, Any]:
    from autobalancer.catalog.fluid_table import fluid as find_fluid
    from autobalancer.errors import CatalogError

    try:
        return asdict(find_fluid(entry.name, kelvin))
    except CatalogError:
        nothing = {"density": None, "viscosity": None, "temperature": kelvin}
        remark = f"not known at {kelvin - 273.15:.5g} degC"
        return {"name": entry.name, **nothing, "source": entry.source, "remark": remark}


def fluid(
    name: Annotated[str, typer.Argument(help='Such as "silicone oil 20" or "glycerol 50 wt%".')],
    temperature: Temperature = "25 degC",
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Show one fluid with its source.

    Example: autobalancer catalog fluid "silicone oil 20" --temperature "40 degC"
    """
    from autobalancer.catalog.fluid_table import fluid as find_fluid

    one_form(as_json, as_csv)
    state = find_fluid(name, float(quantity("--temperature", temperature, "K")))
    if as_json:
        print_json(asdict(state))
    elif as_csv:
        print_csv(_fluid_columns(state))
    else:
        _show(state)


def blend(
    first: Annotated[str, typer.Argument(help="Name of the first oil.")],
    second: Annotated[str, typer.Argument(help="Name of the second oil.")],
    viscosity: Annotated[str, typer.Option(help='Wanted viscosity, such as "5 mm^2/s".')],
    temperature: Temperature = "25 degC",
    basis: Annotated[str, typer.Option(help="What the fraction counts: mass or volume.")] = "mass",
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Mix two oils to a wanted viscosity.

    Example: autobalancer catalog blend "silicone oil 1" "silicone oil 50" \\
      --viscosity "5 mm^2/s"
    """
    from autobalancer.catalog.fluid_table import blend as mix

    one_form(as_json, as_csv)
    wanted, kelvin = (
        float(quantity("--viscosity", viscosity, "m^2/s")),
        float(quantity("--temperature", temperature, "K")),
    )
    result = mix(first, second, wanted, kelvin, basis=basis)  # type: ignore[arg-type]
    if as_json:
        print_json(asdict(result))
        return
    if as_csv:
        from autobalancer.tables import Column

        share = Column(f"share of {result.first} by {result.basis}", [100.0 * result.fraction], "%")
        print_csv([share, *_fluid_columns(result.fluid)])
        return
    say(f"{100.0 * result.fraction:.2f} % of {result.first} by {result.basis}, the rest {result.second}")
    _show(result.fluid)


def _fluid_columns(state: FluidState) -> list[Column]:
    from autobalancer.tables import Column

    return [
        Column("fluid", [state.name]),
        Column("temperature", [state.temperature - 273.15], "degC"),
        Column("density", [state.density], "kg/m^3"),
        Column("viscosity", [1e6 * state.viscosity], "mm^2/s"),
        Column("source", [state.source]),
    ]


def _show(state: FluidState) -> None:
    typer.echo(f"{state.name} at {state.temperature - 273.15:.5g} degC")
    typer.echo(f"  density    {state.density:.5g} kg/m^3")
    typer.echo(f"  viscosity  {state.viscosity * 1e6:.5g} mm^2/s")
    say(f"  source     {state.source}", indent=" " * 13)
    if state.remark:
        say(f"  remark     {state.remark}", indent=" " * 13)


def fluid_density(name: str | None, temperature: str) -> float:
    """Of a fluid at a temperature, kg/m^3; zero without one."""
    from autobalancer.catalog.fluid_table import fluid as find_fluid

    return 0.0 if name is None else find_fluid(name, float(quantity("--temperature", temperature, "K"))).density


# ``autobalancer catalog drag-laws`` and ``capability``.


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
    from autobalancer.cli.terminal.command import Files
    from autobalancer.cli.terminal.sheet import print_sheet
    from autobalancer.drag import drag_laws
    from autobalancer.drag.race_geometry import race_geometry
    from autobalancer.errors import QuestionError
    from autobalancer.laws.drag_coefficient import DragLaw, annulus_cd_re

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
        from autobalancer.plots.drawing.style import save_picture

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
    from autobalancer.tables import Column

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
    from autobalancer.catalog.small_tables import material as find_material
    from autobalancer.laws import capabilities as laws

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
        from autobalancer.tables import Column

        units = {"capability": "kg m", "largest_capability": "kg m", "ball_mass": "kg"}
        print_csv([Column(key.replace("_", " "), [value], units.get(key, "")) for key, value in answer.items()])
        return
    given, most = moment_text(answer["capability"], 5), moment_text(answer["largest_capability"], 5)
    typer.echo(f"{balls} balls ({answer['ball_mass'] * 1e3:.4g} g) compensate {given}")
    typer.echo(f"greatest: {most} with {best} balls; room for {answer['largest_count']}")


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
    from autobalancer.catalog.small_tables import material as find_material
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
    from autobalancer.tables import Column

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
    from autobalancer.cli.terminal.sheet import print_facts
    from autobalancer.laws.capabilities import largest_count, largest_useful_count
    from autobalancer.tables import Column

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
    from autobalancer.catalog.small_tables import materials as all_materials
    from autobalancer.cli.terminal.sheet import print_sheet
    from autobalancer.tables import Column

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
    from autobalancer.catalog.small_tables import friction
    from autobalancer.tables import Column

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
    from autobalancer.cli.terminal.sheet import print_sheet
    from autobalancer.files.examples import rig as find_rig
    from autobalancer.files.examples import rigs as all_rigs
    from autobalancer.tables import Column

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

    from autobalancer.cli.terminal.command import MACHINE, check_suffix
    from autobalancer.files.examples import rig_text
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
