"""The border speeds over any parameter of the machine."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.assembly.quantities import parameter_range, parameter_unit, si_value
from autobalancer.assembly.terms import Theory, unknown, weightless
from autobalancer.catalog.resolve import resolve
from autobalancer.errors import QuestionError
from autobalancer.files.given import balls_in_races
from autobalancer.files.machine_file import machine_text
from autobalancer.machine import Machine, PlanarRotor
from autobalancer.machine.plain_names import axis_attributes, dimension_of, text_of
from autobalancer.results.provenance import provenance
from autobalancer.stability.host.planar import Floats, Plane, plane
from autobalancer.stability.maps.answers import BorderCurve
from autobalancer.stability.maps.exact import exact_borders
from autobalancer.stability.maps.map_rates import with_values
from autobalancer.stability.maps.speeds import (
    NAMES,
    Border,
    borders_of,
    saying_what_is_ignored,
    speed_or_none,
    theory_of,
)
from autobalancer.stability.states.described import Described, described, lower_critical_speed

Progress = Callable[[int, int], None]
VARIABLES = {name: name.replace(", ", "_").replace(" ", "_") for name in NAMES}
MISSING = {  # why a border that others have is not there
    "exact border, best case": "positions of the balls make no difference",
    "capture speed": "balls in line are not captured",
}


def border_curve(
    machine: Machine | str | Path,
    parameter: str,
    values: Sequence[Any] | Floats | str | None = None,
    *,
    only: Sequence[str] = (),
    up_to: float | str | None = None,
    progress: Progress | None = None,
) -> BorderCurve:
    """The border speeds over a parameter.

    Parameters
    ----------
    machine
        A machine or the path of a machine file.
    parameter
        A name of :data:`autobalancer.machine.plain_names.QUANTITIES`, such as ``"unbalance"``, ``"viscosity"`` or
        ``"rolling_resistance"``, or a path such as ``"balancers[1].races[1].orbit_radius"``.
    values
        SI, strings with units, or a range such as ``"1:100 mm^2/s:30:log"``. For the unbalance they may be
        omitted: then from zero to the capability, dense near the values at which the border is highest.
    only, up_to
        Names of the borders that are wanted, and the highest speed of the run-up, see :func:`borders`.
    progress
        Called with (values done, values in all).

    Returns
    -------
    xarray.Dataset
        Over the parameter, in rad/s: ``averaged_border``, ``exact_border``, ``exact_border_worst_case`` (any
        unbalance), for more than two balls ``exact_border_best_case``, ``release_speed``, ``capture_speed``; each with a
        text ``..._note``. Infinite is *never*, nan *none*; the note says why. ``critical_speed`` is the lower one.

    Raises
    ------
    QuestionError
        For an unknown parameter or no values, no balls, or the ``unbalance`` of a rotor that tilts
        or bends, which may have several: there give the path of one.
    MachineError
        If a value makes no possible machine; the message names it.
    """
    machine = balls_in_races(machine)
    if values is None:
        parameter_unit(machine, parameter)  # refuses a name that is none, with what was perhaps meant
        if parameter != "unbalance" or not isinstance(machine.rotor, PlanarRotor):
            raise QuestionError(
                f"values: none given; give those of {parameter!r}. Only for 'unbalance' of a planar rotor they follow from the "
                "machine"
            )
        values = unbalances_to_capability(machine)
    if isinstance(values, str):
        values = parameter_range(machine, parameter, values)
    if len(values) == 0:
        raise QuestionError(f"values: given none; give at least one of {parameter!r}")
    points = [value.item() if isinstance(value, np.generic) else value for value in values]
    numbers = [si_value(machine, parameter, value) for value in points]
    rows, critical, top = [], [], speed_or_none(up_to)
    constant: tuple[Border, ...] | None = None  # only the exact border depends on the unbalance of races on the axis
    for number, value in enumerate(points):
        changed, p = with_values(machine, {parameter: value})
        if parameter == "unbalance" and not only and constant is not None and _any_unbalance(p):
            rows.append(
                (
                    *(b for b in constant if not b.name.startswith("exact border")),
                    *saying_what_is_ignored(changed, exact_borders(changed, p)),
                )
            )
            rows[-1] += tuple(b for b in constant if b.name == "exact border, worst case")
        else:
            constant = borders_of(changed, p, only, top)
            rows.append(constant)
        critical.append(lower_critical_speed(p))
        if progress is not None:
            progress(number + 1, len(points))
    return _dataset(machine, parameter, numbers, rows, critical)


def _any_unbalance(p: Described) -> bool:
    """Whether all borders but the exact one of a state are those of any unbalance."""
    one_plane = isinstance(p, Plane) or (p.isotropic and len(p.names) == 1)
    return one_plane and not np.any(p.offset)


def unbalances_to_capability(machine: Machine, count: int = 161) -> Floats:
    """From zero to what the balls side by side can balance, kg m, dense about two balls at right angles, where |S2| = 0."""
    p = plane(weightless(machine), 0.0, with_forces=True)
    if p.moment.size == 0:
        raise QuestionError("the machine has no balls; there is no border over the unbalance")
    most, points = p.capability, float(p.moment.sum())
    even = np.linspace(0.0, 1.0, count // 2)
    around = math.sqrt(0.5) + np.concatenate(
        [-np.geomspace(1e-5, 0.1, count // 4)[::-1], [0.0], np.geomspace(1e-5, 0.1, count // 4)]
    )
    return np.unique(np.minimum(np.concatenate([most * even, points * around]), most))


def _dataset(
    machine: Machine, parameter: str, numbers: list[float], rows: list[tuple[Border, ...]], critical: list[float]
) -> BorderCurve:
    dim = dimension_of(parameter)
    found = xr.Dataset(coords={dim: (dim, numbers, axis_attributes(parameter))})
    names = [name for name in VARIABLES if any(border.name == name for row in rows for border in row)]
    for name in names:
        by_name = [{border.name: border for border in row} for row in rows]
        missing = Border(name, math.nan, MISSING.get(name, ""))
        borders = [entry.get(name, missing) for entry in by_name]
        found[VARIABLES[name]] = (dim, [b.speed for b in borders], {"long_name": name, "units": "rad/s"})
        found[f"{VARIABLES[name]}_note"] = (
            dim,
            np.array([b.note for b in borders], dtype=object),
            {"long_name": f"note on the {name}"},
        )
    found["critical_speed"] = (dim, critical, {"long_name": "lower critical speed", "units": "rad/s"})
    p = described(weightless(machine), None)
    found.attrs = {
        "title": f"Border speeds of {machine.name} over {text_of(parameter)}",
        **provenance(),
        "machine": machine_text(machine),
        "machine_name": machine.name,
        "parameter": parameter,
        "unbalance": abs(p.unbalance),
        "capability": float(np.sum(p.capability)),
        "balls": len(resolve(machine)),
        **_ignored(machine, names),
        "theory": "exact border: full equations; averaged border: averaged equations (Spannan 2021, 4.74); release and "
        "capture speed: torque balance of stalled balls",
    }
    return BorderCurve.of(found)


def _ignored(machine: Machine, names: list[str]) -> dict[str, str]:
    """What the borders of balls at rest leave out, and those of stalled balls, which know more."""
    left_out: dict[bool, dict[str, None]] = {}
    for name in names:
        theory = theory_of(name)
        left_out.setdefault(theory is Theory.STALLED, {}).update(dict.fromkeys(unknown(machine, theory)))
    stalled = ", ".join(left_out.get(True, ()))
    if False not in left_out:
        return {"ignores": stalled}
    return {"ignores": ", ".join(left_out[False]), "stalled_ignores": stalled}
