"""The speed of the walls over time."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import xarray as xr
from scipy.interpolate import CubicHermiteSpline, PchipInterpolator
from scipy.special import j0, j1, y0, y1

from autobalancer.arrays import Floats, Matrix
from autobalancer.assembly.drive_train import Piece, SpeedProfile, profile_pieces
from autobalancer.assembly.guided_balls import uniform_table
from autobalancer.errors import QuestionError
from autobalancer.flow.annulus import Annulus
from autobalancer.kernels.annulus_flow import RECORD
from autobalancer.kernels.records import HILL
from autobalancer.machine import Constant
from autobalancer.roots import root
from autobalancer.units import texts_argument


@dataclass(frozen=True)
class Recorded:
    """A speed known at instants, as one piece; ``numbers`` as ``kernels/annulus_flow.py`` has them."""

    start: float
    kind: int
    numbers: Floats

    @cached_property
    def times(self) -> Floats:
        """Equally spaced, s."""
        return np.asarray(self.start + self.numbers[0] * np.arange(int(self.numbers[1])), np.float64)

    @cached_property
    def curve(self) -> CubicHermiteSpline:
        """The speed between the first and the last instant."""
        return CubicHermiteSpline(self.times, self.numbers[2::2], self.numbers[3::2] / self.numbers[0])

    def at(self, time: float) -> tuple[float, float]:
        """Speed and rate; constant outside."""
        inside = min(max(time, self.start), float(self.times[-1]))
        return float(self.curve(inside)), float(self.curve(inside, 1)) if inside == time else 0.0


@dataclass(frozen=True)
class WallSpeed:
    """Speed over time from the pieces of a profile; what happened before time zero is ``before``, rad/s."""

    pieces: tuple[Piece | Recorded, ...]
    before: float

    def piece(self, time: float) -> Piece | Recorded:
        """The piece in force just after ``time``."""
        starts = [piece.start for piece in self.pieces]
        return self.pieces[max(bisect_right(starts, time) - 1, 0)]

    def at(self, time: float, piece: Piece | Recorded | None = None) -> tuple[float, float]:
        """Speed (rad/s) and its rate (rad/s^2); ``piece`` tells sides apart at a corner."""
        piece = piece or self.piece(time)
        if isinstance(piece, Recorded):
            return piece.at(time)
        c0, c1, c2, c3 = piece.numbers
        if piece.kind == HILL:
            if time <= 0.0:
                return c3, 0.0
            ratio = (time / c1) ** c2
            rise = ratio / (1.0 + ratio)
            return c3 + (c0 - c3) * rise, (c0 - c3) * rise * c2 / (time * (1.0 + ratio))
        return c0 + c1 * (time - piece.start), c1

    def over(self, times: Floats) -> Floats:
        """Speeds at ``times``, rad/s."""
        return np.array([self.at(float(t))[0] for t in times])

    def corners(self, end: float) -> list[float]:
        """Times inside (0, end) at which the rate may jump."""
        return [piece.start for piece in self.pieces if 0.0 < piece.start < end]

    @property
    def settled(self) -> float:
        """Time from which the speed no longer changes, s; infinite if it always does."""
        last = self.pieces[-1]
        return last.start if last.kind not in (HILL, RECORD) and last.numbers[1] == 0.0 else math.inf

    def fastest(self, end: float) -> float:
        """Greatest magnitude of the speed up to ``end``, rad/s; every piece of a profile is monotonic."""
        times = np.array([0.0, *self.corners(end), end])
        if isinstance(self.pieces[0], Recorded):
            times = self.pieces[0].times
            times = np.append(times[(times > 0.0) & (times < end)], [0.0, end])
        return float(max(np.abs(self.over(times)).max(), abs(self.before)))


def recorded_speed(times: Floats | Sequence[str] | str, speeds: Floats | Sequence[str] | str) -> WallSpeed:
    """A speed that was measured or simulated, for :func:`autobalancer.flow.annulus_problem.annulus_flow`.

    Parameters
    ----------
    times
        Ascending, s; (time,). Speeds are smooth and monotone between them, and constant before and after.
    speeds
        rad/s; (time,).
    """
    times = texts_argument("times", times, "s")
    speeds = texts_argument("speeds", speeds, "rad/s")
    table = uniform_table(np.asarray(times, np.float64), np.asarray(speeds, np.float64))
    pairs = np.column_stack([table.values, table.slopes]).ravel()
    piece = Recorded(float(times[0]), RECORD, np.array([table.step, table.values.size, *pairs]))
    alone = WallSpeed((piece,), 0.0)
    return WallSpeed((piece,), alone.at(0.0)[0])


def wall_speed(profile: SpeedProfile | WallSpeed | float, initial: float | None = None) -> WallSpeed:
    """From a profile or one speed; the fluid turns with ``initial`` before time zero, by default with the profile."""
    if isinstance(profile, WallSpeed):
        return profile if initial is None else WallSpeed(profile.pieces, initial)
    part: SpeedProfile = Constant(speed=profile) if isinstance(profile, (int, float)) else profile
    pieces = tuple(profile_pieces(part))
    first = WallSpeed(pieces, 0.0).at(0.0, pieces[0])[0]
    return WallSpeed(pieces, first if initial is None else initial)


# Which model is good enough: what to expect of a speed profile before the flow is solved.


SECONDARY = 0.1  # share of the lag that the secondary flow takes away, over (w / slowest decay rate)^2; calibrated
LOOKS = 400  # instants at which the lag is looked at
SLOW = 1.6  # lag at the orbit over that of one decaying number: the share (4/pi)^2 of the slowest mode
SWIRLS = 500.0  # Reynolds number of the lag above which the layer at the inner wall breaks into vortices


@dataclass(frozen=True)
class Expected:
    """What to expect of a speed profile before the flow is solved."""

    fastest: float  # rad/s
    lag: float  # greatest lag over the greatest speed, at most 1
    error: float  # of the fluid's speed at the orbit by diffusion alone, over the greatest speed
    reynolds: float = 0.0  # of the greatest lag, over the gap
    lagged: float = 0.0  # integral of the lag over time, rad
    turned: float = 0.0  # integral of the speed over time, rad

    @property
    def unsteady(self) -> bool:
        """Whether vortices at the inner wall are to be expected, which no grid follows one by one."""
        return self.reynolds > SWIRLS


def expected(annulus: Annulus, modes: RelaxationModes, speed: WallSpeed, end: float) -> Expected:
    """From the modes: their lag, and the share of it that a secondary flow would take away.

    Where the rotor is slow against the slowest mode, that share grows as the square of w over its decay rate
    nu (pi^2/W^2 + pi^2/H^2); the factor was found with the full equations for gaps of 0.4 to 2.7 times the height, slow ramps
    (0.05 to 0.1) and impulsive starts (0.02 to 0.05).
    """
    fastest = speed.fastest(end)
    if fastest == 0.0:
        return Expected(0.0, 0.0, 0.0)
    times = np.unique(np.concatenate([np.linspace(0.0, end, LOOKS), speed.corners(end)]))
    speeds = speed.over(times)
    lag = np.abs(speeds - modes.response(speed, times))
    share = np.minimum(1.0, SECONDARY * (speeds / annulus.decay_rate) ** 2)
    behind = np.minimum(lag, _behind(annulus, speed.before, times, speeds))
    return Expected(
        fastest,
        lag=float(min(1.0, behind.max() / fastest)),
        error=float((lag * share).max() / fastest),
        reynolds=float(behind.max() * annulus.orbit_radius * annulus.width / annulus.viscosity),
        lagged=float(np.trapezoid(behind, times)),
        turned=float(np.trapezoid(np.abs(speeds), times)),
    )


def _behind(annulus: Annulus, before: float, times: Floats, speeds: Floats) -> Floats:
    """A guess of the lag where Ekman layers, at the rate 2 sqrt(nu w)/H, and diffusion bring the fluid along, rad/s."""
    rates = annulus.decay_rate + 2.0 * np.sqrt(annulus.viscosity * np.abs(speeds)) / annulus.height
    behind = np.empty_like(times)
    behind[0] = abs(speeds[0] - before)
    for i in range(1, times.size):
        x = 0.5 * (rates[i - 1] + rates[i]) * (times[i] - times[i - 1])
        rise = abs(speeds[i] - speeds[i - 1]) * -math.expm1(-x) / max(x, 1e-300)
        behind[i] = behind[i - 1] * math.exp(-x) + rise
    return np.asarray(SLOW * behind, np.float64)


# Relaxation modes: a fluid that only diffuses as a few numbers that decay.


MANY = 60  # modes in each direction from which the fewest that matter are taken


@dataclass(frozen=True)
class RelaxationModes:
    """Lag of the fluid at the orbit in modes: W_f = w - sum c_k with c_k' = -rate_k c_k + gain_k w'.

    To be integrated with the equations of motion where the speed w is a coordinate. The gains of all modes add up to 1:
    right after a jump of the speed the fluid still rotates as before. Modes that were left out follow without lag.

    Parameters
    ----------
    rates
        Decay rates, 1/s; (mode,).
    gains
        Share of each mode in a jump of the speed; (mode,). They are of either sign.
    """

    rates: Floats
    gains: Floats

    @property
    def ramp_lag(self) -> float:
        """Lag w - W_f after a long ramp over its rate w', s."""
        return float((self.gains / self.rates).sum())

    def step(self, lags: Floats, duration: float, change: float) -> Floats:
        """The lags c (rad/s) a time ``duration`` later in which the speed changes by ``change`` at a steady rate; exact."""
        x = self.rates * duration
        return lags * np.exp(-x) + self.gains * change * _mean_decay(x)

    def lags(self, speed: WallSpeed, times: Floats) -> Matrix:
        """c at ``times`` (ascending, from 0 on), rad/s; (time, mode). Exact for straight pieces with corners in ``times``."""
        speeds = speed.over(times)
        lags = np.empty((times.size, self.rates.size))
        lags[0] = self.gains * (speeds[0] - speed.before)
        for i in range(1, times.size):
            lags[i] = self.step(lags[i - 1], times[i] - times[i - 1], speeds[i] - speeds[i - 1])
        return lags

    def response(self, speed: WallSpeed, times: Floats) -> Floats:
        """W_f at ``times``, rad/s; as :meth:`lags`."""
        return np.asarray(speed.over(times) - self.lags(speed, times).sum(axis=1), np.float64)


def all_modes(annulus: Annulus) -> RelaxationModes:
    """As many modes at the orbit as the exact series is worked out with."""
    rates, gains = mode_table(annulus, MANY, MANY)
    return RelaxationModes(rates.ravel(), gains.ravel())


def relaxation_modes(annulus: Annulus, error: float = 1e-3) -> RelaxationModes:
    """The fewest modes of an ``annulus`` that give the lag after a long ramp within the share ``error``.

    A jump of the speed is followed with the same error only after a time: about ln(1/error) over the rate of the fastest mode
    that is kept.

    Raises
    ------
    QuestionError
        If ``error`` is not between 1e-6 and 0.5.
    """
    if not 1e-6 <= error <= 0.5:
        raise QuestionError(f"error: given {error:g}; must be between 1e-6 and 0.5")
    exact = all_modes(annulus)
    rates, gains = exact.rates, exact.gains
    weight = np.abs(gains) / rates
    order = np.argsort(-weight, kind="stable")
    lag = (gains / rates)[order]
    missing = np.abs(lag.cumsum() - lag.sum())
    kept = order[: int(np.flatnonzero(missing > error * abs(lag.sum()))[-1]) + 2]
    return RelaxationModes(rates[kept], gains[kept])


def diffusive_swirl(annulus: Annulus, speed: WallSpeed, times: Floats, radius: Floats, height: Floats) -> Matrix:
    """W - w of a fluid that only diffuses, rad/s; (time, radius, height).

    ``times`` ascend from 0 on and contain the corners of the speed; walls that jump at time 0 need some time to be seen with
    a finite number of modes.
    """
    waves = radial_roots(annulus.inner, annulus.outer, MANY)
    k = math.pi * (2.0 * np.arange(MANY) + 1.0)
    rates = annulus.viscosity * (waves[:, None] ** 2 + (k[None, :] / annulus.height) ** 2)
    gains = np.outer(radial_shares(annulus.inner, annulus.outer, waves), 4.0 / k)
    lags = RelaxationModes(rates.ravel(), gains.ravel()).lags(speed, times).reshape(-1, MANY, MANY)
    shape = radial_modes(annulus.inner, waves, radius) / radius[:, None]
    return np.asarray(-(shape @ lags @ np.sin(np.outer(k, height / annulus.height))), np.float64)


def _mean_decay(x: Floats) -> Floats:
    """(1 - exp(-x))/x."""
    return np.asarray(-np.expm1(-x) / np.maximum(x, math.ulp(1.0) ** 2), np.float64)


# Exact modes of a fluid that only diffuses between walls that turn with the rotor.
#
# Without secondary flow g_t = nu D2 g - r^2 w', g = 0 on the walls, so g/r is a sum of
#
#     phi_n(r) sin(k pi z/H),  phi_n(r) = J1(l_n r) Y1(l_n a) - Y1(l_n r) J1(l_n a),  phi_n(b) = 0,
#
# with the decay rates nu (l_n^2 + (k pi/H)^2); only odd k are excited by walls that turn together.


def radial_roots(inner: float, outer: float, count: int) -> Floats:
    """The first ``count`` l_n, 1/m; each lies close to n pi/(b - a)."""

    def cross(wave: float) -> float:
        return float(j1(wave * outer) * y1(wave * inner) - y1(wave * outer) * j1(wave * inner))

    step = math.pi / (outer - inner)
    values: list[float] = []
    low, start = 1e-6 * step, cross(1e-6 * step)
    while len(values) < count:
        high = low + 0.1 * step
        end = cross(high)
        if start * end < 0.0:
            values.append(root(cross, low, high, xtol=1e-13 * step, rtol=1e-15))
        low, start = high, end
    return np.array(values)


def radial_modes(inner: float, waves: Floats, radius: Floats) -> Matrix:
    """phi_n(r); (radius, mode)."""
    x = np.outer(radius, waves)
    return np.asarray(j1(x) * y1(waves * inner) - y1(x) * j1(waves * inner), np.float64)


def radial_shares(inner: float, outer: float, waves: Floats) -> Floats:
    """A_n in r = sum A_n phi_n(r), by orthogonality with the weight r."""
    ends = np.array([inner, outer])
    x = np.outer(ends, waves)
    y_a, j_a = y1(waves * inner), j1(waves * inner)
    jn2, yn2 = 2.0 / x * j1(x) - j0(x), 2.0 / x * y1(x) - y0(x)
    moment = ends[:, None] ** 2 * (jn2 * y_a - yn2 * j_a) / waves  # integral of r^2 C1 is r^2 C2 / l
    slope = waves * ((j0(x) - j1(x) / x) * y_a - (y0(x) - y1(x) / x) * j_a)  # phi'
    square = 0.5 * ends[:, None] ** 2 * slope**2 / waves**2  # integral of r C1^2 where C1 = 0 at both ends
    return np.asarray((moment[1] - moment[0]) / (square[1] - square[0]), np.float64)


def mode_table(annulus: Annulus, radial: int, axial: int) -> tuple[Matrix, Matrix]:
    """Decay rates (1/s) and gains at the orbit of the modes; (radial, axial), the axial wave numbers k are 1, 3, 5, ...

    After an impulsive start at the speed w from rest the fluid at the orbit turns with w (1 - sum gain exp(-rate t)).
    """
    waves = radial_roots(annulus.inner, annulus.outer, radial)
    k = 2.0 * np.arange(axial) + 1.0
    shape = radial_modes(annulus.inner, waves, np.array([annulus.orbit_radius]))[0] / annulus.orbit_radius
    middle = 4.0 / (math.pi * k) * np.where(np.arange(axial) % 2 == 0, 1.0, -1.0)
    rates = annulus.viscosity * (waves[:, None] ** 2 + (math.pi * k[None, :] / annulus.height) ** 2)
    return rates, np.outer(radial_shares(annulus.inner, annulus.outer, waves) * shape, middle)


# A solved flow as a labelled dataset.


@dataclass(frozen=True)
class Solved:
    """Arrays of a solved flow, whatever the model."""

    model: str
    times: Floats
    speed: Floats
    orbit: Floats
    radius: Floats
    height: Floats
    moments: Floats
    swirl: Matrix  # W - w; (moment, radius, height)
    stream: Matrix
    vorticity: Matrix
    torque: Floats
    momentum: Floats
    moment_speed: Floats
    steps: int
    uncertainty: float = 0.0  # of an unsteady flow, over the greatest speed


def percent(share: float) -> str:
    """A share as people read it: ``"14.3 %"``."""
    return f"{100.0 * share:.3g} %"


def flow_notes(flow: xr.Dataset) -> list[str]:
    """What to make of a solved flow, in sentences: how certain an unsteady one is."""
    uncertainty = float(flow.attrs["uncertainty"])
    if uncertainty == 0.0:
        return []
    if not np.isfinite(uncertainty):
        return [
            "vortices form at the inner wall, and a coarser grid cannot follow them, so it is unknown how certain the lag is; "
            "a finer grid (points) shows it"
        ]
    lag = float(flow.attrs["greatest_lag"]) / max(float(np.abs(flow["speed"]).max()), 1e-300)
    return [
        f"vortices form at the inner wall: at an instant the speed of the fluid is certain to {percent(uncertainty)} of the "
        f"greatest speed only (a coarser grid differs by this), and the greatest lag is {percent(lag)} of it; "
        "a mean over time is more certain"
    ]


# The fluid at the orbit over time, as a table.


@dataclass(frozen=True)
class SpinUp:
    """Angular velocity of the fluid at the orbit over time, for balls on a rotor whose speed is prescribed.

    The flow does not depend on the balls, so one table serves all runs with this profile.

    Parameters
    ----------
    times
        Ascending, s; (time,).
    angular_velocity
        Of the fluid at the orbit in space, rad/s; (time,).
    """

    times: Floats
    angular_velocity: Floats

    def at(self, times: Floats | float) -> Floats:
        """Angular velocity at ``times``, rad/s: monotonic cubics between the entries, constant outside."""
        inside = np.clip(times, self.times[0], self.times[-1])
        return np.asarray(PchipInterpolator(self.times, self.angular_velocity)(inside), np.float64)


def spin_up(flow: xr.Dataset) -> SpinUp:
    """The table of ``flow``, a result of :func:`annulus_flow`."""
    return SpinUp(flow["time"].values.copy(), flow["fluid_speed"].values.copy())


# What a solver records at every step.


@dataclass
class Track:
    """Time, speed of the rotor and angular velocity of the fluid at the orbit (rad/s), step by step."""

    times: list[float] = field(default_factory=list)
    speeds: list[float] = field(default_factory=list)
    orbit: list[float] = field(default_factory=list)
    steps: int = 0
    rejected: int = 0

    def note(self, time: float, speed: float, lag: float) -> None:
        """One more instant; ``lag`` is relative to the rotor."""
        self.times.append(time)
        self.speeds.append(speed)
        self.orbit.append(speed + lag)

    def arrays(self) -> tuple[Floats, Floats, Floats]:
        """The same as arrays."""
        return np.array(self.times), np.array(self.speeds), np.array(self.orbit)
