"""Speeds so close that straight lines between the values show every resonance as it is."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from autobalancer.assembly.rotors.model import Complexes, Floats

CHORD = 0.1  # of the greater end: a resonance is a circle through zero, so its peak is missed by 1 - cos(0.05), 0.13 %
ROUNDS = 16  # each about halves a step: one of 40 rpm ends at 0.0006 rpm; without damping there is no end
BESIDE = 0.49  # of a step: its middle is often a round speed, and may be a resonance without damping, without any value


def smooth_speeds(speeds: Floats, respond: Callable[[Floats], Complexes]) -> Floats:
    """``speeds``, ascending, with others between where the complex response, (S, places), turns or grows."""
    speeds = np.unique(speeds)
    values = respond(speeds)
    for _ in range(ROUNDS):
        size = np.abs(values)
        far = np.abs(np.diff(values, axis=0)) > CHORD * np.maximum(size[:-1], size[1:])
        wide = np.flatnonzero(far.any(axis=1))
        if wide.size == 0:
            break
        between = speeds[wide] + BESIDE * (speeds[wide + 1] - speeds[wide])
        speeds = np.insert(speeds, wide + 1, between)
        values = np.insert(values, wide + 1, respond(between), axis=0)
    return speeds
