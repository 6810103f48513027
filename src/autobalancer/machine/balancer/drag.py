"""How the fluid brakes a ball that moves in its race.

In the Stokes range the product of drag coefficient and Reynolds number is a constant of the geometry, and the drag is linear,
T = beta phi' with beta = (c_d Re) (pi/4) rho nu r_b eps^2 (Spannan 2021, 5.26). A law of ``range`` "linear" keeps to that at
any speed; one of range "whole" follows c_d(Re), laws/drag_coefficient.py.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from autobalancer.machine.part import Listed, Part, key
from autobalancer.machine.quantity import AngularDamping, Length, Positive

Range = Literal["linear", "whole"]

RANGE = "`linear` at any speed, or `whole`: over all Reynolds numbers"


class DragTorque(Part):
    """beta itself, N m s per ball."""

    law: Literal["beta"] = "beta"
    beta: AngularDamping = key("drag torque on one ball over its speed in the rotor", symbol=r"\beta")


class PlaneDrag(Part):
    """A ball that rolls on a plane wall: c_d Re = 322 up to Re = 10 (Jan and Chen 1997; Spannan 2021, 5.21)."""

    law: Literal["sphere_on_plane"] = "sphere_on_plane"
    range: Range = key(RANGE, "linear")


class AnnulusDrag(Part):
    """A ball in the annulus of a balancer; ``clear_width`` is W_1 of Spannan 2021, (5.22).

    Over the whole range c_d tends to ``plateau`` at Re = 20 000, by default that of a sphere on a plane, 0.74.
    """

    law: Literal["race_geometry"] = "race_geometry"
    clear_width: Length = key("$W_1$ of Spannan (2021), figure 5.7", symbol="W_1")
    range: Range = key(RANGE, "linear")
    plateau: Positive | None = key("drag coefficient from Re = 20 000 on; without it 0.74", None)

    @model_validator(mode="after")
    def _sense(self) -> AnnulusDrag:
        if self.range == "linear" and self.plateau is not None:
            raise ValueError("plateau: has no effect on a linear law; leave it out, or set range = 'whole'")
        return self


class CoefficientDrag(Part):
    """A known product of drag coefficient and Reynolds number; over the whole range also the ``plateau`` of c_d."""

    law: Literal["cd_re"] = "cd_re"
    cd_re: Positive = key("drag coefficient times Reynolds number", symbol=r"c_d \mathrm{Re}")
    range: Range = key(RANGE, "linear")
    plateau: Positive | None = key("drag coefficient from Re = 20 000 on; required by `whole`", None)

    @model_validator(mode="after")
    def _sense(self) -> CoefficientDrag:
        if self.range == "linear" and self.plateau is not None:
            raise ValueError("plateau: has no effect on a linear law; leave it out, or set range = 'whole'")
        if self.range == "whole" and self.plateau is None:
            raise ValueError(
                "plateau: missing; over the whole range give the drag coefficient at high Reynolds numbers"
            )
        return self


class DiscoidalDrag(Part):
    """The race of the discoidal rig (Spannan 2021, 6.9), repaired; ``plateau`` is 0.60 as stated, or 0.74 as in the fit."""

    law: Literal["discoidal"] = "discoidal"
    plateau: Positive = key("drag coefficient from Re = 20 000 on: 0.60 as stated, 0.74 as in the printed fit", 0.60)
    range: Range = key(RANGE, "whole")


class FreeSphereDrag(Part):
    """A ball far from walls: 24/Re, then Cheng (2009) up to Re = 2e5."""

    law: Literal["free_sphere"] = "free_sphere"
    range: Range = key(RANGE, "whole")


class TableDrag(Part):
    """Measured drag coefficients over increasing Reynolds numbers; linear below the first, c_d kept beyond the last."""

    law: Literal["table"] = "table"
    reynolds: Annotated[tuple[Positive, ...], Listed] = key(
        "must increase; drag is linear below the first, its coefficient is constant above the last"
    )
    coefficient: Annotated[tuple[Positive, ...], Listed] = key(
        "as many as Reynolds numbers; coefficient times Reynolds number must not fall"
    )


Drag = Annotated[
    DragTorque | PlaneDrag | AnnulusDrag | CoefficientDrag | DiscoidalDrag | FreeSphereDrag | TableDrag,
    Field(discriminator="law"),
]
