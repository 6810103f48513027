"""How long the design of the laboratory centrifuge takes from the specification to the report."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any

import autobalancer as ab
from benchmarks import measured

SPECIFICATION = "centrifuge_design"


def bench() -> list[dict[str, Any]]:
    """The row: reading, screening, all runs, ranking, machine file and report, on all cores."""
    with TemporaryDirectory() as place:
        begin = perf_counter()
        found = ab.design(ab.catalog.example_path(SPECIFICATION), folder=Path(place) / "parts", progress=None)
        best = ab.save_machine(ab.designed_machine(found), Path(place) / "best.toml")
        ab.report(best, Path(place) / "best.html", study=found)
        seconds = perf_counter() - begin
    ran = found.best().sizes["design"]
    note = f"{found.sizes['design']} candidates, {ran} with {found.attrs['members']} runs each, report; at most 300 is asked"
    return [measured("design_centrifuge_s", seconds, "s", note=note)]
