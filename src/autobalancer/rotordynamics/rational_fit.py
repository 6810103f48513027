"""From a measured receptance to poles and residues: AAA proposes, least squares refines, the noise sets the order."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.interpolate import AAA
from scipy.linalg import lstsq
from scipy.optimize import least_squares

from autobalancer.arrays import Complexes, Floats
from autobalancer.errors import QuestionError, one_of
from autobalancer.progress import Progress, shows_progress
from autobalancer.results.answers.answer import Answer, provenance
from autobalancer.rotordynamics.receptances import hertz
from autobalancer.units import ends_argument

# A receptance as a sum of modes, stable and of relative degree two by construction, fitted by least squares.
#
# H(sigma) = sum (a_k + b_k sigma)/(sigma^2 + d_k sigma + e_k), d_k, e_k > 0, sum b_k = 0. The a, b follow linearly
# from the d, e, so only these are searched for (variable projection, Golub and Pereyra 1973).


ROWS = 256  # of a matrix that one thread factorizes
SINGULAR = 1e-13  # of the greatest singular value: what is below it is none


@dataclass(frozen=True)
class Modes:
    """K modes in scaled units, and how far they are from the data."""

    shapes: Floats  # (2 K,) ln d, ln e
    numerators: Floats  # (K, 2) a, b
    misfit: float  # weighted sum of squares

    @property
    def count(self) -> int:
        """K."""
        return int(self.shapes.size // 2)

    def poles_and_residues(self) -> tuple[Complexes, Complexes]:
        """All 2 K poles and residues, a conjugate or real pair for each mode."""
        d, e = np.exp(self.shapes).reshape(2, -1)
        root = np.sqrt((0.25 * d**2 - e).astype(np.complex128))
        root = np.where(np.abs(root) < 1e-9 * np.sqrt(e), 1e-9 * np.sqrt(e), root)  # no double poles
        up, down = -0.5 * d + root, -0.5 * d - root
        a, b = self.numerators.T
        residue_up, residue_down = (a + b * up) / (up - down), (a + b * down) / (down - up)
        return np.concatenate([up, down]), np.concatenate([residue_up, residue_down])

    def at(self, frequency: Floats) -> Complexes:
        """The receptance at i frequency."""
        return np.asarray(self.parts(frequency).sum(axis=1), np.complex128)

    def parts(self, frequency: Floats) -> Complexes:
        """The part of each mode in it, shape (n, K)."""
        d, e = np.exp(self.shapes).reshape(2, -1)
        sigma = 1j * frequency[:, None]
        a, b = self.numerators.T
        return np.asarray((a + b * sigma) / (sigma**2 + d * sigma + e), np.complex128)

    def slopes(self, frequency: Floats) -> Complexes:
        """The derivatives of the receptance over ln d, ln e, a and all b but the last, shape (n, 4 K - 1)."""
        d, e = np.exp(self.shapes).reshape(2, -1)
        sigma = 1j * frequency[:, None]
        a, b = self.numerators.T
        share = 1.0 / (sigma**2 + d * sigma + e)
        change = -(a + b * sigma) * share**2
        moved = sigma * share
        return np.hstack([change * d * sigma, change * e, share, moved[:, :-1] - moved[:, -1:]])

    def taken(self, frequency: Floats, variance: Floats) -> Floats:
        """The share of each value that these parameters take up, the leverage of its line, from 0 to 1."""
        slopes = _stack(self.slopes(frequency) / np.sqrt(variance)[:, None])
        slopes /= np.linalg.norm(slopes, axis=0)
        _, sizes, right = np.linalg.svd(_triangle(slopes))
        q = slopes @ (right[sizes > SINGULAR * sizes[0]].T / sizes[sizes > SINGULAR * sizes[0]])
        return np.asarray(0.5 * (q**2).sum(axis=1).reshape(2, -1).sum(axis=0))


class Fitting:
    """Data to be fitted: complex values at sigma = i frequency, weighted."""

    def __init__(self, frequency: Floats, values: Complexes, weights: Floats) -> None:
        self.sigma, self.weights = 1j * frequency, weights
        self.target = _stack(weights * values)
        self.known: tuple[Floats, tuple[Floats, Floats, Floats]] | None = None  # residuals and slopes are asked in turn

    def numerators(self, shapes: Floats) -> tuple[Floats, Floats, Floats]:
        """Best a, b for given d, e; the residuals; and their slopes over ln d, ln e (Kaufman 1975).

        Residuals and slopes are those of all lines, turned into few rows, which changes no sum of squares: the triangle of
        one QR of base functions, what their slopes add to these, and target has all of it.
        """
        if self.known is not None and np.array_equal(self.known[0], shapes):
            return self.known[1]
        k, sigma = shapes.size // 2, self.sigma[:, None]
        d, e = np.exp(shapes).reshape(2, -1)
        share = 1.0 / (sigma**2 + d * sigma + e)
        base = self.weights[:, None] * share
        slope = base * sigma
        matrix = _stack(np.hstack([base, slope[:, :-1] - slope[:, -1:], base * share, slope * share]))
        size = np.linalg.norm(matrix, axis=0)
        triangle, m = _triangle(np.column_stack([matrix / size, self.target])), 2 * k - 1
        solution = lstsq(triangle[:m, :m], triangle[:m, -1], cond=SINGULAR)[0] / size[:m]
        a, b = solution[:k], np.append(solution[k:], -solution[k:].sum())
        left = triangle[:, :m] @ (solution * size[:m]) - triangle[:, -1]
        once, moved = np.split(triangle[:, m:-1] * size[m:], 2, axis=1)  # over share^2 and sigma share^2
        once[:m] = moved[:m] = 0.0  # what the best a, b follow; sigma^2 share^2 = share - d sigma share^2 - e share^2
        slopes = np.hstack([-d * ((a - b * d) * moved - b * e * once), -e * (a * once + b * moved)])
        answer = np.column_stack([a, b]), left, slopes
        self.known = shapes.copy(), answer
        return answer

    def search(self, starts: list[Complexes]) -> Modes:
        """The modes nearest to the data; from each start (poles, one of each pair) a few steps, from the best all."""
        tried = [self.refined(_shapes(poles), 12, 1e-6) for poles in starts]
        return self.refined(min(tried, key=lambda modes: modes.misfit).shapes)

    def refined(self, start: Floats, steps: int = 60, tolerance: float = 1e-13) -> Modes:
        """The modes nearest to the data, from shapes that are near."""
        # ln d, ln e: frequencies within a hundred times the band, and what damping cannot be told from none
        ones, far = np.ones(start.size // 2), math.log(100.0)
        first, last = math.log(np.abs(self.sigma).min()), math.log(np.abs(self.sigma).max())
        low = np.concatenate([(first - 25.0) * ones, 2.0 * (first - far) * ones])
        high = np.concatenate([(last + 2.0 * far) * ones, 2.0 * (last + far) * ones])
        solution = least_squares(
            lambda x: self.numerators(x)[1],
            np.clip(start, low + 1e-6, high - 1e-6),
            jac=lambda x: self.numerators(x)[2],
            bounds=(low, high),
            xtol=tolerance,
            ftol=tolerance,
            gtol=1e-15,
            max_nfev=steps,
        )
        numerators, miss, _ = self.numerators(solution.x)
        return Modes(solution.x, numerators, float(miss @ miss))


def _stack(values: Complexes) -> Floats:
    return np.concatenate([values.real, values.imag])


def _triangle(matrix: Floats) -> Floats:
    """R of the QR of a tall matrix, by some hundred rows: of more, libraries make threads that wait for each other."""
    rows, columns = matrix.shape
    tall = max(ROWS, 4 * columns)
    if rows > tall:
        whole = np.concatenate([matrix, np.zeros((-rows % tall, columns))]).reshape(-1, tall, columns)
        return _triangle(np.asarray(np.linalg.qr(whole, mode="r")).reshape(-1, columns))
    return np.asarray(np.linalg.qr(matrix, mode="r"))


def _shapes(poles: Complexes) -> Floats:
    return np.concatenate([np.log(np.maximum(-2.0 * poles.real, 1e-12)), np.log(np.maximum(np.abs(poles), 1e-12) ** 2)])


FEWEST = 8  # values that a fit needs
ROUNDING = 1e-6  # so that a line at an end of the band is in it


@shows_progress
def receptance(
    measured: xr.Dataset,
    *,
    modes: int | None = None,
    most_modes: int = 8,
    noise: Noise = "estimated",
    band: tuple[float | str, float | str] | None = None,
    progress: Callable[[float, float], None] | bool | None = None,
) -> xr.Dataset:
    """Fit poles and residues of a stable, real system with inertia to a measured receptance.

    The AAA algorithm (Nakatsukasa, Sete and Trefethen 2018) proposes poles; they are folded into conjugate pairs and to
    the stable side, and those that contribute least are dropped, among them the doublets of noise. Poles and residues
    are then refined together by least squares under the condition that the receptance falls with the square of the
    frequency, as that of every body with mass does. Each value has the weight that its noise leaves it: fit and noise
    are found in turn. The number of modes is that with the least Bayesian information criterion (Schwarz 1978).

    Parameters
    ----------
    measured
        From :func:`load_receptance`. Of several places the poles are first those of the sum over the driving points, then modes
        damped each by itself, with a shape over the places, are fitted to all that was measured.
    modes
        Number of modes, or of different poles where there are several places; by default chosen by the noise.
    most_modes
        Greatest number of modes that is tried.
    noise
        *estimated*: a share of the value, a floor, and parts that grow towards low frequencies, as acceleration
        gives; their sizes come from the data. *relative*: a share of the value; *absolute*: the same everywhere. A
        coherence in the data is used with each: variance in proportion to (1 - coherence)/coherence.
    band
        Lowest and highest frequency that are used, rad/s or as texts such as ``("5 Hz", "200 Hz")``; by default all.
    progress
        By default a bar where a person is looking and it takes more than a second; False: none; or a function of
        (done, all).

    Returns
    -------
    xarray.Dataset
        Along ``pole``: its real and imaginary part (1/s) and that of its residue (m/(N s)). Along ``mode``, ascending:
        ``mode_frequency`` (rad/s, undamped), ``mode_damping_ratio`` and ``mode_mass`` (kg, at the race), and the standard
        deviation of each as ``..._deviation``. Along ``frequency``: what was measured and what was fitted, the noise
        (``noise_deviation``, m/N) and whether the value was ``used``. ``attrs``: ``fit_error`` (root mean square
        as a share of the values, weighted by the noise), ``modes``, ``effective_mass`` (kg, at high frequency),
        ``band_low`` and ``band_high`` (rad/s), ``warnings``. Of several places it has ``mode_frequency``,
        ``mode_damping_ratio`` and ``mode_shape`` (mode, place), 1/sqrt(kg), and ``fitted_real`` and ``fitted_imag`` of each pair.

    Raises
    ------
    QuestionError
        If there are too few values, or they are not those of a driving point in the convention e^(+i w t).
    """
    if "pair" in measured.dims:
        about = {"modes": modes, "most_modes": most_modes, "noise": noise, "band": band}
        return _between_places(measured, **about, progress=progress if callable(progress) else False)
    every = np.asarray(measured["frequency"].values, np.float64)
    used = _used(every, band)
    part = measured.isel(frequency=np.flatnonzero(used))
    frequency, values = every[used], receptance_of(part)
    unit, size = math.sqrt(frequency[0] * frequency[-1]), float(np.abs(values).max())
    coherence = np.asarray(part["coherence"].values, np.float64) if "coherence" in part else None
    described = NoiseShapes(noise, frequency / unit, values / size, coherence)
    # the values, weighted by their noise, must not be those of a force that feeds energy
    if float((np.abs(described.values) * described.values.imag / described.start).sum()) > 0.0:
        raise QuestionError(
            "receptance: its imaginary part is positive, so the force would draw energy from the rotor; "
            "turn the sign of the force, or take the complex conjugate if the file uses e^(-i w t)"
        )
    best, kept, dropped = sure_modes(described, modes, most_modes, progress if callable(progress) else None)
    lone = np.zeros_like(used)
    lone[np.flatnonzero(used)[~kept]] = True
    dataset = fit_dataset(measured, used & ~lone, best, unit, size, noise)
    return with_doubts(dataset, best, unit, every[lone], [unit * frequency for frequency in dropped])


def receptance_of(measured: xr.Dataset) -> Complexes:
    """The measured values, m/N."""
    return np.asarray(measured["receptance_real"].values + 1j * measured["receptance_imag"].values, np.complex128)


def modes_of(fit: xr.Dataset) -> list[tuple[float, float]]:
    """Frequency (rad/s, undamped) and damping ratio of each pair of poles of ``fit``, ascending."""
    pairs = zip(fit["mode_frequency"].values, fit["mode_damping_ratio"].values, strict=True)
    return [(float(frequency), float(ratio)) for frequency, ratio in pairs]


def _used(frequency: Floats, band: tuple[float | str, float | str] | None) -> NDArray[np.bool_]:
    used = np.ones(frequency.size, np.bool_)
    words = ""
    if band is not None:
        low, high = ends_argument("band", band, "rad/s")
        if not 0.0 <= low < high:
            raise QuestionError(f"band: given {low:g} to {high:g} rad/s; must ascend from zero or above")
        used = (frequency >= low * (1.0 - ROUNDING)) & (frequency <= high * (1.0 + ROUNDING))
        words = f" in the band; it is measured from {hertz(frequency[0])} to {hertz(frequency[-1])} Hz"
    if used.sum() < FEWEST:
        raise QuestionError(f"receptance: {used.sum()} values are too few for a fit; give {FEWEST} or more{words}")
    return used


# Receptances between several places: poles of the sum over the driving points, residues of all pairs, their shapes, then
# frequencies, damping ratios and shapes refined together. A pole of two modes, as round rotors have, has two shapes.


SHAPES = 0.02  # share of the greatest shape of a pole, below which another one is noise


def _between_places(measured: xr.Dataset, **about: Any) -> xr.Dataset:
    places = sorted({*measured["response"].values.tolist(), *measured["force"].values.tolist()})
    ends = np.array([[places.index(str(one)) for one in measured[name].values] for name in ("response", "force")])
    driving = np.flatnonzero(ends[0] == ends[1])
    lost = next((place for number, place in enumerate(places) if number not in ends), None)
    if not driving.size or lost:
        raise QuestionError("receptance: no pair has response and force at one place; measure a driving point")
    part = [f"receptance_{name}" for name in ("real", "imag")]
    whole = measured[part].isel(pair=driving).sum("pair").assign_attrs(measured.attrs)
    poles = receptance(whole, **about)
    used = np.flatnonzero(poles["used"].values)
    frequency = np.asarray(measured["frequency"].values, np.float64)
    values, weights = receptance_of(measured)[:, used], 1.0 / poles["noise_deviation"].values[used]

    def share(own: Floats, ratio: Floats, at: Floats) -> Complexes:
        return np.asarray(1.0 / (own**2 - at[:, None] ** 2 + 2j * ratio * own * at[:, None]), np.complex128)

    # residues of all pairs, and the shapes that they are made of
    found = np.array([poles["mode_frequency"].values, poles["mode_damping_ratio"].values])
    matrix = _stack(share(found[0], found[1], frequency[used]) * weights[:, None])
    residues = lstsq(matrix, np.concatenate([(values * weights).real, (values * weights).imag], axis=1).T)[0]
    shapes: list[tuple[float, float, Floats]] = []
    for (own, ratio), residue in zip(found.T, residues, strict=True):
        square = np.full((len(places), len(places)), np.nan)
        square[ends[0], ends[1]] = square[ends[1], ends[0]] = residue
        if np.isfinite(square).all():
            sizes, vectors = np.linalg.eigh(square)
            kept = sizes > SHAPES * np.abs(sizes).max()
            shapes += [(own, ratio, shape) for shape in (vectors * np.sqrt(np.abs(sizes))).T[kept]]
            continue
        column = next((j for j in range(len(places)) if np.isfinite(square[:, j]).all() and square[j, j] > 0.0), None)
        if column is None:
            raise QuestionError(
                "receptance: measure all pairs of places, or from one place, with its driving point, to all others; "
                f"there are {', '.join(places)}"
            )
        shapes.append((own, ratio, square[:, column] / np.sqrt(square[column, column])))
    count = len(shapes)
    start = np.concatenate(
        [np.log([s[0] for s in shapes]), np.log([max(s[1], 1e-9) for s in shapes]), *(s[2] for s in shapes)]
    )

    def fitted(parameters: Floats, at: Floats) -> Complexes:
        shape = parameters[2 * count :].reshape(count, -1)
        parts = share(np.exp(parameters[:count]), np.exp(parameters[count : 2 * count]), at)
        return np.asarray((parts @ (shape[:, ends[0]] * shape[:, ends[1]])).T)

    def left(parameters: Floats) -> Floats:
        return _stack(((fitted(parameters, frequency[used]) - values) * weights).ravel())

    best = least_squares(left, start, x_scale="jac").x
    error = math.sqrt(float((left(best) ** 2).sum() / (np.abs(values * weights) ** 2).sum()))
    order = np.argsort(best[:count])
    own, ratio = np.exp(best[: 2 * count]).reshape(2, -1)[:, order]
    shape = best[2 * count :].reshape(count, -1)[order]
    curve = fitted(best, frequency)
    dataset = measured.assign(
        mode_frequency=("mode", own, {"units": "rad/s"}), mode_damping_ratio=("mode", ratio, {"units": ""}),
        mode_shape=(("mode", "place"), shape, {"units": "1/sqrt(kg)"}),
        fitted_real=(("pair", "frequency"), curve.real, {"units": "m/N"}),
        fitted_imag=(("pair", "frequency"), curve.imag, {"units": "m/N"}),
    ).assign_coords(place=places)  # fmt: skip
    kept = {name: poles.attrs[name] for name in ("band_low", "band_high", "noise", "warnings")}
    return dataset.assign_attrs({**measured.attrs, **provenance(), **kept, "modes": count, "fit_error": error})


# The labelled outcome of a fit: poles, modes with their uncertainty, and the noise.


def fit_dataset(
    measured: xr.Dataset, used: NDArray[np.bool_], best: FittedModes, unit: float, size: float, noise: Noise
) -> xr.Dataset:
    """See :func:`~.rational_fit.receptance`; ``best`` in frequencies and values so scaled."""
    frequency = np.asarray(measured["frequency"].values, np.float64)
    scaled = frequency / unit
    poles, residues = best.modes.poles_and_residues()
    poles, residues = unit * poles, unit * size * residues
    fitted = size * best.modes.at(scaled)
    deviation = np.full(frequency.size, math.nan)
    deviation[used] = size * np.sqrt(best.variance)
    dataset = measured.copy()
    values = receptance_of(measured)[used]
    # root mean square of what is left as a share of the values, each line with the weight of its noise
    left, whole = ((np.abs(part) ** 2 / best.variance).sum() for part in (values - fitted[used], fitted[used]))
    error = math.sqrt(float(left / whole))
    lightness = float((residues * poles).sum().real)
    over_frequency = {
        "fitted_real": (fitted.real, "fitted receptance, real part", "m/N"),
        "fitted_imag": (fitted.imag, "fitted receptance, imaginary part", "m/N"),
        "noise_deviation": (deviation, "standard deviation of the noise", "m/N"),
        "used": (used.astype("int8"), "whether the value was used in the fit", ""),
    }
    for name, (part, text, sign) in over_frequency.items():
        dataset[name] = ("frequency", part, {"long_name": text, "units": sign})
    for name, both, sign in (("pole", poles, "1/s"), ("residue", residues, "m/(N s)")):
        dataset[f"{name}_real"] = ("pole", both.real, {"long_name": f"{name}, real part", "units": sign})
        dataset[f"{name}_imag"] = ("pole", both.imag, {"long_name": f"{name}, imaginary part", "units": sign})
    for name, part, text, sign in _mode_values(best.modes, covariance(best, scaled[used]), unit, size):
        dataset[name] = ("mode", part, {"long_name": text, "units": sign})
    dataset.attrs = {
        **measured.attrs,
        **provenance(),
        "fit_error": error,
        "noise": noise,
        "modes": best.modes.count,
        "effective_mass": 1.0 / lightness if lightness != 0.0 else math.inf,
        "band_low": float(frequency[used][0]),
        "band_high": float(frequency[used][-1]),
    }
    return dataset


def _mode_values(modes: Modes, spread: Floats, unit: float, size: float) -> list[tuple[str, Floats, str, str]]:
    """Frequency sqrt(e), damping ratio d/(2 sqrt(e)) and mass 1/a, ascending, each with its standard deviation."""
    k = modes.count
    d, e, a = np.exp(modes.shapes[:k]), np.exp(modes.shapes[k:]), modes.numerators[:, 0]
    order = np.argsort(e)
    own = np.arange(k)
    of_d, of_e, of_a = (np.maximum(np.diag(spread)[own + at], 0.0) for at in (0, k, 2 * k))
    both = spread[own, own + k]
    frequency, ratio, mass = unit * np.sqrt(e), 0.5 * d / np.sqrt(e), 1.0 / (size * unit**2 * a)
    rows = [
        ("frequency", frequency, 0.5 * frequency * np.sqrt(of_e), "undamped frequency", "rad/s"),
        ("damping_ratio", ratio, ratio * np.sqrt(np.maximum(of_d + 0.25 * of_e - both, 0.0)), "damping ratio", ""),
        ("mass", mass, np.abs(mass / a) * np.sqrt(of_a), "modal mass at the race", "kg"),
    ]
    result = []
    for name, values, deviation, text, sign in rows:
        result.append((f"mode_{name}", values[order], f"{text} of the mode", sign))
        result.append((f"mode_{name}_deviation", deviation[order], f"standard deviation of the {text}", sign))
    return result


# What must be doubted of a fit, and what to do about it.


SURE = 4.0  # standard deviations by which the fit must feed energy before it is said
LEAST = 3  # lines below their noise at an end of the band before it is said
WHAT_TO_DO = "look at the picture and try another number of modes (--modes) or a narrower band (--band)"


def with_doubts(dataset: xr.Dataset, best: FittedModes, unit: float, lone: Floats, dropped: list[float]) -> xr.Dataset:
    """``dataset`` with its ``warnings``, one sentence a line; ``lone`` and ``dropped`` are frequencies, rad/s."""
    low, high = dataset.attrs["band_low"], dataset.attrs["band_high"]
    texts, lines = [], np.asarray(dataset["frequency"].values[dataset["used"].values > 0], np.float64) / unit
    if not dataset.attrs["effective_mass"] > 0.0:
        texts.append(f"the fit has no positive mass at high frequency; measure to higher frequencies, or {WHAT_TO_DO}")
    # energy that the fit feeds in, more than its noise explains
    grid = np.linspace(low, high, 2000) / unit
    slopes = best.modes.slopes(grid)
    unsure = np.einsum("ij,jk,ik->i", slopes.imag, covariance(best, lines), slopes.imag)
    values = best.modes.at(grid)
    active = unit * grid[values.imag > np.maximum(SURE * np.sqrt(np.maximum(unsure, 0.0)), 1e-6 * np.abs(values))]
    if active.size:
        texts.append(
            f"the fit feeds energy between {hertz(active[0])} and {hertz(active[-1])} Hz, more than its noise explains, and no "
            f"rotor at rest does that: either there are too many modes or the lines there are bad ({WHAT_TO_DO}), "
            "or force and deflection are not at one place and along one direction"
        )
    # modes and lines that are none
    if weak := weak_modes(best, lines):
        places = _listed(unit * frequencies(best)[weak])
        texts.append(f"the fit at {places} Hz cannot be told from noise. Give fewer --modes")
    if lone.size:
        few = f"{_listed(lone[:4])} Hz" + (f" and {lone.size - 4} more" if lone.size > 4 else "")
        texts.append(
            f"left out as disturbed: {few}, where no mode but single lines stand out, as mains hum or a bad line does. "
            "If it is a mode, measure with a finer resolution, or give --modes"
        )
    if dropped:
        inside = [at for at in dropped if low <= at <= high]
        where = [f"at {_listed(inside)} Hz"] if inside else []
        where += [f"{len(dropped) - len(inside)} outside the band"] if len(inside) < len(dropped) else []
        texts.append(f"dropped: fitted modes that cannot be told from noise or drift, {' and '.join(where)}")
    texts += _noise_doubt(dataset)
    # modes outside the band, which are there to describe what reaches into it
    frequency = dataset["mode_frequency"].values
    outside = frequency[(frequency < low) | (frequency > high)]
    if outside.size:
        which = "a mode at {} Hz lies" if outside.size == 1 else "modes at {} Hz lie"
        texts.append(
            f"{which.format(_listed(outside))} outside the measured band: only what reaches into the band is known, so "
            "frequency and damping there are estimates"
        )
    dataset.attrs["warnings"] = "\n".join(texts)
    return Answer.of(dataset, "FittedReceptance")


def _noise_doubt(dataset: xr.Dataset) -> list[str]:
    """Where at the ends of the band the noise is greater than the value."""
    used = np.flatnonzero(dataset["used"].values)
    size = np.hypot(dataset["fitted_real"].values, dataset["fitted_imag"].values)
    hidden = dataset["noise_deviation"].values[used] > size[used]
    frequency = dataset["frequency"].values[used]
    if hidden.all() or not hidden.any():
        return []
    texts = []
    for word, run in (("below", 1), ("above", -1)):  # from either end of the band
        if hidden[::run][:LEAST].all():
            end = frequency[::run][int(np.argmin(hidden[::run]))]
            low, high = (hertz(at) for at in (end, frequency[::run][-1])[::run])
            why = ", as usual where acceleration was measured" if run > 0 else ""
            texts.append(
                f"{word} {hertz(end)} Hz the noise is greater than the receptance{why}; these lines have almost no weight. "
                f'--band "{low} Hz:{high} Hz" leaves them out'
            )
    return texts


def _listed(frequencies: list[float] | Floats) -> str:
    return ", ".join(hertz(value) for value in frequencies)


# Which fitted modes are modes: those that show in more than a few lines and stand out of the noise.


FEW = 3  # lines; a mode shows in more of them, a disturbance of one frequency does not, whatever the window
SAFE = 10.0  # standard deviations of its strength from which on a mode need not be tried to do without
CLEAR = 3.0  # standard deviations of its strength that a mode must exceed
# A line this far from the fit, as a log probability beyond that of the worst of all lines, is no noise: e^-9 = 1e-4
SURE_EVIDENCE = 9.0
NEAR = math.log(1.5)  # how far from its frequency a mode must stand out
ROUNDS = 6  # of leaving out lines and fitting anew; what is left after them stays in
DIGITS = 1e-12  # of the greatest value: the arithmetic of a fit leaves this of exact values, which is no disturbance
MOST = 0.05  # share of the lines that may be left out as disturbed


def sure_modes(
    noise: NoiseShapes, modes: int | None, most: int, progress: Progress | None
) -> tuple[FittedModes, NDArray[np.bool_], list[float]]:
    """The modes; which lines they were found from; and the frequencies of modes that were dropped.

    With a number of ``modes`` given, nothing is dropped.
    """
    kept = np.ones(noise.frequency.size, np.bool_)
    for _ in range(ROUNDS):
        part = noise.only(kept)
        order = best_order(part, modes, most, progress)
        lines = lone_lines(order, part) if modes is None else np.zeros(0, np.int64)
        if lines.size == 0 or (~kept).sum() + lines.size > max(FEW, MOST * kept.size):
            break
        kept[np.flatnonzero(kept)[lines]] = False
    order, dropped = (order, []) if modes is not None else without_weak(part, order)
    return order, kept, dropped


def without_weak(noise: NoiseShapes, found: FittedModes) -> tuple[FittedModes, list[float]]:
    """The fit without modes that the criterion or their own uncertainty is against; and where the latter were."""
    dropped: list[float] = []
    while found.modes.count > 1 and math.isfinite(found.score):
        weak = weak_modes(found, noise.frequency)
        doubted = {*weak, *np.flatnonzero(strengths(found, noise.frequency) < SAFE).tolist()}
        fewer = {i: fit_without(noise, found, i) for i in doubted}
        better = [i for i in fewer if fewer[i].score < found.score]
        if not (weak or better):
            break
        least = min(better or weak, key=lambda i: fewer[i].score)
        if least in weak:
            dropped.append(float(frequencies(found)[least]))
        found = fewer[least]
    return found, dropped


def lone_lines(found: FittedModes, noise: NoiseShapes) -> NDArray[np.int64]:
    """Lines that stand for themselves: far from the fit, or reached by modes fitted to no more than ``FEW`` of them."""
    fitted, parts = found.modes.at(noise.frequency), found.modes.parts(noise.frequency)
    left = np.abs(noise.values - fitted) ** 2
    variance = np.maximum(found.variance, (DIGITS * np.abs(noise.values).max()) ** 2)
    far = left / variance > math.log(noise.frequency.size) + SURE_EVIDENCE
    # runs of few lines; longer ones are something that is not yet fitted
    edges = np.flatnonzero(np.diff(np.concatenate([[0], far.astype(np.int8), [0]])))
    runs = [range(int(start), int(end)) for start, end in zip(edges[::2], edges[1::2], strict=True)]
    lone = [i for run in runs if len(run) <= FEW for i in run]
    for near in _groups(found, noise.frequency):
        part = parts[:, near].sum(axis=1)
        gain = (np.abs(noise.values - fitted + part) ** 2 - left) / variance
        strongest = np.argsort(gain)[::-1][:FEW]
        if gain.sum() - gain[strongest].sum() < cost(gain.size):
            lone += [int(i) for i in strongest if gain[i] > math.log(gain.size)]
    return np.unique(np.array(lone, np.int64))


def _groups(found: FittedModes, frequency: Floats) -> list[NDArray[np.int64]]:
    """Modes within the band, together where they are nearer than ``FEW`` lines: then they may cancel each other."""
    at = frequencies(found)
    inside = np.flatnonzero((at >= frequency[0]) & (at <= frequency[-1]))
    inside = inside[np.argsort(at[inside])]
    places = np.interp(at[inside], frequency, np.arange(frequency.size))
    return np.split(inside, np.flatnonzero(np.diff(places) > FEW) + 1) if inside.size else []


def weak_modes(found: FittedModes, frequency: Floats) -> list[int]:
    """Modes that cannot be told from noise or drift.

    Within the band: those whose strength at the race does not exceed its uncertainty clearly, or that do not stand out near
    their own frequency. Outside of it: those beyond an end where the noise is greater than the receptance. Below it also
    those that are overdamped or of no clear strength: above itself a mode acts as its mass alone, so that is well known.
    """
    at, unclear = frequencies(found), strengths(found, frequency) < CLEAR
    shares = np.abs(found.modes.parts(frequency)) ** 2 / found.variance[:, None]
    near = np.abs(np.log(frequency[:, None] / at)) < NEAR
    unseen = (shares * near).sum(axis=0) < cost(frequency.size)
    hidden = np.abs(found.modes.at(frequency)) ** 2 < found.variance
    below, above = at < frequency[0], at > frequency[-1]
    overdamped = np.exp(found.modes.shapes[: at.size]) > 2.0 * at
    weak = ~below & ~above & (unseen | unclear)
    weak |= below & (unclear | overdamped | hidden[:FEW].all())
    weak |= above & hidden[-FEW:].all()
    return [int(i) for i in np.flatnonzero(weak)]


def cost(lines: int) -> float:
    """What a mode must gain, in squares of deviations over the variance, for the criterion to be for it."""
    return 2.0 * math.log(2 * lines)


def strengths(found: FittedModes, frequency: Floats) -> Floats:
    """Of each mode at the race, one over its mass, in its standard deviations."""
    k = found.modes.count
    variance = np.diag(covariance(found, frequency))[2 * k : 3 * k]
    return np.asarray(np.abs(found.modes.numerators[:, 0]) / np.sqrt(np.maximum(variance, 1e-300)))


def frequencies(found: FittedModes) -> Floats:
    """Of the modes, undamped."""
    return np.asarray(np.exp(0.5 * found.modes.shapes[found.modes.count :]))


def covariance(found: FittedModes, frequency: Floats) -> Floats:
    """Of the parameters of :meth:`Modes.slopes`; the noise has half its variance in either part of a value."""
    stacked = _stack(found.modes.slopes(frequency) / np.sqrt(0.5 * found.variance)[:, None])
    size = np.linalg.norm(stacked, axis=0)
    inverse = np.linalg.pinv(_triangle(stacked / size))
    return np.asarray((inverse @ inverse.T) / np.outer(size, size))


# How many modes a receptance has, and where: AAA proposes poles, an information criterion chooses their number.


EXACT = 1e-9  # a root mean square deviation below this share of the values is no noise
PASSES = 6  # of fit and noise in turn
SETTLED = 0.02  # change of the noise below which another pass is not needed
WORSE = 2  # so many orders without a better score end the search
DAMPED = 0.05  # damping ratio of a pole that is guessed; the refinement finds its own
SHARP = 0.02  # of one guessed at the line that stands out most from the fit so far
OUTSIDE = 2.5  # a guess outside the band is so many times beyond its end


@dataclass(frozen=True)
class FittedModes:
    """Modes, the variance of the noise in which they were found, and their Bayesian information criterion."""

    modes: Modes
    variance: Floats
    score: float  # -inf: exact


def best_order(noise: NoiseShapes, modes: int | None, most: int, progress: Progress | None = None) -> FittedModes:
    """Orders one after the other; each starts from the order below and a new pole, and from poles of its own."""
    clear = np.abs(smoothed(noise.values)) > CLEAR * np.sqrt(noise.start)
    clear = clear if clear.sum() >= FEWEST else np.ones_like(clear)
    fitting = Fitting(noise.frequency, noise.values, 1.0 / np.sqrt(noise.start * noise.values.size))
    best, previous = None, None
    for count in range(1, (modes or most) + 1):
        if progress is not None:
            progress(count - 1, modes or most)
        previous = fitting.search(_starts(noise, clear, count, previous))
        result = with_its_noise(noise, previous, noise.start)
        if best is None or result.score < best.score or modes is not None:
            best = result
        if modes is None and (count - best.modes.count == WORSE or math.isinf(result.score)):
            break
    assert best is not None
    return best


def with_its_noise(noise: NoiseShapes, modes: Modes, variance: Floats) -> FittedModes:
    """The fit whose weights are the noise that it leaves, from ``modes`` fitted with this ``variance``."""
    values = noise.values
    for _ in range(PASSES):
        fitted = modes.at(noise.frequency)
        squares = np.abs(values - fitted) ** 2
        if float((squares / np.abs(values) ** 2).mean()) < EXACT**2:
            return FittedModes(modes, np.maximum(squares.mean(), 1e-30 * np.abs(values) ** 2), -math.inf)
        before, variance = variance, noise.variances(fitted, squares, modes.taken(noise.frequency, variance))
        if np.abs(np.log(variance / before)).max() < SETTLED:
            break
        modes = Fitting(noise.frequency, values, 1.0 / np.sqrt(variance * values.size)).refined(modes.shapes)
    squares = np.abs(values - modes.at(noise.frequency)) ** 2
    unlikely = 2.0 * float((np.log(variance) + squares / variance).sum())
    return FittedModes(modes, variance, unlikely + (4 * modes.count - 1) * math.log(2 * values.size))


def fit_without(noise: NoiseShapes, found: FittedModes, number: int) -> FittedModes:
    """The fit that begins with all modes but one."""
    fitting = Fitting(noise.frequency, noise.values, 1.0 / np.sqrt(found.variance * noise.values.size))
    shapes = np.delete(found.modes.shapes, [number, found.modes.count + number])
    return with_its_noise(noise, fitting.refined(shapes), found.variance)


def _starts(noise: NoiseShapes, clear: NDArray[np.bool_], count: int, previous: Modes | None) -> list[Complexes]:
    frequency, values = noise.frequency[clear], noise.values[clear]
    own = _proposals(frequency, values, 2 * count + 1)
    starts = [own[:count]] if own.size >= count else []
    if previous is None:
        return [*starts, np.array([-DAMPED + 1j]) * frequency[int(np.abs(values).argmax())]]
    kept, left = previous.poles_and_residues()[0][: previous.count], values - previous.at(frequency)
    fresh = [complex(pole) for pole in _proposals(frequency, left, 5)[:2]]
    worst = int((np.abs(smoothed(left)) / np.sqrt(noise.start[clear])).argmax())
    fresh.append((-SHARP + 1j) * frequency[worst])
    fresh += [(-DAMPED + 1j) * at for at in (OUTSIDE * frequency[-1], frequency[0] / OUTSIDE)]
    return starts + [np.append(kept, pole) for pole in fresh]


def _proposals(frequency: Floats, values: Complexes, terms: int) -> Complexes:
    """Poles of the AAA approximant, one of each pair, on the stable side, the greatest contribution first."""
    points = np.concatenate([1j * frequency, -1j * frequency])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that the tolerance was not reached with so few terms is meant to be so
        approximation = AAA(points, np.concatenate([values, values.conj()]), max_terms=terms, clean_up=False)
    poles, residues = np.asarray(approximation.poles()), np.asarray(approximation.residues())
    keep = np.isfinite(poles) & (poles.imag >= 0.0) & (np.abs(poles) > 0.0)
    poles, residues = poles[keep], residues[keep]
    nearest = np.abs(points[:, None] - poles).min(axis=0, initial=np.inf) + np.abs(poles.real)
    poles = -np.maximum(np.abs(poles.real), 1e-6 * np.abs(poles)) + 1j * poles.imag
    return np.asarray(poles[np.argsort(-np.abs(residues) / nearest)], np.complex128)


# How much noise a measured receptance has at each frequency: variances of known shapes that add, sized by the data.
#
# The noise of a sensor is even over the frequency in what it measures. An accelerance is divided by the square of the
# frequency, so that its noise grows without limit towards zero. A share of each value and five powers of the
# frequency describe this, what drifts, and a blow that is weak at its end; the likelihood decides which are there.


Noise = Literal["estimated", "relative", "absolute"]
POWERS = (-2, 0, 1, 2, 3)  # of 1/frequency: a weak blow, deflection, velocity, acceleration, a drift of the latter
STEPS = 300  # tens are enough, except where a part of the noise vanishes
ROUNDED = 1e-12  # a line of which the fit leaves no more than this has no voice
COHERENCE = (1e-3, 1.0 - 1e-4)  # beyond them its own error, of few averages and rounding in files, is all there is
LEAST_NOISE_CHANGE = 1e-4  # change of the variances in a step below which they are found


@dataclass(frozen=True)
class NoiseShapes:
    """What the noise of a measurement may be made of; frequencies scaled so that their middle is one."""

    noise: Noise
    frequency: Floats
    values: Complexes
    coherence: Floats | None = None

    def __post_init__(self) -> None:
        one_of("noise", self.noise, "estimated", "relative", "absolute")

    def only(self, kept: NDArray[np.bool_]) -> NoiseShapes:
        """The same of some of the lines."""
        coherence = None if self.coherence is None else self.coherence[kept]
        return NoiseShapes(self.noise, self.frequency[kept], self.values[kept], coherence)

    @cached_property
    def start(self) -> Floats:
        """The variances by the scatter of the values alone, before anything is fitted."""
        return self.variances(smoothed(self.values), scatter(self.values))

    def shapes(self, fitted: Complexes) -> Floats:
        """One row for each part of the noise, its variance up to a factor, given the values without noise."""
        ones = np.ones(self.frequency.size)
        doubt = ones
        if self.coherence is not None:
            clipped = np.clip(self.coherence, *COHERENCE)
            doubt = (1.0 - clipped) / clipped
        if self.noise == "relative":
            return np.asarray(doubt * np.abs(self.values) ** 2)[None]
        if self.noise == "absolute":
            return np.asarray(doubt)[None]
        rows = [np.abs(fitted) ** 2, *(self.frequency ** (-2.0 * power) for power in POWERS)]
        if self.coherence is not None:
            own = doubt * np.abs(self.values) ** 2
            rows.append(np.maximum(own, smoothed(own).real))  # few averages leave the coherence itself uncertain
        return np.array(rows)

    def variances(self, fitted: Complexes, squares: Floats, taken: Floats | float = 0.0) -> Floats:
        """The variance at each frequency that makes these squares of deviations likeliest.

        Each factor is multiplied by a root that is one at the greatest likelihood, which rises in every step
        (Févotte and Idier 2011, Itakura-Saito divergence). ``taken`` is the share of each value that the fit takes up,
        its leverage: of a square only 1 - ``taken`` is to be expected, so the likelihood is the restricted one
        (Patterson and Thompson 1971). Without it a fit through the only line on a narrow peak seems to be free of noise.
        """
        rows = self.shapes(fitted)
        least = 1e-30 * float(np.abs(self.values).max()) ** 2
        factors = float(squares.mean() + least) / rows.mean(axis=1) / len(rows)
        variances, left = factors @ rows, np.broadcast_to(np.maximum(1.0 - taken, ROUNDED), squares.shape)
        for _ in range(STEPS):
            factors = factors * np.sqrt((rows @ (squares / variances**2)) / (rows @ (left / variances)))
            before, variances = variances, factors @ rows + least
            if np.abs(variances / before - 1.0).max() < LEAST_NOISE_CHANGE:
                break
        return np.asarray(variances)


def scatter(values: Complexes) -> Floats:
    """Squares of what each value deviates from the parabola through its neighbours: noise, before anything is fitted."""
    weights = np.array([-1.0, 3.0, -3.0, 1.0])
    third = np.convolve(values, weights, mode="valid") / math.sqrt(20.0)
    between, ahead = (np.pad(third, ends, mode="edge") for ends in ((1, 2), (2, 1)))
    return np.asarray(0.5 * (np.abs(between) ** 2 + np.abs(ahead) ** 2))


def smoothed(values: Complexes | Floats) -> Complexes:
    """Mean over five neighbours, fewer at the ends."""
    ones = np.ones(5)
    count = np.convolve(np.ones(values.size), ones, mode="same")
    return np.asarray(np.convolve(values, ones, mode="same") / count, np.complex128)
