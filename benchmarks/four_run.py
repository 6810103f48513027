"""Balancing without phase on simulated rigs: how far corrections are off with a noise of 1 %."""

from __future__ import annotations

from typing import Any

import numpy as np

import autobalancer as ab
from autobalancer.machine import Machine, Unbalance
from autobalancer.measure import BalanceRun, Reading, TrialMass, four_run
from autobalancer.random_numbers import generator
from benchmarks import measured

NOISE, DRAWS, DURATION = 0.01, 100, 8.0
TRIAL = 1.5  # trial mass over unbalance, as docs/balancing.md advises
PLACES = (None, 0.0, 120.0, 240.0)
SPEEDS = {"discoidal": 100.0, "rodrigues_rig": 418.9}  # rad/s, above all critical speeds
PLANES = {"discoidal": None, "rodrigues_rig": "disk"}  # of the trial mass; read is the first station


def bench() -> list[dict[str, Any]]:
    """Root mean squares over both rigs and all draws, of the mass and of the angle."""
    off = np.concatenate([errors(name) for name in SPEEDS])
    mass, angle = np.sqrt(np.mean(off**2, axis=0))
    job = f"{NOISE:.0%} noise of each amplitude, trial mass {TRIAL:g} times the unbalance, no balls"
    note = f"{job}; {len(off)} jobs, 2 simulated rigs"
    row = measured("four_run_mass_percent", 100.0 * float(mass), "%", note=note)
    other = measured("four_run_angle_deg", float(np.degrees(angle)), "deg", note=note)
    return [
        row | {"peer": "limit 3 %", "ratio": 0.03 / float(mass)},
        other | {"peer": "limit 2 deg", "ratio": float(np.radians(2.0) / angle)},
    ]


def errors(name: str) -> np.ndarray:
    """Relative error of the mass and error of the angle (rad) of each draw, (DRAWS, 2)."""
    machine = ab.catalog.example_path(name)
    bare = ab.load_machine(machine).model_copy(update={"balancers": ()})
    speed = SPEEDS[name]
    true = needed(bare, speed, PLANES[name])
    trial = TRIAL * abs(true)
    amplitudes = np.array([amplitude(bare, speed, trial, PLANES[name], place) for place in PLACES])
    rng, off = generator(7), np.empty((DRAWS, 2))
    for n in range(DRAWS):
        runs = [
            BalanceRun(
                str(place), [Reading(a)], [] if place is None else [TrialMass("disk", f"{trial} kg*m", f"{place} deg")]
            )
            for place, a in zip(PLACES, amplitudes * (1.0 + NOISE * rng.standard_normal(4)), strict=True)
        ]
        found = four_run(runs, deviation=NOISE)
        ratio = float(found.correction[0, 0]) * np.exp(1j * float(found.correction_angle[0, 0])) / true
        off[n] = abs(ratio) - 1.0, np.angle(ratio)
    return off


def needed(machine: Machine, speed: float, plane: str | None) -> complex:
    """The correction that brings the sensor to rest, in closed form: the truth of the job."""
    loads = (machine.unbalances, (Unbalance(moment=1.0, station=plane),))
    station = [machine.stations[0].name] if machine.stations else None
    seen = [ab.rotor.response(machine, [speed], station, load).isel(speed=0, station=0) for load in loads]
    own, one = (complex(float(found.x_real), float(found.x_imag)) for found in seen)
    return -own / one


def amplitude(machine: Machine, speed: float, trial: float, plane: str | None, place: float | None) -> float:
    """Of the motion along x at once a turn, simulated in time from rest until the start has died out."""
    mass = () if place is None else (Unbalance(moment=trial, angle=np.radians(place), station=plane),)
    drive = {"kind": "speed", "profile": {"kind": "constant", "speed": speed}}
    changed = machine.model_copy(update={"unbalances": (*machine.unbalances, *mass)})
    turns = 2.0 * np.pi / speed * np.arange(200) / 20.0  # ten turns
    run = ab.simulate(
        ab.with_parameter(changed, "drive", drive),
        duration=DURATION,
        save=ab.SampleTimes((DURATION - 0.7 + turns).tolist()),
    )
    angle = run["rotor_angle"].values
    rows = np.column_stack([np.cos(angle), np.sin(angle), np.ones(angle.size)])
    return float(np.hypot(*np.linalg.lstsq(rows, run["x"].values, rcond=None)[0][:2]))
