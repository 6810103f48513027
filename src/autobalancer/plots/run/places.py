"""The places on the axis whose deflection a run knows: the planes of its balancers, then its other stations."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr

from autobalancer.plots.run.ball_looks import planes_of
from autobalancer.results.drawn.motion import Complexes, Floats, cubic


class Place(NamedTuple):
    """A place and its motion; ``position`` is m along the axis, nan if not known."""

    name: str
    position: float
    deflection: Complexes  # m, x + i y in space, over time


def places(run: xr.Dataset, prefix: str = "") -> list[Place]:
    """The reference place first; with ``prefix`` "turn_" over the last revolutions.

    A station in the plane of a balancer is named after it once, not twice.
    """
    reference = np.asarray(run[f"{prefix}x"].values + 1j * run[f"{prefix}y"].values)
    found: list[Place] = []
    for kind in ("place",) if f"{prefix}place_x" in run else ("plane", "station"):
        if f"{prefix}{kind}_x" not in run:
            continue
        if kind == "place" and "place_kind" in run:
            run = run.isel(place=np.flatnonzero(run["place_kind"].values != "support"))
        names = planes_of(run).names if kind == "plane" else _renamed(run, kind)
        z = np.asarray(run[f"{prefix}{kind}_x"].values + 1j * run[f"{prefix}{kind}_y"].values)
        where = run[f"{kind}_position"].values if f"{kind}_position" in run else np.full(z.shape[1], np.nan)
        for name, position, column in zip(names, where, z.T, strict=True):
            if not any(np.allclose(column, place.deflection, rtol=1e-9, atol=0.0) for place in found):
                found.append(Place(str(name), float(position), column))
    same = [place for place in found if np.allclose(place.deflection, reference, rtol=1e-9, atol=0.0)]
    if not same:
        return [Place("rotor", float("nan"), reference), *found]
    return [same[0], *(place for place in found if place is not same[0])]


class PlacesInRotor(NamedTuple):
    """Places with a position on the axis, in its order, at some times."""

    names: tuple[str, ...]
    position: Floats  # (places,) m
    deflection: Complexes  # (times, places) m, in the rotor


def places_in_rotor(run: xr.Dataset, times: Floats) -> PlacesInRotor | None:
    """What is known along the axis at ``times`` (s); ``None`` if that are fewer than two places."""
    known = [place for place in places(run) if np.isfinite(place.position)]
    known = sorted(known, key=lambda place: place.position)
    if len({place.position for place in known}) < 2:
        return None
    samples = run["time"].values
    z = np.column_stack([place.deflection for place in known]) * np.exp(-1j * run["rotor_angle"].values)[:, None]
    between = cubic(times, samples, z, np.gradient(z, samples, axis=0))
    return PlacesInRotor(
        tuple(place.name for place in known), np.array([place.position for place in known]), np.asarray(between)
    )


def _renamed(run: xr.Dataset, kind: str) -> list[str]:
    """Names of stations or places; a place that is a plane is called by its balancers, as everywhere in pictures."""
    known = {}
    if "plane" in run:
        known = dict(zip(map(str, run["plane"].values), planes_of(run).names, strict=True))
    return [known.get(str(name), str(name)) if kind == "place" else str(name) for name in run[kind].values]
