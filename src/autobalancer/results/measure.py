"""What a measure is: a number of a run, or one for each ball or place, and what a sweep keeps of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

NEEDS = {
    "": "bins",
    "ball": "balls",
    "place": "turns",
    "plane": "planes",
    "support": "forces",
    "jump": "parts",
    "link": "links",
}
Of = Callable[[Any], Any]  # of a Recorded in which nothing that the measure needs is None


class OfAll(NamedTuple):
    """The one number that a sweep keeps of a measure with several; ``name`` where it has its own."""

    text: str
    of: Of
    needs: str = ""  # by default what the measure needs
    name: str = ""
    per_ball: bool = False  # then a sweep has them all


class Measure(NamedTuple):
    """One measure: ``of`` gives a number, or an array along ``along``.

    It is left out where the run did not record what :data:`NEEDS` says of ``along``, or what it ``needs`` besides, both names
    of :class:`~autobalancer.results.recorded.Recorded`. A sweep keeps measures that are one number, those over the balls, and
    ``of_all`` of the others.
    """

    name: str
    unit: str
    along: str
    text: str
    of: Of
    of_all: OfAll | None = None
    needs: str = ""


class InSweep(NamedTuple):
    """A measure as a sweep has it: one number of a run, or one for each ball."""

    name: str
    unit: str
    text: str
    per_ball: bool
    of: Of
    needs: tuple[str, ...]


def needed(measure: Measure) -> tuple[str, ...]:
    """What a run must have recorded for a measure."""
    return NEEDS[measure.along], *([measure.needs] if measure.needs else [])
