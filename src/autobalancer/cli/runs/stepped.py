"""``autobalancer stepped-response``: the response measured at one speed after the other, kept even if interrupted."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import autobalancer as ab
from autobalancer.cli.terminal.options import Csv, Json, MachineFile, Plot, Seed, SpeedUnit, Unit
from autobalancer.cli.terminal.words import note, speed_sign, speed_text


def stepped(
    machine: MachineFile,
    speeds: Annotated[str, typer.Option(help='"from:to:count", such as "600 rpm:5500 rpm:300", or one speed.')],
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
    seed: Seed = 0,
    mass_spread: Annotated[
        float, typer.Option(help="Relative difference in mass of equal balls that pass through each other.")
    ] = 1e-6,
    out: Annotated[
        Path | None, typer.Option(help="Result file (.nc); by default the machine's name with _stepped.nc here.")
    ] = None,
    plot: Plot = None,
    speed_unit: Unit = SpeedUnit.RPM,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Hold a speed, let transients die, measure, go to the next. Ctrl-C keeps what was measured; the same call goes on.

    Example: autobalancer stepped-response discoidal.toml \\
      --speeds "400 rpm:900 rpm:20" --dwell "5 s" --window "1 s" --plot s.png
    """
    from autobalancer.cli.runs.starts import say_seed
    from autobalancer.cli.terminal.exit_codes import stop_code
    from autobalancer.cli.terminal.output import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.progress import progress_bar
    from autobalancer.cli.terminal.quantities import optional, quantity, speed_range
    from autobalancer.files.machine_file import load_race_machine

    one_form(as_json, as_csv)
    out = out if out is not None else Path(f"{machine.stem}_stepped.nc")
    files = Files(out, plot, (".nc",))
    described = load_race_machine(machine)
    chosen = speed_range("--speeds", speeds)
    held, measured = quantity("--dwell", dwell, "s"), quantity("--window", window, "s")
    rate, most = optional("--acceleration", acceleration, "rad/s^2"), optional("--longest", longest, "s")
    from autobalancer.plots.drawing.save import save_picture
    from autobalancer.studies.stepped_response import stepped_response

    with progress_bar("speeds") as update:
        found = stepped_response(
            machine,
            chosen,
            dwell=held,
            window=measured,
            direction=direction,  # type: ignore[arg-type]
            start=start,  # type: ignore[arg-type]
            acceleration=rate,
            stations=station or None,
            settle=settle,
            longest=most,
            tolerance=tolerance,
            seed=seed,
            mass_spread=mass_spread,
            store=out,
            keep_on_interrupt=True,
            progress=update,
        )
    if plot is not None:
        save_picture(ab.plot.stepped_response(found, speed_unit=speed_unit), plot)
    if as_json:
        keys = ("speed", "direction", "amplitude", "greatest_mean_deflection", "motion")
        numbers = {key: found[key].values for key in keys if key in found.variables}
        about = {"result": str(out), "outcome": found.attrs["outcome"], "seed": seed}
        print_json({**about, **numbers, "outcomes": found["outcome"].values})
    elif as_csv:
        print_csv(found.columns(speed_sign()))
    else:
        for text in found.greatest(speed_text):
            typer.echo(text)
        if "coincidence_text" in found.attrs:
            note(found.attrs["coincidence_text"])
        say_seed(described, seed)
        files.say()
    if found.attrs["outcome"] == "interrupted":
        typer.echo(f"interrupted; the same command goes on from {out}.journal", err=True)
        raise typer.Exit(stop_code())
