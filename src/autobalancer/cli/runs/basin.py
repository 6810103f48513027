"""``autobalancer basin``: which end state follows from which start."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

import autobalancer as ab
from autobalancer.cli.terminal.options import Csv, Json, MachineFile, Outs, Plot, Seed, SpeedUnit, Unit
from autobalancer.cli.terminal.words import note, say

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
    from autobalancer.cli.terminal.output import MACHINE, Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.progress import progress_bar
    from autobalancer.cli.terminal.quantities import optional, quantity
    from autobalancer.cli.terminal.sheet import print_sheet
    from autobalancer.errors import QuestionError
    from autobalancer.results.verdict.rule import NO_VERDICT, NOT_SETTLED
    from autobalancer.studies.basin import basin as ask
    from autobalancer.studies.worst_start import worst_start

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
    from autobalancer.cli.terminal.quantities import named
    from autobalancer.stability.basins.starts import unit_of_axis
    from autobalancer.units.ranges import range_values

    name, span = named(option, text)
    return name, [float(value) for value in range_values(option, span, unit_of_axis(name))]
