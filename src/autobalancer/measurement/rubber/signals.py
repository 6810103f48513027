"""Points of rubber straight from recorded force and deflection, with one or several amplitudes in a record.

Each period is fitted by itself; neighbors of equal amplitude are one loop, whose complex stiffness is the ratio of the first
harmonics of force and deflection. How much its periods differ says how sure it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from autobalancer.errors import QuestionError
from autobalancer.laws.rubber import Motion
from autobalancer.measurement.signals.load import load_signals
from autobalancer.results.answers.rubber_points import RubberPoints, joined
from autobalancer.units import argument, optional_argument

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
Record = xr.Dataset | str | Path
ALIKE = 0.05  # relative difference of amplitudes of neighboring periods that are one loop
PERIODS = 4  # of a loop, the first one of which settles and is left out
CALIBRATION = 0.005  # relative standard uncertainty that no scatter shows: of both sensors, and of their phase (rad)
REFINED = 3  # times that the frequency is improved
CLIPPED = 0.05  # share of samples at the same extreme value


def rubber_signals(
    records: Record | Sequence[Record],
    *,
    deflection: str | None = None,
    force: str | None = None,
    frequency: float | str | None = None,
    calibration: float = CALIBRATION,
    motion: Motion = "line",
) -> RubberPoints:
    """Stiffness and loss of rubber at every amplitude and frequency of recorded hysteresis loops.

    Parameters
    ----------
    records
        Signals with a displacement and a force, or their files, see :func:`~autobalancer.measure.load_signals`; one frequency
        in each, and amplitudes in steps of at least four periods.
    deflection, force
        Names of the channels; by default the only displacement and the only force.
    frequency
        Of the motion, rad/s, the same in all records; by default that of the deflection in each.
    calibration
        Relative standard uncertainty of the sensors, and of the phase between them in rad, which no scatter shows.
    motion
        ``"line"`` or ``"circle"``.

    Returns
    -------
    RubberPoints
        For :func:`~autobalancer.measure.rubber`, with standard uncertainties from the scatter of the periods and the calibration.

    Raises
    ------
    QuestionError
        If a channel is missing or clipped, a record has no loop of four periods, or the rubber would give energy; it names the
        time.

    Source: Spannan (2021), (6.2) to (6.5), with K' and K'' in place of k and b.
    """
    w = optional_argument("frequency", frequency, "rad/s")
    if not 0.0 < calibration < 0.5:
        raise QuestionError(
            f"rubber_signals: calibration: given {calibration:g}; must be a share such as {CALIBRATION:g}"
        )
    given = [records] if isinstance(records, (xr.Dataset, str, Path)) else list(records)
    if not given:
        raise QuestionError("rubber_signals: given no records")
    return joined([_points(one, deflection, force, w, calibration, motion) for one in given])


def _points(
    record: Record,
    deflection: str | None,
    force: str | None,
    frequency: float | None,
    calibration: float,
    motion: Motion,
) -> RubberPoints:
    found = record if isinstance(record, xr.Dataset) else load_signals(record)
    place = str(found.attrs.get("origin") or "signals")
    t = found["time"].values
    x, f = (_channel(found, name, kind, place) for name, kind in ((deflection, "displacement"), (force, "force")))
    w = _frequency(t, x, place) if frequency is None else frequency
    step, period = float(t[1] - t[0]), 2.0 * np.pi / w
    if step > period / FEWEST:
        raise QuestionError(f"{place}: {period / step:.3g} samples in a period; at least {FEWEST} are needed")
    for _ in range(1 if frequency is not None else REFINED):
        starts, moved, pushed = _periods(t, x, f, w)
        loops = _loops(np.abs(moved))
        if frequency is None and loops:
            w += _advance(moved, loops) / (2.0 * np.pi / w)
    if not loops:
        raise QuestionError(
            f"{place}: no {PERIODS} periods of {w / (2.0 * np.pi):.4g} Hz in a row have one amplitude within "
            f"{100.0 * ALIKE:g} %; hold each "
            "amplitude longer, or give the 'frequency'"
        )
    rows = [_loop(w, starts[part], moved[part], pushed[part], calibration, place) for part in loops]
    size, stiff, stiff_sure, loss, loss_sure, names = zip(*rows, strict=True)
    count = len(rows)
    return RubberPoints(
        np.full(count, w), np.array(size), np.array(stiff), np.array(loss), np.array(stiff_sure), np.array(loss_sure),
        (motion,) * count, ("loop",) * count, names,
    )  # fmt: skip


def _channel(found: xr.Dataset, name: str | None, kind: str, place: str) -> Floats:
    if name is None:
        fitting = [str(one) for one, entry in found.data_vars.items() if entry.attrs.get("quantity") == kind]
        if len(fitting) != 1:
            raise QuestionError(f"{place}: {len(fitting)} channels are a {kind}; name the one to use")
        name = fitting[0]
    if name not in found:
        raise QuestionError(f"{place}: no channel {name!r}; there are {', '.join(map(str, found.data_vars))}")
    if found[name].attrs.get("quantity") != kind:
        raise QuestionError(f"{place}: channel {name!r} is a {found[name].attrs.get('quantity')}, not a {kind}")
    values = np.asarray(found[name].values, float)
    for extreme in (values.max(), values.min()):
        if np.mean(values == extreme) > CLIPPED and np.ptp(values) > 0.0:
            at = float(found["time"].values[int(np.argmax(values == extreme))])
            raise QuestionError(
                f"{place}: channel {name!r} is clipped at {extreme:.4g}, first at {at:.4g} s; take a wider range"
            )
    return values


def _frequency(t: Floats, x: Floats, place: str) -> float:
    """Where the deflection has its greatest line, rad/s."""
    from scipy.optimize import minimize_scalar

    step = float(t[1] - t[0])
    window = np.hanning(t.size) * (x - x.mean())
    size = np.abs(np.fft.rfft(window, 4 * t.size))
    lines = 2.0 * np.pi * np.fft.rfftfreq(4 * t.size, step)
    top = int(np.argmax(size[4:])) + 4  # not the drift
    if not size[top] > 0.0:
        raise QuestionError(f"{place}: the deflection does not move")
    found = minimize_scalar(
        lambda w: -abs(np.sum(window * np.exp(-1j * w * t))),
        bounds=(lines[top - 2], lines[min(top + 2, lines.size - 1)]),
        method="bounded",
    )
    return float(found.x)


def _periods(t: Floats, x: Floats, f: Floats, w: float) -> tuple[Floats, Complexes, Complexes]:
    """Start of each whole period, and first harmonics of deflection and force in it, with a mean of their own."""
    period = 2.0 * np.pi / w
    count = int((t[-1] - t[0]) / period * (1.0 + 1e-9))
    starts = t[0] + period * np.arange(count)
    both = np.empty((2, count), complex)
    for n, start in enumerate(starts):
        inside = (t >= start - 1e-9 * period) & (t < start + period * (1.0 - 1e-9))
        at = t[inside]
        rows = np.column_stack([np.cos(w * at), np.sin(w * at), np.ones(at.size)])  # a trend would take harmonics in
        for k, values in enumerate((x, f)):
            c, s, _ = np.linalg.lstsq(rows, values[inside], rcond=None)[0]
            both[k, n] = complex(c, -s)
    return starts, both[0], both[1]


def _advance(moved: Complexes, loops: list[slice]) -> float:
    """How far the deflection gets ahead of the frequency in a period, rad."""
    parts = [moved[part] for part in loops]
    return float(np.angle(sum((part[1:] * part[:-1].conj()).sum() / np.abs(part).mean() ** 2 for part in parts)))


def _loops(size: Floats) -> list[slice]:
    """Neighboring periods of equal amplitude, without the first of each row."""
    found, first = [], 0
    for n in range(1, size.size + 1):
        if n < size.size and abs(size[n] - np.median(size[first:n])) <= ALIKE * np.median(size[first:n]):
            continue
        if n - first >= PERIODS:
            found.append(slice(first + 1, n))
        first = n
    return found


def _loop(
    w: float, starts: Floats, moved: Complexes, pushed: Complexes, calibration: float, place: str
) -> tuple[float, float, float, float, float, str]:
    each = pushed / moved
    mean = complex(pushed @ moved.conj() / (moved @ moved.conj()).real)
    scatter = (each - mean) / np.sqrt(max(1, each.size - 1) * each.size)
    stiff_sure = float(np.hypot(np.linalg.norm(scatter.real), calibration * abs(mean)))
    loss_sure = float(np.hypot(np.linalg.norm(scatter.imag), calibration * abs(mean)))
    amplitude = float(np.sqrt(np.mean(np.abs(moved) ** 2)))
    until, what = starts[-1] + 2.0 * np.pi / w, f"{w / (2.0 * np.pi):.4g} Hz, {1e3 * amplitude:.4g} mm"
    name = f"{place}, {starts[0]:.3g} to {until:.3g} s ({what})"
    if mean.imag < -3.0 * loss_sure or mean.real <= 0.0:
        raise QuestionError(
            f"{name}: stiffness {mean.real:.4g} and loss {mean.imag:.4g} N/m; rubber pushes back and takes energy. Check "
            "the sign of the force, "
            "and the delay between both channels"
        )
    return amplitude, mean.real, stiff_sure, max(mean.imag, 1e-3 * loss_sure), loss_sure, name


# A hysteresis loop from recorded deflection and force.


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
