"""The balancers of a machine as an element with states of its own, for a rotor that another program moves."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import eigh

from autobalancer.assembly.system import MASS_SPREAD, Assembly, assemble
from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import balls_in_races
from autobalancer.kernels.balls import element
from autobalancer.kernels.records import TORQUE
from autobalancer.kernels.system import BALLS, Floats, Host, Matrix, Rigid, System
from autobalancer.machine import Machine

TABLED = 65  # speeds at which a rotor of ROSS that changes its speed is asked for its matrices


class Forms(NamedTuple):
    """Forces and ball accelerations over the accelerations a of all rows and of the rotor angle, the last of a.

    F = force - mass a,  phi'' = push - lean a.
    """

    force: Floats  # (R + 1,) N; of slopes and of the rotor angle N m
    mass: Matrix  # (R + 1, R + 1)
    push: Floats  # (n,) rad/s^2
    lean: Matrix  # (n, R + 1)


class BalancerElement:
    """Balls that feel R rows of a shaft, two or four at each plane with balancers, and the angle of the rotor.

    What its methods take is the motion of the shaft, ``shaft`` (2 R,), deflections of the rows in ``rows``, then their rates,
    of the rotor, ``rotor`` (angle, speed), and of the balls, ``balls`` (2 n,), angles in the rotor, then speeds there. All is
    in SI and in axes at rest, as in CONVENTIONS.md; a slope is dx/dz or dy/dz, and its force a moment, -M_x for dy/dz.

    Attributes
    ----------
    rows
        Names of the R rows: along x and y at each plane, and slopes where ``tilting_races`` is ``"full"``.
    state
        (2 n,) ``balls`` at the start.
    system
        The numbers that :func:`autobalancer.kernels.balls.element.element` takes.
    """

    def __init__(self, system: System, state: Floats, rows: tuple[str, ...]) -> None:
        self.system, self.state, self.rows = system, state, rows
        count, size = state.size // 2, len(rows) + 1
        self._forms = Forms(np.zeros(size), np.zeros((size, size)), np.zeros(count), np.zeros((count, size)))

    def forms(self, time: float, shaft: Floats, rotor: Floats, balls: Floats) -> Forms:
        """What the element does as two linear forms of the accelerations; its arrays are valid until the next call.

        Parameters
        ----------
        time
            s.
        shaft, rotor, balls
            The motion, as above.
        """
        element.element(time, shaft, rotor, balls, self.system, *self._forms)
        return self._forms

    def rates(
        self, time: float, shaft: Floats, rotor: Floats, balls: Floats, acceleration: Floats
    ) -> tuple[Floats, Floats]:
        """Forces on the rows and torque on the rotor, (R + 1,), and the rates of ``balls``, where the accelerations are known.

        Parameters
        ----------
        time
            s.
        shaft, rotor, balls
            The motion, as above.
        acceleration
            (R + 1,) of the rows and of the rotor angle.
        """
        force, mass, push, lean = self.forms(time, shaft, rotor, balls)
        return force - mass @ acceleration, np.concatenate([balls[push.size :], push - lean @ acceleration])

    def coupled(
        self, time: float, shaft: Floats, rotor: Floats, balls: Floats, free: Floats, mobility: Matrix
    ) -> tuple[Floats, Floats]:
        """The same where the accelerations depend on these forces: free + mobility F.

        Parameters
        ----------
        time
            s.
        shaft, rotor, balls
            The motion, as above.
        free
            (R + 1,) accelerations of the rows and of the rotor angle without this element.
        mobility
            (R + 1, R + 1) what a force of 1 N on each adds to them, B M^-1 B^T; zeros for a speed that is given.
        """
        force, mass, _, _ = self.forms(time, shaft, rotor, balls)
        left = np.eye(force.size) + mobility @ mass
        return self.rates(
            time, shaft, rotor, balls, np.asarray(np.linalg.solve(left, free + mobility @ force), np.float64)
        )

    def in_ross(self, rotor: Any, nodes: Sequence[int]) -> Any:
        """A copy of a rotor of ROSS whose own time response, ``run_time_response`` of it, has these balls.

        It takes what ROSS takes: a speed or one for each time, forces on all coordinates, ``model_reduction`` to so many modes.
        It goes by the method of Newmark, as ROSS does, compiled and with balls that are found together with the rotor, from
        the accelerations that belong to the forces at the start, where ROSS takes none. Where
        they are, (times, 2 n) as ``state``, is ``xout`` of the result; all else is as ROSS has it. The rotor turns by the
        integral of its speed.

        Parameters
        ----------
        rotor
            A ``ross.Rotor`` of versions 2.3 or 3.
        nodes
            Its nodes at the planes of the balls, in their order.

        Raises
        ------
        QuestionError
            If there are not as many nodes as planes, or one is not of this rotor; later, if balls and rotor do not agree on
            a step, which is too long then, or another reduction is asked for.
        """
        planes, per_node = len(self.rows) // self.system.work.inert.shape[1], int(rotor.number_dof)
        if len(nodes) != planes or not all(0 <= node < len(rotor.nodes) for node in nodes):
            raise QuestionError(
                f"in_ross: nodes: given {list(nodes)}; must be one for each of {planes} planes, 0 to {len(rotor.nodes) - 1}"
            )
        # x, y, dx/dz = beta and dy/dz = -alpha at each node
        places = (
            ((0, 1.0), (1, 1.0), (4, 1.0), (3, -1.0)) if per_node == 6 else ((0, 1.0), (1, 1.0), (3, 1.0), (2, -1.0))
        )
        rows = np.zeros((len(self.rows), int(rotor.ndof)))
        for i in range(len(rows)):
            place, sign = places[i % (len(rows) // planes)]
            rows[i, per_node * nodes[i // (len(rows) // planes)] + place] = sign
        result = copy(rotor)
        result.time_response = partial(self._time_response, rotor, rows)
        return result

    def _time_response(
        self,
        rotor: Any,
        rows: Matrix,
        speed: Any,
        F: Any,
        t: Any,
        ic: Any = None,
        method: str = "default",
        **options: Any,
    ) -> tuple[Floats, Matrix, Matrix]:
        """As ``Rotor.time_response`` of ROSS: times, motion of all coordinates, and the balls in place of the state vector."""
        modes = options.pop("model_reduction", {}).get("num_modes", 0)
        if ic is not None or options:
            raise QuestionError(
                f"in_ross: {', '.join(['ic'] * (ic is not None) + [*options])}: not possible with balls"
            )
        times = np.ascontiguousarray(t, np.float64)
        w = np.broadcast_to(np.asarray(speed, np.float64), times.shape)
        turns = np.zeros((times.size, 3))
        turns[1:, 0] = np.cumsum(0.5 * (w[1:] + w[:-1]) * np.diff(times))
        steady = not np.ptp(w) > 0.0
        turns[:, 1], turns[:, 2] = w, 0.0 if steady else np.gradient(w, times)
        # the matrices of the rotor, of many speeds where bearings depend on it, in so many modes
        grid = w[:1].copy() if steady else np.linspace(w.min(), w.max(), TABLED)
        basis = np.eye(rows.shape[1])
        if modes:
            stiffness = np.asarray(rotor.K(float(w.mean())))
            basis = eigh(0.5 * (stiffness + stiffness.T), rotor.M(), subset_by_index=(0, modes - 1))[1]
        small = [
            np.ascontiguousarray([(basis.T @ matrix @ basis).T for matrix in some])
            for some in ([rotor.M()], [rotor.G()], [rotor.Ksdt()], map(rotor.C, grid), map(rotor.K, grid))
        ]
        host = element.Rotor(
            small[0][0], small[1][0], small[2][0], np.ascontiguousarray(rows @ basis), grid, *small[3:]
        )
        size, count = basis.shape[1], self.state.size // 2
        motion, balls = np.zeros((times.size, size)), np.zeros((times.size, 2 * count))
        balls[0] = self.state
        room = element.room_for(size, len(rows), count)
        forces = np.ascontiguousarray(np.asarray(F, np.float64) @ basis)
        if not element.march(times, turns, forces, host, room, self.system, motion, balls):
            raise QuestionError("in_ross: balls and rotor do not agree on a step; take shorter steps of t")
        return times, motion @ basis.T, balls


def balancer_element(machine: Machine | str | Path, *, seed: int = 0) -> BalancerElement:
    """The balancers of a machine as an element for a rotor of another program, which has rotor, unbalance, drive and supports.

    Parameters
    ----------
    machine
        A machine or the path of a machine file. Its rotor says where the planes are; with ``tilting_races = "full"`` the element
        has slopes too.
    seed
        For the start positions of balls that have none in the machine.

    Returns
    -------
    BalancerElement
        Its ``forms`` are forces and ball accelerations over the accelerations of the shaft; ``state`` is where the balls start.

    Raises
    ------
    MachineError
        If the machine is not possible.
    QuestionError
        If balls are without guidance, stick, or meet rigidly, which takes events, or if the fluid of a race has states.
    """
    machine = balls_in_races(machine)
    _refuse_events(machine)
    assembly = assemble(machine, seed=seed, rotating=False, general=True, mass_spread=MASS_SPREAD)
    _refuse_rigid(assembly)
    system, count = assembly.system, len(assembly.balls)
    rows = tuple(
        f"{way} at {balancer.station if isinstance(balancer.station, str) else balancer.name or f'balancer {number + 1}'}"
        for number, balancer in enumerate(machine.balancers)
        for way in ("x", "y", "dx/dz", "dy/dz")[: system.work.inert.shape[1]]
    )
    size = len(rows)
    system = system._replace(
        host=Host(size, size, system.host.stations, system.host.axial_gravity, rows=np.eye(size)),
        work=system.work._replace(q=np.zeros(size), v=np.zeros(size)),
        drive=system.drive._replace(kind=TORQUE),
        rigid=Rigid(middle=np.zeros(BALLS + 2 * count)),
    )
    return BalancerElement(system, assembly.state[BALLS : BALLS + 2 * count].copy(), rows)


def _refuse_events(machine: Machine) -> None:
    """Refuse balls whose motion is not one smooth rate of their own states."""
    if not machine.balancers:
        raise QuestionError("balls alone: the machine has no balancers; give it some")
    for b, balancer in enumerate(machine.balancers):
        for r, race in enumerate(balancer.races):
            obstacles = {
                "resolved: balls without guidance; an element guides them, leave it out": race.resolved,
                "friction: balls that stick and roll change at an instant; leave it out": race.friction,
                "fluid.lag: such a fluid has states of its own; leave it out": race.fluid and race.fluid.lag != "none",
            }
            for what, there in obstacles.items():
                if there:
                    raise QuestionError(f"balls alone: balancers[{b + 1}].races[{r + 1}].{what}")


def _refuse_rigid(assembly: Assembly) -> None:
    """Refuse balls that may meet rigidly."""
    for ball, row in zip(assembly.balls, assembly.system.contacts, strict=True):
        if row.rigid or row.wall_rigid:
            raise QuestionError(
                f"balls alone: balancers[{ball.balancer + 1}].races[{ball.race + 1}]: its balls meet rigidly, which takes "
                "an instant; give contact.stiffness, or collisions = false"
            )
