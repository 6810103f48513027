"""``autobalancer measure signals``: what is in a file of measured signals."""

from __future__ import annotations

from autobalancer.cli.measured.given import Channels, End, Rate, Resample, SignalFile, Start, given_signals
from autobalancer.cli.measured.told import tell_signals
from autobalancer.cli.terminal.options import Csv, Json, Outs


def signals(
    file: SignalFile,
    channels: Channels = None,
    rate: Rate = "",
    resample: Resample = "",
    start: Start = "",
    end: End = "",
    out: Outs = None,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Read measured signals, check them, and list their channels.

    Example: autobalancer measure signals run_up_signals.csv --out run_up.nc
    """
    from autobalancer.cli.terminal.output import SIGNALS, Files, one_form

    one_form(as_json, as_csv)
    files = Files(out, allowed=SIGNALS)
    found = given_signals(file, channels, rate, resample, start, end)
    files.save(found)
    tell_signals(found, as_json, as_csv)
    if not (as_json or as_csv):
        files.say()
