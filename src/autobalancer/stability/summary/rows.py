"""What is known of a machine, as rows of a table: a name and a text each, with speeds as ``said`` writes them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

from autobalancer.laws.balance_quality import grade_name
from autobalancer.results.number_text import force_text, length_text, moment_text, velocity_text
from autobalancer.stability.friction.held_values import HeldByFriction
from autobalancer.stability.summary.service import Service

if TYPE_CHECKING:
    from autobalancer.stability.summary.summary import RaceSummary, Summary

LISTED = 4  # critical speeds that are shown
Row = tuple[str, str]
SpeedText = Callable[[float], str]


def summary_rows(found: Summary, said: SpeedText) -> list[Row]:
    """Everything that ``check`` shows of a machine with races."""
    return [
        ("axis", found.axis),
        ("mass", f"{found.total_mass:.6g} kg with balls, {found.rotor_mass:.6g} kg without"),
        *_critical_speeds(found, said),
        *([("rubber", "\n".join(found.rubber))] if found.rubber else []),
        *_unbalance(found, said),
        *(_race(race, found) for race in found.races),
        *([("rings of liquid", "\n".join(found.liquid_rings))] if found.liquid_rings else []),
        *_together(found),
        *_planes(found, said),
        *(friction_rows(found.friction, said) if found.friction is not None else ()),
        *(_settled(found.friction_settled, said) if found.friction_settled is not None else ()),
        *_eccentricity(found),
        *_borders(found, said),
        *([("highest speed", said(found.highest_speed))] if found.highest_speed is not None else ()),
    ]


def friction_rows(held: HeldByFriction, said: SpeedText, *, brief: bool = False) -> list[Row]:
    """What friction holds: rows for each plane with balls, only the first of them if ``brief``, or that there is none."""
    rows = _rows_of("friction", held, [plane.rows[: 1 if brief else None] for plane in held.planes], said)
    return [*rows, ("friction", held.note)] if held.note else rows


def _eccentricity(found: Summary) -> list[Row]:
    if found.off_center is None or not found.off_center.sentence:
        return []
    held = found.friction is not None and any(plane.eccentric_residual > 0.0 for plane in found.friction.planes)
    return [("race eccentricity", found.off_center.sentence + "; with friction more is left, see above" * held)]


def service_rows(service: Service, said: SpeedText) -> list[Row]:
    """What the rotor does without balancing: grade, vibration and forces."""
    grade = f"ISO 21940-11 {grade_name(service.grade)} ({velocity_text(1e-3 * service.grade)})"
    of = f", of {moment_text(service.unbalance)}, the needs of the planes added up" if service.added_up else ""
    ignored = f"; {service.ignores}" if service.ignores else ""
    rows = [("without balancing", f"{grade} at {said(service.speed)}{of}{ignored}")]
    for names, text, values in (("vibration", length_text, service.vibration), ("force", force_text, service.force)):
        known = [(name, value) for name, value in values if math.isfinite(value)]
        if known:
            shown = ", ".join(f"{name}: {text(value)}" if len(values) > 1 else text(value) for name, value in known)
            rows.append(("", f"{names} {shown}"))
    return rows


def _critical_speeds(found: Summary, said: SpeedText) -> Iterator[Row]:
    names: tuple[str, ...] = ("along x and y, ",) if len(found.critical_speeds) == 1 else ("along x, ", "along y, ")
    if found.rotor != "planar":
        names = tuple("" for _ in found.critical_speeds)
    rows = list(zip(names, found.critical_speeds, found.damping_ratios, strict=True))
    for name, speed, ratio in rows[:LISTED]:
        yield "critical speed", f"{said(speed)}, {name}damping ratio {100 * ratio:.3g} %"
    if len(rows) > LISTED:
        yield "", f"and {len(rows) - LISTED} more from {said(rows[LISTED][1])} on; see autobalancer modes"


def _most(found: Summary) -> str:
    return " (greatest over time)" if found.unbalance_varies else ""


def _unbalance(found: Summary, said: SpeedText) -> Iterator[Row]:
    what = ", vector sum of the point unbalances" * found.several_unbalances
    yield "unbalance", f"{moment_text(found.unbalance, 5)}{what}{_most(found)}"
    if found.service is not None:
        yield from service_rows(found.service, said)


def _race(race: RaceSummary, found: Summary) -> Row:
    enough = _enough(race.capability, found) if len(found.races) == 1 else ""
    enough += f"; {race.ignores}" if race.ignores else ""
    return (
        f"balancer {race.balancer}, race {race.race}",
        f"{race.balls} {race.bodies}{'s' * (race.balls > 1)}, "
        f"{race.ball_mass * 1e3:.5g} g ({race.effective_mass * 1e3:.5g} g effective), "
        f"taking {math.degrees(race.occupied_angle):.4g} deg\n"
        f"capability {moment_text(race.capability, 5)}{enough}\n"
        f"drag beta {', '.join(f'{beta:.4g}' for beta in race.drag)} N m s",
    )


def _together(found: Summary) -> Iterator[Row]:
    if len(found.races) > 1 and not found.stations:
        yield "all races", f"capability {moment_text(found.capability, 5)}{_enough(found.capability, found)}"


def _enough(capability: float, found: Summary) -> str:
    return f", {capability / found.unbalance:.3g} times the unbalance" if found.unbalance and not found.stations else ""


def _planes(found: Summary, said: SpeedText) -> Iterator[Row]:
    for plane in found.stations:
        enough = f", {plane.capability / plane.required:.3g} times as much" if plane.required > 0.0 else ""
        yield (
            f"plane {plane.name}",
            f"needs {moment_text(plane.required, 5)}{_most(found)} for rest at {said(plane.speed)}, "
            f"capability {moment_text(plane.capability, 5)}{enough}",
        )


def _settled(held: HeldByFriction, said: SpeedText) -> list[Row]:
    """The same of balls that settle at a lower speed."""
    rows = _rows_of("  settled", held, [plane.settled_rows for plane in held.planes], said)
    return rows or [("  settled", held.note)]


def _rows_of(title: str, held: HeldByFriction, planes: list[tuple[Row, ...]], said: SpeedText) -> list[Row]:
    rows: list[Row] = []
    for plane, (first, *others) in zip(held.planes, planes, strict=True):
        name = f"{title}, {plane.name}" if len(planes) > 1 else title
        indent = " " * (len(title) - len(title.lstrip()) + 2)
        rows += [(name, f"at {said(held.speed)} {first[1]}"), *((indent + label, text) for label, text in others)]
    return rows


def _borders(found: Summary, said: SpeedText) -> Iterator[Row]:
    if not found.borders:
        yield "border speeds", f"none ({found.no_borders_because.removeprefix('border speeds: ')})"
        return
    if not math.isnan(found.sommerfeld_number):
        yield "Sommerfeld number S", f"{found.sommerfeld_number:.4g}   (m eps w_c)^2 / (b beta)"
    for border in found.borders:
        shown = said(border.speed) + (f"   ({border.note})" if border.note else "")
        yield border.name, shown if border.known else f"not known: {border.note}"
