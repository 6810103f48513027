"""How the fluids of a machine lag behind their chambers, worked out before a run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from autobalancer.assembly.drive_train import SpeedProfile
from autobalancer.assembly.guided_balls import Lag
from autobalancer.assembly.system import Assembly, assemble
from autobalancer.errors import MachineError
from autobalancer.machine import Machine, PrescribedSpeed

if TYPE_CHECKING:
    from autobalancer.arrays import Floats
    from autobalancer.flow.annulus import Annulus
    from autobalancer.flow.relaxation import WallSpeed


SAMPLES = 2001  # instants of the tabled lag
Place = tuple[int, int]  # numbers of balancer and race, from 0


@dataclass(frozen=True)
class KnownLags:
    """The lags of a machine, and what a result says of them."""

    lags: Mapping[Place, Lag] = field(default_factory=dict)
    record: dict[str, Any] = field(default_factory=dict)


def fluid_lags(machine: Machine, end: float | None, *, seed: int = 0, max_steps: int = 100_000_000) -> KnownLags:
    """The lag of every fluid that has one.

    Modes are integrated along with the balls. Full equations are solved for the speed of the drive up to ``end``, and where the
    speed is a coordinate for that of a run, which is repeated with the lag until the speed no longer changes.

    Parameters
    ----------
    machine
        The machine.
    end
        Duration of the run, s; None where the speed is not that of the machine's drive, and then only modes are possible.
    seed, max_steps
        Of the runs that give the speed; as for :func:`autobalancer.simulate`.

    Raises
    ------
    MachineError
        If full equations are asked for and the speed cannot be known, or the race has no proper chamber.
    QuestionError
        If the flow cannot be solved.
    """
    models = _models(machine)
    if not models:
        return KnownLags()
    from autobalancer.flow.annulus import annulus_of

    chambers = {place: annulus_of(machine, place[0] + 1, place[1] + 1) for place in models}
    diffusing = {place: _diffusing(annulus) for place, annulus in chambers.items()}
    requested = {place: model for place, model in models.items() if model != "modes"}
    if end is None and "full" in requested.values():
        b, r = next(place for place, model in requested.items() if model == "full")
        raise MachineError(
            f"balancers[{b + 1}].races[{r + 1}].fluid.lag: given 'full', but this analysis has its own speeds, not known "
            "in advance; use 'auto' or 'modes'"
        )
    sheared = [place for place, annulus in chambers.items() if annulus.sheared is not None]
    if end is None and sheared:
        b, r = sheared[0]
        raise MachineError(
            f"balancers[{b + 1}].races[{r + 1}].fluid: this analysis has its own speeds, not known in advance, and a fluid with "
            "'shear' lags by no fixed modes; leave 'lag' or 'shear' out"
        )
    if end is None or not requested:
        return KnownLags(diffusing, {"flow_model": "modes"})
    if not isinstance(machine.drive, PrescribedSpeed) or machine.drive.couplings:
        return _lags_by_passes(machine, end, chambers, diffusing, requested, seed, max_steps)
    profile, lags = machine.drive.profile, dict(diffusing)
    models_used, uncertain = dict.fromkeys(models, "modes"), 0.0
    for place, model in requested.items():
        solved = _solved_once(chambers[place], profile, end, model)
        models_used[place], uncertain = solved.model, float(np.maximum(uncertain, solved.uncertainty))
        if solved.lag is not None:
            lags[place] = solved.lag
    return KnownLags(lags, _flow_record(models_used, uncertain))


def diffusing_lags(machine: Machine) -> dict[Place, Lag]:
    """The lags as those of fluids that only diffuse, as modes to be integrated along; empty where no fluid lags."""
    from autobalancer.flow.annulus import annulus_of

    return {(b, r): _diffusing(annulus_of(machine, b + 1, r + 1)) for b, r in _models(machine)}


def _models(machine: Machine) -> dict[Place, str]:
    return {
        (b, r): race.fluid.lag
        for b, balancer in enumerate(machine.balancers)
        for r, race in enumerate(balancer.races)
        if race.fluid is not None and race.fluid.lag != "none"
    }


def _diffusing(annulus: Annulus) -> Lag:
    from autobalancer.flow.relaxation import relaxation_modes

    modes = relaxation_modes(annulus)
    return Lag(rates=modes.rates, gains=modes.gains)


def _flow_record(models: Mapping[Place, str], uncertainty: float) -> dict[str, Any]:
    """Attributes of a result: models that were taken, and how far the speed of an unsteady flow is certain."""
    flow_record: dict[str, Any] = {"flow_model": ", ".join(dict.fromkeys(models.values()))}
    if uncertainty != 0.0:
        flow_record["flow_uncertainty"] = uncertainty
    return flow_record


@dataclass(frozen=True)
class _SolvedLag:
    """Model that was taken, table (None for modes), uncertainty over the greatest speed."""

    model: str
    lag: Lag | None
    uncertainty: float


def _solved_lag(annulus: Annulus, speed: SpeedProfile | WallSpeed, end: float, model: str) -> _SolvedLag:
    """The lag by the flow in a chamber; ``model`` is that of the fluid, "full" or "auto"."""
    from autobalancer.flow.annulus_problem import annulus_flow

    flow = annulus_flow(annulus, speed, duration=end, model="chebyshev" if model == "full" else "auto", samples=SAMPLES)
    if flow.attrs["model"] == "modes":
        return _SolvedLag("modes", None, 0.0)
    lag = flow["speed"].values - flow["fluid_speed"].values
    table = Lag(times=np.asarray(flow["time"].values, np.float64), values=np.asarray(lag, np.float64))
    return _SolvedLag(str(flow.attrs["model"]), table, float(flow.attrs["uncertainty"]))


@lru_cache(maxsize=64)
def _solved_once(annulus: Annulus, profile: SpeedProfile, end: float, model: str) -> _SolvedLag:
    """The balls do not disturb the flow, so one solution serves all runs with this profile."""
    return _solved_lag(annulus, profile, end, model)


# The lag where the speed of the rotor is a coordinate: run, solve the flow for its speed, run again.
#
# The balls brake the rotor through their drag, so the speed depends on the lag, and the lag on the speed. Each pass takes
# the lag from the speed of the pass before; the first takes modes. This is a waveform iteration (Lelarasmee, Ruehli and
# Sangiovanni-Vincentelli 1982); the flow at an instant depends on the speeds before only, so it converges on any finite
# interval.

SAME_SPEED = 5e-4  # greatest change of the speed from pass to pass over the greatest speed; the lag changes by twice that at most
UNSTEADY_SHARE = (
    0.1  # of the uncertainty of an unsteady flow, whose eddies differ from pass to pass; where this is more
)
MOST_PASSES = 8
PASS_PRECISION = 1e-8  # of the runs that give the speed


def _lags_by_passes(
    machine: Machine,
    end: float,
    chambers: Mapping[Place, Annulus],
    diffusing: Mapping[Place, Lag],
    requested: Mapping[Place, str],
    seed: int,
    max_steps: int,
) -> KnownLags:
    """The lags with which the speed of a run is that for which the flow was solved.

    Every pass goes to ``end``, whatever events would stop the run itself. Where a pass breaks off, its last speed is kept. The
    record says how many passes there were, how much the last one changed the speed, and whether that was little enough.
    """
    from autobalancer.flow.relaxation import recorded_speed

    times = np.linspace(0.0, end, SAMPLES)
    lags, models = dict(diffusing), dict.fromkeys(chambers, "modes")
    passes, change, tolerance, uncertain = 0, np.inf, SAME_SPEED, 0.0
    speeds = _rotor_speeds(assemble(machine, seed=seed, lags=lags), end, max_steps)
    while change > tolerance and passes < MOST_PASSES:
        walls, passes, uncertain = recorded_speed(times, speeds), passes + 1, 0.0
        for place, model in requested.items():
            solved = _solved_lag(chambers[place], walls, end, model)
            lags[place] = solved.lag or diffusing[place]
            models[place], uncertain = solved.model, float(np.maximum(uncertain, solved.uncertainty))
        if set(models.values()) == {"modes"}:
            return KnownLags(diffusing, _flow_record(models, 0.0))
        before, speeds = speeds, _rotor_speeds(assemble(machine, seed=seed, lags=lags), end, max_steps)
        change = float(np.abs(speeds - before).max()) / max(float(np.abs(speeds).max()), 1e-300)
        tolerance = max(SAME_SPEED, UNSTEADY_SHARE * uncertain) if uncertain > 0.0 else SAME_SPEED
    record = _flow_record(models, uncertain) | {
        "flow_passes": passes,
        "flow_change": change,
        "flow_tolerance": tolerance,
        "flow_converged": int(change <= tolerance),
    }
    return KnownLags(lags, record)


def _rotor_speeds(assembly: Assembly, end: float, max_steps: int) -> Floats:
    """Speed of the rotor at equally spaced instants; after a run that breaks off, its last one."""
    from autobalancer.kernels.integrators import tableau as tableaus
    from autobalancer.kernels.integrators.runge_kutta import advance
    from autobalancer.kernels.system import SPEED
    from autobalancer.simulation.record import Samples, record_for
    from autobalancer.simulation.steppers import equations, memory_for

    pair = tableaus.dormand_prince_8()
    record = record_for([Samples(SAMPLES)], (), assembly, end)
    advance(
        *equations(assembly), assembly.system, pair, record, memory_for(assembly, end, PASS_PRECISION, pair), max_steps
    )
    speeds = record.samples[:, SPEED].copy()
    known = np.flatnonzero(np.isfinite(speeds))
    speeds[known[-1] + 1 :] = speeds[known[-1]]
    return np.asarray(speeds, np.float64)


# A machine made ready to run: assembled, with the lag of its fluids worked out before.


def prepare(
    machine: Machine,
    end: float | None,
    *,
    seed: int = 0,
    rotating: bool | None = None,
    mass_spread: float = 0.0,
    max_steps: int = 100_000_000,
) -> Assembly:
    """Like :func:`autobalancer.assembly.system.assemble`, with fluids that lag behind their chamber.

    ``end`` is the duration of the run; None where the speed is not that of the machine's drive. ``max_steps`` is for the runs
    that :func:`autobalancer.simulation.fluid_lag.fluid_lags` may need.

    Raises
    ------
    MachineError
        Also if the flow in a race cannot be worked out.
    """
    known = fluid_lags(machine, end, seed=seed, max_steps=max_steps)
    return assemble(machine, seed=seed, rotating=rotating, lags=known.lags, mass_spread=mass_spread)
