"""Resolved balls in machines that are shaken."""

from __future__ import annotations

import cmath
import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from tests.references.resolved import BALL, chamber, contact, run
from tests.references.resolved_run_ups import GRIP, PLANAR, RIGID, apart, run_up

from autobalancer.kernels import records as at
from autobalancer.machine import Machine

RECORD = np.linspace(0.0, 0.3, 61)
SHAKES: list[dict[str, Any]] = [
    {"kind": "base_motion", "displacement": 1e-4, "frequency": 220.0, "direction": 0.5},
    {"kind": "base_motion", "acceleration": 30.0, "order": 0.5, "direction": 1.0},
    {"kind": "force", "force": 60.0, "frequency": 300.0},
    {
        "kind": "recorded_base_motion", "time": RECORD.tolist(), "direction": 2.0,
        "acceleration": (40.0 * np.sin(40.0 * RECORD)).tolist(),
    },
    {"kind": "recorded_force", "time": RECORD.tolist(), "force": (200.0 * np.sin(30.0 * RECORD)).tolist()},
]  # fmt: skip
FIRM = {"mass": 1e8, "stiffness": 1e17, "damping": 3e12}


@pytest.mark.parametrize("rotor", [PLANAR, RIGID], ids=["planar", "rigid"])
@pytest.mark.parametrize("torque", [False, True], ids=["speed", "torque"])
def test_stiff_balls_in_a_shaken_machine_run_up_like_guided_ones(rotor: dict[str, Any], torque: bool) -> None:
    """Under all excitations at once, each of which matters."""
    where = {"station": -0.05} if rotor is RIGID else {}
    shakes = [s | where if "force" in s else s for s in SHAKES]
    guided = run_up(rotor=rotor, torque=torque, excitations=shakes)
    for number in range(len(shakes) if rotor is PLANAR and not torque else 0):
        fewer = shakes[:number] + shakes[number + 1 :]
        assert apart(guided, run_up(rotor=rotor, torque=torque, excitations=fewer)) > 0.1
    law = contact(stiffness=1e7, slip_speed=0.01, **GRIP)
    assert apart(guided, run_up(law, rotor=rotor, torque=torque, excitations=shakes)) < 5e-3


def shaken(machine: Machine, *excitations: dict[str, Any]) -> Machine:
    return Machine(**{**{key: getattr(machine, key) for key in machine.model_fields_set}, "excitations": excitations})


def test_a_ball_that_touches_nothing_stays_behind_when_the_base_is_pushed() -> None:
    push = {"kind": "recorded_base_motion", "time": [0.0, 1.0, 2.0], "acceleration": [3.0] * 3, "direction": 0.7}
    machine = shaken(chamber(rotor=FIRM, start_gap=0.1), push)
    _, own, _ = run(machine, [0.0, 0.2])
    found = complex(own[1, 0, at.BALL_X], own[1, 0, at.BALL_Y])
    assert found == pytest.approx(-0.5 * 3.0 * 0.2**2 * cmath.exp(0.7j), abs=1e-7)


def test_a_ball_in_a_shaken_turning_oval_moves_as_an_independent_solution_in_space_says() -> None:
    """Newton's laws of ball and spin in space; the chamber is a moving, turning curve whose foot point is searched for."""
    mass, radius, k, mu, slip_speed, w = 5e-3, 5e-3, 2e4, 0.2, 0.05, 50.0
    size, fast, direction, wave, crest, gravity = 2e-3, 130.0, 0.4, 2e-3, 0.8, 9.80665
    machine = shaken(
        chamber(
            axis="horizontal", rotor=FIRM, speed=w, restitution=1.0, stiffness=k, sliding_friction=mu, slip_speed=slip_speed,
            race={"harmonics": [{"order": 2, "amplitude": wave, "angle": crest}]}, start_gap=4e-3, balls=BALL,
        ),
        {"kind": "base_motion", "displacement": size, "frequency": fast, "direction": direction},
    )  # fmt: skip
    times = np.linspace(0.0, 0.15, 31)
    _, own, assembly = run(machine, times, tolerance=1e-12)

    def orbit(angle: float) -> tuple[complex, complex]:
        turned = cmath.exp(1j * angle)
        length = 0.1 + wave * math.cos(2.0 * (angle - crest))
        return length * turned, (1j * length - 2.0 * wave * math.sin(2.0 * (angle - crest))) * turned

    def base(time: float) -> tuple[complex, complex]:
        along = size * cmath.exp(1j * direction)
        return along * math.cos(fast * time), -fast * along * math.sin(fast * time)

    def newton(time: float, y: Any) -> list[float]:
        turn, (at_base, moving) = cmath.exp(1j * w * time), base(time)
        place = (complex(y[0], y[1]) - at_base) / turn
        velocity = (complex(y[2], y[3]) - moving) / turn - 1j * w * place
        force = torque = 0.0
        angle = cmath.phase(place)
        if abs(place) > abs(orbit(angle)[0]):
            foot = brentq(
                lambda a: ((place - orbit(a)[0]) * orbit(a)[1].conjugate()).real, angle - 0.1, angle + 0.1, xtol=1e-14
            )
            normal = -1j * orbit(foot)[1] / abs(orbit(foot)[1])
            pressed = k * abs(place - orbit(foot)[0])
            slip = (velocity * (1j * normal).conjugate()).real + radius * (y[4] - w)
            rub = mu * pressed * math.tanh(slip / slip_speed)
            force, torque = -pressed * normal - rub * 1j * normal, -radius * rub
        pull = force * turn / mass - 1j * gravity
        return [y[2], y[3], pull.real, pull.imag, torque / (0.4 * mass * radius**2)]

    first = complex(own[0, 0, at.BALL_X], own[0, 0, at.BALL_Y])
    going = complex(own[0, 0, at.BALL_VX], own[0, 0, at.BALL_VY]) + 1j * w * first
    first += base(0.0)[0]
    start = [first.real, first.imag, going.real, going.imag, own[0, 0, at.BALL_SPIN] + w]
    path = solve_ivp(newton, (0.0, 0.15), start, t_eval=times, method="DOP853", rtol=1e-10, atol=1e-12)
    found = (own[:, 0, at.BALL_X] + 1j * own[:, 0, at.BALL_Y]) * np.exp(1j * w * times)
    expected = path.y[0] + 1j * path.y[1] - np.array([base(time)[0] for time in times])
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-6)
    # with ever finer steps 7e-7 m and 0.01 rad/s of 100 remain: the rotor is not quite firm
    np.testing.assert_allclose(own[:, 0, at.BALL_SPIN] + w, path.y[4], rtol=0.0, atol=2e-2)
    assert np.ptp(path.y[4]) > 100.0
    assert assembly.system.rotating == 0.0
