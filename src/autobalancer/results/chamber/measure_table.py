"""The table of the measures of a run of a deep chamber, of the form of :mod:`autobalancer.results.measure_table`.

A new measure is an entry here and, if it is more than a line, a method of :class:`ChamberRecorded`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from autobalancer.results.chamber.balls import Floats
from autobalancer.results.chamber.recorded import ChamberRecorded
from autobalancer.results.measure import Measure

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
