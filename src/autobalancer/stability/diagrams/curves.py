"""Stability borders and folds over two parameters, followed exactly."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

import numpy as np
import xarray as xr

from autobalancer.assembly.terms import Theory, unknown
from autobalancer.errors import QuestionError
from autobalancer.files.given import balls_in_races
from autobalancer.files.machine_file import machine_text
from autobalancer.machine import Machine
from autobalancer.results.provenance import provenance
from autobalancer.stability.continuation.curves import Curve, FoldCurve, HopfCurve, curve_from
from autobalancer.stability.continuation.family import Family
from autobalancer.stability.continuation.follow import NoConvergence, Point, Steps, at_parameter, follow, locate
from autobalancer.stability.continuation.steady import Range
from autobalancer.stability.continuation.symmetry import kinds
from autobalancer.stability.diagrams.answers import BifurcationCurves
from autobalancer.stability.diagrams.branches import begin_all, with_enough_harmonics
from autobalancer.stability.diagrams.explorer import Explorer, Progress
from autobalancer.stability.host.planar import Floats
from autobalancer.units import optional_argument

NEAR = 5e-3  # of both ranges: a special point so near to a curve is on it


def bifurcation_curves(
    machine: Machine | str | Path,
    kind: Literal["Hopf", "fold"],
    parameter: str,
    start: float | str,
    end: float | str | None = None,
    second: str = "",
    second_start: float | str = "",
    second_end: float | str | None = None,
    *,
    speed: float | str | None = None,
    from_state: Literal["balanced", "coincident", "in line", "spread"] = "balanced",
    largest_step: float = 0.03,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Curves of Hopf points or folds of steady states in the plane of two parameters.

    Parameters
    ----------
    machine
        A machine or the path of a machine file; any rotor, no gravity across its axis.
    kind
        *Hopf*: where a state becomes unstable and its balls begin to oscillate. *fold*: where two states meet and vanish.
    parameter, start, end
        The first points of the curves are searched along this parameter, at the machine's own value of ``second``.
    second, second_start, second_end
        The other parameter; if the machine's own value is outside, ``second_start`` is taken instead.
    speed, from_state
        As for :func:`branches`.
    largest_step
        Of the parameters, as a share of their ranges.
    progress
        Called with (number of the curve, place in the second range between 0 and 1).

    Returns
    -------
    xarray.Dataset
        Along ``point``: ``curve``, the two parameters, for Hopf curves ``frequency`` (rad/s), ``lyapunov_coefficient``
        and ``criticality``. Along ``special``: *Bautin* points, at which the criticality changes, and *cusps*.

    Raises
    ------
    QuestionError
        If there is no such point along the first parameter, or a parameter or range is not possible.
    """
    speed = optional_argument("speed", speed, "rad/s")
    machine = balls_in_races(machine)
    if kind not in ("Hopf", "fold"):
        raise QuestionError(f"kind: given {kind!r}; must be Hopf or fold")
    if parameter == second:
        raise QuestionError(f"second: given {second!r} twice; take two different parameters")
    family = Family(machine, [parameter, second], speed)
    first, last = family.ends(0, start, end)
    ends = family.ends(1, second_start, second_end)
    if first == last or ends[0] == ends[1]:
        raise QuestionError(f"{parameter}, {second}: a range is empty; give two different ends")
    now = family.now(1)
    now = now if min(ends) <= now <= max(ends) else ends[0]
    at_speed = [(first, last), ends][(parameter, second).index("speed")] if "speed" in (parameter, second) else None
    family.reduce(max(at_speed) if at_speed else family(first, now).speed)
    kind_of = kinds([family(value, other).host for value in (first, last) for other in ends])
    if not kind_of:
        raise QuestionError("bifurcation curves: the machine has no balls")
    steps = Steps(0.3 * largest_step, 1e-7, largest_step)

    def followed() -> tuple[tuple[list[dict[str, Any]], list[dict[str, Any]]], float]:
        explorer = Explorer(Range(family, first, last, (now,)), kind_of, steps, 10, 10, None)
        begin_all(explorer, from_state, parameter)
        found = [f for f in explorer.specials if f.special.kind == kind and f.steady is not None and not f.steady.loose]
        if not found:
            raise QuestionError(
                f"kind: no {kind} point of the {from_state} state along {parameter} from {first:.6g} to {last:.6g} at "
                f"{second} = {now:.6g}; widen the range"
            )
        rows: list[dict[str, Any]] = []
        specials: list[dict[str, Any]] = []
        for number, entry in enumerate(found, 1):
            assert entry.steady is not None
            problem, u = curve_from(entry.special, entry.steady, now, ends)
            if _passes(rows, problem, u):
                continue  # the curve came back here along the first parameter
            sides = [_side(problem, u, way, number, specials, largest_step, progress) for way in (1.0, -1.0)]
            rows += [*reversed(sides[1]), *sides[0][1:]]
        return (rows, specials), max(explorer.tail(), *(row["tail"] for row in rows))

    rows, specials = with_enough_harmonics(family, followed)
    attributes = {
        "title": f"{kind} curves of {machine.name}, {from_state} state",
        **provenance(),
        "machine": machine_text(machine),
        "machine_name": machine.name,
        "parameter": parameter,
        "second_parameter": second,
        "state": from_state,
        "ignores": ", ".join(unknown(machine, Theory.AT_REST)),
    }
    return _dataset(family, rows, specials, attributes)


def _side(
    problem: Curve,
    u: Floats,
    way: float,
    number: int,
    specials: list[dict[str, Any]],
    most: float,
    progress: Progress | None,
) -> list[dict[str, Any]]:
    like = np.zeros(u.size)
    like[-1] = way
    u = at_parameter(problem, u, float(u[-1]))
    rows = [_row(problem, u, number)]
    try:
        for now, a, b in follow(problem, u, like, steps=Steps(0.3 * most, 1e-7, most, 1000)):
            assert isinstance(now, Curve)
            if not -1e-9 <= now.share(b.u) <= 1.0 + 1e-9:
                break
            if isinstance(now, HopfCurve) and now.frequency(b.u) < 1e-4 * now.span.frequency:
                break  # Takens-Bogdanov: the frequency runs to zero
            specials += _between(now, a, b, number)
            rows.append(_row(now, b.u, number))
            if progress is not None:
                progress(number, min(max(float(b.u[-1]), 0.0), 1.0))
    except np.linalg.LinAlgError:
        pass
    return rows


def _between(problem: Curve, a: Point, b: Point, number: int) -> list[dict[str, Any]]:
    """A Bautin point or a cusp between two points of a curve."""
    name = "Bautin" if isinstance(problem, HopfCurve) else "cusp"

    def test(p: Point) -> float:
        if isinstance(problem, HopfCurve):
            return problem.lyapunov(p.u)
        assert isinstance(problem, FoldCurve)
        return problem.curvature(p.u)

    if test(a) * test(b) >= 0.0:
        return []
    try:
        point = locate(problem, a, b, test, 1e-11)
    except (NoConvergence, np.linalg.LinAlgError):
        return []
    return [_row(problem, point.u, number) | {"type": name}]


def _row(problem: Curve, u: Floats, number: int) -> dict[str, Any]:
    row = {
        "curve": number,
        "parameter": problem.span.value(problem.share(u)),
        "second_parameter": problem.second(u),
        "share": problem.share(u),
        "mark": float(u[-1]),
        "tail": problem.tail(u),
    }
    if isinstance(problem, HopfCurve):
        row |= {"frequency": problem.frequency(u), "lyapunov_coefficient": problem.lyapunov(u)}
    return row


def _passes(rows: list[dict[str, Any]], problem: Curve, u: Floats) -> bool:
    """Whether a curve that was followed goes through this point."""
    mark, share = float(u[-1]), problem.share(u)
    for a, b in pairwise(rows):
        if a["curve"] != b["curve"] or not min(a["mark"], b["mark"]) - NEAR <= mark <= max(a["mark"], b["mark"]) + NEAR:
            continue
        part = (mark - a["mark"]) / (b["mark"] - a["mark"]) if a["mark"] != b["mark"] else 0.5
        if abs(a["share"] + part * (b["share"] - a["share"]) - share) < NEAR:
            return True
    return False


def _dataset(
    family: Family, rows: list[dict[str, Any]], specials: list[dict[str, Any]], attributes: dict[str, Any]
) -> xr.Dataset:
    parameters = {"parameter": family.attributes(0), "second_parameter": family.attributes(1)}
    data: dict[str, Any] = {"curve": ("point", [row["curve"] for row in rows], {"long_name": "number of the curve"})}
    for name, attrs in parameters.items():
        data[name] = ("point", [row[name] for row in rows], attrs)
        data[f"special_{name}"] = ("special", np.array([row[name] for row in specials], np.float64), attrs)
    types = np.array([row["type"] for row in specials], dtype=np.str_)
    data["special_type"] = ("special", types, {"long_name": "what happens there"})
    if rows and "frequency" in rows[0]:
        values = [row["lyapunov_coefficient"] for row in rows]
        data["frequency"] = ("point", [row["frequency"] for row in rows], {"long_name": "frequency", "units": "rad/s"})
        data["lyapunov_coefficient"] = ("point", values, {"long_name": "first Lyapunov coefficient", "units": "1"})
        names = ["supercritical" if value < 0.0 else "subcritical" for value in values]
        data["criticality"] = ("point", names, {"long_name": "criticality"})
    return BifurcationCurves(data, attrs=attributes)
