"""Fifty balls in a turning drum: a step of ``simulate_chamber`` against one of the sphere contact of Exudyn.

Equal are number, size, mass and first places of the balls, the size of the drum and its speed, gravity, coefficient of
friction, the slip speed below which friction falls to zero, the step, its method (velocity Verlet) and one thread. Not
equal: Exudyn has a drum of flat triangles, springs and dampers that are linear (of the same contact time) and no rolling
resistance; we have a round drum, Hertz stiffness with restitution, rolling resistance, the ledger of energy and
the reactions of the bearings. Exudyn is used as it is fastest here: without range checks, inverse of the mass matrix per body,
rotation vectors, few triangles, and cells of its search that suit. Without Exudyn only our time is measured.
"""

from __future__ import annotations

import contextlib
import io
import math
import sys
from importlib import import_module
from importlib.util import find_spec
from time import process_time
from typing import Any

import numpy as np

from autobalancer.assembly.chamber_assembly import contact_time
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.simulation.chamber import simulate_chamber
from benchmarks import measured
from benchmarks.chamber import machine

COUNT, SPEED, STEP, END = 50, 20.0, 1e-6, 0.02  # balls, rad/s, s, s
FACETS, CELLS = 24, (3, 3, 3)  # flat pieces of the drum; cells of Exudyn's search
HEAVY = 1e6  # kg: the drum keeps its speed
REPEATS = 3


def bench() -> list[dict[str, Any]]:
    """One row, with the peer where it is installed."""
    given = drum()
    time, first = ours(given)
    note = f"{COUNT} balls, steps of {STEP:g} s, time per step; ours {1e9 * time / COUNT:.0f} ns per ball"
    if find_spec("exudyn") is None:
        note += "; Exudyn is not installed, so there is no ratio: pip install 'autobalancer[test]'"
        return [measured("chamber_vs_exudyn", time, "s", note=note)]
    with contextlib.redirect_stdout(io.StringIO()):
        peer = theirs(given, first)
    note += f", theirs {1e9 * peer / COUNT:.0f} ns"
    return [measured("chamber_vs_exudyn", time, "s", note=note) | {"peer": "Exudyn, spheres", "ratio": peer / time}]


def drum() -> ChamberMachine:
    """The reference machine on a rigid foundation at constant speed."""
    described = machine(COUNT, SPEED).model_dump(exclude_unset=True)
    described["drive"]["profile"] = {"kind": "constant", "speed": SPEED}
    described["body"] = {"freedom": "fixed"}
    return ChamberMachine(**described)


def ours(given: ChamberMachine) -> tuple[float, np.ndarray]:
    """Least processor time of a step, s, and places of the settled balls, (balls, 3)."""
    held: list[Any] = []
    run = simulate_chamber(given, duration=1e-3, step=STEP, on_chunk=lambda part, state: held.append(state))
    times = []
    for _ in range(REPEATS):
        begin = process_time()
        simulate_chamber(given, duration=END, step=STEP, resume=held[0], keep=False)
        times.append(process_time() - begin)
    return min(times) / ((END - 1e-3) / STEP), run.ball_position.values[0]


def theirs(given: ChamberMachine, places: np.ndarray) -> float:
    """Least processor time of a step of Exudyn, s."""
    sys.exudynFast = True  # type: ignore[attr-defined]
    exu = import_module("exudyn")
    steps = round(END / STEP)
    times = []
    for _ in range(REPEATS):
        system, balls = exudyn_drum(exu, given, places)
        settings = exu.SimulationSettings()
        settings.solution.file.write = False
        settings.timeIntegration.numberOfSteps, settings.timeIntegration.endTime = steps, END
        settings.timeIntegration.explicit.computeEndOfStepAccelerations = False
        settings.timeIntegration.explicit.computeMassMatrixInversePerBody = True
        settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
        settings.parallel.numberOfThreads = 1
        begin = process_time()
        system.SolveDynamic(settings, solverType=exu.DynamicSolverType.VelocityVerlet)
        times.append(process_time() - begin)
        ended = np.array([system.GetNodeOutput(ball, exu.OutputVariableType.Position) for ball in balls])
        # none fell through the wall, and friction took some along
        reach = given.chambers[0].radius / math.cos(math.pi / FACETS) - given.chambers[0].balls[0].radius
        assert np.hypot(ended[:, 1], ended[:, 2]).max() < reach + 2e-4
        assert np.abs(ended - places).max() > 0.25 * float(given.contact.friction) * 9.81 * END**2
    return min(times) / steps


def exudyn_drum(exu: Any, given: ChamberMachine, places: np.ndarray) -> tuple[Any, list[int]]:
    """A system of Exudyn, and the nodes of its balls."""
    of = import_module("exudyn.utilities")
    chamber, contact = given.chambers[0], given.contact
    group = chamber.balls[0]
    radius, mass = float(group.radius), float(group.ball_mass)
    # two equal springs in series and half the mass of a ball: half a period is the time of contact
    stiffness = mass * (math.pi / contact_time(given)) ** 2
    log = math.log(float(contact.restitution))
    damping = -log / math.hypot(math.pi, log) * math.sqrt(stiffness * mass)
    law = {"contactStiffness": stiffness, "contactDamping": damping, "frictionMaterialIndex": 0}
    container = exu.SystemContainer()
    system = container.AddSystem()
    kind = exu.NodeType.RotationRotationVector
    contacts = system.AddGeneralContact()
    contacts.SetFrictionPairings(float(contact.friction) * np.eye(1))
    contacts.SetFrictionProportionalZone(float(contact.slip_speed))
    contacts.SetSearchTreeCellSize(numberOfCells=list(CELLS))
    inertia = of.InertiaCuboid(HEAVY / 8.0, (2.0, 2.0, 2.0))
    body = system.CreateRigidBody(inertia=inertia, nodeType=kind, initialAngularVelocity=[SPEED, 0.0, 0.0])
    marker = system.AddMarker(of.MarkerNodeRigid(nodeNumber=system.GetObject(body)["nodeNumber"]))
    points, triangles = facets(float(chamber.radius), chamber.inner_depth)
    contacts.AddTrianglesRigidBodyBased(rigidBodyMarkerIndex=marker, pointList=points, triangleList=triangles, **law)
    nodes = []
    for place in places:
        body = system.CreateRigidBody(
            inertia=of.InertiaSphere(mass, radius), nodeType=kind, referencePosition=list(place),
            gravity=list(given.gravity),
        )  # fmt: skip
        nodes.append(system.GetObject(body)["nodeNumber"])
        marker = system.AddMarker(of.MarkerNodeRigid(nodeNumber=nodes[-1]))
        contacts.AddSphereWithMarker(marker, radius=radius, **law)
    system.Assemble()
    return system, nodes


def facets(radius: float, depth: float) -> tuple[list[list[float]], list[list[int]]]:
    """Points and triangles of a drum along x, seen from inside; its flat pieces touch the round one from outside."""
    n = FACETS
    angles = 2.0 * math.pi * np.arange(n) / n
    reach = radius / math.cos(math.pi / n)
    points = [[x, reach * math.cos(a), reach * math.sin(a)] for x in (-0.5 * depth, 0.5 * depth) for a in angles]
    points += [[-0.5 * depth, 0.0, 0.0], [0.5 * depth, 0.0, 0.0]]
    triangles = []
    for i in range(n):
        j = (i + 1) % n
        triangles += [[i, j, n + i], [j, n + j, n + i], [i, 2 * n, j], [n + i, n + j, 2 * n + 1]]
    inside = []
    corners = np.array(points)
    for a, b, c in triangles:
        inward = np.cross(corners[b] - corners[a], corners[c] - corners[a]) @ corners[[a, b, c]].mean(axis=0) < 0.0
        inside.append([a, b, c] if inward else [a, c, b])
    return points, inside
