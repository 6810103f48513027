"""Critical speeds as a result notes them, and of which motions they are."""

from __future__ import annotations

from typing import Any

from autobalancer.assembly.bearings.hardening import has_hardening
from autobalancer.assembly.rubber import has_rubber
from autobalancer.assembly.system import Assembly
from autobalancer.machine import Machine


def critical_attributes(machine: Machine, assembly: Assembly) -> dict[str, Any]:
    """The critical speeds (rad/s); where the stiffness depends on the deflection, that they are those of small motions."""
    found: dict[str, Any] = {"critical_speeds": list(assembly.critical_speeds)}
    if has_rubber(machine) or has_hardening(machine):
        found["critical_speeds_of"] = "small motions"
    return found
