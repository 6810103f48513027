"""A verdict as lines that people read."""

from __future__ import annotations

import html
import math
from collections.abc import Callable
from typing import TYPE_CHECKING

from autobalancer.kernels.measures.limits import LIMITS
from autobalancer.laws.balance_quality import grade_name
from autobalancer.results.number_text import (
    couple_text,
    force_text,
    length_text,
    moment_text,
    share_text,
    significant,
    velocity_text,
    worded,
)
from autobalancer.results.verdict.rule import BALANCED, NOT_SETTLED, WORDS

if TYPE_CHECKING:
    from autobalancer.results.verdict.judged import Verdict
    from autobalancer.results.verdict.passage import Forecast, Peak, RunPart, Settling

Lines = list[tuple[str, str]]
NOT_COMPARED = "not computed; verdict(run, held) compares it, with held = simulate(machine, hold_balls=True)"
LISTED = 8  # balls that are named
GREATER = LIMITS[-1]  # times the greatest deflection without balls, from which on the headline says so
LEAST_SHARE = 1e-3  # of an unbalance, below which an extrapolated residual is not said in figures


def rpm_text(speed: float) -> str:
    """A speed in rad/s as text in rpm: ``"668 rpm"``."""
    return f"{significant(speed * 30.0 / math.pi)} rpm"


def verdict_lines(found: Verdict, speed_text: Callable[[float], str] = rpm_text) -> tuple[str, Lines, list[str]]:
    """A headline, rows of a label and a text, and notes; ``speed_text`` writes a speed (rad/s)."""
    rows: Lines = []
    if not math.isnan(found.residual):
        of = f" of {moment_text(found.unbalance)}, {share_text(found.residual_share)}" if found.unbalance > 0.0 else ""
        added = "planes added up, " * (len(found.planes) > 1)
        rows.append(("residual unbalance", f"{moment_text(found.residual)}{of} ({added}mean at the end)"))
    if len(found.planes) > 1:
        for plane in found.planes:
            share = f", {share_text(plane.residual / plane.unbalance)}" if plane.unbalance > 0.0 else ""
            rows.append((f"  {plane.name}", f"{moment_text(plane.residual)} of {moment_text(plane.unbalance)}{share}"))
    if not math.isnan(found.couple_residual):
        static = f"{moment_text(found.static_residual)} of {moment_text(found.static_unbalance)}"
        couple = f"{couple_text(found.couple_residual)} of {couple_text(found.couple_unbalance)}"
        rows.append(("  vector sum", f"static {static}, couple about their middle {couple}"))
    for number, place in enumerate(found.places):
        text = f"at most {length_text(place.vibration)}, {velocity_text(place.velocity_rms)} rms"
        rows.append(
            ("vibration" if not number else "", f"{place.name}: {text}{_without(place.without_balls, length_text)}")
        )
    settled = [place for place in found.places if place.static > 1e-8 and place.static > 0.01 * place.vibration]
    for number, place in enumerate(settled):
        name = f"{place.name}: " if len(found.places) > 1 else ""
        beyond = (
            f", beyond the {length_text(place.sag)} by which the rotor sags without balls" if place.sag > 0.0 else ""
        )
        rows.append(("static deflection" if not number else "", f"{name}{length_text(place.static)}{beyond}"))
    for number, support in enumerate(found.supports):
        static = f"static {force_text(support.static)}, " if support.static > 0.01 * support.vibrating else ""
        name = f"{support.name}: " if len(found.supports) > 1 else ""
        text = f"{name}{static}vibrating {force_text(support.vibrating)}"
        rows.append(("support forces" if not number else "", text + _without(support.without_balls, force_text)))
    if not math.isnan(found.grade_after):
        after, before = (
            f"{grade_name(v)} ({velocity_text(1e-3 * v)})" if v > 0.0 else "no unbalance"
            for v in (found.grade_after, found.grade_before)
        )
        rows.append(("ISO 21940-11", f"{after}; without balls {before}"))
    if found.peak is not None:
        where = f"{found.peak.place}: " if len(found.places) > 1 else ""
        rows.append(("greatest deflection", where + _peak(found.peak, speed_text)))
        if found.peak_without_balls is not None:
            rows.append(("  without balls", _peak(found.peak_without_balls, speed_text)))
        elif found.without_held:
            rows.append(("  without balls", NOT_COMPARED))
    if found.parts:
        rows += _parts(found.parts, speed_text)
    elif found.settling is not None:
        rows.append(("balls settle", _settling(found.settling, None if found.word == NOT_SETTLED else found.forecast)))
    rows = [(worded(label, found.bodies), worded(text, found.bodies)) for label, text in rows]
    return headline(found), rows, list(found.notes)


def headline(found: Verdict) -> str:
    """The verdict in a sentence, with the greatest deflection of the run where balls have made it much greater."""
    vibration = f"vibration {share_text(found.ratio)} of that without balls"
    if found.word in WORDS[:4]:
        beside = f"; {found.because}" if found.because else ""
        return worded(f"{found.word}{_transient(found)}: {vibration}{beside}", found.bodies)
    still = _still(found) if found.word == NOT_SETTLED else ""
    return worded(f"{found.word}: {still or found.because}{_transient(found)}", found.bodies)


def verdict_html(found: Verdict) -> str:
    """The verdict as a table for a notebook."""
    head, rows, notes = verdict_lines(found)
    cells = "".join(
        f"<tr><th style='text-align:left'>{html.escape(label.strip())}</th>"
        f"<td style='text-align:left'>{html.escape(text)}</td></tr>"
        for label, text in rows
    )
    told = "".join(f"<p>note: {html.escape(note)}</p>" for note in notes)
    return f"<p><b>{html.escape(head)}</b></p><table>{cells}</table>{told}"


def _without(value: float, text: Callable[[float], str]) -> str:
    return "" if math.isnan(value) else f"; without balls {text(value)}"


def _transient(found: Verdict) -> str:
    """The passage of the resonance, where balls have made it worse."""
    if found.peak is None or found.peak_without_balls is None or not found.peak_ratio > GREATER:
        return ""
    here, other = length_text(found.peak.deflection), length_text(found.peak_without_balls.deflection)
    much = worse_by(found.peak_ratio) + (" than" if found.peak_ratio < 2.0 else " as")
    joined = ", but" if found.word == BALANCED else ", and" if found.word in WORDS[:4] else ";"
    return f"{joined} the greatest deflection on the way is {much} without balls ({here}, without {other})"


def worse_by(ratio: float) -> str:
    """How much worse a passage is of so many times the greatest deflection without balls; empty up to one tenth."""
    if not ratio > GREATER:
        return ""
    return f"{share_text(ratio - 1.0)} worse" if ratio < 2.0 else f"{significant(ratio)} times as much"


def _still(found: Verdict) -> str:
    """What still changes at the end of a run, where it goes, and how long a run shows it."""
    ahead = found.forecast
    if ahead is None:
        return f"{found.because}; run longer (run.duration)"
    said = found.because
    if found.settling is not None and found.settling.moving:
        said = f"balls still move {significant(math.degrees(ahead.speed), 2)} deg/s"
    if math.isnan(ahead.duration):
        return f"{said}; run longer (run.duration)"
    return (
        f"{said}; residual {share_text(found.residual_share)} now, {_later(ahead)} when they have settled (extrapolated); run "
        f"for about {significant(ahead.duration, 2)} s to see it (run.duration)"
    )


def _later(ahead: Forecast) -> str:
    return "below 0.1 %" if ahead.share < LEAST_SHARE else f"about {share_text(ahead.share)}"


def _peak(peak: Peak, speed_text: Callable[[float], str]) -> str:
    return f"{length_text(peak.deflection)} at {speed_text(peak.speed)}"


def _parts(parts: tuple[RunPart, ...], speed_text: Callable[[float], str]) -> Lines:
    """Peak and settling before and after each jump of the unbalance."""
    rows: Lines = [("unbalance jumps", "at " + ", ".join(f"{part.begin:.5g} s" for part in parts[1:]))]
    for number, part in enumerate(parts):
        label = f"  from {part.begin:.5g} s" if number else f"  up to {part.end:.5g} s"
        texts = [f"greatest deflection {_peak(part.peak, speed_text)}"] if part.peak is not None else []
        texts += [f"balls settle {_settling(part.settling)}"] if part.settling is not None else []
        rows.append((label, "; ".join(texts) or "nothing was kept"))
    return rows


def _settling(settling: Settling, ahead: Forecast | None = None) -> str:
    moving = settling.moving
    later = ""
    if ahead is not None and not math.isnan(ahead.duration):
        later = f"; a run of about {significant(ahead.duration, 2)} s shows them settled (extrapolated)"
    if not settling.ball:
        return f"none; {'it still moves' if len(moving) == 1 else 'all still move'} at the end{later}"
    at = f" (at {settling.settled_at:.5g} s)" if settling.counted_from != "start" else ""
    when = f"{settling.duration:.3g} s after" if settling.duration > 0.0 else "before"
    text = f"{when} the {settling.counted_from}{at}, ball {settling.ball} last"
    if moving:
        named = ", ".join(map(str, moving[:LISTED])) + (", ..." if len(moving) > LISTED else "")
        text += f"; not settled: {len(moving)} ({named}){later}"
    return text
