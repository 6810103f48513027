"""What is odd in the description of a machine and the length of its run, in words."""

from __future__ import annotations

from typing import Any

from autobalancer.assembly.drive_train import corners, highest_prescribed
from autobalancer.assembly.reduced_rotor import has_hardening, has_rubber
from autobalancer.assembly.system import Assembly
from autobalancer.catalog.resolve import resolve
from autobalancer.machine import Machine, MatricesRotor, PrescribedSpeed
from autobalancer.machine.drive import Hill
from autobalancer.machine.keys import USUAL, bare_numbers
from autobalancer.tables import rpm_and_si
from autobalancer.units import WrittenFloat

REACHED = 0.95  # of the last speed of an S-shaped run-up, which never ends: a run that comes so far is long enough
SMALLEST_SHIFT = 2e-7  # m: balls that move the center of mass by less balance nothing that can be measured


def input_notes(machine: Machine, end: float | None) -> tuple[str, ...]:
    """Sentences on numbers that were hardly meant in SI, and on a run of ``end`` seconds that ends before its speed profile."""
    return (
        bare_numbers(machine)
        + _too_heavy(machine)
        + _of_matrices(machine)
        + (() if end is None else _ends_early(machine, end))
    )


def _too_heavy(machine: Machine) -> tuple[str, ...]:
    """A mass without a unit beside which the balls of the machine are nothing."""
    mass = getattr(machine.rotor, "mass", None)
    able = sum(ball.moment for ball in resolve(machine))
    if (
        not isinstance(mass, float)
        or isinstance(mass, WrittenFloat)
        or mass > USUAL["kg"][1]
        or not 0.0 < able < SMALLEST_SHIFT * mass
    ):
        return ()
    return (
        f"rotor.mass = {mass:.10g} was read in kg, since a number without a unit is SI; beside it the balls can move the center "
        f'of mass by {1e6 * able / mass:.2g} um at most. Write the mass with its unit, "{mass:.10g} g" if that is meant',
    )


HEAVY = 0.1  # balls over the mass of a rotor of matrices, beyond which their unit is in doubt


def _of_matrices(machine: Machine) -> tuple[str, ...]:
    """A rotor of matrices beyond the frequency for which its coordinates stand, and one that is light beside its balls."""
    rotor, notes = machine.rotor, []
    if not isinstance(rotor, MatricesRotor):
        return ()
    top, balls = highest_prescribed(machine), sum(ball.mass for ball in resolve(machine))
    if top is not None and rotor.valid_to is not None and top > float(rotor.valid_to):
        notes.append(
            f"the machine turns at up to {rpm_and_si(top)}, and its few coordinates stand for all rows of the matrices up to "
            f"{rpm_and_si(float(rotor.valid_to))} only; keep more 'modes' (rotor.files)"
        )
    if balls > HEAVY * rotor.mass:
        notes.append(
            f"the balls are {100.0 * balls / rotor.mass:.3g} % of the mass of the rotor, {rotor.mass:.4g} kg; look at the "
            "units of the matrices (rotor.files.mass_unit) if it is heavier"
        )
    return tuple(notes)


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


# Critical speeds as a result notes them, and of which motions they are.


def critical_attributes(machine: Machine, assembly: Assembly) -> dict[str, Any]:
    """Critical speeds (rad/s) and their gyroscopic shares; that they are those of small motions where the stiffness changes."""
    attributes: dict[str, Any] = {"critical_speeds": list(assembly.critical_speeds)}
    if assembly.gyroscopic_shares:
        attributes["gyroscopic_shares"] = list(assembly.gyroscopic_shares)
    if has_rubber(machine) or has_hardening(machine):
        attributes["critical_speeds_of"] = "small motions"
    return attributes
