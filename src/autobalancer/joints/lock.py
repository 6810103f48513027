"""Two bodies that are one."""

from __future__ import annotations

from typing import ClassVar, Literal

from autobalancer.errors import Problem
from autobalancer.machine.rotors.body import GROUND
from autobalancer.machine.rotors.joint import Joint


class Lock(Joint):
    """Merges two bodies into one, exactly; between a standing and a rotating body all but the turning is locked."""

    kind: Literal["lock"] = "lock"
    interface: ClassVar[int] = 1

    def unfit(self, turning: int) -> list[Problem]:
        """The ground is no body."""
        text = f"a body cannot be locked to the {GROUND!r}; leave it out and connect the others to the ground"
        return [(("between",), text)] if GROUND in self.between else []
