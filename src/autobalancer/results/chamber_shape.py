"""What a run of a deep chamber says about its machine: sizes of the chambers, and the unbalance of the rotor."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from autobalancer.machine.chamber import Chamber, ChamberUnbalance

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class ChamberShape:
    """A cylinder around the rotor's axis: radius and depth (m), place of its middle along the axis (m), inner radius (m)."""

    radius: float
    depth: float
    place: float = 0.0
    inner_radius: float = 0.0


def chambers_of(run: xr.Dataset) -> list[ChamberShape]:
    """The chambers in their order, as the machine of the run describes them.

    Without a description a chamber is taken as what its balls have reached, which is exact for the radius once a ball has
    been at the race.
    """
    described = _machine(run).get("chambers")
    if described:
        parts = [Chamber(**entry) for entry in _listed(described)]
        return [
            ChamberShape(float(part.radius), part.inner_depth, float(part.position), float(part.inner_radius))
            for part in parts
        ]
    place = run["ball_position"].transpose("time", "ball", "axis").values
    radius, number = run["ball_radius"].values, run["chamber"].values.astype(int)
    reach = np.hypot(place[:, :, 1], place[:, :, 2]).max(axis=0) + radius
    along = np.abs(place[:, :, 0]).max(axis=0) + radius
    chambers = []
    for chamber in range(1, int(number.max(initial=1)) + 1):
        mine = number == chamber
        chambers.append(ChamberShape(float(reach[mine].max(initial=1e-3)), 2.0 * float(along[mine].max(initial=1e-3))))
    return chambers


def unbalance_of(run: xr.Dataset) -> tuple[complex, complex] | None:
    """Static unbalance (kg m) and couple unbalance (kg m²) of the rotor, complex in the rotor; None if it is not described.

    Of the machine that ``run`` keeps; the couple counts from the plane x = 0.
    """
    machine = _machine(run)
    if "chambers" not in machine:
        return None
    static = couple = 0.0 + 0.0j
    for entry in _listed(machine.get("unbalances", [])):
        part = ChamberUnbalance(**entry)
        static, couple = static + part.vector, couple + part.position * part.vector
    return static, couple


def _machine(run: xr.Dataset) -> dict[str, Any]:
    try:
        return tomllib.loads(str(run.attrs.get("machine", "")))
    except tomllib.TOMLDecodeError:
        return {}


def _listed(entries: Any) -> list[dict[str, Any]]:
    return entries if isinstance(entries, list) else [entries]


def bodies_of(run: xr.Dataset) -> str:
    """What rolls in the chambers, as a word: "balls" or "cylinders"."""
    return "cylinders" if "ball_length" in run.variables else "balls"


def is_chamber_run(result: xr.Dataset) -> bool:
    """Whether its balls moved freely in chambers."""
    import xarray as xr

    return isinstance(result, xr.Dataset) and "body_position" in result
