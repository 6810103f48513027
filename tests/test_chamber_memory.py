"""A run that is streamed takes as much memory as its chunk, however long it lasts."""

from __future__ import annotations

import tracemalloc

from tests.references.chamber_machines import small_machine

from autobalancer.simulation.chamber import simulate_chamber

MACHINE = small_machine()
STEP, CHUNK = 2e-6, 20


def greatest(duration: float, keep: bool = False) -> int:
    """Bytes of arrays and objects at most while a run is computed."""
    tracemalloc.start(1)
    simulate_chamber(MACHINE, duration=duration, step=STEP, settle=False, chunk=CHUNK, keep=keep)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return most


def test_memory_of_a_streamed_run_does_not_grow_with_its_duration() -> None:
    simulate_chamber(MACHINE, duration=0.02, step=STEP, settle=False)  # whatever is compiled or imported
    short = greatest(0.06)
    assert greatest(0.3) < 1.2 * short  # five times as long; when garbage is collected makes a difference of up to 7 %
    assert greatest(0.3, keep=True) > 3.0 * short  # so it could be seen
