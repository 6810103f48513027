"""The panels of a chart over time, shared by pictures and films."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from autobalancer.plots.angles import slipping, wrapped
from autobalancer.plots.axis_units import AxisUnit, length_text, significant
from autobalancer.plots.history import Deflections, History
from autobalancer.plots.style import CRITICAL, FILL, INK, UNBALANCE, ball_color, ball_label, legend

BEHIND = {"fc": "white", "ec": "none", "alpha": 0.8, "pad": 0.8}


def speed_panel(axes: Axes, history: History, critical: list[float], unit: AxisUnit) -> None:
    """Rotor speed, absolute ball speeds and critical speeds: where balls hang, they leave the rotor's line."""
    drawn = np.concatenate([history.speed, history.ball_speed_in_space.ravel()])
    drawn = drawn[np.isfinite(drawn)]
    least, most = float(drawn.min(initial=np.inf)), float(drawn.max(initial=-np.inf))
    if not drawn.size:
        least, most = 0.0, 1.0
    least = min(least, 0.0) if least < 0.6 * most else least
    for level in critical:
        if not 0.9 * least <= level <= 1.1 * most:
            continue  # would squeeze what is asked for
        axes.axhline(level * unit.factor, color=CRITICAL, lw=1.0, ls=(0, (5, 3)), zorder=1.5)
        axes.annotate(
            f"critical speed {significant(level * unit.factor)} {unit.sign}",
            (1.0, level * unit.factor),
            xycoords=("axes fraction", "data"),
            xytext=(-2, 3),
            textcoords="offset points",
            ha="right",
            fontsize=8.5,
            color=CRITICAL,
        )
        least, most = min(least, level), max(most, level)
    axes.plot(history.time, history.speed * unit.factor, color=INK, lw=1.6, label="rotor")
    count = history.ball_speed_in_space.shape[1]
    for i in range(count):
        speed = history.ball_speed_in_space[:, i] * unit.factor
        axes.plot(history.time, speed, color=ball_color(i), lw=_width(i, count), label=ball_label(i, count))
    axes.set_ylabel(f"speed in space ({unit.sign})" if count else f"rotor speed ({unit.sign})")
    room = 0.1 * (most - least) or 0.1 * abs(most) or 1.0
    axes.set_ylim((least - (room if least else 0.0)) * unit.factor, (most + room) * unit.factor)
    legend(axes)


def deflection_panel(axes: Axes, deflections: Deflections, unit: AxisUnit, *, log: bool = False) -> None:
    """Deflection with its envelope; greatest and last value as numbers."""
    time, low, high = deflections.time, deflections.low * unit.factor, deflections.high * unit.factor
    greatest = float(np.nanmax(high, initial=0.0)) or 1.0
    if log:
        floor = max(float(np.nanmin(high[high > 0.0], initial=greatest)), 1e-8 * greatest)
        axes.set_yscale("log")
        axes.set_ylim(0.5 * floor, 8.0 * greatest)
        low = np.maximum(low, 0.5 * floor)
    else:
        axes.set_ylim(0.0, 1.18 * greatest)
    if deflections.is_envelope:
        axes.fill_between(time, low, high, color=FILL, lw=0.0, label="between least and greatest")
    axes.plot(time, high, color=INK, lw=0.9, label="greatest" if deflections.is_envelope else "deflection")
    axes.set_ylabel(f"deflection ({unit.sign})")
    if deflections.is_envelope:
        legend(axes)
    if not np.isfinite(high).any():
        return
    peak = int(np.nanargmax(high))
    late = time[peak] - time[0] > 0.6 * (time[-1] - time[0])
    axes.plot(time[peak], high[peak], "o", ms=4, color=INK, label="_peak")
    axes.annotate(
        f"{length_text(float(deflections.high[peak]))} at {time[peak]:.4g} s",
        (time[peak], high[peak]),
        xytext=(-7 if late else 7, 3),
        textcoords="offset points",
        ha="right" if late else "left",
        va="bottom",
        fontsize=8.5,
        bbox=BEHIND,
    )
    if time[-1] - time[peak] > 0.2 * (time[-1] - time[0]):  # else it says the same once more
        axes.annotate(
            f"at the end {length_text(float(deflections.high[-1]))}",
            (time[-1], max(float(high[-1]), axes.get_ylim()[0])),
            xytext=(-2, 6),
            textcoords="offset points",
            ha="right",
            fontsize=8.5,
            bbox=BEHIND,
        )


def angle_panel(axes: Axes, history: History) -> None:
    """Ball angles in the rotor, the unbalance and its opposite; pale where a ball slips round and round."""
    if history.unbalance_angle_in_rotor.size:
        heavy = history.unbalance_angle_in_rotor
        axes.plot(*wrapped(history.time, heavy), color=UNBALANCE, lw=1.2, ls="--", label="unbalance")
        time, degrees = wrapped(history.time, heavy + np.pi)
        for turn, label in ((0.0, "opposite"), (360.0, "_"), (-360.0, "_")):  # at ±180 degrees both edges show it
            axes.plot(time, degrees + turn, color=UNBALANCE, lw=1.2, ls=":", label=label)
    span = float(np.ptp(history.time))
    count = history.ball_angle_in_rotor.shape[1]
    for i in range(count):
        angle = history.ball_angle_in_rotor[:, i]
        fast = slipping(history.time, angle, span)
        time, degrees = wrapped(history.time, angle)
        if fast.any():
            axes.plot(time, degrees, color=ball_color(i), lw=0.5, alpha=0.22, label="_slipping")
        hidden = np.interp(time, history.time, fast.astype(np.float64)) > 0.5
        shown = np.where(hidden, np.nan, degrees)
        axes.plot(time, shown, color=ball_color(i), lw=_width(i, count), label=ball_label(i, count))
    axes.set_ylim(-186.0, 186.0)
    axes.set_yticks([-180, -90, 0, 90, 180])
    axes.set_ylabel("ball angle in the rotor (°)")
    legend(axes)


def _width(number: int, count: int) -> float:
    """Balls that move together stay visible together: the first is drawn broad below the others."""
    return 2.2 if number == 0 and 1 < count <= 6 else 1.2
