"""What the borders of stalled balls say of themselves."""

from __future__ import annotations

import math

from autobalancer.stability.border import Border
from autobalancer.stability.host.stations import Stations
from autobalancer.stability.stall.groups import Loads
from autobalancer.stability.stall.ranges import HangingRange

RELEASE, CAPTURE = "release speed", "capture speed"
HOW = "torque balance of stalled balls in line"
PASS = "the balls never stall: drag and friction carry them through"
DRAGLESS = "a ball without drag is not dragged along"
EXACTLY = "balls at exactly the same place stay stalled up to {0:.4g} rad/s"
NO_CAPTURE = "not computed where balls are never released"
RUN, GRADUAL = "end of a slow run", "half of the slip in a slow run"
RUN_DOWN = "slow run-down"
APART = "states in which the planes stall at different speeds are not sought, and balls may be released higher"
EARLIER_PLANE = "whether one plane falls back before, far above, was not sought by a slow run-down"
UNEQUAL = "unequal balls of one race may stall in more ways than were sought, and be released higher"
OTHERS = 4  # further release speeds in a note
WORTH = 0.002  # relative difference from which on a second release speed is said


def never(why: str, capture: bool) -> tuple[Border, ...]:
    """Balls that are never released."""
    release = Border(RELEASE, math.inf, why)
    return (release, Border(CAPTURE, math.nan, NO_CAPTURE, False)) if capture else (release,)


def capture_border(speed: float, which: str, balls: str = "", how: str = HOW) -> Border:
    """Of balls in line, or of some of them."""
    return Border(CAPTURE, speed, f"{how}: below it balls in line{balls} fall back to the resonance{which}")


def beyond(st: Stations, loads: Loads, one: HangingRange) -> str:
    """Where balls leave in a slow run, and how they lag there; the end of their balance is elsewhere."""
    slips: dict[str, float] = {}
    for group, slip in zip(loads.groups, one.slips, strict=True):
        slips[st.names[group.station]] = max(slip, slips.get(st.names[group.station], 0.0))
    each = ", ".join(f"those of {name} by {slip:.3g} rad/s" for name, slip in slips.items())
    until = f"the torque balance of balls in line ends at {float(one.state.speed[0]):.4g} rad/s"
    gradually = ", to half of it gradually" if one.cause == GRADUAL else ""
    each += f" slower than the rotor{gradually}; {until}"
    return f"slow run of stalled balls at the resonance of {one.whirl:.4g} rad/s: {each}"


def which(st: Stations, loads: Loads, one: HangingRange) -> str:
    """Which balls hang, if not all."""
    if len(one.groups) == len(loads.groups):
        return ""
    places = {group.station for group in loads.groups}
    held = {loads.groups[g].station for g in one.groups}
    if len(held) < len(places):
        names = ", ".join(st.names[place] for place in sorted(held))
        return f", balls of {names} alone, those of other planes are free already"
    return ", the strongest balls alone"


def unsought(loads: Loads, runs: bool) -> list[str]:
    """Why balls may be released higher than said; ``runs``: whether slow runs sought planes at different speeds."""
    planes = len({group.station for group in loads.groups})
    return [APART] * (planes > 1 and not runs) + [UNEQUAL] * (len(loads.groups) > planes)


def others(st: Stations, loads: Loads, met: list[HangingRange], last: HangingRange) -> list[str]:
    """The next lower ends, each resonance and set once."""
    rest = sorted((one for one in met if one is not last and math.isfinite(one.end)), key=lambda one: -one.end)
    found: list[str] = []
    for one in rest:
        held = {loads.groups[g].station for g in one.groups}
        alone = (
            "" if len(one.groups) == len(loads.groups) else f" ({', '.join(st.names[p] for p in sorted(held))} alone)"
        )
        text = f"{one.end:.4g} rad/s at that of {one.whirl:.4g} rad/s{alone}"
        if text not in found:
            found.append(text)
    return found[:OTHERS]


def again(one: HangingRange) -> str:
    """A range that no run-up meets."""
    to = "" if math.isinf(one.end) else f" to {one.end:.4g}"
    return f"from {one.begin:.4g}{to} rad/s on balls can stall again, at a resonance that rises with the speed, never passed"
