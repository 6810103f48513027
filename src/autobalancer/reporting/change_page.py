"""The page of small changes: what a tenth more or less of a number of a machine does, and so which must be known well."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from autobalancer.assembly.quantities import value_of, with_quantity
from autobalancer.errors import AutobalancerError
from autobalancer.machine import Machine, PlanarRotor
from autobalancer.machine.plain_names import dimension_of, named_unit, text_of
from autobalancer.patience import silent
from autobalancer.reporting.page import Paragraph, Rows, Section
from autobalancer.results.number_text import significant
from autobalancer.studies.ensemble.ensemble import ensemble
from autobalancer.studies.study.outputs import standing_numbers

CHANGE = 0.1
NAMES = (
    "unbalance",
    "stiffness",
    "damping",
    "ball_diameter",
    "viscosity",
    "drag",
)  # drag where no viscosity can change
STANDING = {  # numbers that need no run, by their names in results
    "critical speed": "critical_speed",
    "release speed": "release_speed",
    "exact border": "exact_border",
    "capability": "capability",
}


def change_page(machine: Machine, file: str, starts: int, seed: int) -> Section:
    """What changes of a tenth do to borders, capability, and run-ups from random starts.

    Parameters
    ----------
    machine
        As it is described.
    file
        Its name in commands.
    starts
        Random starts of each value; 0 for no runs.
    seed
        Of the first of them.
    """
    page, asked = Section("What small changes do"), [f"autobalancer borders {file}"]
    here, _ = standing_numbers(machine, STANDING)
    known = [name for name, key in STANDING.items() if math.isfinite(here[key]) and here[key] > 0.0]
    rows: list[tuple[str, ...]] = []
    middle, again = math.nan, f"--seeds {starts} --seed {seed}"
    if starts:
        middle = _median(ensemble(machine, seeds=starts, seed=seed, progress=silent)["peak_deflection"].values)
        asked.append(f"autobalancer ensemble {file} {again}")
    for name in NAMES:
        value = _value(machine, name)
        if not value > 0.0 or (name == "drag" and rows and rows[-1][0] == text_of("viscosity")):
            continue
        try:
            ends = [with_quantity(machine, name, one) for one in _ends(value)]
            runs = _runs(machine, name, value, starts, seed, middle)
        except AutobalancerError:
            continue
        found = [standing_numbers(one, STANDING)[0] for one in ends]
        cells = [_both([one[STANDING[key]] / here[STANDING[key]] for one in found]) for key in known]
        rows.append((text_of(name), *cells, *runs))
        asked.append(f'autobalancer borders {file} --over "{_span(name, value)}"')
        if starts:
            values = ",".join(f"{one:.6g}" for one in _ends(value))
            asked.append(f'autobalancer ensemble {file} --column "{name}={values} {named_unit(name)}" {again}')
    if not rows:
        page.blocks.append(Paragraph("Not stated: no number of the machine can be changed by itself."))
        return page
    measures = ["median peak deflection", "balanced (%)"] if starts else []
    heads = (f"{100.0 * CHANGE:g} % less / more of", *known, *measures)
    page.blocks.append(Rows(heads, tuple(rows), (False, *(True,) * (len(heads) - 1))))
    said = (
        f" Of {starts} run-ups from random starts, the same for all values: median, and the share that ends balanced."
    )
    page.blocks.append(
        Paragraph(
            "Changes in percent, of one number at a time; numbers that move a result by much must be known well. "
            "For scatter as it is expected, and how it acts together, add a study." + said * bool(starts)
        )
    )
    page.replay = "\n".join(asked)
    return page


def _value(machine: Machine, name: str) -> float:
    """The value that the machine has, nan if it has none that can be changed by its plain name."""
    if name in ("stiffness", "damping") and not isinstance(machine.rotor, PlanarRotor):
        return math.nan
    return value_of(machine, name)


def _ends(value: float) -> tuple[float, float]:
    """What is tried: a tenth less and more, as it stands in commands."""
    return float(f"{(1.0 - CHANGE) * value:.6g}"), float(f"{(1.0 + CHANGE) * value:.6g}")


def _span(name: str, value: float) -> str:
    low, high = _ends(value)
    return f"{name}={low:.6g}:{high:.6g} {named_unit(name)}:3"


def _runs(machine: Machine, name: str, value: float, starts: int, seed: int, middle: float) -> list[str]:
    """How run-ups with less and more change the median of the greatest deflection, and the shares that end balanced."""
    if not starts:
        return []
    found: Any = ensemble(machine, {name: _ends(value)}, seeds=starts, seed=seed, progress=silent)
    at = found[dimension_of(name)].values
    parts = [found.isel(member=np.isclose(at, one, rtol=1e-9)) for one in _ends(value)]
    ratios = [_median(part["peak_deflection"].values) / middle for part in parts]
    return [_both(ratios), " / ".join(f"{100.0 * float(part['balanced'].values.mean()):.3g}" for part in parts)]


def _median(values: Any) -> float:
    """Of the runs that have a number; nan if most have none."""
    known = np.isfinite(values)
    return float(np.median(values[known])) if known.mean() > 0.5 else math.nan


def _both(ratios: list[float]) -> str:
    return " / ".join("-" if not math.isfinite(one) else _signed(100.0 * (one - 1.0)) for one in ratios)


def _signed(percent: float) -> str:
    return "0" if abs(percent) < 0.05 else f"{'+' if percent > 0.0 else '−'}{significant(abs(percent), 2)}"
