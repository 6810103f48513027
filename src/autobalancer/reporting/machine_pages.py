"""Pages that need no run: drawing of the numbers of a machine, capability, balance quality, border speeds, stress."""

from __future__ import annotations

import math
from typing import Any

import autobalancer.plots.stability.stability_map as pictures
from autobalancer.catalog.resolve import resolve
from autobalancer.errors import AutobalancerError
from autobalancer.laws.balance_quality import grade_name, permissible_unbalance
from autobalancer.laws.hertz import greatest_pressure, reduced_modulus
from autobalancer.machine import Machine
from autobalancer.patience import silent
from autobalancer.reporting.page import Paragraph, Rows, Section, drawing, facts
from autobalancer.results.number_text import force_text, moment_text, significant
from autobalancer.shown import rpm_and_si
from autobalancer.stability.maps.stability_map import map as stability_map
from autobalancer.stability.summary.summary import Summary

STEEL = reduced_modulus(2.06e11, 0.3)  # E* of steel on steel, Pa
STATIC = 4.2e9  # Pa, ISO 76: pressure of a point contact at the static load rating of ball bearings
MAP = (41, 31)  # speeds and viscosities
UNITS = {"viscosity": (1e6, "mm^2/s"), "drag": (1.0, "N*m*s")}


def facts_page(found: Summary) -> Section:
    """What is known before a run."""
    page = Section("Machine", [facts(found.rows(rpm_and_si))], "autobalancer check machine.toml")
    page.blocks += [Paragraph(f"Note: {text}") for text in found.warnings]
    return page


def quality_page(found: Summary, settled: float, grade: float | None) -> Section:
    """Balance quality before, and with the balls settled, against the grade that is asked for.

    Parameters
    ----------
    found
        Of the machine.
    settled
        Residual unbalance at the end of the run-up, kg m; nan if it has none.
    grade
        G in m/s, or ``None``.
    """
    page = Section("Balance quality (ISO 21940-11)")
    service = found.service
    if service is None:
        page.blocks.append(Paragraph("Not stated: the drive names no service speed, or the machine has no unbalance."))
        return page
    mass = service.unbalance * service.speed / service.grade
    rows = [
        ("without balancing", service.unbalance),
        ("balls settled, at the end of the run-up", settled),
        *_worst(found),
    ]
    allowed = math.inf if grade is None else permissible_unbalance(grade, mass, service.speed)
    known = [(name, value) for name, value in rows if math.isfinite(value)]
    heads: tuple[str, ...] = ("state", "unbalance", "velocity of the mass center (mm/s)", "grade reached")
    cells = [_quality_row(name, value, value * service.speed / mass) for name, value in known]
    if grade is not None:
        heads = (*heads, f"G {1e3 * grade:g}")
        cells = [
            (*row, "reached" if value <= allowed else "NOT reached")
            for row, (_, value) in zip(cells, known, strict=True)
        ]
        page.blocks.append(
            Paragraph(f"G {1e3 * grade:g} at {rpm_and_si(service.speed)} permits {moment_text(allowed)}.", strong=True)
        )
    page.blocks.append(Rows(heads, tuple(cells), (False, True, True, False, False)[: len(heads)]))
    return page


def _quality_row(name: str, unbalance: float, velocity: float) -> tuple[str, ...]:
    return name, moment_text(unbalance), significant(1e3 * velocity), grade_name(velocity)


def _worst(found: Summary) -> list[tuple[str, float]]:
    """What eccentric races and friction may leave."""
    rows = []
    if found.off_center is not None and len(found.off_center.planes) == 1:
        (plane,) = found.off_center.planes
        kind = "race off the axis as given" if plane.given else "race off the axis as is typical (not given)"
        rows.append((kind, plane.residual))
    held = found.friction_settled or found.friction
    if held is not None and len(held.planes) == 1:
        rows.append(("95 % of the balls that friction stops end below", held.planes[0].residual_95))
        rows.append(("worst that friction and eccentricity hold", held.planes[0].greatest_residual))
    return rows


def margin_page(found: Summary) -> Section:
    """Border speeds, amplification and margins from the service speed."""
    page = Section("Border speeds and margins", replay="autobalancer borders machine.toml")
    if found.no_borders_because:
        page.blocks.append(Paragraph(found.no_borders_because))
    top = found.highest_speed
    rows = []
    for one in found.borders:
        margin = (
            "-" if top is None or not math.isfinite(one.speed) else f"{100.0 * (top - one.speed) / one.speed:.3g} %"
        )
        rows.append((one.name, rpm_and_si(one.speed), margin, one.note))
    if rows:
        page.blocks.append(
            Rows(("border", "speed", "highest speed above it by", "note"), tuple(rows), (False, False, True, False))
        )
    for speed, ratio in zip(found.critical_speeds, found.damping_ratios, strict=False):
        text = f"Critical speed {rpm_and_si(speed)}: damping ratio {100.0 * ratio:.3g} %"
        if ratio > 0.0:
            text += f", amplification factor {0.5 / ratio:.3g}"
        if top is not None:
            text += f"; separation margin of the highest speed {100.0 * abs(top - speed) / speed:.3g} %"
        page.blocks.append(Paragraph(f"{text}."))
    return page


def map_page(machine: Machine, found: Summary) -> Section:
    """Where balancing is stable over speed and viscosity, or drag."""
    page = Section("Where balancing is stable")
    top = found.highest_speed or 0.0
    lowest = min(found.critical_speeds, default=0.0)
    if not top > lowest > 0.0:
        page.blocks.append(Paragraph("Not drawn: the machine does not run faster than its lowest critical speed."))
        return page
    low, high = 60.0 / (2.0 * math.pi) * 0.8 * lowest, 60.0 / (2.0 * math.pi) * 1.15 * top
    for name in ("viscosity", "drag"):
        try:
            value, (scale, unit) = _value(machine, name), UNITS[name]
            axes: dict[str, Any] = {
                "speed": f"{low:.4g}:{high:.4g} rpm:{MAP[0]}",
                name: f"{0.1 * scale * value:.4g}:{10.0 * scale * value:.4g} {unit}:{MAP[1]}:log",
            }
            picture = pictures.map(stability_map(machine, axes, borders=31, progress=silent), title="")
        except AutobalancerError as reason:
            why = str(reason)
            continue
        page.blocks.append(
            drawing(picture, f"Growth rate of the balanced state over speed and {name}; the point is this machine.")
        )
        page.replay = f'autobalancer map machine.toml --x "speed={axes["speed"]}" --y "{name}={axes[name]}"'
        return page
    page.blocks.append(Paragraph(f"Not drawn: {why}"))
    return page


def _value(machine: Machine, name: str) -> float:
    from autobalancer.assembly.quantities import value_of
    from autobalancer.errors import QuestionError

    value = value_of(machine, name)
    if not value > 0.0:
        raise QuestionError(f"the machine has no single value of {name}")
    return value


def stress_page(machine: Machine, found: Summary) -> Section:
    """Force and pressure between ball and race at the highest speed."""
    page = Section("Balls in their race")
    top = found.highest_speed
    if top is None:
        page.blocks.append(Paragraph("Not stated: the drive names no highest speed."))
        return page
    rows = []
    for ball in {(one.balancer, one.race): one for one in resolve(machine)}.values():
        force = float(ball.effective_mass) * float(ball.orbit_radius) * top**2
        if not ball.diameter > 0.0:
            rows.append(
                (f"balancer {ball.balancer + 1}, race {ball.race + 1}", force_text(force), "not known: no diameter")
            )
            continue
        radius = 0.5 * float(ball.diameter)
        pressure = greatest_pressure(force, STEEL, radius, float(ball.orbit_radius) + radius)
        rows.append(
            (
                f"balancer {ball.balancer + 1}, race {ball.race + 1}",
                force_text(force),
                f"{1e-6 * pressure:.0f} MPa, {100.0 * pressure / STATIC:.3g} % of the static limit of ball bearings (4200 MPa)",
            )
        )
    page.blocks.append(Rows(("race", "greatest force of a ball on the wall", "greatest pressure (Hertz)"), tuple(rows)))
    page.blocks.append(
        Paragraph(
            "A steel ball on a cylindrical steel wall (Johnson 1985); a groove that fits the ball closely lowers the pressure. "
            "Impacts are not counted. Limit: ISO 76."
        )
    )
    return page
