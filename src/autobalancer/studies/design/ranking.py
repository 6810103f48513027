"""The order of the designs that ran: limits first, then the Pareto front, then how much reserve is left."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from autobalancer.studies.chamber_design.statistics import fronts
from autobalancer.studies.design.judging import MISSED, OPEN, verdicts
from autobalancer.studies.design.screening import Design
from autobalancer.studies.design.spec import MASS, MEASURED, OUTER, STALL, Spec


def objective(found: Design, name: str) -> float:
    """A number of a design that should be small."""
    if name == MASS:
        return found.ball_mass
    return found.candidate.ring.outer if name == OUTER else found.numbers.get(name, math.nan)


def meets(spec: Spec, found: Design) -> int:
    """1: keeps all limits; 0: too few runs to say; -1: misses one."""
    return min(verdicts(spec, found).values(), default=1)


def missed(spec: Spec, found: Design) -> str:
    """The limits that it misses, and those of which too few runs say nothing."""
    found_of = verdicts(spec, found)
    texts = [name.replace("_", " ") for name, one in found_of.items() if one == MISSED]
    return ", ".join(texts + [f"{name.replace('_', ' ')} open" for name, one in found_of.items() if one == OPEN])


def used(spec: Spec, found: Design) -> float:
    """The greatest share of a limit that it uses up; 0 without limits on the runs."""
    shares = [found.numbers[name] / spec.limits[name] for name in MEASURED if name in spec.limits]
    if STALL in spec.limits:
        shares.append(found.numbers["stall"] / spec.limits[STALL])
    return max(shares, default=0.0)


def ordered(spec: Spec, ran: Sequence[Design]) -> list[tuple[Design, int]]:
    """Designs that ran, the best first, each with the number of its front.

    First those that keep all limits, then those of which the runs cannot tell, then the others: three classes. On front 0 of a
    class nothing is better in both objectives. Front by front, and on a front the one whose two objectives have the smallest
    product: a little of one is given for much of the other, in shares of each.
    """
    found: list[tuple[Design, int]] = []
    for level in (1, 0, -1):
        group = [one for one in ran if meets(spec, one) == level]
        if not group:
            continue
        values = np.array([[objective(one, name) for name in spec.search.objectives] for one in group])
        front = fronts(values[:, 0], values[:, 1])
        with np.errstate(invalid="ignore"):
            product = np.where(np.isfinite(values).all(axis=1), values.prod(axis=1), math.inf)
        order = sorted(
            range(len(group)), key=lambda i: (front[i], product[i], used(spec, group[i]), group[i].candidate.label)
        )
        found += [(group[i], int(front[i])) for i in order]
    return found
