"""Drag coefficient of a ball against its Reynolds number: c_d(Re), continuous over the whole range.

F = 1/2 rho A c_d u |u| with A the cross section of the ball, u its velocity relative to the fluid and Re = |u| d_b / nu
(Spannan 2021, 5.17 and, with the absolute value that is missing there, 5.20). Every law has three ranges: up to
``stokes_end`` c_d Re is a constant and the drag exactly linear, from ``kept_from`` on c_d is a constant, and in between the
law has its shape. ``highest`` is the Reynolds number up to which the law is meant to hold; beyond it c_d keeps its value,
although the drag of a sphere falls to a quarter where its boundary layer turns turbulent.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from autobalancer.arrays import Floats
from autobalancer.errors import QuestionError, RangeWarning, warn
from autobalancer.units import argument, field_arguments, texts_argument

UNNAMED = "own law"
CRISIS = 2e5
"""Reynolds number from which on the boundary layer of a sphere may turn turbulent (end of Cheng 2009)."""
PER_DECADE = 50
"""Points for each factor of ten of a law that is computed from a function."""
PLANE_PLATEAU = 0.74
"""c_d of a sphere on a plane at high Reynolds numbers (Spannan 2021, 5.21)."""


@dataclass(frozen=True)
class DragLaw:
    """What all laws have in common; the laws there are stand in ``autobalancer/drag``.

    ``cd_times_re`` is c_d Re in the Stokes range, ``source`` where the law comes from and what was changed.
    """

    name: str
    source: str
    cd_times_re: float
    stokes_end: float
    kept_from: float
    highest: float

    def product(self, reynolds: ArrayLike) -> Floats:
        """c_d Re, finite at rest too; ``reynolds`` of any shape and either sign."""
        re = np.abs(np.asarray(reynolds, dtype=float))
        between = np.clip(re, self.stokes_end, self.kept_from)
        inside = np.exp(self._log_product(np.log(between))) * (re / between)
        return np.where(re <= self.stokes_end, self.cd_times_re, inside)

    def coefficient(self, reynolds: ArrayLike) -> Floats:
        """c_d; infinite at rest. Warns once with a ``RangeWarning`` if a Reynolds number is above ``highest``."""
        re = np.abs(np.asarray(reynolds, dtype=float))
        if text := self.outside(float(re.max(initial=0.0))):
            warn(text, RangeWarning)
        with np.errstate(divide="ignore"):
            return np.asarray(self.product(re) / re)

    def log_slope(self, reynolds: ArrayLike) -> Floats:
        """d ln c_d / d ln Re between both ends of the shape, where it is one-sided; -1 below and 0 above."""
        re = np.abs(np.asarray(reynolds, dtype=float))
        slope = self._product_slope(np.log(np.clip(re, self.stokes_end, self.kept_from))) - 1.0
        return np.where(re < self.stokes_end, -1.0, np.where(re > self.kept_from, 0.0, slope))

    def outside(self, reynolds: float) -> str:
        """A sentence if this Reynolds number is above the range of the law, else an empty text."""
        if abs(reynolds) <= self.highest:
            return ""
        return (
            f"the Reynolds number reaches {abs(reynolds):.3g}, but the drag law {self.name!r} holds up to {self.highest:.3g}; "
            "its drag coefficient is kept at the value there"
        )

    def _log_product(self, log_re: Floats) -> Floats:
        raise NotImplementedError

    def _product_slope(self, log_re: Floats) -> Floats:
        raise NotImplementedError


@dataclass(frozen=True)
class CubicLaw(DragLaw):
    """log10 c_d a cubic of log10 Re between both ends, ``coefficients`` from the constant one on."""

    coefficients: tuple[float, float, float, float]

    def _log_product(self, log_re: Floats) -> Floats:
        c, x = self.coefficients, log_re / np.log(10.0)
        return np.asarray(log_re + np.log(10.0) * (c[0] + x * (c[1] + x * (c[2] + x * c[3]))))

    def _product_slope(self, log_re: Floats) -> Floats:
        c, x = self.coefficients, log_re / np.log(10.0)
        return np.asarray(1.0 + c[1] + x * (2.0 * c[2] + x * 3.0 * c[3]))


@dataclass(frozen=True)
class LinearLaw(DragLaw):
    """c_d Re a constant at any Reynolds number."""

    def _log_product(self, log_re: Floats) -> Floats:
        return np.full(np.shape(log_re), np.log(self.cd_times_re))

    def _product_slope(self, log_re: Floats) -> Floats:
        return np.zeros(np.shape(log_re))


@dataclass(frozen=True)
class TableLaw(DragLaw):
    """Points (Re, c_d), with a monotone cubic (Fritsch and Carlson 1980) of log(c_d Re) over log Re in between."""

    reynolds: tuple[float, ...]
    coefficients: tuple[float, ...]

    def _log_product(self, log_re: Floats) -> Floats:
        return np.asarray(self._curve()(log_re), dtype=float)

    def _product_slope(self, log_re: Floats) -> Floats:
        return np.asarray(self._curve()(log_re, 1), dtype=float)

    def _curve(self) -> Any:
        from scipy.interpolate import PchipInterpolator

        return PchipInterpolator(np.log(self.reynolds), np.log(self.reynolds) + np.log(self.coefficients))


@dataclass(frozen=True)
class SampledLaw(TableLaw):
    """Points that were computed, so near to each other that the curve between them is the law."""


def linear_drag_law(cd_times_re: float, source: str = "given c_d Re") -> LinearLaw:
    """A constant c_d Re: drag linear in the velocity at any Reynolds number.

    Parameters
    ----------
    cd_times_re
        Drag coefficient times Reynolds number.
    source
        Of the number, kept with the law.

    Returns
    -------
    DragLaw
        Ready for the ``curve`` of a drag law of your own.

    Raises
    ------
    QuestionError
        If it is not positive.
    """
    if not (math.isfinite(cd_times_re) and cd_times_re > 0.0):
        raise QuestionError(f"drag law: given c_d Re = {cd_times_re:g}; must be positive")
    return LinearLaw("linear", source, cd_times_re, np.inf, np.inf, np.inf)


def joined(cd_times_re: float, plateau: float, name: str = "cd_times_re", source: str = "") -> CubicLaw:
    """c_d Re up to Re = 10, a ``plateau`` from 20 000 on, between them the cubic that joins both in value and slope.

    It is the shape of (5.21) and the way in which Spannan (2021) found (6.9).

    Raises
    ------
    QuestionError
        If drag and drag coefficient would not both change monotonically in between.
    """
    x, y = np.log10([10.0, 2e4]), np.log10([cd_times_re / 10.0, plateau])
    mean = (y[1] - y[0]) / (x[1] - x[0])
    if not -2.0 / 3.0 <= mean <= -1.0 / 3.0:
        low, high = (cd_times_re / 10.0 * 10.0 ** (share * (x[1] - x[0])) for share in (-2.0 / 3.0, -1.0 / 3.0))
        raise QuestionError(
            f"given a plateau of {plateau:.4g} for c_d Re = {cd_times_re:.4g}; the law joins them smoothly for plateaus from "
            f"{low:.3g} to {high:.3g}; give one of these, or describe the law by a table"
        )
    rows = [[1.0, e, e**2, e**3] for e in x] + [[0.0, 1.0, 2.0 * e, 3.0 * e**2] for e in x]
    coefficients = np.linalg.solve(np.array(rows), np.array([*y, -1.0, 0.0]))
    source = source or "given c_d Re and plateau, joined like Spannan (2021), (6.9)"
    return CubicLaw(name, source, cd_times_re, 10.0, 2e4, CRISIS, tuple(coefficients.tolist()))


def table(reynolds: ArrayLike, coefficients: ArrayLike, source: str = "given") -> TableLaw:
    """Measured points: linear drag below the first one, c_d kept beyond the last one.

    Raises
    ------
    QuestionError
        If there are fewer than two points, Re does not increase, c_d is not positive, or c_d Re falls anywhere: below the
        drag crisis drag grows at least as the velocity does, and only then a torque belongs to one speed.
    """
    re, cd = np.atleast_1d(np.asarray(reynolds, dtype=float)), np.atleast_1d(np.asarray(coefficients, dtype=float))
    if re.shape != cd.shape or re.ndim != 1 or re.size < 2:
        raise QuestionError(
            f"drag table: given {re.size} Reynolds numbers and {cd.size} drag coefficients; give two or more pairs"
        )
    if not (re[0] > 0.0 and (np.diff(re) > 0.0).all() and (cd > 0.0).all() and np.isfinite(re * cd).all()):
        raise QuestionError("drag table: Reynolds numbers must increase, and they and drag coefficients be positive")
    _refuse_falling("drag table", re, re * cd, "leave out or correct one of these points")
    first, last = float(re[0]), float(re[-1])
    points = tuple(re.tolist()), tuple(cd.tolist())
    return TableLaw("table", source, float(re[0] * cd[0]), first, last, last, *points)


def sampled_drag_law(
    coefficient: Callable[[float], float],
    *,
    name: str = UNNAMED,
    source: str = "own law",
    linear_to: float = 1e-3,
    holds_to: float = CRISIS,
) -> SampledLaw:
    """A drag law of your own from its drag coefficient as a function of the Reynolds number.

    Parameters
    ----------
    coefficient
        c_d of one Reynolds number. It is called at 50 Reynolds numbers for each factor of ten, not in the run.
    name, source
        Of the law, kept with every result; without a name it gets the word of the class whose ``curve`` it is.
    linear_to
        Reynolds number below which c_d Re keeps the value it has there, so that the drag is linear.
    holds_to
        Reynolds number beyond which c_d keeps the value it has there, and a result warns.

    Returns
    -------
    DragLaw
        Ready for ``DragCurve``, for pictures, and for the ``curve`` of a drag law of your own.

    Raises
    ------
    QuestionError
        If the function fails, gives what is no positive number, or if c_d Re falls anywhere; the message says where.
    """
    if not 0.0 < linear_to < holds_to < math.inf:
        raise QuestionError(
            f"drag law {name!r}: given a range from {linear_to:g} to {holds_to:g}; must increase from above 0"
        )
    re = np.geomspace(linear_to, holds_to, math.ceil(PER_DECADE * math.log10(holds_to / linear_to)) + 1)
    cd = np.array([_checked_value(coefficient, one, name) for one in re.tolist()])
    _refuse_falling(f"drag law {name!r}", re, re * cd, "correct the law, or limit it by linear_to and holds_to")
    points = tuple(re.tolist()), tuple(cd.tolist())
    return SampledLaw(name, source, float(re[0] * cd[0]), linear_to, holds_to, holds_to, *points)


def _checked_value(coefficient: Callable[[float], float], reynolds: float, name: str) -> float:
    try:
        value = float(coefficient(reynolds))
    except Exception as reason:  # whatever a law of somebody else may raise
        raise QuestionError(
            f"drag law {name!r}: fails at Re = {reynolds:.4g}: {type(reason).__name__}: {reason}"
        ) from None
    if not (math.isfinite(value) and value > 0.0):
        raise QuestionError(f"drag law {name!r}: gives c_d = {value:g} at Re = {reynolds:.4g}; must be positive")
    return value


def _refuse_falling(what: str, re: Floats, product: Floats, cure: str) -> None:
    """Below the drag crisis drag grows at least as the velocity does, and only then a torque belongs to one speed."""
    falls = np.flatnonzero(np.diff(product) < -1e-9 * product[0])
    if falls.size:
        i = int(falls[0])
        raise QuestionError(
            f"{what}: c_d Re falls from {product[i]:.4g} at Re = {re[i]:.4g} to {product[i + 1]:.4g} at {re[i + 1]:.4g}; "
            f"it must not fall; {cure}"
        )


# Drag force on a ball of a size in a fluid, against its velocity.


STOKES = 10.0  # Reynolds number up to which drag is linear near a wall (Jan and Chen 1997; Spannan 2021, 5.21)


def stokes_record(reynolds: float) -> dict[str, Any]:
    """What to keep with a result whose drag is the linear range of a law at any speed, and whose balls reached ``reynolds``.

    A sentence in ``drag_warning`` where that is beyond the range, which is then also given as a ``RangeWarning``.
    """
    text = ""
    if reynolds > STOKES:
        text = (
            f"the Reynolds number of a ball reaches {reynolds:.3g}, but drag is linear up to about {STOKES:g} and "
            "greater beyond; set range = 'whole' in the drag of the race (the law cd_times_re then needs its plateau, too)"
        )
        warn(text, RangeWarning)
    return {"drag_reynolds": reynolds, "drag_reynolds_limit": STOKES, "drag_warning": text}


@dataclass(frozen=True)
class DragCurve:
    """A law for a ball of ``diameter`` (m) in a fluid of ``density`` (kg/m^3) and kinematic ``viscosity`` (m^2/s)."""

    law: DragLaw
    density: float
    viscosity: float
    diameter: float

    def __post_init__(self) -> None:
        field_arguments(self, density="kg/m^3", viscosity="m^2/s", diameter="m")

    @property
    def viscous(self) -> float:
        """Force over velocity in the Stokes range, N s/m; beta over the square of the orbit radius."""
        return math.pi / 8.0 * self.density * self.viscosity * self.diameter * self.law.cd_times_re

    def reynolds(self, velocity: ArrayLike) -> Floats:
        """Reynolds number, speed times diameter over nu; ``velocity`` in m/s, relative to the fluid."""
        return np.asarray(np.abs(np.asarray(velocity, dtype=float)) * self.diameter / self.viscosity)

    def force(self, velocity: ArrayLike) -> Floats:
        """Drag, N, along a velocity of the fluid relative to the ball, m/s; odd, of the shape of ``velocity``."""
        share = self.law.product(self.reynolds(velocity)) / self.law.cd_times_re
        return np.asarray(self.viscous * share * np.asarray(velocity, dtype=float))

    def torque(self, slip: ArrayLike, orbit_radius: float) -> Floats:
        """Drag torque, N m, on a ball that circles slower than the fluid by ``slip`` (rad/s)."""
        return orbit_radius * self.force(orbit_radius * np.asarray(slip, dtype=float))

    def points(
        self, first: float | None = None, last: float | None = None, per_decade: int = 50
    ) -> tuple[Floats, Floats, Floats]:
        """The curve on a uniform grid in the logarithm of velocity, for cubic interpolation.

        Parameters
        ----------
        first, last
            Reynolds numbers between which; by default the ends of the shape of the law. Below it is linear, above it c_d
            is kept, so these need no points, and what bends at an end is followed exactly.
        per_decade
            Least number of points for each factor of ten.

        Returns
        -------
        tuple
            Log of velocities (m/s), log of forces (N), and slopes d log F per step of the grid, each of shape (count,).
        """
        low, high = first or self.law.stokes_end, last or self.law.kept_from
        steps = max(math.ceil(per_decade * math.log10(high / low) - 1e-9), 1)
        log_re = np.linspace(math.log(low), math.log(high), steps + 1)
        re = np.exp(log_re)
        re[0], re[-1] = low, high
        log_velocity = log_re + math.log(self.viscosity / self.diameter)
        log_force = np.log(self.viscous * self.law.product(re) / self.law.cd_times_re) + log_velocity
        return log_velocity, log_force, (2.0 + self.law.log_slope(re)) * (log_re[-1] - log_re[0]) / steps

    def range_record(self, velocity: float) -> dict[str, Any]:
        """Attributes to store with a result in which the greatest relative velocity was ``velocity`` (m/s).

        Names of law and source, the greatest Reynolds number, that up to which the law holds, and a sentence in
        ``drag_warning`` if it was exceeded, which is then also given as a ``RangeWarning``.
        """
        reynolds = float(self.reynolds(velocity))
        text = self.law.outside(reynolds)
        if text:
            warn(text, RangeWarning)
        return {
            "drag_law": self.law.name,
            "drag_source": self.law.source,
            "drag_reynolds": reynolds,
            "drag_reynolds_limit": self.law.highest,
            "drag_warning": text,
        }


# Drag of a ball in its race in the Stokes range.


def annulus_cd_times_re(width_ratio: float, radius_ratio: float) -> float:
    """c_d Re of a ball in the annulus of a balancer (Spannan 2021, 5.22), for Re <= 10.

    ``width_ratio`` is W_1 / r_b, ``radius_ratio`` is r_b / eps.
    """
    return float(248.0 * width_ratio ** (-11.0 / 8.0) + 245.0 + 813.0 * (radius_ratio - 0.08))


def linear_drag(cd_times_re: float, density: float, viscosity: float, ball_radius: float, orbit_radius: float) -> float:
    """beta = (c_d Re) (pi/4) rho nu r_b eps^2 in N m s (Spannan 2021, 5.26); SI in.

    It is F eps over phi' with F = 1/2 rho (pi r_b^2) c_d u^2, u = eps phi', Re = u (2 r_b) / nu.
    """
    return cd_times_re * math.pi / 4.0 * density * viscosity * ball_radius * orbit_radius**2


# Slipstream: a ball behind another one feels less drag (Spannan 2021, section 5.2.4).
#
# The polynomial is a fit to free spheres in line, for Re from 0 to 300 and center distances from 1 to 20 diameters. It
# runs away outside: at 25 diameters it is 1.32, at 30 it is 3.3. So arguments are clamped to the range and the factor
# is never above 1; over the last diameter what is left of the shielding, 0.8 % at most, fades, so that the factor is 1
# from 20 diameters on without a jump. The walls of a race are not in it.


REYNOLDS = (0.0, 300.0)
DISTANCE = (1.0, 20.0)

# rows powers of Re, columns powers of l/d
FIT = 1e-6 * np.array(
    [
        [452100.0, 164000.0, -29690.0, 2731.0, -116.9, 1.876],
        [-2937.0, 321.9, -55.15, 4.918, -0.1302, 0.0],
        [4.95, 0.8646, -0.1306, 0.003754, 0.0, 0.0],
    ]
)


def slipstream_factor(reynolds: ArrayLike, distance: ArrayLike) -> Floats:
    """Drag of the ball behind over that of a single ball.

    Parameters
    ----------
    reynolds
        Reynolds number of the ball; clamped to 0 ... 300.
    distance
        Between the centers, in diameters: 1 is contact; smaller values are read as 1, beyond 20 the factor is 1.
        The source does not say whether it means centers or gaps; its fit begins at 1, so centers are assumed.

    Returns
    -------
    ndarray
        Between 0.27 and 1, of the common shape of both.
    """
    re = np.clip(np.abs(np.asarray(reynolds, dtype=float)), *REYNOLDS)
    apart = np.asarray(distance, dtype=float)
    powers = np.stack([np.ones_like(re), re, re**2], axis=-1) @ FIT
    ratio = np.clip(apart, *DISTANCE)[..., None] ** np.arange(FIT.shape[1])
    fade = np.clip(DISTANCE[1] - apart, 0.0, 1.0)
    return np.asarray(1.0 - fade * np.maximum(1.0 - (powers * ratio).sum(axis=-1), 0.0))


def slipstream_factors(
    angles: ArrayLike,
    velocities: ArrayLike,
    orbit_radius: float | str,
    diameter: float | str,
    viscosity: float | str,
) -> Floats:
    """Slipstream factor of every ball of a race: the next ball ahead shields it, in the direction in which it moves.

    The distance is that of the centers along the orbit, as the fluid goes round with the race. Balls that pass through each
    other hand over what they do to each other within half a diameter, so that the factor is continuous in the angles. It jumps
    where a velocity changes its sign, but there is no drag then.

    Parameters
    ----------
    angles, velocities
        Ball angles (rad) and velocities relative to the fluid (m/s, positive towards greater angles), shape (n,).
    orbit_radius, diameter, viscosity
        m, m, m^2/s.

    Raises
    ------
    QuestionError
        If there are not as many velocities as angles.
    """
    angles = texts_argument("angles", angles, "rad")
    velocities = texts_argument("velocities", velocities, "m/s")
    orbit_radius = argument("orbit_radius", orbit_radius, "m")
    diameter = argument("diameter", diameter, "m")
    viscosity = argument("viscosity", viscosity, "m^2/s")
    phi, u = np.asarray(angles, dtype=float), np.asarray(velocities, dtype=float)
    if phi.shape != u.shape or phi.ndim != 1:
        raise QuestionError(
            f"slipstream: given {phi.size} angles and {u.size} velocities; give one of each for each ball"
        )
    if phi.size < 2:
        return np.ones_like(phi)
    ahead = np.sign(u)[:, None] * (phi[None, :] - phi[:, None]) % (2.0 * math.pi) * orbit_radius / diameter
    around = 2.0 * math.pi * orbit_radius / diameter
    np.fill_diagonal(ahead, around)
    reynolds = u * diameter / viscosity
    passing = 2.0 * np.where(ahead < 0.5, ahead, 0.0).max(axis=1)
    share = passing**2 * (3.0 - 2.0 * passing)
    factor = slipstream_factor(reynolds, np.where(ahead < 0.5, around, ahead).min(axis=1))
    factor += share * (slipstream_factor(reynolds, 1.0) - factor)
    return np.where(u == 0.0, 1.0, factor)


def range_record(reynolds: float) -> dict[str, Any]:
    """What to keep with a result in which the greatest Reynolds number of a ball was ``reynolds``.

    That number, the last of the fit, and a sentence in ``slipstream_warning`` if it was exceeded, which is then also given as a
    ``RangeWarning``.
    """
    text = ""
    if reynolds > REYNOLDS[1]:
        text = (
            f"slipstream: the Reynolds number reached {reynolds:.3g}; the factor is a fit up to {REYNOLDS[1]:g} "
            "(Spannan 2021, section 5.2.4), beyond this range its value at the limit is used"
        )
        warn(text, RangeWarning)
    return {"slipstream_reynolds": reynolds, "slipstream_reynolds_limit": REYNOLDS[1], "slipstream_warning": text}


# Drag on a ball in a fluid whose viscosity depends on the rate of shear.
#
# With a power of the rate of shear a ball far from walls feels F = 3 pi d K U (U/d)^(n-1) X(n), which is Stokes' law
# with the viscosity at the rate k U/d, k = X^(1/(n-1)). In a slow flow the drag of any geometry is that of a fluid of
# constant viscosity times an effective share of it; for weak thinning the share is the mean of s over the rates of
# shear of the flow of constant viscosity, each counted with its dissipation, because to first order a change of the
# flow does not change the dissipation. One rate k U/d stands for this mean here; k depends on geometry and law, and
# finite elements find it (the example plot_sheared_drag). With inertia of the fluid the Reynolds number is formed with
# the viscosity at this rate, which is an assumption.


RATES = np.geomspace(1e-9, 1e9, 1801)  # 1/s, at which a law is tried
LINEAR = 1e-5  # change of the share below which the fluid counts as at rest
SLOWEST, FASTEST = 1e-9, 1e3  # m/s, of a ball in a table
SHEARED_DRAG_PER_DECADE = 60


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
        self, first: float | None = None, last: float | None = None, per_decade: int = SHEARED_DRAG_PER_DECADE
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
        record = super().range_record(velocity) if math.isfinite(self.law.stokes_end) else self._linear(velocity)
        rate = float(self.rate(velocity))
        if rate > self.sheared.highest:
            text = (
                f"the rate of shear at a ball reaches {rate:.3g} 1/s, but the viscosity is known up to "
                f"{self.sheared.highest:.3g} 1/s and kept beyond"
            )
            warn(text, RangeWarning)
            record["drag_warning"] = "; ".join(filter(None, (record["drag_warning"], text)))
        return record | {"drag_shear_rate": rate}

    def _linear(self, velocity: float) -> dict[str, Any]:
        named = {"drag_law": self.law.name, "drag_source": self.law.source}
        return named | stokes_record(float(self.reynolds(velocity)))
