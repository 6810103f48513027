"""``autobalancer map``: the growth rate of the balanced state over two parameters."""

from __future__ import annotations

from typing import Annotated

import typer

import autobalancer as ab
from autobalancer.cli.terminal.options import Csv, Json, MachineFile, Outs, Plot, SpeedUnit, Unit
from autobalancer.cli.terminal.words import say


def map_(
    machine: MachineFile,
    x: Annotated[str, typer.Option(help='Along x: "NAME=from:to:count", with ":log" for equal ratios.')],
    y: Annotated[str, typer.Option(help="Along y, in the same form.")],
    speed: Annotated[str, typer.Option(help='Rotor speed where it is not an axis, such as "1200 rpm".')] = "",
    positions: Annotated[str, typer.Option(help="Of more than two balls: worst or best.")] = "worst",
    point: Annotated[
        list[str] | None, typer.Option(help='Operating point "NAME=x value, y value". May be repeated.')
    ] = None,
    out: Outs = None,
    plot: Plot = None,
    speed_unit: Unit = SpeedUnit.RPM,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Find where the balanced state is stable, with averaged border, exact border, release and capture speed.

    A NAME is speed, viscosity, drag, ball_mass, ball_diameter, count, unbalance, damping, stiffness, temperature,
    plateau, rolling_resistance, or a path such as rotor.damping.

    Example: autobalancer map discoidal.toml \\
      --x "speed=50 rad/s:130 rad/s:400" \\
      --y "viscosity=0.2 mm^2/s:100 mm^2/s:400:log" --plot map.png
    """
    from autobalancer.cli.terminal.output import Files, one_form, print_json
    from autobalancer.cli.terminal.progress import progress_bar
    from autobalancer.cli.terminal.quantities import optional, parameter_values
    from autobalancer.errors import QuestionError
    from autobalancer.files.machine_file import load_race_machine
    from autobalancer.results.export import result_csv

    one_form(as_json, as_csv)
    files = Files(out, plot)
    fixed = optional("--speed", speed, "rad/s")
    described = load_race_machine(machine)
    (across, x_values), (up, y_values) = (parameter_values(*axis, described) for axis in (("--x", x), ("--y", y)))
    if across == up:
        raise QuestionError(f"--y: given {up!r}, which is along --x already; take two different parameters")
    with progress_bar("map") as update:
        found = ab.stability.map(
            described,
            {across: x_values, up: y_values},
            speed=fixed,
            positions=positions,  # type: ignore[arg-type]
            operating_points=dict(_point(text) for text in point or []),
            progress=update,
        )
    files.save(found, lambda: ab.plot.map(found, speed_unit=speed_unit))
    if as_json:
        rates = found["growth_rate"].values
        names = {str(name): found[name].values for name in (*found.dims, *found.data_vars)}
        print_json({"machine": str(machine), "points": rates.size, "stable": int((rates < 0.0).sum()), **names})
        return
    if as_csv:
        typer.echo(result_csv(found), nl=False)
        return
    say("; ".join((found.stable_text(), *found.remarks())))
    if held := found.held_text():
        say(f"friction: {held}")
    files.say()


def _point(text: str) -> tuple[str, tuple[str, str]]:
    from autobalancer.errors import QuestionError

    name, _, values = text.partition("=")
    pair = [value.strip() for value in values.split(",")]
    if not name.strip() or len(pair) != 2 or not all(pair):
        raise QuestionError(
            f"--point: given {text!r}; write it as \"NAME=x value, y value\", such as 'measured=64 rad/s, 0.65 mm^2/s'"
        )
    return name.strip(), (pair[0], pair[1])
