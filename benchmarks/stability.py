"""Stability maps against a loop of numpy.linalg.eigvals over matrices assembled in Python, on orthotropic supports against one
periodic state at a time."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from tests.references.planar_linear import matrices
from tests.references.planar_states import equilibria_of

import autobalancer as ab
from autobalancer.assembly.quantities import with_quantity, with_value_at
from autobalancer.files.examples import rig
from autobalancer.files.machine_file import load_race_machine
from autobalancer.machine import Machine
from autobalancer.stability.host.stations import of_plane, plane
from autobalancer.stability.maps.balanced import StationBalls, balanced_states
from benchmarks import compared, measured, processor_seconds, seconds

MACHINE = Path(__file__).parents[1] / "examples" / "machines" / "discoidal.toml"
SMALL, LARGE, UNEVEN = (250, 80), (1000, 1000), (21, 11)  # speeds, viscosities


def bench() -> list[dict[str, Any]]:
    """The same map both ways, and the points per second of a large one."""
    machine = load_race_machine(MACHINE)
    found, rates = ours(machine, SMALL), theirs(machine)
    worst = float(np.abs(found["growth_rate"].values - rates).max())
    assert worst < 1e-9 * 60.0, worst  # of the critical speed
    small = seconds(lambda: ours(machine, SMALL))
    peer = seconds(lambda: theirs(machine), repeats=1)
    large = seconds(lambda: ours(machine, LARGE), repeats=2)
    points = SMALL[0] * SMALL[1]
    note = f"{points} points, growth rates equal to {worst:.1g} 1/s"
    return [
        *orthotropic(machine),
        *orthotropic_rotors(),
        compared("stability_map_vs_numpy", small, "numpy.linalg.eigvals in a loop", peer, note=note),
        measured("stability_map_points_per_s", LARGE[0] * LARGE[1] / large, "1/s", note="10^6 points, all cores"),
    ]


def orthotropic(machine: Machine) -> list[dict[str, Any]]:
    """A map on orthotropic supports, with its borders, and its growth rates against one periodic state at a time."""
    machine = with_value_at(machine, "rotor.stiffness", ("40 kN/m", "50 kN/m"))
    grid = axes(UNEVEN)
    planes = [plane(with_quantity(machine, "viscosity", viscosity)) for viscosity in grid["viscosity"]]

    def rates(members: list[Any]) -> np.ndarray:
        return np.array([member.rates(grid["speed"]) for member in members])

    fast = [balanced_states(p)[0] for p in planes]
    slow = [StationBalls(of_plane(p), route="multipliers") for p in planes]
    worst = float(np.abs(rates(fast) - rates(slow)).max())
    assert worst < 1e-9 * 60.0, worst  # of the critical speed
    points = UNEVEN[0] * UNEVEN[1]
    note = f"{points} points on orthotropic supports, growth rates equal to {worst:.1g} 1/s"
    peer = seconds(lambda: rates(slow), repeats=1)
    whole = seconds(lambda: ab.stability.map(machine, grid), repeats=2)
    sizes = {"speed": grid["speed"], "unbalance": np.linspace(0.01, 1.0, UNEVEN[1]) * planes[0].capability}
    over_unbalance = seconds(lambda: ab.stability.map(machine, sizes), repeats=2)
    return [
        compared(
            "orthotropic_growth_rates_vs_one_at_a_time", seconds(lambda: rates(fast)), "one at a time", peer, note=note
        ),
        measured(
            "orthotropic_stability_map_s",
            whole,
            "s",
            note=f"{points} points and all borders at {UNEVEN[1]} viscosities",
        ),
        measured("orthotropic_map_over_unbalance_s", over_unbalance, "s", note=f"{points} points and all borders"),
    ]


def orthotropic_rotors() -> list[dict[str, Any]]:
    """Maps with all borders where no formula helps: a race off the axis, and a rotor that tilts in two planes."""
    eccentric = with_value_at(ab.example("eccentric_race"), "rotor.stiffness", ("40 kN/m", "50 kN/m"))
    rows = []
    for name, machine, speeds, text in (
        ("orthotropic_eccentric_race_map_s", eccentric, (50.0, 180.0), "a race off the axis"),
        ("rodrigues_rig_map_s", rig("rodrigues_rig"), (120.0, 600.0), "a rotor that tilts in two planes"),
    ):
        drag = float(machine.balancers[0].races[0].drag.damping)
        grid = {"speed": np.linspace(*speeds, UNEVEN[0]), "drag": drag * np.geomspace(0.2, 5.0, UNEVEN[1])}
        time = processor_seconds(lambda machine=machine, grid=grid: ab.stability.map(machine, grid))
        note = f"{UNEVEN[0] * UNEVEN[1]} points and all borders, {text}; time of all processors"
        rows.append(measured(name, time, "s", note=note))
    return rows


def axes(shape: tuple[int, int]) -> dict[str, Any]:
    """Speed and viscosity."""
    return {"speed": np.linspace(50.0, 130.0, shape[0]), "viscosity": np.geomspace(0.2e-6, 100e-6, shape[1])}


def ours(machine: Any, shape: tuple[int, int]) -> xr.Dataset:
    """The whole function, with the machines of all rows."""
    return ab.stability.map(machine, axes(shape), borders=0)


def theirs(machine: Any) -> np.ndarray:
    """Matrices of the linearized equations and their eigenvalues, point by point."""
    grid = axes(SMALL)
    rates = np.empty(SMALL)
    for j, viscosity in enumerate(grid["viscosity"]):
        p = plane(with_quantity(machine, "viscosity", viscosity))
        state = equilibria_of(p, 100.0)[0]  # its angles do not depend on the speed
        for i, speed in enumerate(grid["speed"]):
            m, c, k = matrices(p, float(speed), state)
            n = len(m)
            first = np.zeros((2 * n, 2 * n))
            first[:n, n:] = np.eye(n)
            first[n:, :n], first[n:, n:] = -np.linalg.solve(m, k), -np.linalg.solve(m, c)
            rates[i, j] = np.linalg.eigvals(first).real.max()
    return rates
