"""Over which speeds one oscillator stands for a rotor."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from autobalancer.assembly.rotors.model import Floats


class Curves(Protocol):
    """Receptance of the rotor, and without damping in total and of one mode; each (S,)."""

    @property
    def whole(self) -> Any:
        """With damping."""

    @property
    def undamped(self) -> Any:
        """Without damping."""

    @property
    def mode(self) -> Any:
        """Of the mode alone, without damping."""


def deviation(curves: Curves, speeds: Floats, stiffness: float, mass: float, damping: float) -> Floats:
    """Relative deviation of the receptance of an oscillator from that of the rotor."""
    own = 1.0 / (stiffness - speeds**2 * mass + 1j * speeds * damping)
    return np.asarray(np.abs(own - curves.whole) / np.abs(curves.whole))


def other_share(curves: Curves) -> Floats:
    """Share of all other modes in the receptance without damping; it may exceed one."""
    return np.asarray(np.abs(curves.undamped - curves.mode) / np.abs(curves.undamped))


def border(speeds: Floats, share: Floats, tolerance: float, center: float) -> tuple[float, float]:
    """The range around ``center`` in which ``share`` stays within the tolerance; nan if it does nowhere near.

    Linear between the speeds; an end of the speeds is an end of the range.
    """
    start = int(np.argmin(np.abs(speeds - center)))
    if not share[start] <= tolerance:
        return np.nan, np.nan
    ends = []
    for step, last in ((-1, 0), (1, speeds.size - 1)):
        i = start
        while i != last and share[i + step] <= tolerance:
            i += step
        if i == last:
            ends.append(float(speeds[i]))
            continue
        part = (tolerance - share[i]) / (share[i + step] - share[i])
        ends.append(float(speeds[i] + part * (speeds[i + step] - speeds[i])))
    return ends[0], ends[1]
