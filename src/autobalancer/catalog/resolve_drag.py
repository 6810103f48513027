"""From the drag law of a race to the numbers of a ball in it."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache

import numpy as np

from autobalancer.errors import QuestionError
from autobalancer.laws.drag import linear_drag
from autobalancer.laws.drag_coefficient import UNNAMED, DragLaw, LinearLaw
from autobalancer.laws.drag_curve import DragCurve
from autobalancer.machine.balancer.drag import BallInRace, Drag
from autobalancer.patience import returned

TRIED = np.geomspace(1e-6, 1e7, 2001)  # Reynolds numbers


def ball_drag(
    part: Drag, radius: float, orbit: float, density: float, viscosity: float
) -> tuple[float, DragCurve | None]:
    """beta (N m s) of the linear law, and the curve over all Reynolds numbers where the law is asked for as a whole.

    ``radius`` of the ball and ``orbit`` radius in m; ``density`` and kinematic ``viscosity`` of the fluid in SI.

    Raises
    ------
    QuestionError
        If the law is no law for this ball: it fails, or its drag is not finite, negative, or falls as a ball becomes faster.
    """
    ball = BallInRace(radius, orbit)
    if not part.needs_fluid:
        return _torque(part, ball), None
    if radius == 0.0:
        return 0.0, None
    law = law_of(part, ball)
    beta = linear_drag(law.cd_re, density, viscosity, radius, orbit)
    return beta, None if isinstance(law, LinearLaw) else DragCurve(law, density, viscosity, 2.0 * radius)


def _torque(part: Drag, ball: BallInRace) -> float:
    try:
        torque = returned(lambda: float(part.torque(ball)), f"the drag law {part.word()!r}")
    except Exception as reason:  # whatever a law of somebody else may raise
        raise QuestionError(_failed(part, reason)) from None
    if not (math.isfinite(torque) and torque >= 0.0):
        raise QuestionError(f"the drag law {part.word()!r} gives a torque of {torque:g} N m s; it must not be negative")
    return torque


@lru_cache(maxsize=256)
def law_of(part: Drag, ball: BallInRace) -> DragLaw:
    """The law of a ball, tried over all Reynolds numbers."""
    try:
        law = returned(lambda: part.curve(ball), f"the drag law {part.word()!r}")
    except QuestionError as reason:
        raise QuestionError(str(reason).replace(repr(UNNAMED), repr(part.word()))) from None
    except Exception as reason:  # whatever a law of somebody else may raise
        raise QuestionError(_failed(part, reason)) from None
    if not isinstance(law, DragLaw):
        raise QuestionError(
            f"the drag law {part.word()!r} gives {law!r}; its 'curve' must return what ab.laws.sampled_drag_law or "
            "ab.laws.linear_drag_law makes"
        )
    if law.name == UNNAMED:
        law = replace(law, name=part.word())
    product = law.product(TRIED)
    wrong = np.flatnonzero(~(np.isfinite(product) & (product > 0.0)))
    if wrong.size:
        re, value = TRIED[wrong[0]], product[wrong[0]]
        raise QuestionError(
            f"the drag law {part.word()!r} gives c_d Re = {value:g} at Re = {re:.4g}; it must be positive"
        )
    falls = np.flatnonzero(np.diff(product * TRIED) <= 0.0)
    if falls.size:
        re = TRIED[falls[0]]
        raise QuestionError(
            f"the drag law {part.word()!r} gives less drag as a ball becomes faster, about Re = {re:.4g}"
        )
    return law


def _failed(part: Drag, reason: Exception) -> str:
    return f"the drag law {part.word()!r} fails: {type(reason).__name__}: {reason}"
