"""``autobalancer measure signals``: what is in a file of measured signals."""

from __future__ import annotations

from typing import Annotated

import typer

import autobalancer as ab
from autobalancer.cli.measured.given import (
    READING,
    Chosen,
    Reading,
    SignalFile,
)
from autobalancer.cli.measured.told import tell_signals
from autobalancer.cli.terminal.blocks import in_blocks
from autobalancer.cli.terminal.options import Csv, Json, Outs


@in_blocks
def signals(
    file: SignalFile,
    reading: Reading = READING,
    to: Annotated[str, typer.Option(help="Make displacement, velocity or acceleration of the vibrations.")] = "",
    corner: Annotated[str, typer.Option(help='High pass where that integrates, such as "2 Hz".')] = "",
    channel: Chosen = None,
    out: Outs = None,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Read measured signals, check them, list their channels, and write them in another form or as another quantity.

    Example: autobalancer measure signals run_up_signals.csv --out run_up.nc
    """
    from autobalancer.cli.terminal.output import SIGNALS, Files, one_form
    from autobalancer.errors import QuestionError

    one_form(as_json, as_csv)
    if (corner or channel) and not to:
        raise QuestionError("--corner, --channel: say with --to what the vibrations are to become")
    files = Files(out, allowed=SIGNALS)
    found = reading.signals(file)
    if to:
        found = ab.measure.converted(found, to, corner=corner or None, channels=channel)
    files.save(found)
    tell_signals(found, as_json, as_csv)
    if not (as_json or as_csv):
        files.say()
