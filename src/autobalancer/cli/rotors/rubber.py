"""``autobalancer rubber``: rubber that softens with the amplitude, from measured loops and resonances."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from autobalancer.cli.terminal.options import Csv, Json, Plot
from autobalancer.cli.terminal.words import note, say

if TYPE_CHECKING:
    from autobalancer.results.answers.rubber_fit import RubberFit


def rubber(
    tables: Annotated[
        list[Path],
        typer.Argument(
            help="Loops: frequency [Hz], amplitude \\[mm], stiffness \\[kN/m], damping [N s/m]. Resonances: mass \\[kg] and "
            "decay rate [1/s] in place of the last two. Perhaps motion, line or circle."
        ),
    ],
    law: Annotated[str, typer.Option(help="Of the friction elements: elastoplastic or endochronic.")] = "elastoplastic",
    spacing: Annotated[float, typer.Option(help="Ratio of neighboring breakaway amplitudes.")] = 2.0,
    relaxation_time: Annotated[
        list[str] | None, typer.Option(help='Of a Maxwell element, such as "5 ms". May be repeated.')
    ] = None,
    viscous: Annotated[bool, typer.Option("--viscous/--no-viscous", help="With a viscous part.")] = True,
    out: Annotated[Path | None, typer.Option(help="The lines of a machine file, as .toml.")] = None,
    plot: Plot = None,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Fit rubber that softens with the amplitude to hysteresis loops and to resonances at several amplitudes.

    Example: autobalancer rubber rubber_loops.csv --out rubber.toml
    """
    from autobalancer.cli.terminal.output import MACHINE, Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.quantities import quantity
    from autobalancer.cli.terminal.sheet import print_sheet
    from autobalancer.measurement.rubber.fit import rubber as fit
    from autobalancer.plots.drawing.save import save_picture
    from autobalancer.plots.measured.rubber import rubber as picture
    from autobalancer.safe_file import write_text_safely

    one_form(as_json, as_csv)
    files = Files(out, plot, MACHINE)
    times = [float(quantity("--relaxation-time", text, "s")) for text in relaxation_time or []]
    found = fit(
        tables,
        law=law,  # type: ignore[arg-type]
        spacing=spacing,
        relaxation_times=times,
        viscous=viscous,
    )
    if out is not None:
        write_text_safely(out, found.toml())
    if plot is not None:
        save_picture(picture(found), plot)
    if as_json:
        print_json(_numbers(found))
        return
    if as_csv:
        print_csv(found.columns())
        return
    print_sheet(found.columns(), f"rubber, {found.law.law}, from {len(found.points)} points")
    deviation = abs(found.fitted.real / found.points.stiffness - 1.0).max()
    say(f"stiffness of the points within {100.0 * deviation:.2g} %")
    for text in found.remarks:
        note(text)
    files.say()


def _numbers(found: RubberFit) -> dict[str, Any]:
    points, fitted = found.points, found.fitted
    return {
        "elastic": found.law.elastic,
        "viscous": found.law.viscous,
        "law": found.law.law,
        "friction": [{"stiffness": k, "breakaway_amplitude": a} for k, a in found.law.friction],
        "maxwell": [{"stiffness": k, "relaxation_time": t} for k, t in found.law.maxwell],
        "points": [
            {
                "name": name,
                "frequency": float(points.frequency[i]),
                "amplitude": float(points.amplitude[i]),
                "stiffness": float(points.stiffness[i]),
                "loss": float(points.loss[i]),
                "fitted_stiffness": float(fitted[i].real),
                "fitted_loss": float(fitted[i].imag),
            }
            for i, name in enumerate(points.names)
        ],
        "remarks": list(found.remarks),
    }
