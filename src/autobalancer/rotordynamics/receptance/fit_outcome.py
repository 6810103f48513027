"""The labelled outcome of a fit: poles, modes with their uncertainty, and the noise."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.results.provenance import provenance
from autobalancer.rotordynamics.receptance.modal_model import Modes
from autobalancer.rotordynamics.receptance.mode_checks import covariance
from autobalancer.rotordynamics.receptance.noise import Noise
from autobalancer.rotordynamics.receptance.pole_search import Found

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]


def fit_dataset(
    measured: xr.Dataset, used: NDArray[np.bool_], best: Found, unit: float, size: float, noise: Noise
) -> xr.Dataset:
    """See :func:`~.rational_fit.receptance`; ``best`` in frequencies and values so scaled."""
    frequency = np.asarray(measured["frequency"].values, np.float64)
    scaled = frequency / unit
    poles, residues = best.modes.poles_and_residues()
    poles, residues = unit * poles, unit * size * residues
    fitted = size * best.modes.at(scaled)
    deviation = np.full(frequency.size, math.nan)
    deviation[used] = size * np.sqrt(best.variance)
    found = measured.copy()
    values = np.asarray(measured["receptance_real"].values + 1j * measured["receptance_imag"].values)[used]
    error = _share(values - fitted[used], fitted[used], best.variance)
    lightness = float((residues * poles).sum().real)
    over_frequency = {
        "fitted_real": (fitted.real, "fitted receptance, real part", "m/N"),
        "fitted_imag": (fitted.imag, "fitted receptance, imaginary part", "m/N"),
        "noise_deviation": (deviation, "standard deviation of the noise", "m/N"),
        "used": (used.astype("int8"), "whether the value was used in the fit", ""),
    }
    for name, (part, text, sign) in over_frequency.items():
        found[name] = ("frequency", part, {"long_name": text, "units": sign})
    for name, both, sign in (("pole", poles, "1/s"), ("residue", residues, "m/(N s)")):
        found[f"{name}_real"] = ("pole", both.real, {"long_name": f"{name}, real part", "units": sign})
        found[f"{name}_imag"] = ("pole", both.imag, {"long_name": f"{name}, imaginary part", "units": sign})
    for name, part, text, sign in _mode_values(best.modes, covariance(best, scaled[used]), unit, size):
        found[name] = ("mode", part, {"long_name": text, "units": sign})
    found.attrs = {
        **measured.attrs,
        **provenance(),
        "fit_error": error,
        "noise": noise,
        "modes": best.modes.count,
        "effective_mass": 1.0 / lightness if lightness != 0.0 else math.inf,
        "band_low": float(frequency[used][0]),
        "band_high": float(frequency[used][-1]),
    }
    return found


def _share(left: Complexes, fitted: Complexes, variance: Floats) -> float:
    """Root mean square of what is left as a share of the values, each line with the weight of its noise."""
    return math.sqrt(float((np.abs(left) ** 2 / variance).sum() / (np.abs(fitted) ** 2 / variance).sum()))


def _mode_values(modes: Modes, spread: Floats, unit: float, size: float) -> list[tuple[str, Floats, str, str]]:
    """Frequency sqrt(e), damping ratio d/(2 sqrt(e)) and mass 1/a, ascending, each with its standard deviation."""
    k = modes.count
    d, e, a = np.exp(modes.shapes[:k]), np.exp(modes.shapes[k:]), modes.numerators[:, 0]
    order = np.argsort(e)
    own = np.arange(k)
    of_d, of_e, of_a = (np.maximum(np.diag(spread)[own + at], 0.0) for at in (0, k, 2 * k))
    both = spread[own, own + k]
    frequency, ratio, mass = unit * np.sqrt(e), 0.5 * d / np.sqrt(e), 1.0 / (size * unit**2 * a)
    rows = [
        ("frequency", frequency, 0.5 * frequency * np.sqrt(of_e), "undamped frequency", "rad/s"),
        ("damping_ratio", ratio, ratio * np.sqrt(np.maximum(of_d + 0.25 * of_e - both, 0.0)), "damping ratio", ""),
        ("mass", mass, np.abs(mass / a) * np.sqrt(of_a), "modal mass at the race", "kg"),
    ]
    found = []
    for name, values, deviation, text, sign in rows:
        found.append((f"mode_{name}", values[order], f"{text} of the mode", sign))
        found.append((f"mode_{name}_deviation", deviation[order], f"standard deviation of the {text}", sign))
    return found
