"""Measured receptances: read from files, and a rotor made of the modes of a fitted one."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
import xarray as xr
from scipy.optimize import least_squares

from autobalancer.arrays import Complexes, Floats
from autobalancer.assembly.quantities import changed_part
from autobalancer.errors import MachineError, QuestionError, RangeWarning, ResultError, UnitError, warn
from autobalancer.files.samples import sample_hint
from autobalancer.files.text_files import Table, read_table
from autobalancer.machine import Machine, ModalRotor, PlanarRotor, Resonance
from autobalancer.results.answers.answer import Answer, Labeled, provenance
from autobalancer.results.labels import labeled
from autobalancer.results.signals import UNIVERSAL, Function, is_universal, read_universal
from autobalancer.safe_file import as_path, not_to_read
from autobalancer.units import argument, optional_argument, to_si

# A receptance as a sum over poles.


@dataclass(frozen=True)
class PoleModel:
    """A receptance sum r/(sigma - p) over all poles. ``added_mass``: of the balls, if it was measured without them."""

    poles: Complexes
    residues: Complexes
    added_mass: float = 0.0

    def receptance(self, sigma: Complexes) -> Complexes:
        """H(sigma) with the balls on the rotor, m/N."""
        bare = (self.residues / (sigma[..., None] - self.poles)).sum(axis=-1)
        return np.asarray(bare / (1.0 + self.added_mass * sigma**2 * bare), np.complex128)

    def at(self, frequency: Floats) -> Complexes:
        """H(i frequency), m/N."""
        return self.receptance(np.asarray(1j * frequency, np.complex128))


def pole_model(fit: xr.Dataset, added_mass: float = 0.0) -> PoleModel:
    """The fitted receptance for :mod:`autobalancer.measurement.loop`."""
    if "place" in fit.dims:
        raise QuestionError(
            "receptance: this needs one place, and several were fitted; receptance_rotor makes a rotor of them"
        )
    poles = fit["pole_real"].values + 1j * fit["pole_imag"].values
    return PoleModel(poles, fit["residue_real"].values + 1j * fit["residue_imag"].values, added_mass)


# Measured receptances from files: deflection over force at the race, whatever was measured and in which unit.
#
# Tables, and universal files with frequency responses, in ASCII (dataset 58) or binary (58b).


POWERS = {"receptance": 0, "mobility": 1, "accelerance": 2}  # of i w, to divide by
LENGTHS = {"receptance": "m", "mobility": "m/s", "accelerance": "m/s^2"}
MOTIONS = {8: "receptance", 11: "mobility", 12: "accelerance"}  # kinds of data of universal files
RESPONSE, FREQUENCY, FORCE, UNSAID = (
    4,
    18,
    (9, 13),
    (0, 1),
)  # function; abscissa; reaction and excitation; unknown, general
EXAMPLE = "frequency [Hz], real [m/N], imag [m/N]"
WORDS = {
    "frequency": ("frequency", "freq", "f"),
    "real": ("real", "re", "real part"),
    "imag": ("imag", "im", "imaginary", "imag part", "imaginary part"),
    "amplitude": ("amplitude", "magnitude", "abs", "mag"),
    "phase": ("phase", "angle"),
    "coherence": ("coherence", "coh"),
}


def load_receptance(
    path: str | Path, *, function: int | Literal["all"] | None = None, mass_added: float | str | None = None
) -> xr.Dataset:
    """Read a measured frequency response, force to deflection, velocity or acceleration along the same direction.

    Those between several places, as ``disc`` or ``disc y``, are read of a table with columns ``response`` and ``force``, and of a
    universal file with ``function="all"``, whose places are nodes with directions; then the result has them over ``pair``.

    Parameters
    ----------
    path
        A table (``.csv``, ``.txt``, ...) with a line of column names, each with its unit in brackets, such as
        ``frequency [Hz], real [m/s^2/N], imag [m/s^2/N]``; ``amplitude [...]`` and ``phase [deg]`` can be used instead,
        and ``coherence`` is used if present. Or a universal file with datasets of type 58 or 58b.
    function
        Which frequency response of a universal file, counted from 1; by default the only one at a driving point; or ``"all"``.
    mass_added
        Mass (kg) that was fixed to the rotor at the race in the test and is no part of it, such as that of the accelerometer and
        of balls; what is read is the rotor without it.

    Returns
    -------
    xarray.Dataset
        ``receptance_real`` and ``receptance_imag`` (m/N, convention e^(+i w t)) over ``frequency`` (rad/s, ascending,
        above zero), and ``coherence`` if the file has one.

    Raises
    ------
    ResultError
        If the file cannot be read; the message says where and what is expected.
    QuestionError
        If the added mass is negative.
    """
    path = as_path(path)
    if reason := not_to_read(path):
        raise ResultError(f"{path}: cannot be read: {reason}{sample_hint(path)}")
    with path.open("rb") as file:
        start = file.read(1024)
    if is_universal(start) or path.suffix.lower() in UNIVERSAL:
        functions, lost = read_universal(path.read_bytes(), path.name)
        dataset = _of_functions(functions, path.name, function)
        for text in lost:
            warn(f"{path.name}: {text}", RangeWarning)
    else:
        dataset = _of_table(read_table(path, EXAMPLE, path.name))
    mass = optional_argument("mass_added", mass_added, "kg")
    if mass is not None and "pair" in dataset.dims:
        raise QuestionError("mass_added: is known of one place only; leave it out")
    if mass is None:
        return dataset
    if not mass >= 0.0:
        raise QuestionError(f"mass_added: given {mass:g} kg; must not be negative")
    # without this mass at the place: 1/H0 = 1/H + m w^2
    values = dataset["receptance_real"].values + 1j * dataset["receptance_imag"].values
    values = values / (1.0 + mass * dataset["frequency"].values ** 2 * values)
    for name, part in (("receptance_real", values.real), ("receptance_imag", values.imag)):
        dataset[name] = dataset[name].copy(data=part)
    return dataset.assign_attrs(mass_added=mass)


def _of_table(table: Table) -> xr.Dataset:
    """The receptance in a table of real and imaginary part, or of amplitude and phase."""
    at = {word: name for name in table.heads for word, names in WORDS.items() if name in names}
    first, second = ("amplitude", "phase") if "amplitude" in at else ("real", "imag")
    for needed in ("frequency", first, second):
        if needed not in at:
            raise ResultError(
                f"{table.place}: no column {needed!r}; the columns must be frequency and real, imag (or amplitude, phase), "
                f"such as: {EXAMPLE}"
            )
        if not table.heads[at[needed]][1]:
            unit = {"frequency": "Hz", "phase": "deg"}.get(needed, "m/N")
            raise ResultError(
                f"{table.place}: column {at[needed]!r} has no unit; write it in brackets, such as {at[needed]} [{unit}]"
            )
    kind, factor = _kind(table.heads[at[first]][1], table.place)
    if first == "real" and _kind(table.heads[at[second]][1], table.place) != (kind, factor):
        raise ResultError(f"{table.place}: real and imaginary part have different units")
    frequency, one = table.numbers(at["frequency"], "rad/s"), table.values(table.heads[at[first]][0])
    if first == "amplitude":
        values = one * np.exp(1j * table.numbers(at["phase"], "rad"))
    else:
        values = one + 1j * table.values(table.heads[at[second]][0])
    coherence = table.values(table.heads[at["coherence"]][0]) if "coherence" in at else None
    if {"response", "force"} <= set(table.heads):
        ends = list(zip(table.texts("response"), table.texts("force"), strict=True))
        parts = {}
        for pair in dict.fromkeys(ends):
            rows = [k for k, other in enumerate(ends) if other == pair]
            title = f"{table.place}, {pair[0]} over {pair[1]}"
            parts[pair] = receptance_dataset(frequency[rows], factor * values[rows], kind, title=title)
        return _pairs(parts, table.place)
    return receptance_dataset(frequency, factor * values, kind, title=table.place, coherence=coherence)


def _pairs(parts: dict[tuple[str, str], xr.Dataset], title: str) -> xr.Dataset:
    """Receptances between places, by response and force."""
    first = next(iter(parts.values()))
    for (response, force), part in parts.items():
        if not np.array_equal(part["frequency"].values, first["frequency"].values):
            raise ResultError(f"{title}: {response} over {force} is at other frequencies than the first pair")
    whole = xr.concat(list(parts.values()), "pair", combine_attrs="override")
    ends = {name: ("pair", [pair[k] for pair in parts]) for k, name in enumerate(("response", "force"))}
    return whole.assign_coords(ends).assign_attrs(title=title)


def _kind(unit: str, place: str) -> tuple[str, float]:
    for kind, length in LENGTHS.items():
        try:
            return kind, _factor(unit, f"{length}/N")
        except UnitError:
            continue
    raise ResultError(
        f"{place}: {unit!r} is not a unit of a frequency response; give deflection, velocity or acceleration over force, "
        "such as m/N, mm/s/N or m/s^2/N"
    )


def _factor(unit: str, si: str) -> float:
    """How many ``si`` one ``unit`` is; m/s2 and m/s² are understood, too, and g where an acceleration is wanted."""
    plain = re.sub(r"(?<=[A-Za-z])(\d)", r"^\1", unit.replace("²", "2"))
    if plain in ("g", "G") and si == "m/s^2":
        plain = "g_0"
    return float(to_si(f"1 {plain}", si))


def _of_functions(functions: list[Function], name: str, number: int | Literal["all"] | None) -> xr.Dataset:
    """The wanted frequency response of a universal file, by default the only one at a driving point."""
    responses: list[tuple[Function, str, float]] = []
    odd = []
    for k, function in enumerate(functions, 1):
        if function.kind == RESPONSE and function.axes[0].kind in (FREQUENCY, *UNSAID):
            kind, factor, label = _response(function, f"{name}, function {k}")
            responses += [(function, kind, factor)] if kind else []
            odd += [] if kind else [f"function {k} is {label}"]
    if not responses:
        others = "; ".join(odd[:3]) or f"{len(functions)} other functions"
        raise ResultError(f"{name}: no dataset 58 with a frequency response of motion over force, but {others}")
    if number == "all":
        parts = {}
        for entry in responses:
            ends = [f"{node} {'xyz'[(abs(way) or 1) - 1]}" for node, way in (entry[0].response, entry[0].reference)]
            parts[ends[0], ends[1]] = _one(entry, name)
        return _pairs(parts, name)
    driving = [
        entry
        for entry in responses
        if entry[0].response[0] == entry[0].reference[0] and abs(entry[0].response[1]) == abs(entry[0].reference[1])
    ]
    candidates = driving if number is None else responses[number - 1 : number] if number > 0 else []
    if len(candidates) != 1:
        rows = "; ".join(
            f"{i}: {kind}, node {f.response[0]} direction {f.response[1]} over node {f.reference[0]} direction {f.reference[1]}"
            for i, (f, kind, _) in enumerate(responses, 1)
        )
        raise ResultError(
            f"{name}: choose one function by its number, the one at the race along one line. There are {rows}"
        )
    return _one(candidates[0], name)


def _one(entry: tuple[Function, str, float], name: str) -> xr.Dataset:
    function, kind, factor = entry
    sign = np.sign(function.response[1] or 1) * np.sign(
        function.reference[1] or 1
    )  # minus directions of an accelerometer
    hertz = _labeled(function.axes[0].unit, "rad/s", 2.0 * math.pi, name)
    title = f"{name}, {function.words[0]}"
    return receptance_dataset(
        hertz * np.asarray(function.abscissa, np.float64),
        np.asarray(float(sign) * factor * function.values, np.complex128),
        kind,
        title=title,
    )


def _response(function: Function, place: str) -> tuple[str, float, str]:
    """Kind of a frequency response, and its SI value; of one that is none of motion over force what it is."""
    _, over, under = function.axes
    if not np.iscomplexobj(function.values):
        raise ResultError(f"{place}: the values are not complex")
    if over.kind in MOTIONS and under.kind in FORCE:
        kind = MOTIONS[over.kind]
        force = _labeled(under.unit, "N", function.force, place)
        return kind, _labeled(over.unit, LENGTHS[kind], function.length, place) / force, ""
    if over.unit and under.kind in UNSAID and not under.unit:  # the unit of the whole as its label
        try:
            return *_kind(over.unit, place), ""
        except ResultError:
            pass
    return "", 0.0, f"{over.unit or 'of no unit'} (kind {over.kind}) over {under.unit or 'no unit'} (kind {under.kind})"


def _labeled(label: str, si: str, default: float, place: str) -> float:
    try:
        return _factor(label, si) if label else default
    except UnitError as reason:
        raise ResultError(f"{place}: unit label: {reason}") from None


def receptance_dataset(
    frequency: Floats, values: Complexes, kind: str, *, title: str, coherence: Floats | None = None
) -> xr.Dataset:
    """Label values of kind *receptance*, *mobility* or *accelerance* (SI, over rad/s); a line at zero is left out.

    Raises
    ------
    ResultError
        If there are values that are no numbers, or a frequency comes twice.
    """
    frequency, values = np.asarray(frequency, np.float64), np.asarray(values, np.complex128)
    order = np.argsort(frequency, kind="stable")
    order = order[frequency[order] > 0.0]
    frequency, values = frequency[order], values[order]
    if not np.isfinite(values).all() or not np.isfinite(frequency).all():
        raise ResultError(f"{title}: a value is not a finite number")
    if (np.diff(frequency) == 0.0).any():
        raise ResultError(f"{title}: a frequency comes twice; give one value for each")
    if not (np.abs(values) > 0.0).all():
        raise ResultError(f"{title}: a value is exactly zero, which cannot be a measurement; delete that line")
    values = values / (1j * frequency) ** POWERS[kind]
    data: dict[str, tuple[Any, ...]] = {
        "receptance_real": ("frequency", values.real, "receptance, real part", "m/N"),
        "receptance_imag": ("frequency", values.imag, "receptance, imaginary part", "m/N"),
    }
    if coherence is not None:
        data["coherence"] = ("frequency", np.asarray(coherence)[order], "coherence", "")
    about = {**provenance(), "title": title, "measured": kind}
    return Labeled.of(labeled(data, {"frequency": ("frequency", frequency, "frequency", "rad/s")}, about))


def hertz(frequency: float) -> str:
    """A frequency in rad/s as messages give it, without the unit: Hz."""
    return f"{frequency / (2.0 * math.pi):.4g}"


# A rotor made of the modes that were fitted to a measured receptance.


COUPLED = 1.5  # times what a free fit leaves, from which on it is said that the modes are not damped each by itself


class MeasuredRotor(NamedTuple):
    """A rotor, and its receptance beside the measured one."""

    rotor: PlanarRotor | ModalRotor
    fit: Answer  # with the modes of this rotor


def receptance_rotor(
    fit: xr.Dataset,
    *,
    inertia: float | str | None = None,
    positions: Mapping[str, float | str] | None = None,
    total_mass: float | str | None = None,
) -> PlanarRotor | ModalRotor:
    """The rotor of a machine from a measured receptance: of one mode a planar rotor, of several a modal one.

    Each mode of this rotor is damped by itself and has a positive mass, so that it can be run; frequencies, damping ratios and
    masses are fitted once more under this condition, each value with the weight of its noise.

    Parameters
    ----------
    fit
        From :func:`receptance`, of a test without balls, or of one whose balls are taken off (``mass_added`` of
        :func:`load_receptance`).
    inertia
        About the shaft, kg m^2; needed only where a torque drives.
    positions
        Of several places: where each is along the axis, such as ``{"disc": "100 mm"}``; ``disc y`` is the same place along y.
    total_mass
        Of several places: of all that moves across the axis, kg.

    Returns
    -------
    PlanarRotor or ModalRotor
        For the ``rotor`` of a machine.

    Raises
    ------
    QuestionError
        If a mode has no positive mass, so that no such rotor exists.
    """
    if "place" not in fit.dims:
        return measured_rotor(fit, inertia=inertia).rotor
    names = [str(name) for name in fit["place"].values]
    ways = [("y" if name.endswith(" y") else "x", name.removesuffix(" x").removesuffix(" y")) for name in names]
    stations = {name: argument(f"positions {name}", (positions or {}).get(name), "m") for _, name in ways}
    order = sorted(stations, key=lambda name: stations[name])
    along = [way for way in "xy" if any(way == one for one, _ in ways)]
    if lost := [f"{name} {way}" for way in along for name in order if (way, name) not in ways]:
        raise QuestionError(f"receptance: {lost[0]} was not measured; measure all places along the same directions")
    columns = [[ways.index((way, name)) for name in order] for way in along]
    shapes = np.asarray(fit["mode_shape"].values, np.float64)
    numbers = zip(fit["mode_frequency"].values.tolist(), fit["mode_damping_ratio"].values.tolist(), shapes, strict=True)
    modes = [
        {"frequency": own, "damping_ratio": ratio}
        | {name: shape[column].tolist() for name, column in zip(("shape", "shape_y"), columns, strict=False)}
        for own, ratio, shape in numbers
    ]
    source = f"{fit.attrs['title']}: {len(modes)} modes, left over {100.0 * float(fit.attrs['fit_error']):.2g} %"
    keys: dict[str, Any] = {"positions": [stations[name] for name in order], "resonances": modes, "source": source}
    return ModalRotor(
        **keys,
        inertia=optional_argument("inertia", inertia, "kg*m^2"),
        total_mass=argument("total_mass", total_mass, "kg"),
    )


def measured_rotor(fit: xr.Dataset, *, inertia: float | str | None = None) -> MeasuredRotor:
    """The same with its receptance in place of that of the fit; ``free_error`` is what ``fit`` itself leaves."""
    about = optional_argument("inertia", inertia, "kg*m^2")
    modes = np.array([fit[f"mode_{name}"].values for name in ("mass", "frequency", "damping_ratio")], np.float64)
    if not (modes[0] > 0.0).all():
        where = ", ".join(hertz(float(mode)) for mode in modes[1, ~(modes[0] > 0.0)])
        raise QuestionError(
            f"receptance: the mode at {where} Hz has no positive mass, which no rotor has at the place of the force; look at the "
            "picture, and fit fewer modes or a narrower band"
        )
    modes, error = _damped_by_itself(fit, modes)
    # the fit with the receptance, poles and residues of these modes
    mass, own, ratio = modes
    roots = np.sqrt((ratio**2 - 1.0).astype(np.complex128))
    poles, others = own * (-ratio + roots), own * (-ratio - roots)
    residues = 1.0 / (mass * (poles - others))
    both = {
        "fitted": _receptance(modes, np.asarray(fit["frequency"].values, np.float64)),
        "pole": np.concatenate([poles, others]),
        "residue": np.concatenate([residues, -residues]),
    }
    parts = {f"{name}_{part}": getattr(of, part) for name, of in both.items() for part in ("real", "imag")}
    parts |= {"mode_mass": mass, "mode_frequency": own, "mode_damping_ratio": ratio}
    measured_rotor = fit.assign({name: fit[name].copy(data=part) for name, part in parts.items()})
    measured_rotor.attrs |= {"fit_error": error, "free_error": fit.attrs["fit_error"]}
    if error > COUPLED * fit.attrs["fit_error"]:
        said = (
            f"modes that are damped each by itself leave {100.0 * error:.2g} % of the values, a free fit "
            f"{100.0 * fit.attrs['fit_error']:.2g} %: the rotor that runs is that much coarser than the measurement"
        )
        measured_rotor.attrs["warnings"] = "\n".join(filter(None, (fit.attrs["warnings"], said)))
    # of one mode a planar rotor, of several a modal one
    (m, w, d), *more = modes.T.tolist()
    rotor: PlanarRotor | ModalRotor = PlanarRotor(mass=m, stiffness=m * w**2, damping=2.0 * d * w * m, inertia=about)
    if more:
        listed = tuple(Resonance(mass=m, frequency=w, damping_ratio=d) for m, w, d in modes.T.tolist())
        rotor = ModalRotor(resonances=listed, inertia=about)
    return MeasuredRotor(rotor, Answer.of(measured_rotor, "FittedReceptance"))


def fit_text(fit: Answer) -> str:
    """What was measured and fitted, in one line."""
    modes = zip(*(fit[f"mode_{name}"].values.tolist() for name in ("frequency", "damping_ratio", "mass")), strict=True)
    said = "; ".join(f"{hertz(w)} Hz, damping ratio {100.0 * ratio:.3g} %, mass {m:.4g} kg" for w, ratio, m in modes)
    low, high = (hertz(float(fit.attrs[f"band_{end}"])) for end in ("low", "high"))
    return f"{fit.attrs['title']}, {low} to {high} Hz: {said}; left over {100.0 * float(fit.attrs['fit_error']):.2g} %"


def with_measured_rotor(machine: Machine, measured: MeasuredRotor) -> Machine:
    """A machine with this rotor in place of its own; its description says so.

    Raises
    ------
    QuestionError
        If the machine has what a rotor known in one plane cannot carry.
    """
    try:
        changed: Machine = changed_part(machine, rotor=measured.rotor)
    except MachineError as reason:
        raise QuestionError(
            f"receptance: the machine cannot have a rotor that is known in one plane: {reason}"
        ) from None
    text = f"Its rotor was fitted to {fit_text(measured.fit)}. {machine.description}".strip()
    return changed.model_copy(update={"description": text})


def _damped_by_itself(fit: xr.Dataset, modes: Floats) -> tuple[Floats, float]:
    """Masses, frequencies and damping ratios nearest to what was measured, and what they leave of it."""
    used = np.flatnonzero(fit["used"].values)
    frequency, noise = (np.asarray(fit[name].values[used], np.float64) for name in ("frequency", "noise_deviation"))
    measured = np.asarray((fit["receptance_real"].values + 1j * fit["receptance_imag"].values)[used], np.complex128)

    def left(logarithms: Floats) -> Floats:
        miss = (_receptance(np.exp(logarithms).reshape(3, -1), frequency) - measured) / noise
        return np.concatenate([miss.real, miss.imag])

    start = np.log(np.maximum(modes, 1e-9)).ravel()
    best = (
        least_squares(left, start, x_scale="jac").x if modes.shape[1] > 1 else start
    )  # one mode is such a rotor itself
    modes = np.exp(best).reshape(3, -1)
    size = float((np.abs(_receptance(modes, frequency) / noise) ** 2).sum())
    return modes[:, np.argsort(modes[1])], math.sqrt(float((left(best) ** 2).sum()) / size)


def _receptance(modes: Floats, frequency: Floats) -> Complexes:
    mass, own, ratio = modes
    sigma = 1j * frequency[:, None]
    return np.asarray((1.0 / (mass * (sigma**2 + 2.0 * ratio * own * sigma + own**2))).sum(axis=1), np.complex128)
