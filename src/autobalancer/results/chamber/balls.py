"""Where the balls of a deep chamber are in the rotor, what they balance there, and when they came to rest."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.results.answers.labeled import Labeled
from autobalancer.results.chamber.shape import chambers_of

Floats = NDArray[np.float64]
CARRIED = 0.5  # a ball that turns faster than this share of the rotor speed goes around with the rotor


def window(run: xr.Dataset, last: float | None = None) -> slice:
    """Samples of the last seconds of a run, by default its last tenth; that is what the measures call steady state.

    Raises
    ------
    QuestionError
        If the run has fewer than two samples there, or ``last`` is not positive.
    """
    if "time" not in run.variables:
        raise QuestionError("this result is no run of simulate_chamber; there is nothing to measure")
    time = run["time"].values
    if time.size < 2:
        raise QuestionError(f"the run has {time.size} samples; at least two are needed")
    length = 0.1 * float(time[-1] - time[0]) if last is None else float(last)
    if not 0.0 < length <= (time[-1] - time[0]) * (1.0 + 1e-9):
        raise QuestionError(
            f"last: given {length:g} s; must be above zero and within the {time[-1] - time[0]:g} s of the run"
        )
    start = int(np.searchsorted(time, time[-1] - length * (1.0 + 1e-9)))
    if time.size - start < 2:
        raise QuestionError(f"last: there are fewer than two samples in {length:g} s; take a longer time")
    return slice(start, time.size)


def ball_places_in_rotor(run: xr.Dataset) -> xr.DataArray:
    """Places of the balls in the turning rotor (m): (time, ball, axis), x along the axis, y towards the zero mark.

    The tilt of the body against space is taken off the rotor angle, which is counted in space.
    """
    turned = run["rotor_angle"].values - run["body_rotation"].isel(axis=0).values
    place = run["ball_position"].transpose("time", "ball", "axis").values
    wound = (place[:, :, 1] + 1j * place[:, :, 2]) * np.exp(-1j * turned)[:, None]
    inside = np.stack([place[:, :, 0], wound.real, wound.imag], axis=2)
    coords = {name: run[name] for name in ("time", "ball", "axis") if name in run.coords}
    attrs = {"long_name": "position of a ball from the center of its chamber", "units": "m", "frame": "rotor"}
    return xr.DataArray(inside, coords, ("time", "ball", "axis"), attrs=attrs)


def balls_carried(run: xr.Dataset, last: float | None = None) -> xr.DataArray:
    """Which balls go around with the rotor in steady state: mean turning of each faster than half of the rotor's."""
    part = run.isel(time=window(run, last))
    place = part["ball_position"].transpose("time", "ball", "axis").values
    around = place[:, :, 1] + 1j * place[:, :, 2]
    turn = np.angle(around[1:] * np.conj(around[:-1])).sum(axis=0)
    own = part["rotor_angle"].values
    if np.abs(np.diff(own)).max(initial=0.0) > 0.5 * np.pi:
        raise QuestionError(
            "samples: fewer than four per revolution of the rotor; save more, to see how the balls circulate"
        )
    share = turn / (own[-1] - own[0]) if own[-1] != own[0] else np.zeros_like(turn)
    return xr.DataArray(
        share > CARRIED, {"ball": run["ball"]}, ["ball"], attrs={"long_name": "goes around with the rotor"}
    )


def ball_settling_time(run: xr.Dataset, tolerance: float = 1.0, last: float | None = None) -> xr.DataArray:
    """Time (s) from which each ball stays within ``tolerance`` ball radii of its mean place in the rotor in steady state.

    nan for a ball that still leaves it in the steady state, such as one that stays at the bottom of the chamber.
    """
    if not tolerance > 0.0:
        raise QuestionError(f"tolerance: given {tolerance:g} ball radii; must be greater than zero")
    place = ball_places_in_rotor(run).values
    steady = window(run, last)
    away = np.linalg.norm(place - place[steady].mean(axis=0), axis=2) > tolerance * run["ball_radius"].values
    time = run["time"].values
    found = np.full(place.shape[1], np.nan)
    for i in range(place.shape[1]):
        late = np.flatnonzero(away[:, i])
        after = int(late[-1]) + 1 if late.size else 0
        if after <= steady.start:
            found[i] = time[after]
    return xr.DataArray(found, {"ball": run["ball"]}, ["ball"], attrs={"long_name": "settling time", "units": "s"})


def balls_unbalance(run: xr.Dataset, chamber_places: Floats | None = None) -> xr.Dataset:
    """What the balls add to the unbalance of the rotor, static and dynamic, in the rotor.

    Parameters
    ----------
    run
        Samples of a chamber.
    chamber_places
        Places (m) of the chambers along the axis; by default those of the machine of the run.

    Returns
    -------
    xarray.Dataset
        Over ``time``: ``static``, the sum of m r (kg m), and ``couple``, the sum of m x r (kg m²), each with ``part``
        ``"y"`` and ``"z"`` in the rotor; x is counted from the plane of reference.
    """
    place = ball_places_in_rotor(run)
    mass = run["ball_mass"].values
    if chamber_places is None:
        chamber_places = np.array([chamber.place for chamber in chambers_of(run)])
    along = place.values[:, :, 0] + np.asarray(chamber_places, float)[np.asarray(run["chamber"].values, int) - 1]
    radial = place.values[:, :, 1:]
    static = np.einsum("b,tbp->tp", mass, radial)
    couple = np.einsum("b,tb,tbp->tp", mass, along, radial)
    found = xr.Dataset(coords={"time": run["time"], "part": ["y", "z"]})
    found["static"] = (
        ("time", "part"),
        static,
        {"long_name": "unbalance of the balls", "units": "kg m", "frame": "rotor"},
    )
    found["couple"] = (
        ("time", "part"),
        couple,
        {"long_name": "couple unbalance of the balls", "units": "kg m^2", "frame": "rotor"},
    )
    return Labeled.of_run(run, "Unbalance of the balls", found)


def residual_of_balls(
    run: xr.Dataset, unbalance: complex, couple: complex = 0.0, chamber_places: Floats | None = None
) -> xr.Dataset:
    """Size of what the balls of ``run`` leave of ``unbalance`` (kg m, complex in the rotor) and ``couple`` (kg m²), over time.

    ``chamber_places`` (chambers,) are the middles of the chambers along the axis, m; by default those of the run.

    Zero ``static`` is static balance, zero of both is dynamic balance.
    """
    own = balls_unbalance(run, chamber_places)
    found = xr.Dataset(coords={"time": run["time"]})
    for name, given, text, unit in (
        ("static", unbalance, "residual unbalance", "kg m"),
        ("couple", couple, "residual couple unbalance", "kg m^2"),
    ):
        part = own[name].values
        size = np.abs(part[:, 0] + 1j * part[:, 1] + given)
        found[name] = ("time", size, {"long_name": text, "units": unit})
    return Labeled.of_run(run, "Residual unbalance", found)
