"""A hysteresis loop from recorded deflection and force."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from autobalancer.errors import QuestionError
from autobalancer.units import argument

FEWEST = 20  # samples in a period
FINE = 400  # points of a period between samples


@dataclass(frozen=True)
class HysteresisLoop:
    """What a loop says.

    ``frequency`` (rad/s), ``amplitude`` (m), ``stiffness`` k and ``damping`` b of Spannan (2021), (6.3) and (6.5), N/m and
    N s/m, the ``energy`` W that a period costs (J), and the number of whole ``periods`` used.
    """

    frequency: float
    amplitude: float
    stiffness: float
    damping: float
    energy: float
    periods: int


def hysteresis(time: ArrayLike, deflection: ArrayLike, force: ArrayLike, frequency: float | str) -> HysteresisLoop:
    """Amplitude, stiffness, damping and loss of a loop, from the last whole periods of a record.

    Parameters
    ----------
    time
        Of the samples, s, ascending, (n,).
    deflection, force
        m and N, (n,). Both count with their first harmonic, as the linear k and b do; the energy is the area of the loop.
    frequency
        Of the motion, rad/s.

    Raises
    ------
    QuestionError
        If the record is shorter than a period, or coarser than 20 samples in a period, or has holes.
    """
    w = argument("frequency", frequency, "rad/s")
    t, x, f = (np.asarray(one, dtype=float) for one in (time, deflection, force))
    if t.ndim != 1 or x.shape != t.shape or f.shape != t.shape or not all(np.isfinite(one).all() for one in (t, x, f)):
        raise QuestionError("hysteresis: give as many finite deflections and forces as times, without holes")
    if t.size < 2 or np.any(np.diff(t) <= 0.0) or not w > 0.0:
        raise QuestionError("hysteresis: times must ascend, and the frequency must be above zero")
    period = 2.0 * np.pi / w
    periods = int(np.floor((t[-1] - t[0]) / period * (1.0 + 1e-9)))
    if periods < 1 or np.diff(t).max() > period / FEWEST:
        raise QuestionError(
            f"hysteresis: the record has {(t[-1] - t[0]) / period:.3g} periods and steps up to "
            f"{np.diff(t).max() / period:.3g} of one; give at least one period, sampled at least {FEWEST} times"
        )
    from scipy.interpolate import CubicSpline

    at = t[-1] - period * periods + np.arange(periods * FINE) * period / FINE
    at = np.maximum(at, t[0])
    turned = np.exp(-1j * w * at) * 2.0 / at.size
    x_at, f_at = CubicSpline(t, x)(at), CubicSpline(t, f)(at)
    first_x, first_f = complex((x_at * turned).sum()), complex((f_at * turned).sum())
    if abs(first_x) == 0.0:
        raise QuestionError("hysteresis: the deflection does not move at this frequency")
    energy = float((0.5 * (f_at + np.roll(f_at, -1)) * (np.roll(x_at, -1) - x_at)).sum() / periods)
    amplitude = abs(first_x)
    return HysteresisLoop(w, amplitude, abs(first_f) / amplitude, energy / (np.pi * amplitude**2 * w), energy, periods)
