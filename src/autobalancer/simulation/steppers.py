"""How a run is integrated: by an explicit pair, or by long steps with the pair beside them."""

from __future__ import annotations

from typing import Any, Literal, NamedTuple, get_args

from autobalancer.assembly.system import Assembly
from autobalancer.errors import QuestionError
from autobalancer.kernels.cache import Work, compile_together
from autobalancer.kernels.given import given
from autobalancer.kernels.integrators import tableau as tableaus
from autobalancer.kernels.integrators.memory import ACCEPTED, EVALUATIONS, REJECTED, Memory
from autobalancer.kernels.integrators.record import Record
from autobalancer.kernels.integrators.runge_kutta import advance
from autobalancer.kernels.integrators.switching import switch_type
from autobalancer.kernels.system import System, rhs_type
from autobalancer.kernels.wide import NODES
from autobalancer.simulation.equations import Equations, equations
from autobalancer.simulation.fresh import memory_for

Method = Literal["auto", "dormand_prince_8", "tsitouras", "exponential_collocation"]


class LongSteps(NamedTuple):
    """What long steps need beside the pair."""

    nodes: Any  # forces at the nodes of a step
    watch: Any  # how far they hold
    powers: tableaus.Tableau
    memory: Memory  # shares time, state and counts with that of the pair
    amplitudes: Any


class Stepper(NamedTuple):
    """One integration of an assembled machine; it can stop after any step and go on."""

    method: str
    moving: Equations
    pair: tableaus.Tableau
    memory: Memory
    long: LongSteps | None = None

    def make_ready(self) -> None:
        """Load or compile the kernels of a run, those of its result too."""
        from autobalancer.kernels.measures.response import with_balls_held
        from autobalancer.kernels.measures.seen import see

        rates, switch = self.moving
        works: list[Work] = [(switch, switch_type.signature), (rates, rhs_type.signature)]
        if self.long is None:
            works += [(with_balls_held, None), (see, None), (advance, None)]
        else:
            from autobalancer.kernels.integrators.collocation.amplitudes import nodes_type, watch_type
            from autobalancer.kernels.integrators.collocation.march import march

            works += [(self.long.nodes, nodes_type.signature), (self.long.watch, watch_type.signature)]
            works += [(with_balls_held, None), (see, None), (march, None)]
        compile_together(works, then=OF_RESULTS)

    def advance(self, system: System, record: Record, budget: int) -> int:
        """Take up to ``budget`` accepted steps; returns how that ended, see kernels/integrators/runge_kutta.py."""
        moving = self.moving.ready()
        if self.long is None:
            return int(advance(*moving, system, self.pair, record, self.memory, budget))
        from autobalancer.kernels.integrators.collocation.amplitudes import nodes_type, watch_type
        from autobalancer.kernels.integrators.collocation.march import march

        nodes, watch, powers, memory, amplitudes = self.long
        ways = given(nodes, nodes_type), given(watch, watch_type)
        return int(march(*moving, *ways, system, self.pair, powers, record, self.memory, memory, amplitudes, budget))

    def attributes(self) -> dict[str, str | int]:
        """For a result: the method and its work."""
        counts, work = self.memory.counts, {}
        if self.long is not None:
            from autobalancer.kernels.integrators.collocation.amplitudes import LONG_STEPS, SWEEPS

            tallies = self.long.amplitudes.tallies
            work = {"long_steps": int(tallies[LONG_STEPS]), "sweeps": int(tallies[SWEEPS]), "lanes": NODES}
        return {
            "method": self.method,
            "steps": int(counts[ACCEPTED]),
            "rejected_steps": int(counts[REJECTED]),
            "evaluations": int(counts[EVALUATIONS]),
            **work,
        }


OF_RESULTS = tuple(f"autobalancer.kernels.measures.{name}" for name in ("series", "impacts", "motion", "verdict"))
FINEST = 1e-11  # tolerance below which "auto" takes the pair: long steps were compared with it down to 1e-9


def stepper_for(assembly: Assembly, end: float, tolerance: float, method: str = "auto") -> Stepper:
    """A fresh integration of a machine up to ``end``.

    Raises
    ------
    QuestionError
        If the method is unknown or this machine cannot be integrated with it.
    """
    if method not in get_args(Method):
        raise QuestionError(
            f"method: given {method!r}; must be 'auto', 'dormand_prince_8', 'tsitouras' or 'exponential_collocation'"
        )
    pair = tableaus.tsitouras() if method == "tsitouras" else tableaus.dormand_prince_8()
    memory, moving = memory_for(assembly, end, tolerance, pair), equations(assembly)
    if method == "exponential_collocation" or (method == "auto" and tolerance >= FINEST):
        from autobalancer.simulation.long_steps import NEARLY_THE_SAME, long_steps, why_no_long_steps

        obstacle, long = why_no_long_steps(assembly), None
        if not obstacle and (long := long_steps(assembly, memory)) is None:
            obstacle = NEARLY_THE_SAME
        if obstacle and method != "auto":
            raise QuestionError(f"method: 'exponential_collocation' is not possible here: {obstacle}; take 'auto'")
        if long is not None:
            return Stepper("exponential_collocation", moving, pair, memory, long)
    return Stepper("dormand_prince_8" if method == "auto" else method, moving, pair, memory)
