"""A ring partly filled with liquid, in place of balls."""

from __future__ import annotations

from pydantic import model_validator

from autobalancer.machine.balancer.fluid import Fluid
from autobalancer.machine.part import Label, Part, key
from autobalancer.machine.quantity import Length, Mass


class LiquidRing(Part):
    """A hollow ring around a planar rotor, partly filled with liquid, as on the drums of washing machines.

    Give the ``layer`` of liquid that the turning rotor would have without deflection, or the mass of the ``liquid``. Without
    ``width`` there is no inner wall.
    """

    name: Label = key("used in messages and results", "")
    radius: Length = key("of the outer wall, inside", symbol="R")
    height: Length = key("along the axis, inside", symbol="L")
    width: Length | None = key("from the outer to an inner wall, inside", None)
    layer: Length | None = key("thickness on the outer wall while the rotor turns; this or `liquid`", None)
    liquid: Mass | None = key("mass of the liquid; this or `layer`", None)
    fluid: Fluid = key("the liquid; its viscosity does not affect a steady whirl")

    @model_validator(mode="after")
    def _filled(self) -> LiquidRing:
        if (self.layer is None) == (self.liquid is None):
            raise ValueError("give either 'layer' or 'liquid', the mass")
        if self.fluid.lag != "none":
            raise ValueError("fluid.lag: the liquid of a ring turns with it in the answers there are; leave it out")
        room = self.radius if self.width is None else min(self.width, self.radius)
        if self.width is not None and self.width >= self.radius:
            raise ValueError(
                f"width: given {1e3 * self.width:.4g} mm, but the outer wall is at {1e3 * self.radius:.4g} mm; must be smaller"
            )
        if self.layer is not None and self.layer >= room:
            raise ValueError(
                f"layer: given {1e3 * self.layer:.4g} mm, which fills the ring; must be less than {1e3 * room:.4g} mm, because "
                "only liquid with a free surface balances"
            )
        return self
