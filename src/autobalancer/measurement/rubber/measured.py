"""What was measured of rubber: complex stiffness at frequencies and amplitudes, from loops on a shaker or from resonances."""

from __future__ import annotations

from collections.abc import Sequence
from typing import get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from autobalancer.errors import QuestionError
from autobalancer.laws.rubber import Motion
from autobalancer.results.answers.rubber_points import RubberPoints
from autobalancer.units import texts_argument

Floats = NDArray[np.float64]
STIFFNESS_SURE, LOSS_SURE = 0.02, 0.05  # relative standard uncertainties where none are given


def rubber_loops(
    frequency: ArrayLike,
    amplitude: ArrayLike,
    stiffness: ArrayLike,
    damping: ArrayLike,
    *,
    stiffness_uncertainty: float = STIFFNESS_SURE,
    loss_uncertainty: float = LOSS_SURE,
    motion: Motion | Sequence[Motion] = "line",
) -> RubberPoints:
    """Points from loops of force over deflection, evaluated as in Spannan (2021), (6.2) to (6.5).

    Parameters
    ----------
    frequency
        Of the motion, rad/s, (n,).
    amplitude
        x of the deflection, m, (n,).
    stiffness
        k = F / x, the amplitude of the force over that of the deflection, N/m, (n,): the absolute value of K.
    damping
        b = W / (2 pi^2 f x^2) with the area W of the loop, N s/m, (n,): K'' = w b.
    stiffness_uncertainty, loss_uncertainty
        Relative standard uncertainties.
    motion
        ``line`` on a shaker, or ``circle``; one, or one of each point.

    Raises
    ------
    QuestionError
        If the lists are of different length, or a number is missing, not finite, or impossible.
    """
    w, x, k, b = _columns(
        "rubber_loops",
        frequency=(frequency, "rad/s"),
        amplitude=(amplitude, "m"),
        stiffness=(stiffness, "N/m"),
        damping=(damping, "N*s/m"),
    )
    names = tuple(f"loop {n} ({_where(*at)})" for n, at in enumerate(zip(w, x, strict=True), 1))
    loss = w * b
    wrong = np.flatnonzero(loss >= k)
    if wrong.size:
        i = int(wrong[0])
        raise QuestionError(
            f"{names[i]}: the loss w b = {loss[i]:.4g} N/m is not below the stiffness {k[i]:.4g} N/m; check the units of both"
        )
    return _points(
        w,
        x,
        np.sqrt(k**2 - loss**2),
        loss,
        (stiffness_uncertainty, loss_uncertainty),
        motion,
        "loop",
        names,
    )


def rubber_resonances(
    mass: ArrayLike | str,
    frequency: ArrayLike,
    amplitude: ArrayLike,
    decay_rate: ArrayLike | None = None,
    *,
    stiffness_uncertainty: float = STIFFNESS_SURE,
    loss_uncertainty: float = LOSS_SURE,
    motion: Motion | Sequence[Motion] = "line",
) -> RubberPoints:
    """Points from resonances of a mass on the rubber at several amplitudes.

    K' = M (w^2 + d^2) and K'' = 2 M d w for a free decay of frequency w and decay rate d; without d K' = M w^2.

    Parameters
    ----------
    mass
        All that moves, kg; one, or one of each point.
    frequency
        Of a free decay, or where the response to unbalance is 90 degrees behind, rad/s, (n,).
    amplitude
        Mean deflection in the part of the decay that was evaluated, or at the resonance, m, (n,).
    decay_rate
        1/s, (n,); nan or nothing where it is not known.
    stiffness_uncertainty, loss_uncertainty
        Relative standard uncertainties.
    motion
        ``line`` after a blow, ``circle`` for unbalance; one, or one of each point.

    Raises
    ------
    QuestionError
        As :func:`rubber_loops`.
    """
    size = np.size(np.asarray(frequency, dtype=object))
    moving = np.asarray(texts_argument("mass", mass, "kg"), dtype=float)
    every = np.full(size, moving) if moving.ndim == 0 else moving
    w, x, m = _columns(
        "rubber_resonances", frequency=(frequency, "rad/s"), amplitude=(amplitude, "m"), mass=(every, "kg")
    )
    given = np.full(w.size, np.nan) if decay_rate is None else texts_argument("decay_rate", decay_rate, "1/s")
    decay = np.atleast_1d(np.asarray(given, dtype=float))
    if decay.shape != w.shape or (decay[~np.isnan(decay)] <= 0.0).any():
        raise QuestionError("decay_rate: give one above zero for each frequency, or nan where it is not known")
    names = tuple(f"resonance {n} ({_where(*at)})" for n, at in enumerate(zip(w, x, strict=True), 1))
    known = np.nan_to_num(decay)
    return _points(
        w,
        x,
        m * (w**2 + known**2),
        2.0 * m * decay * w,
        (stiffness_uncertainty, loss_uncertainty),
        motion,
        "resonance",
        names,
    )


def _points(
    w: Floats, x: Floats, k: Floats, loss: Floats, sure: tuple[float, float], motion: Motion | Sequence[Motion], kind: str,
    names: tuple[str, ...],
) -> RubberPoints:  # fmt: skip
    motions: tuple[Motion, ...] = (motion,) * w.size if isinstance(motion, str) else tuple(motion)
    wrong = [one for one in motions if one not in get_args(Motion)]
    if wrong or len(motions) != w.size:
        raise QuestionError(
            f"motion: given {wrong[0] if wrong else motions!r}; give line or circle, one or one of each point"
        )
    for name, share in zip(("stiffness_uncertainty", "loss_uncertainty"), sure, strict=True):
        if not 0.0 < share < 1.0:
            raise QuestionError(f"{name}: given {share:g}; must be a share between 0 and 1, such as {STIFFNESS_SURE}")
    return RubberPoints(w, x, k, loss, sure[0] * k, sure[1] * loss, motions, (kind,) * w.size, names)


def _columns(owner: str, **given: tuple[ArrayLike, str]) -> list[Floats]:
    found: list[Floats] = []
    for name, (values, unit) in given.items():
        array = np.atleast_1d(np.asarray(texts_argument(name, values, unit), dtype=float))
        if array.ndim != 1 or (found and array.size != found[0].size):
            first = next(iter(given))
            raise QuestionError(
                f"{owner}: {name}: given {array.size} values for {found[0].size if found else 0} of {first!r}; "
                "give one for each"
            )
        bad = np.flatnonzero(~(np.isfinite(array) & (array > 0.0)))
        if bad.size:
            raise QuestionError(
                f"{owner}: {name}: value {bad[0] + 1} is {array[bad[0]]:g}; each must be a number above zero. The table has a "
                "hole there: measure this point, or leave its row out"
            )
        found.append(array)
    return found


def _where(frequency: float, amplitude: float) -> str:
    return f"{frequency / (2.0 * np.pi):.4g} Hz, {1e3 * amplitude:.4g} mm"
