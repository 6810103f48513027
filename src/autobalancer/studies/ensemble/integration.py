"""A fresh run of one member: all numbers that the compiled loop needs."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import types

from autobalancer.assembly.contact.touches import with_touches
from autobalancer.assembly.gauges import MOST, desk_for
from autobalancer.assembly.places import Places
from autobalancer.assembly.profile import unbalance_jumps
from autobalancer.assembly.system import Assembly
from autobalancer.kernels.ensemble.members import run_members
from autobalancer.kernels.ensemble.numbers import count_numbers
from autobalancer.kernels.integrators.memory import Memory, memory_type
from autobalancer.kernels.integrators.record import Record, record_type
from autobalancer.kernels.measures.columns import WIDTH
from autobalancer.kernels.measures.gauges import Gauges, gauges_type
from autobalancer.kernels.system import VX, Integers, Matrix, System, system_type
from autobalancer.results.measure_table import SWEPT
from autobalancer.results.recorded import SETTLING_FROM
from autobalancer.simulation.record import record_for
from autobalancer.simulation.sampling import Envelope, LastRevolutions, Sampling
from autobalancer.simulation.steppers import Stepper, stepper_for
from autobalancer.studies.ensemble.layout import Layout
from autobalancer.studies.sweep_row import gauges_for

APART = ("system.impacts",)  # room that a run need not find empty
ASKABLE = (*(one.name for one in SWEPT), "verdict")  # measures of a member
# what measures need (results/measure.py) that is not in the envelope
OF_TURNS, OF_END = {"turns", "planes", "forces", "rotor"}, {"final_angle", "impacts"}
MIXED = {"residual_vibration", "vibration", "verdict"}  # for which the envelope is compared with the last revolutions


class Plan(NamedTuple):
    """How members are run."""

    end: float  # s
    tolerance: float
    bins: int
    max_steps: int
    method: str = "auto"
    settling_from: str = SETTLING_FROM[0]
    measures: tuple[str, ...] = ASKABLE

    @property
    def wishes(self) -> list[Sampling]:
        """What a run has to record for the measures: nothing where its end alone is asked for."""
        needs = [set(one.needs) for one in SWEPT if one.name in self.measures and OF_END.isdisjoint(one.needs)]
        both = not MIXED.isdisjoint(self.measures)
        found: list[Sampling] = []
        if both or any(need.isdisjoint(OF_TURNS) for need in needs):
            found.append(Envelope(self.bins))
        if both or any(not need.isdisjoint(OF_TURNS) for need in needs):
            found.append(LastRevolutions())
        return found


class Integration(NamedTuple):
    """What a run changes or reads; the order is that of the words in a block."""

    system: System
    record: Record
    memory: Memory
    gauges: Gauges
    long: tuple[Any, ...] = ()  # memory and amplitudes of long steps


def kind_of(one: Integration) -> Any:
    """Its compiled type."""
    kinds = [system_type, record_type, memory_type, gauges_type]
    if one.long:
        from autobalancer.kernels.integrators.collocation.amplitudes import amplitudes_type

        kinds.append(types.Tuple((memory_type, amplitudes_type)))  # type: ignore[no-untyped-call]
    return types.Tuple(kinds)  # type: ignore[no-untyped-call]


def fresh_integration(
    assembly: Assembly, places: Places, plan: Plan, known: dict[Any, Record] | None = None
) -> tuple[Integration, Stepper]:
    """A run of an assembled machine that has not begun, and how it is integrated; empty records that are ``known`` are taken."""
    jumps, known = unbalance_jumps(places.machine, plan.end), {} if known is None else known
    empty = jumps, assembly.state.size, tuple(assembly.state[:VX])
    if empty not in known:
        known[empty] = record_for(plan.wishes, (), assembly, plan.end, jumps)
    record = known[empty]
    noting, touches = with_touches(places.machine, assembly)
    stepper = stepper_for(noting, plan.end, plan.tolerance, plan.method)
    gauges = gauges_for(noting, places, plan.end, touches)
    long = (stepper.long.memory, stepper.long.amplitudes) if stepper.long is not None else ()
    return Integration(noting.system, record, stepper.memory, gauges, long), stepper


class Bench:
    """A place where one thread runs members of one layout, one after the other."""

    def __init__(self, first: Integration, stepper: Stepper, layout: Layout) -> None:
        self._block = np.zeros(layout.size, np.int64)
        self._own: Integration = layout.viewed(first, self._block)
        self._stepper = stepper
        record = self._own.record
        hits = MOST if len(self._own.system.touches) else 0
        self._desk = desk_for(self._own.gauges, record.turn_states.shape[0], record.bin_low.size, hits)
        self._run: Any = run_members
        self._how: tuple[Any, ...] = ()
        if stepper.long is not None:
            from autobalancer.kernels.ensemble.long_members import run_members_long

            nodes, watch, powers, _, amplitudes = stepper.long
            self._run = run_members_long
            self._how = nodes, watch, powers, *self._own.long, layout.numbers - count_numbers(amplitudes)

    @property
    def record(self) -> Record:
        """What the member that ran last was asked to keep; the next one overwrites it."""
        return self._own.record

    def run(
        self, fresh: Integers, places: Integers, words: Any, part: range, most: int, flags: Integers, found: Found
    ) -> None:
        """Run some of the members and write down what they leave."""
        own = self._own
        self._run(
            *self._stepper.moving, *self._how, own.system, self._stepper.pair, own.record, own.memory, own.gauges,
            self._desk, self._block, fresh, places, words, part.start, part.stop, most, flags,
            found.rows, found.states, found.counts,
        )  # fmt: skip


class Found(NamedTuple):
    """What members of one layout leave, a row for each."""

    rows: Matrix  # (members, WIDTH + n) measures
    states: Matrix  # (members, states), or (0, 0)
    counts: Any  # (members, 3) accepted, rejected, evaluations; no accepted step: it did not run

    @classmethod
    def room(cls, members: int, balls: int, states: int) -> Found:
        """Room for so many members, with so many numbers of a state."""
        return cls(
            np.full((members, WIDTH + balls), np.nan),
            np.full((members if states else 0, states), np.nan),
            np.zeros((members, 3), np.int64),
        )
