"""Measurement files: what is free and what was measured, in TOML, every quantity with its unit or in SI."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field

from autobalancer.errors import AutobalancerError, QuestionError, UnitError
from autobalancer.files.text_files import built_of, read_table, read_toml
from autobalancer.machine.part import Amount, Label, Listed, Question, Rate, Speed, key
from autobalancer.machine.path import unit_at
from autobalancer.machine.rotors.body import Place
from autobalancer.rotordynamics.parameter_fit import (
    FreeParameter,
    KnownValue,
    MeasuredCriticalSpeed,
    MeasuredMode,
    MeasuredResponse,
    MeasuredStiffness,
    Measurement,
    ModeQuantity,
    Motion,
    ResponseMeasure,
    Tie,
    WhirlWord,
)
from autobalancer.safe_file import as_path
from autobalancer.units import to_si

Whole = Annotated[int, Field(strict=True, ge=1)]
OF_VALUE = "in the unit of the value, or percent of it"
UNITS = {"frequency": "rad/s", "decay_rate": "1/s", "damping_ratio": ""}
MOTIONS = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s^2"}


class Entry(Question):
    """An entry of a list of a measurement file."""

    def measurement(self, folder: Path) -> Measurement:
        """What was measured; files are seen from ``folder``."""
        raise NotImplementedError

    def _in(self, unit: str) -> dict[str, Any]:
        """``value`` and ``error`` in SI; an error may be a text in percent of the value."""
        value = _si(self, "value", unit)
        return {"value": value, "error": error_of(self, unit, abs(value))}

    def _rest(self, *but: str) -> dict[str, Any]:
        """What was given beside these keys, as the measurement takes it."""
        return {
            key: getattr(self, key)
            for key in type(self).model_fields
            if key in self.model_fields_set and key not in but
        }


def _si(entry: Entry, name: str, unit: str) -> float:
    try:
        return float(to_si(getattr(entry, name), unit))
    except UnitError as reason:
        raise QuestionError(str(reason), (name,)) from None


def error_of(entry: Any, unit: str, size: float) -> float:
    """The standard deviation ``error`` of an entry: a quantity, or percent of ``size``."""
    if str(entry.error).strip().endswith("%"):
        return _si(entry, "error", "") * size
    return _si(entry, "error", unit)


class Free(Question):
    """A free parameter: one unknown of the fit."""

    paths: Annotated[tuple[Label, ...], Field(min_length=1), Listed] = key(
        "of an entry of the machine, or of several that are tied"
    )
    lower: Amount | None = key("least value", None, value="in the unit of the entry")
    upper: Amount | None = key("greatest value", None, value="in the unit of the entry")
    tie: Tie = key("what is free: the value of all, a factor on those of the machine, or an offset to them", "value")
    name: Label = key("in results; the first path unless given", "")
    start: Amount | None = key(
        "where the fit begins; as the machine is unless given", None, value="in the unit of the entry"
    )


class Mode(Entry):
    """A mode, whose frequency is damped."""

    value: Amount = key("what was measured", value="rad/s, 1/s or number, by the quantity")
    error: Amount = key("standard deviation", value=OF_VALUE)
    quantity: ModeQuantity = key("what it is", "frequency")
    speed: Speed = key("of the rotor", 0.0)
    order: Whole = key("by frequency, of those with the whirl and the words below", 1)
    whirl: WhirlWord | None = key("its direction; on an isotropic rotor at rest each frequency occurs twice", None)
    mode: Label | None = key("words of its name, such as `cylindrical y`", None)
    balls: bool = key("whether the masses of the balls are on the rotor", False)

    def measurement(self, folder: Path) -> Measurement:
        """See :class:`Entry`."""
        return MeasuredMode(**self._in(UNITS[self.quantity]), **self._rest("value", "error"))


class CriticalSpeed(Entry):
    """A critical speed."""

    value: Amount = key("what was measured", value="rad/s")
    error: Amount = key("standard deviation", value=OF_VALUE)
    order: Whole = key("ascending, of those with the whirl and the words below", 1)
    whirl: WhirlWord | None = key("its direction", None)
    mode: Label | None = key("words of its name", None)
    balls: bool = key("whether the masses of the balls are on the rotor", False)
    highest: Rate | None = key("damped ones up to this speed; without damping unless given", None)

    def measurement(self, folder: Path) -> Measurement:
        """See :class:`Entry`."""
        return MeasuredCriticalSpeed(**self._in("rad/s"), **self._rest("value", "error"))


class Stiffness(Entry):
    """A static stiffness across the rotor: force over deflection."""

    value: Amount = key("what was measured", value="N/m")
    error: Amount = key("standard deviation", value=OF_VALUE)
    station: Place | None = key("where; not needed on a planar rotor", None)
    direction: Literal["x", "y"] = key("along which", "x")

    def measurement(self, folder: Path) -> Measurement:
        """See :class:`Entry`."""
        return MeasuredStiffness(**self._in("N/m"), **self._rest("value", "error"))


class Known(Entry):
    """A parameter that is known with an error."""

    path: Label = key("of an entry of the machine, or the name of a free parameter")
    value: Amount = key("what it is", value="in the unit of the entry")
    error: Amount = key("standard deviation", value=OF_VALUE)

    def of(self, units: Mapping[str, str]) -> Measurement:
        """With the units of the free parameters by their names."""
        return KnownValue(**self._in(units[self.path] if self.path in units else unit_at(self.path)), path=self.path)


class Response(Entry):
    """Amplitudes of the synchronous unbalance response over the speed, without balls."""

    file: Label = key("a table beside this file, such as `speed [rpm], amplitude [mm]`")
    error: Amount = key("standard deviation", value="in the unit of the amplitudes, or percent of them")
    stations: Annotated[tuple[Place, ...], Listed] | None = key("names or positions; all stations unless given", None)
    measure: ResponseMeasure = key("of all stations, or of a single one", "mean_of_greatest")
    logarithmic: bool = key("small and large amplitudes have the same weight", True)
    quantity: Motion = key("of the amplitudes", "displacement")
    label: Label | None = key("in reports; the file unless given", None)
    lowest: Speed = key("that is used", 0.0)
    highest: Speed | None = key("that is used", None)

    def measurement(self, folder: Path) -> Measurement:
        """See :class:`Entry`."""
        unit = MOTIONS[self.quantity]
        table = read_table(folder / self.file, "speed [rpm], amplitude [mm]")
        speeds, values = table.numbers("speed", "rad/s"), table.numbers("amplitude", unit)
        inside = (speeds >= self.lowest) & (speeds <= (math.inf if self.highest is None else self.highest))
        percent = str(self.error).strip().endswith("%")
        relative = 1.0 if self.logarithmic == percent else values[inside] if percent else 1.0 / values[inside]
        return MeasuredResponse(
            speeds[inside],
            values[inside],
            error_of(self, unit, 1.0) * relative,
            label=self.label or self.file,
            **self._rest("file", "error", "label", "lowest", "highest"),
        )


class MeasurementFile(Question):
    """What is free, and what was measured."""

    name: Label = key("of the file", "")
    description: str = key("what it is about", "")
    parameters: Annotated[tuple[Free, ...], Listed] = key("what is free", ())
    modes: Annotated[tuple[Mode, ...], Listed] = key("frequencies, decay rates or damping ratios", ())
    critical_speeds: Annotated[tuple[CriticalSpeed, ...], Listed] = key("critical speeds", ())
    stiffnesses: Annotated[tuple[Stiffness, ...], Listed] = key("static stiffnesses", ())
    known: Annotated[tuple[Known, ...], Listed] = key("parameters that are known with an error", ())
    responses: Annotated[tuple[Response, ...], Listed] = key("responses over the speed", ())


def read_measurements(
    path: str | Path, form: type[MeasurementFile] = MeasurementFile
) -> tuple[list[FreeParameter], list[Measurement]]:
    """Read a measurement file.

    Parameters
    ----------
    path
        As of :func:`~autobalancer.measurement.run_up_fit.load_measurements`.
    form
        Its lists.

    Returns
    -------
    list, list
        Free parameters and measurements, for :func:`~autobalancer.rotordynamics.identify.identify`.

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
    requested = built_of(lambda data: form(**data), data, str(path))
    free = [
        FreeParameter(**{key: value for key, value in parameter if key in parameter.model_fields_set})
        for parameter in requested.parameters
    ]
    units = {one.name: "" if one.tie == "factor" else unit_at(one.first) for one in free}
    measurements: list[Measurement] = []
    for kind in [name for name in form.model_fields if name not in ("name", "description", "parameters")]:
        for number, entry in enumerate(getattr(requested, kind)):
            try:
                measurements.append(entry.of(units) if isinstance(entry, Known) else entry.measurement(path.parent))
            except AutobalancerError as error:
                raise type(error).of(str(path), error.within(kind, number).problems) from None
    return free, measurements


def _hint(path: Path) -> str:
    """What to do with a table that was given in place of the file that names it."""
    if path.suffix.lower() == ".toml" or not path.is_file():
        return ""
    return (
        ". A measurement file ends with .toml and says what is free and what was measured; "
        f'it names a table so:\n[[responses]]\nfile = "{path.name}"\nerror = "5 %"'
    )
