"""The machine of a design, with what was assumed written into its description."""

from __future__ import annotations

import json
import math

import xarray as xr

from autobalancer.assembly.author_units import in_author_units
from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import parse_machine
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.studies.chamber_design.candidate import Candidate, machine_of

NUMBERS = ("diameter", "density", "friction", "ball_friction", "viscosity", "fluid_density", "fill")


def designed_machine(designs: xr.Dataset, place: int = 1, *, unbalance: float | None = None) -> ChamberMachine:
    """The machine of the design at a place, 1 for the best, that can be saved and run.

    Parameters
    ----------
    designs
        From :func:`design`.
    place
        In their order.
    unbalance
        kg m; by default the greatest for which they were made.

    Raises
    ------
    QuestionError
        If no design has this place.
    """
    if "place" not in designs or "machine" not in designs.attrs:
        raise QuestionError("designed_machine: wants the answer of chamber.design")
    there = designs["place"].values == place
    if not there.any():
        raise QuestionError(f"place: given {place}; the designs have 1 to {int(designs['place'].max())}")
    one = designs.isel(design=int(there.argmax()))
    machine = parse_machine(str(designs.attrs["machine"]))
    assert isinstance(machine, ChamberMachine)
    candidate = candidate_of(one)
    size = float(designs["unbalance"].max()) if unbalance is None else unbalance
    made = in_author_units(machine_of(machine, candidate, size), machine)
    return made.model_copy(
        update={"name": f"{machine.name}, {candidate.label}", "description": _said(designs, one, candidate)}
    )


def candidate_of(one: xr.Dataset) -> Candidate:
    """The candidate of one design of the answer."""
    return Candidate(int(one["balls"]), *(float(one[name]) for name in NUMBERS))


def _said(designs: xr.Dataset, one: xr.Dataset, candidate: Candidate) -> str:
    limits = json.loads(designs.attrs["limits"])
    asked = ", ".join(f"{name} {value:g}" for name, value in limits.items()) or "none"
    sizes = ", ".join(f"{size:g}" for size in designs["unbalance"].values)
    meets = "It meets them." if int(one["meets"]) else f"It misses {str(one['missed'].values) or 'them'}."
    fluid = ""
    if candidate.viscosity > 0.0:
        fluid = (
            f" Fluid of {candidate.viscosity:g} Pa s and {candidate.fluid_density:g} kg/m^3 that fills {candidate.fill:g} of the "
            f"chamber, its drag that of balls far from walls, c_d = 24/Re + 0.44; buoyancy is left out."
        )
    worst = float(one["worst_vibration"])
    found = f"Worst vibration {worst:.3g} m" if not math.isnan(worst) else "Worst vibration not known"
    return (
        f"Design {int(one['place'])} of {designs.sizes['design']} for unbalances of {sizes} kg m. Limits (SI): {asked}. {meets} "
        f"{found} in {designs.sizes['seed']} fillings of {designs.attrs['duration']:g} s. Assumed: a friction of "
        f"{candidate.friction:g}, restitution and rolling resistance of the machine it was made from.{fluid}"
    )
