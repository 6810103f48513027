"""Figure 2.5: variants of the race that are meant to spare the rotor the balls below its critical speed.

The source judges them in words. Here each is a machine of the catalog on the planar stand-in of the discoidal rig: it rests at
40 rad/s, two thirds of its critical speed, then runs through this to 1200 rpm. Stiffnesses, magnets, pins and incline are
assumed, since nothing is printed of them.
"""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import autobalancer as ab
from autobalancer.errors import RangeWarning
from autobalancer.plots.style import save_picture
from reproductions import compared_all, said

VARIANTS = (
    *("plain", "springs", "magnets", "radial_springs", "incline", "pins", "partitions", "two_oils"),
    *("rollers", "pendulums"),
)
ANGLE = "balancers[1].races[1].partitions.angle"
RATE, LITTLE, CLEARLY = 40.0, 1e-3, 0.95  # rad/s; of the vibration without balls; of the plain race


def reproduce(out: Path) -> list[dict[str, Any]]:
    """What the words say of each variant, against a plain race with the same balls."""
    machines = {name: ab.load_machine(ab.catalog.example_path(f"variant_{name}")) for name in VARIANTS}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RangeWarning)  # the drag of this rig is linear, as in the source
        found = ab.compare(machines, at=[RATE], progress=False)
    save_picture(ab.plot.answer(found), out / "figure_2_5.png")
    below = found["deflection_at"].sel(speed=RATE) / found["deflection_at"].sel(speed=RATE, machine="plain")
    peak = found["peak_deflection"] / found["peak_deflection"].sel(machine="plain")
    left = found["vibration"] / found["vibration_without_balls"]

    def spared(name: str) -> bool:
        """Below the critical speed and at the peak."""
        return float(below.sel(machine=name)) < CLEARLY and float(peak.sel(machine=name)) < 1.0

    def balanced(name: str) -> bool:
        return float(left.sel(machine=name)) < LITTLE

    limited, reduced = partitions(float(found["deflection_at"].sel(speed=RATE, machine="plain")))
    rows = [
        said("springs along the race keep the balls from gathering below the critical speed", spared("springs")),
        said("they do not let them balance the rotor completely", not balanced("springs")),
        said("magnets hold the balls below the critical speed, then they balance", spared("magnets") and balanced("magnets")),
        said("radial springs: less impact below, full effect above", spared("radial_springs") and balanced("radial_springs")),
        said("inclined race: less impact below, full effect above", spared("incline") and balanced("incline")),
        said("pins: held below, unhindered above their speed", spared("pins") and balanced("pins")),
        said("partitions limit the unbalance added below the critical speed, mean over their angle", limited),
        said("partitions reduce what can be balanced, at some angles", reduced),
        said("races with different oils: smaller peak, then balanced",
             float(peak.sel(machine="two_oils")) < CLEARLY and balanced("two_oils")),
    ]  # fmt: skip
    return compared_all("Spannan 2021", "2.5 in kind", rows)


def partitions(plain: float) -> tuple[bool, bool]:
    """Whether two partitions add less than a plain race below the critical speed, and leave something above it."""
    one = ab.load_machine(ab.catalog.example_path("variant_partitions"))
    turned = {f"{angle} deg": ab.with_parameter(one, ANGLE, f"{angle} deg") for angle in (0, 20, 40, 60, 80)}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RangeWarning)
        found = ab.compare(turned, at=[RATE], progress=False)
    left = found["vibration"] / found["vibration_without_balls"]
    return float(found["deflection_at"].mean()) < CLEARLY * plain, float(left.max()) > 0.1
