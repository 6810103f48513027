"""Branches and special points as a labeled dataset."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.stability.diagrams.explorer import Explorer
from autobalancer.stability.periodic.rows import Row, verdict

TEXTS = ("kind", "name", "verdict", "special_type", "criticality")


def branch_dataset(explorer: Explorer, parameter: dict[str, str], attributes: dict[str, Any]) -> xr.Dataset:
    """Flat table of all points, branch after branch, and of all special points."""
    rows = [row for branch in explorer.branches for row in branch.rows]
    number = [i for i, branch in enumerate(explorer.branches, 1) for _ in branch.rows]
    kind = [branch.kind for branch in explorer.branches for _ in branch.rows]
    balls, names = len(explorer.kind), explorer.span.whole(0.0).host.names
    data: dict[str, tuple[Any, Any, dict[str, str]]] = {
        "branch": ("point", np.array(number, np.int64), {"long_name": "number of the branch, counted from 1"}),
        "parameter": ("point", [row.value for row in rows], parameter),
        "kind": ("point", kind, {"long_name": "equilibrium or orbit"}),
        "name": ("point", [row.name for row in rows], {"long_name": "name of the state or motion"}),
        "verdict": ("point", [verdict(row) for row in rows], {"long_name": "stable, marginal or unstable"}),
        "unstable_directions": (
            "point",
            np.array([row.unstable for row in rows], np.int64),
            {"long_name": "unstable directions"},
        ),
        "growth_rate": ("point", [row.growth for row in rows], _text("growth rate of the leading disturbance", "1/s")),
        **_motion(rows, balls, len(names), "point", ""),
    }
    found = explorer.specials
    marks = [f.row for f in found]
    lyapunov = [f.special.lyapunov for f in found]
    data |= {
        "special_type": ("special", [f.special.kind for f in found], {"long_name": "what happens there"}),
        "special_branch": (
            "special",
            np.array([f.branch + 1 for f in found], np.int64),
            {"long_name": "on which branch"},
        ),
        "special_parameter": ("special", [row.value for row in marks], parameter),
        "special_frequency": (
            "special",
            [f.special.frequency for f in found],
            _text("frequency of the motion", "rad/s"),
        ),
        "lyapunov_coefficient": ("special", lyapunov, _text("first Lyapunov coefficient for ball angles in rad", "1")),
        "criticality": (
            "special",
            [_criticality(value) for value in lyapunov],
            {"long_name": "super- or subcritical Hopf point"},
        ),
        "special_unstable_directions": (
            "special",
            np.array([row.unstable for row in marks], np.int64),
            {"long_name": "unstable directions there; 0 where stability begins or ends"},
        ),
        **_motion(marks, balls, len(names), "special", "special_"),
    }
    table = xr.Dataset(coords={"ball": np.arange(1, balls + 1)})
    if len(names) > 1:
        table = table.assign_coords(station=list(names))
    for name, (dims, values, attrs) in data.items():
        table[name] = (dims, np.asarray(values, np.str_ if name in TEXTS else None), attrs)
    table.attrs = attributes | {"branch_ends": [branch.ended for branch in explorer.branches]}
    return table


def stable_ranges(branches: xr.Dataset, number: int) -> list[tuple[float, float]]:
    """Ranges of the parameter (begin, end in the order of the branch, SI) in which a branch is not unstable."""
    part = branches.isel(point=np.flatnonzero(branches["branch"].values == number))
    good, values = part["verdict"].values != "unstable", part["parameter"].values
    inside = good[1:] & good[:-1]
    edges = np.flatnonzero(np.diff(np.concatenate([[False], inside, [False]]).astype(int)))
    return [(float(values[a]), float(values[b])) for a, b in edges.reshape(-1, 2)]


def _motion(rows: list[Row], balls: int, stations: int, dim: str, prefix: str) -> dict[str, Any]:
    def by_ball(values: list[Any]) -> Any:
        return np.array(values, np.float64).reshape(len(rows), balls)

    shape, most = (dim, "ball"), ", greatest of all stations" if stations > 1 else ""
    by_station = {
        f"{prefix}station_deflection_{which}": (
            (dim, "station"),
            np.array([row.stations[side] for row in rows], np.float64).reshape(len(rows), stations),
            _text(f"{word} deflection of a station", "m"),
        )
        for side, (which, word) in enumerate((("min", "least"), ("max", "greatest")))
        if stations > 1
    }
    low, high, speed = (by_ball([getattr(row, key) for row in rows]) for key in ("low", "high", "ball_speed"))
    turning = "; nan where the ball turns round and round"
    return {
        f"{prefix}deflection_min": (dim, [row.deflection[0] for row in rows], _text(f"least deflection{most}", "m")),
        f"{prefix}deflection_max": (dim, [row.deflection[1] for row in rows], _text(f"greatest deflection{most}", "m")),
        **by_station,
        f"{prefix}ball_angle_in_rotor_min": (shape, low, _text(f"least ball angle in the rotor{turning}", "rad")),
        f"{prefix}ball_angle_in_rotor_max": (shape, high, _text(f"greatest ball angle in the rotor{turning}", "rad")),
        f"{prefix}ball_speed_in_space": (shape, speed, _text("mean ball speed in space", "rad/s")),
        f"{prefix}period": (dim, [row.period for row in rows], _text("period in the frame of the rotor", "s")),
    }


def _text(long_name: str, units: str) -> dict[str, str]:
    return {"long_name": long_name, "units": units}


def _criticality(lyapunov: float) -> str:
    return "" if math.isnan(lyapunov) else "supercritical" if lyapunov < 0.0 else "subcritical"
