"""The order of the designs that ran: limits, how many are missed and by how much, then the Pareto front."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

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
    return ", ".join(texts + [f"{name.replace('_', ' ')} undecided" for name, one in found_of.items() if one == OPEN])


def misses(spec: Spec, found: Design) -> dict[str, float]:
    """The limits that it misses, each with how far it is beyond it, over the limit."""
    beyond = {name: one for name, one in verdicts(spec, found).items() if one == MISSED}
    return {name: found.numbers["stall" if name == STALL else name] / spec.limits[name] - 1.0 for name in beyond}


def _added_up(beyond: Collection[float]) -> tuple[int, float]:
    """How many have no end, as a settling time of balls that never settle, and the sum of the others."""
    finite = [one for one in beyond if math.isfinite(one)]
    return len(beyond) - len(finite), sum(finite)


def used(spec: Spec, found: Design) -> float:
    """The greatest share of a limit that it uses up; 0 without limits on the runs."""
    shares = [found.numbers[name] / spec.limits[name] for name in MEASURED if name in spec.limits]
    if STALL in spec.limits:
        shares.append(found.numbers["stall"] / spec.limits[STALL])
    return max(shares, default=0.0)


def ordered(spec: Spec, ran: Sequence[Design]) -> list[tuple[Design, int]]:
    """Designs that ran, the best first, each with the number of its front.

    First those that keep all limits, then those of which the runs cannot tell, then those that miss one, two and so on: classes.
    On front 0 of a class nothing is better in both objectives. Those that miss limits are ordered by how far they are beyond
    them, in shares of each added up; all others front by front, and on a front the one whose two objectives have the smallest
    product: a little of one is given for much of the other, in shares of each.
    """
    found: list[tuple[Design, int]] = []
    beyond = {id(one): misses(spec, one) for one in ran}
    classes = {id(one): (-meets(spec, one), len(beyond[id(one)])) for one in ran}
    for level in sorted(set(classes.values())):
        group = [one for one in ran if classes[id(one)] == level]
        values = np.array([[objective(one, name) for name in spec.search.objectives] for one in group])
        front = fronts(values[:, 0], values[:, 1])
        with np.errstate(invalid="ignore"):
            product = np.where(np.isfinite(values).all(axis=1), values.prod(axis=1), math.inf)
        excess = [_added_up(beyond[id(one)].values()) for one in group]
        order = sorted(
            range(len(group)),
            key=lambda i: (excess[i], front[i], product[i], used(spec, group[i]), group[i].candidate.label),
        )
        found += [(group[i], int(front[i])) for i in order]
    return found
