"""The planar machine by heyoka: its own derivation from the Lagrangian, its own Taylor integrator."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.references import lagrange
from tests.references.motion import motion
from tests.references.runs import states_at

from autobalancer.assembly.system import assemble
from autobalancer.machine import Machine


def equations(machine: Machine) -> list[Any]:
    """Explicit Euler-Lagrange equations, in the order of the package's state in axes at rest."""
    hy = pytest.importorskip("heyoka")  # loading it takes half a second: not where tests are only collected
    p = lagrange.planar(machine)  # numbers only
    n = p.balls
    x, y, theta, *phi = q = hy.make_vars("x", "y", "theta", *(f"phi{i}" for i in range(n)))
    vx, vy, w, *rate = v = hy.make_vars("vx", "vy", "w", *(f"rate{i}" for i in range(n)))
    u, drive = machine.unbalances[0], machine.drive
    angle = theta + float(u.angle)
    kinetic = 0.5 * p.mass * (vx**2 + vy**2) + 0.5 * p.inertia * w**2
    kinetic += u.size * w * (hy.cos(angle) * vy - hy.sin(angle) * vx)
    potential = 0.5 * p.stiffness[0] * x**2 + 0.5 * p.stiffness[1] * y**2 - drive.torque * theta  # type: ignore[union-attr]
    potential -= p.gravity[1] * u.size * hy.sin(angle)
    loss = 0.5 * p.damping[0] * vx**2 + 0.5 * p.damping[1] * vy**2 + 0.5 * drive.damping * w**2  # type: ignore[union-attr]
    for i in range(n):
        shift, at = abs(p.center[i]), theta + float(np.angle(p.center[i]))
        bx = vx - shift * w * hy.sin(at) - p.orbit[i] * (w + rate[i]) * hy.sin(theta + phi[i])
        by = vy + shift * w * hy.cos(at) + p.orbit[i] * (w + rate[i]) * hy.cos(theta + phi[i])
        height = y + shift * hy.sin(at) + p.orbit[i] * hy.sin(theta + phi[i])
        kinetic += 0.5 * p.effective_mass[i] * (bx**2 + by**2) + 0.5 * p.fluid_mass[i] * (p.orbit[i] * rate[i]) ** 2
        kinetic += 0.5 * p.own[i] * (w + p.turn[i] * rate[i]) ** 2
        potential -= p.gravity[1] * p.effective_mass[i] * height
        loss += 0.5 * p.drag[i] * rate[i] ** 2
    found = {str(variable): rhs for variable, rhs in hy.lagrangian(kinetic - potential, q, v, loss)}
    order = [x, y, vx, vy, theta, w, *phi, *rate]
    return [(variable, found[str(variable)]) for variable in order]


BALL = {"diameter": 8e-3, "mass": 2.5e-3}


def machine(races: list[dict[str, Any]], **changes: Any) -> Machine:
    data: dict[str, Any] = {
        "name": "as in heyoka",
        "axis": "vertical",
        "rotor": {"mass": 10.0, "stiffness": 6.25e5, "damping": 100.0, "inertia": 0.05},
        "unbalances": [{"moment": 5e-4, "angle": 0.3}],
        "balancers": [{"races": [race | {"collisions": False} for race in races]}],
        "drive": {"kind": "torque", "torque": 8.0, "damping": 5e-3},
        "start": {"speed": 150.0},
    }
    return Machine(**(data | changes))


DRAG = {"law": "viscous", "damping": 1.5e-4}
CENTERED = {"orbit_radius": 0.1, "drag": DRAG, "balls": [BALL | {"count": 2, "start_angles": [1.0, -1.9]}]}
OFF_CENTER = {
    "race_radius": 0.1,
    "eccentricity": 2e-3,
    "eccentricity_angle": 0.8,
    "drag": DRAG,
    "balls": [BALL | {"start_angles": 1.0}],
}
WET = {
    "orbit_radius": 0.07,
    "fluid": {"density": 900.0, "viscosity": 2e-5},
    "drag": {"law": "cd_times_re", "cd_times_re": 300.0},
    "balls": [{"diameter": 0.012, "density": 7800.0, "start_angles": -2.0, "start_speeds": -15.0}],
}
CASES = {
    "rolling balls through resonance": machine([CENTERED]),
    "two races, one off center, one with fluid": machine([OFF_CENTER, WET], start={"speed": 240.0}),
    "horizontal axis on unequal supports": machine(
        [OFF_CENTER, WET],
        axis="horizontal",
        rotor={"mass": 10.0, "stiffness": [6.25e5, 5e5], "damping": [100.0, 130.0], "inertia": 0.05},
        start={"speed": 60.0},
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_heyoka_moves_the_same_machine_in_the_same_way(name: str) -> None:
    case = CASES[name]
    times = np.linspace(0.0, 1.5, 151)
    start = assemble(case, rotating=False).state
    hy = pytest.importorskip("heyoka")
    taylor = hy.taylor_adaptive(equations(case), start, tol=1e-16, compact_mode=True)
    theirs = motion(case, taylor.propagate_grid(times)[-1])
    ours = motion(case, states_at(case, times))
    assert np.abs(theirs.deflection).max() > 5e-5
    assert np.ptp(theirs.angles[:, 0]) > 0.5
    np.testing.assert_allclose(ours.deflection, theirs.deflection, rtol=0.0, atol=1e-13)
    for one, other in ((ours.rotor_angle, theirs.rotor_angle), (ours.rotor_speed, theirs.rotor_speed)):
        np.testing.assert_allclose(one, other, rtol=0.0, atol=1e-10)
    np.testing.assert_allclose(ours.angles, theirs.angles, rtol=0.0, atol=1e-10)
