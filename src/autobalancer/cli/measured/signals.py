"""``autobalancer measure signals``: what is in a file of measured signals."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import autobalancer as ab
from autobalancer.cli.terminal.options import Csv, Json, Outs
from autobalancer.cli.terminal.words import note


def signals(
    file: Annotated[
        Path, typer.Argument(help="Table with units in its column names, or a file of this package (.nc).")
    ],
    out: Outs = None,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Read measured signals, check them, and list their channels.

    Example: autobalancer measure signals run_up_signals.csv --out run_up.nc
    """
    from autobalancer.cli.terminal.output import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.sheet import print_facts, print_sheet

    one_form(as_json, as_csv)
    files = Files(out)
    found = ab.measure.load_signals(file)
    files.save(found)
    channels = {str(name): entry.attrs for name, entry in found.data_vars.items()}
    if as_json:
        about = {"sampling_rate": found.attrs["sampling_rate"], "samples": found.sizes["time"]}
        print_json(about | {"channels": channels})
        return
    if as_csv:
        print_csv(found.columns())
        return
    print_facts(found.facts(), found.heading())
    print_sheet(found.columns())
    for text in found.remarks():
        note(text)
    files.say()
