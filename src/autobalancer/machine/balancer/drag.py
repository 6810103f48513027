"""How the fluid brakes a ball that moves in its race: linear laws, T = beta phi'.

In the Stokes range the product of drag coefficient and Reynolds number is a constant of the geometry, and
beta = (c_d Re) (pi/4) rho nu r_b eps^2 (Spannan 2021, 5.26).
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from autobalancer.machine.part import AngularDamping, Length, Part, Positive


class DragTorque(Part):
    """beta itself, N m s per ball."""

    law: Literal["beta"] = "beta"
    beta: AngularDamping


class PlaneDrag(Part):
    """A ball that rolls on a plane wall: c_d Re = 322 (Jan and Chen 1997; Spannan 2021, 5.21)."""

    law: Literal["sphere_on_plane"] = "sphere_on_plane"


class AnnulusDrag(Part):
    """A ball in the annulus of a balancer; ``clear_width`` is W_1 of Spannan 2021, (5.22)."""

    law: Literal["race_geometry"] = "race_geometry"
    clear_width: Length


class CoefficientDrag(Part):
    """A known product of drag coefficient and Reynolds number, 24 for a free sphere."""

    law: Literal["cd_re"] = "cd_re"
    cd_re: Positive


Drag = Annotated[DragTorque | PlaneDrag | AnnulusDrag | CoefficientDrag, Field(discriminator="law")]
