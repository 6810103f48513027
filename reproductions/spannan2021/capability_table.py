"""Tables C.1 and C.2: the capability of 412 bearings from eqs. (2.1) to (2.3).

The tables print three digits, so half a unit of the third digit (at most 0.5 %) is all that may be missing. Evidence
are the 315 verified rows; of the 97 reconstructed ones 11 were completed by the same law, and most of the others used
it to choose between readings. Three statements of the source do not hold, so their rows are compared with what is right: the
fluid of the footnote, the number of balls with the greatest capability, and the range of ball sizes in section 2.1.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from autobalancer.catalog.product_tables import TABLE_DENSITY, Bearing, bearings
from autobalancer.laws.capabilities import capability, half_sector, largest_useful_count, potential_ratio
from autobalancer.plots.style import BALLS, CRITICAL, INK, UNBALANCE, look, picture
from reproductions import Found, Kind, compared_all

AIR = 1.2
"""Density of air in a laboratory [kg/m^3]; any value from 0.9 to 1.27 gives the same digits."""


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Deviations by class of row, digits with and without air, and the two statements about the number of balls."""
    table = bearings()
    deviation = np.array([printed_rule(entry, 0.0) / entry.capability_printed - 1.0 for entry in table])
    verified = np.array([entry.verified for entry in table])
    alpha = np.array([half_sector(entry.orbit_radius, entry.ball_diameter) for entry in table])
    fit = 0.5 * math.pi / alpha
    best = np.array([largest_useful_count(entry.orbit_radius, entry.ball_diameter) for entry in table])
    gain = potential_ratio(best, alpha) / potential_ratio(np.floor(fit), alpha) - 1.0
    draw(out, table, deviation, verified, fit, gain)

    classes: dict[str, tuple[Kind, np.ndarray]] = {
        "315 verified rows": ("printed", verified),
        "97 reconstructed rows": ("fitted", ~verified),
    }
    rows = [
        Found(kind, f"largest deviation, {name}", "%", 0.0, 100.0 * float(np.abs(deviation[which]).max()), 0.5)
        for name, (kind, which) in classes.items()
    ]
    vacuum, air = (sum(not same_digits(entry, density) for entry in table if entry.verified) for density in (0.0, AIR))
    quantity = "verified rows with another third digit, air around the balls"
    rows.append(
        Found("misprint", quantity, "rows", 0, air, 0, f"the footnote says density 0, which misses {vacuum} digits")
    )
    tried = np.array([every_number(a) for a in alpha]) / potential_ratio(np.floor(fit), alpha) - 1.0
    quantity = "largest gain over the printed number of balls, nearest integer against every number tried"
    note = f"printed is the next lower integer, so no gain; {int(np.sum(gain > 1e-12))} of 412 rows gain"
    rows.append(Found("misprint", quantity, "%", 100.0 * tried.max(), 100.0 * float(gain.max()), 1e-6, note))
    extremes: tuple[tuple[str, str, Kind, float, float, str], ...] = (
        ("smallest", "deep_groove_SKF", "printed", 0.05, 0.005, ""),
        ("largest", "deep_groove_SKF", "misprint", 15.081 / 46.0, 0.0005, "6404; the text says 0.27"),
        ("smallest", "thin_section_Schaeffler", "misprint", 3.175 / 311.15, 0.0005, "CSCA 120; the text says 0.012"),
        ("largest", "thin_section_Schaeffler", "misprint", 2.381 / 30.162, 0.0005, "CSCAA 010 TN; the text says 0.065"),
    )
    for which, family, kind, target, tolerance, note in extremes:
        ratio = np.sin(alpha[[entry.family == family for entry in table]])
        extreme = ratio.min() if which == "smallest" else ratio.max()
        name = family.rsplit("_", 1)[0].replace("_", " ")
        rows.append(Found(kind, f"{which} ball on its orbit, {name}", "d/2e", target, extreme, tolerance, note))
    return compared_all("Spannan 2021", "Tables C.1, C.2", rows)


def every_number(alpha: float) -> float:
    """Greatest length of the sum (2.3) of directions, of all numbers of balls that fit."""
    return float(np.abs(np.cumsum(np.exp(2j * alpha * np.arange(math.floor(math.pi / alpha))))).max())


def printed_rule(entry: Bearing, fluid_density: float) -> float:
    """Capability [kg m] with the number of balls that the source takes, the next integer below pi / (2 a)."""
    count = math.floor(0.5 * math.pi / half_sector(entry.orbit_radius, entry.ball_diameter))
    race = (entry.orbit_radius, entry.ball_diameter, TABLE_DENSITY)
    return capability(*race, count, fluid_density=fluid_density)


def same_digits(entry: Bearing, fluid_density: float) -> bool:
    """Whether the capability, rounded to three digits, is the printed one."""
    return math.isclose(float(f"{printed_rule(entry, fluid_density):.2e}"), entry.capability_printed, rel_tol=1e-9)


def draw(out: Path, table: Any, deviation: Any, verified: Any, fit: Any, gain: Any) -> None:
    """Deviation of every row on the left, gain by the nearest integer on the right."""
    printed = 1e6 * np.array([entry.capability_printed for entry in table])
    with look():
        figure = picture(9.6, 3.9)
        left, right = figure.subplots(1, 2)
        x = np.logspace(-1, 8, 4001)
        half_digit = 50.0 * 10.0 ** (np.floor(np.log10(x)) - 2.0) / x
        left.fill_between(
            x, -half_digit, half_digit, color="#E9EDF0", lw=0, label="rounding of the printed three digits"
        )
        for which, color, name in ((verified, BALLS[0], "verified"), (~verified, BALLS[1], "reconstructed")):
            left.plot(printed[which], 100.0 * deviation[which], "o", ms=3.2, mew=0, color=color, alpha=0.8, label=name)
        left.set(xscale="log", xlim=(0.12, 2.0 * printed.max()), ylim=(-0.6, 0.95), xlabel="printed capability [g mm]")
        left.set(ylabel="calculated / printed - 1 [%]", title="412 bearings against eq. (2.3)")
        left.legend(loc="upper right", handletextpad=0.4)

        fraction = fit - np.floor(fit)
        right.axvline(0.5, color=CRITICAL, lw=0.9, ls="--")
        right.plot(fraction, 100.0 * gain, "o", ms=3.6, mew=0, color=UNBALANCE, alpha=0.7)
        top = int(np.argmax(gain))
        right.annotate(
            f"{table[top].designation}: {100.0 * gain[top]:.1f} %",
            (fraction[top], 100.0 * gain[top]),
            xytext=(-8, -2),
            textcoords="offset points",
            ha="right",
            color=INK,
        )
        right.set(xlim=(0, 1), ylim=(-0.1, 3.7), xlabel=r"fractional part of $\pi / 2\alpha$")
        right.set(ylabel="gain by one ball more [%]", title="nearest integer against next lower integer")
        figure.savefig(out / "capability_table.png", dpi=150)
