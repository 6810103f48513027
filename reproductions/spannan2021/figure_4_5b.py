"""Figure 4.5b in kind: stability map of two balls on an eccentric race and orthotropic supports, by (4.70).

The source draws the map without numbers, for the dimensionless machine of figure 4.3; this is the project's own machine of that
figure. With much drag the averaged equations behind (4.70) are right: their borders are those of the full equations, judged by
multipliers over a turn. With little drag they leave out too much, and the full equations balance at far lower speeds.

The source wishes for an explicit criterion like (4.74) on such supports (section 7.1). There is one for any unbalance: the least
drag at each speed, drawn as a line and compared with (4.70) for balls at 135 degrees.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import brentq

from autobalancer.assembly.quantities import with_value_at
from autobalancer.files.machine_file import load_race_machine
from autobalancer.machine import Machine
from autobalancer.plots.style import BALLS, CRITICAL, INK, UNBALANCE, look, picture, save_picture
from autobalancer.stability.averaged import averaged_plane, averaged_station_growth, greatest_g
from autobalancer.stability.host.stations import of_plane, station_form
from autobalancer.stability.maps.balanced import members_of
from autobalancer.stability.states.questions import eigenvalues
from autobalancer.stability.states.rest_states import StationState
from reproductions import Found, compared_all
from reproductions.spannan2021.figure_4_3 import MACHINE, SUPPORTS

HEAVY = 1e-2  # N m s
SPEEDS, DRAGS = np.linspace(200.0, 700.0, 201), np.geomspace(2e-4, 1e-1, 41)
NEAR = 3.0  # rad/s
AT_135 = StationState(
    "balanced", np.radians([135.0, -135.0]), np.zeros(1, np.complex128), 0, 0
)  # in a race that runs true
BRACKETS = {1e-3: [(280.0, 360.0)], 3e-3: [(235.0, 245.0), (249.0, 252.0), (295.0, 310.0)]}  # N m s: rad/s


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Edges of the stable ranges with much drag, and the map."""
    machine = with_value_at(load_race_machine(MACHINE), "rotor.stiffness", SUPPORTS["orthotropic"])
    averaged = np.array(averaged_edges(machine, HEAVY))
    exact = {drag: [exact_edge(machine, drag, *ends) for ends in pairs] for drag, pairs in BRACKETS.items()}
    exact[HEAVY] = [exact_edge(machine, HEAVY, edge - NEAR, edge + NEAR) for edge in averaged]
    worst = 100.0 * max((averaged / np.array(exact[HEAVY]) - 1.0).tolist(), key=abs)
    draw(machine, exact, out)
    text = "edges of the stable ranges by (4.70), much drag, against the full equations"
    rows = [
        Found("closed form", f"{text}: how many", "1", 3, averaged.size, 0),
        Found("closed form", f"{text}: farthest", "%", 0.0, worst, 0.2),
        Found(
            "closed form",
            "explicit least drag against (4.70) at 135 deg: farthest",
            "%",
            0.0,
            explicit_error(machine),
            1e-6,
        ),
    ]
    return compared_all("Spannan 2021", "4.5b in kind", rows)


def with_drag(machine: Machine, drag: float) -> Machine:
    """The machine with another drag torque over ball speed, N m s."""
    return with_value_at(machine, "balancers[1].races[1].drag.damping", drag)


def averaged_rates(machine: Machine, drag: float) -> np.ndarray:
    """Growth rate of (4.70) over the speed."""
    return balanced_rates(with_drag(machine, drag))(SPEEDS)


def balanced_rates(machine: Machine) -> Callable[[np.ndarray], np.ndarray]:
    """Averaged growth rates of the balanced state at speeds."""
    (state,) = members_of(station_form(machine), averaged_station_growth)
    return state.rates


def averaged_edges(machine: Machine, drag: float) -> list[float]:
    """Speeds at which (4.70) becomes stable or unstable."""
    rates = balanced_rates(with_drag(machine, drag))
    changes = np.flatnonzero(np.diff(np.sign(averaged_rates(machine, drag))))
    return [float(brentq(lambda w: rates(np.array([w]))[0], SPEEDS[i], SPEEDS[i + 1])) for i in changes]


def least_drags(machine: Machine, speeds: np.ndarray) -> np.ndarray:
    """By the closed form, for any unbalance; infinite where no drag is enough, N m s."""
    plane = averaged_plane(machine)
    most = np.array([greatest_g(plane, float(speed)) for speed in speeds])
    found = np.full(speeds.size, np.inf)
    found[most > 0.0] = (plane.moment**2).sum() / most[most > 0.0]
    return found


def explicit_error(machine: Machine) -> float:
    """The farthest that the explicit drag is from the one at which (4.70) at 135 degrees changes its sign, %."""
    plane, errors = averaged_plane(machine), []
    speeds = SPEEDS[::20]
    for speed, drag in zip(speeds, least_drags(machine, speeds), strict=True):
        if np.isfinite(drag):

            def rate(factor: float, speed: float = speed, drag: float = drag) -> float:
                there = replace(plane, drag=np.full(2, factor * drag), offset=np.zeros(2, np.complex128))
                return averaged_station_growth(of_plane(there), speed, AT_135)

            errors.append(100.0 * (brentq(rate, 0.9, 1.1, xtol=1e-13) - 1.0))
    return float(max(errors, key=abs))


def exact_edge(machine: Machine, drag: float, low: float, high: float) -> float:
    """The speed at which the full equations become stable or unstable."""
    heavy = with_drag(machine, drag)
    return float(brentq(lambda w: float(eigenvalues(heavy, [w])["growth_rate"][0]), low, high, xtol=1e-2))


def draw(machine: Machine, exact: dict[float, list[float]], out: Path) -> None:
    """Where (4.70) is stable, and edges of the full equations."""
    rates = np.array([averaged_rates(machine, float(drag)) for drag in DRAGS])
    with look():
        figure = picture(7.4, 4.6)
        axes = figure.subplots()
        axes.contourf(SPEEDS, DRAGS, rates, levels=[-np.inf, 0.0], colors=["#CFE3EE"])
        axes.contour(SPEEDS, DRAGS, rates, levels=[0.0], colors=[INK], linewidths=1.0)
        for drag, edges in exact.items():
            axes.plot(edges, [drag] * len(edges), "x", ms=6, color=UNBALANCE)
        axes.plot([], [], "x", color=UNBALANCE, label="full equations")
        axes.fill_between([], [], [], color="#CFE3EE", label="stable by (4.70)")
        fine = np.linspace(SPEEDS[0], SPEEDS[-1], 2001)
        axes.plot(fine, least_drags(machine, fine), color=BALLS[0], lw=1.4, label="closed form, any unbalance")
        axes.set_ylim(DRAGS[0], DRAGS[-1])
        plane = averaged_plane(machine)
        low, high = (np.sqrt(k / plane.mass) for k in plane.stiffness)
        for speed in (low, np.sqrt(0.5 * (low**2 + high**2)), high):
            axes.axvline(speed, color=CRITICAL, lw=0.8, ls=":")
        axes.set(yscale="log", xlabel="rotor speed (rad/s)", ylabel="drag torque over ball speed (N m s)")
        axes.set_title("Spannan 2021, figure 4.5b: orthotropic supports, eccentric race")
        figure.legend(loc="outside lower center", ncols=2)
        save_picture(figure, out / "figure_4_5b.png")
