"""Drag laws of balls in their races, one in each file; the file has the name of its ``law``."""

import autobalancer.machine  # noqa: F401  (it reads the leaves of this package, so it comes first)
from autobalancer.laws.drag_coefficient import DragLaw
from autobalancer.machine.balancer.fluid import Drag
from autobalancer.machine.plugins import leaves_of
from autobalancer.tables import Table


class DragLaws(Table[DragLaw]):
    """Drag laws, a tuple."""

    head = ("law", "c_d Re at rest", "up to Re", "source")

    def row(self, entry: DragLaw) -> tuple[str, ...]:
        """Name, product at rest, highest Reynolds number and source."""
        return (entry.name, f"{entry.cd_times_re:g}", f"{entry.highest:g}", entry.source)


def drag_laws() -> DragLaws:
    """The drag laws that need no further parameter, also your own that were registered."""
    return DragLaws(law for leaf in leaves_of(Drag) if issubclass(leaf, Drag) for law in leaf.listed())
