"""The body of a deep chamber on its supports and let go: rigid rotor, balances, order of the steps."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from tests.references.chamber_machines import free_machine

import autobalancer as ab
from autobalancer.assembly.chamber_assembly import assemble_chamber
from autobalancer.kernels.chamber.time_steps import start
from autobalancer.machine import Machine
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.rotordynamics.campbell import modes
from autobalancer.simulation.chamber import simulate_chamber

FLOATING = [
    {"radius": 0.1, "depth": 0.1, "balls": [{"count": 1, "density": 7800.0, "mass": 0.02, "positions": [[0, 0, 0]]}]}
]
ARM, SPRING, DAMPER = 0.25, 9e3, 40.0
POINT = {"moment": 2e-3, "angle": 0.4, "position": 0.08}
PAIR = [
    {"moment": 1e-3, "angle": -1.0, "position": x, **({} if x > 0 else {"angle": math.pi - 1.0})} for x in (0.1, -0.1)
]


def hung(**changed: Any) -> ChamberMachine:
    """Body and rotor on four springs around the axis, without weight, with one ball that floats and touches nothing."""
    legs = [
        {"position": [x, y, z], "stiffness": [0, SPRING / 4, SPRING / 4], "damping": [0, DAMPER / 4, DAMPER / 4]}
        for x in (ARM, -ARM) for y, z in ((0.2, 0.0), (-0.2, 0.0), (0.0, 0.2), (0.0, -0.2))
    ]  # fmt: skip
    return free_machine(**({"supports": legs, "chambers": FLOATING} | changed))


def as_rigid_rotor() -> Machine:
    """The same as a rigid rotor on two supports: its mass and transverse inertia contain the body, its polar one does not."""
    return Machine(
        name="rigid",
        axis="vertical",
        rotor={
            "kind": "rigid", "mass": 23.0, "transverse_inertia": 0.82, "polar_inertia": 0.5,
            "supports": [{"position": x, "stiffness": SPRING, "damping": DAMPER} for x in (-ARM, ARM)],
        },
        drive={"kind": "speed", "profile": {"kind": "constant", "speed": 100.0}},
    )  # fmt: skip


def state_matrix(machine: ChamberMachine, speed: float) -> np.ndarray:
    """Of y, z, and the rotations about y and z, by differences of the accelerations."""
    chamber = assemble_chamber(machine, np.zeros((1, 3)), 1e-5)
    body, coordinates, step = chamber.body, [1, 2, 4, 5], 1e-5
    matrix = np.zeros((8, 8))
    matrix[:4, 4:] = np.eye(4)
    for i, (moved, coordinate) in enumerate([(part, c) for part in (body.place, body.rate) for c in coordinates]):
        ends = []
        for sign in (1.0, -1.0):
            body.place, body.rate = 0.0, 0.0
            body.rate[6] = speed
            moved[coordinate] = sign * step
            start(chamber)
            ends.append(body.acceleration[coordinates].copy())
        matrix[4:, i] = (ends[0] - ends[1]) / (2.0 * step)
    return matrix


def motor(speed: float) -> dict[str, Any]:
    """A motor without torque, and the speed at the start."""
    kind = {
        "kind": "asynchronous",
        "rated_torque": 0.0,
        "overload": 2.0,
        "synchronous_speed": 100.0,
        "breakdown_slip": 0.2,
    }
    return {"drive": kind, "start": {"speed": speed}}


def test_a_released_body_has_the_natural_frequencies_and_whirls_of_the_rigid_rotor() -> None:
    speed = 150.0
    values, vectors = np.linalg.eig(state_matrix(hung(**motor(speed)), speed))
    upper = np.argsort(values.imag)[4:]
    found = modes(as_rigid_rotor(), speed)
    order = np.argsort(found["frequency"].values)
    assert values[upper].imag == pytest.approx(found["frequency"].values[order], rel=1e-8)
    assert -values[upper].real == pytest.approx(found["decay_rate"].values[order], rel=1e-7)
    tilting = [i for i in upper if np.abs(vectors[2:4, i]).max() > np.abs(vectors[:2, i]).max()]
    # of a forward motion e^{iwt} the tilt about z follows that about y by a quarter of a turn
    turns = [float((vectors[3, i] / vectors[2, i]).imag) for i in tilting]
    assert turns == pytest.approx([1.0, -1.0], abs=1e-6)  # the slower one backward


@pytest.mark.parametrize("speed", [30.0, 160.0])
def test_a_released_body_answers_to_unbalance_and_couple_as_the_rigid_rotor(speed: float) -> None:
    drive = {"kind": "speed", "profile": {"kind": "constant", "speed": speed}}
    loads = [{"moment": 2e-3, "angle": 0.4, "station": 0.08}, {"couple": 2e-4, "angle": -1.0}]
    described = Machine(**(as_rigid_rotor().model_dump() | {"unbalances": loads}))
    expected = ab.rotor.response(described, [speed], [-ARM, ARM])
    # polar inertia of the rotor is large, so that the sign of the gyroscopic moment counts
    released = hung(drive=drive, unbalances=[POINT, *PAIR], contact={"stiffness": 1e2})
    run = simulate_chamber(released, duration=24.0, sample=2e-3, method="runge_kutta", step=1e-3).isel(
        time=slice(-500, None)
    )
    theta = run.rotor_angle.values
    basis = np.column_stack([np.cos(theta), -np.sin(theta)])
    for k, x in enumerate((-ARM, ARM)):
        y = run.body_position.values[:, 1] + x * run.body_rotation.values[:, 2]
        z = run.body_position.values[:, 2] - x * run.body_rotation.values[:, 1]
        for name, values in (("x", y), ("y", z)):
            wanted = complex(expected[f"{name}_real"][0, k], expected[f"{name}_imag"][0, k])
            found, *_ = np.linalg.lstsq(basis, values, rcond=None)
            assert complex(*found) == pytest.approx(wanted, abs=1e-5 * abs(wanted))
