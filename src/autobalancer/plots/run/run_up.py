"""The chart of a run-up: speeds, deflection and ball angles over one time axis."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from autobalancer.errors import QuestionError
from autobalancer.plots.run.history import (
    SAVE_MORE,
    BallLook,
    CriticalSpeeds,
    Curve,
    Deflections,
    History,
    ball_looks,
    critical_speeds_of,
    deflections_of,
    history_of,
    passages,
    planes_of,
    quiet,
    span_of,
)
from autobalancer.plots.style import (
    BALLS,
    CRITICAL,
    FILL,
    INK,
    UNBALANCE,
    heading,
    label_level,
    label_point,
    legend,
    look,
    picture,
    plain_log_ticks,
    slipping,
    wrapped,
)
from autobalancer.results.display_units import (
    EACH_ITS_OWN,
    AxisUnit,
    length_axis,
    length_text,
    length_tick,
    significant,
    speed_axis,
)
from autobalancer.results.run_argument import RunArgument, load_race_run
from autobalancer.results.run_arrays import Impacts, impacts_of
from autobalancer.results.time_series import crests
from autobalancer.units import optional_argument


def run_up(
    run: RunArgument,
    *,
    speed_unit: str = "rpm",
    deflection_unit: str | None = None,
    log: bool | None = None,
    start: float | str | None = None,
    end: float | str | None = None,
    held: xr.Dataset | None = None,
) -> Figure:
    """Draw a run over time: speeds of rotor and balls, deflection of the rotor, and ball angles.

    The upper panel has the rotor speed and the absolute speed of each ball, so that balls stalled at the critical
    speed leave the line of the rotor. The middle one shades the deflection between the least and the greatest value of
    each bin of the envelope. On a rotor that tilts or bends it also has the deflection of the other planes of balancers
    and stations, from samples; under gravity the vibration about the static deflection. The lower ones, one for each
    plane, have the ball angles in the rotor from its zero mark, within ±180 degrees, with the unbalance in this plane and
    its opposite; while a ball circles in the rotor its line is pale. Critical speeds are drawn if
    ``run.attrs["critical_speeds"]`` (rad/s) has them, dotted where they are passed; the label says so if they
    are those of small motions, because the stiffness depends on the deflection.

    Parameters
    ----------
    run
        From :func:`simulate` or :func:`load_run`, with samples, an envelope, or both.
    speed_unit
        ``"rpm"``, ``"rad/s"`` or ``"Hz"``.
    deflection_unit
        ``"m"``, ``"mm"``, ``"um"`` or ``"nm"``; by default the one that suits the greatest deflection; on a logarithmic
        axis each tick has its own.
    log
        Whether the deflection axis is logarithmic, which shows how well the balls balance in the end; by default where
        the end is below 5 % of the greatest deflection.
    start, end
        Part of the run to be drawn, s; by default all of it.
    held
        The same machine without balancing, from ``simulate(machine, hold_balls=True)``, drawn dashed. Without it the
        dashed line is its vibration at the last speed.

    Returns
    -------
    matplotlib.figure.Figure
        Save it with ``savefig`` or show it in a notebook.

    Raises
    ------
    QuestionError
        If the run has nothing to be drawn, a unit is unknown, or the interval is outside the run.
    """
    run = load_race_run(run, "plot.run_up")
    start = optional_argument("start", start, "s")
    end = optional_argument("end", end, "s")
    speeds = speed_axis(speed_unit)
    first, last = span_of(run, start, end)
    history, deflections = history_of(run, first, last), deflections_of(run, first, last, held)
    if history is not None and not history.time.size:
        history = None
    if deflections is not None and not deflections.time.size:
        deflections = None
    if history is None and deflections is None:
        raise QuestionError(f"the run has neither speed nor deflection between {first:g} s and {last:g} s; {SAVE_MORE}")
    greatest = float(np.nanmax(deflections.high, initial=0.0)) if deflections is not None else 0.0
    logarithmic = deflections is not None and (quiet(deflections) if log is None else log)
    lengths = EACH_ITS_OWN if logarithmic and not deflection_unit else length_axis(deflection_unit, greatest)
    planes = _planes_with_balls(run) if history is not None and history.ball_angle_in_rotor.shape[1] else []
    heights = [1.0] * (history is not None) + [1.0] * (deflections is not None) + [0.9] * len(planes)
    with look():
        figure = picture(8.0, 0.5 + 2.3 * sum(heights))
        panels = list(figure.subplots(len(heights), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0])
        critical, looks = critical_speeds_of(run), ball_looks(run)
        if history is not None:
            _passages(panels, history, critical)
            speed_panel(panels[0], history, critical, speeds, looks)
        if deflections is not None:
            deflection_panel(panels[1 if history is not None else 0], deflections, lengths, log=logarithmic)
        for panel, (plane, name, balls) in zip(panels[len(panels) - len(planes) :], planes, strict=True):
            assert history is not None
            angle_panel(panel, history, looks, plane=plane, balls=balls, name=name)
        panels[-1].set(xlabel="time (s)", xlim=(first, last))
        figure.align_ylabels(panels)
        heading(figure, str(run.attrs.get("title", "Run")))
    return figure


def _passages(panels: list[Axes], history: History, critical: CriticalSpeeds) -> None:
    """Dotted lines where critical speeds are passed."""
    moments = [moment for level in critical.levels for moment in passages(history.time, history.speed, level)]
    for number, moment in enumerate(moments):
        for panel in panels:
            label = f"critical speed{critical.of} passed" if panel is panels[0] and number == 0 else "_passed"
            panel.axvline(moment, color=CRITICAL, lw=0.9, ls=(0, (1, 2)), zorder=1.5, label=label)


def _planes_with_balls(run: xr.Dataset) -> list[tuple[int, str, list[int]]]:
    """Number, name and balls of each plane; one without a name if all balls are in one."""
    count = run.sizes["ball"]
    where = run["ball_plane"].values - 1 if "ball_plane" in run else np.zeros(count, np.int64)
    names = planes_of(run).names
    if len(names) == 1:
        return [(0, "", list(range(count)))]
    return [
        (plane, name, np.flatnonzero(where == plane).tolist()) for plane, name in enumerate(names) if plane in where
    ]


# The panels of a chart over time, shared by pictures and films.


RARE = 0.002  # of all speeds of balls; if these alone make the axis three times longer they leave the picture
SAME = 1e-6  # of the speed: what differs less is one line, not the rounding of the run enlarged
NEAR = 0.15  # of the speed axis: a label is an eighth of the lowest panel
PLACES = (BALLS[0], BALLS[1], BALLS[2], BALLS[3], BALLS[4], BALLS[5])  # colors of the deflection at other places


def speed_panel(
    axes: Axes, history: History, critical: CriticalSpeeds, unit: AxisUnit, looks: Sequence[BallLook]
) -> None:
    """Rotor speed, absolute ball speeds and critical speeds: where balls stall, they leave the rotor's line."""
    least, most = _speed_range(history)
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
        least = min(float(np.nanmin(values[values > 0.0], initial=greatest)) for values in every)
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
        instant = bool(np.ptp(without.time) < 0.01 * np.ptp(time))
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
    axes.set(
        ylim=(-186.0, 186.0),
        yticks=[-180, -90, 0, 90, 180],
        ylabel=f"ball angle in the rotor (°)\n{name}" if name else "ball angle in the rotor (°)",
    )
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


def _speed_range(history: History) -> tuple[float, float]:
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


def _width(number: int, count: int) -> float:
    """Balls that move together stay visible together: the first is drawn broad below the others."""
    return 2.2 if number == 0 and 1 < count <= 6 else 1.2


# The noise of balls: their impacts over a run.


PARTS = 80  # of the time, in each of which the power is a mean
KINDS = ((1, np.inf, "of two balls", BALLS[0]), (0, 0, "on a partition", BALLS[2]), (-1, -1, "on a wall", BALLS[1]))
POWERS = ((1e-6, "µW", 1e6), (1e-3, "mW", 1e3), (np.inf, "W", 1.0))  # up to a thousand of each


def impacts(
    run: xr.Dataset, *, speed_unit: str = "rpm", start: float | str | None = None, end: float | str | None = None
) -> Figure:
    """Draw the impacts of a run over time: how fast balls hit each other and walls, and the power they dissipate.

    The upper panel has the speeds of rotor and balls, as that of a run-up; the lowest one the mean power in eighty parts of
    the time.

    Parameters
    ----------
    run
        From :func:`simulate` or :func:`load_run`, of balls that touch.
    speed_unit
        ``"rpm"``, ``"rad/s"`` or ``"Hz"``.
    start, end
        Part of the run to be drawn, s; by default all of it.

    Raises
    ------
    QuestionError
        If nothing touched in the run, a unit is unknown, or the interval is outside the run.
    """
    first, last = span_of(run, optional_argument("start", start, "s"), optional_argument("end", end, "s"))
    impacts, speeds, history = impacts_of(run), speed_axis(speed_unit), history_of(run, first, last)
    assert impacts is not None
    with look():
        figure = picture(8.0, 6.6 if history is not None else 4.6)
        panels = list(figure.subplots(2 + (history is not None), 1, sharex=True))
        if history is not None:
            speed_panel(panels[0], history, critical_speeds_of(run), speeds, ball_looks(run))
        _speeds(panels[-2], impacts)
        _power(panels[-1], impacts, np.linspace(first, last, PARTS + 1))
        panels[-1].set(xlabel="time (s)", xlim=(first, last))
        figure.align_ylabels(panels)
        heading(figure, str(run.attrs.get("title", "Run")))
    return figure


def _speeds(axes: Axes, impacts: Impacts) -> None:
    for low, high, label, color in KINDS:
        its = (impacts.partner >= low) & (impacts.partner <= high)
        if its.any():
            axes.plot(impacts.time[its], impacts.speed[its], ".", ms=4.0, color=color, alpha=0.7, label=label)
    axes.set(yscale="log", ylabel="impact speed (m/s)")
    legend(axes)


def _power(axes: Axes, impacts: Impacts, edges: np.ndarray[tuple[int], np.dtype[np.float64]]) -> None:
    power = np.histogram(impacts.time, edges, weights=impacts.lost)[0] / np.diff(edges)
    _, sign, factor = next(entry for entry in POWERS if power.max(initial=0.0) < 1e3 * entry[0])
    axes.stairs(factor * power, edges, color=INK, fill=True, alpha=0.75)
    axes.set(ylabel=f"power of impacts ({sign})", ylim=(0.0, None))


# The twist of a drive train over a run.


STATOR = "stator"  # the name of a mount in every run
CHANGING = 0.02  # of its greatest value by which the speed changes where torque over speed is worth a panel


def drive_train(
    run: xr.Dataset, *, speed_unit: str = "rpm", start: float | str | None = None, end: float | str | None = None
) -> Figure:
    """Draw how the drive train of a run twists: speeds, torque and twist of every link over time.

    Where the speed changes, the torque is drawn over the speed as well. The greatest torque of each link has its number, as in
    ``ab.run_measures(run)["peak_torque"]``.

    Parameters
    ----------
    run
        From :func:`simulate` or :func:`load_run`, with samples, of a machine whose drive has couplings or a mount.
    speed_unit
        ``"rpm"``, ``"rad/s"`` or ``"Hz"``.
    start, end
        Part of the run to be drawn, s; by default all of it.

    Raises
    ------
    QuestionError
        If the drive has no link or the run no samples, a unit is unknown, or the interval is outside the run.
    """
    unit = speed_axis(speed_unit)
    first, last = span_of(run, optional_argument("start", start, "s"), optional_argument("end", end, "s"))
    if "link_torque" not in run:
        raise QuestionError(
            f"plot.answer: this run has no twist; give its drive 'couplings' or a 'mount', and {SAVE_MORE}"
        )
    run = run.sel(time=slice(first - 1e-9, last + 1e-9))
    if run.sizes["time"] < 2:
        raise QuestionError(
            f"plot.answer: fewer than two samples from {first:g} s to {last:g} s; ask for a longer part"
        )
    speed = run["speed"].values * unit.factor
    with look():
        changes = float(np.ptp(speed)) > CHANGING * float(np.abs(speed).max())
        figure = picture(8.0, 8.4 if changes else 6.4)
        panels = list(figure.subplots(3 + changes, 1))
        _drive_train_speeds(panels[0], run, unit)
        _links(panels[1], run["time"].values, run["link_torque"], "torque (N m)", peaks=True)
        _links(panels[2], run["time"].values, run["twist"] * (180.0 / np.pi), "twist (°)")
        for axes in panels[:3]:
            axes.set_xlim(first, last)
            axes.tick_params(labelbottom=axes is panels[2])
        panels[2].set_xlabel("time (s)")
        if changes:
            _links(panels[3], speed, run["link_torque"], "torque (N m)")
            panels[3].set_xlabel(f"rotor speed ({unit.sign})")
        figure.align_ylabels(panels)
        heading(figure, str(run.attrs.get("title", "Run")))
    return figure


def _drive_train_speeds(axes: Axes, run: xr.Dataset, unit: AxisUnit) -> None:
    axes.plot(run["time"], run["speed"] * unit.factor, color=INK, lw=3.2, alpha=0.35, label="rotor")
    for i, link in enumerate(run["link"].values):
        if link != STATOR:
            axes.plot(
                run["time"], run["link_speed"][:, i] * unit.factor, color=_color(i), lw=0.9, label=str(link), zorder=3.0
            )
    axes.ticklabel_format(axis="y", useOffset=False)
    axes.set_ylabel(f"speed ({unit.sign})")
    legend(axes)


def _links(axes: Axes, along: np.ndarray, values: xr.DataArray, text: str, peaks: bool = False) -> None:
    for i, link in enumerate(values["link"].values):
        its = values.isel(link=i).values
        axes.plot(along, its, color=_color(i), lw=0.8, label=str(link))
        if peaks:
            (at,), (top,) = crests(along, its[:, None])
            axes.plot(at, top, "o", ms=3.5, color=_color(i))
            label_point(axes, f"{significant(top)} N m".replace("-", "\N{MINUS SIGN}"), at, top, color=_color(i))
    axes.set_ylabel(text)
    if peaks:
        legend(axes)


def _color(number: int) -> str:
    return BALLS[number % len(BALLS)]


# Runs of several machines side by side.


COLUMNS = 2
SHOWN = 1e-5  # of the greatest deflection; what is below it is balanced for every eye


def comparison(found: xr.Dataset) -> Figure:
    """Draw the deflection of each machine over time, with that of the first one behind it.

    Parameters
    ----------
    found
        From :func:`autobalancer.compare`.

    Returns
    -------
    matplotlib.figure.Figure
        One panel for each machine, in the order of the table, on one logarithmic axis of deflection.

    Raises
    ------
    QuestionError
        If there is nothing to draw.
    """
    names, time, high = found["machine"].values, found["time_in_run"].values, found["deflection"].values
    greatest = float(np.nanmax(high, initial=0.0))
    if greatest == 0.0:
        raise QuestionError("plot.answer: no machine was deflected, so there is nothing to draw")
    rows = math.ceil(len(names) / COLUMNS)
    with look():
        figure = picture(8.0, 1.1 + 1.5 * rows)
        panels = figure.subplots(rows, COLUMNS, sharex=True, sharey=True, squeeze=False).ravel()
        for number, (axes, name) in enumerate(zip(panels, names, strict=False)):
            axes.set_yscale("log")
            if number:
                axes.plot(
                    time[0], high[0], color=CRITICAL, lw=0.8, alpha=0.7, label=str(names[0]) if number == 1 else "_"
                )
            axes.plot(time[number], high[number], color=INK, lw=1.2)
            axes.set_title(str(name), fontsize=9.0)
        panels[0].set_ylim(SHOWN * greatest, 2.0 * greatest)
        plain_log_ticks(panels[0], "y", length_tick)
        for axes in panels[len(names) :]:
            axes.set_visible(False)
        for axes in panels[max(len(names) - COLUMNS, 0) : len(names)]:
            axes.set_xlabel("time (s)")
            axes.tick_params(labelbottom=True)
        for axes in panels[::COLUMNS]:
            axes.set_ylabel("deflection")
        if len(names) > 1:
            figure.legend(*panels[1].get_legend_handles_labels(), loc="outside lower center")
        heading(figure, f"{found.attrs['title']}\ngreatest deflection over time, static part included")
    return figure
