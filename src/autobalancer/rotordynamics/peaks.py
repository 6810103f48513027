"""Speeds at which the unbalance response has its peaks: the critical speeds one measures."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Literal, get_args

import numpy as np
import xarray as xr
from scipy.optimize import minimize_scalar

from autobalancer.assembly.rotors.model import Floats
from autobalancer.errors import QuestionError
from autobalancer.machine import Machine
from autobalancer.rotordynamics.answers import ResponsePeaks
from autobalancer.rotordynamics.question import attributes, chosen_places, rotor_of
from autobalancer.rotordynamics.response import UNITS, Quantity, amplitudes
from autobalancer.rotordynamics.rubber import rubber_of
from autobalancer.rotordynamics.unbalance import Given, load_of
from autobalancer.rotordynamics.whirl import greatest_mean, mean_of_greatest, whirl
from autobalancer.units import argument, unbalance_argument

Measure = Literal["mean_of_greatest", "greatest_mean"]


def response_peaks(
    machine: Machine | str | Path,
    lowest: float | str,
    highest: float | str,
    stations: Sequence[str | float] | str | float | None = None,
    unbalance: Given | str = None,
    *,
    balls: bool = False,
    measure: Measure = "mean_of_greatest",
    quantity: Quantity = "displacement",
    samples: int = 1000,
) -> ResponsePeaks:
    """Peaks of the response between two speeds, with damping; each is refined between the samples.

    Parameters
    ----------
    machine, stations, unbalance, balls, quantity
        As for :func:`~autobalancer.rotordynamics.response.response`.
    lowest, highest
        Rotor speeds, rad/s.
    measure
        Of the chosen stations together: ``mean_of_greatest``, or ``greatest_mean``.
    samples
        Number of speeds of the search; peaks closer than two of its steps are not distinguished.

    Returns
    -------
    xarray.Dataset
        Over ``peak``: ``peak_speed`` (rad/s) and ``peak_amplitude`` (m, m/s or m/s^2), by ascending speed.

    Raises
    ------
    QuestionError
        If the speeds do not ascend from zero, a measure is unknown, or as for ``response``.
    """
    lowest = argument("lowest", lowest, "rad/s")
    highest = argument("highest", highest, "rad/s")
    unbalance = unbalance_argument(unbalance)
    owner = "response_peaks"
    machine, model = rotor_of(machine, balls=balls)
    if not 0.0 <= lowest < highest or not highest <= model.top_speed:
        raise QuestionError(
            f"{owner}: given {lowest:g} to {highest:g} rad/s; must ascend from zero, up to {model.top_speed:g} rad/s at most"
        )
    if measure not in get_args(Measure):
        raise QuestionError(f"{owner}: measure: given {measure!r}; must be one of {', '.join(get_args(Measure))}")
    if quantity not in UNITS:
        raise QuestionError(f"{owner}: quantity: given {quantity!r}; must be one of {', '.join(UNITS)}")
    if samples < 3:
        raise QuestionError(f"{owner}: samples: given {samples}; must be at least 3")
    places = chosen_places(machine, model, stations, owner)
    load = load_of(machine, model, unbalance, None, owner)
    order = list(UNITS).index(quantity)
    summed = mean_of_greatest if measure == "mean_of_greatest" else greatest_mean

    soft = rubber_of(machine, model)

    def height(speeds: Floats) -> Floats:
        return speeds**order * summed(whirl(*amplitudes(model, speeds, load, places, soft)))

    grid = np.linspace(lowest, highest, samples)
    level = height(grid)
    found = []
    for i in np.flatnonzero((level[1:-1] > level[:-2]) & (level[1:-1] >= level[2:])) + 1:
        best = minimize_scalar(
            lambda w: -float(height(np.array([w]))[0]),
            bounds=(grid[i - 1], grid[i + 1]),
            method="bounded",
            options={"xatol": 1e-10 * grid[i]},
        )
        found.append((float(best.x), -float(best.fun)))
    result = xr.Dataset()
    for column, (name, text, unit) in enumerate(
        (("peak_speed", "speed of the peak", "rad/s"), ("peak_amplitude", "amplitude at the peak", UNITS[quantity]))
    ):
        result[name] = ("peak", [entry[column] for entry in found], {"long_name": text, "units": unit})
    result.attrs = attributes(machine, f"Peaks of the unbalance response of {machine.name}", balls=balls) | {
        "measure": measure,
        "quantity": quantity,
        "stations": places.names,
    }
    return ResponsePeaks.of(result)
