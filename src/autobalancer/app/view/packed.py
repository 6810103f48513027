"""A run as one block of bytes for the browser: a head in JSON that says what follows, then arrays, sent once.

Between samples the browser interpolates as films do: angles by their speeds, deflections in the frame of the rotor.
"""

from __future__ import annotations

import json
import struct
from typing import Any, Protocol

import numpy as np
import xarray as xr

from autobalancer.errors import AutobalancerError, QuestionError
from autobalancer.files.machine_file import parse_machine
from autobalancer.machine_kinds import machine_kind
from autobalancer.plots.style import ALL_BALLS, INK, UNBALANCE, ball_color
from autobalancer.results.drawn import Motion, bodies_of, races_of
from autobalancer.results.time_series import plane_vectors
from autobalancer.sketch import Layout

MAGIC = b"ABV1"
FRAMES = 400  # of a deep chamber; its balls are many
SAMPLES = 6001  # of balls in races


class Packer:
    """Collects arrays; ``bytes`` are the block."""

    def __init__(self, head: dict[str, Any]) -> None:
        self.head = head | {"arrays": {}}
        self.blocks: list[bytes] = []
        self.size = 0

    def add(self, name: str, values: Any, kind: str = "float32") -> None:
        """One array, rows first."""
        array = np.ascontiguousarray(np.asarray(values), dtype=kind)
        self.head["arrays"][name] = {"type": kind, "shape": list(array.shape), "at": self.size}
        block = array.tobytes()
        block += b"\0" * (-len(block) % 8)
        self.blocks.append(block)
        self.size += len(block)

    @property
    def bytes(self) -> bytes:
        """Magic, length of the head, head, arrays; all little endian and at multiples of 8."""
        head = json.dumps(self.head, separators=(",", ":"), allow_nan=False).encode()
        head += b" " * (-len(head) % 8)
        return b"".join([MAGIC, struct.pack("<I", len(head)), head, *self.blocks])


def packed(run: xr.Dataset) -> bytes:
    """The block of a run.

    Raises
    ------
    QuestionError
        If the run has no samples.
    """
    block: bytes = machine_kind(run)["packed"](run)
    return block


def _layout(run: xr.Dataset) -> Layout | None:
    """The outline of the machine of a run; ``None`` if the run does not say."""
    try:
        machine = parse_machine(str(run.attrs["machine"]))
        layout: Layout = machine_kind(machine)["layout"](machine)
        return layout
    except (KeyError, AutobalancerError):
        return None


def _bodies(layout: Layout | None, reach: float) -> list[list[float]]:
    """Start, end, radius, bore and whether it turns, of every body."""
    if layout is None or not layout.blocks:
        return [[-0.1 * reach, 0.1 * reach, 1.1 * reach, 0.0, 1.0]]
    return [
        [float(value) for value in (one.start, one.end, one.radius, one.bore, one.turning)] for one in layout.blocks
    ]


def packed_races(run: xr.Dataset) -> bytes:
    """The block of a run of balls in races."""
    motion = Motion(run)  # refuses a run without samples
    races, layout = races_of(run), _layout(run)
    thin = slice(None, None, max(1, -(-motion.time.size // SAMPLES)))
    count = races.orbit_radius.size
    places = [0.0] * (int(races.balancer.max(initial=1)))
    if layout is not None and len(layout.planes) >= len(places):
        places = [float(place) for place in layout.planes]
    balls = [
        {
            "orbit": float(races.orbit_radius[k]),
            "radius": 0.5 * float(races.ball_diameter[k]) or 0.04 * float(races.orbit_radius[k]),
            "z": places[int(races.balancer[k]) - 1],
            "plane": int(races.plane[k]),
            "center": [float(races.center[k].real), float(races.center[k].imag)],
            "color": ball_color(k),
            "body": str(bodies_of(run)[k]),
        }
        for k in range(count)
    ]
    reach = float(races.orbit_radius.max(initial=0.05))
    planes = sorted({(ball["plane"], ball["z"]) for ball in balls}) or [(0, 0.0)]
    names = [str(name) for name in run["plane"].values] if "plane" in run.coords else []
    head = {
        "kind": "races",
        "name": str(run.attrs.get("machine_name", "")),
        "outcome": str(run.attrs.get("outcome_text", "")),
        "balls": balls,
        "bodies": _bodies(layout, reach),
        "planes": [z for _, z in planes],
        "names": names if len(names) == len(planes) > 1 else [],  # of the planes, where there are several
        "springs": []
        if layout is None
        else [[float(one.place), float(one.radius)] for one in layout.springs if one.grounded],
        "horizontal": run.attrs.get("axis") == "horizontal",
    }
    out = Packer(head)
    out.add("time", motion.time[thin], "float64")
    out.add("speed", motion.speed[thin])
    out.add("angle", motion.rotor_angle[thin], "float64")
    planes_z = motion.plane_deflection_in_rotor[thin]
    out.add("re", planes_z.real)
    out.add("im", planes_z.imag)
    out.add("ball", motion.ball_angle[thin], "float64")
    out.add("slip", motion.ball_slip[thin])
    out.add("inside", motion.ball_inside[thin])
    heavy = motion.plane_unbalance_in_rotor[thin]  # a column a plane
    out.add("heavy_re", heavy.real)
    out.add("heavy_im", heavy.imag)
    Panels(out).races(run)
    return out.bytes


def packed_chamber(run: xr.Dataset) -> bytes:
    """The block of a run of deep chambers."""
    if run.sizes.get("time", 0) < 2:
        raise QuestionError("the run has fewer than two samples; run it longer")
    layout = _layout(run)
    step = slice(None, None, max(1, -(-run.sizes["time"] // FRAMES)))
    seen = run.isel(time=step)
    place = seen["ball_position"].transpose("time", "ball", "axis").values
    moved = seen["body_position"].transpose("time", "axis").values
    reach = float(np.abs(place).max()) or 1.0
    centers = (
        [0.0]
        if layout is None or not layout.fillings
        else [0.5 * (float(one.start) + float(one.end)) for one in layout.fillings]
    )
    head = {
        "kind": "chambers",
        "name": str(run.attrs.get("machine_name", "")),
        "outcome": str(run.attrs.get("outcome_text", "")),
        "bodies": _bodies(layout, reach),
        "chambers": centers,
        "reach": reach,
        "springs": []
        if layout is None
        else [[float(one.place), float(one.radius)] for one in layout.springs if one.grounded],
    }
    out = Packer(head)
    out.add("time", seen["time"].values, "float64")
    out.add("speed", seen["speed"].values)
    out.add("angle", seen["rotor_angle"].values, "float64")
    out.add("moved", moved)
    out.add("place", np.round(place / reach * 32000.0), "int16")
    out.add("radius", seen["ball_radius"].values)
    out.add("chamber", np.minimum(seen["chamber"].values, len(centers)) - 1, "int16")
    Panels(out).chamber(run)
    return out.bytes


# The waveforms of a run: which curves, in which unit, over which time.


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
