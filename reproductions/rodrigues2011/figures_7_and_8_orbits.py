"""Figures 7 and 8, whirl orbits of the rotor without balls at 1415, 1675, 1944 and 2310 rpm.

With forward rotation and damping the long axis of an orbit on supports that are softer along y leans to one side only,
towards negative x y. The measured orbits lean to the other side, so their axes are seen from the other end of the rotor;
x is mirrored here, and the labels B1 and B2 are exchanged, which both the view and the sizes ask for. The points are
sorted by polar angle, so the measured direction is not in the data. Sizes compare at one speed although the measured first
peak lies 3 % below that of the model.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

import autobalancer as ab
from autobalancer.plots.rotor import WHIRL
from autobalancer.plots.style import ALL_BALLS, look, picture, save_picture
from autobalancer.results.display_units import length_axis
from autobalancer.rotordynamics.response import whirl_orbits
from reproductions import Found, compared_all, said
from reproductions.rodrigues2011.rig import BEARINGS, RPM, columns, fitted

FIGURES = {
    1415.0: "orbit_fig07b_1415rpm_measured_plain",
    1675.0: "orbit_fig07c_1675rpm_measured_plain",
    1944.0: "orbit_fig07d_1944rpm_measured_plain",
    2310.0: "orbit_fig07e_2310rpm_measured_plain",
}
DEGREES, SIZE = 10.0, 0.2
RATIO = "the second measured peak differs between days; here it is at 1675 rpm, in the model at 1700 rpm"
LEAN = "the orbit is nearly straight in the model and wide in the measurement"
PEAKS = {
    1415.0: "the peak is at 1457 rpm in the model; here run-up and run-down of the source differ by a fifth",
    2310.0: "the peak is at 2280 rpm in the model",
}
LABEL = {"B1": "B2", "B2": "B1"}  # of the model: of the figure


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Inclination, size, their ratio between the bearings, and where the whirl is backward."""
    machine = fitted()
    rows = []
    for speed, name in FIGURES.items():
        found = whirl_orbits(machine, speed * RPM, BEARINGS)
        measured = [_ellipse(*_seen(name, bearing)) for bearing in BEARINGS]
        about = f"{speed:.0f} rpm"
        for i, bearing in enumerate(BEARINGS):
            seen = measured[i][1]
            lean = seen + math.remainder(math.degrees(found["inclination"].values[i]) - seen, 180.0)
            note = LEAN if abs(lean - seen) > DEGREES else ""
            rows.append(
                Found("printed", f"{about}, {bearing}: inclination of the orbit", "deg", seen, lean, DEGREES, note)
            )
        size = found["semi_major"].values * 1e3
        ratio, mean = measured[1][0] / measured[0][0], 0.5 * (measured[0][0] + measured[1][0])
        rows += [
            Found(
                "printed",
                f"{about}: orbit at B2 over that at B1",
                "1",
                ratio,
                size[1] / size[0],
                SIZE * ratio,
                RATIO if speed == 1675.0 else "",
            ),
            Found(
                "printed", f"{about}: mean major semi-axis", "mm", mean, size.mean(), SIZE * mean, PEAKS.get(speed, "")
            ),
        ]
    between = np.linspace(1458.0, 1698.0, 121)
    words = ab.rotor.response(machine, between * RPM, BEARINGS)["whirl"].values
    rows.append(
        said("backward whirl at both bearings between the first peaks", bool((words == "backward").all(axis=1).any()))
    )
    _draw(out)
    return compared_all("Rodrigues 2011", "7 and 8, orbits", rows)


def _seen(name: str, bearing: str) -> tuple[np.ndarray, np.ndarray]:
    """Measured points at a bearing of the model, x mirrored, mm."""
    x, y = columns(f"{name}_{LABEL[bearing]}")
    return -x, y


def _ellipse(x: np.ndarray, y: np.ndarray) -> tuple[float, float]:
    """Major semi-axis and inclination (deg, within 90) of the conic with the least squares of its equation."""
    a, b, c, d, e = np.linalg.lstsq(np.column_stack([x**2, x * y, y**2, x, y]), np.ones(x.size), rcond=None)[0]
    shape = np.array([[a, 0.5 * b], [0.5 * b, c]])
    center = np.linalg.solve(2.0 * shape, [-d, -e])
    level = 1.0 + center @ shape @ center
    values, vectors = np.linalg.eigh(shape / level)
    lean = math.degrees(math.atan2(vectors[1, 0], vectors[0, 0]))
    return float(values[0] ** -0.5), math.remainder(lean, 180.0)


def _draw(out: Path) -> None:
    unit = length_axis("mm", 1.0)
    with look():
        figure = picture(7.4, 10.4)
        grid = figure.subplots(4, 2, sharex=True, sharey=True)
        shown: dict[str, Any] = {}
        for row, (speed, name) in zip(grid, FIGURES.items(), strict=True):
            found = whirl_orbits(fitted(), speed * RPM, BEARINGS)
            for axes, bearing, i in zip(row, BEARINGS, range(2), strict=True):
                word = str(found["whirl"].values[i])
                axes.plot(*_seen(name, bearing), ".", ms=2, color=ALL_BALLS, label="measured, x mirrored")
                line = found["x"].values[i] * unit.factor, found["y"].values[i] * unit.factor
                axes.plot(*line, color=WHIRL[word], label=f"model, {word}")
                axes.set(aspect="equal", title=f"{bearing}, {speed:.0f} rpm", xlabel="x (mm)", ylabel="y (mm)")
                shown |= dict(zip(*axes.get_legend_handles_labels()[::-1], strict=True))
        figure.legend(shown.values(), shown.keys(), loc="outside lower center", ncols=3)
        save_picture(figure, out / "orbits.png")
