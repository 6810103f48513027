"""From a measured receptance to poles and residues: AAA proposes, least squares refines, the noise sets the order."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Literal

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.measurement.closed_loop import PoleModel
from autobalancer.measurement.modal_model import Fitting
from autobalancer.measurement.pole_search import best_modes
from autobalancer.random_numbers import generator
from autobalancer.results.provenance import provenance

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
Noise = Literal["relative", "absolute"]


def fit_receptance(
    measured: xr.Dataset, *, modes: int | None = None, most_modes: int = 8, noise: Noise = "relative"
) -> xr.Dataset:
    """Fit poles and residues of a stable, real system with inertia to a measured receptance.

    The AAA algorithm (Nakatsukasa, Sete and Trefethen 2018) proposes poles; they are folded into conjugate pairs and to
    the stable side, and those that contribute least are dropped, among them the doublets of noise. Poles and residues
    are then refined together by least squares under the condition that the receptance falls with the square of the
    frequency, as that of every body with mass does. The number of modes is that with the least Bayesian information
    criterion (Schwarz 1978).

    Parameters
    ----------
    measured
        From :func:`load_receptance`.
    modes
        Number of modes; by default chosen by the noise.
    most_modes
        Greatest number of modes that is tried.
    noise
        *relative*: errors are a share of the value; *absolute*: the same everywhere. A coherence in the data is
        used with either: variance in proportion to (1 - coherence)/coherence.

    Returns
    -------
    xarray.Dataset
        Along ``pole``: its real and imaginary part (1/s) and that of its residue (m/(N s)). Along ``frequency``: what
        was measured and what was fitted. ``attrs``: ``fit_error`` (root mean square over the band, as a share),
        ``modes``, ``effective_mass`` (kg, at high frequency), ``band_low`` and ``band_high`` (rad/s), ``warnings``.

    Raises
    ------
    QuestionError
        If there are too few values, or they are not those of a driving point in the convention e^(+i w t).
    """
    frequency = np.asarray(measured["frequency"].values, np.float64)
    values = np.asarray(measured["receptance_real"].values + 1j * measured["receptance_imag"].values, np.complex128)
    if frequency.size < 8:
        raise QuestionError(f"receptance: {frequency.size} values are too few for a fit; give 8 or more")
    weights = _weights(measured, values, noise)
    if float((weights**2 * np.abs(values) * values.imag).sum()) > 0.0:
        raise QuestionError(
            "receptance: its imaginary part is positive, so the force would draw energy from the rotor; "
            "turn the sign of the force, or take the complex conjugate if the file uses e^(-i w t)"
        )
    unit = math.sqrt(frequency[0] * frequency[-1])
    size = float(np.abs(values).max())
    fitting = Fitting(frequency / unit, values / size, weights * size)
    best = best_modes(fitting, frequency / unit, values / size, modes, most_modes)
    poles, residues = best.poles_and_residues()
    return _dataset(measured, values, unit * poles, unit * size * residues, best.count, noise)


def pole_model(fit: xr.Dataset, added_mass: float = 0.0) -> PoleModel:
    """The fitted receptance for :mod:`autobalancer.measurement.closed_loop`."""
    poles = fit["pole_real"].values + 1j * fit["pole_imag"].values
    return PoleModel(poles, fit["residue_real"].values + 1j * fit["residue_imag"].values, added_mass)


def modes_of(fit: xr.Dataset) -> list[tuple[float, float]]:
    """Frequency (rad/s, undamped) and damping ratio of each pair of poles, ascending."""
    poles = pole_model(fit).poles
    up, down = poles[: poles.size // 2], poles[poles.size // 2 :]
    frequency = np.sqrt((up * down).real)
    ratio = -0.5 * (up + down).real / frequency
    return [(float(frequency[i]), float(ratio[i])) for i in np.argsort(frequency)]


def resampled(fit: xr.Dataset, count: int, seed: int) -> Iterator[xr.Dataset]:
    """Fits of the fitted receptance with new noise of the same size; the number of modes stays."""
    random = generator(seed)
    fitted = fit["fitted_real"].values + 1j * fit["fitted_imag"].values
    measured = fit[[name for name in ("receptance_real", "receptance_imag", "coherence") if name in fit]]
    size = np.abs(fitted) if fit.attrs["noise"] == "relative" else np.abs(fitted).max()
    for _ in range(count):
        noise = random.normal(size=(2, fitted.size)) * fit.attrs["fit_error"] / math.sqrt(2.0)
        values = fitted + size * (noise[0] + 1j * noise[1])
        again = measured.assign(receptance_real=("frequency", values.real), receptance_imag=("frequency", values.imag))
        yield fit_receptance(again, modes=fit.attrs["modes"], noise=fit.attrs["noise"])


def _weights(measured: xr.Dataset, values: Complexes, noise: Noise) -> Floats:
    if noise not in ("relative", "absolute"):
        raise QuestionError(f"noise: given {noise!r}; must be 'relative' or 'absolute'")
    weights = 1.0 / np.abs(values) if noise == "relative" else np.full(values.size, 1.0 / np.abs(values).max())
    if "coherence" in measured:
        coherence = np.clip(measured["coherence"].values, 1e-3, 1.0 - 1e-4)
        share = coherence / (1.0 - coherence)
        weights = weights * np.sqrt(share / share.max())
    return np.asarray(weights / math.sqrt(values.size), np.float64)


def _dataset(
    measured: xr.Dataset, values: Complexes, poles: Complexes, residues: Complexes, count: int, noise: Noise
) -> xr.Dataset:
    frequency = measured["frequency"].values
    fitted = (residues / (1j * frequency[:, None] - poles)).sum(axis=1)
    scale = np.abs(values) if noise == "relative" else np.abs(values).max()
    error = float(np.sqrt((np.abs((fitted - values) / scale) ** 2).mean()))
    lightness = float((residues * poles).sum().real)
    found = measured.copy()
    found["fitted_real"] = ("frequency", fitted.real, {"long_name": "fitted receptance, real part", "units": "m/N"})
    found["fitted_imag"] = (
        "frequency",
        fitted.imag,
        {"long_name": "fitted receptance, imaginary part", "units": "m/N"},
    )
    for name, part, unit in (("pole", poles, "1/s"), ("residue", residues, "m/(N s)")):
        found[f"{name}_real"] = ("pole", part.real, {"long_name": f"{name}, real part", "units": unit})
        found[f"{name}_imag"] = ("pole", part.imag, {"long_name": f"{name}, imaginary part", "units": unit})
    found.attrs = {
        **measured.attrs,
        **provenance(),
        "fit_error": error,
        "noise": noise,
        "modes": count,
        "effective_mass": 1.0 / lightness if lightness != 0.0 else math.inf,
        "band_low": float(frequency[0]),
        "band_high": float(frequency[-1]),
        "warnings": "\n".join(_doubts(poles, residues, lightness, frequency)),
    }
    return found


def _doubts(poles: Complexes, residues: Complexes, lightness: float, frequency: Floats) -> list[str]:
    found = []
    if lightness <= 0.0:
        found.append("the fit has no positive mass at high frequency; measure to higher frequencies")
    grid = np.geomspace(0.03 * frequency[0], 30.0 * frequency[-1], 4000)
    grid = np.sort(np.concatenate([grid, np.abs(poles)]))
    fitted = (residues / (1j * grid[:, None] - poles)).sum(axis=1)
    active = grid[fitted.imag > 1e-6 * np.abs(fitted)]
    inside = active[(active >= frequency[0]) & (active <= frequency[-1])]
    if inside.size:
        found.append(
            f"the fit feeds energy between {inside[0]:.4g} and {inside[-1]:.4g} rad/s, which no rotor at rest does; "
            "is it a driving point, and are force and deflection along one direction?"
        )
    return found
