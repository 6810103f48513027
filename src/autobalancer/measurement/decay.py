"""Frequency and decay rate of a motion that was left to itself."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.linalg import lstsq
from scipy.ndimage import uniform_filter1d
from scipy.optimize import least_squares

from autobalancer.errors import QuestionError, RangeWarning, warn
from autobalancer.results.answers.answer import Labeled
from autobalancer.results.provenance import provenance

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
PARTS, SPARE = (1, 2, 4), (1, 3)  # beginnings of the signal; poles more than asked, one for what the mean leaves
MOST, WIDEST = 1200, 300  # samples and columns of the matrix of which the first guess is made
PLAIN = 5.0  # standard deviations of its amplitude by which a mode must stand out of the noise
BINS = 12  # on each side of a frequency, from which the noise there is judged
OUTLIER = 3.0  # from how many standard deviations of the scatter on a sample counts less


def decay_rate(
    time: Sequence[float] | Floats, signal: Sequence[float] | Floats, modes: int = 1, *, robust: bool = True
) -> xr.Dataset:
    """Fit decaying oscillations, offset + sum a e^(-d t) cos(w t + phase), to a measured decay.

    Parameters
    ----------
    time
        Of the samples, s, ascending at equal steps.
    signal
        Deflection, velocity or acceleration, in any unit.
    modes
        Number of oscillations.
    robust
        Whether outliers are given less weight (soft L1 loss).

    Returns
    -------
    xarray.Dataset
        Over ``mode``, the strongest first: ``frequency`` (w, damped, rad/s), ``decay_rate`` (d, 1/s), ``damping_ratio``,
        ``logarithmic_decrement`` (2 pi d / w), ``amplitude`` and ``phase`` (rad) at the first sample, and
        ``frequency_uncertainty``, ``decay_rate_uncertainty``, ``damping_ratio_uncertainty``, ``amplitude_uncertainty``,
        ``phase_uncertainty`` (standard deviations from the scatter); over ``time``: ``signal`` and ``fitted``. ``attrs``:
        ``offset``, ``scatter`` (standard deviation), ``warnings`` (modes that are hardly more than noise).

    Raises
    ------
    QuestionError
        If the samples are too few, not finite or not at equal steps, or hold no such oscillation.
    """
    t, y = np.asarray(time, np.float64), np.asarray(signal, np.float64)
    if isinstance(modes, bool) or not isinstance(modes, (int, np.integer)) or modes < 1:
        raise QuestionError(f"decay_rate: modes: given {modes!r}; must be a whole number from 1")
    least = 8 * modes + 8
    if t.ndim != 1 or t.shape != y.shape or t.size < least:
        raise QuestionError(
            f"decay_rate: given {t.size} times and {y.size} values; give the same number of both, at least {least}"
        )
    if not (np.isfinite(t).all() and np.isfinite(y).all()):
        raise QuestionError(
            "decay_rate: a time or value is not finite; leave such samples out at the ends, or fill them"
        )
    steps = np.diff(t)
    if not steps[0] > 0.0 or np.abs(steps - steps.mean()).max() > 1e-3 * steps.mean():
        raise QuestionError("decay_rate: times must ascend at equal steps; interpolate the signal first")
    clock = t - t[0]
    size = float(np.ptp(y))
    if size == 0.0:
        raise QuestionError("decay_rate: the signal is constant; there is nothing to fit")
    start = _poles(y / size, clock, modes)
    refined = _refined(y / size, clock, start, robust)
    return _dataset(t, y, clock, size, refined)


def _poles(y: Floats, clock: Floats, modes: int) -> Complexes:
    """First guess: of pencils of the whole signal and of shorter beginnings, where fast decays are not yet noise, the best."""
    thin = max(1, int(np.ceil(y.size / MOST)))
    while thin > 1 and _highest(y, clock) > 0.4 * np.pi / (thin * (clock[1] - clock[0])):
        thin //= 2
    y, step = y[::thin][:MOST], thin * float(clock[1] - clock[0])
    y = y - y.mean()
    times = np.asarray(np.arange(y.size) * step, np.float64)
    whole = _pencil(y, step, modes, 1)
    pencils = [whole]
    if modes > 1 and whole.size:
        sizes = [(y.size // part, more) for part in PARTS for more in SPARE]
        pencils += [_pencil(y[:size], step, modes, more) for size, more in sizes if size > 16 * modes]
    guesses = [poles for poles in pencils if poles.size == modes]
    if not guesses:
        raise QuestionError(
            f"decay_rate: the signal holds {whole.size} oscillations, not {modes}; ask for fewer, or give a longer piece"
        )
    left = [np.linalg.norm(y - design @ lstsq(design, y)[0]) for design in (_design(times, guess) for guess in guesses)]
    return guesses[int(np.argmin(left))]


def _pencil(y: Floats, step: float, modes: int, more: int) -> Complexes:
    """The strongest poles of the upper half plane by the matrix pencil (Hua and Sarkar 1990), of so many ``more`` than asked."""
    columns = max(2 * modes + 2, min(y.size // 3, WIDEST))
    rows = np.lib.stride_tricks.sliding_window_view(y, columns)
    order = min(2 * modes + more, columns - 1)
    basis = np.linalg.eigh(rows.T @ rows)[1][:, -order:]
    roots = np.linalg.eigvals(np.linalg.pinv(basis[:-1]) @ basis[1:])
    poles = np.log(roots[np.abs(roots) > 0.0].astype(np.complex128)) / step
    poles = poles[(poles.imag > 1e-6 / (y.size * step)) & (poles.imag < 0.999 * np.pi / step)]
    poles = np.minimum(poles.real, -1e-9) + 1j * poles.imag
    design = _design(np.asarray(np.arange(y.size) * step, np.float64), poles)
    parts = lstsq(design, y)[0]
    strength = np.hypot(parts[1::2], parts[2::2])
    return np.asarray(poles[np.argsort(-strength)][:modes])


def _highest(y: Floats, clock: Floats) -> float:
    """The highest frequency with a tenth of the largest line, rad/s."""
    lines = np.abs(np.fft.rfft(y - y.mean()))
    frequency = 2.0 * np.pi * np.fft.rfftfreq(y.size, float(clock[1] - clock[0]))
    return float(frequency[np.flatnonzero(lines > 0.1 * lines.max())[-1]])


def _design(clock: Floats, poles: Complexes) -> Floats:
    """Offset, and two quadratures of each oscillation: (samples, 1 + 2 modes)."""
    waves = np.exp(np.outer(clock, poles))
    columns = [np.ones_like(clock)]
    for wave in waves.T:
        columns += [wave.real, -wave.imag]
    return np.array(columns).T


def _refined(y: Floats, clock: Floats, start: Complexes, robust: bool) -> tuple[Floats, Floats, Floats]:
    """Unknowns [offset, (real, imaginary amplitude), (decay, frequency)...], their deviations, the residuals."""
    count = start.size
    linear = lstsq(_design(clock, start), y)[0]
    begin = np.concatenate([linear, -start.real, start.imag])

    def poles(u: Floats) -> Complexes:
        return np.asarray(-u[1 + 2 * count : 1 + 3 * count] + 1j * u[1 + 3 * count :])

    def residuals(u: Floats) -> Floats:
        return np.asarray(_design(clock, poles(u)) @ u[: 1 + 2 * count] - y)

    def jacobian(u: Floats) -> Floats:
        design = _design(clock, poles(u))
        waves = (u[1 : 1 + 2 * count : 2] + 1j * u[2 : 2 + 2 * count : 2]) * np.exp(np.outer(clock, poles(u)))
        moving = clock[:, None] * waves
        return np.hstack([design, -moving.real, -moving.imag])

    how = {"jac": jacobian, "x_scale": "jac", "method": "trf", "xtol": 1e-15, "ftol": 1e-15, "gtol": 1e-15}
    result = least_squares(residuals, begin, max_nfev=200, **how)
    weight = np.ones_like(y)
    if robust:
        spread = 1.4826 * float(np.median(np.abs(result.fun - np.median(result.fun))))
        if spread > 1e-13:
            result = least_squares(residuals, result.x, loss="soft_l1", f_scale=OUTLIER * spread, max_nfev=200, **how)
            weight = (1.0 + (result.fun / (OUTLIER * spread)) ** 2) ** -0.5
    u = np.asarray(result.x)
    scaled = np.sqrt(weight)[:, None] * jacobian(u)
    variance = float((weight * result.fun**2).sum() / (y.size - u.size))
    norm = np.linalg.norm(scaled, axis=0)
    inverse = np.linalg.pinv((scaled / norm).T @ (scaled / norm))
    own = np.maximum(np.diag(inverse), 0.0) * variance
    takes = (inverse @ (scaled / norm).T) * np.sqrt(weight)  # of each sample, (unknown, sample)
    lines = np.abs(np.fft.rfft(takes, 2 * y.size, axis=1)) ** 2
    power = np.abs(np.fft.rfft(np.where(weight > 0.5, result.fun, 0.0) * np.hanning(y.size), 2 * y.size)) ** 2
    power /= float((np.hanning(y.size) ** 2).sum())
    near = 2 * BINS + 1  # lines of the spectrum, of which the mean is the noise there
    smooth = uniform_filter1d(power, near, mode="nearest")
    colored = (lines * smooth).sum(axis=1) / y.size
    return u, np.asarray(np.sqrt(np.maximum(own, colored)) / norm), np.asarray(result.fun)


def _dataset(t: Floats, y: Floats, clock: Floats, size: float, found: tuple[Floats, Floats, Floats]) -> xr.Dataset:
    u, spread, residuals = found
    count = (u.size - 1) // 4
    parts = u[1 : 1 + 2 * count : 2] + 1j * u[2 : 2 + 2 * count : 2]
    order = np.argsort(-np.abs(parts))
    decay, frequency = u[1 + 2 * count : 1 + 3 * count], u[1 + 3 * count :]
    decay_spread, frequency_spread = spread[1 + 2 * count : 1 + 3 * count], spread[1 + 3 * count :]
    of_parts = np.hypot(parts.real * spread[1 : 1 + 2 * count : 2], parts.imag * spread[2 : 2 + 2 * count : 2])
    of_parts = of_parts / np.maximum(np.abs(parts), 1e-300)
    natural = np.hypot(decay, frequency)
    entries = {
        "frequency": (frequency, "natural frequency, damped", "rad/s"),
        "decay_rate": (decay, "decay rate", "1/s"),
        "damping_ratio": (decay / natural, "damping ratio", ""),
        "logarithmic_decrement": (2.0 * np.pi * decay / frequency, "logarithmic decrement", ""),
        "amplitude": (size * np.abs(parts), "amplitude at the first sample", ""),
        "phase": (np.angle(parts), "phase at the first sample", "rad"),
        "frequency_uncertainty": (frequency_spread, "standard uncertainty of the frequency", "rad/s"),
        "decay_rate_uncertainty": (decay_spread, "standard uncertainty of the decay rate", "1/s"),
        "damping_ratio_uncertainty": (
            np.hypot(decay_spread * frequency, decay * frequency_spread) * frequency / natural**3,
            "standard uncertainty of the damping ratio",
            "",
        ),
        "amplitude_uncertainty": (size * of_parts, "standard uncertainty of the amplitude", ""),
        "phase_uncertainty": (
            np.minimum(of_parts / np.maximum(np.abs(parts), 1e-300), np.pi / np.sqrt(3.0)),
            "standard uncertainty of the phase",
            "rad",
        ),
    }
    result = xr.Dataset(coords={"mode": ("mode", np.arange(1, count + 1)), "time": ("time", t, {"units": "s"})})
    for key, (numbers, text, unit) in entries.items():
        result[key] = ("mode", np.asarray(numbers)[order], {"long_name": text, "units": unit})
    result["signal"] = ("time", y, {"long_name": "measured"})
    result["fitted"] = ("time", y + size * residuals, {"long_name": "fitted"})
    doubts = _doubts(result)
    for text in doubts:
        warn(text, RangeWarning)
    result.attrs = {
        "title": "Decay of a free motion",
        **provenance(),
        "offset": float(size * u[0]),
        "scatter": float(size * np.sqrt((residuals**2).sum() / (y.size - u.size))),
        "warnings": "\n".join(doubts),
    }
    return Labeled.of(result)


def _doubts(dataset: xr.Dataset) -> list[str]:
    """Modes that are hardly more than noise."""
    size, sure = dataset["amplitude"].values, dataset["amplitude_uncertainty"].values
    return [
        f"mode {k + 1} at {dataset['frequency'].values[k] / (2.0 * np.pi):.4g} Hz is hardly more than noise: its amplitude is "
        "only "
        f"{size[k] / sure[k]:.2g} times its standard deviation; ask for fewer modes"
        for k in np.flatnonzero(size < PLAIN * sure)
    ]
