"""Designs whose balls stall or do not balance at an operating speed, by the exact borders; and the least oil that would do."""

from __future__ import annotations

import math

from autobalancer.errors import AutobalancerError
from autobalancer.results.number_text import moment_text
from autobalancer.shown import rpm_and_si
from autobalancer.stability.maps.minimum import minimum_viscosity
from autobalancer.stability.maps.speeds import borders
from autobalancer.studies.design.building import machine_of
from autobalancer.studies.design.screening import Design
from autobalancer.studies.design.spec import MARGIN, Spec

RELEASE, EXACT = "release speed", "exact border"
SAYS = {RELEASE: "its balls stall at the critical speed and are released at", EXACT: "balancing is stable from"}


def judge_borders(spec: Spec, found: Design) -> None:
    """Ask both borders at all temperatures and both ends of the unbalance; rule the design out where one is too high."""
    allowed = spec.slowest / (1.0 + spec.limits.get(MARGIN, 0.0))
    worst: dict[str, tuple[float, float, float]] = {}
    for temperature in spec.temperatures:
        for size in sorted({max(spec.unbalance[0], 0.02 * spec.unbalance[1]), spec.unbalance[1]}):
            try:
                machine = machine_of(spec, found.candidate, temperature, size)
                known = {one.name: one.speed for one in borders(machine, only=(RELEASE, EXACT))}
            except AutobalancerError:
                continue
            for name in (RELEASE, EXACT):
                speed = known.get(name, math.nan)
                if not math.isnan(speed) and speed > worst.get(name, (-1.0, 0.0, 0.0))[0]:
                    worst[name] = speed, temperature, size
    found.release = worst.get(RELEASE, (math.nan,))[0]
    found.border = worst.get(EXACT, (math.nan,))[0]
    for name in (RELEASE, EXACT):
        speed, temperature, size = worst.get(name, (0.0, 0.0, 0.0))
        if speed > allowed:
            said = f"{SAYS[name]} {rpm_and_si(speed)} only" if math.isfinite(speed) else _never(name)
            at = f" at {temperature - 273.15:.4g} °C" if spec.temperature[0] != spec.temperature[1] else ""
            at += f" and {moment_text(size)}" if spec.unbalance[0] != spec.unbalance[1] else ""
            reason = f"{said}{at}; needed is {rpm_and_si(allowed)} or less"
            found.rule_out(
                "border", reason + _least(spec, found, name, allowed, (temperature, size)), speed / allowed - 1.0
            )
            return


def _never(name: str) -> str:
    return (
        "its balls stall at the critical speed and are never released"
        if name == RELEASE
        else "balancing is never stable"
    )


def _least(spec: Spec, found: Design, name: str, allowed: float, at: tuple[float, float]) -> str:
    """How thick the oil would have to be at its density, as the end of a reason; empty where it is not known."""
    one, (temperature, size) = found.candidate, at
    if len(set(one.fillings)) != 1:
        return ""
    has = one.fillings[0].at(temperature)[1]
    try:
        machine = machine_of(spec, one, temperature, size)
        least = minimum_viscosity(machine, allowed, name)
    except AutobalancerError:
        return ""
    if not has < least < math.inf:  # thinner oils may do in a window, which is no design
        return ""
    return f"; that takes {1e6 * least:.3g} mm²/s there, this oil has {1e6 * has:.3g}"
