"""The averaged border of any machine: of planar rotors in closed form where there is one, of others over the speed."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from autobalancer.assembly.terms import Theory
from autobalancer.errors import QuestionError
from autobalancer.files.given import balls_in_races
from autobalancer.machine import Machine, PlanarRotor
from autobalancer.stability.averaged.border import averaged_border as planar_border
from autobalancer.stability.averaged.formulas import explicit_averaged_border
from autobalancer.stability.averaged.stations import (
    averaged_station_growth,
    averaged_station_growths,
    refuse_without_drag,
)
from autobalancer.stability.border import Border, ignoring
from autobalancer.stability.host.planar import Floats, Plane
from autobalancer.stability.host.stations import Stations
from autobalancer.stability.maps.balanced import Balanced
from autobalancer.stability.maps.balanced_stations import members_of
from autobalancer.stability.maps.exact import border_of
from autobalancer.stability.states.described import Described, described, highest_searched
from autobalancer.stability.states.state import StationState
from autobalancer.units import unbalance_argument

AVERAGED = "averaged border"
WORST_CASE = "averaged border, worst case"
SPREADS = (0.0, 0.5, 1.0)  # between the least and the greatest |g2| at which the worst case is looked for


def averaged_border(
    machine: Plane | Machine | str | Path,
    unbalance: complex | float | str | None = None,
    *,
    worst_case: bool = False,
    searched: tuple[float, float] | None = None,
) -> Border:
    """Averaged border from the averaged eigenvalue problem; on planar rotors Spannan (2021), (4.69), by root finding.

    Parameters
    ----------
    machine
        A machine or the path of its file; any rotor.
    unbalance
        kg m, or a text such as ``"594 g*mm"``; by default that of the machine. On rotors that tilt or bend it replaces the
        machine's unbalance if there is only one.
    worst_case
        Take the ball positions with the highest border instead of those that balance the unbalance. Needs races on the
        axis of the rotor, in one plane.
    searched
        Speeds, rad/s: the border is the lowest speed in this range from which on the state is stable up to its end. By
        default from the critical speed (planar: the higher one, else the lowest) to 40 times it, or to the end of the
        tables of the supports.

    Returns
    -------
    Border
        Infinite if the state is unstable at the end of the range, nan if there is no balanced state.

    Raises
    ------
    QuestionError
        If a ball has no drag or forces act on it, or the worst case is asked of an eccentric race or several planes.
    """
    if not isinstance(machine, Plane):
        machine = balls_in_races(machine)
        if not isinstance(machine.rotor, PlanarRotor):
            highest = None if searched is None else searched[1]
            st = described(machine, unbalance_argument(unbalance), highest)
            assert isinstance(st, Stations)
            if st.forces is not None:
                raise QuestionError(
                    "averaged border: the averaged theory does not know forces on the balls; ask borders for the exact border"
                )
            return ignoring(machine, _of_stations(st, worst_case, searched), Theory.AVERAGED)
        found = planar_border(machine, unbalance, worst_case=worst_case, searched=searched)
        return ignoring(machine, found, Theory.AVERAGED)
    return planar_border(machine, unbalance, worst_case=worst_case, searched=searched)


def averaged_of(p: Described) -> Border:
    """*averaged border* as :func:`autobalancer.stability.borders` has it.

    With races on the axis in one plane that of the worst case over the unbalance: of planar rotors by the closed form, (4.74)
    generalized to any balls and to orthotropic supports, of others by root finding. Else that at this unbalance.
    """
    if isinstance(p, Stations) and p.forces is not None:
        return Border(AVERAGED, math.nan, "computed without forces on the balls only; see the exact border", False)
    if p.moment.size == 1:
        return Border(AVERAGED, math.nan, "one ball alone can balance one unbalance only")
    if not (p.drag > 0.0).all():
        return Border(AVERAGED, math.inf, "a ball has no drag")
    if isinstance(p, Stations):
        if not p.model.damping.any():
            return Border(AVERAGED, math.inf, "the rotor has no damping")
        return replace(_of_stations(p, worst_case=_one_centric(p)), name=AVERAGED)
    if max(p.damping) == 0.0:
        return Border(AVERAGED, math.inf, "the rotor has no damping")
    if np.all(p.offset == 0.0):
        return replace(explicit_averaged_border(p), name=AVERAGED)
    found = planar_border(p)
    return replace(
        found, note=found.note or "at this unbalance, from the averaged eigenvalue problem (Spannan 2021, 4.69)"
    )


def _of_stations(st: Stations, worst_case: bool, searched: tuple[float, float] | None = None) -> Border:
    refuse_without_drag(st.drag)
    if worst_case and not _one_centric(st):
        raise QuestionError(
            "averaged border: the worst case over the unbalance needs races on the axis of the rotor, in one plane; leave out "
            "worst_case for the border at the unbalance of the machine"
        )
    st = replace(st, slopes=None)
    low, high = searched or (st.scale_speed, highest_searched(st))
    members = _any_unbalance(st) if worst_case else members_of(st, averaged_station_growth)
    found = [border_of(member, st, high, low) for member in members]
    found = [one for one in found if not math.isnan(one[0])] or found[:1]
    speed, note = max(found, key=lambda one: one[0])
    where = "worst case over the unbalance" if worst_case else "at this unbalance"
    if not worst_case and len(found) > 1:
        where += f", worst of {len(found)} positions of the balls"
    text = "; ".join(filter(None, (f"{where}, from the averaged eigenvalue problem", note)))
    return Border(WORST_CASE if worst_case else AVERAGED, speed, text)


def _one_centric(st: Stations) -> bool:
    return len(st.names) == 1 and not np.any(st.offset)


def _any_unbalance(st: Stations) -> list[Balanced]:
    """Two equal balls with the same g = sum s^2/beta, and |g2| from the least that the balls can make up to g."""
    weight: Floats = st.moment**2 / st.drag
    g = float(weight.sum())
    least = max(0.0, 2.0 * float(weight.max()) / g - 1.0)
    two = {name: getattr(st, name)[[0, 0]] for name in ("ball_mass", "inertia", "station", "race", "offset")}
    alike = replace(st, moment=np.full(2, math.sqrt(0.5 * g)), drag=np.ones(2), **two)
    return [_AnyUnbalance(alike, least + (1.0 - least) * share) for share in SPREADS]


@dataclass(frozen=True)
class _AnyUnbalance:
    """Two equal balls in a race on the axis with this |g2|/g."""

    stations: Stations
    share: float
    route: str = "eigenvalues"

    def rates(self, speeds: Floats) -> Floats:
        """Averaged growth rates, 1/s."""
        angle = 0.5 * math.acos(min(self.share, 1.0))
        state = StationState("balanced", np.array([angle, -angle]), np.zeros(1, np.complex128), 0, 0)
        return averaged_station_growths(self.stations, speeds, state)
