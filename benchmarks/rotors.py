"""How much faster than real time rotors with balls run: a shaft of 20 elements, and a rigid rotor that tilts.

The whole of ``simulate`` is timed, with its assembly, reduction and recording. And how long the matrices of 5000 degrees of
freedom take until they are a rotor of few, with the check of its receptances, beside the modes alone by ``eigsh`` of SciPy.
"""

from __future__ import annotations

from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import eigsh

import autobalancer as ab
from autobalancer.assembly.quantities import with_value_at
from autobalancer.files.examples import rig
from autobalancer.machine import Machine
from benchmarks import measured

RIGID = Path(__file__).parents[1] / "examples" / "machines" / "two_plane_rotor.toml"
RUN_UP = {"kind": "ramp", "start": 0.0, "end": "4000 rpm", "duration": "60 s"}
SHAFT_GOAL, RIGID_GOAL = 1000.0, 2000.0


def bench() -> list[dict[str, Any]]:
    """Simulated seconds per second of processor time of one core, best of five runs, and against the goals."""
    rigid = with_value_at(ab.load_machine(RIGID), "drive.profile", RUN_UP)
    return [
        factor("cfrp_real_time_factor", rig("cfrp_rig"), 120.0, SHAFT_GOAL),
        factor("rigid_rotor_real_time_factor", rigid, 60.0, RIGID_GOAL),
        reduction(),
    ]


def factor(name: str, machine: Machine, duration: float, goal: float) -> dict[str, Any]:
    """One row; its ratio is against the goal."""
    run = ab.simulate(machine, duration=duration)
    time = min(taken(machine, duration) for _ in range(5))
    value = duration / time
    balls, kept, pairs = run.sizes["ball"], run.attrs["modes_kept"], run.attrs["modes_in_all"]
    note = (
        f"run-up of {duration:g} s with {balls} balls, {kept} of {pairs} pairs of modes, "
        f"{run.attrs['steps']} steps, {run.attrs['outcome']}"
    )
    return measured(name, value, "1", note=note) | {"peer": f"goal {goal:g}", "ratio": value / goal}


def taken(machine: Machine, duration: float) -> float:
    """Processor time of one run, s."""
    start = process_time()
    ab.simulate(machine, duration=duration)
    return process_time() - start


NODES, LENGTH, RADIUS, MODES = 1250, 1.0, 0.02, 20  # four degrees of freedom a node


def beam() -> tuple[sparse.csc_array, sparse.csc_array]:
    """M and K of a round steel beam on two springs, node by node ux, uy, rx, ry."""
    h, area = LENGTH / (NODES - 1), np.pi * RADIUS**2
    mass = 7800.0 * area * h / 420.0 * np.array(
        [[156, 22 * h, 54, -13 * h], [22 * h, 4 * h**2, 13 * h, -3 * h**2],
         [54, 13 * h, 156, -22 * h], [-13 * h, -3 * h**2, -22 * h, 4 * h**2]]
    )  # fmt: skip
    stiffness = 210e9 * area * RADIUS**2 / 4.0 / h**3 * np.array(
        [[12, 6 * h, -12, 6 * h], [6 * h, 4 * h**2, -6 * h, 2 * h**2],
         [-12, -6 * h, 12, -6 * h], [6 * h, 2 * h**2, -6 * h, 4 * h**2]]
    )  # fmt: skip
    rows, columns = [], []
    entries: tuple[list[Any], list[Any]] = ([], [])
    first = 4 * np.arange(NODES - 1)
    for own, sign in (([0, 3, 4, 7], 1.0), ([1, 2, 5, 6], -1.0)):  # ux, ry and uy, rx = -dy/dz
        signs = np.array([1.0, sign, 1.0, sign])
        for i in range(4):
            for j in range(4):
                rows.append(first + own[i])
                columns.append(first + own[j])
                for kept, matrix in zip(entries, (mass, stiffness), strict=True):
                    kept.append(np.full(first.size, signs[i] * signs[j] * matrix[i, j]))
    for end in (0, 4 * (NODES - 1)):
        for way in (0, 1):
            rows.append(np.array([end + way]))
            columns.append(np.array([end + way]))
            entries[0].append(np.zeros(1))
            entries[1].append(np.array([1e6]))
    at = np.concatenate(rows), np.concatenate(columns)
    whole = [sparse.coo_array((np.concatenate(of), at), shape=(4 * NODES,) * 2).tocsc() for of in entries]
    return whole[0], whole[1]


def reduction() -> dict[str, Any]:
    """The row of the reduction; its ratio is against the modes alone."""
    mass, stiffness = beam()
    positions = np.repeat(np.linspace(0.0, LENGTH, NODES), 4)
    keep = [float(positions[4 * (k * (NODES - 1) // 3)]) for k in range(4)]
    times, peers, note = [], [], ""
    for _ in range(3):
        start = process_time()
        rotor = ab.rotor.from_matrices(
            mass, stiffness, ["ux", "uy", "rx", "ry"] * NODES, positions, keep=keep, modes=MODES
        )
        times.append(process_time() - start)
        start = process_time()
        eigsh(stiffness, 2 * MODES, mass, sigma=0.0)
        peers.append(process_time() - start)
        note = rotor.source
    row = measured("matrices_reduction", min(times), "s", note=f"{note}; goal 5 s")
    return row | {"peer": "SciPy eigsh, modes alone", "ratio": min(peers) / min(times)}
