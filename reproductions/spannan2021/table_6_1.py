"""Tables 6.1 and 6.3: the viscosity law of the silicone oils and the densities of their blends.

The tolerances are half a unit of the last printed digit; where a viscosity follows from printed coefficients, what
their rounding allows. The temperatures behind the coefficient of temperature are 99 and 38 degC, which the source
truncates to 372 and 311 K. The printed densities of the three blends follow from no rule of mixing; the row of one has
that of an ideal mixture.
"""

from __future__ import annotations

import itertools
import math
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import brentq

from autobalancer.catalog.product_tables import blend, fluid
from autobalancer.catalog.product_tables import rows as catalog_rows
from autobalancer.laws.viscosity import double_log_from_slope, viscosity_from_double_log
from autobalancer.plots.style import BALLS, CRITICAL, INK, UNBALANCE, look, picture
from reproductions import Found, compared_all

HALF_DIGIT = 5e-4
COLD, HOT = 311.15, 372.15  # K, 38 and 99 degC
BLENDS = (
    "printed is 844, which shares of volume (850) do not give either; nor are 800 and 876 of the other two blends mixed"
)


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Viscosity and VTC from the printed coefficients, the coefficients refitted, and the blends of Table 6.3."""
    within, oils, exact = 0, catalog_rows("silicone_oils.csv"), 0
    for oil in oils:
        nominal, coefficient = float(oil["nu_nominal_mm2_s"]), float(oil["VTC"])
        printed = float(oil["P1"]), float(oil["P2"])
        nu, steady = from_coefficients(*printed)
        corners = [
            from_coefficients(printed[0] + a, printed[1] + b)
            for a, b in itertools.product((-HALF_DIGIT, HALF_DIGIT), repeat=2)
        ]
        slack = max(abs(corner[0] - nu) for corner in corners), max(abs(corner[1] - steady) for corner in corners)
        within += abs(nu - nominal) <= slack[0] and abs(steady - coefficient) <= slack[1] + HALF_DIGIT
        refit = double_log_from_vtc(1e-6 * nominal, coefficient)
        exact += tuple(round(value, 3) for value in refit) == printed
    count = len(oils)
    rows = [
        Found("printed", "oils whose viscosity at 25 degC and VTC follow from P1, P2 within their rounding", "oils", count,
              within, 0),
        Found("printed", "oils whose P1 and P2 follow from viscosity and VTC to three decimals", "oils", count, exact, 0),
    ]  # fmt: skip
    share = math.log(5.0 * 855.0 / (50.0 * 950.0)) / math.log(0.65 * 760.0 / (50.0 * 950.0))  # (6.8), of the thin oil
    mixed = blend("silicone oil 0.65", "silicone oil 50 (experiment)", 5e-6, basis="mass").fluid.density
    rows.append(Found("misprint", "density of the blend of 5 mm^2/s, shares of mass", "kg/m^3",
                      1.0 / (share / 760.0 + (1.0 - share) / 950.0), float(mixed), 0.5, BLENDS, "Table 6.3"))  # fmt: skip
    draw(out)
    return compared_all("Spannan 2021", "Table 6.1", rows)


def vtc(p1: float, p2: float) -> float:
    """Viscosity-temperature coefficient 1 - nu(99 degC) / nu(38 degC)."""
    hot, cold = (viscosity_from_double_log(at, p1, p2) for at in (HOT, COLD))
    return float(1.0 - hot / cold)


def double_log_from_vtc(nu: float, coefficient: float) -> tuple[float, float]:
    """P1 and P2 from the viscosity at 25 degC and the coefficient, Spannan (2021), section 6; the flatter of two lines."""

    def line(p2: float) -> tuple[float, float]:
        return double_log_from_slope(298.15, nu, p2), p2

    slopes = np.linspace(0.0, -12.0, 1201)
    steepest = max(slopes, key=lambda slope: vtc(*line(slope)))
    return line(float(brentq(lambda slope: vtc(*line(slope)) - coefficient, steepest, 0.0, xtol=1e-13)))


def from_coefficients(p1: float, p2: float) -> tuple[float, float]:
    """Viscosity at 25 degC [mm^2/s] and coefficient of temperature."""
    return 1e6 * float(viscosity_from_double_log(298.15, p1, p2)), vtc(p1, p2)


def draw(out: Path) -> None:
    """Viscosity against temperature, as in figure 6.2 of the source."""
    celsius = np.linspace(0.0, 100.0, 201)

    def curve(name: str) -> Any:
        return [1e6 * fluid(name, 273.15 + t).viscosity for t in celsius]

    with look():
        figure = picture(7.2, 5.0)
        axes = figure.subplots()
        for point in (25.0, COLD - 273.15, HOT - 273.15):
            axes.axvline(point, color=CRITICAL, lw=0.8, ls=(0, (2, 2)))
        for oil in catalog_rows("silicone_oils.csv"):
            name = oil["nu_nominal_mm2_s"]
            line = curve(f"silicone oil {name}")
            label = "silicone oils" if name == "1" else "_"
            axes.plot(celsius, line, color=BALLS[0], label=label)
            axes.plot(25.0, float(name), "o", ms=4.5, color=BALLS[0])
            axes.annotate(name, (101.0, line[-1]), va="center", fontsize=8.5, color=BALLS[0])
        axes.plot(celsius, curve("ISO VG 10"), "--", color=UNBALANCE, label="ISO VG 10, viscosity index 100")
        for share, place in ((40, 52), (60, 46), (80, 44)):
            line = curve(f"glycerol {share} vol%")
            label = "glycerol-water" if share == 40 else "_"
            axes.plot(celsius, line, ":", color=BALLS[2], lw=1.8, label=label)
            box = {"facecolor": "white", "edgecolor": "none", "pad": 1.0}
            axes.annotate(
                f"{share} vol%",
                (place, line[2 * place]),
                ha="center",
                va="center",
                fontsize=8.5,
                color=BALLS[2],
                bbox=box,
            )
        for point, text in ((25.0, "25 °C"), (COLD - 273.15, "38 °C"), (HOT - 273.15, "99 °C")):
            axes.annotate(text, (point, 0.31), xytext=(3, 0), textcoords="offset points", fontsize=8, color=INK)
        axes.set(yscale="log", xlim=(0, 107), ylim=(0.28, 400), xlabel="temperature [°C]")
        axes.set(ylabel="kinematic viscosity [mm²/s]", title="silicone oils by the double-logarithmic law (6.1)")
        axes.legend(loc="upper right", frameon=True, facecolor="white", edgecolor="none", framealpha=1.0)
        figure.savefig(out / "table_6_1.png", dpi=150)
