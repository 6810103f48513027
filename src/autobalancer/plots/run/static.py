"""What of a deflection stands still in space, and what vibrates about it."""

from __future__ import annotations

import numpy as np
import xarray as xr

from autobalancer.results.drawn.motion import Complexes, Floats
from autobalancer.results.standing import NONE, load_of

SAMPLES = 60  # that are looked at around a moment
TURNS = 4.0  # of the rotor, at least as many as they span: within less a whirl that grows looks like one about another place
LEAST = 0.1  # of the vibration; a smaller static part cannot be told from one that comes and goes
APART = 30.0  # condition above which samples do not tell a turning vector from a standing one


def static_part(
    run: xr.Dataset, time: Floats, angle: Floats, deflection: Complexes, moment: float, *, samples: int = SAMPLES
) -> complex:
    """The mean place in m, x + i y in space, about which a place moves around a ``moment`` (s).

    Fitted to samples of the deflection in space: a vector that stands, one that turns with the rotor (by ``angle``) and
    one against it. Zero where nothing can deflect the rotor for good, as on a vertical axis without a recorded excitation,
    where samples lie so far apart that they always see the rotor from the same side, and where what these three leave is
    greater than the standing one.
    """
    loaded = load_of({"axis": "horizontal"} | run.attrs) != NONE
    still = not loaded or run.attrs.get("frame_of_integration", "space") == "rotor"
    if still or time.size < 8:
        return 0j
    near = np.argsort(np.abs(time - moment))[:samples]
    if np.ptp(angle[near]) < 2.0 * np.pi * TURNS:
        here = np.interp(moment, time, angle)
        near = np.flatnonzero(np.abs(angle - here) <= 2.0 * np.pi * TURNS)
    turned = np.exp(1j * angle[near])
    columns = np.column_stack([np.ones(near.size), turned, turned.conj()])
    if np.linalg.cond(columns) > APART:
        return 0j
    standing, *turning = found = np.linalg.lstsq(columns, deflection[near], rcond=None)[0]
    rest = float(np.sqrt(np.mean(np.abs(deflection[near] - columns @ found) ** 2)))
    return complex(standing) if abs(standing) > max(LEAST * sum(map(abs, turning)), rest) else 0j
