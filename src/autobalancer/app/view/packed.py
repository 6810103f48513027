"""A run as one block of bytes for the browser: a head in JSON that says what follows, then arrays, sent once.

Between samples the browser interpolates as films do: angles by their speeds, deflections in the frame of the rotor.
"""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.app.view.panels import Panels
from autobalancer.catalog.resolve import resolve
from autobalancer.errors import AutobalancerError, QuestionError
from autobalancer.files.machine_file import parse_machine
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.plots.drawing.style import ball_color
from autobalancer.results.chamber.shape import is_chamber_run
from autobalancer.results.drawn.motion import Motion, bodies_of, races_of
from autobalancer.sketch.layout import Layout, chamber_layout, layout_of

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
    return _chamber(run) if is_chamber_run(run) else _races(run)


def _layout(run: xr.Dataset) -> Layout | None:
    """The outline of the machine of a run; ``None`` if the run does not say."""
    try:
        machine = parse_machine(str(run.attrs["machine"]))
        if isinstance(machine, ChamberMachine):
            return chamber_layout(machine)
        return layout_of(machine, resolve(machine))
    except (KeyError, AutobalancerError):
        return None


def _bodies(layout: Layout | None, reach: float) -> list[list[float]]:
    """Start, end, radius, bore and whether it turns, of every body."""
    if layout is None or not layout.blocks:
        return [[-0.1 * reach, 0.1 * reach, 1.1 * reach, 0.0, 1.0]]
    return [
        [float(value) for value in (one.start, one.end, one.radius, one.bore, one.turning)] for one in layout.blocks
    ]


def _races(run: xr.Dataset) -> bytes:
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


def _chamber(run: xr.Dataset) -> bytes:
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
