"""``autobalancer ensemble``: thousands of run-ups of one machine, and how they end."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

import autobalancer as ab
from autobalancer.cli.terminal.options import Csv, Json, MachineFile, Outs, Plot, Seed, Settling, SpeedUnit, Unit
from autobalancer.cli.terminal.sheet import note, say, speed_sign

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
    from autobalancer.cli.terminal.command import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.group import stop_code
    from autobalancer.cli.terminal.options import optional
    from autobalancer.cli.terminal.progress_bar import progress_bar
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
    from autobalancer.cli.terminal.options import named
    from autobalancer.studies.ensemble.columns import SEED, unit_of_column
    from autobalancer.units.quantity import listed, whole

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


# ``autobalancer basin``: which end state follows from which start.


WORST = {
    "vibration": "the greatest vibration,",
    "peak_deflection": "the greatest deflection on the way (all balance),",
    "final_deflection": "the greatest deflection at its end,",
}


def basin(
    machine: MachineFile,
    speed: Annotated[str, typer.Option(help='Final rotor speed, such as "1200 rpm".')],
    x: Annotated[str, typer.Option(help='Starts along x: "NAME=from:to:count"; see below.')] = "",
    y: Annotated[str, typer.Option(help="Starts along y, in the same form.")] = "",
    random: Annotated[int, typer.Option(help="Instead of --x and --y: number of random starts.")] = 0,
    seed: Seed = 0,
    acceleration: Annotated[str, typer.Option(help='Run up from rest, such as "10 rad/s^2".')] = "",
    hold: Annotated[str, typer.Option(help='Longest time at the final speed, such as "30 s".')] = "",
    worst: Annotated[
        Path | None, typer.Option(help="Machine file (.toml) of the worst random start, to run it again.")
    ] = None,
    out: Outs = None,
    plot: Plot = None,
    speed_unit: Unit = SpeedUnit.RPM,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Run a machine from many starts and say in percent where it ends.

    A NAME is ball_angle[1], ball_speed[1] or the same of another ball, or acceleration.
    On several planes each plane has an end state and a residual of its own.
    With gravity across the axis an end is the verdict on a run.
    So it is in run-ups from random starts.

    Example: autobalancer basin discoidal.toml \\
      --speed "1200 rpm" --random 50 --acceleration "10 rad/s^2" \\
      --plot basin.png --worst worst.toml
    """
    from autobalancer.cli.terminal.command import MACHINE, Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.options import optional, quantity
    from autobalancer.cli.terminal.progress_bar import progress_bar
    from autobalancer.cli.terminal.sheet import print_sheet
    from autobalancer.errors import QuestionError
    from autobalancer.results.verdict import NO_VERDICT, NOT_SETTLED
    from autobalancer.studies.basin import basin as ask
    from autobalancer.studies.random_starts import worst_start

    one_form(as_json, as_csv)
    files, again = Files(out, plot), Files(worst, allowed=MACHINE)
    if worst is not None and not random:
        raise QuestionError("--worst: the worst is one of random starts; give their number, such as --random 50")
    axes = dict(_axis(option, text) for option, text in (("--x", x), ("--y", y)) if text)
    with progress_bar("runs") as update:
        found = ask(
            machine,
            quantity("--speed", speed, "rad/s"),
            axes or None,
            random=random,
            seed=seed,
            acceleration=optional("--acceleration", acceleration, "rad/s^2"),
            hold=optional("--hold", hold, "s"),
            progress=update,
        )
    shares = {str(name): float(found["share"].sel(end=name)) for name in found["end"].values}
    files.save(found, lambda: ab.plot.basin(found, speed_unit=speed_unit))
    if worst is not None:
        again.save(found, machine=worst_start(found))
    runs, overlapping = int(found["state"].size), int(found.attrs.get("overlapping", 0))
    left = _left(found)
    if as_json:
        drawn = {"seed": seed, "worst_start": _worst(found)} if random else {"overlapping_starts": overlapping}
        print_json({"machine": str(machine), "runs": runs, **drawn, "share": shares, **left})
        return
    columns = found.columns(speed_unit)
    if as_csv:
        print_csv(columns)
        return
    print_sheet(columns)
    if random:
        say("95 %: the share of very many starts is in this interval with a probability of 95 %")
    say(_counted(runs, overlapping, seed if random else None))
    for line in (*found.left(), *([_worst_line(found)] if random else [])):
        say(line, indent="  ")
    late = [word for word in (NO_VERDICT, NOT_SETTLED) if shares.get(word)]
    changing = f"runs with the end {' or '.join(map(repr, late))} still change; give a longer --hold" if late else ""
    ignored = f"ignores {found.attrs['ignores']}" if found.attrs.get("ignores") else ""
    for text in (changing, left["note"], left["gravity_note"], ignored):
        if text:
            note(text)
    files.say()
    again.say()
    if worst is not None:
        own = f" --seed {int(found['seed'][int(found.attrs['worst'])])}" if "seed" in found else ""
        typer.echo(f"run it again: autobalancer simulate {worst}{own}")


def _counted(runs: int, overlapping: int, seed: int | None) -> str:
    if seed is not None:
        return f"{runs} runs, random starts of seed {seed}; none puts balls on top of each other"
    if overlapping:
        return f"{runs} starts; {overlapping} of them put balls on top of each other and are not counted in the shares"
    return f"{runs} starts"


def _worst(found: Any) -> dict[str, Any]:
    """The worst start: its number, counted from 1, by which quantity, and this, m."""
    place, name = int(found.attrs["worst"]), str(found.attrs["worst_by"])
    return {"number": place + 1, "by": name, "value": float(found[name][place])}


def _worst_line(found: Any) -> str:
    from autobalancer.results.number_text import length_text

    worst = _worst(found)
    count = int(found["state"].size)
    return f"worst start: number {worst['number']} of {count}, with {WORST[worst['by']]} {length_text(worst['value'])}"


def _left(found: Any) -> dict[str, Any]:
    """What the ends leave, SI."""

    def plain(name: str) -> Any:
        return found[name].values.tolist()

    quantiles = [str(float(q)) for q in found["quantile"].values]
    left: dict[str, Any] = {
        "residual_unbalance": dict(zip(quantiles, plain("residual_quantile"), strict=True)),
        "unbalance": plain("unbalance"),
        "released": str(found.attrs["released"]),
        "note": str(found.attrs.get("friction_text", "")),
        "gravity_note": str(found.attrs.get("gravity_text", "")),
    }
    if "verdict_share" in found:
        left["verdict_share"] = dict(zip(found["verdict"].values.tolist(), plain("verdict_share"), strict=True))
    if found.planes():
        left["planes"] = found.planes()
    if "moving_share" in found:
        left["moving_share"] = plain("moving_share")
    for name in ("deflection", "vibration", "peak"):
        if f"{name}_quantile" in found:
            left[name] = dict(zip(quantiles, plain(f"{name}_quantile"), strict=True))
            left[f"{name}_without_balls"] = plain(f"{name}_without_balls")
    return left


def _axis(option: str, text: str) -> tuple[str, list[float]]:
    from autobalancer.cli.terminal.options import named
    from autobalancer.stability.basins import unit_of_axis
    from autobalancer.units.quantity import range_values

    name, span = named(option, text)
    return name, [float(value) for value in range_values(option, span, unit_of_axis(name))]


# ``autobalancer compare``: several machines side by side, or a run and what was measured.


def compare(
    machines: Annotated[
        list[Path],
        typer.Argument(
            help="Machine files, in the order of the table. Or a run (.nc) and a file of signals, orders or ball angles."
        ),
    ],
    at: Annotated[
        list[str] | None,
        typer.Option(help='Speed at which the deflection is wanted too, such as "40 rad/s". May be repeated.'),
    ] = None,
    duration: Annotated[str, typer.Option(help='Such as "60 s"; by default that of each machine.')] = "",
    tolerance: Annotated[float, typer.Option(help="Relative error per step.")] = 1e-7,
    seed: Seed = 0,
    out: Outs = None,
    plot: Plot = None,
    speed_unit: Unit = SpeedUnit.RPM,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Run several machines and put side by side what each run left, and from which speed on it balances.

    Of a run (.nc) and a measurement: the same curves and the same measures of both.

    Example: autobalancer compare variant_plain.toml variant_pins.toml \\
      --at "40 rad/s" --plot variants.png
    """
    from autobalancer.cli.terminal.command import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.options import optional, quantity
    from autobalancer.cli.terminal.progress_bar import progress_bar
    from autobalancer.cli.terminal.sheet import note, print_sheet
    from autobalancer.studies.compare import compare as compared

    one_form(as_json, as_csv)
    files = Files(out, plot)
    if machines[0].suffix.lower() == ".nc":
        _overlay(machines, seed, files, speed_unit, as_json, as_csv)
        return
    runs = [path for path in machines if path.suffix.lower() == ".nc"]
    if runs:
        raise ab.errors.QuestionError(f"{runs[0]}: a run comes first, and then what was measured")
    with progress_bar("machines") as update:
        found = compared(
            machines,
            at=[quantity("--at", speed, "rad/s") for speed in at or ()],
            duration=optional("--duration", duration, "s"),
            tolerance=tolerance,
            seed=seed,
            progress=update,
        )
    files.save(found, lambda: ab.plot.comparison(found))
    columns = found.columns(speed_unit)
    if as_json:
        print_json({str(name): part.values for name, part in found.variables.items() if "bin" not in part.dims})
        return
    if as_csv:
        print_csv(columns)
        return
    print_sheet(columns, found.heading())
    for remark in found.remarks():
        note(remark)
    files.say()


def _overlay(given: list[Path], seed: int, files: Any, speed_unit: str, as_json: bool, as_csv: bool) -> None:
    from autobalancer.cli.terminal.command import print_csv, print_json
    from autobalancer.cli.terminal.sheet import note, print_facts, print_sheet
    from autobalancer.measurement.comparison.run_up_fit import load_measured

    if len(given) != 2:
        raise ab.errors.QuestionError(
            "compare: after a run give one measurement: a table of signals or orders, or an .nc file"
        )
    run = ab.load_run(given[0])
    found = ab.compare(run, load_measured(given[1]), seed=seed)
    files.save(found, lambda: ab.plot.overlay(found, speed_unit=speed_unit))
    columns = found.columns(speed_unit)
    if as_json:
        names = (name for name, part in found.variables.items() if not {"time", "order_time"} & set(part.dims))
        print_json({str(name): found[name].values for name in names} | {"notes": found.remarks()})
        return
    if as_csv:
        print_csv(columns)
        return
    print_facts(found.facts(), found.heading())
    if found.sizes["measure"]:
        print_sheet(columns)
    for text in found.remarks():
        note(text)
    files.say()
