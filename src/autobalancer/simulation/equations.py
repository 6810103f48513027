"""Which compiled equations of motion belong to an assembled machine."""

from __future__ import annotations

from typing import Any, NamedTuple

from autobalancer.assembly.system import Assembly, Model
from autobalancer.kernels.balls.planar import planar
from autobalancer.kernels.given import given
from autobalancer.kernels.integrators.switching import no_switch, switch_type
from autobalancer.kernels.system import rhs_type


class Equations(NamedTuple):
    """The first two arguments of :func:`autobalancer.kernels.integrators.runge_kutta.advance`."""

    rates: Any  # the right-hand side
    switch: Any = no_switch

    def ready(self) -> tuple[Any, Any]:
        """The same, where they are called often."""
        return given(self.rates, rhs_type), given(self.switch, switch_type)


PLANAR = Equations(planar)


def equations(assembly: Assembly) -> Equations:
    """The equations of a machine; only those that it needs are loaded. Impacts are noted where there is room for them."""
    chosen = _equations(assembly)
    if assembly.system.ties.size:
        from autobalancer.kernels.balls.rigid.events import rigid_contact

        return chosen._replace(switch=rigid_contact)
    if not assembly.system.touches.size:
        return chosen
    from autobalancer.kernels.balls import impacts

    if assembly.model is Model.RESOLVED:
        return chosen._replace(switch=impacts.impacts_of_resolved)
    noting = impacts.impacts_of_guided if chosen.switch is no_switch else impacts.impacts_and_adherence
    return chosen._replace(switch=noting)


def _equations(assembly: Assembly) -> Equations:
    if assembly.model is Model.PLANAR:
        return PLANAR
    if assembly.model is Model.RESOLVED:
        from autobalancer.kernels.balls.resolved import resolved

        return Equations(resolved)
    if assembly.rough:
        from autobalancer.kernels.balls.rough_races import guided_rough, guided_rough_tilting

        chosen = guided_rough_tilting if assembly.model is Model.ROUGH_TILTING else guided_rough
    else:
        from autobalancer.kernels.balls.smooth_races import guided, guided_tilting

        chosen = guided_tilting if assembly.model is Model.TILTING else guided
    balls = assembly.system.balls
    if not (balls.rolling.any() or balls.adherence.any()):
        return Equations(chosen)
    from autobalancer.kernels.balls.switches import adherence

    return Equations(chosen, adherence)
