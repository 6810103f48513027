"""Measurement files: what is free and what was measured, in TOML, every quantity with its unit or in SI."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from autobalancer.assembly.rotors.lateral_model import Floats
from autobalancer.errors import AutobalancerError, QuestionError
from autobalancer.files.table import read_table
from autobalancer.files.text import read_toml
from autobalancer.machine.part import unknown_key
from autobalancer.machine.path import unit_at
from autobalancer.rotordynamics.identification.free import FreeParameter
from autobalancer.rotordynamics.identification.measurements import (
    KnownValue,
    MeasuredCriticalSpeed,
    MeasuredMode,
    MeasuredResponse,
    MeasuredStiffness,
    Measurement,
)
from autobalancer.safe_file import as_path
from autobalancer.units import shortened, to_si

TEXTS = ("name", "label", "tie", "path", "file", "quantity")
MODE_UNITS = {"frequency": "rad/s", "decay_rate": "1/s", "damping_ratio": ""}


class Kind(NamedTuple):
    """A list of a measurement file: its keys, those without a default, and what makes a measurement of an entry and a folder."""

    keys: tuple[str, ...]
    needed: tuple[str, ...]
    read: Callable[[dict[str, Any], Path], Measurement]


def read_measurements(
    path: str | Path, more: Mapping[str, Kind] | None = None
) -> tuple[list[FreeParameter], list[Measurement]]:
    """Read a measurement file.

    Parameters
    ----------
    path
        As of :func:`~autobalancer.measurement.comparison.run_up_fit.load_measurements`.
    more
        Further lists by their names.

    Returns
    -------
    list, list
        Free parameters and measurements, for :func:`~autobalancer.rotordynamics.identification.identify.identify`.

    Raises
    ------
    QuestionError
        If the file or an entry cannot be read; the message names the key.
    ResultError
        If the table of a response cannot be read.
    """
    path = as_path(path)
    try:
        data = read_toml(path)
    except QuestionError as reason:
        raise QuestionError(f"{reason}{_hint(path)}") from None
    kinds = KINDS | dict(more or {})
    unknown = sorted(set(data) - set(kinds) - {"name", "description"})
    if unknown:
        raise QuestionError(f"{path}: {unknown[0]}: {unknown_key(unknown[0], (*kinds, 'name', 'description'))}")
    free: list[FreeParameter] = []
    found: list[Measurement] = []
    units: dict[str, str] = {}
    for kind in kinds:
        for number, entry in enumerate(_list(data.get(kind, []), path, kind), 1):
            where = f"{path}: {kind}[{number}]"
            _check_keys(entry, kinds[kind], where)
            try:
                if kind == "parameters":
                    free.append(FreeParameter(**entry))
                    units[free[-1].name] = "" if free[-1].tie == "factor" else unit_at(free[-1].first)
                elif kind == "known":
                    name = str(entry["path"])
                    path_unit = units[name] if name in units else unit_at(name)
                    found.append(KnownValue(**_single(entry, path_unit)))
                else:
                    found.append(kinds[kind].read(entry, path.parent))
            except AutobalancerError as error:
                raise type(error)(f"{where}: {error}") from None
            except (TypeError, ValueError, AttributeError) as error:
                raise QuestionError(f"{where}: a value has the wrong form: {error}") from None
    return free, found


def _hint(path: Path) -> str:
    """What to do with a table that was given in place of the file that names it."""
    if path.suffix.lower() == ".toml" or not path.is_file():
        return ""
    return (
        ". A measurement file ends with .toml and says what is free and what was measured; "
        f'it names a table so:\n[[responses]]\nfile = "{path.name}"\nerror = "5 %"'
    )


def _list(entries: Any, path: Path, kind: str) -> list[dict[str, Any]]:
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        raise QuestionError(f"{path}: {kind}: write each entry under its own line [[{kind}]]")
    return entries


def _check_keys(entry: dict[str, Any], kind: Kind, where: str) -> None:
    for key, value in entry.items():
        if key not in kind.keys:
            raise QuestionError(f"{where}.{key}: {unknown_key(key, kind.keys)}")
        if isinstance(value, dict) or (
            isinstance(value, list) and any(isinstance(part, (dict, list)) for part in value)
        ):
            raise QuestionError(f"{where}.{key}: given {shortened(value)}; must be a single value, or a list of them")
        if key in TEXTS and not isinstance(value, str):
            raise QuestionError(f"{where}.{key}: given {shortened(value)}; must be a text")
    for key in kind.needed:
        if key not in entry:
            raise QuestionError(f"{where}.{key}: missing; it has no default")


def value_and_error(entry: dict[str, Any], unit: str) -> dict[str, float]:
    """``value`` and ``error`` in SI; an error may be a text in percent of the value."""
    value = to_si(entry["value"], unit)
    return {"value": float(value), "error": error_of(entry["error"], unit, abs(value))}


def error_of(error: Any, unit: str, size: float) -> float:
    """A standard deviation: a quantity, or percent of ``size``."""
    if isinstance(error, str) and error.strip().endswith("%"):
        return float(to_si(error.strip()[:-1].strip(), "")) / 100.0 * size
    return float(to_si(error, unit))


def _single(entry: dict[str, Any], unit: str, speeds: tuple[str, ...] = ()) -> dict[str, Any]:
    rest = {key: value for key, value in entry.items() if key not in ("value", "error")}
    for key in speeds:
        if key in rest:
            rest[key] = float(to_si(rest[key], "rad/s"))
    return {**rest, **value_and_error(entry, unit)}


def _mode(entry: dict[str, Any], folder: Path) -> Measurement:
    quantity = entry.get("quantity", "frequency")
    if quantity not in MODE_UNITS:
        raise QuestionError(f"quantity: given {quantity!r}; must be one of {', '.join(MODE_UNITS)}")
    return MeasuredMode(**_single(entry, MODE_UNITS[quantity], ("speed",)))


def _response(entry: dict[str, Any], folder: Path) -> Measurement:
    quantity = entry.get("quantity", "displacement")
    units = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s^2"}
    if quantity not in units:
        raise QuestionError(f"quantity: given {quantity!r}; must be one of {', '.join(units)}")
    low, high = (to_si(entry.get(key, default), "rad/s") for key, default in (("lowest", 0.0), ("highest", 1e9)))
    speeds, values = read_curve(folder / str(entry["file"]), units[quantity])
    inside = (speeds >= low) & (speeds <= high)
    percent = isinstance(entry["error"], str) and entry["error"].strip().endswith("%")
    logarithmic = bool(entry.get("logarithmic", True))
    error = error_of(entry["error"], units[quantity], 1.0)
    wanted = {key: entry[key] for key in ("stations", "measure") if key in entry}
    spread = error * (1.0 if logarithmic == percent else values[inside] if percent else 1.0 / values[inside])
    return MeasuredResponse(
        speeds[inside], values[inside], spread, quantity=quantity, logarithmic=logarithmic,
        label=str(entry.get("label", entry["file"])), **wanted,
    )  # fmt: skip


def _none(entry: dict[str, Any], folder: Path) -> Measurement:
    raise NotImplementedError  # read where what is before in the file is known


SINGLE = ("value", "error")
CHOSEN = ("order", "whirl", "mode", "balls")
KINDS = {
    "parameters": Kind(("paths", "lower", "upper", "tie", "name", "start"), ("paths",), _none),
    "modes": Kind((*SINGLE, "quantity", "speed", *CHOSEN), SINGLE, _mode),
    "critical_speeds": Kind(
        (*SINGLE, *CHOSEN, "highest"),
        SINGLE,
        lambda entry, _: MeasuredCriticalSpeed(**_single(entry, "rad/s", ("highest",))),
    ),
    "stiffnesses": Kind(
        (*SINGLE, "station", "direction"), SINGLE, lambda entry, _: MeasuredStiffness(**_single(entry, "N/m"))
    ),
    "known": Kind((*SINGLE, "path"), (*SINGLE, "path"), _none),
    "responses": Kind(
        ("file", "error", "stations", "measure", "logarithmic", "quantity", "label", "lowest", "highest"),
        ("file", "error"),
        _response,
    ),
}


# Tables of amplitude against speed with units in their column names.


def read_curve(path: Path, unit: str) -> tuple[Floats, Floats]:
    """Speeds (rad/s) and amplitudes (in the SI ``unit``) of a table ``speed [rpm], amplitude [mm]``.

    Raises
    ------
    ResultError
        If the file, a column, a unit or a number is not there or not understood.
    """
    table = read_table(path, "speed [rpm], amplitude [mm]")
    return table.numbers("speed", "rad/s"), table.numbers("amplitude", unit)
