"""What the ends of many runs leave: residual unbalance, deflection and verdicts over the starts."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.results.verdict.rule import BALANCED, NO_VERDICT, NOT, PARTLY, WORSE, verdict_word
from autobalancer.stability.basins.end_states import AT_REST, STATES, Question
from autobalancer.stability.host.planar import Floats

QUANTILES = (0.5, 0.95, 1.0)
MOVING = "balls not at rest"
WORDS = (BALANCED, PARTLY, NOT, WORSE, MOVING)


def residuals(
    question: Question, dims: tuple[str, ...], angles: Floats, states: NDArray[Any], seen: Floats
) -> xr.Dataset:
    """Residual unbalance and deflection of each end, and the distributions over the starts that are possible.

    Where the balls rest, the deflection is the greatest in a turn that they leave once the transient of the rotor is gone;
    else ``seen``, that at the last instant of the run. A verdict compares it with that of evenly spread balls.
    """
    p = question.p
    left = np.abs(p.fixed_load + (p.moment * np.exp(1j * angles)).sum(axis=-1))
    resting = np.isin(states, [STATES.index(name) for name in AT_REST])
    possible = states != STATES.index("overlapping start")
    gain = _gain(question)
    alone, deflection = gain * abs(p.fixed_load), gain * left
    ends = np.where(resting & np.isfinite(deflection), deflection, seen)
    found = xr.Dataset(
        {"residual_unbalance": (dims, left), "final_deflection": (dims, ends)},
        {"quantile": list(QUANTILES), "verdict": list(WORDS)},
    )
    for name, values in (("residual_quantile", left), ("deflection_quantile", deflection)):
        there = values[resting]
        found[name] = ("quantile", np.quantile(there, QUANTILES) if there.size else np.full(len(QUANTILES), np.nan))
    words = [verdict_word(value / alone) if alone > 0.0 else NO_VERDICT for value in deflection[resting]]
    counts = [words.count(word) for word in WORDS[:-1]]
    counts.append(int((possible & ~resting).sum()))
    found["verdict_share"] = ("verdict", np.array(counts) / max(int(possible.sum()), 1))
    found["unbalance"] = abs(p.fixed_load)
    found["deflection_without_balls"] = alone
    for name, text, unit in (
        ("residual_unbalance", "unbalance of rotor and balls together", "kg m"),
        ("final_deflection", "deflection at the end", "m"),
        ("residual_quantile", "residual unbalance of the starts that end at rest", "kg m"),
        ("deflection_quantile", "deflection of the starts that end at rest", "m"),
        ("verdict_share", "share of the starts", "1"),
        ("unbalance", "unbalance without balls", "kg m"),
        ("deflection_without_balls", "deflection with evenly spread balls", "m"),
    ):
        found[name].attrs.update(long_name=text, units=unit)
    return found


def _gain(question: Question) -> float:
    """Greatest deflection in a turn over the unbalance, with balls at rest, 1/kg."""
    p = question.p
    stiffness = p.dynamic_stiffness(question.speed)
    if stiffness == 0.0:
        return np.inf
    forward = question.speed**2 / stiffness
    return float(abs(forward) + (0.0 if p.isotropic else abs(p.backward(question.speed, forward))))
