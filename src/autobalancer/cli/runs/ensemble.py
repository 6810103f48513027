"""``autobalancer ensemble``: thousands of run-ups of one machine, and how they end."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from autobalancer.cli.terminal.options import Csv, Json, MachineFile, Plot, Seed, Settling, SpeedUnit, Unit
from autobalancer.cli.terminal.words import say, speed_sign

QUANTILES = (0.0, 0.05, 0.5, 0.95, 1.0)


def ensemble(
    machine: MachineFile,
    column: Annotated[
        list[str] | None,
        typer.Option(help='What varies: "NAME=values", such as "drag=1e-4,2e-4 N*m*s"; may be repeated.'),
    ] = None,
    table: Annotated[
        Path | None, typer.Option(help="Text file with a column for each name; its first line has names and units.")
    ] = None,
    seeds: Annotated[int, typer.Option(min=0, help="Random starts with which each row is run; 0 for none.")] = 0,
    seed: Seed = 0,
    duration: Annotated[str, typer.Option(help='Such as "20 s"; by default run.duration of the file.')] = "",
    tolerance: Annotated[float, typer.Option(help="Relative error per step.")] = 1e-7,
    settling_from: Settling = "run-up",
    measures: Annotated[
        str,
        typer.Option(
            help='What to find of each member, such as "verdict,settling_time"; "all", or "none": only the ends.'
        ),
    ] = "all",
    record: Annotated[
        bool, typer.Option("--record-impossible", help="Note members that no machine can be, and run the others.")
    ] = False,
    workers: Annotated[int, typer.Option(min=0, help="Threads; 0 for one each core.")] = 0,
    out: Annotated[
        Path | None,
        typer.Option(help="Result file: .nc, .csv or .json; by default the machine's name with _ensemble.nc here."),
    ] = None,
    plot: Plot = None,
    speed_unit: Unit = SpeedUnit.RPM,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Run a machine thousands of times, each time with its own numbers, and count how the runs end.

    A NAME is a plain name such as viscosity, a path such as rotor.mass, ball_angle[1], ball_speed[1] or seed.
    All columns have the same length, or one value for all. Ctrl-C keeps the members that are done.

    Example: autobalancer ensemble stall_and_release.toml \\
      --column "drag=1e-4,2e-4 N*m*s" --seeds 10 --plot ensemble.png
    """
    import autobalancer as ab
    from autobalancer.cli.terminal.exit_codes import stop_code
    from autobalancer.cli.terminal.output import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.progress import progress_bar
    from autobalancer.cli.terminal.quantities import optional
    from autobalancer.cli.terminal.sheet import print_sheet
    from autobalancer.errors import QuestionError
    from autobalancer.files.machine_file import load_race_machine
    from autobalancer.studies.ensemble.ensemble import ensemble as ask

    one_form(as_json, as_csv)
    if column and table is not None:
        raise QuestionError("--column, --table: give columns here or in a table, not both")
    files = Files(out if out is not None else Path(f"{machine.stem}_ensemble.nc"), plot)
    described = load_race_machine(machine)
    columns = dict(_column(described, text) for text in column or ())
    with progress_bar("members") as update:
        found = ask(
            described,
            table if table is not None else columns or None,
            seeds=seeds or None,
            seed=seed,
            duration=optional("--duration", duration, "s"),
            tolerance=tolerance,
            settling_from=settling_from,
            measures=_measures(measures),
            impossible="record" if record else "refuse",
            workers=workers or None,
            progress=update,
            keep_on_interrupt=True,
        )
    files.save(found, lambda: ab.plot.ensemble(found, speed_unit=speed_unit))
    if as_json:
        print_json({"machine": str(machine), "members": found.sizes["member"], "seed": seed, **_numbers(found)})
    elif as_csv:
        print_csv(found.columns(speed_sign()))
    else:
        print_sheet(found.columns(speed_sign()))
        say("95 %: the share of very many members is in this interval with a probability of 95 %")
        for line in (*found.spread(), *found.without()):
            say(line, indent="  ")
        files.say()
    if found.attrs["outcome"] == "interrupted":
        typer.echo("interrupted; the members that were done are kept", err=True)
        raise typer.Exit(stop_code())


def _column(machine: Any, text: str) -> tuple[str, list[Any]]:
    """The name and the values of an option, read with the unit of the name."""
    from autobalancer.cli.terminal.quantities import named
    from autobalancer.studies.ensemble.columns import SEED, unit_of_column
    from autobalancer.units.ranges import listed, whole

    name, values = named("--column", text)
    if name == SEED:
        return name, list(whole("--column", values))
    return name, [float(value) for value in listed("--column", values, unit_of_column(machine, name))]


def _measures(text: str) -> list[str] | None:
    """The names in an option; None: all of them."""
    names = [name.strip() for name in text.split(",") if name.strip()]
    return {"all": None, "none": []}.get(text.strip(), names)


def _numbers(found: Any) -> dict[str, Any]:
    """Shares, and quantiles of the measures, SI."""
    shares = found.shares()
    ends = {
        str(end): {name: float(shares[name].sel(end=end)) for name in ("count", "share", "share_low", "share_high")}
        for end in shares["end"].values
    }
    measures = [name for name in found.data_vars if found[name].dims == ("member",) and found[name].dtype.kind == "f"]
    spread = {
        str(name): dict(zip(map(str, QUANTILES), found.quantiles(name, QUANTILES).tolist(), strict=True))
        for name in measures
    }
    return {"share": ends, "quantile": spread}
