"""What the rotor does without balancing, as rows of a table."""

from __future__ import annotations

import math

from autobalancer.cli.terminal.words import speed_text
from autobalancer.laws.balance_quality import grade_name
from autobalancer.results.number_text import force_text, length_text, moment_text, velocity_text
from autobalancer.stability.summary.service import Service


def service_rows(service: Service) -> list[tuple[str, str]]:
    """Names and texts: grade, vibration and forces before balls balance anything."""
    grade = f"ISO 21940-11 {grade_name(service.grade)} ({velocity_text(service.grade)})"
    of = f", of {moment_text(service.unbalance)}, the needs of the planes added up" if service.added_up else ""
    rows = [("without balancing", f"{grade} at {speed_text(service.speed)}{of}")]
    for names, text, values in (("vibration", length_text, service.vibration), ("force", force_text, service.force)):
        known = [(name, value) for name, value in values if math.isfinite(value)]
        if known:
            shown = ", ".join(f"{name}: {text(value)}" if len(values) > 1 else text(value) for name, value in known)
            rows.append(("", f"{names} {shown}"))
    return rows
