"""The options that commands share, each in one place: a new command takes them by name."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from autobalancer.cli.terminal.words import use_speed_unit


class SpeedUnit(StrEnum):
    """How speeds are shown."""

    RPM = "rpm"
    RAD = "rad/s"
    HZ = "Hz"


MachineFile = Annotated[Path, typer.Argument(help="Machine file.")]
Outs = Annotated[
    list[Path] | None,
    typer.Option("--out", help="Result file: .nc, or a table as .csv or .json. May be repeated."),
]
Plot = Annotated[Path | None, typer.Option(help="Picture: .png, .svg or .pdf.")]
Unit = Annotated[
    SpeedUnit,
    typer.Option("--speed-unit", case_sensitive=False, callback=use_speed_unit, help="Unit in which speeds are shown."),
]
FrequencyUnit = Annotated[
    SpeedUnit, typer.Option("--frequency-unit", case_sensitive=False, help="Unit in which frequencies are shown.")
]
Seed = Annotated[int, typer.Option(help="Chooses among the random numbers; equal seeds, equal results.")]
Settling = Annotated[
    str, typer.Option("--settling-from", help="From where settling times count: the end of the run-up, or release.")
]
Json = Annotated[bool, typer.Option("--json", help="Print JSON in SI units.")]
Csv = Annotated[bool, typer.Option("--csv", help="Print the table as CSV, with units in its first line.")]
