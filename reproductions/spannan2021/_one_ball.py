"""One ball in the annulus of the discoidal rig, from its floor on: section 6.1.8, ten run-ups in each of three oils.

``python -m reproductions.spannan2021._one_ball`` writes ``data/one_ball_<viscosity>_mm2_s_<rolling>.csv``, in some minutes:
what figures 6.25 to 6.27 draw of ten run-ups, whose ball lies at another place of the floor each time.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

import autobalancer as ab
from autobalancer.assembly.quantities import with_value_at
from autobalancer.files.examples import rig
from autobalancer.machine import Machine

DATA = Path(__file__).parent / "data"
DENSITY = {5: 844.0, 20: 955.0, 50: 950.0}  # kg/m^3 by mm^2/s: tables 6.3 and 6.1
TIMES, SPEEDS = [0.0, 5.0, 140.0], [0.0, 12.7, 1200.0 * math.pi / 30.0]  # s, rad/s: section 6.1.2, as in figure 6.12
END, RATE = 145.0, 100  # s, samples per second
STEP = 1.0  # s, of the data
BALL = {"mass": 5.4e-3, "diameter": 10.95e-3, "motion": "rolling"}  # 4.75 g less than which it displaces: 6.1.6
ROOM = 13.8e-3 - 10.95e-3  # m, between the walls
RUNS = 10
ROLLING = (0.001, 0.002)  # both meet the five speeds of 6.1.7 on this rig
TURN = 2.0 * math.pi
CONTACT = {  # friction of walls and floor is assumed, as in the sample resolved_balls
    "stiffness": 3e4,
    "restitution": 0.3,
    "sliding_friction": 0.1,
    "floor_friction": 0.15,
    "slip_speed": 0.02,
    "rest_speed": 1e-3,
}
RACE = "balancers[1].races[1]"


def starts() -> list[tuple[float, float]]:
    """Angle from the unbalance (rad) and distance from the wall (m) of the ball in each of the run-ups."""
    places = np.random.default_rng(625).uniform((-math.pi, 0.05 * ROOM), (math.pi, 0.95 * ROOM), (RUNS, 2))
    return [(float(angle), float(gap)) for angle, gap in places]


def machine(
    viscosity: int,
    start: tuple[float, float],
    *,
    floor: str = "rolling",
    rolling: float = ROLLING[0],
    guided: bool = False,
) -> Machine:
    """The rig on softening rubber with a ball on the floor of its annulus, or guided from the first instant on."""
    given = rig("discoidal_rig_rubber")
    race: dict[str, Any] = {
        "orbit_radius": given.balancers[0].races[0].orbit_radius,
        "width": 13.8e-3,
        "height": 20e-3,
        "fluid": {"density": DENSITY[viscosity], "viscosity": viscosity * 1e-6, "lag": "modes"},
        "drag": {"law": "discoidal"},
        "friction": {"rolling_resistance": rolling, "adherence": rolling},
        "balls": [BALL | {"start_angles": [start[0]]}],
    }
    if not guided:
        race["resolved"] = CONTACT | {"floor_motion": floor, "start_gap": start[1]}
    return with_speeds(with_value_at(given, RACE, race))


def with_speeds(given: Machine) -> Machine:
    """The machine with the run-up of the rig."""
    return with_value_at(given, "drive.profile", {"kind": "table", "time": TIMES, "speed": SPEEDS})


def bare() -> Machine:
    """The rig without a ball."""
    return with_speeds(with_value_at(rig("discoidal_rig_rubber"), "balancers", ()))


def simulated(given: Machine, end: float = END) -> xr.Dataset:
    """A run, sampled and with its last turns."""
    return ab.simulate(
        given, duration=end, save=[ab.Samples(round(RATE * end) + 1), ab.LastRevolutions(5)], tolerance=1e-6
    )


def at_laser(run: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Middles of the steps of the data (s), and the greatest deflection at the laser in each (m)."""
    there = run.sel(station="laser")
    size = np.hypot(there["station_x"].values, there["station_y"].values)
    each = round(RATE * STEP)
    count = size.size // each
    return STEP * (np.arange(count) + 0.5), size[: count * each].reshape(count, each).max(axis=1)


def turns(run: xr.Dataset) -> np.ndarray:
    """Turns of the ball in the rotor, counted from the unbalance, at each sample."""
    return np.asarray(run["ball_angle_in_rotor"].values[:, 0] / TURN)


def kept(viscosity: int, rolling: float) -> dict[str, np.ndarray]:
    """The data: ``time`` (s), ``deflection`` at the laser (m) and ``turns``, of all run-ups (time, run)."""
    table = np.loadtxt(DATA / f"one_ball_{viscosity}_mm2_s_{rolling}.csv", delimiter=",", comments="#", skiprows=3)
    return {"time": table[:, 0], "deflection": 1e-6 * table[:, 1 : 1 + RUNS], "turns": table[:, 1 + RUNS :]}


def write(viscosity: int, rolling: float) -> None:
    """Run all run-ups in an oil and keep them."""
    columns, names = [], []
    for number, start in enumerate(starts(), 1):
        run = simulated(machine(viscosity, start, rolling=rolling))
        time, size = at_laser(run)
        middle = np.interp(time, run["time"].values, turns(run))
        columns.append((1e6 * size, middle))
        names.append(number)
    table = np.column_stack([time, *(size for size, _ in columns), *(turned for _, turned in columns)])
    head = [
        "# own simulation: python -m reproductions.spannan2021._one_ball",
        "# middle of the second (s); greatest deflection at the laser in it (um); turns of the ball from the unbalance",
        ",".join(["time", *(f"deflection_{n}" for n in names), *(f"turns_{n}" for n in names)]),
    ]
    lines = [
        ",".join([f"{row[0]:g}", *(f"{v:.1f}" for v in row[1 : 1 + RUNS]), *(f"{v:.3f}" for v in row[1 + RUNS :])])
        for row in table
    ]
    DATA.mkdir(exist_ok=True)
    (DATA / f"one_ball_{viscosity}_mm2_s_{rolling}.csv").write_text("\n".join([*head, *lines]) + "\n")


if __name__ == "__main__":
    for oil in DENSITY:
        for resistance in ROLLING:
            write(oil, resistance)
