"""Coefficients of the drag laws (5.22) and (6.9), and a picture of all laws.

(6.9) is used as repaired: its printed cubic misses its own plateau by a factor of 670. The rows of its coefficients show that
the print belongs to a plateau of 0.74, with a decimal point moved in the last one. That the laws go through their printed anchors
is a matter of construction and a test.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import autobalancer as ab
from autobalancer.drag.discoidal import discoidal
from autobalancer.laws.drag_coefficient import annulus_cd_times_re
from autobalancer.plots.style import save_picture
from reproductions import Found, Kind, compared_all


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Printed coefficients, and the picture."""
    save_picture(ab.plot.drag_laws(), out / "drag_laws.png")
    print_of = discoidal(0.74)
    rows = [Found("printed", "c_d Re for W1/rb = 2.10, rb/eps = 0.07", "1", 327.0, annulus_cd_times_re(2.10, 0.07), 1.0,
                  figure="5.22")]  # fmt: skip
    for power, (value, half) in enumerate([(2.72, 0.005), (-1.25, 0.005), (0.121, 0.0005), (0.0038, 0.00005)]):
        quantity = f"coefficient of x^{power} with the plateau 0.74"
        kind: Kind = "misprint" if power == 3 else "printed"
        note = "printed is 0.038: a decimal point is moved" if power == 3 else ""
        rows.append(Found(kind, quantity, "1", value, print_of.coefficients[power], half, note, figure="6.9"))
    return compared_all("Spannan 2021", "6.9", rows)
