"""Options of the commands that read measured signals, and the signals that they describe."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    import xarray as xr

SignalFile = Annotated[
    Path, typer.Argument(help="Table with units in its column names, .uff, .wav, .npz, .mat, or a result file (.nc).")
]
Channels = Annotated[
    Path | None, typer.Option(help="TOML file that says what the columns are; by default NAME.channels.toml beside.")
]
Chosen = Annotated[list[str] | None, typer.Option("--channel", help="Use this channel. May be repeated.")]
Rate = Annotated[str, typer.Option(help='Sampling rate where the file has no time, such as "2 kHz".')]
Resample = Annotated[str, typer.Option(help='Bring uneven samples to this rate, such as "2 kHz".')]
Start = Annotated[str, typer.Option(help='Use the file from here, such as "1 s".')]
End = Annotated[str, typer.Option(help='Use it up to here, such as "12 s".')]
Tacho = Annotated[str, typer.Option(help="Channel of the tacho; by default the only one.")]
PulsesOption = Annotated[int, typer.Option(help="Marks of the tacho on a turn, evenly spaced.")]
Edge = Annotated[str, typer.Option(help="Which edge of a pulse counts: rising or falling.")]
Index = Annotated[str, typer.Option(help="Channel with one pulse a turn, where the tacho has several.")]
TachoAngle = Annotated[str, typer.Option(help='Where the tacho looks at the shaft, from the x axis: "90 deg".')]


@dataclass(frozen=True)
class Reading:
    """How the file of signals is read."""

    channels: Channels = None
    rate: Rate = ""
    resample: Resample = ""
    start: Start = ""
    end: End = ""

    def signals(self, file: Path) -> xr.Dataset:
        """Read it."""
        from autobalancer.cli.terminal.quantities import optional
        from autobalancer.measurement.signals.load import load_signals

        return load_signals(
            file,
            self.channels,
            rate=self.rate or None,
            resample=self.resample or None,
            start=optional("--start", self.start, "s"),
            end=optional("--end", self.end, "s"),
        )


@dataclass(frozen=True)
class Turning:
    """What says how the rotor turns."""

    tacho: Tacho = ""
    pulses: PulsesOption = 1


@dataclass(frozen=True)
class Phase:
    """What says where the rotor is at an instant, so that phases have a meaning."""

    edge: Edge = "rising"
    tacho_angle: TachoAngle = ""
    index: Index = ""


READING, TURNING, PHASE = Reading(), Turning(), Phase()  # as they are unless something is asked


def with_angle(signals: xr.Dataset, turning: Turning, phase: Phase = PHASE) -> xr.Dataset:
    """Signals with the angle of the rotor, from their tacho if they have none yet."""
    from autobalancer.cli.terminal.quantities import optional
    from autobalancer.measurement.orders.angle import rotor_angle

    if "rotor_angle" in signals:
        return signals
    looks = optional("--tacho-angle", phase.tacho_angle, "rad")
    return rotor_angle(
        signals, turning.tacho, pulses=turning.pulses, edge=phase.edge, tacho_angle=looks, index=phase.index
    )


def tacho_of(signals: xr.Dataset, tacho: str) -> bool:
    """Whether the signals have a tacho, or one was named."""
    return bool(tacho) or any(entry.attrs.get("quantity") == "tacho" for entry in signals.data_vars.values())
