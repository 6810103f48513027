"""Drag laws of balls in their races, one in each file; the file has the name of its ``law``."""

import autobalancer.machine  # noqa: F401  (it reads the leaves of this package, so it comes first)
from autobalancer.laws.drag_coefficient import DragLaw
from autobalancer.machine.balancer.drag import Drag
from autobalancer.machine.leaves import leaves_of


def drag_laws() -> tuple[DragLaw, ...]:
    """The drag laws that need no further parameter, also your own that were registered."""
    return tuple(law for leaf in leaves_of(Drag) if issubclass(leaf, Drag) for law in leaf.listed())
