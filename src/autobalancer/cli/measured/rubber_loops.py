"""``autobalancer measure rubber-signals``: rubber of a machine file from recorded force and deflection."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import autobalancer as ab
from autobalancer.cli.terminal.options import Csv, Json, Plot
from autobalancer.cli.terminal.words import note


def rubber_signals(
    records: Annotated[
        list[Path],
        typer.Argument(help="Signals with a deflection and a force, such as time \\[s], deflection \\[mm], force [N]."),
    ],
    frequency: Annotated[str | None, typer.Option(help="Of the motion; by default that of the deflection.")] = None,
    law: Annotated[str, typer.Option(help="Of the friction elements: elastoplastic or endochronic.")] = "elastoplastic",
    viscous: Annotated[bool, typer.Option("--viscous/--no-viscous", help="With a viscous part.")] = True,
    out: Annotated[Path | None, typer.Option(help="The lines of a machine file, as .toml.")] = None,
    plot: Plot = None,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Rubber that softens with the amplitude, from recorded hysteresis loops to the lines of a machine file.

    Example: autobalancer measure rubber-signals rubber_signals.csv --out rubber.toml --plot rubber.png
    """
    from autobalancer.cli.terminal.output import MACHINE, Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.quantities import quantity
    from autobalancer.cli.terminal.sheet import print_sheet
    from autobalancer.plots.drawing.save import save_picture
    from autobalancer.plots.measured.rubber import rubber as picture
    from autobalancer.safe_file import write_text_safely
    from autobalancer.shown import Column

    one_form(as_json, as_csv)
    files = Files(out, plot, MACHINE)
    w = None if frequency is None else float(quantity("--frequency", frequency, "rad/s"))
    points = ab.measure.rubber_signals(records, frequency=w)
    found = ab.measure.rubber(points, law=law, viscous=viscous)  # type: ignore[arg-type]
    if out is not None:
        write_text_safely(out, found.toml())
    if plot is not None:
        save_picture(picture(found), plot)
    columns = [
        Column("frequency", points.frequency / 6.283185307179586, "Hz", ".4g"),
        Column("amplitude", 1e3 * points.amplitude, "mm", ".4g"),
        Column("K'", 1e-3 * points.stiffness, "kN/m", ".4g"),
        Column("+-", 1e-3 * points.stiffness_uncertainty, "kN/m", ".2g"),
        Column("K''", 1e-3 * points.loss, "kN/m", ".4g"),
        Column("+-", 1e-3 * points.loss_uncertainty, "kN/m", ".2g"),
        Column("K' fitted", 1e-3 * found.fitted.real, "kN/m", ".4g"),
        Column("K'' fitted", 1e-3 * found.fitted.imag, "kN/m", ".4g"),
    ]
    if as_json:
        print_json(
            {"points": {f"{c.head} [{c.unit}]": list(map(float, c.values)) for c in columns}, "lines": found.toml()}
        )
        return
    if as_csv:
        print_csv(columns)
        return
    print_sheet(columns, "Loops, and the rubber that was fitted to them")
    for text in found.remarks:
        note(text)
    files.say()
