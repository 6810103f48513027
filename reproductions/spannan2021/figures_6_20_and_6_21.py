"""Figures 6.20 and 6.21 in kind: where one ball comes to rest on an oval race, 30 run-ups for each of 12 unbalances.

Numbers of section 6.1.6: 594 g mm, one ball of 4.75 g (effective) at 77 mm, oil of 20 mm^2/s; the race is an oval whose
wide places are 150 and 340 deg (here 155 and 335, an exact oval). The source draws its deviation without a scale; 10 um are
assumed, and so is the friction, chosen after seeing what it does, which is low: with an adherence of 4e-4 balls rest 18 deg
behind on a circular race, since all come from the same side; the source saw no such bias. Start positions are random. The
run-up takes 30 s. It forgets where the ball began: the 30 rests for one unbalance lie within one sector, and the scatter in
single histograms of figure 6.20, which the source ascribes to friction, is not there.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

import autobalancer as ab
from autobalancer.assembly.quantities import with_value_at
from autobalancer.machine import Machine
from autobalancer.plots.style import save_picture
from autobalancer.simulation.record import Samples
from reproductions import Found, compared_all

MACHINE = Path(__file__).parents[2] / "examples" / "machines" / "one_ball_run_up.toml"
WIDE, OVAL = math.radians(155.0), 10e-6
FRICTION = {"rolling_resistance": 5e-5, "adherence": 1e-4}
RUNS, SECTORS = 30, 12
TURN = 2.0 * math.pi


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Where rests gather on the oval race; on the ideal circle half of them are near each pair of places."""
    oval, circle = rests(OVAL), rests(0.0)
    draw(oval, out)
    draw_each(oval, circle, out)
    spread = ideal(oval) < ideal(circle)
    found = [
        Found("fitted", "rests within 45 deg of a wide place, oval race: more than 60 % (1 = true)", "1", 1.0,
              float(share(oval, WIDE) > 0.6), 0.0),
        Found("fitted", "directions around which rests gather on the oval race", "1", 2.0, gatherings(oval), 0.0),
        Found("fitted", "the first of them, against the wide place", "deg", math.degrees(WIDE), preferred(oval), 10.0),
        Found("fitted", "the oval race spreads rests over more sectors (1 = true)", "1", 1.0, float(spread), 0.0),
    ]  # fmt: skip
    return compared_all("Spannan 2021", "6.20, 6.21 in kind", found)


def unbalances() -> np.ndarray:
    """Angles of the primary unbalance in the rotor."""
    return np.arange(SECTORS) * TURN / SECTORS


def rests(oval: float) -> np.ndarray:
    """Final ball angles in the rotor, (unbalance, run-up), rad."""
    machine = race_of(ab.load_machine(MACHINE), oval)
    found = np.empty((SECTORS, RUNS))
    random = np.random.default_rng(1)
    for i, angle in enumerate(unbalances()):
        turned = with_value_at(machine, "unbalances[1].angle", float(angle))
        for k in range(RUNS):
            start = [float(random.uniform(0.0, TURN))]
            one = with_value_at(turned, "balancers[1].races[1].balls[1].start_angles", start)
            run = ab.simulate(one, duration=33.0, save=Samples(2), tolerance=1e-6)
            found[i, k] = float(run["ball_angle_in_rotor"][-1, 0])
    return found


def race_of(machine: Machine, oval: float) -> Machine:
    """The machine with its race rough, oval, and run up in 30 s."""
    race = "balancers[1].races[1]"
    machine = with_value_at(machine, f"{race}.friction", FRICTION)
    if oval:
        machine = with_value_at(machine, f"{race}.harmonics", [{"order": 2, "amplitude": oval, "angle": WIDE}])
    profile = {"kind": "ramp", "end": "1200 rpm", "duration": 30.0}
    return with_value_at(machine, "drive.profile", profile)


def share(angles: np.ndarray, place: float) -> float:
    """Share of the angles within 45 deg of a place or of the one opposite."""
    return float(np.mean(np.cos(2.0 * (angles - place)) > 0.0))


def gatherings(angles: np.ndarray) -> int:
    """Number of directions: the strongest harmonic of the distribution of rests."""
    return int(np.argmax([abs(np.exp(1j * order * angles).mean()) for order in range(1, 7)])) + 1


def preferred(angles: np.ndarray) -> float:
    """Direction in the first half turn around which rests gather, deg, by the second harmonic of their distribution."""
    return math.degrees(0.5 * float(np.angle(np.exp(2j * angles).mean()))) % 180.0


def sectors(angles: np.ndarray) -> np.ndarray:
    """Sector of each angle, 30 deg wide, the first one around zero."""
    return np.floor(np.remainder(angles + math.pi / SECTORS, TURN) * SECTORS / TURN).astype(int)


def ideal(angles: np.ndarray) -> float:
    """Share of the rests in the sector opposite to the unbalance."""
    return float(np.mean(sectors(angles - unbalances()[:, None]) == SECTORS // 2))


def draw_each(oval: np.ndarray, circle: np.ndarray, out: Path) -> None:
    """Figure 6.20: one histogram for each unbalance, over the rest relative to it."""
    figure, panels = plt.subplots(3, 4, figsize=(9.0, 5.4), sharex=True, sharey=True, layout="constrained")
    centers = np.arange(SECTORS) * 360.0 / SECTORS
    for axes, place, one, other in zip(panels.flat, unbalances(), oval, circle, strict=True):
        shares = [np.bincount(sectors(rest - place), minlength=SECTORS) / RUNS for rest in (one, other)]
        axes.bar(centers, shares[0], width=27.0, label="oval")
        axes.step(centers, shares[1], "k", where="mid", lw=0.8, label="circle")
        axes.set_title(f"unbalance at {math.degrees(place):.0f}°", fontsize=8)
        axes.set_xticks([0, 90, 180, 270])
    panels[0, 0].legend(fontsize=7)
    figure.supxlabel("rest relative to the unbalance in deg")
    figure.supylabel("share of 30 run-ups")
    save_picture(figure, out / "figure_6_20.png")


def draw(angles: np.ndarray, out: Path) -> None:
    """Polar histogram of all rests."""
    figure, axes = plt.subplots(subplot_kw={"projection": "polar"}, figsize=(4.2, 4.2), layout="constrained")
    edges = (np.arange(SECTORS + 1) - 0.5) * TURN / SECTORS
    counts = np.bincount(sectors(angles).ravel(), minlength=SECTORS)
    axes.bar(edges[:-1] + math.pi / SECTORS, counts / angles.size, width=0.9 * TURN / SECTORS)
    around = np.linspace(0.0, TURN, 361)
    axes.plot(around, np.full(361, 1.0 / SECTORS), "k--", lw=0.8, label="1/12")
    axes.plot(around, (1.0 + 0.15 * np.cos(2.0 * (around - WIDE))) / SECTORS, "k", lw=0.8, label="race, exaggerated")
    axes.legend(fontsize=7)
    save_picture(figure, out / "figure_6_21.png")
