"""The envelope of a measured run-up: least and greatest value in bins, named as in runs."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import xarray as xr

from autobalancer.errors import QuestionError
from autobalancer.measurement.orders.question import vibrations
from autobalancer.results.answers.labeled import Labeled
from autobalancer.results.labels import LABELS
from autobalancer.results.provenance import provenance
from autobalancer.results.signals.signals import Signals
from autobalancer.units import argument

LEAST = 4  # samples of a bin


def envelope(
    signals: xr.Dataset,
    channels: str | Sequence[str] | None = None,
    *,
    revolutions: float = 1.0,
    bin_length: float | str | None = None,
) -> xr.Dataset:
    """Least and greatest value of each channel in bins of so many revolutions, or of equal time.

    Parameters
    ----------
    signals
        With the angle of the rotor (``ab.measure.rotor_angle``), or a ``bin_length``.
    channels
        Names; by default all vibrations.
    revolutions
        Of a bin; at least one, so that a bin sees a whole turn.
    bin_length
        s, or a text; in place of revolutions.

    Returns
    -------
    xarray.Dataset
        Over bin: ``envelope_time`` (middle, s), ``envelope_end`` (s) and, with an angle, ``envelope_speed`` (rad/s); over
        (channel, bin): ``envelope_low`` and ``envelope_high`` (SI). The last bin is left out if it is not full.

    Raises
    ------
    QuestionError
        If there is neither an angle nor a length of bins, or bins have fewer than four samples.
    """
    if not isinstance(signals, Signals):
        raise QuestionError("envelope: give measured signals, from ab.measure.load_signals or ab.measure.signals")
    names, time = vibrations(signals, channels), signals["time"].values
    if bin_length is not None:
        numbers = np.floor((time - time[0]) / argument("bin_length", bin_length, "s") + 1e-9)
    elif "rotor_angle" not in signals:
        raise QuestionError("envelope: the signals have no angle; use ab.measure.rotor_angle, or give bin_length")
    elif not revolutions >= 1.0:
        raise QuestionError(f"revolutions: given {revolutions!r}; must be at least 1")
    else:
        turned = signals["rotor_angle"].values - signals["rotor_angle"].values[0]
        numbers = np.floor(turned / (2.0 * math.pi * revolutions) + 1e-9)
    starts = np.flatnonzero(np.diff(numbers, prepend=-1.0))
    if starts.size < 2 or np.diff(starts).min() < LEAST:
        raise QuestionError(f"envelope: there must be at least two bins of {LEAST} samples; change their length")
    ends = time[starts[1:]]
    low, high = (
        np.array([cut.reduceat(signals[name].values, starts)[:-1] for name in names])
        for cut in (np.minimum, np.maximum)
    )
    found = xr.Dataset(
        coords={"channel": ("channel", names), "units": ("channel", [signals[n].attrs["units"] for n in names])}
    )
    entries = {"envelope_time": 0.5 * (time[starts[:-1]] + ends), "envelope_end": ends}
    if "speed" in signals:
        entries["envelope_speed"] = signals["speed"].values[starts[1:]]
    for key, values in entries.items():
        found[key] = ("bin", values, {"long_name": LABELS[key].long_name, "units": LABELS[key].units})
    for key, values, text in (
        ("envelope_low", low, "least value in the bin"),
        ("envelope_high", high, "greatest value in the bin"),
    ):
        found[key] = (("channel", "bin"), values, {"long_name": text})
    title = f"envelope of {signals.attrs.get('origin') or 'signals'}"
    return Labeled.of(found.assign_attrs({"title": title} | provenance()))
