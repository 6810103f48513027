"""Which analysis supports which machine: every analysis is tried on every machine while the pages are built."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import xarray as xr

import autobalancer as ab
from autobalancer.assembly.terms import TERMS, Theory
from autobalancer.errors import AutobalancerError
from autobalancer.machine import Machine

SPEED = 200.0  # rad/s, above the critical speeds of the machines below
SHORT = 0.5  # s; enough to see whether a law takes part

Answer = Callable[[Machine], Any]
Changes = dict[str, Any]
BORDERS = ("averaged border", "exact border", "release speed", "capture speed")
ANALYSES: dict[str, Answer] = {
    "simulate": lambda machine: ab.simulate(machine, duration=SHORT)["ball_angle_in_rotor"],
    "stepped-response": lambda machine: ab.stepped_response(machine, [SPEED], dwell=SHORT, window=SHORT),
    "basin": lambda machine: ab.basin(machine, SPEED, random=2, hold=SHORT),
    **{name: lambda machine, name=name: _border(machine, name) for name in BORDERS},
    "eigenvalues": lambda machine: ab.stability.eigenvalues(machine, [SPEED, 1.1 * SPEED]),
    "map": lambda machine: ab.stability.map(
        machine, {"speed": [SPEED, 1.1 * SPEED], "ball_mass": [4e-3, 5e-3]}, borders=2
    ),
    "branches": lambda machine: ab.stability.branches(machine, "speed", SPEED, 1.02 * SPEED, orbits=False),
    "friction": lambda machine: _held(machine),
    "modes": lambda machine: ab.rotor.modes(machine, SPEED),
    "response": lambda machine: ab.rotor.response(machine, [SPEED]),
}

RACE = {
    "orbit_radius": "50 mm",
    "width": "12 mm",
    "height": "12 mm",
    "fluid": {"density": "955 kg/m^3", "viscosity": "20 mm^2/s"},
    "drag": {"law": "cd_times_re", "cd_times_re": 300.0},
    "balls": [
        {
            "count": 2,
            "diameter": "10 mm",
            "density": "7800 kg/m^3",
            "start_angles": ["40 deg", "60 deg"],
            "start_speeds": [5.0, 0.0],
        }
    ],
}
PLANAR = {"kind": "planar", "mass": "5 kg", "stiffness": "40 kN/m", "damping": "40 N*s/m"}
ROTORS: dict[str, Changes] = {
    "planar": {"rotor": PLANAR},
    "planar, different in x and y": {"rotor": PLANAR | {"stiffness": ["40 kN/m", "50 kN/m"]}},
    "planar, horizontal axis": {"rotor": PLANAR, "axis": "horizontal"},
    "planar, driven by a torque": {
        "rotor": PLANAR | {"inertia": "0.02 kg*m^2"},
        "drive": {
            "kind": "target_torque",
            "gain": "1 N*m*s",
            "damping": "1 N*m*s",
            "profile": {"kind": "constant", "speed": SPEED},
        },
    },
}
CURVED = {"law": "sphere_on_plane", "range": "whole"}
RACES: dict[str, Changes] = {
    "rolling resistance, adherence": {"friction": {"rolling_resistance": 0.005, "adherence": 0.006}},
    "drag over all Reynolds numbers": {"drag": CURVED},
    "slipstream": {"drag": CURVED, "slipstream": True},
    "restitution of balls that touch": {"contact": {"restitution": 0.5}},
    "partitions": {"partitions": {"count": 2, "angle": "33 deg"}},
    "race out of round": {"harmonics": [{"order": 2, "amplitude": "50 um", "angle": "30 deg"}]},
    "springs along the race": {"forces": [{"kind": "race_springs", "stiffness": 0.05}]},
    "eccentric race": {"eccentricity": "0.1 mm"},
    "fluid that lags": {"fluid": RACE["fluid"] | {"lag": "modes"}},
    "resolved balls": {
        "resolved": {"stiffness": "1000 kN/m", "restitution": 0.5, "sliding_friction": 0.1, "slip_speed": "1 mm/s"}
    },
}
BASE: Changes = {
    "name": "sample",
    "axis": "vertical",
    "unbalances": [{"moment": "200 g*mm"}],
    "drive": {"kind": "speed", "profile": {"kind": "ramp", "start": 0.9 * SPEED, "end": SPEED, "duration": 0.05}},
    "run": {"duration": SHORT},
}


def pages() -> dict[str, str]:
    """What the documentation includes."""
    return {"analyses_of_rotors.md": rotors(), "analyses_of_races.md": races(), "terms.md": terms()}


def terms() -> str:
    """Which theory knows which term of the equations, as it is declared in the code."""
    text = f"| term | {' | '.join(theory.value for theory in Theory)} |\n|---|{'---|' * len(Theory)}\n"
    for term in TERMS:
        marks = ["●" if theory in term.known else "·" if theory in term.idle else "–" for theory in Theory]
        partly = "".join(f" (of {theory.value}: {name})" for theory, name in term.names.items())
        text += f"| {term.name}{partly} | {' | '.join(marks)} |\n"
    return text


def rotors() -> str:
    """Which analysis takes which rotor and drive."""
    machines = {name: _machine(changes, {}) for name, changes in ROTORS.items()}
    planes = ab.example("two_plane_rotor")
    machines["rigid rotor, two planes"] = planes
    supports = [{"position": at, "stiffness": ["20 kN/m", "25 kN/m"], "damping": "20 N*s/m"} for at in (-0.12, 0.12)]
    machines["rigid rotor, supports different in x and y"] = ab.with_parameter(planes, "rotor.supports", supports)
    machines["rigid rotor, full motion of tilting races"] = ab.with_parameter(planes, "tilting_races", "full")
    machines["flexible shaft"] = ab.example("cfrp_rig")
    machines["rig of rigid bodies"] = ab.example("discoidal_rig")
    cells = {name: _tried(machine) for name, machine in machines.items()}
    cells["planar, on rubber that softens"] = _on_rubber()
    return _table("rotor and drive", cells)


def _on_rubber() -> dict[str, str | None]:
    """Where the amplitude of softening rubber counts: answers that differ from those of a spring as stiff as in small motions."""
    friction = {"breakaway_amplitude": ["1 um", "10 um"], "stiffness": ["10 kN/m", "10 kN/m"]}
    rubber = {"stiffness": "20 kN/m", "damping": "40 N*s/m", "friction": friction}
    soft = _tried(_machine({"rotor": {"kind": "planar", "mass": "5 kg", "rubber": rubber}}, {}))
    stiff = _tried(_machine({"rotor": PLANAR}, {}))
    return {key: _effect(soft[key], stiff[key]) for key in ANALYSES}


def races() -> str:
    """Which analysis takes into account what a race may have."""
    plain = _tried(_machine({"rotor": PLANAR}, {}))
    others = {
        "drag over all Reynolds numbers": _tried(_machine({"rotor": PLANAR}, {"drag": {"law": "sphere_on_plane"}})),
        "slipstream": _tried(_machine({"rotor": PLANAR}, {"drag": CURVED})),
    }
    cells = {}
    for name, changes in RACES.items():
        answers = _tried(_machine({"rotor": PLANAR}, changes))
        reference = others.get(name, plain)
        cells[name] = {key: _effect(answers[key], reference[key]) for key in ANALYSES}
    return _table("the race has", cells)


def _machine(changes: Changes, race: Changes) -> Machine:
    return Machine.model_validate(BASE | changes | {"balancers": [{"races": [RACE | race]}]})


def _border(machine: Machine, name: str) -> np.ndarray:
    found = [one.speed for one in ab.stability.borders(machine, only=(name,)) if one.name == name and one.known]
    if not found:
        raise AutobalancerError("no such border")
    return np.array(found)


def _held(machine: Machine) -> np.ndarray:
    """What friction holds: worst and median residual; a machine without friction gets a little for the question."""
    race = machine.balancers[0].races[0]
    if race.friction is None:
        if race.resolved is not None:
            machine = ab.with_parameter(machine, "balancers[1].races[1].resolved.rest_speed", "1 mm/s")
        machine = ab.with_parameter(machine, "balancers[1].races[1].friction", {"rolling_resistance": 2e-4})
    planes = ab.stability.held_by_friction(machine, SPEED).planes
    return np.array([[plane.sticking_residual, plane.median_residual] for plane in planes])


def _tried(machine: Machine) -> dict[str, Any]:
    """The answer of each analysis, or ``None`` where it refuses."""
    answers: dict[str, Any] = {}
    for name, ask in ANALYSES.items():
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                answers[name] = _numbers(ask(machine))
        except AutobalancerError:
            answers[name] = None
    return answers


def _numbers(answer: Any) -> np.ndarray:
    if isinstance(answer, xr.Dataset):
        values = [v.values.ravel() for v in answer.data_vars.values() if np.issubdtype(v.dtype, np.number)]
        return np.concatenate(values) if values else np.zeros(0)
    return np.asarray(answer, float).ravel()


def _effect(answer: Any, reference: Any) -> str | None:
    if answer is None or reference is None:
        return None
    same = answer.shape == reference.shape and np.allclose(answer, reference, rtol=1e-12, atol=0.0, equal_nan=True)
    return "without it" if same else "yes"


def _table(head: str, rows: Mapping[str, Mapping[str, Any]]) -> str:
    text = f"| {head} | {' | '.join(ANALYSES)} |\n|---|{'---|' * len(ANALYSES)}\n"
    marks = {None: "–", "yes": "●", "without it": "○"}
    for name, cells in rows.items():
        shown = [cell if cell is None or isinstance(cell, str) else "yes" for cell in cells.values()]
        text += f"| {name} | {' | '.join(marks[cell] for cell in shown)} |\n"
    return text
