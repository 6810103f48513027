"""``autobalancer identify``: parameters of a machine from measurements."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import autobalancer as ab
from autobalancer.cli.terminal.options import Csv, Json, MachineFile, Plot
from autobalancer.cli.terminal.words import note, say

if TYPE_CHECKING:
    import xarray as xr

    from autobalancer.cli.terminal.sheet import Column
    from autobalancer.machine import Machine
    from autobalancer.rotordynamics.identification.free import FreeParameter


def identify(
    machine: MachineFile,
    measurements: Annotated[Path, typer.Option(help="Measurement file: what is free and what was measured.")],
    free: Annotated[
        list[str] | None, typer.Option(help='More free parameters, "NAME=from:to", NAME a path. May be repeated.')
    ] = None,
    loss: Annotated[
        str, typer.Option(help="linear, soft_l1, huber or cauchy; all except linear are robust against outliers.")
    ] = "linear",
    loss_scale: Annotated[float, typer.Option(help="Outliers begin at so many standard deviations.")] = 2.0,
    starts: Annotated[int, typer.Option(help="Number of searches, spread over the bounds.")] = 1,
    out: Annotated[
        list[Path] | None,
        typer.Option(help="The fitted machine as .toml, the numbers as .nc, .csv or .json. May be repeated."),
    ] = None,
    plot: Plot = None,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Fit parameters of a machine to measured modes, critical speeds, response curves and known values.

    Example: autobalancer identify rodrigues_rig.toml \\
      --measurements rodrigues_critical_speeds.toml \\
      --out fitted.toml --out fit.nc
    """
    from autobalancer.cli.terminal.output import MACHINE, RESULT, Files, one_form, print_csv, print_json
    from autobalancer.files.machine_file import load_race_machine
    from autobalancer.measurement.comparison.measurement_file import load_measurements
    from autobalancer.rotordynamics.identification.identify import identify as fit

    one_form(as_json, as_csv)
    files = Files(out, plot, (*MACHINE, *RESULT))
    described = load_race_machine(machine)
    parameters, measured = load_measurements(measurements)
    parameters += [_free(text, described) for text in free or []]
    found = fit(described, parameters, measured, loss=loss, loss_scale=loss_scale, starts=starts)  # type: ignore[arg-type]
    files.save(_storable(found.data), lambda: ab.plot.identification(found.data), machine=found.machine)
    if as_json:
        print_json(_numbers(found.data))
        return
    if as_csv:
        print_csv(_parameters(found.data))
        return
    _show(found.data)
    files.say()


def _free(text: str, machine: Machine) -> FreeParameter:
    from autobalancer.cli.terminal.quantities import named, unit_of
    from autobalancer.rotordynamics.identification.free import FreeParameter
    from autobalancer.units.ranges import ends

    path, span = named("--free", text, "from:to")
    return FreeParameter(path, *ends("--free", span, unit_of("--free", path, machine)))


def _storable(data: xr.Dataset) -> xr.Dataset:
    """netCDF knows neither lists of texts as attributes nor booleans."""
    plain = data.copy()
    plain.attrs["notes"] = "\n".join(data.attrs["notes"])
    plain["at_bound"] = plain["at_bound"].astype("int8")
    return plain


def _parameters(data: xr.Dataset) -> list[Column]:
    from autobalancer.cli.terminal.sheet import Column
    from autobalancer.rotordynamics.identification.outcome import shown_parameter, with_spread

    bound = [bool(value) for value in data["at_bound"].values]
    factors, units = zip(
        *(shown_parameter(data.isel(parameter=p)) for p in range(data.sizes["parameter"])), strict=True
    )
    spread = [float(value) for value in factors * data["uncertainty"].values]
    said = ["at its bound" if stuck else with_spread(value) for stuck, value in zip(bound, spread, strict=True)]
    return [
        Column("parameter", [str(name) for name in data["parameter"].values], wraps=True),
        Column("identified", factors * data["value"].values, form=".7g"),
        Column("uncertainty", said),
        Column("unit", list(units)),
        Column("start", factors * data["start"].values, form=".6g"),
    ]


def _measurements(data: xr.Dataset) -> list[Column]:
    from autobalancer.cli.terminal.sheet import Column
    from autobalancer.rotordynamics.identification.outcome import grouped, shown_unit

    rows: list[list[Any]] = []
    for label, part in grouped(data):
        count = part.sizes["row"]
        if count > 1:
            rms = math.sqrt(float((part["deviation"] ** 2).mean()))
            rows.append([f"{label}, {count} values", None, None, None, "", f"rms {rms:.2f}"])
            continue
        factor, unit = shown_unit(part)
        numbers = [factor * float(part[name][0]) for name in ("measured", "before", "after")]
        rows.append([label, *numbers, unit, f"{float(part['deviation'][0]):+.2f}"])
    heads = ("quantity", "measured", "before", "after", "unit", "deviation in sigma")
    cells = zip(*rows, strict=True)
    return [
        Column(head, list(cell), form=".6g", wraps=head == "quantity") for head, cell in zip(heads, cells, strict=True)
    ]


def _show(data: xr.Dataset) -> None:
    from autobalancer.cli.terminal.sheet import print_sheet

    print_sheet(_parameters(data), data.attrs["title"])
    print_sheet(_measurements(data), "Measurements")
    a = data.attrs
    say(f"chi square {a['chi_square']:.4g}, {a['degrees_of_freedom']} degrees of freedom, rank {a['rank']}")
    for text in a["notes"]:
        note(text)


def _numbers(data: xr.Dataset) -> dict[str, Any]:
    names = [name for name in data.variables if name != "other_parameter" and "point" not in data[name].dims]
    attrs = ("chi_square", "degrees_of_freedom", "scatter_ratio", "rank", "outcome", "loss", "notes", "machine")
    return {str(name): data[name].values for name in names} | {name: data.attrs[name] for name in attrs}
