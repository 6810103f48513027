"""One machine held at one speed after the other."""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from autobalancer.assembly.system import Assembly
from autobalancer.kernels.balls.at_nodes.planar_contacts import contacts_in_steps
from autobalancer.kernels.balls.planar_nodes import planar_nodes
from autobalancer.kernels.dwell.hold import hold
from autobalancer.kernels.dwell.window import Window
from autobalancer.kernels.integrators.collocation.amplitudes import LONG_STEPS, amplitudes
from autobalancer.kernels.integrators.collocation.inside import by_powers
from autobalancer.kernels.integrators.memory import ACCEPTED, TIME, Memory
from autobalancer.kernels.integrators.passages import SUM
from autobalancer.kernels.integrators.runge_kutta import FINISHED
from autobalancer.kernels.system import BALLS, SPEED, Floats, Matrix, own
from autobalancer.simulation.long_steps import long_steps
from autobalancer.simulation.outcome import outcome
from autobalancer.simulation.record import record_for
from autobalancer.simulation.remarks.coincidence import pairs_together, parting_rate
from autobalancer.simulation.steppers import LongSteps, stepper_for

LONGEST = 1e9  # s that one speed can be held
NEAR = math.radians(30.0)  # a ball that moves less stays where it is in the rotor, apart from a vibration

Row = dict[str, Any]  # what was seen at one speed: plain numbers and lists, so that it goes into a text exactly


@dataclass(frozen=True)
class Plan:
    """How long a speed is held and measured; see :func:`autobalancer.stepped_response`."""

    dwell: float
    window: float
    acceleration: float  # rad/s^2, infinite for a jump
    settle: float | None
    longest: float
    tolerance: float
    max_steps: int
    method: str = "auto"


class Stepper:
    """Work arrays of one thread."""

    def __init__(
        self, assembly: Assembly, rows: Sequence[Matrix], weights: Floats, plan: Plan, groups: Sequence[list[int]]
    ) -> None:
        self.balls, self.groups, self.named = assembly.balls, groups, weights.size
        if groups:  # whether balls in one place stay there depends on the deflection of their race
            rows = [*rows, *places(assembly)]
            weights = np.append(weights, np.zeros(len(rows) - weights.size))
        self.system = own(assembly.system)
        self.stepper, self.plan = stepper_for(assembly, LONGEST, plan.tolerance, plan.method), plan
        self.assembly, self.memory, self.modes = assembly, self.stepper.memory, dict[float, LongSteps]()
        self.quiet = record_for((), (), assembly, 1.0)
        # an event that never comes: for its sake the stepper keeps the dense output of all components
        self.dense = self.quiet._replace(
            event_kinds=np.array([SUM]),
            event_firsts=np.array([SPEED]),
            event_seconds=np.array([-1]),
            event_levels=np.array([1e300]),
            event_directions=np.zeros(1, np.int64),
            event_terminal=np.zeros(1, np.int64),
            event_seen=np.zeros(1, np.int64),
            event_sides=np.zeros(1),
            event_places=np.zeros(1),
        )
        s, n, size = weights.size, len(assembly.balls), rows[0].shape[1]
        self.window = Window(
            rows=np.ascontiguousarray(np.concatenate(rows), np.float64),
            weights=weights,
            greatest=np.zeros((2, s + 1)),
            low=np.zeros((2, n)),
            high=np.zeros((2, n)),
            ends=np.zeros((2, n)),
            forward=np.zeros((s, 2)),
            spent=np.zeros(3),
            place=np.zeros(size),
            move=np.zeros(size),
            points=np.zeros((s, 2)),
            value=np.zeros(s + 1),
            growth=np.zeros(s + 1),
            before=np.zeros(s + 1),
        )

    def hold(self, state: Floats, speed: float) -> Row:
        """Bring a state to a speed and measure there; without balls and stations lists are empty."""
        m, w, plan = self.memory, self.window, self.plan
        m.state[:] = state
        settle = -1.0 if plan.settle is None else plan.settle
        numbers = [speed, plan.acceleration, plan.dwell, plan.window, settle, plan.longest, plan.max_steps]
        nodes, watch, powers, long, unknowns = self._long_steps_at(speed)
        status = hold(
            *self.stepper.moving, nodes, watch, self.system, self.stepper.pair, powers, self.quiet, self.dense, m, long,
            unknowns, w, np.array(numbers, np.float64),
        )  # fmt: skip
        end, steps = float(m.clock[TIME]), int(m.counts[ACCEPTED])
        taken = int(unknowns.tallies[LONG_STEPS])
        row: Row = {"speed": float(speed), "steps": steps, "long_steps": taken, "state": m.state.tolist()}
        if status != FINISHED:
            planned = float(w.spent[0]) + plan.dwell + plan.window
            ended = outcome(status, end, planned, interrupted=False, steps=steps)
            return row | {"outcome": ended.name, "text": ended.text}
        each = w.greatest[:, : self.named].max(axis=0)
        return (
            row
            | self._parting(m.state, speed)
            | {
                "outcome": "finished",
                "hold": end - float(w.spent[0]),
                "change": float(w.spent[1]),
                "greatest": each.tolist(),
                "amplitude": float(each @ w.weights[: self.named]),
                "mean": float(w.greatest[:, -1].max()),
                "low": w.low.min(axis=0).tolist(),
                "high": w.high.max(axis=0).tolist(),
                "ball_speed": ((w.ends[1] - w.ends[0]) / plan.window).tolist(),
                "forward": w.forward[: self.named].tolist(),
            }
        )

    def _long_steps_at(self, speed: float) -> LongSteps:
        """Long steps at a speed: they depend on no other speed that is asked for, and speeds that are near share them."""
        own, near = self.stepper.long, 0.0
        if own is not None and own.amplitudes.bases.size > 0:
            stride = 2.0 ** (math.floor(math.log2(speed)) - 4)
            near = stride * round(speed / stride)
        if near not in self.modes:
            found = own if near == 0.0 else long_steps(self.assembly, self.memory, near)
            self.modes[near] = found or _no_long_steps(self.memory)
        return self.modes[near]

    def _parting(self, state: Floats, speed: float) -> Row:
        """How fast balls would part that stay in one place of the rotor, the fastest pair."""
        n, w, worst = len(self.balls), self.window, -math.inf
        for one, _ in pairs_together(list(self.groups), state[BALLS : BALLS + n]):
            low, high = w.low[:, one].min(), w.high[:, one].max()
            if high - low > NEAR:
                continue
            ball = self.balls[one]
            center = complex(*w.forward[self.named + ball.balancer]) + ball.eccentricity
            outward = (center * cmath.exp(-0.5j * (low + high))).real
            worst = max(worst, parting_rate(ball, speed, outward))
        return {"parting": worst} if math.isfinite(worst) else {}


def _no_long_steps(memory: Memory) -> LongSteps:
    """In place of those that a machine cannot take: no modes, so that all steps are those of the pair."""
    nothing = amplitudes(np.zeros(0), np.zeros((0, 0)), np.zeros(0, np.int64), 0, np.zeros(0), 0, turning=False)
    return LongSteps(planar_nodes, contacts_in_steps, by_powers(), memory, nothing)


def places(assembly: Assembly) -> list[Matrix]:
    """Rows of the deflection of each balancer; a planar rotor has one place."""
    if assembly.places.shape[0]:
        return list(assembly.places)
    return [np.eye(2)] * (1 + max((ball.balancer for ball in assembly.balls), default=0))


def at_speed(state: Floats, speed: float) -> Floats:
    """A start state with the rotor at a speed."""
    state = state.copy()
    state[SPEED] = speed
    return state


def rate(acceleration: float | None) -> float:
    """The rate of a ramp; a jump is infinitely fast."""
    return math.inf if acceleration is None else float(acceleration)
