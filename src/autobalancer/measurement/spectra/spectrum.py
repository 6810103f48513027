"""Averaged spectra of measured signals."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.signal import get_window, welch

from autobalancer.errors import QuestionError
from autobalancer.measurement.orders.question import vibrations
from autobalancer.measurement.signals.unit_words import hertz_argument
from autobalancer.measurement.spectra.lines import Lines, found_lines, named_lines
from autobalancer.results.provenance import provenance
from autobalancer.results.signals.signals import Signals
from autobalancer.results.signals.spectrum import Spectrum

Floats = NDArray[np.float64]
WINDOWS = ("hann", "flattop", "blackmanharris", "boxcar")
LINES = 400  # of a segment, by default
STEADY = 0.02  # share by which the speed may change for its orders to be named


def spectrum(
    signals: xr.Dataset,
    channels: str | Sequence[str] | None = None,
    *,
    window: str = "hann",
    resolution: float | str | None = None,
    natural: Sequence[float] = (),
) -> xr.Dataset:
    """Amplitudes over the frequency, averaged over segments that overlap by half, and the lines in them.

    Parameters
    ----------
    signals
        Measured at one speed; with the angle of the rotor (``ab.measure.rotor_angle``) or a tacho lines are named by their
        order.
    channels
        Names; by default all vibrations.
    window
        hann, flattop (amplitudes of lines within 0.1 %, wide), blackmanharris or boxcar.
    resolution
        Between the frequencies, Hz; by default four hundred lines up to half of the sampling rate.
    natural
        Natural frequencies (rad/s) by which lines may be named.

    Returns
    -------
    xarray.Dataset
        Over (channel, frequency): ``amplitude`` (SI, of a sinusoid) and ``density`` (mean square a hertz). Over ``line``:
        what stands at least four times above the noise about it: ``line_channel``, ``line_frequency`` (rad/s),
        ``line_amplitude``, each with ``..._deviation`` (one standard deviation, from that noise), ``line_name``.
        ``attrs``: ``window``, ``resolution`` and ``noise_bandwidth`` (Hz), ``averages``,
        ``density_deviation`` (one relative standard deviation of a density), ``speed`` (rad/s, nan where it is not known or not
        steady).

    Raises
    ------
    QuestionError
        If there is no such channel or window, or the signals are too short for the resolution.
    """
    if not isinstance(signals, Signals):
        raise QuestionError("spectrum: give measured signals, from ab.measure.load_signals or ab.measure.signals")
    if window not in WINDOWS:
        raise QuestionError(f"window: given {window!r}; must be one of {', '.join(WINDOWS)}")
    names = vibrations(signals, channels)
    rate, count = float(signals.attrs["sampling_rate"]), signals.sizes["time"]
    length = min(2 * LINES, count) if resolution is None else round(rate / hertz_argument("resolution", resolution))
    if not 16 <= length <= count:
        raise QuestionError(
            f"resolution: {rate / length:.4g} Hz needs {length / rate:.4g} s in a segment; the signals have "
            f"{count / rate:.4g} s (from pulse to pulse of a tacho); give {1.0001 * rate / count:.4g} Hz or more"
        )
    weights = get_window(window, length)
    values = np.array([signals[name].values for name in names])
    frequency, power = welch(values, rate, weights, length, length // 2, detrend="linear", scaling="spectrum")
    amplitude = np.sqrt(2.0 * power)
    bandwidth = rate * float((weights**2).sum() / weights.sum() ** 2)
    averages = 1 + (count - length) // (length - length // 2)
    speed = steady_speed(signals)
    lines = [found_lines(2.0 * math.pi * frequency, row, weights, averages) for row in amplitude]
    how = {"window": window, "resolution": rate / length, "noise_bandwidth": bandwidth, "averages": averages}
    how |= {"density_deviation": 1.0 / math.sqrt(max(1.0, 0.95 * averages)), "speed": speed}
    return _dataset(signals, names, 2.0 * math.pi * frequency, amplitude, power / bandwidth, lines, how, natural)


def steady_speed(signals: xr.Dataset) -> float:
    """Mean speed (rad/s); nan where it is not known or changes by more than two percent."""
    if "speed" not in signals:
        return math.nan
    speed = signals["speed"].values
    return float(speed.mean()) if np.ptp(speed) <= STEADY * speed.mean() else math.nan


def _dataset(
    signals: xr.Dataset,
    names: list[str],
    frequency: Floats,
    amplitude: Floats,
    density: Floats,
    lines: list[Lines],
    how: dict[str, Any],
    natural: Sequence[float],
) -> Spectrum:
    dims = ("channel", "frequency")
    near = 2.0 * math.pi * how["resolution"]
    texts = [text for one in lines for text in named_lines(one.frequency, one.amplitude, how["speed"], natural, near)]
    every = Lines(*(np.concatenate(parts) for parts in zip(*lines, strict=True)))
    of = [name for name, one in zip(names, lines, strict=True) for _ in one.frequency]
    found = xr.Dataset(
        {
            "amplitude": (dims, amplitude, {"long_name": "amplitude of a sinusoid"}),
            "density": (dims, density, {"long_name": "mean square a hertz", "units_form": "{}^2/Hz"}),
            "line_channel": ("line", np.array(of, dtype=object), {"long_name": "channel of the line"}),
            "line_frequency": ("line", every.frequency, {"long_name": "frequency of the line", "units": "rad/s"}),
            "line_frequency_deviation": (
                "line",
                every.frequency_deviation,
                {"long_name": "standard deviation of the frequency of the line", "units": "rad/s"},
            ),
            "line_amplitude": ("line", every.amplitude, {"long_name": "amplitude of the line"}),
            "line_amplitude_deviation": (
                "line",
                every.amplitude_deviation,
                {"long_name": "standard deviation of the amplitude of the line"},
            ),
            "line_name": ("line", np.array(texts, dtype=object), {"long_name": "what it is"}),
        },
        {
            "channel": ("channel", names, {"long_name": "channel"}),
            "frequency": ("frequency", frequency, {"long_name": "frequency", "units": "rad/s"}),
            "units": ("channel", [str(signals[name].attrs.get("units", "")) for name in names]),
        },
        {"title": f"spectrum of {signals.attrs.get('origin') or 'signals'}", **how, **provenance()},
    )
    return Spectrum.of(found)
