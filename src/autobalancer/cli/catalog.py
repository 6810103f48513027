"""``autobalancer catalog``: bearings, ball materials, fluids, and what a race of balls can compensate."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import autobalancer as ab
from autobalancer.cli.terminal.command import MACHINE, Files, Reply, command
from autobalancer.cli.terminal.options import In
from autobalancer.errors import CatalogError, QuestionError
from autobalancer.files.examples import example_text
from autobalancer.results.display_units import moment_text
from autobalancer.tables import Column

if TYPE_CHECKING:
    from autobalancer.catalog.product_tables import FluidState, SuitableBearing

FluidName = Annotated[str | None, "Fluid around the balls, at --temperature; without it no buoyancy."]
Temperature = Annotated[Any, In("K"), 'Such as "40 degC".']
Limit = Annotated[float | None, In("m"), 'Such as "60 mm".']

TOPIC = "catalog"  # where the help of autobalancer lists the commands below


# ``autobalancer catalog bearings`` and ``bearing``.


@command(out=None)
def bearings(
    unbalance: Annotated[float | None, In("kg*m"), 'Unbalance to compensate, such as "594 g*mm".'] = None,
    min_outer: Limit = None,
    max_outer: Limit = None,
    min_bore: Limit = None,
    max_width: Limit = None,
    min_orbit: Limit = None,
    max_orbit: Limit = None,
    material: Annotated[str, "Material of the balls."] = "steel",
    fluid: FluidName = None,
    temperature: Temperature = "25 degC",
    sort: Annotated[str, "outer, mass (of the balls), capability, orbit, bore or width."] = "outer",
    limit: Annotated[int, typer.Option(min=0, help="Rows to print; 0 prints all.")] = 20,
) -> Reply:
    """List bearings whose outer ring and balls compensate an unbalance in a given space.

    The limits are those of the outer diameter, the catalog bore, the width, and the orbit radius of the balls.

    Example: autobalancer catalog bearings --unbalance "594 g*mm" \\
      --max-outer "80 mm" --sort mass
    """
    from autobalancer.catalog.product_tables import RECONSTRUCTED
    from autobalancer.catalog.product_tables import material as find_material

    limits = {
        "min_outer": min_outer,
        "max_outer": max_outer,
        "min_bore": min_bore,
        "max_width": max_width,
        "min_orbit": min_orbit,
        "max_orbit": max_orbit,
    }
    found = ab.catalog.suitable_bearings(
        unbalance or 1e-12,  # any bearing does, so all are listed
        **{name: size for name, size in limits.items() if size is not None},
        ball_density=find_material(material).density,
        fluid_density=ab.catalog.fluid(fluid, temperature).density if fluid else 0.0,
        sort=sort,
    )
    shown = found[: limit or None]
    needs = ("count", "capability", "ball_mass") if not unbalance else ()
    lines = [f"Source: Spannan (2021), Tables C.1 and C.2; capabilities are for balls of {material}."]
    if any(not entry.bearing.verified for entry in shown):
        lines.append("* a value of this row was reconstructed from a damaged text: check it with the maker.")
    remarks = {entry.bearing.designation: entry.bearing.remark for entry in shown}
    lines += [f"{name}: {text}." for name, text in remarks.items() if text and text != RECONSTRUCTED]
    return Reply(
        shown,
        [{key: value for key, value in asdict(entry).items() if key not in needs} for entry in shown],
        f"{len(found)} bearings, {len(shown)} shown",
        columns=_bearing_columns(shown, bool(unbalance)),
        lines=lines,
    )


def _bearing_columns(shown: tuple[SuitableBearing, ...], needs: bool) -> list[Column]:
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


def _digits(value: float) -> float:
    return float(f"{value:.4g}")


@command(out=None)
def bearing(name: Annotated[str, typer.Argument(help='Designation, such as "16021".')]) -> Reply:
    """Show one bearing and what a race with bearing = "..." takes from it.

    Example: autobalancer catalog bearing 16021
    """
    from autobalancer.laws.capabilities import largest_count, largest_useful_count

    b = ab.catalog.bearing(name)
    wall = b.orbit_radius + 0.5 * b.ball_diameter
    most, useful = (ask(b.orbit_radius, b.ball_diameter) for ask in (largest_count, largest_useful_count))
    sizes = {
        "bore": b.bore,
        "outer": b.outer,
        "width": b.width,
        "orbit radius": b.orbit_radius,
        "ball": b.ball_diameter,
    }
    chamber = (
        f'the chamber. Its wall has a radius of {1e3 * wall:.5g} mm; with lids on the faces of the ring height = "'
        f'{1e3 * b.width:.5g} mm"; width depends on what stands in place of the inner ring, '
        f"{1e3 * (wall - 0.5 * b.bore):.5g} mm down to the bore"
    )
    taken = f"orbit_radius {1e3 * b.orbit_radius:.5g} mm, diameter of the balls {1e3 * b.ball_diameter:.5g} mm"
    facts = [
        ("sizes", ", ".join(f"{head} {1e3 * size:.5g} mm" for head, size in sizes.items())),
        ("the race takes", taken),
        ("room for", f"{most} balls; {useful} compensate the most"),
        ("not known", chamber),
        ("source", "Spannan (2021), Tables C.1 and C.2" + (f"; {b.remark}" if b.remark else "")),
    ]
    lengths = [Column(head, [1e3 * size], "mm") for head, size in sizes.items()]
    use = f'In a machine file: bearing = "{b.designation}" in a race, and balls = [{{ count = 2, material = "steel" }}]'
    return Reply(
        b,
        {**asdict(b), "wall_radius": wall, "largest_count": most, "largest_useful_count": useful},
        f"{b.designation} ({b.family.replace('_', ' ')})",
        facts,
        [Column("bearing", [b.designation]), *lengths, Column("largest count", [most])],
        brief=True,
        lines=[use],
    )


# ``autobalancer catalog fluids``, ``fluid`` and ``blend``.


@command(out=None)
def fluids(
    temperature: Annotated[
        list[float] | None, In("K"), 'Such as "40 degC"; by default 25 degC. May be repeated.'
    ] = None,
) -> Reply:
    """List the fluids with their density and viscosity at a temperature, or at several.

    Example: autobalancer catalog fluids \\
      --temperature "20 degC" --temperature "40 degC"
    """
    kelvins = temperature or [298.15]
    states = [[_state(entry, kelvin) for entry in ab.catalog.fluids()] for kelvin in kelvins]
    columns = [Column("fluid", [row["name"] for row in states[0]])]
    for kelvin, rows in zip(kelvins, states, strict=True):
        at = f" at {kelvin - 273.15:.5g} degC" if len(kelvins) > 1 else ""
        columns.append(Column(f"density{at}", [row["density"] for row in rows], "kg/m^3", ".4g"))
        numbers = [None if row["viscosity"] is None else 1e6 * row["viscosity"] for row in rows]
        columns.append(Column(f"viscosity{at}", numbers, "mm^2/s", ".4g"))
    remarks = [next((row["remark"] for row in rows if row["remark"]), "") for rows in zip(*states, strict=True)]
    columns.append(Column("remark", remarks, wraps=True))
    heading = "Fluids" + (f" at {kelvins[0] - 273.15:.5g} degC" if len(kelvins) == 1 else "")
    also = "Also: glycerol <number> wt% and glycerol <number> vol%. Sources: autobalancer catalog fluid NAME"
    return Reply(None, [row for rows in states for row in rows], heading, columns=columns, lines=[also])


def _state(entry: Any, kelvin: float) -> dict[str, Any]:
    try:
        return asdict(ab.catalog.fluid(entry.name, kelvin))
    except CatalogError:
        nothing = {"density": None, "viscosity": None, "temperature": kelvin}
        remark = f"not known at {kelvin - 273.15:.5g} degC"
        return {"name": entry.name, **nothing, "source": entry.source, "remark": remark}


@command(out=None)
def fluid(
    name: Annotated[str, typer.Argument(help='Such as "silicone oil 20" or "glycerol 50 wt%".')],
    temperature: Temperature = "25 degC",
) -> Reply:
    """Show one fluid with its source.

    Example: autobalancer catalog fluid "silicone oil 20" --temperature "40 degC"
    """
    return _fluid(ab.catalog.fluid(name, temperature))


@command("catalog.blend", take="basis", out=None)
def blend(
    first: Annotated[str, typer.Argument(help="Name of the first oil.")],
    second: Annotated[str, typer.Argument(help="Name of the second oil.")],
    viscosity: Annotated[float, In("m^2/s"), 'Wanted viscosity, such as "5 mm^2/s".'],
    temperature: Temperature = "25 degC",
    **options: Any,
) -> Reply:
    """Mix two oils to a wanted viscosity.

    Example: autobalancer catalog blend "silicone oil 1" "silicone oil 50" \\
      --viscosity "5 mm^2/s"
    """
    found = ab.catalog.blend(first, second, viscosity, temperature, **options)
    reply = _fluid(found.fluid)
    share = Column(f"share of {found.first} by {found.basis}", [100.0 * found.fraction], "%")
    said = f"{100.0 * found.fraction:.2f} % of {found.first} by {found.basis}, the rest {found.second}"
    return Reply(found, asdict(found), said, reply.facts, [share, *(reply.columns or ())], brief=True)


def _fluid(state: FluidState) -> Reply:
    """A fluid with its source."""
    degrees = state.temperature - 273.15
    facts = [
        ("density", f"{state.density:.5g} kg/m^3"),
        ("viscosity", f"{state.viscosity * 1e6:.5g} mm^2/s"),
        ("source", state.source),
        *([("remark", state.remark)] if state.remark else []),
    ]
    columns = [
        Column("fluid", [state.name]),
        Column("temperature", [degrees], "degC"),
        Column("density", [state.density], "kg/m^3"),
        Column("viscosity", [1e6 * state.viscosity], "mm^2/s"),
        Column("source", [state.source]),
    ]
    return Reply(state, asdict(state), f"{state.name} at {degrees:.5g} degC", facts, columns, brief=True)


# ``autobalancer catalog materials``, ``friction``, ``rigs`` and ``rig``.


@command(out=None)
def materials() -> Reply:
    """List the materials of balls with their densities.

    Example: autobalancer catalog materials
    """
    found = ab.catalog.materials()
    columns = [
        Column("material", [entry.name for entry in found]),
        Column("density", [entry.density for entry in found], "kg/m^3"),
        Column("source", [entry.source for entry in found], wraps=True),
        Column("remark", [entry.remark for entry in found], wraps=True),
    ]
    return Reply(found, heading="Materials of balls", columns=columns)


@command(out=None)
def friction() -> Reply:
    """List published coefficients of friction between a ball and its race, with what they were found on.

    Example: autobalancer catalog friction
    """
    found = ab.catalog.friction()
    names = ("name", "kind", "rolling_resistance", "adherence", "conditions", "source", "remark")
    columns = [Column(name.replace("_", " "), [getattr(entry, name) for entry in found]) for name in names]
    facts = []
    for entry in found:
        values = f"rolling resistance {entry.rolling_resistance:.0e}"
        values += f", adherence {entry.adherence:.0e}" if entry.adherence == entry.adherence else ""
        about = (values, f"{entry.kind}: {entry.conditions}", entry.source, entry.remark)
        facts.append((entry.name, "\n".join(filter(None, about))))
    differ = "They differ by orders of magnitude: measure your own pair, or try both ends."
    return Reply(found, heading="Friction", facts=facts, columns=columns, brief=True, lines=[differ])


@command(out=None)
def rigs() -> Reply:
    """List the published rigs that come as machine files.

    Example: autobalancer catalog rigs
    """
    found = {name: ab.example(name) for name in ab.catalog.examples("rigs")}
    columns = [Column("rig", list(found)), Column("source", [m.description for m in found.values()], wraps=True)]
    numbers = [{"name": key, "title": m.name, "description": m.description} for key, m in found.items()]
    one = "Get one: autobalancer catalog rig NAME --out machine.toml"
    return Reply(None, numbers, "Published rigs", columns=columns, lines=[one])


@command(out=None, csv=False)
def rig(
    name: Annotated[str, typer.Argument(help='Such as "rodrigues_rig"; catalog rigs lists them.')],
    out: Annotated[Path | None, "Machine file to write (.toml)."] = None,
) -> Reply:
    """Print or write the machine file of a published rig.

    Example: autobalancer catalog rig rodrigues_rig --out machine.toml
    """
    import tomllib

    text = example_text(name)
    files = Files(out, allowed=MACHINE)
    files.save(None, machine=text)
    return Reply(None, tomllib.loads(text), code=text.rstrip("\n") if out is None else f"written: {out}")


# ``autobalancer catalog drag-laws`` and ``capability``.


@command(out=None, draw=True)
def drag_laws(
    reynolds: Annotated[list[float] | None, "Reynolds number to show. May be repeated."] = None,
    clear_width: Annotated[float | None, In("m"), 'Of a race, such as "9.2 mm"; with ball and orbit.'] = None,
    ball_diameter: Annotated[float | None, In("m"), 'Such as "12.3 mm".'] = None,
    orbit_radius: Limit = None,
) -> Reply:
    """List the drag laws with their coefficients at some Reynolds numbers.

    Example: autobalancer catalog drag-laws --reynolds 100 --reynolds 24000 --plot drag.png
    """
    from autobalancer.drag.race_geometry import race_geometry
    from autobalancer.laws.drag_coefficient import DragLaw, annulus_cd_times_re

    laws: tuple[DragLaw, ...] = ab.laws.drag_laws()
    if clear_width is not None and ball_diameter is not None and orbit_radius is not None:
        ratio = annulus_cd_times_re(2.0 * clear_width / ball_diameter, 0.5 * ball_diameter / orbit_radius)
        laws = (*laws, race_geometry(ratio))
    elif clear_width is not None or ball_diameter is not None or orbit_radius is not None:
        raise QuestionError("give --clear-width, --ball-diameter and --orbit-radius together")
    at = reynolds or [1.0, 10.0, 100.0, 1000.0, 20000.0]
    if min(at) <= 0.0:
        raise QuestionError(f"--reynolds: given {min(at):g}; must be greater than zero")
    coefficients = [(law.product(at) / at).tolist() for law in laws]
    names = ("name", "cd_times_re", "stokes_end", "highest", "source")
    rows = [
        {name: getattr(law, name) for name in names}
        | {"plateau": _plateau(law), "reynolds": at, "coefficient": coefficients[i]}
        for i, law in enumerate(laws)
    ]
    columns = [
        Column("law", [law.name for law in laws]),
        Column("c_d Re", [law.cd_times_re for law in laws], form=".4g"),
        Column("linear to Re", [law.stokes_end for law in laws], form="g"),
        *(Column(f"c_d at Re {re:g}", [row[i] for row in coefficients], form=".4g") for i, re in enumerate(at)),
        Column("plateau", [_plateau(law) for law in laws], form=".3g"),
        Column("holds to Re", [law.highest for law in laws], form=".3g"),
        Column("source", [law.source for law in laws], wraps=True),
    ]
    also = "Also: race_geometry with clear_width, cd_times_re with plateau, and table. Reynolds numbers are of the diameter."
    return Reply(None, rows, "Drag laws", columns=columns, lines=[also], draw=lambda: ab.plot.drag_laws(laws))


def _plateau(law: Any) -> float | None:
    """Drag coefficient at high Reynolds numbers; ``None`` where the law has none."""
    import math

    end = float(law.kept_from)
    return float(law.product(end)) / end if 0.0 < end < math.inf else None


@command(out=None)
def capability(
    orbit_radius: Annotated[float, In("m"), 'Radius of the circle of ball centers, such as "77 mm".'],
    ball_diameter: Annotated[float, In("m"), 'Such as "12.3 mm".'],
    material: Annotated[str, "Material of the balls."] = "steel",
    count: Annotated[int | None, "Number of balls; by default the most useful one."] = None,
    fluid: FluidName = None,
    temperature: Temperature = "25 degC",
) -> Reply:
    """Work out the unbalance that a race of balls can compensate.

    Example: autobalancer catalog capability --orbit-radius "77 mm" --ball-diameter "12 mm"
    """
    from autobalancer.catalog.product_tables import material as find_material
    from autobalancer.laws import capabilities as laws

    size = (orbit_radius, ball_diameter)
    density, around = (
        find_material(material).density,
        ab.catalog.fluid(fluid, temperature).density if fluid else 0.0,
    )
    best = laws.largest_useful_count(*size)
    balls = best if count is None else count
    answer = {
        "count": balls,
        "capability": laws.capability(*size, density, balls, fluid_density=around),
        "ball_mass": balls * laws.ball_mass(ball_diameter, density),
        "largest_useful_count": best,
        "largest_capability": laws.capability(*size, density, fluid_density=around),
        "largest_count": laws.largest_count(*size),
    }
    units = {"capability": "kg m", "largest_capability": "kg m", "ball_mass": "kg"}
    able, most = moment_text(answer["capability"], 5), moment_text(answer["largest_capability"], 5)
    lines = [
        f"{balls} balls ({answer['ball_mass'] * 1e3:.4g} g) compensate {able}",
        f"greatest: {most} with {best} balls; room for {answer['largest_count']}",
    ]
    columns = [Column(key.replace("_", " "), [value], units.get(key, "")) for key, value in answer.items()]
    return Reply(None, answer, columns=columns, brief=True, lines=lines)
