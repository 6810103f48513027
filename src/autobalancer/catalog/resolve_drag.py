"""From the drag law of a race to the numbers of a ball in it."""

from __future__ import annotations

from autobalancer.laws import drag_coefficient as laws
from autobalancer.laws.drag import annulus_cd_re, linear_drag
from autobalancer.laws.drag_curve import DragCurve
from autobalancer.machine import (
    AnnulusDrag,
    CoefficientDrag,
    DiscoidalDrag,
    DragTorque,
    FreeSphereDrag,
    PlaneDrag,
    TableDrag,
)
from autobalancer.machine.balancer import Drag

SPHERE_ON_PLANE, FREE_SPHERE, DISCOIDAL = 322.0, 24.0, 387.0  # c_d Re in the Stokes range


def ball_drag(
    part: Drag, radius: float, orbit: float, density: float, viscosity: float
) -> tuple[float, DragCurve | None]:
    """beta (N m s) of the linear law, and the curve over all Reynolds numbers where the law is asked for as a whole.

    ``radius`` of the ball and ``orbit`` radius in m; ``density`` and kinematic ``viscosity`` of the fluid in SI.

    Raises
    ------
    QuestionError
        If the numbers of the law make no curve.
    """
    if isinstance(part, DragTorque):
        return float(part.beta), None
    if radius == 0.0:
        return 0.0, None
    law: laws.DragLaw | None = None
    whole = isinstance(part, TableDrag) or part.range == "whole"
    if isinstance(part, TableDrag):
        law = laws.table(part.reynolds, part.coefficient)
        cd_re = law.cd_re
    elif isinstance(part, CoefficientDrag):
        cd_re = float(part.cd_re)
        law = laws.joined(cd_re, float(part.plateau or 0.0)) if whole else None
    elif isinstance(part, AnnulusDrag):
        cd_re = annulus_cd_re(float(part.clear_width) / radius, radius / orbit)
        plateau = float(part.plateau) if part.plateau is not None else laws.PLANE_PLATEAU
        law = laws.race_geometry(cd_re, plateau) if whole else None
    elif isinstance(part, DiscoidalDrag):
        cd_re = DISCOIDAL
        law = laws.discoidal(float(part.plateau)) if whole else None
    elif isinstance(part, FreeSphereDrag):
        cd_re = FREE_SPHERE
        law = laws.free_sphere() if whole else None
    else:
        assert isinstance(part, PlaneDrag)
        cd_re = SPHERE_ON_PLANE
        law = laws.sphere_on_plane() if whole else None
    beta = linear_drag(cd_re, density, viscosity, radius, orbit)
    return beta, None if law is None else DragCurve(law, density, viscosity, 2.0 * radius)
