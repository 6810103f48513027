"""``autobalancer stepped``: the response measured at one speed after the other, kept even if interrupted."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Annotated

import typer


def stepped(
    machine: Annotated[Path, typer.Argument(help="Machine file.")],
    speed: Annotated[str, typer.Option("--speed", help='"from:to:count", such as "600rpm:5500rpm:300", or one speed.')],
    dwell: Annotated[str, typer.Option(help='Time at a speed before it is measured, such as "6 s".')],
    window: Annotated[str, typer.Option(help='Length of the measurement, such as "1 s".')],
    direction: Annotated[str, typer.Option(help="up, down or both.")] = "up",
    start: Annotated[
        str, typer.Option(help="carried: on from the speed before; fixed: each from the start state.")
    ] = "carried",
    acceleration: Annotated[
        str, typer.Option(help='Way to the next speed, such as "10 rad/s^2"; by default at once.')
    ] = "",
    station: Annotated[
        list[str] | None, typer.Option(help="Name of a station to average over; by default all.")
    ] = None,
    settle: Annotated[
        float | None, typer.Option(help="Measure again until amplitudes change less, such as 0.01.")
    ] = None,
    longest: Annotated[str, typer.Option(help='With --settle: longest time at a speed, such as "60 s".')] = "",
    tolerance: Annotated[float, typer.Option(help="Relative error per step.")] = 1e-7,
    seed: Annotated[int, typer.Option(help="For balls without start angles.")] = 0,
    mass_spread: Annotated[
        float, typer.Option(help="Relative difference in mass of equal balls that pass through each other.")
    ] = 1e-6,
    out: Annotated[
        Path | None, typer.Option(help="Result file; by default the machine's name with _stepped.nc here.")
    ] = None,
    plot: Annotated[Path | None, typer.Option(help="Picture: png, svg or pdf.")] = None,
    speed_unit: Annotated[str, typer.Option(help="rpm, rad/s or Hz, for the picture.")] = "rpm",
    as_json: Annotated[bool, typer.Option("--json", help="Print the numbers in SI for a program.")] = False,
) -> None:
    """Hold a speed, let transients die, measure, go to the next. Ctrl-C keeps what was measured; the same call goes on.

    Example: autobalancer stepped rig.toml --speed 600rpm:5500rpm:200 --dwell 5s --window 1s --direction both --plot s.png
    """
    from rich.console import Console
    from rich.progress import Progress

    from autobalancer.cli.exit_codes import stop_code
    from autobalancer.cli.ranges import speed_range
    from autobalancer.cli.run import _say_if_first
    from autobalancer.safe_file import ready_to_write
    from autobalancer.units import option_to_si

    out = out if out is not None else Path(f"{machine.stem}_stepped.nc")
    ready_to_write(out)
    console = Console(stderr=True)
    chosen = speed_range(speed)
    _say_if_first(console)
    from autobalancer.plots.frequency_response import plot_frequency_response
    from autobalancer.plots.save import save_picture
    from autobalancer.studies.frequency_response import frequency_response

    with Progress(console=console, transient=True) as bar:
        task = bar.add_task("speeds")
        found = frequency_response(
            machine,
            chosen,
            dwell=option_to_si(dwell, "s"),
            window=option_to_si(window, "s"),
            direction=direction,  # type: ignore[arg-type]
            start=start,  # type: ignore[arg-type]
            acceleration=option_to_si(acceleration, "rad/s^2") if acceleration else None,
            stations=station or None,
            settle=settle,
            longest=option_to_si(longest, "s") if longest else None,
            tolerance=tolerance,
            seed=seed,
            mass_spread=mass_spread,
            store=out,
            keep_on_interrupt=True,
            progress=lambda done, total: bar.update(task, completed=done, total=total),
        )
    if plot is not None:
        save_picture(plot_frequency_response(found, speed_unit=speed_unit), plot)
    whole = found["amplitude"] if "direction" in found.dims else found["amplitude"].expand_dims("direction")
    if as_json:
        keys = ("speed", "direction", "amplitude", "greatest_mean_deflection", "motion")
        numbers = {key: _plain(found[key].values.tolist()) for key in keys if key in found.variables}
        numbers["outcomes"] = found["outcome"].values.tolist()
        typer.echo(json.dumps({"result": str(out), "outcome": found.attrs["outcome"], **numbers}, indent=2))
    else:
        for name, row in zip(whole["direction"].values, whole.values, strict=True):
            reached = [i for i, value in enumerate(row) if math.isfinite(value)]
            if reached:
                peak = max(reached, key=lambda i: row[i])
                at = float(found["speed"].values[peak]) * 30.0 / math.pi
                typer.echo(f"{name}: greatest amplitude {1e6 * row[peak]:.5g} um at {at:.5g} rpm")
        if "coincidence_text" in found.attrs:
            console.print(f"[yellow]note:[/yellow] {found.attrs['coincidence_text']}")
        for path in (out, plot):
            if path is not None and path.exists():
                typer.echo(f"written: {path}")
    if found.attrs["outcome"] == "interrupted":
        typer.echo(f"interrupted; the same command goes on from {out}.journal", err=True)
        raise typer.Exit(stop_code())


def _plain(value: object) -> object:
    """Numbers that JSON can say."""
    if isinstance(value, list):
        return [_plain(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
