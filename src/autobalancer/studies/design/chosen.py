"""The machine of a design, with what it was chosen for in its description."""

from __future__ import annotations

import xarray as xr

from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import parse_race_machine
from autobalancer.machine import Machine
from autobalancer.results.number_text import moment_text
from autobalancer.studies.design.answer import OPEN, Designed


def designed_machine(designs: xr.Dataset, place: int = 1) -> Machine:
    """The machine of the design at a place, 1 for the best, that can be saved and run.

    Parameters
    ----------
    designs
        From :func:`design`.
    place
        In their order.

    Raises
    ------
    QuestionError
        If no design has this place.
    """
    if "place" not in designs or "machine" not in designs or "specification" not in designs.attrs:
        raise QuestionError("designed_machine: wants the answer of ab.design")
    there = designs["place"].values == place
    if not there.any():
        most = int((designs["place"].values > 0).sum())
        raise QuestionError(f"place: given {place}; the designs that ran have 1 to {most}")
    one = designs.isel(design=int(there.argmax()))
    machine = parse_race_machine(str(one["machine"].values))
    label = str(one["label"].values)
    return machine.model_copy(update={"name": f"{machine.name}, {label}", "description": _said(designs, one, machine)})


def _said(designs: xr.Dataset, one: xr.Dataset, machine: Machine) -> str:
    fluid = str(one["fluid"].values)
    filled = f" Its races are filled with {fluid}{' (shares by mass)' if '%' in fluid else ''}." if fluid else ""
    limits = dict(Designed.of(designs).facts())["limits"]
    low, high = designs.attrs["unbalance_range"]
    cold, warm = (value - 273.15 for value in designs.attrs["temperature_range"])
    keeps = {
        1: "It keeps them",
        0: "Too few runs to say whether it keeps them",
        -1: f"It misses {_missed(one)}",
    }
    began = f" The machine that was given: {machine.description}" if machine.description else ""
    return (
        f"Place {int(one['place'])} of design {designs.attrs['design_name']!r} for unbalances of {moment_text(low)} to "
        f"{moment_text(high)}, {cold:.4g} to {warm:.4g} °C.{filled} Its numbers here are those at "
        f"{0.5 * (cold + warm):.4g} °C. Limits: {limits}. {keeps[int(one['meets'])]} in "
        f"{designs.attrs['members']} runs with the seed {designs.attrs['seed']}.{began}"
    )


def _missed(one: xr.Dataset) -> str:
    return ", ".join(name for name in str(one["missed"].values).split(", ") if not name.endswith(OPEN))
