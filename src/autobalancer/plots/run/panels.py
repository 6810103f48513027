"""The panels of a chart over time, shared by pictures and films."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from autobalancer.plots.drawing.angles import slipping, wrapped
from autobalancer.plots.drawing.labels import label_level, label_point
from autobalancer.plots.drawing.quantity_axis import plain_log_ticks
from autobalancer.plots.drawing.style import BALLS, CRITICAL, FILL, INK, UNBALANCE, legend
from autobalancer.plots.run.ball_looks import BallLook
from autobalancer.plots.run.history import CriticalSpeeds, Curve, Deflections, History
from autobalancer.results.display_units import EACH_ITS_OWN, AxisUnit, length_text, length_tick, significant

RARE = 0.002  # of all speeds of balls; if these alone make the axis three times longer they leave the picture
SAME = 1e-6  # of the speed: what differs less is one line, not the rounding of the run enlarged
NEAR = 0.15  # of the speed axis: a label is an eighth of the lowest panel
PLACES = (BALLS[0], BALLS[1], BALLS[2], BALLS[3], BALLS[4], BALLS[5])  # colors of the deflection at other places


def speed_panel(
    axes: Axes, history: History, critical: CriticalSpeeds, unit: AxisUnit, looks: Sequence[BallLook]
) -> None:
    """Rotor speed, absolute ball speeds and critical speeds: where balls stall, they leave the rotor's line."""
    least, most = _speeds_shown(history)
    least = min(least, 0.0) if least < 0.6 * most else least
    shown = sorted(
        level for level in critical.levels if 0.9 * least <= level <= 1.1 * most
    )  # others would squeeze the rest
    for level in shown:
        axes.axhline(level * unit.factor, color=CRITICAL, lw=1.0, ls=(0, (5, 3)), zorder=1.5)
        least, most = min(least, level), max(most, level)
    for group in _near(shown, NEAR * (most - least)):
        numbers = [significant(level * unit.factor) for level in group]
        text = f"critical speed{'s' * (len(group) > 1)}{critical.of} {_listed(numbers)} {unit.sign}"
        label_level(axes, text, group[-1] * unit.factor, color=CRITICAL)
    axes.plot(history.time, history.speed * unit.factor, color=INK, lw=1.6, label="rotor")
    count = history.ball_speed_in_space.shape[1]
    for i in range(count):
        speed = history.ball_speed_in_space[:, i] * unit.factor
        axes.plot(history.time, speed, color=looks[i].color, lw=_width(i, count), label=looks[i].label)
    axes.set_ylabel(f"speed in space ({unit.sign})" if count else f"rotor speed ({unit.sign})")
    steady = most - least <= SAME * abs(most)
    room = (0.1 * abs(most) or 1.0) if steady else 0.1 * (most - least)
    axes.set_ylim((least - (room if least else 0.0)) * unit.factor, (most + room) * unit.factor)
    legend(axes)


def deflection_panel(
    axes: Axes, deflections: Deflections, unit: AxisUnit, *, log: bool = False, brief: bool = False
) -> None:
    """Deflection with its envelope, and that of other places; greatest and last value as numbers."""
    time, low, high = deflections.time, deflections.low * unit.factor, deflections.high * unit.factor
    every = [high, *(curve.value * unit.factor for curve in deflections.curves)]
    without = deflections.without
    if without is not None:
        every.append(without.value * unit.factor)
    greatest = max(float(np.nanmax(values, initial=0.0)) for values in every) or 1.0
    if log:
        least = min(_least_of(values, greatest) for values in every)
        floor = 0.5 * max(least, 1e-8 * greatest)
        axes.set_yscale("log")
        axes.set_ylim(floor, greatest * max(5.0, (greatest / floor) ** 0.14))  # room for a label above the peak
        low = np.maximum(low, floor)
    else:
        axes.set_ylim(0.0, 1.18 * greatest)
    if deflections.is_envelope:
        axes.fill_between(time, low, high, color=FILL, lw=0.0, label="_band" if brief else "least to greatest")
    axes.plot(time, high, color=INK, lw=0.9, label=_main_label(deflections, brief))
    for curve, color in zip(deflections.curves, PLACES, strict=False):
        axes.plot(
            curve.time, curve.value * unit.factor, color=color, lw=0.9, label=_curve_label(curve, deflections, brief)
        )
    if without is not None:
        axes.plot(without.time, without.value * unit.factor, "--", color=UNBALANCE, lw=1.2, label="without balancing")
        instant = _is_instant(without, time)
        if instant:  # the line is too short to be seen
            axes.plot(without.time[-1:], without.value[-1:] * unit.factor, "_", color=UNBALANCE, ms=24.0, mew=1.4)
    if unit == EACH_ITS_OWN:
        plain_log_ticks(axes, "y", length_tick)
    axes.set_ylabel(f"deflection ({unit.sign})" if unit.sign else "deflection")
    if deflections.is_envelope or deflections.curves or without is not None:
        legend(axes)
    _numbers(axes, deflections, unit)
    if without is not None:  # last: of all labels it can move farthest
        words = f"{length_text(float(without.value[-1]))} without balancing{' at the last speed' * instant}"
        level = float(np.ptp(without.value)) <= 0.01 * float(without.value[-1])
        back = without.time[0] if level else None
        label_point(axes, words, without.time[-1], without.value[-1] * unit.factor, color=UNBALANCE, back=back)


def _is_instant(curve: Curve, time: np.ndarray) -> bool:
    return bool(np.ptp(curve.time) < 0.01 * np.ptp(time))


def angle_panel(
    axes: Axes, history: History, looks: Sequence[BallLook], *, plane: int = 0, balls: Sequence[int], name: str = ""
) -> None:
    """Ball angles of a plane in the rotor, the unbalance there and its opposite; pale where a ball slips round and round."""
    if history.unbalance_angle_in_rotor.shape[1] > plane:
        heavy = history.unbalance_angle_in_rotor[:, plane]
        axes.plot(*wrapped(history.time, heavy), color=UNBALANCE, lw=1.2, ls="--", label="unbalance")
        time, degrees = wrapped(history.time, heavy + np.pi)
        for turn, label in ((0.0, "opposite"), (360.0, "_"), (-360.0, "_")):  # at ±180 degrees both edges show it
            axes.plot(time, degrees + turn, color=UNBALANCE, lw=1.2, ls=":", label=label)
    span = float(np.ptp(history.time))
    count = len(looks)
    for i in balls:
        angle = history.ball_angle_in_rotor[:, i]
        fast = slipping(history.time, angle, span)
        time, degrees = wrapped(history.time, angle)
        if fast.any():
            axes.plot(time, degrees, color=looks[i].color, lw=0.5, alpha=0.22, label="_slipping")
        hidden = np.interp(time, history.time, fast.astype(np.float64)) > 0.5
        shown = np.where(hidden, np.nan, degrees)
        axes.plot(time, shown, color=looks[i].color, lw=_width(i - balls[0], count), label=looks[i].label)
    axes.set_ylim(-186.0, 186.0)
    axes.set_yticks([-180, -90, 0, 90, 180])
    axes.set_ylabel(f"ball angle in the rotor (°)\n{name}" if name else "ball angle in the rotor (°)")
    legend(axes)


def _numbers(axes: Axes, deflections: Deflections, unit: AxisUnit) -> None:
    """The greatest deflection, and what is there at the end if that says something else."""
    time, high = deflections.time, deflections.high
    if not np.isfinite(high).any():
        return
    peak = int(np.nanargmax(high))
    axes.plot(time[peak], high[peak] * unit.factor, "o", ms=4, color=INK, label="_peak")
    label_point(axes, f"{length_text(float(high[peak]))} at {time[peak]:.4g} s", time[peak], high[peak] * unit.factor)
    if time[-1] - time[peak] <= 0.2 * (time[-1] - time[0]):
        return  # it would say the same once more
    bottom, when = axes.get_ylim()[0], "at the end" if deflections.ends else f"at {time[-1]:.4g} s"
    if deflections.static:
        curve = deflections.curves[0]
        moving = f"vibration {length_text(float(curve.value[-1]))} {when}"
        label_point(axes, moving, curve.time[-1], max(curve.value[-1] * unit.factor, bottom), color=PLACES[0])
        return
    outside = (
        high[-1] * unit.factor < bottom
    )  # two short lines then stay clear of a curve that falls out of the picture
    gap = "\n" if outside else " "
    words = f"{length_text(float(high[-1]))}{gap}{when}"
    label_point(axes, words, time[-1], max(high[-1] * unit.factor, bottom))


def _speeds_shown(history: History) -> tuple[float, float]:
    """The range of the speeds, without the few moments at which a ball that falls through the middle turns very fast."""
    drawn = np.concatenate([history.speed, history.ball_speed_in_space.ravel()])
    drawn = drawn[np.isfinite(drawn)]
    if not drawn.size:
        return 0.0, 1.0
    rotor = history.speed[np.isfinite(history.speed)]
    usual = np.concatenate([rotor, np.quantile(drawn, [RARE, 1.0 - RARE])])
    shown = usual if np.ptp(drawn) > 3.0 * np.ptp(usual) > 0.0 else drawn
    return float(shown.min()), float(shown.max())


def _near(levels: Sequence[float], apart: float) -> list[list[float]]:
    """Ascending levels, those too near to each other for labels of their own in one group."""
    groups: list[list[float]] = []
    for level in levels:
        if groups and level - groups[-1][-1] < apart:
            groups[-1].append(level)
        else:
            groups.append([level])
    return groups


def _listed(words: Sequence[str]) -> str:
    *others, last = words
    return f"{', '.join(others)} and {last}" if others else last


def _main_label(deflections: Deflections, brief: bool) -> str:
    """The legend of the reference place."""
    if brief:
        return "with static part" if deflections.static else deflections.name or "greatest"
    name = f", {deflections.name}" if deflections.name else ""
    return f"greatest{name}" if deflections.is_envelope else f"deflection{name}"


def _curve_label(curve: Curve, deflections: Deflections, brief: bool) -> str:
    """The legend of another place, or of the vibration of any place about where it rests."""
    if brief or not deflections.static:
        return curve.name or "vibration"
    side = f"{np.rad2deg(np.angle(deflections.static)):.0f}°".replace("-", "−")
    about = f"about {length_text(abs(deflections.static))} at {side}" if curve is deflections.curves[0] else ""
    return " ".join(word for word in ("vibration", curve.name, about) if word)


def _least_of(values: np.ndarray, otherwise: float) -> float:
    return float(np.nanmin(values[values > 0.0], initial=otherwise))


def _width(number: int, count: int) -> float:
    """Balls that move together stay visible together: the first is drawn broad below the others."""
    return 2.2 if number == 0 and 1 < count <= 6 else 1.2
