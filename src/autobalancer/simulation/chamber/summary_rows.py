"""What is known of a machine with deep chambers, as rows of a table: a name and a text each."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

from autobalancer.results.number_text import moment_text

if TYPE_CHECKING:
    from autobalancer.simulation.chamber.summary import ChamberFilling, ChamberSummary

FREEDOM = {"fixed": "fixed", "planar": "moves in its plane", "free": "free"}


def chamber_rows(found: ChamberSummary, said: Callable[[float], str]) -> list[tuple[str, str]]:
    """Everything that ``check`` shows of it, with speeds as ``said`` writes them."""
    couple = f", couple {found.couple_unbalance * 1e9:.5g} g mm²" if found.couple_unbalance else ""
    steps = f", {found.duration / found.step:.3g} steps in {found.duration:g} s" if found.duration else ""
    between = "" if found.ball_friction is None else f", {found.ball_friction:g} between balls"
    those = f"{found.chambers[0].body}s"
    modes = zip(found.critical_speeds, found.damping_ratios, strict=True)
    return [
        ("body", FREEDOM[found.freedom]),
        ("mass", f"{found.total_mass:.6g} kg with balls, rotor {found.rotor_mass:.6g} kg"),
        *(("critical speed", f"{said(speed)}, damping ratio {100 * ratio:.3g} %") for speed, ratio in modes),
        ("unbalance", f"{moment_text(found.unbalance, 5)}{couple}"),
        *((f"chamber {filling.chamber}", _filling(filling, found.unbalance)) for filling in found.chambers),
        (
            "friction",
            f"{found.friction:g}{between}; with too little friction, or too few {those}, they stay at the bottom",
        ),
        ("shortest contact", f"{1e6 * found.contact_time:.4g} us{_at(found)}"),
        ("step", f"{1e6 * found.step:.4g} us{steps}"),
        ("highest speed", said(found.highest_speed)),
    ]


def _at(found: ChamberSummary) -> str:
    """A contact along a line takes the same time at any speed."""
    return "" if found.chambers[0].body == "cylinder" else " at 4 m/s"


def _filling(filling: ChamberFilling, unbalance: float) -> str:
    small, large = 1e3 * filling.smallest_diameter, 1e3 * filling.largest_diameter
    size = f"{large:.4g} mm" if math.isclose(small, large) else f"{small:.4g} to {large:.4g} mm"
    enough = f", {filling.capability / unbalance:.3g} times the unbalance" if unbalance else ""
    one = filling.balls == 1
    if filling.longest is not None:
        size += f" by {1e3 * filling.longest:.4g} mm"
    return (
        f"{filling.balls} {filling.body}{'' if one else 's'} of {size}, {filling.ball_mass:.4g} kg{'' if one else ' together'}\n"
        f"{1e3 * filling.depth:.4g} mm deep, {_room(filling)}{_tilt(filling.tilt)}\n"
        f"capability {moment_text(filling.capability, 5)}{enough}"
    )


def _tilt(tilt: float | None) -> str:
    if tilt is None:
        return ""
    return (
        ", so that one could turn over" if tilt > 1.57 else f", which lets one tilt by {math.degrees(tilt):.3g} degrees"
    )


def _room(filling: ChamberFilling) -> str:
    """Balls of mixed sizes may be more than there is room for of the largest."""
    share = "" if filling.balls > filling.room else f": {100 * filling.balls / filling.room:.3g} % filled"
    return f"room for {filling.room} of {1e3 * filling.largest_diameter:.4g} mm{share}"
