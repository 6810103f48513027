"""Race, friction and drag from measurements on the balancer."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from autobalancer.arrays import Floats
from autobalancer.catalog.resolve import resolve
from autobalancer.errors import QuestionError, one_of
from autobalancer.files.machine_file import balls_in_races
from autobalancer.files.text_files import read_table
from autobalancer.laws.stall import rest_ends
from autobalancer.machine import Machine
from autobalancer.results.answers.answer import Answer, Form, Shown, provenance, sure
from autobalancer.results.display_units import length_text
from autobalancer.results.labels import labeled
from autobalancer.roots import root
from autobalancer.rotordynamics.response import response
from autobalancer.tables import Column
from autobalancer.units import argument, texts_argument

# Roundness of a race: a measured profile as a circle, its eccentricity, and waves with their uncertainty.
#
# The profile r(phi) = R + sum of a_k cos(k (phi - alpha_k)) is fitted by least squares, so that points may stand at
# any angles. Order 1 is the distance of the center from the axis of the measurement; from order 2 on the waves are
# those of the race. Waves up to a number of undulations per revolution are kept.


Center = Literal["axis", "setup"]
EXAMPLE = "angle [deg], radius [mm] (or: deviation [um])"
MOST = 60  # waves of a machine file
CLEAR = 3.0  # deviations from which on a wave is taken for one
FAR = 8.0  # robust standard deviations beyond which a point is no part of a race


def race_shape(
    angles: ArrayLike | str | Path,
    radii: ArrayLike | None = None,
    *,
    waves: int = 15,
    center: Center = "axis",
) -> RaceShape:
    """Circle, eccentricity and waves of a race from its measured profile.

    Parameters
    ----------
    angles
        In the rotor, rad, (n,), in any order over a whole turn; or a table with the columns ``angle`` and ``radius`` or
        ``deviation`` (of the radius).
    radii
        m, (n,), where angles are given.
    waves
        Undulations per revolution up to which the profile is kept.
    center
        Around what it was measured: ``"axis"`` of the rotor, so that order 1 is the eccentricity of the race; or a ``"setup"`` on
        which it was clamped anyhow, so that order 1 says nothing of the race and is taken away.

    Returns
    -------
    RaceShape
        Over ``order`` from 2: ``amplitude`` (m), ``crest`` (rad, of a crest in the rotor) and their one standard deviations; over
        ``point`` the ``profile`` without circle and eccentricity and what was ``fitted`` (m). ``radius``, ``eccentricity``,
        ``eccentricity_angle`` and deviations, ``roundness`` (greatest less least of the fitted profile, m) and ``scatter`` are
        attributes; ``machine_lines()`` has the lines of a machine file.

    Raises
    ------
    QuestionError
        If there are too few points, a gap in the turn is too wide, or a point lies far off; it names the angle.

    Source: least-squares circle and undulations per revolution as in ISO 12181; Spannan (2021), section 6.1.6.
    """
    phi, r, whole = _profile(angles, radii)
    if not 2 <= waves <= MOST:
        raise QuestionError(f"race_shape: waves: given {waves}; must be from 2 to {MOST}")
    one_of("race_shape: center", center, "axis", "setup")
    order = np.argsort(phi)
    phi, r = phi[order], r[order]
    _check(phi, waves)
    rows = _rows(phi, waves)
    race_shape = np.linalg.lstsq(rows, r, rcond=None)[0]
    left = r - rows @ race_shape
    freedom = r.size - rows.shape[1]
    scatter = float(np.sqrt((left**2).sum() / freedom))
    robust = 1.4826 * float(np.median(np.abs(left)))
    worst = int(np.argmax(np.abs(left)))
    if robust > 0.0 and abs(left[worst]) > FAR * robust and abs(left[worst]) > 3.0 * scatter:
        raise QuestionError(
            f"race_shape: the point at {np.degrees(phi[worst]):.4g} deg is {1e6 * left[worst]:.3g} um off its neighbors, "
            f"{FAR:g} times as far "
            "as others scatter; dirt, or a wrong number: leave it out"
        )
    covariance = scatter**2 * np.linalg.inv(rows.T @ rows)
    return _answer(phi, r, rows, race_shape, covariance, scatter, waves, center, whole)


def _profile(angles: ArrayLike | str | Path, radii: ArrayLike | None) -> tuple[Floats, Floats, bool]:
    """Angles, radii, and whether radii are whole ones and no deviations."""
    if isinstance(angles, (str, Path)):
        table = read_table(Path(angles), EXAMPLE)
        name = "radius" if "radius" in table.heads else "deviation"
        return np.mod(table.numbers("angle", "rad"), 2.0 * np.pi), table.numbers(name, "m"), name == "radius"
    phi, r = _row("angles", angles, "rad"), _row("radii", radii, "m")
    if phi.ndim != 1 or phi.shape != r.shape or not (np.isfinite(phi).all() and np.isfinite(r).all()):
        raise QuestionError("race_shape: give as many finite radii as angles")
    return np.mod(phi, 2.0 * np.pi), r, bool(np.abs(r.mean()) > 10.0 * np.ptp(r))


def _row(name: str, values: ArrayLike | None, unit: str) -> Floats:
    """Numbers or texts that a caller gives, SI; nan where nothing was given."""
    return np.atleast_1d(np.asarray(texts_argument(name, np.nan if values is None else values, unit), float))


def _check(phi: Floats, waves: int) -> None:
    least = 2 * waves + 3
    if phi.size < least:
        raise QuestionError(
            f"race_shape: given {phi.size} points; {waves} waves need at least {least}: measure more, or keep fewer waves"
        )
    gaps = np.diff(np.r_[phi, phi[0] + 2.0 * np.pi])
    wide = int(np.argmax(gaps))
    if gaps[wide] > 0.9 * np.pi / waves:
        raise QuestionError(
            f"race_shape: nothing was measured from {np.degrees(phi[wide]):.4g} to "
            f"{np.degrees(phi[wide] + gaps[wide]):.4g} deg; {waves} waves "
            f"need a point at least every {0.9 * 180.0 / waves:.3g} deg: measure there, or keep fewer waves"
        )


def _rows(phi: Floats, waves: int) -> Floats:
    k = np.arange(1, waves + 1)
    return np.concatenate([np.ones((phi.size, 1)), np.cos(np.outer(phi, k)), np.sin(np.outer(phi, k))], axis=1)


def _answer(
    phi: Floats,
    r: Floats,
    rows: Floats,
    result: Any,
    covariance: Any,
    scatter: float,
    waves: int,
    center: Center,
    whole: bool,
) -> RaceShape:
    k = np.arange(1, waves + 1)
    cosine, sine = result[1 : waves + 1], result[waves + 1 :]
    amplitude, crest = np.hypot(cosine, sine), np.arctan2(sine, cosine) / k
    spread = np.sqrt(0.5 * (np.diag(covariance)[1 : waves + 1] + np.diag(covariance)[waves + 1 :]))
    with np.errstate(divide="ignore"):
        turned = np.minimum(spread / np.where(amplitude > 0.0, amplitude, np.inf), np.pi / np.sqrt(3.0)) / k
    round_part = rows[:, [0, 1, waves + 1]] @ result[[0, 1, waves + 1]]
    fine = _rows(np.linspace(0.0, 2.0 * np.pi, 1440, endpoint=False), waves)
    shape = np.delete(fine, [0, 1, waves + 1], axis=1) @ np.delete(result, [0, 1, waves + 1])
    answer = labeled(
        {
            "amplitude": ("order", amplitude[1:], "amplitude of the wave", "m"),
            "amplitude_deviation": ("order", spread[1:], "its standard deviation", "m"),
            "crest": ("order", crest[1:], "angle of a crest in the rotor", "rad"),
            "crest_deviation": ("order", turned[1:], "its standard deviation", "rad"),
            "profile": ("point", r - round_part, "radius less circle and eccentricity", "m"),
            "fitted": ("point", rows @ result - round_part, "sum of the waves", "m"),
        },
        {
            "order": ("order", k[1:], "undulations per revolution", "1"),
            "angle": ("point", phi, "angle in the rotor", "rad"),
        },
    )
    warnings = []
    if scatter > 0.5 * max(amplitude[1:].max(), 1e-12):
        warnings.append(
            f"points scatter by {1e6 * scatter:.3g} um about {waves} waves, as much as the greatest wave: keep more "
            "waves, or measure better"
        )
    if center == "setup":
        warnings.append(f"an eccentricity of {1e6 * amplitude[0]:.3g} um of the setup was taken away")
    answer.attrs = {
        "title": "Shape of a race", **provenance(), "radius": float(result[0]) if whole else float("nan"),
        "radius_deviation": float(np.sqrt(covariance[0, 0])), "eccentricity": float(amplitude[0]),
        "eccentricity_angle": float(crest[0]), "eccentricity_deviation": float(spread[0]), "center": center,
        "roundness": float(np.ptp(shape)), "scatter": scatter, "waves": waves, "warnings": "\n".join(warnings),
    }  # fmt: skip
    return RaceShape.of(answer)


# The shape of a race as a table of its waves, and as lines of a machine file.


class RaceShape(Answer):
    """Waves of a measured race."""

    __slots__ = ()
    shown_as = Form(
        lambda it, unit: [
            *it.shown(
                unit, Shown("order", "waves"), Shown("amplitude", unit="µm", form=".3g"), sure("amplitude", "µm")
            ),
            Column("crest at", np.mod(np.degrees(it["crest"].values), 360.0 / it["order"].values), "deg", ".1f"),
            *it.shown(unit, sure("crest", "deg")),
        ],
        "order",
        ("amplitude", "crest"),
        frozenset({"radius", "eccentricity", "roundness", "scatter"}),
    )

    def facts(self) -> list[tuple[str, str]]:
        """Circle, center and roundness."""
        messages = [
            ("roundness", f"{length_text(float(self.attrs['roundness']))} from the lowest to the highest point")
        ]
        if np.isfinite(self.attrs["radius"]):
            radius, sure = 1e3 * float(self.attrs["radius"]), length_text(float(self.attrs["radius_deviation"]))
            messages.append(("radius", f"{radius:.6g} mm +- {sure}"))
        of = "of the race" if self.attrs["center"] == "axis" else "of the setup, taken away"
        size, way = float(self.attrs["eccentricity"]), np.degrees(float(self.attrs["eccentricity_angle"])) % 360.0
        sure = length_text(float(self.attrs["eccentricity_deviation"]))
        messages.append(("eccentricity", f"{length_text(size)} +- {sure} at {way:.0f} deg, {of}"))
        messages.append(("points scatter by", length_text(float(self.attrs["scatter"]))))
        return messages

    def machine_lines(self) -> str:
        """Lines for a race of a machine file: waves that are clear of their uncertainty, and the eccentricity of the race."""
        lines = []
        if np.isfinite(self.attrs["radius"]):
            lines.append(f'race_radius = "{1e3 * float(self.attrs["radius"]):.5f} mm"')
        if self.attrs["center"] == "axis" and self.attrs["eccentricity"] > CLEAR * self.attrs["eccentricity_deviation"]:
            lines.append(f'eccentricity = "{1e6 * float(self.attrs["eccentricity"]):.4g} um"')
            lines.append(
                f'eccentricity_angle = "{np.degrees(float(self.attrs["eccentricity_angle"])) % 360.0:.5g} deg"'
            )
        clear = self["amplitude"].values > CLEAR * self["amplitude_deviation"].values
        waves = [
            f'    {{ order = {int(k)}, amplitude = "{1e6 * a:.4g} um", angle = "{np.degrees(crest) % (360.0 / k):.5g} deg" }},'
            for k, a, crest, one in zip(
                self["order"].values, self["amplitude"].values, self["crest"].values, clear, strict=True
            )
            if one
        ]
        if waves:
            lines += ["harmonics = [", *waves, "]"]
        return "\n".join(lines) + "\n"


# Friction between ball and race from where a ball came to rest in many run-ups.
#
# Adherence mu holds a ball anywhere within an interval around its place opposite the unbalance. Rests that fill an
# interval evenly, as after run-ups that end anyhow, give its width; the friction is that whose interval is as wide.


FEWEST = 5
GREATEST = 0.5  # adherence
REST_EXAMPLE = "angle [deg]"


@dataclass(frozen=True)
class RestFriction:
    """``adherence`` with ends of its 95 % interval ``low`` and ``high``; ``width`` of the interval of rests (rad) with "
    "the ends of its own,
    its ``middle`` (rad from the balanced place) with one standard deviation, the ``angles`` of all rests, and ``remarks``.
    """

    adherence: float
    low: float
    high: float
    width: float
    width_low: float
    width_high: float
    middle: float
    middle_deviation: float
    angles: tuple[float, ...]
    remarks: tuple[str, ...]


def rest_friction(machine: Machine | str | Path, angles: ArrayLike | str | Path, speed: float | str) -> RestFriction:
    """Adherence of one ball from its rest positions.

    Parameters
    ----------
    machine
        With one ball, whose unbalance it cannot balance alone or just balances, on a rotor alike along x and y.
    angles
        Of the rests in the rotor, from the place opposite the unbalance, rad, (n,); or a table with the column ``angle``.
    speed
        At which it rested, rad/s, above the critical speed.

    Raises
    ------
    QuestionError
        If there are too few rests, more than one ball, or no friction up to 0.5 explains them.

    Notes
    -----
    Of n rests spread evenly over a width d their range R has R/d distributed as Beta(n - 1, 2), so d is (n + 1)/(n - 1) R and
    its interval follows from quantiles. Rests that gather in the middle make d too wide. A race that is not round shifts and
    widens the interval.
    """
    machine = balls_in_races(machine)
    w = argument("speed", speed, "rad/s")
    rests = _rests(angles)
    # one ball, and rests that differ
    balls = resolve(machine)
    if len(balls) != 1:
        raise QuestionError(f"rest_friction: the machine has {len(balls)} balls; rests of exactly one are evaluated")
    ball = balls[0]
    gain, load = _gain(machine, w)
    range_, n = float(np.ptp(rests)), rests.size
    if range_ == 0.0:
        raise QuestionError(
            f"rest_friction: all {n} rests are at one angle; the friction is too small to be seen, or they are copies"
        )
    # the width of the interval of rests from the range of n of them, and with it the adherence
    width, width_low, width_high = _widths(range_, n)
    rest_friction = [
        _adherence(width, gain, load, ball.moment, ball.orbit_radius) for width in (width, width_low, width_high)
    ]
    # do the rests lie where they should, and spread evenly?
    middle = 0.5 * float(rests.max() + rests.min())
    spread = width / np.sqrt(2.0 * (n + 1.0) * (n + 2.0))
    ends = rest_ends(gain, load, ball.moment, ball.orbit_radius, rest_friction[0])
    expected = 0.0 if ends is None else 0.5 * (ends[0] + ends[1])
    remarks = []
    if abs(middle - expected) > 3.0 * spread:
        remarks.append(
            f"the middle of the rests is {np.degrees(middle - expected):.3g} deg off where it should be, more than chance "
            "makes it: a race that "
            "is not round or not centered, or an unbalance elsewhere"
        )
    third = float(np.mean(np.abs(rests - middle) < width / 6.0))
    if n >= 12 and third > 1.0 / 3.0 + 3.0 * np.sqrt(2.0 / 9.0 / n):
        remarks.append(
            "the rests gather in the middle of their interval, so that friction is rather smaller than stated"
        )
    widths = width, width_low, width_high
    adherence, low, high = rest_friction
    return RestFriction(adherence, low, high, *widths, middle, float(spread), tuple(rests.tolist()), tuple(remarks))


def _rests(angles: ArrayLike | str | Path) -> Floats:
    if isinstance(angles, (str, Path)):
        result = read_table(Path(angles), REST_EXAMPLE).numbers("angle", "rad")
    else:
        result = _row("angles", angles, "rad")
    if result.ndim != 1 or result.size < FEWEST or not np.isfinite(result).all():
        raise QuestionError(f"rest_friction: given {result.size} rests; at least {FEWEST} finite angles are needed")
    wrapped = np.mod(result + np.pi, 2.0 * np.pi) - np.pi
    if np.abs(wrapped).max() > 0.5 * np.pi:
        far = float(wrapped[int(np.argmax(np.abs(wrapped)))])
        raise QuestionError(
            f"rest_friction: a rest at {np.degrees(far):.4g} deg is more than 90 deg off the place opposite the "
            "unbalance; count angles from "
            "there, and leave out balls that stuck before they balanced"
        )
    return np.asarray(wrapped)


def _gain(machine: Machine, speed: float) -> tuple[complex, float]:
    """Whirl of the plane of the ball for a unit unbalance there, and the unbalance of the machine seen there."""
    if not machine.unbalances:
        raise QuestionError("rest_friction: the machine has no unbalance; a ball rests opposite to one")
    own = response(machine, [speed], balls=True).isel(speed=0, station=0)
    one = response(machine, [speed], unbalance=1.0, balls=True).isel(speed=0, station=0)
    gain = complex(float(one["x_real"]), float(one["x_imag"]))
    return gain, abs(complex(float(own["x_real"]), float(own["x_imag"])) / gain)


def _widths(range_: float, count: int) -> tuple[float, float, float]:
    from scipy.stats import beta

    low, high = beta.ppf([0.975, 0.025], count - 1, 2)
    return range_ * (count + 1) / (count - 1), range_ / float(low), range_ / float(high)


def _adherence(width: float, gain: complex, load: float, moment: float, orbit_radius: float) -> float:
    """The friction whose interval of rest is so wide."""

    def excess(adherence: float) -> float:
        ends = rest_ends(gain, load, moment, orbit_radius, adherence)
        return (0.0 if ends is None else ends[1] - ends[0]) - width

    if excess(GREATEST) < 0.0:
        raise QuestionError(
            f"rest_friction: rests over {np.degrees(width):.3g} deg are wider than an adherence of {GREATEST:g} explains "
            "at this speed and "
            "unbalance; check the speed and the unbalance of the machine"
        )
    return root(excess, 1e-9, GREATEST, xtol=1e-12, rtol=1e-9)


# Drag and rolling resistance from how far a ball lags behind its rotor in a run-up.
#
# On a round race whose plane hardly moves, with phi' the speed of the ball in the rotor and w that of the rotor:
#
#     I phi'' + S w' = - beta phi' - mu m eps^2 (w + phi')^2 sign(phi')
#
# with the inertias I and S of the ball that its machine has. Integrated once over time this needs no derivative of a
# measured speed, and is linear in beta and mu.


LAG_EXAMPLE = "time [s], rotor speed [rpm], ball speed [rpm]"
FEWEST_LAGS, MOST_LAGS = 20, 1000  # samples; of more, neighbors are averaged
ROUNDS = 4  # of the drag, on which the weights depend
ALIKE = 0.98  # correlation of drag and rolling resistance beyond which only their sum is known


@dataclass(frozen=True)
class LagFit:
    """``drag`` beta (N m s) and ``rolling_resistance`` with one standard deviation each, their ``correlation``, and the
    ``scatter`` of the speed of the ball about the fit (rad/s).
    """

    drag: float
    drag_deviation: float
    rolling_resistance: float
    rolling_resistance_deviation: float
    correlation: float
    scatter: float
    remarks: tuple[str, ...]


def drag_from_lag(
    machine: Machine | str | Path,
    time: ArrayLike | str | Path,
    rotor_speed: ArrayLike | None = None,
    ball_speed: ArrayLike | None = None,
    *,
    rolling: bool = True,
) -> LagFit:
    """Linear drag and rolling resistance of one ball from a run-up.

    Parameters
    ----------
    machine
        With one ball on a vertical axis; its size and mass, not its drag, are used.
    time, rotor_speed, ball_speed
        s and rad/s in space, (n,); or a table with these columns.
    rolling
        Whether there may be rolling resistance beside the drag.

    Raises
    ------
    QuestionError
        If the machine or the record does not fit, or nothing lags.
    """
    machine = balls_in_races(machine)
    balls = resolve(machine)
    if len(balls) != 1 or machine.axis != "vertical":
        raise QuestionError(
            f"drag_from_lag: {len(balls)} balls on a {machine.axis} axis; one ball on a vertical axis is evaluated"
        )
    ball = balls[0]
    t, w, absolute = _record(time, rotor_speed, ball_speed)
    lag = w - absolute
    spin = ball.moment * ball.orbit_radius - ball.spin_ratio * ball.mass * ball.rolling_radius * ball.orbit_radius
    known = -ball.inertia * lag + spin * w  # momentum that drag and friction have given to the ball
    if np.abs(lag).max() < 1e-9 * np.abs(w).max():
        raise QuestionError(
            "drag_from_lag: the ball does not lag behind the rotor; record a faster run-up, or check the channels"
        )
    pulls = [lag, _sense(lag) * ball.moment * ball.orbit_radius * absolute**2]
    columns = [_integral(t, pull) for pull in (pulls if rolling else pulls[:1])]
    rows = np.column_stack([*columns, np.full(t.size, ball.inertia)])  # the last one: an error of the first speed
    drag, covariance, variance = _least(t, rows, known - known[0], ball.inertia)
    sure = np.sqrt(np.diag(covariance))
    correlation = float(covariance[0, 1] / (sure[0] * sure[1])) if rolling else 0.0
    remarks = []
    if abs(correlation) > ALIKE:
        remarks.append(
            "drag and rolling resistance act alike in this record; only their sum is known: use several accelerations"
        )
    if rolling and abs(drag[1]) < 2.0 * sure[1]:
        remarks.append("no rolling resistance is seen beyond its uncertainty; without it the drag is surer")
    if drag[0] < -2.0 * sure[0] or (rolling and drag[1] < -3.0 * sure[1] - 1e-6):
        remarks.append(
            "a negative friction or drag: the ball gains where it should lose; check signs, and whether the rotor whirls much"
        )
    return LagFit(
        float(drag[0]), float(sure[0]), float(drag[1]) if rolling else 0.0, float(sure[1]) if rolling else 0.0,
        correlation, float(np.sqrt(variance)), tuple(remarks),
    )  # fmt: skip


def _record(
    time: ArrayLike | str | Path, rotor_speed: ArrayLike | None, ball_speed: ArrayLike | None
) -> tuple[Floats, Floats, Floats]:
    if isinstance(time, (str, Path)):
        table = read_table(Path(time), LAG_EXAMPLE)
        t, w, b = (
            table.numbers(name, u) for name, u in (("time", "s"), ("rotor speed", "rad/s"), ("ball speed", "rad/s"))
        )
    else:
        given = (("time", time, "s"), ("rotor_speed", rotor_speed, "rad/s"), ("ball_speed", ball_speed, "rad/s"))
        t, w, b = (_row(name, values, unit) for name, values, unit in given)
    alike = t.ndim == 1 and t.shape == w.shape == b.shape
    if not alike or t.size < FEWEST_LAGS or not np.isfinite([t, w, b]).all():
        raise QuestionError(
            f"drag_from_lag: give at least {FEWEST_LAGS} finite times, and as many speeds of rotor and ball"
        )
    if (np.diff(t) <= 0.0).any():
        raise QuestionError(
            f"drag_from_lag: times must ascend; they do not after {t[int(np.argmax(np.diff(t) <= 0.0))]:g} s"
        )
    t, w, b = _thinned([t, w, b])
    return t, w, b


def _least(time: Floats, rows: Floats, known: Floats, inertia: float) -> tuple[Floats, Floats, float]:
    """Unknowns, their covariance, and the variance of a speed of the ball.

    An error e of that speed is in the momentum as I e and in the integral of the drag as beta times the integral of e, so that
    errors of neighboring rows belong together; rows are combined until they do not.
    """
    from scipy.linalg import solve_triangular

    steps = np.diff(time)
    trapezes = np.tril(np.tile(np.r_[0.5 * steps, 0.0] + np.r_[0.0, 0.5 * steps], (time.size, 1)), -1)
    trapezes += np.diag(np.r_[0.0, 0.5 * steps])
    trapezes[1:, 0] = 0.5 * steps[0]
    scale = np.abs(rows).max(axis=0)
    mixed, beta = np.eye(time.size) * inertia, 0.0
    for _ in range(ROUNDS):
        mixed = inertia * np.eye(time.size) + beta * trapezes
        design = solve_triangular(mixed, rows / scale, lower=True)
        values = solve_triangular(mixed, known, lower=True)
        result, _, rank, _ = np.linalg.lstsq(design, values, rcond=None)
        if rank < rows.shape[1]:
            raise QuestionError("drag_from_lag: the record does not determine the drag; the lag must change over it")
        beta = max(0.0, float(result[0] / scale[0]))
    variance = float(((values - design @ result) ** 2).sum()) / (time.size - rows.shape[1])
    return result / scale, variance * np.linalg.inv(design.T @ design) / np.outer(scale, scale), variance


def _sense(lag: Floats) -> Floats:
    """Sign of the lag, that of its neighborhood where it is small."""
    from scipy.signal import medfilt

    return np.asarray(np.sign(medfilt(lag, 9)))


def _thinned(parts: list[Floats]) -> list[Floats]:
    """Means of neighboring samples of a long record."""
    block = -(-parts[0].size // MOST_LAGS)
    whole = parts[0].size // block * block
    return [part[:whole].reshape(-1, block).mean(axis=1) for part in parts]


def _integral(time: Floats, values: Floats) -> Floats:
    """From the first time on, by splines."""
    from scipy.interpolate import CubicSpline

    return np.asarray(CubicSpline(time, values).antiderivative()(time))
