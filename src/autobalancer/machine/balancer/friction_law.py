"""How a wall brakes a ball that slides on it: what a friction law of resolved balls is."""

from __future__ import annotations

from typing import ClassVar

from autobalancer.machine.leaves import Leaf


class FrictionLaw(Leaf):
    """The coefficient of friction of a resolved ball on its walls over its slip.

    A leaf of this family is one class with this static method, which is compiled when it is first used; ``at`` is the slip
    (fields of ``SLIP`` in kernels/records/friction.py), ``own`` has the keys of the leaf that are numbers.

    ``coefficient(at, own) -> float``
        Friction over the force of the wall, with the sign of the slip ``at.slip``, which it opposes; zero without slip,
        and smooth.
    """

    family: ClassVar[str] = "friction"
    one: ClassVar[str] = "friction law"
    current: ClassVar[int] = 1

    def unfit(self, sliding: float) -> str:
        """What is wrong with it beside this coefficient of sliding friction; empty if nothing is."""
        return ""
