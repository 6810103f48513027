"""``autobalancer chamber design``: the balls, the friction and the fluid with which a deep chamber balances best."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import autobalancer as ab
from autobalancer.cli.runs.archive import archive
from autobalancer.cli.runs.study import app, asked_of, bar, chamber_machine, said_when_stopped
from autobalancer.cli.terminal.options import Csv, Json, Outs, Plot
from autobalancer.cli.terminal.output import Files, one_form, print_csv, print_json
from autobalancer.cli.terminal.quantities import optional, quantity

if TYPE_CHECKING:
    from collections.abc import Sequence

    import xarray as xr


def design(
    machine: Annotated[Path, typer.Argument(help="Machine file with one deep chamber.")],
    duration: Annotated[str, typer.Option(help='Of each full run, such as "16 s".')],
    balls: Annotated[str, typer.Option(help='Numbers of balls, such as "5,8,12,20".')] = "",
    diameter: Annotated[str, typer.Option(help='Of a ball, such as "20,25,30 mm".')] = "",
    total_mass: Annotated[
        str, typer.Option(help='Of all balls, such as "0.8,1,1.5 kg"; instead of the diameter.')
    ] = "",
    density: Annotated[str, typer.Option(help='Of the balls, such as "7800,14900 kg/m^3".')] = "",
    friction: Annotated[str, typer.Option(help='Coefficients, such as "0.3,0.5,0.7".')] = "",
    ball_friction: Annotated[
        str, typer.Option(help="The same of balls on balls; by default that of the machine.")
    ] = "",
    viscosity: Annotated[
        str, typer.Option(help='Dynamic, of a fluid, such as "0,10,100 mPa*s"; 0 is a dry chamber.')
    ] = "",
    fluid_density: Annotated[str, typer.Option(help='Of the fluid, such as "900 kg/m^3".')] = "",
    fill: Annotated[str, typer.Option(help='Share of the chamber that the fluid fills, such as "0.6".')] = "",
    unbalance: Annotated[
        str, typer.Option(help='For which a design must work, such as "30,60 kg*mm"; by default that of the machine.')
    ] = "",
    limit: Annotated[
        list[str] | None,
        typer.Option(help='Such as "vibration=20 um", "settling_time=10 s" or "pick_up=0.9". May be repeated.'),
    ] = None,
    short: Annotated[str, typer.Option(help="Of a short run; by default half as long as a full one.")] = "",
    last: Annotated[str, typer.Option(help="Time at the end that is the steady state; by default a tenth.")] = "",
    fillings: Annotated[int, typer.Option(min=1, help="Of each design that gets full runs.")] = 5,
    finalists: Annotated[int, typer.Option(min=1, help="Designs that get full runs.")] = 4,
    around: Annotated[
        list[str] | None,
        typer.Option(
            help='Also run the best design with a quantity changed, such as "unbalance=0.2". May be repeated.'
        ),
    ] = None,
    archive: Annotated[Path | None, typer.Option(help="Folder that keeps all runs; a stopped search goes on.")] = None,
    workers: Annotated[int, typer.Option(min=0, help="Threads; 0 for one each core.")] = 0,
    best: Annotated[Path | None, typer.Option(help="Machine file of the best design, .toml.")] = None,
    out: Outs = None,
    plot: Plot = None,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """The designs that balance best within limits: closed forms first, then short runs, then full runs of the few best.

    Without --out the result is written here, under the machine's name with _designs.nc.

    Example: autobalancer chamber design deep_chamber.toml --duration "16 s" \\
      --balls 5,8,12,20 --total-mass "0.8,1,1.5 kg" --friction 0.5,0.7 \\
      --limit "vibration=30 um" --archive runs --best best.toml --plot designs.png
    """
    from autobalancer.files.machine_file import save_machine

    one_form(as_json, as_csv)
    files = Files(out or Path(f"{machine.stem}_designs.nc"), plot)
    made = Files(best, allowed=(".toml",))
    shelf = {
        "balls": balls,
        "diameter": diameter,
        "total_mass": total_mass,
        "density": density,
        "friction": friction,
        "ball_friction": ball_friction,
        "viscosity": viscosity,
        "fluid_density": fluid_density,
        "fill": fill,
    }
    limits = dict(_pair("--limit", text, "vibration=20 um") for text in limit or ())
    changes = {
        name: quantity("--around", text, "")
        for name, text in (_pair("--around", text, "unbalance=0.2") for text in around or ())
    }
    described = chamber_machine(machine)
    with asked_of(machine), bar("runs") as update, said_when_stopped(archive is not None):
        found = ab.chamber.design(
            described,
            {name: text for name, text in shelf.items() if text},
            limits,
            duration=quantity("--duration", duration, "s"),
            short=optional("--short", short, "s"),
            last=optional("--last", last, "s"),
            unbalances=unbalance or None,
            fillings=fillings,
            finalists=finalists,
            archive=archive,
            workers=workers or None,
            progress=update,
        )
    files.save(found, lambda: ab.plot.chamber_designs(found))
    if best is not None:
        save_machine(ab.chamber.designed_machine(found), best)
    changed = None
    if changes:
        with bar("runs around the best one") as update, said_when_stopped(archive is not None):
            changed = ab.chamber.design_sensitivity(
                found, changes, archive=archive, workers=workers or None, progress=update
            )
    if as_json:
        answer = {str(name): found[name].values for name in found.variables}
        print_json(
            answer if changed is None else {**answer, "around": {str(n): changed[n].values for n in changed.variables}}
        )
    elif as_csv:
        print_csv(found.columns())
    else:
        _show(found, changed)
        files.say()
        made.say()


def bounds(
    machine: Annotated[Path, typer.Argument(help="Machine file with one deep chamber.")],
    as_json: Json = False,
) -> None:
    """What the balls of a deep chamber can do at best, from closed forms, without a run.

    Example: autobalancer chamber bounds deep_chamber.toml
    """
    from autobalancer.cli.terminal.sheet import print_facts
    from autobalancer.cli.terminal.words import speed_text

    with asked_of(machine):
        found = ab.chamber.bounds(chamber_machine(machine))
    if as_json:
        print_json(found.as_dict())
        return
    print_facts(found.rows(speed_text), found.name)


def _pair(option: str, text: str, sample: str) -> tuple[str, str]:
    from autobalancer.errors import QuestionError

    name, mark, value = (part.strip() for part in text.partition("="))
    if not (name and mark and value):
        raise QuestionError(f'{option}: given {text!r}; write it as NAME=VALUE, such as "{sample}"')
    return name, value


def _show(found: xr.Dataset, changed: xr.Dataset | None) -> None:
    from rich.text import Text

    from autobalancer.cli.terminal.console import Console
    from autobalancer.cli.terminal.sheet import print_facts, print_sheet

    answer: Sequence[xr.Dataset] = (found,) if changed is None else (found, changed)
    for one in answer:
        print_facts(one.facts(), one.heading())
        print_sheet(one.columns())
        for text in one.remarks():
            Console(highlight=False).print(Text(text))


app.command()(design)
app.command()(bounds)
app.command()(archive)
