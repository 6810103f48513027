"""``autobalancer measure balance``, ``four-run``, ``run-down``: unbalance and corrections from readings."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import autobalancer as ab
from autobalancer.cli.measured.told import tell
from autobalancer.cli.terminal.options import Csv, Json, MachineFile, Outs, Plot

if TYPE_CHECKING:
    from autobalancer.measurement.balancing.answer import Balancing

RunsFile = Annotated[Path, typer.Argument(help="Runs with their masses and readings, .toml.")]
Deviation = Annotated[
    str | None, typer.Option(help="Standard deviation of a reading in percent of it, where a reading has none.")
]


def balance(
    file: RunsFile,
    goal: Annotated[
        str, typer.Option(help="What shall be least of what remains: its mean square (mean), or the greatest.")
    ] = "mean",
    largest: Annotated[str | None, typer.Option(help='Greatest correction mass, such as "20 g".')] = None,
    plane: Annotated[list[str] | None, typer.Option(help="To correct; all by default. May be repeated.")] = None,
    deviation: Deviation = None,
    holes: Annotated[int | None, typer.Option(help="Split each correction over so many evenly spaced holes.")] = None,
    mass: Annotated[list[str] | None, typer.Option(help="That there is for the holes. May be repeated.")] = None,
    out: Outs = None,
    plot: Plot = None,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Correction masses from runs without and with trial masses, with influence coefficients.

    Example: autobalancer measure balance two_plane_job.toml --largest "5 g" --plot balance.png
    """
    from autobalancer.cli.terminal.output import Files
    from autobalancer.plots.measured.balancing import balancing

    files = Files(out, plot)
    found = ab.measure.balance(
        file, goal=goal, largest=largest, planes=plane or None, deviation=deviation  # type: ignore[arg-type]
    )  # fmt: skip
    files.save(found, lambda: balancing(found))
    tell(found, as_json, as_csv)
    if holes is not None and not (as_json or as_csv):
        _tell_holes(found, holes, mass)
    if not (as_json or as_csv):
        files.say()


def _tell_holes(found: Balancing, holes: int, masses: list[str] | None) -> None:
    from math import degrees

    from autobalancer.cli.terminal.sheet import Column, print_sheet

    unit = found["correction"].attrs["units"]
    sign, factor = ("g", 1e3) if unit == "kg" else ("g mm", 1e6)
    rows: list[tuple[str, float, float, float]] = []
    for name, size, angle in zip(
        found["plane"].values, found["correction"].values, found["correction_angle"].values, strict=True
    ):
        given = f"{size:.17g} {'kg' if unit == 'kg' else 'kg*m'}"
        split = ab.measure.split_mass(given, float(angle), holes=holes, masses=masses)
        rows += [
            (str(name), degrees(at) % 360.0, factor * part, factor * split.residual)
            for at, part in zip(split.angles, split.masses, strict=True)
        ]
    heads = (("plane", ""), ("hole at", "deg"), ("mass", sign), ("left in plane", sign))
    print_sheet(
        [Column(head, [row[k] for row in rows], text, ".4g") for k, (head, text) in enumerate(heads)],
        "Split over holes",
    )


def four_run(
    file: RunsFile,
    deviation: Deviation = None,
    both: Annotated[bool, typer.Option("--both", help="Two answers where the runs cannot decide.")] = False,
    out: Outs = None,
    plot: Plot = None,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Correction in one plane from amplitudes alone: one run without and three with a trial mass.

    Example: autobalancer measure four-run four_runs.toml --plot circles.png
    """
    from autobalancer.cli.terminal.output import Files
    from autobalancer.plots.measured.balancing import four_run as picture

    files = Files(out, plot)
    found = ab.measure.four_run(file, deviation=deviation, both=both)
    files.save(found, lambda: picture(found))
    tell(found, as_json, as_csv)
    if not (as_json or as_csv):
        files.say()


def run_down(
    machine: MachineFile,
    file: Annotated[
        Path,
        typer.Argument(
            help="Table: speed \\[rpm], place, direction, amplitude \\[um], phase \\[deg], perhaps amplitude deviation \\[um]; "
            "or orders of this package (.nc)."
        ),
    ],
    plane: Annotated[
        list[str] | None, typer.Option(help="Whose unbalance is asked for: a station, or a position such as 0.1 (m).")
    ] = None,
    out: Outs = None,
    plot: Plot = None,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Unbalance of all planes from one run-down and a model of the rotor.

    Example: autobalancer measure run-down two_plane_rotor.toml run_down_orders.csv --plane lower --plane upper
    """
    from autobalancer.cli.terminal.output import Files
    from autobalancer.plots.measured.balancing import run_down as picture

    files = Files(out, plot)
    found = ab.measure.unbalance_from_run_down(machine, file, planes=[_place(one) for one in plane] if plane else None)
    files.save(found, lambda: picture(found))
    tell(found, as_json, as_csv)
    if not (as_json or as_csv):
        files.say()


def _place(text: str) -> str | float:
    try:
        return float(text)
    except ValueError:
        return text
