"""What must be doubted of a fit, and what to do about it."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.rotordynamics.receptance.answer import FittedReceptance
from autobalancer.rotordynamics.receptance.measured import hertz
from autobalancer.rotordynamics.receptance.mode_checks import covariance, frequencies, weak_modes
from autobalancer.rotordynamics.receptance.pole_search import Found

Floats = NDArray[np.float64]
SURE = 4.0  # standard deviations by which the fit must feed energy before it is said
LEAST = 3  # lines below their noise at an end of the band before it is said
WHAT_TO_DO = "look at the picture and try another number of modes (--modes) or a narrower band (--band)"


def with_doubts(found: xr.Dataset, best: Found, unit: float, lone: Floats, dropped: list[float]) -> xr.Dataset:
    """``found`` with its ``warnings``, one sentence a line; ``lone`` and ``dropped`` are frequencies, rad/s."""
    texts = [*_mass_doubt(found), *_energy_doubt(found, best, unit), *_weak_doubt(found, best, unit)]
    texts += [*_lone_doubt(lone), *_dropped(found, dropped), *_noise_doubt(found), *_tail_doubt(found)]
    found.attrs["warnings"] = "\n".join(texts)
    return FittedReceptance.of(found)


def _mass_doubt(found: xr.Dataset) -> list[str]:
    if found.attrs["effective_mass"] > 0.0:
        return []
    return [f"the fit has no positive mass at high frequency; measure to higher frequencies, or {WHAT_TO_DO}"]


def _energy_doubt(found: xr.Dataset, best: Found, unit: float) -> list[str]:
    grid = np.linspace(found.attrs["band_low"], found.attrs["band_high"], 2000) / unit
    known = covariance(best, _lines(found) / unit)
    slopes = best.modes.slopes(grid)
    unsure = np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", slopes.imag, known, slopes.imag), 0.0))
    values = best.modes.at(grid)
    active = unit * grid[values.imag > np.maximum(SURE * unsure, 1e-6 * np.abs(values))]
    if active.size == 0:
        return []
    return [
        f"the fit feeds energy between {hertz(active[0])} and {hertz(active[-1])} Hz, more than its noise explains, and no "
        f"rotor at rest does that: either there are too many modes or the lines there are bad ({WHAT_TO_DO}), "
        "or force and deflection are not at one place and along one direction"
    ]


def _weak_doubt(found: xr.Dataset, best: Found, unit: float) -> list[str]:
    weak = weak_modes(best, _lines(found) / unit)
    if not weak:
        return []
    return [f"the fit at {_listed(unit * frequencies(best)[weak])} Hz cannot be told from noise. Give fewer --modes"]


def _lone_doubt(lone: Floats) -> list[str]:
    if lone.size == 0:
        return []
    few = f"{_listed(lone[:4])} Hz" + (f" and {lone.size - 4} more" if lone.size > 4 else "")
    return [
        f"left out as disturbed: {few}, where no mode but single lines stand out, as mains hum or a bad line does. "
        "If it is a mode, measure with a finer resolution, or give --modes"
    ]


def _dropped(found: xr.Dataset, dropped: list[float]) -> list[str]:
    if not dropped:
        return []
    inside = [at for at in dropped if found.attrs["band_low"] <= at <= found.attrs["band_high"]]
    places = [f"at {_listed(inside)} Hz"] if inside else []
    places += [f"{len(dropped) - len(inside)} outside the band"] if len(inside) < len(dropped) else []
    return [f"dropped: fitted modes that cannot be told from noise or drift, {' and '.join(places)}"]


def _noise_doubt(found: xr.Dataset) -> list[str]:
    """Where at the ends of the band the noise is greater than the value."""
    used = np.flatnonzero(found["used"].values)
    size = np.hypot(found["fitted_real"].values, found["fitted_imag"].values)
    hidden = found["noise_deviation"].values[used] > size[used]
    frequency = found["frequency"].values[used]
    if hidden.all() or not hidden.any():
        return []
    texts = []
    if hidden[:LEAST].all():
        end = frequency[int(np.argmin(hidden))]
        texts.append(
            f"below {hertz(end)} Hz the noise is greater than the receptance, as usual where acceleration was measured; these "
            f'lines have almost no weight. --band "{hertz(end)} Hz:{hertz(frequency[-1])} Hz" leaves them out'
        )
    if hidden[-LEAST:].all():
        end = frequency[hidden.size - int(np.argmin(hidden[::-1])) - 1]
        texts.append(
            f"above {hertz(end)} Hz the noise is greater than the receptance; these lines have almost no weight. "
            f'--band "{hertz(frequency[0])} Hz:{hertz(end)} Hz" leaves them out'
        )
    return texts


def _tail_doubt(found: xr.Dataset) -> list[str]:
    """Modes outside the band, which are there to describe what reaches into it."""
    frequency = found["mode_frequency"].values
    low, high = found.attrs["band_low"], found.attrs["band_high"]
    outside = frequency[(frequency < low) | (frequency > high)]
    if outside.size == 0:
        return []
    which = "a mode at {} Hz lies" if outside.size == 1 else "modes at {} Hz lie"
    return [
        f"{which.format(_listed(outside))} outside the measured band: only what reaches into the band is known, so frequency "
        "and damping there are estimates"
    ]


def _lines(found: xr.Dataset) -> Floats:
    return np.asarray(found["frequency"].values[np.flatnonzero(found["used"].values)], np.float64)


def _listed(frequencies: list[float] | Floats) -> str:
    return ", ".join(hertz(value) for value in frequencies)
