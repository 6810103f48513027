"""Pages that need no run: drawing of the numbers of a machine, capability, balance quality, border speeds, stress."""

from __future__ import annotations

import math
from typing import Any

import autobalancer.plots.stability.stability_map as pictures
from autobalancer.errors import AutobalancerError
from autobalancer.laws.balance_quality import grade_name, permissible_unbalance
from autobalancer.machine import Machine
from autobalancer.patience import silent
from autobalancer.reporting.page import NO, YES, Decisive, Paragraph, Rows, Section, drawing, facts, yes_or_no
from autobalancer.results.number_text import length_text, moment_text, significant
from autobalancer.shown import rpm_and_si
from autobalancer.sketch.machine import machine as sketch
from autobalancer.stability.maps.stability_map import map as stability_map
from autobalancer.stability.summary.summary import Summary
from autobalancer.studies.design.answer import USUAL

MAP = (41, 31)  # speeds and viscosities
HARDLY = "hardly"  # enough, with less than the usual margin
SETTLED = "balls settled, at the end of the run-up"
TYPICAL = "race off the axis as is typical (not given)"
UNKNOWN = "measure it"  # what nobody has said of the machine
DECIDES = ("release speed", "exact border")
UNITS = {"viscosity": (1e6, "mm^2/s"), "drag": (1.0, "N*m*s")}


def facts_page(found: Summary) -> Section:
    """What is known before a run."""
    page = Section("Machine", [facts(found.rows(rpm_and_si))], "autobalancer check machine.toml")
    page.blocks += [Paragraph(f"Note: {text}") for text in found.warnings]
    if count := len(found.warnings):
        page.decisive.append(Decisive("notes on the machine", f"{count} note{'s' * (count > 1)} to read"))
    return page


def drawing_page(machine: Machine) -> Section:
    """Rotor, supports, planes, races and balls."""
    page = Section("Drawing", replay="autobalancer plot machine.toml --out pictures")
    caption = "Rotor with its supports, planes and races along the axis, and each balancer from above; lengths in mm."
    page.blocks.append(drawing(sketch(machine, title=""), caption))
    return page


def capability_page(found: Summary) -> Section:
    """What the balls of each race, and of each plane, can balance, and what they have to."""
    page = Section("Capability", replay="autobalancer check machine.toml")
    rows = []
    for race in found.races:
        rows.append(
            (
                f"balancer {race.balancer}, race {race.race}",
                f"{race.balls}",
                f"{1e3 * race.ball_mass:.4g} g",
                moment_text(race.capability),
                f"{100.0 * race.occupied_angle / (2.0 * math.pi):.3g} %",
            )
        )
    if not rows:
        page.blocks.append(Paragraph("Not stated: the machine has no balls."))
        return page
    heads = ("race", "balls", "mass of the balls", "capability", "of the race that balls take")
    page.blocks.append(Rows(heads, tuple(rows), (False, True, True, True, True)))
    planes = [(one.name, one.capability, one.required) for one in found.stations if one.required > 0.0]
    if not planes and found.unbalance > 0.0:
        planes = [("all races", found.capability, found.unbalance)]
    for name, capability, required in planes:
        ratio = capability / required
        word = NO if ratio < 1.0 else HARDLY if ratio < USUAL else YES
        said = f"{moment_text(capability)} for {moment_text(required)}, {ratio:.3g} times as much"
        page.decisive.append(
            Decisive(f"capability of the balls, {name}", said, word, "unbalance and fluid of the machine file")
        )
        enough = {
            NO: "NOT enough",
            YES: "enough",
            HARDLY: f"enough, but hardly ({ratio:.3g}): with less than {USUAL:g} to 2 times balls stand nearly side by side and "
            "react slowly",
        }[word]
        page.blocks.append(
            Paragraph(
                f"{name}: {moment_text(capability)} for an unbalance of {moment_text(required)}, {ratio:.3g} times as much: "
                f"{enough}.",
                strong=True,
            )
        )
    return page


def quality_page(found: Summary, settled: float, grade: float | None, command: str) -> Section:
    """Balance quality before, and with the balls settled, against the grade that is asked for.

    Parameters
    ----------
    found
        Of the machine.
    settled
        Residual unbalance at the end of the run-up, kg m; nan if it has none.
    grade
        G in mm/s, or ``None``.
    command
        Makes the run-up again.
    """
    page = Section("Balance quality (ISO 21940-11)", replay=f"autobalancer check machine.toml\n{command}")
    service = found.service
    if service is None:
        page.blocks.append(Paragraph("Not stated: the drive names no service speed, or the machine has no unbalance."))
        return page
    mass = 1e3 * service.unbalance * service.speed / service.grade
    size = moment_text(found.unbalance)
    rows = [
        ("without balancing", service.unbalance, ""),
        (SETTLED, settled, f"one run-up with {size}, from the start of the machine file"),
        *worst_residuals(found, size),
    ]
    allowed = math.inf if grade is None else permissible_unbalance(grade, mass, service.speed)
    known = [row for row in rows if math.isfinite(row[1])]
    heads: tuple[str, ...] = ("state", "unbalance", "velocity of the mass center (mm/s)", "grade reached")
    cells = [_quality_row(name, value, 1e3 * value * service.speed / mass) for name, value, _ in known]
    if grade is not None:
        heads = (*heads, f"G {grade:g}")
        cells = [
            (*row, "reached" if value <= allowed else "NOT reached")
            for row, (_, value, _) in zip(cells, known, strict=True)
        ]
        page.blocks.append(
            Paragraph(f"G {grade:g} at {rpm_and_si(service.speed)} permits {moment_text(allowed)}.", strong=True)
        )
    page.blocks.append(Rows(heads, tuple(cells), (False, True, True, False, False)[: len(heads)]))
    for row, (_, value, condition) in list(zip(cells, known, strict=True))[1:]:
        asked = "-" if grade is None else UNKNOWN if row[0] == TYPICAL else yes_or_no(value <= allowed)
        page.decisive.append(Decisive(f"residual unbalance, {row[0]}", f"{row[1]}, {row[3]}", asked, condition))
    return page


def _quality_row(name: str, unbalance: float, grade: float) -> tuple[str, ...]:
    return name, moment_text(unbalance), significant(grade), grade_name(grade)


def worst_residuals(found: Summary, size: str) -> list[tuple[str, float, str]]:
    """What eccentric races and friction may leave, and of what; ``size`` is the unbalance in words."""
    rows = []
    if found.off_center is not None and len(found.off_center.planes) == 1:
        (plane,) = found.off_center.planes
        kind = "race off the axis as given" if plane.given else TYPICAL
        rows.append(
            (kind, plane.residual, f"{length_text(plane.eccentricity)} off the axis, the balls in their best places")
        )
    held = found.friction
    if (below := found.friction_settled) is not None and all(plane.carried_on is False for plane in below.planes):
        held = below  # the drive rises slowly enough for balls to keep the places that they take there
    if held is not None and len(held.planes) == 1:
        (stuck,) = held.planes
        at = f"{size}, released at rest at the constant speed of {rpm_and_si(held.speed)}, no run-up"
        rows.append(
            ("95 % of the balls that friction stops end below", stuck.residual_95, f"{at}; {held.starts} starts")
        )
        worst = max(stuck.worst_residual, stuck.greatest_residual)
        rows.append(("worst that friction and eccentricity hold", worst, at))
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
            "-"
            if top is None or not math.isfinite(one.speed)
            else f"{significant(100.0 * (top - one.speed) / one.speed)} %"
        )
        rows.append((one.name, rpm_and_si(one.speed), margin, one.note))
        if one.name in DECIDES and top is not None and not math.isnan(one.speed):
            said = (
                "never" if math.isinf(one.speed) else f"{rpm_and_si(one.speed)}; the highest speed is {margin} above it"
            )
            page.decisive.append(
                Decisive(
                    one.name,
                    said,
                    yes_or_no(one.speed < top),
                    f"{moment_text(found.unbalance)}, fluid of the machine file",
                )
            )
    if rows:
        page.blocks.append(
            Rows(("border", "speed", "highest speed above it by", "note"), tuple(rows), (False, False, True, False))
        )
    for speed, ratio in zip(found.critical_speeds, found.damping_ratios, strict=False):
        text = f"Critical speed {rpm_and_si(speed)}: damping ratio {100.0 * ratio:.3g} %"
        if ratio > 0.0:
            text += f", amplification factor {0.5 / ratio:.3g}"
        if top is not None:
            text += f"; separation margin of the highest speed {significant(100.0 * abs(top - speed) / speed)} %"
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
