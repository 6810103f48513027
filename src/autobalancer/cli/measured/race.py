"""``autobalancer measure race-shape``, ``rest-friction``, ``drag-from-lag``: races and balls from measurements."""

from __future__ import annotations

from math import degrees
from pathlib import Path
from typing import Annotated

import typer

import autobalancer as ab
from autobalancer.cli.measured.told import tell
from autobalancer.cli.terminal.options import Csv, Json, MachineFile, Plot
from autobalancer.cli.terminal.words import note


def race_shape(
    file: Annotated[Path, typer.Argument(help="Table: angle \\[deg], and radius \\[mm] or deviation \\[um].")],
    waves: Annotated[int, typer.Option(help="Undulations per revolution up to which the profile is kept.")] = 15,
    center: Annotated[
        str,
        typer.Option(help="Around what it was measured: the axis of the rotor, or a setup whose eccentricity goes."),
    ] = "axis",
    out: Annotated[Path | None, typer.Option(help="The lines of a machine file, as .toml.")] = None,
    plot: Plot = None,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Roundness, eccentricity and waves of a race from its measured profile, for a machine file.

    Example: autobalancer measure race-shape race_profile.csv --out race.toml --plot race.png
    """
    from autobalancer.cli.terminal.output import MACHINE, Files
    from autobalancer.plots.drawing.save import save_picture
    from autobalancer.plots.measured.race import race_shape as picture
    from autobalancer.safe_file import write_text_safely

    files = Files(out, plot, MACHINE)
    found = ab.measure.race_shape(file, waves=waves, center=center)  # type: ignore[arg-type]
    if out is not None:
        write_text_safely(out, found.machine_lines())
    if plot is not None:
        save_picture(picture(found), plot)
    tell(found, as_json, as_csv)
    if not (as_json or as_csv):
        files.say()


def rest_friction(
    machine: MachineFile,
    file: Annotated[
        Path, typer.Argument(help="Table: angle \\[deg] of each rest, from the place opposite the unbalance.")
    ],
    speed: Annotated[str, typer.Option(help='At which the ball rested, such as "1200 rpm".')],
    plot: Plot = None,
    as_json: Json = False,
) -> None:
    """Adherence between a ball and its race from where it came to rest in many run-ups.

    Example: autobalancer measure rest-friction one_ball_run_up.toml rest_positions.csv --speed "1200 rpm"
    """
    from dataclasses import asdict

    from autobalancer.cli.terminal.output import Files, print_json
    from autobalancer.cli.terminal.quantities import quantity
    from autobalancer.cli.terminal.sheet import print_facts
    from autobalancer.plots.drawing.save import save_picture
    from autobalancer.plots.measured.race import rests as picture

    files = Files(None, plot)
    found = ab.measure.rest_friction(machine, file, float(quantity("--speed", speed, "rad/s")))
    if plot is not None:
        save_picture(picture(found), plot)
    if as_json:
        print_json(asdict(found))
        return
    low, high = degrees(found.width_low), degrees(found.width_high)
    middle = f"{degrees(found.middle):.3g} +- {degrees(found.middle_deviation):.2g} deg from the balanced place"
    print_facts(
        [
            ("adherence", f"{found.adherence:.4g}, from {found.low:.4g} to {found.high:.4g} with 95 %"),
            ("rests lie within", f"{degrees(found.width):.4g} deg, from {low:.4g} to {high:.4g} deg with 95 %"),
            ("middle", middle),
            ("rests", str(len(found.angles))),
        ],
        "Friction from rest positions",
    )
    for text in found.remarks:
        note(text)
    files.say()


def drag_from_lag(
    machine: MachineFile,
    file: Annotated[
        Path, typer.Argument(help="Table: time \\[s], rotor speed \\[rpm], ball speed \\[rpm], both in space.")
    ],
    rolling: Annotated[bool, typer.Option("--rolling/--no-rolling", help="With rolling resistance.")] = True,
    as_json: Json = False,
) -> None:
    """Drag and rolling resistance of a ball from how far it lags behind the rotor in a run-up.

    Example: autobalancer measure drag-from-lag one_ball_run_up.toml ball_lag.csv
    """
    from dataclasses import asdict

    from autobalancer.cli.terminal.output import print_json
    from autobalancer.cli.terminal.sheet import print_facts

    found = ab.measure.drag_from_lag(machine, file, rolling=rolling)
    if as_json:
        print_json(asdict(found))
        return
    print_facts(
        [
            ("drag", f"{found.drag:.4g} +- {found.drag_deviation:.2g} N m s"),
            ("rolling resistance", f"{found.rolling_resistance:.4g} +- {found.rolling_resistance_deviation:.2g}"),
            ("correlation of both", f"{found.correlation:.3g}"),
            ("left of the speed", f"{found.scatter:.3g} rad/s"),
        ],
        "Drag from the lag of a ball",
    )
    for text in found.remarks:
        note(text)
