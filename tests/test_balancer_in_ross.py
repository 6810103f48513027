"""A rotor of ROSS with balancers: the same machine by this package and on the matrices of ROSS, to 1e-6 and better."""

from __future__ import annotations

from copy import copy
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import eigvals
from scipy.optimize import brentq

import autobalancer as ab
from autobalancer.errors import QuestionError
from autobalancer.machine import Machine
from autobalancer.rotordynamics.equivalent_planar import from_ross
from autobalancer.simulation.balancer_element import BalancerElement

SAME = 1e-6
MOMENT, ORBIT, MASS, MIDDLE = 4e-4, 0.06, 8e-3, 1
ROUND = ({"kxx": 4e4, "cxx": 40.0}, {"kxx": 4e4, "cxx": 40.0})
STIFF = ({"kxx": 9e4, "cxx": 90.0}, {"kxx": 7e4, "cxx": 90.0})
UNEVEN = (
    {"kxx": 4e4, "kyy": 6e4, "cxx": 40.0, "cyy": 60.0},
    {"kxx": 4e4, "kyy": 5e4, "kxy": 3e2, "kyx": -3e2, "cxx": 50.0},
)
BEARINGS = {"round": ROUND, "stiff": STIFF, "uneven": UNEVEN}
CONSTANT = {"kind": "constant", "speed": 160.0}
RAMP = {"kind": "ramp", "start": 100.0, "end": 200.0, "duration": 0.2}


@pytest.fixture(scope="module")
def ross() -> Any:
    return pytest.importorskip(
        "ross", reason="needs ROSS, which `make test-ross` installs in an environment of its own", exc_type=ImportError
    )


def rotor(ross: Any, name: str, mass: float = 0.0) -> Any:
    """Two elements of a soft material, which has no fast modes, and a disk; ``mass`` is more at the disk."""
    soft = ross.Material(name="soft", rho=1200.0, E=3e8, G_s=1.1e8)
    disk = ross.DiskElement(n=MIDDLE, m=3.0 + mass, Id=0.008, Ip=0.015)
    ends = [ross.BearingElement(n=n, **given) for n, given in zip((0, 2), BEARINGS[name], strict=True)]
    return ross.Rotor([ross.ShaftElement(0.25, 0.0, 0.05, material=soft) for _ in range(2)], [disk], ends)


def machine(given: Any, profile: dict[str, Any] = CONSTANT, **more: Any) -> Machine:
    """The rotor of ROSS with two balls; all of its coordinates are kept."""
    balls = {"count": 2, "mass": MASS, "motion": "point", "start_angles": [1.0, 4.5]}
    race = {"orbit_radius": ORBIT, "drag": {"law": "viscous", "damping": 2e-4}, "collisions": False, "balls": [balls]}
    data = {
        "name": "from ROSS", "axis": "vertical", "rotor": from_ross(given).model_dump() | {"modes": 12},
        "unbalances": [{"moment": MOMENT, "station": 0.25}], "balancers": [{"station": 0.25, "races": [race]}],
        "drive": {"kind": "speed", "profile": profile},
    }  # fmt: skip
    return Machine.model_validate(data | more)


def matrices(given: Any) -> tuple[np.ndarray, ...]:
    """M, G, C, K of ROSS over x, y, alpha and beta of each node, and the row of the disk for x, y, dx/dz, dy/dz."""
    pick = [6 * node + c for node in range(len(given.nodes)) for c in (0, 1, 3, 4)]
    some = (given.M(), given.G(), given.C(0.0), given.K(0.0))
    rows = np.zeros((4, len(pick)))
    for row, (place, sign) in enumerate(((0, 1.0), (1, 1.0), (3, 1.0), (2, -1.0))):
        rows[row, 4 * MIDDLE + place] = sign
    return (*(np.asarray(one)[np.ix_(pick, pick)] for one in some), rows)


def rates_on_ross(given: Any, element: BalancerElement) -> Any:
    """Accelerations of the coordinates and rates of the balls: the matrices of ROSS, its unbalance, and the element.

    With w' the gyroscopic effect has w' G/2, as here; ROSS has another matrix there, ``Ksdt``, from another angle of spin.
    """
    mass, gyroscopic, damping, stiffness, rows = matrices(given)
    rows = rows[: len(element.rows)]
    inverse, wide = np.linalg.inv(mass), np.vstack([rows, np.zeros(rows.shape[1])])
    mobility = wide @ inverse @ wide.T

    def found(q: Any, v: Any, balls: Any, angle: float, speed: float, acceleration: float) -> tuple[Any, Any]:
        u = MOMENT * np.exp(1j * angle) * (speed**2 - 1j * acceleration)
        push = (
            rows[:2].T @ [u.real, u.imag]
            - (damping + speed * gyroscopic) @ v
            - (stiffness + 0.5 * acceleration * gyroscopic) @ q
        )
        moved = inverse @ push
        free = np.append(rows @ moved, acceleration)
        force, changed = element.coupled(
            0.0, np.append(rows @ q, rows @ v), np.array([angle, speed]), balls, free, mobility
        )
        return moved + inverse @ rows.T @ force[:-1], changed

    return found, rows


def run_on_ross(given: Any, one: Machine, times: np.ndarray, start: float, growth: float) -> tuple[Any, Any]:
    """Deflection of the disk and ball angles by SciPy; the speed grows evenly."""
    element = ab.balancer_element(one)
    found, rows = rates_on_ross(given, element)
    size = rows.shape[1]

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        q, v, balls = y[:size], y[size : 2 * size], y[2 * size :]
        accelerations, changed = found(q, v, balls, start * t + 0.5 * growth * t * t, start + growth * t, growth)
        return np.concatenate([v, accelerations, changed])

    y = solve_ivp(
        rates, (0.0, times[-1]), np.append(np.zeros(2 * size), element.state), "DOP853", times, rtol=1e-10, atol=1e-12
    ).y
    return y[4 * MIDDLE] + 1j * y[4 * MIDDLE + 1], y[2 * size : 2 * size + 2].T


@pytest.mark.parametrize("name", ["round", "uneven"])
def test_modes_with_the_mass_of_the_balls_are_those_of_ross(ross: Any, name: str) -> None:
    theirs = rotor(ross, name, 2 * MASS).run_modal(speed=160.0, num_modes=24)
    ours = ab.rotor.modes(machine(rotor(ross, name)), 160.0, modes=4)
    np.testing.assert_allclose(np.sort(ours["frequency"].values), np.sort(theirs.wd)[:4], rtol=SAME)


@pytest.mark.parametrize("name", ["round", "uneven"])
def test_the_response_with_held_balls_is_that_of_ross(ross: Any, name: str) -> None:
    speeds = np.linspace(40.0, 240.0, 6)
    theirs = rotor(ross, name, 2 * MASS).run_unbalance_response(MIDDLE, MOMENT, 0.0, speeds)
    ours = ab.rotor.response(machine(rotor(ross, name)), speeds, balls=True)
    expected = theirs.forced_resp[6 * MIDDLE]
    np.testing.assert_allclose((ours["x_real"] + 1j * ours["x_imag"]).values.squeeze(), expected, rtol=SAME)


@pytest.mark.parametrize("name", ["round", "stiff"])
def test_the_exact_border_is_where_the_balanced_state_on_the_matrices_of_ross_becomes_stable(
    ross: Any, name: str
) -> None:
    """Eigenvalues in axes that turn with the rotor, by differences of the rates."""
    given = rotor(ross, name)
    one = machine(given)
    (border,) = [b for b in ab.stability.borders(one) if b.name == "exact border"]
    found, rows = rates_on_ross(given, ab.balancer_element(one))
    size = rows.shape[1]
    spin = np.kron(np.eye(size // 2), [[0.0, -1.0], [1.0, 0.0]])
    angle = np.arccos(-MOMENT / (2 * MASS * ORBIT))
    balanced = np.concatenate([np.zeros(2 * size), [angle, -angle, 0.0, 0.0]])

    def growth(speed: float) -> float:
        def rates(y: np.ndarray) -> np.ndarray:
            q, v, balls = y[:size], y[size : 2 * size], y[2 * size :]
            accelerations, changed = found(q, v, balls, 0.0, speed, 0.0)
            return np.concatenate([v - speed * spin @ q, accelerations - speed * spin @ v, changed])

        steps = np.repeat([1e-5, 1e-3, 1e-4, 1e-2], [size, size, 2, 2])
        jacobian = [
            (8 * (rates(balanced + h) - rates(balanced - h)) - rates(balanced + 2 * h) + rates(balanced - 2 * h))
            / (12 * h.sum())
            for h in np.diag(steps)
        ]
        return float(eigvals(np.transpose(jacobian)).real.max())

    assert border.speed == pytest.approx(brentq(growth, 0.98 * border.speed, 1.02 * border.speed, xtol=1e-8), rel=SAME)


@pytest.mark.parametrize(
    ("name", "profile", "more"),
    [
        ("round", CONSTANT, {}),
        ("uneven", CONSTANT, {}),
        ("round", RAMP, {}),
        ("uneven", RAMP, {}),
        ("uneven", CONSTANT, {"tilting_races": "full"}),
    ],
)
def test_a_run_on_the_matrices_of_ross_is_that_of_simulate(ross: Any, name: str, profile: Any, more: Any) -> None:
    given, times = rotor(ross, name), np.linspace(0.0, 0.2, 11)
    one = machine(given, profile, **more)
    start, growth = (100.0, 500.0) if profile is RAMP else (160.0, 0.0)
    deflection, angles = run_on_ross(given, one, times, start, growth)
    run = ab.simulate(one, duration=0.2, save=ab.SampleTimes(times.tolist()), tolerance=1e-11)
    ours = run["x"].values + 1j * run["y"].values
    np.testing.assert_allclose(deflection, ours, rtol=0.0, atol=SAME * np.abs(ours).max())
    np.testing.assert_allclose(angles, run["ball_angle_in_rotor"].values, rtol=0.0, atol=SAME)


@pytest.mark.parametrize("profile", [CONSTANT, RAMP])
def test_the_time_response_of_ross_with_balls_is_that_of_simulate(ross: Any, profile: dict[str, Any]) -> None:
    """Its error falls with the square of the step, so two steps give it without: Richardson."""
    given = rotor(ross, "uneven")
    one, found = machine(given, profile), []
    like_ours = copy(given)
    like_ours.Ksdt = lambda: 0.5 * given.G()
    host = ab.balancer_element(one).in_ross(like_ours, [MIDDLE])
    for steps in (8000, 16000):
        t = np.linspace(0.0, 0.2, steps + 1)
        speed = 100.0 + 500.0 * t if profile is RAMP else 160.0
        growth = 500.0 if profile is RAMP else 0.0
        force = np.zeros((t.size, given.ndof))
        push = MOMENT * np.exp(1j * (100.0 * t + 250.0 * t**2 if profile is RAMP else 160.0 * t))
        push *= np.asarray(speed) ** 2 - 1j * growth
        force[:, 6 * MIDDLE], force[:, 6 * MIDDLE + 1] = push.real, push.imag
        result = host.run_time_response(speed, force, t)
        found.append((result.yout[:: steps // 20, 6 * MIDDLE], result.xout[:: steps // 20, :2]))
    times = np.linspace(0.0, 0.2, 21)
    run = ab.simulate(one, duration=0.2, save=ab.SampleTimes(times.tolist()), tolerance=1e-11)
    for fine, coarse, name in zip(found[1], found[0], ("x", "ball_angle_in_rotor"), strict=True):
        expected = run[name].values
        np.testing.assert_allclose((4.0 * fine - coarse) / 3.0, expected, rtol=0.0, atol=SAME * np.abs(expected).max())
    assert type(result).__name__ == "TimeResponseResults"
    assert result.plot_2d(node=MIDDLE).data  # a figure of ROSS


def test_nodes_and_options_that_do_not_fit_are_refused(ross: Any) -> None:
    given = rotor(ross, "round")
    element = ab.balancer_element(machine(given))
    with pytest.raises(QuestionError, match=r"nodes: given \[0, 1\]; must be one for each of 1 planes, 0 to 2"):
        element.in_ross(given, [0, 1])
    with pytest.raises(QuestionError, match="in_ross: ic: not possible with balls"):
        element.in_ross(given, [1]).time_response(100.0, np.zeros((2, 18)), np.array([0.0, 1e-3]), ic=np.zeros(36))
