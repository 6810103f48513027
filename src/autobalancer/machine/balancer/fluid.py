"""The fluid in a race."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, NamedTuple

from pydantic import model_validator

from autobalancer.machine.part import Density, Part, Positive, Ratio, Temperature, Viscosity, key
from autobalancer.machine.plugins import Leaf, OneOf

if TYPE_CHECKING:
    from autobalancer.laws.drag_coefficient import DragLaw


# How the viscosity of a fluid depends on the rate at which it is sheared: what a shear law is.
#
# The stress depends on the rate of shear alone (generalised Newtonian fluid): tau = rho nu s(g) g, with the viscosity
# nu at rest, the rate of shear g = sqrt(2 D : D) and its share s(g), which is 1 at rest. At another temperature than
# that of the measurement the share is that at the rate a g with a = (nu/nu_0) (T_0/T): method of reduced variables
# (Bird, Armstrong and Hassager 1987).


class ShearLaw(Leaf):
    """Share of the viscosity at rest that a sheared fluid has.

    A law of this family is one class with the key ``law`` and the method ``share``.
    """

    family: ClassVar[str] = "shear"
    one: ClassVar[str] = "shear law"
    tag: ClassVar[str] = "law"
    current: ClassVar[int] = 1
    at_ball: Positive | None = key(
        "effective rate of shear at a ball, over its velocity divided by its diameter; `plot_sheared_drag` computes it. "
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


class Fluid(Part):
    """A fluid of the catalog at a temperature, or one given by density and kinematic viscosity.

    The balls lose the mass of the fluid they displace as balancing mass and gain ``virtual_mass`` times it as
    inertia (2 near a wall: Jan and Chen 1997; Spannan 2021, section 5.2.3).

    ``lag`` says how the fluid follows its chamber when the speed changes: at once (``none``), by diffusion (``modes``), by the
    ``full`` equations of the flow, or whichever of both is needed (``auto``). With a drive that is a torque the full equations
    take a few runs.
    """

    name: str | None = key("of the catalog; this, or density and viscosity", None)
    temperature: Temperature | None = key("of a fluid of the catalog; without it 25 °C", None, symbol="T")
    density: Density | None = key("with viscosity, instead of a name", None, symbol=r"\rho")
    viscosity: Viscosity | None = key("kinematic", None, symbol=r"\nu")
    virtual_mass: Ratio = key("fluid mass that moves with a ball, over the mass it displaces", 2.0)
    shear: Annotated[ShearLaw, OneOf(ShearLaw)] | None = key(
        "how the viscosity changes with the rate of shear; `viscosity`, or that of the catalog, is the one at rest",
        None,
    )
    lag: Literal["none", "modes", "full", "auto"] = key(
        "how the fluid follows the rotor when the speed changes; needs `width` and `height` of the race", "none"
    )

    @model_validator(mode="after")
    def _one_way(self) -> Fluid:
        numbers = self.density is not None and self.viscosity is not None
        if (self.name is not None) == numbers or (self.density is None) != (self.viscosity is None):
            raise ValueError("give either the 'name' of a fluid of the catalog, or 'density' and 'viscosity'")
        if numbers and self.temperature is not None:
            raise ValueError("temperature: has no effect on a fluid given by density and viscosity; leave it out")
        if numbers and self.shear is not None and self.shear.measured_at is not None:
            raise ValueError("shear.measured_at: has no effect on a fluid given by density and viscosity; leave it out")
        if self.shear is not None and self.lag in ("modes", "full"):
            raise ValueError(
                f"lag: given {self.lag!r}, which is for constant viscosity; with 'shear' use 'auto', without secondary flow"
            )
        return self


# How the fluid brakes a ball that moves in its race: what a drag law is.
#
# In the Stokes range the product of drag coefficient and Reynolds number is a constant of the geometry, and the drag
# is linear, T = beta phi' with beta = (c_d Re) (pi/4) rho nu r_b eps^2 (Spannan 2021, 5.26). A law of ``range``
# "linear" keeps to that at any speed; one of range "whole" follows c_d(Re).


Range = Literal["linear", "whole"]

RANGE = "`linear` at any speed, or `whole`: over all Reynolds numbers"


class BallInRace(NamedTuple):
    """What a drag law knows of a ball: its ``radius`` and the ``orbit_radius`` of its center, m."""

    radius: float
    orbit_radius: float


class Drag(Leaf):
    """How the fluid brakes a ball: its drag coefficient over the Reynolds number of its diameter.

    A law of this family is one class with the key ``law`` and the method ``curve``.
    """

    family: ClassVar[str] = "drag"
    one: ClassVar[str] = "drag law"
    tag: ClassVar[str] = "law"
    current: ClassVar[int] = 1
    needs_fluid: ClassVar[bool] = True

    def curve(self, ball: BallInRace) -> DragLaw:
        """Drag coefficient of this ball; your own is made by ``ab.laws.sampled_drag_law`` or ``linear_drag_law``."""
        raise NotImplementedError(f"{type(self).__name__} has no method 'curve'")

    def torque(self, ball: BallInRace) -> float:
        """Torque over speed in the rotor, N m s, of a law that needs no fluid; such a law has no curve."""
        raise NotImplementedError(f"{type(self).__name__} needs no fluid, but has no method 'torque'")

    @classmethod
    def listed(cls) -> tuple[DragLaw, ...]:
        """What lists and pictures of drag laws show of it."""
        return ()
