"""What the ends of many runs leave: residual unbalance, deflection and verdicts over the starts."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.results.verdict.rule import BALANCED, NO_VERDICT, NOT, PARTLY, WORSE, verdict_word
from autobalancer.stability.basins.end_states import AT_REST, STATES, Question
from autobalancer.stability.host.planar import Complexes, Floats
from autobalancer.stability.host.stations import Stations
from autobalancer.stability.states.stations import required

QUANTILES = (0.5, 0.95, 1.0)
MOVING = "balls not at rest"
WORDS = (BALANCED, PARTLY, NOT, WORSE, MOVING)


def residuals(
    question: Question, dims: tuple[str, ...], angles: Floats, states: NDArray[Any], seen: Floats
) -> xr.Dataset:
    """Residual unbalance and deflection of each end, and the distributions over the starts that are possible.

    Where the balls rest, the deflection is the greatest in a turn that they leave once the transient of the rotor is gone;
    else ``seen``, that at the last instant of the run. A verdict compares it with that of evenly spread balls. Of several
    planes the residual is the sum of theirs, and the greatest deflection counts.
    """
    st, speed = question.st, question.speed
    each = moments_of(st, angles)
    wanted = _wanted(st, speed)
    left_at = np.abs(each - wanted)
    left, whole = left_at.sum(axis=-1), float(np.abs(wanted).sum())
    resting = np.isin(states, [STATES.index(name) for name in AT_REST])
    possible = states != STATES.index("overlapping start")
    alone = float(_deflections(st, speed, np.zeros((1, len(st.names)), np.complex128)).max())
    deflection = _deflections(st, speed, each.reshape(-1, len(st.names))).max(axis=-1).reshape(left.shape)
    ends = np.where(resting & np.isfinite(deflection), deflection, seen)
    found = xr.Dataset(
        {"residual_unbalance": (dims, left), "final_deflection": (dims, ends)},
        {"quantile": list(QUANTILES), "verdict": list(WORDS), "plane": list(st.names)},
    )
    found["plane_residual_unbalance"] = ((*dims, "plane"), left_at)
    found["plane_unbalance"] = ("plane", np.abs(wanted))
    for name, values in (("residual_quantile", left), ("deflection_quantile", deflection)):
        there = values[resting]
        found[name] = ("quantile", np.quantile(there, QUANTILES) if there.size else np.full(len(QUANTILES), np.nan))
    at_rest = left_at[resting]
    nothing = np.full((len(QUANTILES), len(st.names)), np.nan)
    quantiles = np.quantile(at_rest, QUANTILES, axis=0) if len(at_rest) else nothing
    found["plane_residual_quantile"] = (("quantile", "plane"), quantiles)
    words = [verdict_word(value / alone) if alone > 0.0 else NO_VERDICT for value in deflection[resting]]
    counts = [words.count(word) for word in WORDS[:-1]]
    counts.append(int((possible & ~resting).sum()))
    found["verdict_share"] = ("verdict", np.array(counts) / max(int(possible.sum()), 1))
    found["unbalance"] = whole
    found["deflection_without_balls"] = alone
    for name, text, unit in (
        ("residual_unbalance", "unbalance of rotor and balls together", "kg m"),
        ("final_deflection", "deflection at the end", "m"),
        ("residual_quantile", "residual unbalance of the starts that end at rest", "kg m"),
        ("deflection_quantile", "deflection of the starts that end at rest", "m"),
        ("verdict_share", "share of the starts", "1"),
        ("unbalance", "unbalance without balls", "kg m"),
        ("deflection_without_balls", "deflection with evenly spread balls", "m"),
        ("plane_residual_unbalance", "what the balls of a plane lack to balance it", "kg m"),
        ("plane_residual_quantile", "residual unbalance of a plane, of the starts that end at rest", "kg m"),
        ("plane_unbalance", "unbalance that the balls of a plane have to balance", "kg m"),
    ):
        found[name].attrs.update(long_name=text, units=unit)
    return found


def moments_of(st: Stations, angles: Floats) -> Complexes:
    """Resultant m eps e^(i phi) of the balls of each plane for angles (..., n), (..., P) kg m."""
    found = np.zeros((*angles.shape[:-1], len(st.names)), np.complex128)
    for ball, place in enumerate(st.station.tolist()):
        found[..., place] += st.moment[ball] * np.exp(1j * angles[..., ball])
    return found


def _wanted(st: Stations, speed: float) -> Complexes:
    """What the balls of each plane have to add up to, (P,) kg m; nan at a critical speed of an undamped rotor."""
    if st.model.pairs == 1:
        return -st.fixed_load
    try:
        return required(st, speed)
    except QuestionError:
        return np.full(len(st.names), np.nan + 0j)


def _deflections(st: Stations, speed: float, moments: Complexes) -> Floats:
    """Greatest deflection of each plane in a turn with the balls at rest, (k, P) m; infinite where it has no bound."""
    flat = st.plain_at(speed)
    loads = st.fixed_load + moments @ flat.rows  # (k, pairs)
    try:
        if st.isotropic:
            return np.abs(speed**2 * loads @ st.compliance(speed).T @ st.rows.T)
        answer = speed**2 * st.whole_compliance(speed)
    except QuestionError:
        unbounded = np.where(np.abs(loads).max(axis=1) > 0.0, np.inf, 0.0)
        return np.asarray(np.repeat(unbounded[:, None], len(st.names), axis=1))
    pairs = st.model.pairs
    both = np.zeros((len(loads), st.model.size), np.complex128)
    both[:, :pairs], both[:, pairs : 2 * pairs] = loads, -1j * loads
    moved = both @ answer.T
    x, y = moved[:, :pairs] @ st.rows.T, moved[:, pairs : 2 * pairs] @ st.rows.T
    return np.asarray(0.5 * (np.abs(x + 1j * y) + np.abs(x - 1j * y)))
