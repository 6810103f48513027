"""How the viscosity of a fluid depends on the rate at which it is sheared: what a shear law is.

The stress depends on the rate of shear alone (generalised Newtonian fluid): tau = rho nu s(g) g, with the viscosity nu at rest,
the rate of shear g = sqrt(2 D : D) and its share s(g), which is 1 at rest. At another temperature than that of the measurement
the share is that at the rate a g with a = (nu/nu_0) (T_0/T): method of reduced variables (Bird, Armstrong and Hassager 1987).
"""

from __future__ import annotations

from typing import Any, ClassVar

from autobalancer.machine.leaves import Leaf
from autobalancer.machine.part import key
from autobalancer.machine.quantity import Positive, Temperature


class ShearLaw(Leaf):
    """Share of the viscosity at rest that a sheared fluid has.

    A law of this family is one class with the key ``law`` and the method ``share``.
    """

    family: ClassVar[str] = "shear"
    one: ClassVar[str] = "shear law"
    tag: ClassVar[str] = "law"
    current: ClassVar[int] = 1
    at_ball: Positive | None = key(
        "effective rate of shear at a ball, over its velocity divided by its diameter; `sheared-drag` finds it. "
        "Needed where the drag follows from the fluid",
        None,
    )
    measured_at: Temperature | None = key(
        "temperature for which the rates or times are given, of a fluid of the catalog; without it that of the fluid",
        None,
    )

    def share(self, rate: Any) -> Any:
        """Viscosity over that at rest at rates of shear (1/s, an array, not negative); 1 at rest."""
        raise NotImplementedError(f"{type(self).__name__} has no method 'share'")

    @property
    def highest(self) -> float:
        """Rate of shear up to which the law is known, 1/s."""
        return float("inf")
