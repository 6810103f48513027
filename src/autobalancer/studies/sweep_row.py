"""The measures of one run of a sweep, as plain numbers."""

from __future__ import annotations

from typing import Any

import numpy as np

from autobalancer.assembly.contact.touches import Touch
from autobalancer.assembly.gauges import desk_for, gauges_of
from autobalancer.assembly.place_response import without_balancing
from autobalancer.assembly.places import Places
from autobalancer.assembly.profile import unbalance_jumps
from autobalancer.assembly.system import Assembly
from autobalancer.kernels.integrators.memory import ACCEPTED, Memory
from autobalancer.kernels.integrators.record import Record
from autobalancer.kernels.measures.columns import END, END_SPEED, STATUS, VERDICT, VIBRATION, WIDTH, WITHOUT
from autobalancer.kernels.measures.gauges import HELD, Gauges
from autobalancer.kernels.measures.limits import FASTEST, ITERATED
from autobalancer.kernels.measures.row import judged, measure_row
from autobalancer.kernels.system import Floats
from autobalancer.results.impacts import Impacts
from autobalancer.results.measure_table import in_row
from autobalancer.results.recorded import SETTLING_FROM
from autobalancer.results.standing import NONE, static_load
from autobalancer.results.verdict.rule import WORDS
from autobalancer.simulation.outcome import outcome


def sweep_row(
    status: int,
    assembly: Assembly,
    places: Places,
    record: Record,
    memory: Memory,
    end: float,
    impacts: Impacts | None = None,
) -> dict[str, Any]:
    """All that a sweep keeps of a run with an envelope and its last revolutions; nan for what it cannot say."""
    gauges = gauges_for(assembly, places, end)
    hits = impacts.time.size if impacts is not None else 0
    desk = desk_for(gauges, record.turn_states.shape[0], record.bin_low.size, hits)
    desk.noted[0] = 0
    if impacts is not None:
        desk.hits[:], desk.noted[0] = (impacts.time, impacts.speed, impacts.lost, impacts.impulse), hits
    row = np.empty(WIDTH + len(assembly.balls))
    measure_row(assembly.system, record, memory, gauges, desk, status, row)
    return named(completed(row, assembly, places, gauges), end, int(memory.counts[ACCEPTED]))


def gauges_for(assembly: Assembly, places: Places, end: float, touches: tuple[Touch, ...] = ()) -> Gauges:
    """What the measures of runs of a machine up to ``end`` (s) need; of its ``touches`` those that note impacts."""
    centered = static_load(places.machine) == NONE
    return gauges_of(assembly, places, unbalance_jumps(places.machine, end), touches, centered=centered)


def completed(row: Floats, assembly: Assembly, places: Places, gauges: Gauges) -> Floats:
    """The same row with the vibration without balls of a rotor on softening rubber, which no compiled code finds."""
    known = not np.isnan(row[VIBRATION])
    if gauges.scalars[HELD] == ITERATED and known and abs(row[END_SPEED]) < FASTEST:
        row[WITHOUT] = without_balancing(assembly, places, gauges, row[END], row[END_SPEED])[0].max()
        row[VERDICT] = judged(row)
    return row


def named(row: Floats, end: float, steps: int, settling_from: str = SETTLING_FROM[0]) -> dict[str, Any]:
    """The numbers of a row by name, with ``outcome`` and ``verdict`` in words; the run was to reach ``end`` (s)."""
    ended = outcome(int(row[STATUS]), row[END], end, interrupted=False, steps=steps).name
    return {"outcome": ended, "verdict": WORDS[int(row[VERDICT])], **in_row(row, settling_from)}
