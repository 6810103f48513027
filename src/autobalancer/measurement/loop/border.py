"""Exact border speeds from a fitted receptance, with the uncertainty that comes from the noise of the measurement."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.optimize import brentq

from autobalancer.errors import QuestionError
from autobalancer.measurement.loop.balls import RaceBalls, positions
from autobalancer.measurement.loop.growth import receptance_stability, worst_growth
from autobalancer.patience import shows_progress
from autobalancer.results.answers.labeled import Labeled
from autobalancer.results.provenance import provenance
from autobalancer.rotordynamics.receptance.pole_model import PoleModel
from autobalancer.rotordynamics.receptance.rational_fit import pole_model, resampled
from autobalancer.units import ends_argument, optional_argument

Floats = NDArray[np.float64]
POINTS = 240
SHARES = (1e-3, 1e-2, 0.03, 0.1, 0.3)  # of a border within which that of a fit with new noise is looked for


@shows_progress
def receptance_border(
    fit: xr.Dataset,
    balls: RaceBalls,
    *,
    balls_on_rotor: bool,
    unbalance: float | str | None = None,
    angles: Floats | None = None,
    searched: tuple[float | str, float | str] | str | None = None,
    resamples: int = 0,
    seed: int = 0,
    progress: Callable[[float, float], None] | bool | None = None,
) -> xr.Dataset:
    """Speed ranges in which the balanced state is stable, and the exact border.

    Parameters
    ----------
    fit, balls, balls_on_rotor, unbalance, angles
        As for :func:`receptance_stability`.
    searched
        Speeds, rad/s; by default from the lowest mode in the measured band to the end of the band.
    resamples
        How many times the fit is repeated with its own noise added, for the uncertainty of the border.
    seed
        For that noise.
    progress
        By default a bar where a person is looking and it takes more than a second; False: none; or a function of
        (done, all).

    Returns
    -------
    xarray.Dataset
        Along ``range``: ``stable_from`` and ``stable_to``, rad/s. ``attrs``: ``exact_border``, the lowest speed from
        which on the state is stable up to the end of the search (inf if it is not stable there);
        ``exact_border_deviation``, its standard deviation (nan without resamples); ``searched``; ``warnings``.
    """
    unbalance = optional_argument("unbalance", unbalance, "kg*m")
    added = 0.0 if balls_on_rotor else float(balls.mass.sum())
    model, states = pole_model(fit, added), positions(balls, unbalance, angles)
    low, high = _search_range(fit, model) if searched is None else ends_argument("searched", searched, "rad/s")
    if not 0.0 < low < high:
        raise QuestionError(f"speeds searched: given {low:g} to {high:g} rad/s; must be above zero and ascend")
    ranges = _stable_ranges(model, balls, states, low, high)
    border = ranges[-1][0] if ranges and ranges[-1][1] == high else math.inf
    found = xr.Dataset(
        {
            "stable_from": ("range", [r[0] for r in ranges], {"long_name": "stable from", "units": "rad/s"}),
            "stable_to": ("range", [r[1] for r in ranges], {"long_name": "stable up to", "units": "rad/s"}),
        }
    )
    deviation = math.nan
    if resamples and math.isfinite(border):
        borders = []
        for number, again in enumerate(resampled(fit, resamples, seed, added), 1):
            borders.append(_border_near(partial(worst_growth, again, balls, states), border, high))
            if callable(progress):
                progress(number, resamples)
        known = [speed for speed in borders if math.isfinite(speed)]
        deviation = float(np.std(known, ddof=1)) if len(known) > 1 else math.nan
    at_border = {"balls_on_rotor": balls_on_rotor, "unbalance": unbalance, "angles": angles}
    there = receptance_stability(fit, balls, [border if math.isfinite(border) else high], **at_border)  # type: ignore[arg-type]
    found.attrs = {
        **provenance(),
        "title": "Exact border from a receptance",
        "theory": "exact: full equations",
        "state": "worst case over the positions of the balls" if len(states) > 1 else "one position of the balls",
        "exact_border": border,
        "exact_border_deviation": deviation,
        "searched": [low, high],
        "ignores": balls.ignores,
        "warnings": there.attrs["warnings"],
    }
    return Labeled.of(found)


def _search_range(fit: xr.Dataset, model: PoleModel) -> tuple[float, float]:
    high = float(fit.attrs["band_high"])
    modes = np.abs(model.poles[np.abs(model.poles.imag) > 0.3 * np.abs(model.poles.real)])
    inside = modes[(modes > fit.attrs["band_low"]) & (modes < high)]
    return (0.9 * float(inside.min()) if inside.size else float(fit.attrs["band_low"])), high


def _stable_ranges(
    model: PoleModel, balls: RaceBalls, states: list[Floats], low: float, high: float
) -> list[tuple[float, float]]:
    def rate(speed: float) -> float:
        return worst_growth(model, balls, states, speed)

    speeds = np.linspace(low, high, POINTS)
    stable = np.array([rate(speed) for speed in speeds]) < 0.0
    ranges: list[tuple[float, float]] = []
    start = low if stable[0] else math.nan
    for i in np.flatnonzero(stable[1:] != stable[:-1]):
        edge = float(brentq(rate, speeds[i], speeds[i + 1], xtol=1e-9 * high))
        if stable[i + 1]:
            start = edge
        else:
            ranges.append((start, edge))
    return [*ranges, (start, high)] if stable[-1] else ranges


def _border_near(rate: Callable[[float], float], border: float, high: float) -> float:
    """The speed near ``border`` at which the growth rate falls through zero; nan if there is none within a third."""
    for share in SHARES:
        low, top = border * (1.0 - share), min(border * (1.0 + share), high)
        if rate(low) > 0.0 > rate(top):
            return float(brentq(rate, low, top, xtol=1e-9 * high))
    return math.nan
