"""What is odd in the description of a machine and the length of its run, in words."""

from __future__ import annotations

from autobalancer.assembly.profile import corners
from autobalancer.machine import Machine, PrescribedSpeed
from autobalancer.machine.bare_numbers import bare_numbers
from autobalancer.machine.profile import Hill

REACHED = 0.95  # of the last speed of an S-shaped run-up, which never ends: a run that comes so far is long enough


def input_notes(machine: Machine, end: float | None) -> tuple[str, ...]:
    """Sentences on numbers that were hardly meant in SI, and on a run of ``end`` seconds that ends before its speed profile."""
    return bare_numbers(machine) + (() if end is None else _ends_early(machine, end))


def _ends_early(machine: Machine, end: float) -> tuple[str, ...]:
    if not isinstance(machine.drive, PrescribedSpeed):
        return ()
    profile = machine.drive.profile
    if isinstance(profile, Hill):
        last = float(profile.half_time) * (REACHED / (1.0 - REACHED)) ** (1.0 / float(profile.exponent))
        what = f"has come {100.0 * REACHED:.0f} % of its way"
    else:
        last, what = corners(profile)[-1][0], "ends"
    if end >= last * (1.0 - 1e-9):
        return ()
    return (
        f"the run lasts {end:.5g} s, but the speed profile {what} at {last:.5g} s only; run longer (run.duration) to reach its "
        "last speed",
    )
