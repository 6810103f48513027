"""``autobalancer identify``: parameters of a machine from measurements."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    import xarray as xr

    from autobalancer.rotordynamics.identification.free import FreeParameter


def identify(
    machine: Annotated[Path, typer.Argument(help="Machine file, where the fit begins.")],
    measurements: Annotated[Path, typer.Option(help="Measurement file: what is free and what was measured.")],
    free: Annotated[list[str] | None, typer.Option(help='More free parameters, "path=lower:upper"; repeat it.')] = None,
    loss: Annotated[
        str, typer.Option(help="linear, soft_l1, huber or cauchy; all but the first bear outliers.")
    ] = "linear",
    loss_scale: Annotated[float, typer.Option(help="Outliers begin at so many standard deviations.")] = 2.0,
    starts: Annotated[int, typer.Option(help="Number of searches, spread over the bounds.")] = 1,
    out: Annotated[Path | None, typer.Option(help="Write the fitted machine to this file.")] = None,
    result: Annotated[Path | None, typer.Option(help="Write all numbers of the fit to this file (.nc).")] = None,
    plot: Annotated[Path | None, typer.Option(help="Picture: curves, deviations, correlation.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print numbers in SI for a program.")] = False,
) -> None:
    """Fit parameters of a machine to measured modes, critical speeds, response curves and known values.

    Example: autobalancer identify rig.toml --measurements measured.toml --out fitted.toml
    """
    from autobalancer.files.machine_file import save_machine
    from autobalancer.rotordynamics.identification.identify import identify as fit
    from autobalancer.rotordynamics.identification.measurement_file import load_measurements

    parameters, measured = load_measurements(measurements)
    parameters += [_free(text) for text in free or []]
    found = fit(machine, parameters, measured, loss=loss, loss_scale=loss_scale, starts=starts)  # type: ignore[arg-type]
    if out is not None:
        save_machine(found.machine, out)
    if result is not None:
        _save(found.data, result)
    if plot is not None:
        from autobalancer.plots.identification import plot_identification
        from autobalancer.plots.save import save_picture

        save_picture(plot_identification(found.data), plot)
    if as_json:
        typer.echo(json.dumps(_plain(found.data), indent=2))
        return
    _show(found.data)
    for path in (out, result, plot):
        if path is not None:
            typer.echo(f"written: {path}")


def _free(text: str) -> FreeParameter:
    from autobalancer.errors import QuestionError
    from autobalancer.rotordynamics.identification.free import FreeParameter

    path, mark, bounds = text.partition("=")
    low, colon, high = bounds.partition(":")
    if not (mark and colon):
        raise QuestionError(f"--free: given {text!r}; write it as path=lower:upper, such as 'rotor.mass=1 kg:2 kg'")
    return FreeParameter(path.strip(), _number(low), _number(high))


def _number(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text.strip()


def _save(data: xr.Dataset, path: Path) -> None:
    from autobalancer.safe_file import write_safely

    plain = data.copy()
    plain.attrs["notes"] = "\n".join(data.attrs["notes"])
    plain["at_bound"] = plain["at_bound"].astype("int8")
    write_safely(path, plain.to_netcdf)


def _show(data: xr.Dataset) -> None:
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    from autobalancer.rotordynamics.identification.outcome import grouped, shown_unit, with_spread

    console = Console(soft_wrap=False)
    table = Table(title=data.attrs["title"], title_justify="left")
    for name in ("parameter", "identified", "uncertainty", "unit", "start"):
        table.add_column(name, justify="left" if name in ("parameter", "unit") else "right")
    for p in range(data.sizes["parameter"]):
        one = data.isel(parameter=p)
        spread = "at its bound" if bool(one["at_bound"]) else with_spread(float(one["uncertainty"]))
        cells = (f"{float(one['value']):.7g}", spread, str(one["unit"].item()), f"{float(one['start']):.6g}")
        table.add_row(escape(str(one["parameter"].item())), *cells)
    console.print(table)
    rows = Table(title="Measurements", title_justify="left")
    for name in ("quantity", "measured", "before", "after", "unit", "deviation in sigma"):
        rows.add_column(name, justify="left" if name in ("quantity", "unit") else "right")
    for label, part in grouped(data):
        count = part.sizes["row"]
        if count > 1:
            rms = math.sqrt(float((part["deviation"] ** 2).mean()))
            rows.add_row(f"{escape(label)}, {count} values", "", "", "", "", f"rms {rms:.2f}")
            continue
        factor, unit = shown_unit(part)
        numbers = [f"{factor * float(part[name][0]):.6g}" for name in ("measured", "before", "after")]
        rows.add_row(escape(label), *numbers, unit, f"{float(part['deviation'][0]):+.2f}")
    console.print(rows)
    a = data.attrs
    console.print(f"chi square {a['chi_square']:.4g}, {a['degrees_of_freedom']} degrees of freedom, rank {a['rank']}")
    for note in a["notes"]:
        console.print(f"[yellow]note:[/yellow] {escape(note)}")


def _plain(data: xr.Dataset) -> dict[str, Any]:
    """JSON has no infinity and no nan: they become texts and null."""

    def number(value: Any) -> Any:
        if isinstance(value, float) and not math.isfinite(value):
            return None if math.isnan(value) else "infinite"
        return [number(entry) for entry in value] if isinstance(value, list) else value

    names = [name for name in data.variables if name != "other_parameter"]
    attrs = ("chi_square", "degrees_of_freedom", "scatter_ratio", "rank", "outcome", "loss", "notes", "machine")
    return {str(name): number(data[name].values.tolist()) for name in names} | {
        name: number(data.attrs[name]) for name in attrs
    }
