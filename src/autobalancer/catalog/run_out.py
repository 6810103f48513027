"""How far off center a race may be: half of the run-out that a standard permits, for bearing rings and for turned parts."""

from __future__ import annotations

from functools import cache

from autobalancer.catalog.tables import rows

RING = "half the run-out that ISO 492, class Normal, permits for a bearing ring of this size"
TURNED = "half the run-out that ISO 2768-2, class H, permits for a turned part"
TURNED_ECCENTRICITY = 50e-6  # m, for parts of any size; checked as the page on typical values says


def ring_eccentricity(diameter: float) -> float:
    """Eccentricity (m) that the permissible radial run-out of an outer ring of this diameter (m) allows.

    Radial bearings of the class Normal, ISO 492; above 800 mm the value of 800 mm. The seat of the ring adds its own.
    """
    table = _table()
    return 0.5 * next((run_out for largest, run_out in table if diameter <= largest), table[-1][1])


@cache
def _table() -> tuple[tuple[float, float], ...]:
    """Largest outside diameter and radial run-out, m; checked as the page on typical values says."""
    return tuple((1e-3 * float(row["up_to_mm"]), 1e-6 * float(row["run_out_um"])) for row in rows("ring_run_out.csv"))
