"""``autobalancer catalog fluids``, ``fluid`` and ``blend``."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated, Any

import typer

from autobalancer.cli.terminal.options import Csv, Json
from autobalancer.cli.terminal.output import one_form, print_csv, print_json
from autobalancer.cli.terminal.quantities import quantity
from autobalancer.cli.terminal.words import say

if TYPE_CHECKING:
    from autobalancer.catalog.fluid_table import FluidState
    from autobalancer.cli.terminal.sheet import Column

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
    from autobalancer.cli.terminal.sheet import Column, print_sheet

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
        from autobalancer.cli.terminal.sheet import Column

        share = Column(f"share of {result.first} by {result.basis}", [100.0 * result.fraction], "%")
        print_csv([share, *_fluid_columns(result.fluid)])
        return
    say(f"{100.0 * result.fraction:.2f} % of {result.first} by {result.basis}, the rest {result.second}")
    _show(result.fluid)


def _fluid_columns(state: FluidState) -> list[Column]:
    from autobalancer.cli.terminal.sheet import Column

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
