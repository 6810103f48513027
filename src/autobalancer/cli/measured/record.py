"""``autobalancer measure record``: a run as a logger would have measured it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import autobalancer as ab
from autobalancer.cli.measured.told import tell_signals
from autobalancer.cli.terminal.options import Csv, Json, Outs, Seed
from autobalancer.cli.terminal.words import note

FORM = "QUANTITY:PLACE:DIRECTION:NOISE"


def record(
    run: Annotated[Path, typer.Argument(help="Result of a run with enough samples (.nc).")],
    sensor: Annotated[
        list[str],
        typer.Option(
            help=f"A sensor as {FORM}, such as displacement:laser:x:40 dB or acceleration::30. The place, the direction "
            "(x, y or degrees from x) and the noise (a standard deviation or dB) may be left out. May be repeated."
        ),
    ],
    rate: Annotated[str, typer.Option(help='Sampling rate, such as "5 kHz".')],
    pulses: Annotated[int, typer.Option(help="Pulses of the tacho in a turn; 0 for no tacho.")] = 1,
    start: Annotated[str, typer.Option(help='Begin with this time of the run, such as "1 s".')] = "",
    end: Annotated[str, typer.Option(help='End with it, such as "3 s".')] = "",
    seed: Seed = 0,
    out: Outs = None,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Make a logger file of a run: sensors with noise, and a tacho.

    Example: autobalancer measure record stall.nc --sensor "displacement::x:40 dB" \\
      --rate "2 kHz" --out logger.csv
    """
    from autobalancer.cli.terminal.output import SIGNALS, Files, one_form
    from autobalancer.cli.terminal.quantities import optional

    one_form(as_json, as_csv)
    files = Files(out, allowed=SIGNALS)
    sensors = [_sensor(text) for text in sensor]
    tacho = [ab.measure.Tacho(pulses=pulses)] if pulses else []
    found = ab.measure.record(
        ab.load_run(run),
        [*sensors, *tacho],
        rate,
        start=optional("--start", start, "s"),
        end=optional("--end", end, "s"),
        seed=seed,
    )
    files.save(found)
    tell_signals(found, as_json, as_csv)
    if not (as_json or as_csv):
        for text in found.remarks():
            note(text)
        files.say()


def _sensor(text: str) -> ab.measure.Sensor:
    parts = [part.strip() for part in text.split(":")]
    if len(parts) > len(FORM.split(":")):
        raise ab.errors.QuestionError(f"--sensor: given {text!r}; write {FORM}, such as displacement:laser:x:40 dB")
    quantity, place, direction, noise = (parts + [""] * 3)[:4]
    return ab.measure.Sensor(quantity, place, direction or "x", noise=noise or 0.0)  # type: ignore[arg-type]
