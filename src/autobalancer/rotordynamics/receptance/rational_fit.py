"""From a measured receptance to poles and residues: AAA proposes, least squares refines, the noise sets the order."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.patience import shows_progress
from autobalancer.random_numbers import generator
from autobalancer.rotordynamics.receptance.fit_doubts import with_doubts
from autobalancer.rotordynamics.receptance.fit_outcome import fit_dataset
from autobalancer.rotordynamics.receptance.measured import hertz
from autobalancer.rotordynamics.receptance.modal_model import Fitting
from autobalancer.rotordynamics.receptance.mode_checks import sure_modes
from autobalancer.rotordynamics.receptance.noise import Noise, NoiseShapes
from autobalancer.rotordynamics.receptance.pole_model import PoleModel
from autobalancer.units import ends_argument

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
FEWEST = 8  # values that a fit needs
ROUNDING = 1e-6  # so that a line at an end of the band is in it


@shows_progress
def receptance(
    measured: xr.Dataset,
    *,
    modes: int | None = None,
    most_modes: int = 8,
    noise: Noise = "estimated",
    band: tuple[float | str, float | str] | None = None,
    progress: Callable[[float, float], None] | bool | None = None,
) -> xr.Dataset:
    """Fit poles and residues of a stable, real system with inertia to a measured receptance.

    The AAA algorithm (Nakatsukasa, Sete and Trefethen 2018) proposes poles; they are folded into conjugate pairs and to
    the stable side, and those that contribute least are dropped, among them the doublets of noise. Poles and residues
    are then refined together by least squares under the condition that the receptance falls with the square of the
    frequency, as that of every body with mass does. Each value has the weight that its noise leaves it: fit and noise
    are found in turn. The number of modes is that with the least Bayesian information criterion (Schwarz 1978).

    Parameters
    ----------
    measured
        From :func:`load_receptance`.
    modes
        Number of modes; by default chosen by the noise.
    most_modes
        Greatest number of modes that is tried.
    noise
        *estimated*: a share of the value, a floor, and parts that grow towards low frequencies, as acceleration
        gives; their sizes come from the data. *relative*: a share of the value; *absolute*: the same everywhere. A
        coherence in the data is used with each: variance in proportion to (1 - coherence)/coherence.
    band
        Lowest and highest frequency that are used, rad/s or as texts such as ``("5 Hz", "200 Hz")``; by default all.
    progress
        By default a bar where a person is looking and it takes more than a second; False: none; or a function of
        (done, all).

    Returns
    -------
    xarray.Dataset
        Along ``pole``: its real and imaginary part (1/s) and that of its residue (m/(N s)). Along ``mode``, ascending:
        ``mode_frequency`` (rad/s, undamped), ``mode_damping_ratio`` and ``mode_mass`` (kg, at the race), and the standard
        deviation of each as ``..._deviation``. Along ``frequency``: what was measured and what was fitted, the noise
        (``noise_deviation``, m/N) and whether the value was ``used``. ``attrs``: ``fit_error`` (root mean square
        as a share of the values, weighted by the noise), ``modes``, ``effective_mass`` (kg, at high frequency),
        ``band_low`` and ``band_high`` (rad/s), ``warnings``.

    Raises
    ------
    QuestionError
        If there are too few values, or they are not those of a driving point in the convention e^(+i w t).
    """
    every = np.asarray(measured["frequency"].values, np.float64)
    used = _used(every, band)
    part = measured.isel(frequency=np.flatnonzero(used))
    frequency, values = every[used], receptance_of(part)
    unit, size = math.sqrt(frequency[0] * frequency[-1]), float(np.abs(values).max())
    coherence = np.asarray(part["coherence"].values, np.float64) if "coherence" in part else None
    described = NoiseShapes(noise, frequency / unit, values / size, coherence)
    _refuse_growth(described)
    best, kept, dropped = sure_modes(described, modes, most_modes, progress if callable(progress) else None)
    lone = np.zeros_like(used)
    lone[np.flatnonzero(used)[~kept]] = True
    found = fit_dataset(measured, used & ~lone, best, unit, size, noise)
    return with_doubts(found, best, unit, every[lone], [unit * frequency for frequency in dropped])


def receptance_of(measured: xr.Dataset) -> Complexes:
    """The measured values, m/N."""
    return np.asarray(measured["receptance_real"].values + 1j * measured["receptance_imag"].values, np.complex128)


def pole_model(fit: xr.Dataset, added_mass: float = 0.0) -> PoleModel:
    """The fitted receptance for :mod:`autobalancer.measurement.loop.closed_loop`."""
    poles = fit["pole_real"].values + 1j * fit["pole_imag"].values
    return PoleModel(poles, fit["residue_real"].values + 1j * fit["residue_imag"].values, added_mass)


def modes_of(fit: xr.Dataset) -> list[tuple[float, float]]:
    """Frequency (rad/s, undamped) and damping ratio of each pair of poles of ``fit``, ascending."""
    pairs = zip(fit["mode_frequency"].values, fit["mode_damping_ratio"].values, strict=True)
    return [(float(frequency), float(ratio)) for frequency, ratio in pairs]


def resampled(fit: xr.Dataset, count: int, seed: int, added_mass: float = 0.0) -> Iterator[PoleModel]:
    """Fits of the fitted receptance with new noise of the same size; the number of modes stays."""
    random = generator(seed)
    part = fit.isel(frequency=np.flatnonzero(fit["used"].values))
    frequency = np.asarray(part["frequency"].values, np.float64)
    fitted = np.asarray(part["fitted_real"].values + 1j * part["fitted_imag"].values, np.complex128)
    deviation = np.asarray(part["noise_deviation"].values, np.float64)
    unit, size = math.sqrt(frequency[0] * frequency[-1]), float(np.abs(fitted).max())
    start = pole_model(fit).poles[: fit.attrs["modes"]] / unit
    for _ in range(count):
        noise = random.normal(size=(2, fitted.size)) * deviation / math.sqrt(2.0)
        values = fitted + noise[0] + 1j * noise[1]
        weights = size / (deviation * math.sqrt(fitted.size))
        poles, residues = Fitting(frequency / unit, values / size, weights).search([start]).poles_and_residues()
        yield PoleModel(unit * poles, unit * size * residues, added_mass)


def _used(frequency: Floats, band: tuple[float | str, float | str] | None) -> NDArray[np.bool_]:
    used = np.ones(frequency.size, np.bool_)
    words = ""
    if band is not None:
        low, high = ends_argument("band", band, "rad/s")
        if not 0.0 <= low < high:
            raise QuestionError(f"band: given {low:g} to {high:g} rad/s; must ascend from zero or above")
        used = (frequency >= low * (1.0 - ROUNDING)) & (frequency <= high * (1.0 + ROUNDING))
        words = f" in the band; it is measured from {hertz(frequency[0])} to {hertz(frequency[-1])} Hz"
    if used.sum() < FEWEST:
        raise QuestionError(f"receptance: {used.sum()} values are too few for a fit; give {FEWEST} or more{words}")
    return used


def _refuse_growth(noise: NoiseShapes) -> None:
    """The imaginary part of the values, weighted by their noise, must not be that of a force that feeds energy."""
    weight = 1.0 / noise.start
    if float((weight * np.abs(noise.values) * noise.values.imag).sum()) > 0.0:
        raise QuestionError(
            "receptance: its imaginary part is positive, so the force would draw energy from the rotor; "
            "turn the sign of the force, or take the complex conjugate if the file uses e^(-i w t)"
        )
