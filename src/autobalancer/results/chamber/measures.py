"""Measures of a run of a deep chamber: the numbers by which chambers are compared."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.results.answers.labeled import Labeled
from autobalancer.results.answers.measured import Measured
from autobalancer.results.chamber.balls import Floats, window
from autobalancer.results.chamber.recorded import DIRECTIONS, ChamberRecorded
from autobalancer.results.chamber.shape import bodies_of, unbalance_of
from autobalancer.results.measure import Measure
from autobalancer.results.number_text import worded
from autobalancer.results.of_a_run import of_a_run
from autobalancer.results.verdict.rule import speed_changes
from autobalancer.units import optional_argument

SOURCE = ("machine_name", "outcome", "outcome_text", "source")
PARAMETERS = {"ball_mass_total": "kg", "ball_diameter": "m", "depth": "m", "duration": "s", "step": "s", "sample": "s"}


@of_a_run(runs="simulate_chamber")
def collision_statistics(run: xr.Dataset, bins: int = 50) -> xr.Dataset:
    """Contacts of a ``run`` between balls and with the chamber: totals, rates over time in ``bins`` parts, the hardest.

    Rates (1/s) count contacts that began in a part; ``impact_power`` (W) is what impacts dissipate in it, and
    ``greatest_force`` (N) the greatest force of a contact.
    """
    window(run)
    time = run["time"].values
    edges = np.linspace(0, time.size, min(bins, time.size // 2) + 1).astype(int)
    starts, ends = edges[:-1], edges[1:]
    before = np.concatenate([[time[0]], time[ends[:-1] - 1]])
    span = time[ends - 1] - before
    found = xr.Dataset(coords={"part_time": ("part_time", 0.5 * (before + time[ends - 1]), {"units": "s"})})
    force = run["greatest_contact_force"].values
    for name, text in (("contacts_ball", "contacts between balls"), ("contacts_wall", "contacts with the chamber")):
        counts = run[name].values
        found[name] = _scalar(float(counts.sum()), "", text)
        rate = np.add.reduceat(counts, starts) / span
        found[f"{name}_rate"] = ("part_time", rate, {"units": "1/s", "long_name": f"rate of {text}"})
    lost = np.diff(run["loss_contact"].values, prepend=run["loss_contact"].values[:1])
    power = np.add.reduceat(lost, starts) / span
    found["impact_power"] = ("part_time", power, {"units": "W", "long_name": "power that impacts dissipate"})
    found["greatest_force"] = ("part_time", np.maximum.reduceat(force, starts), {"units": "N"})
    found["greatest_force"].attrs["long_name"] = "greatest force of a contact"
    hardest = int(np.argmax(force))
    found["hardest_contact"] = _scalar(force[hardest], "N", "force of the hardest contact")
    found["hardest_contact_time"] = _scalar(time[hardest], "s", "time of the hardest contact")
    return Labeled.of_run(run, "Contacts", found)


@of_a_run(runs="simulate_chamber")
def chamber_measures(
    run: xr.Dataset,
    *,
    unbalance: complex | None = None,
    couple: complex = 0.0,
    chamber_places: NDArray[np.float64] | None = None,
    last: float | str | None = None,
    tolerance: float = 1.0,
) -> Measured:
    """All measures of a run in one dataset, each with its unit and long name.

    Parameters
    ----------
    run
        From ``simulate_chamber``, or an archive.
    unbalance, couple
        Of the rotor, complex in the rotor (kg m, kg m²), for the residual unbalance; by default those of the machine.
    chamber_places
        Places of the chambers along the axis (m); by default those of the machine.
    last
        Seconds at the end that are the steady state; by default a tenth of the run.
    tolerance
        Of the settling time, in ball radii.

    Raises
    ------
    QuestionError
        If there are too few samples.
    """
    last = optional_argument("last", last, "s")
    described = unbalance_of(run)
    if unbalance is None and described is not None:
        unbalance, couple = described
    recorded = ChamberRecorded(run, last, tolerance, unbalance, couple, chamber_places)
    found = {}
    for measure in CHAMBER_MEASURES:
        if not measure.needs or getattr(recorded, measure.needs) is not None:
            dims, about = (
                (measure.along,) if measure.along else (),
                {"units": measure.unit, "long_name": worded(measure.text, bodies_of(run))},
            )
            found[measure.name] = (dims, np.asarray(measure.of(recorded), np.float64), about)
    return Measured(found, {"stage": list(STAGES)}, {key: run.attrs[key] for key in SOURCE if key in run.attrs})


def without_steady_state(run: xr.Dataset, measured: Measured) -> Measured:
    """The measures of a ``run`` with nan for what is measured in steady state or counts from it, if its speed still changes."""
    time = run["time"].values
    if not speed_changes(time, run["speed"].values, float(time[-1])):
        return measured
    peaks = {f"{direction}_{what}" for direction in DIRECTIONS for what in ("peak", "peak_time")}
    found = {}
    for name, value in measured.data_vars.items():
        if "stage" in value.dims:
            found[name] = value.where(value["stage"] != "steady")
        elif name in peaks or STEADY in value.attrs.get("long_name", ""):
            found[name] = value.where(False)
    return measured.assign(found)


def catalog_numbers(measured: xr.Dataset) -> dict[str, float]:
    """The measures as single numbers for a catalog of runs; those of a stage get its name in front."""
    found: dict[str, float] = {}
    for name, value in measured.variables.items():
        if name in measured.coords:
            continue
        if value.ndim == 0:
            found[str(name)] = float(value.values)
        elif value.dims == ("stage",):
            for stage, number in zip(measured["stage"].values, value.values, strict=True):
                found[f"{stage}_{name}"] = float(number)
    return found


def catalog_unit(name: str) -> str:
    """The unit of a number of :func:`catalog_numbers`, or of a parameter of a run; empty where it has none."""
    return {**PARAMETERS, **UNITS}.get(name, "")


def _scalar(value: float, unit: str, text: str) -> xr.DataArray:
    return xr.DataArray(float(value), attrs={"units": unit, "long_name": text})


# The table of the measures of a run of a deep chamber, of the form of :mod:`autobalancer.results.measure_table`.
#
# A new measure is an entry here and, if it is more than a line, a method of :class:`ChamberRecorded`.


STEADY = "in steady state"  # ends the meaning of what is measured there
STAGES = ("transient", "steady")
KINDS: dict[str, tuple[str, Callable[[Floats], Any]]] = {
    "greatest": ("greatest", lambda values: np.abs(values).max()),
    "rms": ("root mean square", lambda values: np.sqrt(np.mean(values**2))),
    "mean": ("mean", np.mean),
}


def _motion(direction: str, unit: str) -> Iterator[Measure]:
    yield Measure(
        f"{direction}_amplitude",
        *(unit, "", f"{direction} amplitude {STEADY}"),
        lambda r: 0.5 * np.ptp(r.moved(direction)[r.steady]),
    )
    yield Measure(
        f"{direction}_synchronous",
        *(unit, "", f"{direction} synchronous amplitude {STEADY}"),
        lambda r: r.synchronous(direction),
    )
    yield Measure(
        f"{direction}_peak",
        *(unit, "", f"greatest {direction} deflection in the transient"),
        lambda r: r.away(direction).max(),
    )
    yield Measure(
        f"{direction}_peak_time",
        *("s", "", f"time of the greatest {direction} deflection"),
        lambda r: r.time[np.argmax(r.away(direction))],
    )


def _reaction(name: str, unit: str, of: Callable[[ChamberRecorded], Floats]) -> Iterator[Measure]:
    def over_stages(measure: Callable[[Floats], Any]) -> Callable[[ChamberRecorded], Floats]:
        return lambda r: r.parts(of(r), measure)

    for kind, (text, measure) in KINDS.items():
        yield Measure(f"{name}_{kind}", unit, "stage", f"{text} of {name.replace('_', ' ')}", over_stages(measure))


CHAMBER_MEASURES = (
    *_motion("horizontal", "m"),
    *_motion("vertical", "m"),
    *_motion("rotation", "rad"),
    *_reaction("bearing_1", "N", lambda r: r.radial_force(1)),
    *_reaction("bearing_1_axial", "N", lambda r: r.values("bearing_force")[:, 0, 0]),
    *_reaction("bearing_2", "N", lambda r: r.radial_force(2)),
    *_reaction("bearing_2_axial", "N", lambda r: r.values("bearing_force")[:, 1, 0]),
    *_reaction("constraint_x", "N", lambda r: r.values("constraint_force")[:, 0]),
    *_reaction("constraint_moment_y", "N m", lambda r: r.values("constraint_moment")[:, 1]),
    *_reaction("constraint_moment_z", "N m", lambda r: r.values("constraint_moment")[:, 2]),
    Measure("contacts_ball", "", "", "contacts between balls", lambda r: r.run["contacts_ball"].values.sum()),
    Measure("contacts_wall", "", "", "contacts with the chamber", lambda r: r.run["contacts_wall"].values.sum()),
    Measure("impact_rate", "1/s", "stage", "contacts begun a second", lambda r: r.over_stages(r.impacts)),
    Measure(
        "impact_speed", "m/s", "stage", "mean speed at which contacts began", lambda r: r.of_an_impact("impact_speeds")
    ),
    Measure(
        "impact_energy",
        *("J", "stage", "mean energy of approach with which contacts began"),
        lambda r: r.of_an_impact("impact_energies"),
    ),
    Measure("impact_power", "W", "stage", "power that impacts dissipate", lambda r: r.over_stages(r.impact_loss)),
    Measure("hardest_contact", "N", "", "force of the hardest contact", lambda r: r.contact_force.max()),
    Measure(
        "hardest_contact_time",
        *("s", "", "time of the hardest contact"),
        lambda r: r.time[np.argmax(r.contact_force)],
    ),
    Measure(
        "tilting",
        *("", "stage", "greatest moment that would tilt a cylinder over what its contacts could bear"),
        lambda r: r.parts(r.run["tilting"].values, np.max),
        needs="cylinders",
    ),
    Measure(
        "tilting_share",
        *("", "stage", "share of the samples in which it is above 1"),
        lambda r: r.parts(r.run["tilting"].values > 1.0, np.mean),
        needs="cylinders",
    ),
    Measure(
        "settling_time",
        *("s", "", "time at which the last ball settles, from the start"),
        lambda r: r.settled.max() if r.settled.size else np.nan,
    ),
    Measure("share_carried", "1", "", "share of the balls that go around with the rotor", lambda r: np.mean(r.carried)),
    Measure(
        "residual_unbalance",
        *("kg m", "", f"residual unbalance {STEADY}"),
        lambda r: r.left["static"].mean(),
        needs="left",
    ),
    Measure(
        "residual_couple",
        *("kg m^2", "", f"residual couple unbalance {STEADY}"),
        lambda r: r.left["couple"].mean(),
        needs="left",
    ),
    Measure(
        "energy_error",
        *("1", "", "greatest error of the energy balance over the work of the motor"),
        lambda r: _share_of_work(r.run),
    ),
)
UNITS = {
    f"{stage}_{measure.name}" if measure.along else measure.name: measure.unit
    for measure in CHAMBER_MEASURES
    for stage in (STAGES if measure.along else ("",))
}


def _share_of_work(run: Any) -> float:
    exchanged = float(np.abs(run["work_motor"].values[-1]))
    return float(np.abs(run["energy_error"].values).max()) / exchanged if exchanged else float("nan")
