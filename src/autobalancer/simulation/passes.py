"""The lag of a fluid where the speed of the rotor is a coordinate: run, solve the flow for its speed, run again.

The balls brake the rotor through their drag, so the speed depends on the lag, and the lag on the speed. Each pass takes the lag
from the speed of the pass before; the first takes modes. This is a waveform iteration (Lelarasmee, Ruehli and
Sangiovanni-Vincentelli 1982); the flow at an instant depends on the speeds before only, so it converges on any finite interval.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from autobalancer.assembly.guided import Lag
from autobalancer.assembly.system import Assembly, assemble
from autobalancer.flow.annulus import Annulus, Floats
from autobalancer.flow.speed import recorded_speed
from autobalancer.kernels.integrators import tableau as tableaus
from autobalancer.kernels.integrators.runge_kutta import advance
from autobalancer.kernels.system import SPEED
from autobalancer.machine import Machine
from autobalancer.simulation.fluid_lag import SAMPLES, KnownLags, Place, flow_record, solved_lag
from autobalancer.simulation.record import Samples, record_for
from autobalancer.simulation.steppers import equations, memory_for

SAME = 5e-4  # greatest change of the speed from pass to pass over the greatest speed; the lag changes by twice that at most
VAGUE = 0.1  # of the uncertainty of an unsteady flow, whose eddies differ from pass to pass; where this is more
MOST = 8
PRECISION = 1e-8  # of the runs that give the speed


def lags_by_passes(
    machine: Machine,
    end: float,
    chambers: Mapping[Place, Annulus],
    diffusing: Mapping[Place, Lag],
    asked: Mapping[Place, str],
    seed: int,
    max_steps: int,
) -> KnownLags:
    """The lags with which the speed of a run is that for which the flow was solved.

    Every pass goes to ``end``, whatever events would stop the run itself. Where a pass breaks off, its last speed is kept. The
    record says how many passes there were, how much the last one changed the speed, and whether that was little enough.
    """
    times = np.linspace(0.0, end, SAMPLES)
    lags, models = dict(diffusing), dict.fromkeys(chambers, "modes")
    passes, change, tolerance, uncertain = 0, np.inf, SAME, 0.0
    speeds = _speeds(assemble(machine, seed=seed, lags=lags), end, max_steps)
    while change > tolerance and passes < MOST:
        walls, passes, uncertain = recorded_speed(times, speeds), passes + 1, 0.0
        for place, model in asked.items():
            solved = solved_lag(chambers[place], walls, end, model)
            lags[place] = solved.lag or diffusing[place]
            models[place], uncertain = solved.model, float(np.maximum(uncertain, solved.uncertainty))
        if set(models.values()) == {"modes"}:
            return KnownLags(diffusing, flow_record(models, 0.0))
        before, speeds = speeds, _speeds(assemble(machine, seed=seed, lags=lags), end, max_steps)
        change = float(np.abs(speeds - before).max()) / max(float(np.abs(speeds).max()), 1e-300)
        tolerance = max(SAME, VAGUE * uncertain) if uncertain > 0.0 else SAME
    record = flow_record(models, uncertain) | {
        "flow_passes": passes,
        "flow_change": change,
        "flow_tolerance": tolerance,
        "flow_converged": int(change <= tolerance),
    }
    if change > tolerance:
        disagreement = (
            f"the flow in the race and the speed of the rotor did not agree after {passes} passes: the last one changed the "
            f"speed by {change:.1e} of its greatest value, {tolerance:.0e} is wanted; take fluid.lag = 'modes', or prescribe "
            "the speed"
        )
        record["flow_text"] = "; ".join([str(record[key]) for key in ("flow_text",) if key in record] + [disagreement])
    return KnownLags(lags, record)


def _speeds(assembly: Assembly, end: float, max_steps: int) -> Floats:
    """Speed of the rotor at equally spaced instants; after a run that breaks off, its last one."""
    pair = tableaus.dormand_prince_8()
    record = record_for([Samples(SAMPLES)], (), assembly, end)
    advance(*equations(assembly), assembly.system, pair, record, memory_for(assembly, end, PRECISION, pair), max_steps)
    speeds = record.samples[:, SPEED].copy()
    known = np.flatnonzero(np.isfinite(speeds))
    speeds[known[-1] + 1 :] = speeds[known[-1]]
    return np.asarray(speeds, np.float64)
