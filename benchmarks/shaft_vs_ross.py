"""A shaft of 20 elements with a disk and two balls at constant speed: simulate against the time response of ROSS.

Both have the same matrices, those of ROSS. It integrates by the method of Newmark with a fixed step, and gets the forces of
the balls by its callback: their mass is on the disk, their angles go along by the second-order Adams-Bashforth method
with the acceleration of the disk, extrapolated by a step. Without reduction and with its modal reduction, its loosest
step that reaches the goal counts. A second row is its own time response with our balls in it. Where ROSS is not installed
(``pip install 'autobalancer[ross]'``, or ``make test-ross``, then ``.venv-ross/bin/python``) only our time is measured, on the
same shaft of our elements.
"""

from __future__ import annotations

import contextlib
import io
import math
from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from time import process_time
from typing import Any

import numpy as np

import autobalancer as ab
from autobalancer.machine import Machine
from autobalancer.rotordynamics.equivalent_planar import from_ross
from benchmarks import measured

SPEED, END, RISE, GOAL = 400.0, 1.0, 0.05, 1e-3  # rad/s, s, s; greatest miss over greatest deflection
ELEMENTS, LENGTH, DIAMETER, MIDDLE = 20, 0.5, 0.02, 10
DISK = {"m": 3.0, "Id": 0.008, "Ip": 0.015}
STIFFNESS, DAMPING = 1e5, 60.0
UNBALANCE = 1.5e-4  # kg m, rising from zero within RISE
MASS, ORBIT, DRAG, START = 2.5e-3, 0.05, 1.5e-4, (0.5 * math.pi, 1.5 * math.pi)
AT = np.linspace(0.0, END, 1001)
STEPS = (4e-4, 2e-4, 1e-4, 5e-5, 2.5e-5)  # s
REDUCED = {"method": "pseudomodal", "num_modes": 24}


def bench() -> list[dict[str, Any]]:
    """One row, with the peer where it is installed."""
    if find_spec("ross") is None:
        note = "ROSS is not installed, so there is no ratio: pip install 'autobalancer[ross]'"
        return [measured("shaft_vs_ross", our_time(own_shaft()), "s", note=note)]
    with contextlib.redirect_stdout(io.StringIO()):
        rotor = ross_shaft()
        shaft = from_ross(rotor).model_dump()
        exact = ours(shaft, 1e-12)
        peer, error, setting = fastest(exact)
    time = our_time(shaft)
    own = miss(ours(shaft), exact)
    note = f"{END:g} s, {AT.size} samples, errors at most {GOAL:g}; ours: {own:.0e}; theirs: {setting}, {error:.0e}"
    row = measured("shaft_vs_ross", time, "s", note=note) | {"peer": "ROSS, Newmark", "ratio": peer / time}
    return [row, inside(exact, peer)]


def inside(exact: np.ndarray, peer: float) -> dict[str, Any]:
    """The time response of ROSS itself with the element of this package, at its loosest step that reaches the goal."""
    with contextlib.redirect_stdout(io.StringIO()):
        rotor = ross_shaft()
        host = ab.balancer_element(with_balls(from_ross(rotor).model_dump())).in_ross(rotor, [MIDDLE])
        for step in STEPS:
            t, force = load(rotor, step)

            def call(t: np.ndarray = t, force: np.ndarray = force) -> np.ndarray:
                found = host.run_time_response(SPEED, force, t, model_reduction=dict(REDUCED)).yout
                return at_samples(rotor, t, found)

            error = miss(call(), exact)
            if error <= GOAL:
                break
        time = min(timed(call)[0] for _ in range(5))
    note = f"24 modes, steps of {step:g} s, {error:.0e}, balls found with the rotor; theirs: the callback of ROSS"
    return measured("balls_in_ross", time, "s", note=note) | {"peer": "ROSS, Newmark", "ratio": peer / time}


def our_time(shaft: dict[str, Any]) -> float:
    """Least time of five runs, s; one before them, which may compile, is not counted."""
    ours(shaft)
    return min(timed(lambda: ours(shaft))[0] for _ in range(5))


def timed(call: Callable[[], np.ndarray]) -> tuple[float, np.ndarray]:
    """Processor time of a call, and what it returns."""
    start = process_time()
    found = call()
    return process_time() - start, found


def miss(found: np.ndarray, exact: np.ndarray) -> float:
    """Greatest distance of the deflections, complex, over the greatest deflection."""
    return float(np.abs(found - exact).max() / np.abs(exact).max())


def own_shaft() -> dict[str, Any]:
    """The shaft, described for this package."""
    steel = {"density": 7810.0, "youngs_modulus": 211e9, "poisson_ratio": 0.3}
    ends = [{"position": z, "stiffness": STIFFNESS, "damping": DAMPING} for z in (0.0, LENGTH)]
    disk = {"position": 0.5 * LENGTH, "mass": DISK["m"]}
    disk |= {"transverse_inertia": DISK["Id"], "polar_inertia": DISK["Ip"]}
    segment = {"length": LENGTH, "diameter": DIAMETER, "elements": ELEMENTS}
    return {"kind": "shaft", "material": steel, "segments": [segment], "disks": [disk], "supports": ends}


def ours(shaft: dict[str, Any], tolerance: float = 1e-6) -> np.ndarray:
    """Deflection of the disk by ``simulate``."""
    run = ab.simulate(with_balls(shaft), duration=END, save=ab.SampleTimes(AT.tolist()), tolerance=tolerance)
    return np.asarray(run["x"].values + 1j * run["y"].values)


def with_balls(shaft: dict[str, Any]) -> Machine:
    """The machine: the shaft with two balls at its disk."""
    station = 0.5 * LENGTH
    balls = {"count": 2, "mass": MASS, "motion": "point", "start_angles": START}
    return Machine.model_validate({
        "name": "shaft with two balls", "axis": "vertical", "rotor": shaft,
        "unbalances": [{"moment": UNBALANCE, "station": station, "schedule": {"time": [0.0, RISE], "factor": [0.0, 1.0]}}],
        "balancers": [{
            "station": station,
            "races": [{"orbit_radius": ORBIT, "drag": {"law": "viscous", "damping": DRAG}, "balls": [balls]}],
        }],
        "drive": {"kind": "speed", "profile": {"kind": "constant", "speed": SPEED}},
    })  # fmt: skip


# ROSS -------------------------------------------------------------------------------------------------------------------


def ross_shaft(balls: bool = False) -> Any:
    """The same rotor of ROSS; ``balls`` puts their mass on the disk."""
    ross = import_module("ross")
    steel = ross.Material(name="steel", rho=7810.0, E=211e9, Poisson=0.3)
    shaft = [ross.ShaftElement(LENGTH / ELEMENTS, 0.0, DIAMETER, material=steel) for _ in range(ELEMENTS)]
    disk = DISK | {"m": DISK["m"] + (2.0 * MASS if balls else 0.0)}
    ends = [ross.BearingElement(n=n, kxx=STIFFNESS, cxx=DAMPING) for n in (0, ELEMENTS)]
    return ross.Rotor(shaft, [ross.DiskElement(n=MIDDLE, **disk)], ends)


def fastest(exact: np.ndarray) -> tuple[float, float, str]:
    """Time, error and setting of the fastest run of ROSS that reaches the goal."""
    best = (math.inf, math.nan, "none reaches the goal")
    rotor = ross_shaft(balls=True)
    for name, options in (("all coordinates", {}), ("24 modes", {"model_reduction": REDUCED})):
        theirs(rotor, STEPS[0], options)
        for step in STEPS:
            time, found = timed(lambda step=step, options=options: theirs(rotor, step, options))
            if (error := miss(found, exact)) <= GOAL:
                if time < best[0]:
                    best = (time, error, f"{name}, steps of {step:g} s")
                break
    return best


def theirs(rotor: Any, step: float, options: dict[str, Any]) -> np.ndarray:
    """Deflection of the disk by ROSS at the samples."""
    t, force = load(rotor, step)
    balls = Balls(rotor.number_dof * MIDDLE, t, rotor.ndof)
    _, found = rotor.integrate_system(
        SPEED, force, t, add_to_RHS=balls.force, **{k: dict(v) for k, v in options.items()}
    )
    return at_samples(rotor, t, found)


def load(rotor: Any, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Times with this step, and the force of the unbalance on all coordinates of ROSS."""
    t = np.linspace(0.0, END, round(END / step) + 1)
    size, row = UNBALANCE * SPEED**2 * np.minimum(t / RISE, 1.0), rotor.number_dof * MIDDLE
    force = np.zeros((t.size, rotor.ndof))
    force[:, row], force[:, row + 1] = size * np.cos(SPEED * t), size * np.sin(SPEED * t)
    return t, force


def at_samples(rotor: Any, t: np.ndarray, found: np.ndarray) -> np.ndarray:
    """Deflection of the disk at the samples, from all coordinates of ROSS over its times."""
    row = rotor.number_dof * MIDDLE
    return np.asarray(np.interp(AT, t, found[:, row]) + 1j * np.interp(AT, t, found[:, row + 1]))


class Balls:
    """Two balls on their race, advanced a step whenever ROSS asks for their force."""

    def __init__(self, row: int, t: np.ndarray, size: int) -> None:
        self.row, self.t, self.size = row, t, size
        self.angle, self.speed = np.array(START), np.zeros(2)
        self.rate, self.last_rate = np.zeros(2), np.zeros(2)
        self.last = np.zeros(2)

    def force(self, step: int, **state: Any) -> np.ndarray:
        """Force of the balls at the end of a step, all but that of their mass on the disk."""
        h, row = state["time_step"], self.row
        now = np.asarray(state["accl_resp"][row : row + 2])
        self.rate = self._rate(SPEED * self.t[step - 1], now)
        if step == 1:
            self.last_rate = self.rate
        self.angle = self.angle + h * self.speed + h * h * (4.0 * self.rate - self.last_rate) / 6.0
        self.speed = self.speed + h * (1.5 * self.rate - 0.5 * self.last_rate)
        ahead, self.last, self.last_rate = 2.0 * now - self.last, now, self.rate
        rate = self._rate(SPEED * self.t[step], ahead)
        where = SPEED * self.t[step] + self.angle
        pull, push = MASS * ORBIT * (SPEED + self.speed) ** 2, MASS * ORBIT * rate
        out = np.zeros(self.size)
        out[row] = (pull * np.cos(where) + push * np.sin(where)).sum()
        out[row + 1] = (pull * np.sin(where) - push * np.cos(where)).sum()
        return out

    def _rate(self, turned: float, acceleration: np.ndarray) -> np.ndarray:
        where = turned + self.angle
        along = np.sin(where) * acceleration[0] - np.cos(where) * acceleration[1]
        return np.asarray(along / ORBIT - DRAG / (MASS * ORBIT**2) * self.speed)
