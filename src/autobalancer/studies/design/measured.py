"""The rotor of a specification from a measured receptance: read, fitted, and refused where it was not measured."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from autobalancer.assembly.changed_parts import changed_part
from autobalancer.errors import QuestionError
from autobalancer.files.samples import beside
from autobalancer.machine import Machine, PrescribedSpeed, Unbalance
from autobalancer.machine.profile import Constant
from autobalancer.rotordynamics.receptance.answer import FittedReceptance
from autobalancer.rotordynamics.receptance.measured import hertz, load_receptance
from autobalancer.rotordynamics.receptance.rational_fit import receptance
from autobalancer.rotordynamics.receptance.rotor import MeasuredRotor, measured_rotor, said_of, with_measured_rotor
from autobalancer.shown import rpm_and_si
from autobalancer.studies.study.entries import whole
from autobalancer.units import shortened

KEYS = ("receptance", "band", "modes", "function", "mass_added", "inertia")
PREFIX = "rotor_"  # of names in the answer of a design
KEPT = ("title", "fit_error", "free_error", "modes", "band_low", "band_high", "warnings", "noise")


def read_rotor(table: Mapping[str, Any], folder: Path) -> MeasuredRotor:
    """Read a measured receptance and fit a rotor to it; paths are seen from ``folder``.

    Raises
    ------
    QuestionError
        With the key at fault; if no rotor has such a receptance, or its lowest mode was not measured.
    ResultError
        If the file cannot be read.
    """
    if not isinstance(table.get("receptance"), (str, Path)):
        raise QuestionError(
            f"rotor.receptance: given {shortened(table.get('receptance'))}; give the file of a measured frequency response, "
            'such as receptance = "hammer.csv"'
        )
    counts = {key: whole(f"rotor.{key}", table[key], 1) for key in ("modes", "function") if key in table}
    try:
        measured = load_receptance(
            beside(folder, table["receptance"]), function=counts.get("function"), mass_added=table.get("mass_added")
        )
        fit = receptance(measured, modes=counts.get("modes"), band=table.get("band"))
        found = measured_rotor(fit, inertia=table.get("inertia"))
    except QuestionError as reason:
        raise QuestionError(f"rotor: {reason}") from None
    low, lowest = float(found.fit.attrs["band_low"]), float(found.fit["mode_frequency"].values[0])
    if lowest < low:
        raise QuestionError(
            f"rotor.receptance: the lowest mode, at {hertz(lowest)} Hz, lies below what was measured, from {hertz(low)} Hz "
            "on; a run-up passes it, so measure from lower frequencies on"
        )
    return found


def with_rotor(machine: Machine | None, measured: MeasuredRotor, name: str) -> Machine:
    """A machine with the measured rotor in place of its own; without one a machine that is nothing but this rotor.

    Raises
    ------
    QuestionError
        If the machine has what a rotor known in one plane cannot carry.
    """
    if machine is None:
        still = PrescribedSpeed(profile=Constant(speed=0.0))
        machine = Machine(name=name, axis="vertical", rotor=measured.rotor, drive=still)
    return with_measured_rotor(machine, measured)


def with_some_unbalance(machine: Machine, size: float) -> Machine:
    """The machine itself, or with an unbalance (kg m) if it has none that could be changed."""
    if machine.unbalances:
        return machine
    changed: Machine = changed_part(machine, unbalances=(Unbalance(moment=size),))
    return changed


def refuse_beyond(fit: FittedReceptance, fastest: float) -> None:
    """Refuse speeds (rad/s) whose frequency was not measured.

    Raises
    ------
    QuestionError
        With both keys.
    """
    high = float(fit.attrs["band_high"])
    if fastest > high * (1.0 + 1e-6):
        raise QuestionError(
            f"operation.speed and rotor.receptance contradict each other: {rpm_and_si(fastest)} are {hertz(fastest)} Hz, and the "
            f"receptance is known up to {hertz(high)} Hz; measure further, or run slower"
        )


def labelled(fit: FittedReceptance) -> tuple[dict[str, Any], dict[str, Any]]:
    """Variables and attributes under names that no other of a design has."""
    variables = {f"{PREFIX}{name}": fit[name].rename(None) for name in map(str, fit.data_vars)}
    return variables, {f"{PREFIX}{name}": fit.attrs[name] for name in KEPT if name in fit.attrs} | {
        "rotor": said_of(fit)
    }


def read_back(designs: Any) -> FittedReceptance | None:
    """The fit in the answer of a design; None if its rotor was no measured one."""
    if f"{PREFIX}receptance_real" not in designs:
        return None
    names = {name: str(name)[len(PREFIX) :] for name in designs.data_vars if str(name).startswith(PREFIX)}
    attrs = {str(name)[len(PREFIX) :]: value for name, value in designs.attrs.items() if str(name).startswith(PREFIX)}
    found = designs[list(names)].rename(names)
    found.attrs = {**attrs, "rotor": designs.attrs["rotor"], "modes": int(np.asarray(attrs["modes"]))}
    return FittedReceptance.of(found)
