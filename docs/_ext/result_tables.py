"""The tables of what a run holds, read off runs and off the vocabulary of results."""

from __future__ import annotations

from pathlib import Path

import xarray as xr
from sphinx.util import logging

import autobalancer as ab
from autobalancer.assembly.quantities import with_value_at
from autobalancer.assembly.terms import methods
from autobalancer.kernels.integrators import runge_kutta as endings
from autobalancer.machine import Machine
from autobalancer.results.labels import LABELS
from autobalancer.results.measure_table import CHAMBER_MEASURES, KINDS, MEASURES
from autobalancer.simulation.record import Envelope, LastRevolutions, Samples
from autobalancer.simulation.run import outcome

RACE = {
    "orbit_radius": 0.1,
    "drag": {"law": "viscous", "damping": 1e-3},
    "balls": [{"mass": 3e-3, "motion": "point"}],
}
SMALL = Machine(
    name="small",
    axis="vertical",
    rotor={"mass": "10 kg", "stiffness": "600 kN/m", "damping": "100 N*s/m"},
    unbalances=[{"moment": "300 g*mm"}],
    balancers=[{"races": [RACE]}],
    drive={"kind": "speed", "profile": {"kind": "ramp", "end": 400.0, "duration": 0.5}},
    run={"duration": 1.0},
)
RUBBER = {"stiffness": "300 kN/m", "damping": "50 N*s/m"}
TILTING = Machine(
    name="tilting",
    axis="vertical",
    rotor={
        "kind": "rigid",
        "mass": "10 kg",
        "transverse_inertia": "0.1 kg*m^2",
        "polar_inertia": "0.05 kg*m^2",
        "supports": [{"position": z, **RUBBER} for z in ("-0.1 m", "0.1 m")],
    },
    stations=[{"name": "race", "position": "20 mm"}],
    unbalances=[{"couple": "1 g*m^2"}],
    balancers=[{"station": "race", "races": [RACE]}],
    drive={"kind": "speed", "profile": {"kind": "constant", "speed": 100.0}},
    run={"duration": 0.2},
)
CONTACT = {
    "stiffness": "100 kN/m",
    "restitution": 0.5,
    "sliding_friction": 0.1,
    "slip_speed": "1 mm/s",
    "floor_friction": 0.1,
}
FREE_BALL = {
    "orbit_radius": 0.1,
    "drag": RACE["drag"],
    "balls": [{"mass": "3 g", "diameter": "10 mm"}],
    "resolved": CONTACT,
}
TWISTING = Machine(
    name="twisting",
    axis="vertical",
    rotor={"mass": "10 kg", "stiffness": "600 kN/m", "damping": "100 N*s/m", "inertia": "0.05 kg*m^2"},
    drive={"kind": "torque", "torque": "1 N*m", "couplings": [{"stiffness": "1 kN*m/rad", "inertia": "0.01 kg*m^2"}]},
    run={"duration": 0.2},
)
RUBBING = with_value_at(SMALL, "balancers[1].races[1].friction", {"rolling_resistance": 0.01})
CHAMBER = ab.load_machine(Path(__file__).parents[2] / "examples" / "machines" / "single_layer.toml")
CYLINDERS = ab.load_machine(Path(__file__).parents[2] / "examples" / "machines" / "chamber_cylinders.toml")
ROD = {"body": "pendulum", "mass": "3 g", "inertia": "1e-6 kg*m^2"}
SWINGING = with_value_at(SMALL, "balancers[1].races[1].balls", [ROD])
SPRING = {"kind": "radial_spring", "stiffness": "10 N/m", "free_length": "50 mm"}
SPRUNG = with_value_at(SMALL, "balancers[1].races[1].forces", [SPRING])
RESOLVED = with_value_at(SMALL, "balancers[1].races[1]", FREE_BALL)


def pages() -> dict[str, str]:
    """What the documentation includes."""
    return {
        "result_variables.md": result_variables(),
        "result_outcomes.md": result_outcomes(),
        "result_attributes.md": result_attributes(),
        "result_measures.md": result_measures(),
        "chamber_measures.md": chamber_measures(),
        "result_sources.md": result_sources(),
    }


def result_sources() -> str:
    """Which methods each result uses, and their sources."""
    text = "| method | results | sources |\n|---|---|---|\n"
    for method, (results, keys) in methods().items():
        names = ", ".join(f"`{name}`" for name in results)
        text += f"| {method} | {names} | {{cite:t}}`{','.join(keys)}` |\n"
    return text


def result_variables() -> str:
    """Every variable with its dimensions, unit and frame, grouped by what was asked to be kept."""
    passage = ab.Event("speed", 200.0)
    kept: list[tuple[str, xr.Dataset]] = [
        ("always", ab.simulate(SMALL, save=())),
        ("on a horizontal axis", ab.simulate(SMALL.model_copy(update={"axis": "horizontal"}), save=())),
        ("`Samples` or `SampleTimes`", ab.simulate(SMALL, save=Samples(9))),
        ("`Envelope`", ab.simulate(SMALL, save=Envelope(9))),
        ("`LastRevolutions`", ab.simulate(SMALL, save=LastRevolutions(1, 8))),
        ("events", ab.simulate(SMALL, save=(), events=[passage])),
        ("of a machine with stations", ab.simulate(TILTING, save=[Samples(9), LastRevolutions(1, 8)])),
        ("of rollers and pendulums", ab.simulate(SWINGING, save=Samples(9))),
        ("of forces on balls that have an energy", ab.simulate(SPRUNG, duration=0.1, save=Samples(9))),
        ("of a drive with couplings", ab.simulate(TWISTING, save=Samples(9))),
        ("of balls on real races", ab.simulate(RUBBING, duration=0.1, save=Samples(9))),
        ("of balls in `resolved` contact", ab.simulate(RESOLVED, duration=0.1, save=Samples(9))),
        ("of a deep chamber, with $x$ along the rotor", ab.simulate(CHAMBER, duration=0.005, settle=False)),
        ("of cylinders in a deep chamber", ab.simulate(CYLINDERS, duration=0.002, settle=False)),
    ]
    text, listed = "| variable | dimensions | unit | frame | meaning |\n|---|---|---|---|---|\n", set[tuple[str, str]]()
    for wish, run in kept:
        text += f"| *{wish}* | | | | |\n"
        here = {(str(name), ", ".join(map(str, run[name].dims))) for name in run.variables}
        for name, dimensions in sorted(here - listed, key=lambda row: list(LABELS).index(row[0])):
            label = LABELS[name]
            symbol = f", ${label.symbol}$" * bool(label.symbol)
            text += f"| `{name}` | {dimensions} | {label.units} | {label.frame} | {label.long_name}{symbol} |\n"
        listed |= here
    for name in sorted(set(LABELS) - {name for name, _ in listed}):
        logging.getLogger(__name__).warning("no run holds %s, which results/labels.py explains", name)
    return text


def result_outcomes() -> str:
    """Every way in which a run may end, in its own words."""
    ways = [
        (endings.FINISHED, False, ""),
        (endings.EVENT, False, ab.Event("speed", 250.0, "rising").name),
        (endings.RUNNING, True, ""),
        (endings.RUNNING, False, ""),
        (endings.STEP_TOO_SMALL, False, ""),
        (endings.NOT_FINITE, False, ""),
    ]
    text = "| `outcome` | `outcome_text`, for example |\n|---|---|\n"
    for status, interrupted, event in ways:
        ended = outcome(status, 12.5, 20.0, interrupted=interrupted, steps=4598, event=event)
        text += f"| `{ended.name}` | {ended.text} |\n"
    return text


def result_attributes() -> str:
    """The provenance in the attributes of a run."""
    run = ab.simulate(SMALL, save=Samples(9))
    rows = "".join(f"| `{name}` | {_shortly(value)} |\n" for name, value in run.attrs.items())
    return f"| attribute | for example |\n|---|---|\n{rows}"


def result_measures() -> str:
    """Every measure, what it is along, and what a sweep keeps of it."""
    text = "| measure | along | unit | meaning | in a sweep |\n|---|---|---|---|---|\n"
    for measure in MEASURES:
        kept = "the same" if not measure.along else ""
        if measure.of_all is not None:
            other = f"`{measure.of_all.name}`: " if measure.of_all.name else ""
            kept = other + measure.of_all.text + (", of each" if measure.of_all.per_ball else "")
        text += f"| `{measure.name}` | {measure.along} | {measure.unit} | {measure.text} | {kept} |\n"
    return text


def chamber_measures() -> str:
    """Every measure of a run of a deep chamber; those of both stages of a run in one row for each quantity."""
    kinds = " ".join(f"`{kind}`" for kind in KINDS)
    text = "| measure | along | unit | meaning |\n|---|---|---|---|\n"
    for measure in CHAMBER_MEASURES:
        name, _, kind = measure.name.rpartition("_")
        if not measure.along:
            text += f"| `{measure.name}` | | {measure.unit} | {measure.text} |\n"
        elif kind == next(iter(KINDS)):
            whole = measure.text.partition(" of ")[2]
            text += f"| `{name}_...` with {kinds} | stage | {measure.unit} | of {whole} |\n"
    return text


def _shortly(value: object) -> str:
    text = " ".join(str(value).split())
    return text if len(text) < 60 else f"{text[:40]} ..."
