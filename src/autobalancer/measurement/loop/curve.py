"""The loop through rotor and balls as a curve: what passes the point +1 on the wrong side is unstable."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.measurement.loop.balls import RaceBalls
from autobalancer.measurement.loop.growth import receptance_stability
from autobalancer.results.answers.labeled import Labeled
from autobalancer.results.provenance import provenance
from autobalancer.rotordynamics.receptance.pole_model import PoleModel
from autobalancer.rotordynamics.receptance.rational_fit import pole_model
from autobalancer.stability.states.polygon import directions
from autobalancer.units import argument

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]


def receptance_loop(fit: xr.Dataset, balls: RaceBalls, speed: float | str, *, balls_on_rotor: bool) -> xr.Dataset:
    """The loop L = (a_0/2) w^4 H(iw) over the frequency w in space, for balls evenly spread over directions.

    There the equation of :mod:`autobalancer.measurement.loop.growth` splits into 1 = L and its conjugate (equal balls:
    L = (c N/2) w^4 H(iw)/P(i(w - W))), so measured values can be drawn as they are. If stable, the curve,
    followed with rising frequency, has +1 on its left. At w = W it comes from infinity.

    Parameters
    ----------
    fit, balls, balls_on_rotor
        As for :func:`receptance_stability`.
    speed
        Rotor speed, rad/s.

    Returns
    -------
    xarray.Dataset
        ``loop_real`` and ``loop_imag`` over ``loop_frequency`` (rad/s) from the fit; ``measured_loop_real`` and
        ``measured_loop_imag`` over ``frequency`` from the measured values. ``attrs``: speed, growth rate, gain and
        phase margin of balls so spread.
    """
    speed = argument("speed", speed, "rad/s")
    model = pole_model(fit, 0.0 if balls_on_rotor else float(balls.mass.sum()))
    weight = balls.moment**2
    level = max(0.0, 2.0 * float(weight.max()) - float(weight.sum()))
    doubled = directions(weight, complex(level))
    assert doubled is not None
    row = receptance_stability(fit, balls, [speed], balls_on_rotor=balls_on_rotor, angles=0.5 * doubled)
    frequency = _frequencies(fit, model, speed)
    measured_at = fit["frequency"].values
    bare = fit["receptance_real"].values + 1j * fit["receptance_imag"].values
    measured = bare / (1.0 - model.added_mass * measured_at**2 * bare)
    found = xr.Dataset(coords={"loop_frequency": frequency, "frequency": measured_at})
    curves = {
        "loop": ("loop_frequency", _loop(balls, speed, frequency, model.at(frequency))),
        "measured_loop": ("frequency", _loop(balls, speed, measured_at, measured)),
    }
    for name, (dim, values) in curves.items():
        found[f"{name}_real"] = (dim, values.real, {"long_name": "loop, real part", "units": ""})
        found[f"{name}_imag"] = (dim, values.imag, {"long_name": "loop, imaginary part", "units": ""})
        found[dim].attrs = {"long_name": "frequency in space", "units": "rad/s"}
    found.attrs = {
        **provenance(),
        "title": "Loop of evenly spread balls",
        "speed": float(speed),
        "ignores": balls.ignores,
    }
    found.attrs |= {name: float(row[name][0]) for name in ("growth_rate", "gain_margin", "phase_margin")}
    return Labeled.of(found)


def _loop(balls: RaceBalls, speed: float, frequency: Floats, receptance: Complexes) -> Complexes:
    turning = 1j * (frequency[:, None] - speed)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = (balls.moment**2 / (balls.inertia * turning**2 + balls.drag * turning)).sum(axis=1)
        return np.asarray(0.5 * share * frequency**4 * receptance, np.complex128)


def _frequencies(fit: xr.Dataset, model: PoleModel, speed: float) -> Floats:
    """Even over the logarithm, and dense about every mode and about the speed, where the curve runs fast."""
    low, high = 0.3 * min(speed, fit.attrs["band_low"]), 1.5 * max(speed, fit.attrs["band_high"])
    shares = np.sinh(np.linspace(-9.0, 9.0, 400))
    points = [np.geomspace(low, high, 800), speed * (1.0 + 1e-4 * shares)]
    for pole in model.poles[model.poles.imag > 0.0]:
        points.append(abs(pole) + 0.02 * abs(pole.real) * shares)
    every = np.unique(np.concatenate(points))
    return np.asarray(every[(every > low) & (every < high) & (every != speed)], np.float64)
