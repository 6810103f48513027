"""Stiffness and loss of rubber over the amplitude."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from autobalancer.laws.rubber import Motion, RubberLaw
from autobalancer.plots.drawing.style import BALLS, INK, heading, look, picture
from autobalancer.results.answers.rubber_fit import RubberFit
from autobalancer.results.answers.rubber_points import RubberPoints, joined
from autobalancer.results.given import refusal

WIDER = 3.0  # than the points, each way
MOTIONS: tuple[tuple[Motion, str, str, str], ...] = (
    ("circle", "in a circle", "-", "o"),
    ("line", "in a line", "--", "s"),
)


def rubber(
    found: RubberFit | RubberLaw,
    points: RubberPoints | Sequence[RubberPoints] | None = None,
    *,
    frequency: float | None = None,
    amplitudes: tuple[float, float] | None = None,
    points_label: str = "measured",
) -> Figure:
    """Draw K' and K'' over the amplitude, in circles and in lines, with measured points and what was fitted to them.

    Parameters
    ----------
    found
        From :func:`~autobalancer.measure.rubber`, with a band of one standard deviation; or a law.
    points
        Of :func:`~autobalancer.measure.rubber_loops` or the like, in place of those of the fit; one or several sets.
    frequency
        Of the curves, rad/s; by default the median of the points.
    amplitudes
        From and to, m; by default somewhat farther than points and elements.
    points_label
        What the legend calls the points, such as where amplitudes are estimates.

    Returns
    -------
    matplotlib.figure.Figure
    """
    law = _law(found)
    if points is not None and not isinstance(points, RubberPoints):
        points = joined(list(points))
    shown = points if points is not None else found.points if isinstance(found, RubberFit) else None
    if frequency is None:
        frequency = 0.0 if shown is None else float(np.median(shown.frequency))
    if amplitudes is None:
        marks = [a for _, a in law.friction] if shown is None else shown.amplitude.tolist()
        amplitudes = (min(marks, default=1e-4) / WIDER, max(marks, default=1e-3) * WIDER)
    a = np.geomspace(*amplitudes, 400)
    with look():
        figure = picture(8.0, 3.7)
        panels = figure.subplots(1, 2)
        for motion, text, dash, mark in MOTIONS:
            stiffness = law.stiffness(a, frequency, motion)
            for axes, part in zip(panels, (stiffness.real, stiffness.imag), strict=True):
                axes.plot(
                    1e3 * a, 1e-3 * part, dash, color=BALLS[0], label=f"{text}, {frequency / (2.0 * np.pi):.3g} Hz"
                )
            if isinstance(found, RubberFit) and motion == "circle":
                for axes, part, sure in zip(
                    panels, (stiffness.real, stiffness.imag), found.uncertainty(a, frequency, motion), strict=True
                ):
                    axes.fill_between(
                        1e3 * a, 1e-3 * (part - sure), 1e-3 * (part + sure), color=BALLS[0], alpha=0.15, lw=0
                    )
            if shown is not None:
                _points(panels, shown, motion, f"{points_label} {text}", mark)
        if isinstance(found, RubberFit) and points is None:
            for axes, part in zip(panels, (found.fitted.real, found.fitted.imag), strict=True):
                at = 1e3 * found.points.amplitude
                axes.plot(at, 1e-3 * part, "_", color=BALLS[1], ms=8.0, mew=1.6, label="fitted", zorder=4.0)
        for axes, name in zip(panels, ("stiffness K'", "loss K''"), strict=True):
            axes.set_xscale("log")
            axes.set_xlim(1e3 * a[0], 1e3 * a[-1])
            axes.set_ylim(0.0)
            axes.set_xlabel("amplitude of the rubber (mm)")
            axes.set_ylabel(f"{name} (kN/m)")
        panels[0].legend(loc="lower left")
        heading(figure, "Rubber that softens with the amplitude")
    return figure


def _law(found: object) -> RubberLaw:
    if isinstance(found, RubberFit):
        return found.law
    if isinstance(found, RubberLaw):
        return found
    raise refusal(found, "plot.rubber", "a result of measure.rubber, or a laws.RubberLaw")


def _points(panels: np.ndarray, shown: RubberPoints, motion: Motion, label: str, mark: str) -> None:
    """Measured points with their standard uncertainty."""
    rows = np.array([one == motion for one in shown.motion])
    if not rows.any():
        return
    x = 1e3 * shown.amplitude[rows]
    for axes, name in zip(panels, ("stiffness", "loss"), strict=True):
        y = 1e-3 * getattr(shown, name)[rows]
        bar = 1e-3 * getattr(shown, f"{name}_uncertainty")[rows]
        _bars(axes, x, y, bar, mark, label)


def _bars(axes: Axes, x: np.ndarray, y: np.ndarray, bar: np.ndarray, mark: str, label: str) -> None:
    axes.errorbar(x, y, bar, fmt=mark, color=INK, ms=4.0, lw=0.8, mfc="white", mew=0.9, label=label)
