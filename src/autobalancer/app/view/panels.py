"""The waveforms of a run: which curves, in which unit, over which time."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
import xarray as xr

from autobalancer.plots.drawing.style import ALL_BALLS, INK, UNBALANCE, ball_color
from autobalancer.results.places import plane_vectors

POINTS = 6001  # of a curve
CURVES = 12  # balls with a curve of their own
LENGTHS = (("nm", 1e9), ("µm", 1e6), ("mm", 1e3), ("m", 1.0))
MOMENTS = (("mg mm", 1e9), ("g mm", 1e6), ("kg mm", 1e3), ("kg m", 1.0))


class Arrays(Protocol):
    """What takes the arrays of the curves."""

    head: dict[str, Any]

    def add(self, name: str, values: Any, kind: str = "float32") -> None:
        """One array."""


class Panels:
    """Adds panels to a block."""

    def __init__(self, out: Arrays) -> None:
        self.out = out
        self.panels: list[dict[str, Any]] = []
        self.number = 0
        out.head["panels"] = self.panels

    def races(self, run: xr.Dataset) -> None:
        """Speed, deflection, ball angles, residual unbalance."""
        time = run["time"].values
        self._panel("speed", "rpm", [("rotor", INK, time, run["speed"].values * 30.0 / np.pi)])
        if "envelope_high" in run:
            high, low = run["envelope_high"].values, run["envelope_low"].values
            unit, scale = _unit(high, LENGTHS)
            at = run["envelope_time"].values
            self._panel("deflection", unit, [("greatest and least", ball_color(0), at, scale * high, scale * low)])
        else:
            size = run["deflection"].values
            unit, scale = _unit(size, LENGTHS)
            self._panel("deflection", unit, [("rotor", ball_color(0), time, scale * size)])
        if 0 < run.sizes.get("ball", 0) <= CURVES:
            angle = np.degrees(run["ball_angle_in_rotor"].values)
            lines = [(f"ball {k + 1}", ball_color(k), time, _wrapped(angle[:, k])) for k in range(angle.shape[1])]
            self._panel("ball angle in the rotor", "°", lines, (-180.0, 180.0))
        for title, whole, left in _unbalances(run):
            unit, scale = _unit(np.append(left, whole), MOMENTS)
            curves = [
                ("rotor and balls", ball_color(2), time, scale * left),
                ("rotor alone", UNBALANCE, time, scale * whole),
            ]
            self._panel(title, unit, curves)
        if "turn_x" in run:
            self.out.add("orbit_x", run["turn_x"].values)
            self.out.add("orbit_y", run["turn_y"].values)

    def chamber(self, run: xr.Dataset) -> None:
        """Speed, motion of the body, losses."""
        time = run["time"].values
        self._panel("speed", "rpm", [("rotor", INK, time, run["speed"].values * 30.0 / np.pi)])
        moved = run["body_position"].transpose("time", "axis").values
        unit, scale = _unit(moved, LENGTHS)
        names = zip(("along y", "along z"), (1, 2), strict=True)
        self._panel("motion of the body", unit, [(name, ball_color(k), time, scale * moved[:, k]) for name, k in names])
        losses = [("collisions", "loss_contact"), ("sliding", "loss_friction"), ("rolling", "loss_rolling")]
        known = [(text, ball_color(k), time, run[name].values) for k, (text, name) in enumerate(losses) if name in run]
        if known:
            self._panel("energy lost", "J", known)
        if "contacts_ball" in run:
            self._panel("contacts of balls per sample", "", [("begun", ALL_BALLS, time, run["contacts_ball"].values)])

    def _panel(self, title: str, unit: str, curves: list[Any], limits: tuple[float, float] | None = None) -> None:
        lines = []
        for name, color, time, high, *low in curves:
            thin = slice(None, None, max(1, -(-len(time) // POINTS)))
            keys = {"t": f"t{self.number}", "high": f"h{self.number}"}
            self.out.add(keys["t"], time[thin], "float64")
            self.out.add(keys["high"], high[thin])
            if low:
                keys["low"] = f"l{self.number}"
                self.out.add(keys["low"], low[0][thin])
            self.number += 1
            lines.append({"name": name, "color": color, **keys})
        self.panels.append({"title": title, "unit": unit, "lines": lines, "limits": limits})


def _unbalances(run: xr.Dataset) -> list[tuple[str, Any, Any]]:
    """Name, size of the unbalance, and what the balls leave of it, of every plane."""
    if "plane_balls" in run and run.sizes["plane"] > 1:
        whole, balls = plane_vectors(run)
        left = np.abs(whole + balls)
        names = [str(name) for name in run["plane"].values]
        return [(f"unbalance, {name}", np.abs(whole[:, k]), left[:, k]) for k, name in enumerate(names)]
    if "residual_unbalance" in run:
        return [("unbalance", run["unbalance"].values, run["residual_unbalance"].values)]
    return []


def _unit(values: Any, units: tuple[tuple[str, float], ...]) -> tuple[str, float]:
    """The unit in which the greatest value is between 1 and 1000."""
    most = float(np.nanmax(np.abs(values), initial=0.0))
    return next(((name, scale) for name, scale in units if most * scale < 1000.0), units[-1])


def _wrapped(degrees: Any) -> Any:
    return (degrees + 180.0) % 360.0 - 180.0
