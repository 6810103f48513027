"""A chamber of one layer against balls resolved in the plane of their race: two models that share only the stiffness of Hertz."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

import autobalancer as ab
from autobalancer.api import simulate
from autobalancer.assembly.chamber_assembly import contact_time
from autobalancer.files.machine_file import balls_in_chambers
from autobalancer.laws.impacts import damping_ratio
from autobalancer.machine import Machine
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.results.chamber_measures import ball_places_in_rotor, residual_of_balls
from autobalancer.simulation.chamber import simulate_chamber
from autobalancer.simulation.record import SampleTimes

DIAMETER, DENSITY, WALL = 0.017, 7800.0, 0.06
ORBIT = WALL - 0.5 * DIAMETER
STIFFNESS, DAMPING, DRAG, FRICTION = 2e4, 200.0, 0.08, 0.5
MODULUS, POISSON, RESTITUTION = 2e9, 0.3, 0.7
UNBALANCE = 6e-4
ANGLES = (math.radians(40.0), math.radians(250.0))
DRIVE = {"kind": "speed", "profile": {"kind": "table", "time": [0.0, 0.4], "speed": [0.0, 160.0]}}
BALLS = {"count": 2, "diameter": DIAMETER, "density": DENSITY}
DURATION = 5.0


def planar() -> Machine:
    log = math.log(RESTITUTION)
    wanted = -log / math.hypot(
        math.pi, log
    )  # damping ratio of the chamber, whose formula lets the contact pull at its end
    alike = float(brentq(lambda value: damping_ratio(value) - wanted, 0.2, 0.99))
    resolved = {
        "reduced_modulus": MODULUS / (2.0 * (1.0 - POISSON**2)), "restitution": alike,
        "sliding_friction": FRICTION, "slip_speed": 1e-2,
    }  # fmt: skip
    balls = BALLS | {"motion": "rolling", "start_angles": list(ANGLES)}
    race = {
        "orbit_radius": ORBIT,
        "drag": {"law": "viscous", "damping": DRAG * ORBIT**2},
        "resolved": resolved,
        "balls": [balls],
    }
    return Machine(
        name="planar", axis="vertical", rotor={"kind": "planar", "mass": 10.0, "stiffness": STIFFNESS, "damping": DAMPING},
        unbalances=[{"moment": UNBALANCE}], balancers=[{"races": [race]}], drive=DRIVE,
    )  # fmt: skip


def layer(law: str) -> ChamberMachine:
    places = [[0.0, ORBIT * math.cos(angle), ORBIT * math.sin(angle)] for angle in ANGLES]
    return ChamberMachine(
        name="layer", gravity=[0.0, 0.0, 0.0], drive=DRIVE, unbalances=[{"moment": UNBALANCE}],
        body={"freedom": "planar", "mass": 7.0, "inertia": [1e6, 1.0, 1.0]},
        supports=[{"position": [0.0, 0.0, 0.0], "stiffness": [STIFFNESS] * 3, "damping": [DAMPING] * 3}],
        rotor={"mass": 3.0, "polar_inertia": 0.02, "transverse_inertia": 0.02, "bearings": [0.1, -0.1]},
        chambers=[{"radius": WALL, "drag": DRAG, "balls": [BALLS | {"positions": places}]}],
        contact={
            "law": law, "restitution": RESTITUTION, "friction": FRICTION, "youngs_modulus": MODULUS, "poisson_ratio": POISSON,
        },
    )  # fmt: skip


@pytest.fixture(scope="module")
def resolved() -> Any:
    return simulate(planar(), duration=DURATION, save=[SampleTimes(1e-3 * np.arange(5001))], tolerance=1e-7)


@pytest.mark.parametrize(
    ("law", "steps", "angle", "deflection", "at_the_end"),
    [("history", 100, 5e-4, 3e-4, 1e-5), ("restitution", 25, 1.2e-2, 7e-3, 3e-4)],
)
def test_one_layer_moves_as_balls_resolved_in_the_plane(
    resolved: Any, law: str, steps: int, angle: float, deflection: float, at_the_end: float
) -> None:
    machine = layer(law)
    run = simulate_chamber(machine, duration=DURATION, step=contact_time(machine) / steps)
    place = ball_places_in_rotor(run).values
    turned = np.angle((place[:, :, 1] + 1j * place[:, :, 2]) * np.exp(-1j * resolved.ball_angle_in_rotor.values))
    gone = np.abs(resolved.ball_angle_in_rotor[-1] - resolved.ball_angle_in_rotor[0])
    assert float(gone.min()) > 30.0  # rad: they lag behind by many turns before they settle
    assert np.abs(turned).max() < angle
    assert np.abs(turned[4500:]).max() < at_the_end
    greatest = float(np.hypot(resolved.x, resolved.y).max())
    assert greatest > 1.5e-4
    assert np.abs(run.body_position.values[:, 1] - resolved.x.values).max() < deflection * greatest
    assert np.abs(run.body_position.values[:, 2] - resolved.y.values).max() < deflection * greatest
    assert np.abs(run.ball_position.values[:, :, 0]).max() == 0.0
    left = float(residual_of_balls(run, UNBALANCE)["static"][-1])
    balls = DENSITY * math.pi / 6.0 * DIAMETER**3 * ORBIT * np.exp(1j * resolved.ball_angle_in_rotor.values[-1])
    assert left == pytest.approx(abs(UNBALANCE + balls.sum()), abs=1e-3 * UNBALANCE)
    assert left < 0.02 * UNBALANCE


@pytest.mark.parametrize(("balls", "friction", "seed", "duration"), [(8, 0.9, 0, 1.1), (10, 0.7, 1, 1.4)])
def test_the_account_of_a_crowded_layer_closes_at_the_default_step(
    balls: int, friction: float, seed: int, duration: float
) -> None:
    deep = Path(__file__).parents[1] / "examples" / "machines" / "deep_chamber.toml"
    machine = ab.chamber.variant(balls_in_chambers(deep), balls=balls, friction=friction, layers="single")
    run = simulate_chamber(machine, duration=duration, seed=seed)
    losses = [run[name].values for name in run.data_vars if str(name).startswith("loss_")]
    exchanged = float(run.work_motor[-1]) + sum(float(loss[-1]) for loss in losses)
    # without the work of forces that jump from step to step it misses by 3 to 4 in a thousand of the work of the motor
    assert float(np.abs(run.energy_error).max()) < 1e-4 * exchanged
