"""Drag on a ball in a fluid whose viscosity depends on the rate of shear.

With a power of the rate of shear a ball far from walls feels F = 3 pi d K U (U/d)^(n-1) X(n), which is Stokes' law with the
viscosity at the rate k U/d, k = X^(1/(n-1)). In a slow flow the drag of any geometry is that of a fluid of constant viscosity
times an effective share of it; for weak thinning the share is the mean of s over the rates of shear of the flow of constant
viscosity, each counted with its dissipation, because to first order a change of the flow does not change the dissipation. One
rate k U/d stands for this mean here; k depends on geometry and law, and finite elements find it (`sheared_drag`). With inertia of
the fluid the Reynolds number is formed with the viscosity at this rate, which is an assumption.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from autobalancer.errors import QuestionError, RangeWarning, warn
from autobalancer.laws.drag_coefficient import Floats
from autobalancer.laws.drag_curve import DragCurve, stokes_record

RATES = np.geomspace(1e-9, 1e9, 1801)  # 1/s, at which a law is tried
LINEAR = 1e-5  # change of the share below which the fluid counts as at rest
SLOWEST, FASTEST = 1e-9, 1e3  # m/s, of a ball in a table
PER_DECADE = 60


class Shares(Protocol):
    """What is needed of a shear law."""

    def share(self, rate: Any) -> Any:
        """Viscosity over that at rest."""

    @property
    def highest(self) -> float:
        """Rate of shear up to which it is known, 1/s."""


@dataclass(frozen=True)
class Sheared:
    """A shear law at a temperature: its rates are ``shift`` times those of the fluid."""

    law: Shares
    shift: float = 1.0

    def share(self, rate: ArrayLike) -> Floats:
        """Viscosity over that at rest; ``rate`` of shear in 1/s, of any shape and either sign."""
        return np.asarray(self.law.share(self.shift * np.abs(np.asarray(rate, float))), float)

    @property
    def highest(self) -> float:
        """Rate of shear up to which it is known, 1/s."""
        return self.law.highest / self.shift


def tried(law: Shares, word: str) -> None:
    """Refuse what is no viscosity.

    Raises
    ------
    QuestionError
        If the law fails, is not positive, not 1 at rest, or if the stress falls while the rate of shear grows.
    """
    try:
        share = np.asarray(law.share(RATES), float) * np.ones(RATES.shape)
        rest = float(law.share(np.zeros(1))[0])
    except Exception as reason:  # whatever a law of somebody else may raise
        raise QuestionError(f"the shear law {word!r} fails: {type(reason).__name__}: {reason}") from None
    wrong = np.flatnonzero(~(np.isfinite(share) & (share > 0.0)))
    if wrong.size:
        raise QuestionError(
            f"the shear law {word!r} gives a share of {share[wrong[0]]:g} at {RATES[wrong[0]]:.4g} 1/s; must be positive"
        )
    if not abs(rest - 1.0) < 1e-6:
        raise QuestionError(f"the shear law {word!r} gives a share of {rest:g} at rest; must be 1")
    falls = np.flatnonzero(np.diff(share * RATES) <= 0.0)
    if falls.size:
        raise QuestionError(
            f"the shear law {word!r}: the stress falls while the rate of shear grows, from {RATES[falls[0]]:.4g} 1/s on; one "
            "stress would belong to several rates"
        )


@dataclass(frozen=True)
class ShearedDragCurve(DragCurve):
    """A drag law in a sheared fluid; ``viscosity`` is that at rest, ``at_ball`` the k of the effective rate k U/d."""

    sheared: Sheared
    at_ball: float

    def rate(self, velocity: ArrayLike) -> Floats:
        """Effective rate of shear, 1/s; ``velocity`` in m/s."""
        return np.asarray(self.at_ball * np.abs(np.asarray(velocity, float)) / self.diameter)

    def share(self, velocity: ArrayLike) -> Floats:
        """Viscosity over that at rest."""
        return self.sheared.share(self.rate(velocity))

    def reynolds(self, velocity: ArrayLike) -> Floats:
        """Reynolds number with the viscosity at the effective rate of shear."""
        return np.asarray(super().reynolds(velocity) / self.share(velocity))

    def force(self, velocity: ArrayLike) -> Floats:
        """Drag, N, along a velocity of the fluid relative to the ball, m/s; odd, of the shape of ``velocity``."""
        return np.asarray(self.share(velocity) * super().force(velocity))

    def points(
        self, first: float | None = None, last: float | None = None, per_decade: int = PER_DECADE
    ) -> tuple[Floats, Floats, Floats]:
        """As :meth:`DragCurve.points`, from where the fluid counts as at rest; ``first`` and ``last`` in m/s."""
        from scipy.interpolate import PchipInterpolator

        low, high = self._ends()
        low, high = first or low, last or high
        steps = max(math.ceil(per_decade * math.log10(high / low)), 1)
        log_velocity = np.linspace(math.log(low), math.log(high), steps + 1)
        log_force = np.log(self.force(np.exp(log_velocity)))
        slopes = PchipInterpolator(log_velocity, log_force).derivative()(log_velocity)
        return log_velocity, log_force, slopes * (log_velocity[-1] - log_velocity[0]) / steps

    def _ends(self) -> tuple[float, float]:
        """Velocities at which the drag stops being linear, and from which on its coefficient is kept, m/s."""
        tries = np.geomspace(SLOWEST, FASTEST, 2401)
        reynolds = self.reynolds(tries)
        changed = (np.abs(self.share(tries) - 1.0) > LINEAR) | (reynolds > self.law.stokes_end)
        kept = reynolds >= self.law.kept_from
        low = tries[max(int(np.argmax(changed)) - 1, 0)] if changed.any() else 0.1 * FASTEST
        return float(low), float(tries[np.argmax(kept)] if kept.any() else FASTEST)

    def range_record(self, velocity: float) -> dict[str, Any]:
        """As :meth:`DragCurve.range_record`, with the greatest effective rate of shear."""
        found = super().range_record(velocity) if math.isfinite(self.law.stokes_end) else self._linear(velocity)
        rate = float(self.rate(velocity))
        if rate > self.sheared.highest:
            text = (
                f"the rate of shear at a ball reaches {rate:.3g} 1/s, but the viscosity is known up to "
                f"{self.sheared.highest:.3g} 1/s and kept beyond"
            )
            warn(text, RangeWarning)
            found["drag_warning"] = "; ".join(filter(None, (found["drag_warning"], text)))
        return found | {"drag_shear_rate": rate}

    def _linear(self, velocity: float) -> dict[str, Any]:
        named = {"drag_law": self.law.name, "drag_source": self.law.source}
        return named | stokes_record(float(self.reynolds(velocity)))
