"""Whether the balls of a run kept to the range in which their drag law and slipstream are known."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from autobalancer.assembly.system import Assembly
from autobalancer.kernels.integrators.memory import NEXT_BIN, TIME, Memory
from autobalancer.kernels.integrators.record import Record
from autobalancer.kernels.system import Floats, Matrix
from autobalancer.laws.drag_curve import stokes_record
from autobalancer.laws.slipstream import range_record
from autobalancer.simulation.saved.saved_lags import saved_lag


def drag_range_attributes(assembly: Assembly, run: xr.Dataset, record: Record, state: Memory) -> dict[str, Any]:
    """For the result: law, greatest Reynolds number and a warning where the law was left; empty where beta is given.

    The same of the slipstream where there is one. Velocities are those saved with the run, along the race and relative to its
    fluid, which may lag.
    """
    found: dict[str, Any] = {}
    greatest: dict[Any, float] = {}
    in_line, stokes = -1.0, -1.0
    for number, ball in enumerate(assembly.balls):
        if ball.drag_curve is None and not (ball.slipstream or ball.stokes):
            continue
        for name, (times, states) in _saved(record, state).items():
            if name in run:
                rates = run[name].isel(ball=number).values
                speeds = np.abs(rates + saved_lag(assembly, number, states[: rates.size], times[: rates.size]))
                if speeds.size:
                    velocity = float(np.nanmax(speeds)) * ball.orbit_radius
                    if ball.slipstream:
                        in_line = max(in_line, velocity * ball.diameter / ball.fluid_viscosity)
                    if ball.stokes:
                        stokes = max(stokes, velocity * ball.diameter / ball.fluid_viscosity)
                    if ball.drag_curve is not None:
                        greatest[ball.drag_curve] = max(greatest.get(ball.drag_curve, 0.0), velocity)
    for curve, velocity in greatest.items():
        one = curve.range_record(velocity)
        if not found or one["drag_reynolds"] > found["drag_reynolds"]:
            found = one
    if not found and stokes >= 0.0:
        found = stokes_record(stokes)
    return found | (range_record(in_line) if in_line >= 0.0 else {})


def _saved(record: Record, state: Memory) -> dict[str, tuple[Floats, Matrix]]:
    """Times and states behind the ball speeds of a run; a bin that the end of the run cut short has the last state."""
    bins = int(state.counts[NEXT_BIN])
    ends, states = record.bin_edges[1 : bins + 1], record.bin_states[:bins]
    return {
        "ball_speed_in_rotor": (record.sample_times, record.samples),
        "envelope_ball_speed_in_rotor": (np.append(ends, state.clock[TIME]), np.vstack([states, state.state])),
    }
