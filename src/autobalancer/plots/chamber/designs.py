"""Picture of a search for designs of a deep chamber."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from autobalancer.plots.drawing.quantity_axis import plain_log_ticks
from autobalancer.plots.drawing.style import CRITICAL, INK, ball_color, heading, look, picture
from autobalancer.results.display_units import AxisUnit, length_axis
from autobalancer.results.given import Given, result

BESIDE = 0.018  # shares of the width by which marks of several frictions stand apart


def chamber_designs(designs: Given, *, title: str | None = None) -> Figure:
    """Where each design of a deep chamber stopped, and worst vibration against ball mass and settling time of the best.

    Designs that ran in full are filled, with a bar from the mean to the worst vibration and their place as a number; the line
    joins those that no other one beats. ``title`` stands above the panels.

    Parameters
    ----------
    designs
        From :func:`~autobalancer.chamber.design`, or the path of its file.
    title
        By default that of the answer.

    Returns
    -------
    matplotlib.figure.Figure
    """
    found = result(
        designs, "plot.chamber_designs", "chamber.design", lambda one: {"place", "stage"} <= set(one.data_vars)
    )
    frictions = sorted(set(found["friction"].values.tolist()))
    colors = {friction: ball_color(i) for i, friction in enumerate(frictions)}
    full = found.isel(design=np.isfinite(found["place"].values))
    unit = length_axis(None, float(np.nanmax(full["worst_vibration"].values, initial=1e-9)))
    limits = json.loads(found.attrs["limits"])
    with look():
        figure = picture(11.0, 4.0)
        where, light, quick = figure.subplots(1, 3)
        _stages(where, found, colors)
        _against(light, full, full["total_mass"].values, unit, colors, "pareto_mass")
        light.set_xlabel("mass of all balls (kg)")
        _against(quick, full, full["worst_settling_time"].values, unit, colors, "pareto_settling")
        if not np.isfinite(full["worst_settling_time"].values).any() and "settling_time" not in limits:
            quick.set_xticks([])  # nothing to show gets no scale
        late = int(np.isnan(full["worst_settling_time"].values).sum())
        unsettled = f"\n{late} not here: some filling did not settle" if late else ""
        quick.set_xlabel(f"settling time of the last ball, worst filling (s){unsettled}")
        if "settling_time" in limits:
            quick.axvline(limits["settling_time"], color=CRITICAL, lw=0.9, ls="--")
        shown = [unit.factor * limits["vibration"]] if "vibration" in limits else []
        for panel in (light, quick):
            panel.set_ylabel(f"vibration, mean to worst ({unit.sign})")
            panel.set_yscale("log")
            panel.set_ylim(
                *_range([*shown, *(full[name].values * unit.factor for name in ("vibration_mean", "worst_vibration"))])
            )
            plain_log_ticks(panel, "y")
            for level in shown:
                panel.axhline(level, color=CRITICAL, lw=0.9, ls="--")
        _legend(figure, colors, bool({"vibration", "settling_time"} & set(limits)))
        light.set_title("Balls needed")
        quick.set_title("Time to balance")
        heading(figure, title if title is not None else str(found.attrs.get("title", "")))
    return figure


def _stages(panel: Axes, found: xr.Dataset, colors: dict[float, Any]) -> None:
    """All designs over number and mass of their balls: a cross, an open or a filled mark by where they stopped."""
    mass = found["total_mass"].values
    width = max(float(np.ptp(mass)), 0.1 * float(mass.max()))
    for i, (friction, color) in enumerate(colors.items()):
        own = found["friction"].values == friction
        at = mass + (i - 0.5 * (len(colors) - 1)) * BESIDE * width
        ran = np.isfinite(found["place"].values)
        ruled = (found["stage"].values == "bounds") & (found["reason"].values != "")
        for chosen, mark, fill in ((ruled, "x", color), (~ruled & ~ran, "o", "none"), (ran, "o", color)):
            there = own & chosen
            panel.plot(at[there], found["balls"].values[there], mark, ms=5, color=color, mfc=fill, mew=1.0)
    panel.set_xlim(float(mass.min()) - 0.15 * width, float(mass.max()) + 0.15 * width)
    panel.set_yscale("log")
    counts = sorted(set(found["balls"].values.tolist()))
    panel.set_yticks(counts, [str(count) for count in counts])
    panel.minorticks_off()
    panel.set_ylabel("number of balls")
    panel.set_xlabel("mass of all balls (kg)")
    panel.set_title("Where designs stopped")


def _range(values: list[Any]) -> tuple[float, float]:
    """Ends of a logarithmic axis with room around all that is known."""
    known = np.concatenate([np.atleast_1d(one) for one in values])
    known = known[np.isfinite(known) & (known > 0.0)]
    return (0.6 * float(known.min()), 1.6 * float(known.max())) if known.size else (0.1, 1.0)


def _legend(figure: Figure, colors: dict[float, Any], limited: bool) -> None:
    """What marks and colors mean, below all panels."""
    marks = [
        Line2D([], [], ls="", marker="x", color=INK, ms=5, label="ruled out by closed forms"),
        Line2D([], [], ls="", marker="o", color=INK, mfc="none", ms=5, label="by short runs"),
        Line2D([], [], ls="", marker="o", color=INK, ms=5, label="ran in full, with its place"),
        *(
            Line2D([], [], ls="", marker="s", color=color, ms=5, label=f"friction {friction:g}")
            for friction, color in colors.items()
        ),
        Line2D([], [], color=CRITICAL, lw=0.9, label="none is better in both"),
        *([Line2D([], [], color=CRITICAL, lw=0.9, ls="--", label="limit")] if limited else []),
    ]
    figure.legend(handles=marks, ncols=len(marks), loc="outside lower left", frameon=False)


def _against(panel: Axes, full: xr.Dataset, at: Any, unit: AxisUnit, colors: dict[float, Any], front: str) -> None:
    """Vibration of the designs that ran in full; equal ones stand beside each other."""
    mean, worst = (full[name].values * unit.factor for name in ("vibration_mean", "worst_vibration"))
    known = np.isfinite(at) & np.isfinite(worst)
    near = 1e-6 * float(np.abs(at[known]).max(initial=1.0))
    width = max(float(np.ptp(at[known])) if known.any() else 0.0, 1e5 * near)
    if known.any():
        panel.set_xlim(float(at[known].min()) - 0.2 * width, float(at[known].max()) + 0.2 * width)
    on = known & (full[front].values == 1)
    order = np.argsort(at[on])
    panel.plot(at[on][order], worst[on][order], "-", lw=0.9, color=CRITICAL, zorder=1.5)
    for i in np.flatnonzero(known):
        equal = np.flatnonzero(known & (np.abs(at - at[i]) < near))
        x = at[i] + (float(np.searchsorted(equal, i)) - 0.5 * (equal.size - 1)) * 3.0 * BESIDE * width
        color = colors[float(full["friction"].values[i])]
        panel.plot([x, x], [mean[i], worst[i]], "-", lw=1.2, color=color)
        panel.plot(x, worst[i], "o", ms=11, color=color, zorder=3.0)
        place = f"{full['place'].values[i]:.0f}"
        panel.annotate(place, (x, worst[i]), color="white", fontsize=8, ha="center", va="center_baseline", zorder=4.0)
