"""How the fluids of a machine lag behind their chambers, worked out before a run."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from autobalancer.assembly.guided import Lag
from autobalancer.assembly.profile import SpeedProfile
from autobalancer.assembly.system import Assembly, assemble
from autobalancer.errors import MachineError
from autobalancer.machine import Machine, PrescribedSpeed

if TYPE_CHECKING:
    from autobalancer.flow.annulus import Annulus
    from autobalancer.flow.speed import WallSpeed


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
    asked = {place: model for place, model in models.items() if model != "modes"}
    if end is None and "full" in asked.values():
        b, r = next(place for place, model in asked.items() if model == "full")
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
    if end is None or not asked:
        return KnownLags(diffusing, {"flow_model": "modes"})
    if not isinstance(machine.drive, PrescribedSpeed) or machine.drive.couplings:
        from autobalancer.simulation.passes import lags_by_passes

        return lags_by_passes(machine, end, chambers, diffusing, asked, seed, max_steps)
    profile, found = machine.drive.profile, dict(diffusing)
    models_used, uncertain = dict.fromkeys(models, "modes"), 0.0
    for place, model in asked.items():
        solved = _solved_once(chambers[place], profile, end, model)
        models_used[place], uncertain = solved.model, float(np.maximum(uncertain, solved.uncertainty))
        if solved.lag is not None:
            found[place] = solved.lag
    return KnownLags(found, flow_record(models_used, uncertain))


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
    from autobalancer.flow.choice import relaxation_modes

    modes = relaxation_modes(annulus)
    return Lag(rates=modes.rates, gains=modes.gains)


def flow_record(models: Mapping[Place, str], uncertainty: float) -> dict[str, Any]:
    """Attributes of a result: models that were taken, and how far the speed of an unsteady flow is certain."""
    found: dict[str, Any] = {"flow_model": ", ".join(dict.fromkeys(models.values()))}
    if uncertainty != 0.0:
        share = f"by up to {uncertainty:.1%}" if math.isfinite(uncertainty) else "by an unknown share"
        found["flow_uncertainty"] = uncertainty
        found["flow_text"] = (
            f"the flow in the race is unsteady: on two grids the fluid's speed at the orbit differs {share} of the greatest speed"
        )
    return found


@dataclass(frozen=True)
class SolvedLag:
    """Model that was taken, table (None for modes), uncertainty over the greatest speed."""

    model: str
    lag: Lag | None
    uncertainty: float


def solved_lag(annulus: Annulus, speed: SpeedProfile | WallSpeed, end: float, model: str) -> SolvedLag:
    """The lag by the flow in a chamber; ``model`` is that of the fluid, "full" or "auto"."""
    from autobalancer.flow.annulus_problem import annulus_flow

    flow = annulus_flow(annulus, speed, duration=end, model="chebyshev" if model == "full" else "auto", samples=SAMPLES)
    if flow.attrs["model"] == "modes":
        return SolvedLag("modes", None, 0.0)
    lag = flow["speed"].values - flow["fluid_speed"].values
    table = Lag(times=np.asarray(flow["time"].values, np.float64), values=np.asarray(lag, np.float64))
    return SolvedLag(str(flow.attrs["model"]), table, float(flow.attrs["uncertainty"]))


@lru_cache(maxsize=64)
def _solved_once(annulus: Annulus, profile: SpeedProfile, end: float, model: str) -> SolvedLag:
    """The balls do not disturb the flow, so one solution serves all runs with this profile."""
    return solved_lag(annulus, profile, end, model)


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
