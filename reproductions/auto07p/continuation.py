"""Special points of two balls against AUTO-07p: Hopf and Bautin points, period doublings, folds of swinging and stalled balls.

The targets are what AUTO-07p 0.9.2 (Debian 0.9.2+dfsg-3) prints for ``balls.f90``, which is written from the equations and
shares no code with the package; ``_run.py`` repeats it. Its collocation has its own meshes and tolerances, so that digits after
the sixth decimal of a speed are those of AUTO's stopping rule. AUTO finds the Bautin point with differences, to 1e-5.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

import autobalancer as ab
from autobalancer.assembly.quantities import with_value_at
from autobalancer.files.machine_file import load_race_machine
from autobalancer.machine import Machine
from autobalancer.stability.branch_diagrams import bifurcation_curves, branches
from reproductions import Found, compared_all

STALL = Path(__file__).resolve().parents[2] / "examples" / "machines" / "stall_and_release.toml"
SPEED, BAUTIN_SPEED, BAUTIN_DRAG, PERIOD = 1e-6, 1e-4, 1e-8, 1e-6  # tolerances
CRITICAL = 250.0  # rad/s; AUTO counts time in its inverse
HOPF = {1e-4: 275.22485111, 5e-5: 280.88783881, 2e-4: 271.12163980, 5e-4: 266.31686805}  # drag: speed
BAUTIN = (272.95209916, 1.4281170269e-4)  # speed, drag
DOUBLING = (275.68038415, 146.03139763)  # speed, period
SWINGING_FOLDS = (278.46413026, 278.34811306, 278.49299114, 278.40171707)
STALLED_FOLDS = (383.31503761, 282.94986783, 286.16477973, 284.30055441, 259.65651308)


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Our points next to those of AUTO; the stalled orbit with AUTO's folds as a picture."""
    rows: list[Found] = []
    for drag, speed in HOPF.items():
        found = branches(machine(drag), "speed", 300.0, 262.0, orbits=drag == 1e-4, intervals=60)
        if drag == 1e-4:
            swinging = found
        obtained = nearest(found, "Hopf", speed)
        rows.append(external("balanced state", f"Hopf speed, drag {drag:g} N m s", "rad/s", speed, obtained, SPEED))
    curve = bifurcation_curves(machine(1e-4), "Hopf", "speed", 300.0, 262.0, "drag", 6e-5, 3e-4)
    point = float(curve["special_parameter"][0]), float(curve["special_second_parameter"][0])
    rows.append(external("balanced state", "Bautin point, speed", "rad/s", BAUTIN[0], point[0], BAUTIN_SPEED))
    rows.append(external("balanced state", "Bautin point, drag", "N m s", BAUTIN[1], point[1], BAUTIN_DRAG))
    speed, period = DOUBLING
    rows.append(
        external("swinging balls", "first period doubling", "rad/s", speed, nearest(swinging, "period doubling", speed),
                 SPEED)
    )  # fmt: skip
    obtained = nearest(swinging, "period doubling", speed, "special_period")
    rows.append(external("swinging balls", "period there", "s", period / CRITICAL, obtained, PERIOD))
    for number, speed in enumerate(SWINGING_FOLDS, 1):
        obtained = nearest(swinging, "fold", speed)
        rows.append(external("swinging balls", f"fold {number}", "rad/s", speed, obtained, SPEED))
    stalled = branches(load_race_machine(STALL), "speed", 255.0, 450.0, from_state="stalled", intervals=60)
    names = ("release", *(f"fold {number} of the unstable orbits" for number in (2, 3, 4)), "least speed")
    for name, speed in zip(names, STALLED_FOLDS, strict=True):
        rows.append(external("stalled balls", name, "rad/s", speed, nearest(stalled, "fold", speed), SPEED))
    draw(stalled, out)
    return compared_all("AUTO-07p 0.9.2", "", rows)


def external(figure: str, quantity: str, unit: str, target: float, obtained: float, tolerance: float) -> Found:
    """A row against AUTO-07p; ``figure`` says which motion it is of."""
    return Found("external", quantity, unit, target, obtained, tolerance, figure=figure)


def machine(drag: float) -> Machine:
    """Stall and release with 85 % of the unbalance that the balls can balance, and another drag."""
    smaller = with_value_at(load_race_machine(STALL), "unbalances[1].mass", 0.85 * 5e-3)
    return with_value_at(smaller, "balancers[1].races[1].drag.damping", drag)


def nearest(found: xr.Dataset, kind: str, speed: float, name: str = "special_parameter") -> float:
    """Of the special points of a kind the one nearest to a speed."""
    points = found.isel(special=np.flatnonzero(found["special_type"].values == kind))
    return float(points[name].values[np.argmin(np.abs(points["special_parameter"].values - speed))])


def draw(stalled: xr.Dataset, out: Path) -> None:
    """The branch of stalled balls; lines mark the folds that AUTO finds."""
    titled = stalled.assign_attrs(title="Stalled balls; dotted: folds by AUTO-07p")
    figure = ab.plot.branches(titled, speed_unit="rad/s")
    for axes in figure.axes:
        for speed in STALLED_FOLDS:
            axes.axvline(speed, color="#D55E00", lw=0.7, ls=":", zorder=1.0)
    figure.savefig(out / "stalled_balls.png", dpi=110)
