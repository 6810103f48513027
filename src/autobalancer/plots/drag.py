"""Drag coefficients against the Reynolds number."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from numpy.typing import NDArray
from scipy.interpolate import RectBivariateSpline

from autobalancer import drag
from autobalancer.arrays import Floats
from autobalancer.errors import QuestionError, one_of
from autobalancer.laws.drag_coefficient import DragLaw, SampledLaw, TableLaw
from autobalancer.plots.style import BALLS, CRITICAL, FILL, INK, UNBALANCE, ball_color, heading, legend, look, picture
from autobalancer.results.display_units import AxisUnit, speed_axis
from autobalancer.units import list_argument, optional_argument

LINES = ("-", (0, (6, 2)), (0, (5, 1.5, 1, 1.5)), (0, (1, 1.2)))


def drag_laws(
    laws: Sequence[DragLaw] | None = None, *, first: float = 0.1, last: float = 1e6, labels: Sequence[str] | None = None
) -> Figure:
    """Draw c_d, and below it c_d Re, which is a constant where the drag is linear.

    Dotted: beyond the range of a law, where its coefficient is kept constant. The points of a table are marked.

    Parameters
    ----------
    laws
        Such as :func:`sphere_on_plane`; by default all that need no further parameter.
    first, last
        Reynolds numbers between which.
    labels
        One for each law, by default its name and plateau.

    Raises
    ------
    QuestionError
        If there is no law, too few labels, or the range is empty.
    """
    laws = drag.drag_laws() if laws is None else tuple(laws)
    if not laws or (labels is not None and len(labels) != len(laws)):
        raise QuestionError(
            f"plot.drag_laws: given {len(laws)} laws and {len(labels or laws)} labels; give a label for each"
        )
    if not 0.0 < first < last:
        raise QuestionError(
            f"plot.drag_laws: given Reynolds numbers from {first:g} to {last:g}; they must increase from above 0"
        )
    names = list(labels) if labels is not None else [_label(law) for law in laws]
    with look():
        figure = picture(7.2, 6.4)
        upper, lower = figure.subplots(2, 1, sharex=True, gridspec_kw={"height_ratios": [3, 2]})
        for number, (law, name) in enumerate(zip(laws, names, strict=True)):
            color, line = BALLS[number % len(BALLS)], LINES[number // len(BALLS) % len(LINES)]
            inside = np.geomspace(first, max(min(last, law.highest), first), 600)
            beyond = np.geomspace(max(law.highest, first), last, 60) if law.highest < last else np.empty(0)
            for axes, power in ((upper, 1.0), (lower, 0.0)):
                axes.plot(inside, law.product(inside) / inside**power, color=color, ls=line, lw=1.7, label=name)
                axes.plot(beyond, law.product(beyond) / beyond**power, color=color, ls=(0, (1, 2)), lw=1.1)
                if isinstance(law, TableLaw) and not isinstance(law, SampledLaw):
                    re = np.array(law.reynolds)
                    axes.plot(re, law.product(re) / re**power, "o", ms=3.5, color=color)
        _axes(upper, "drag coefficient $c_d$")
        _axes(lower, r"$c_d\,\mathrm{Re}$")
        lower.set(ylim=(10.0, 3e4), xlim=(first, last), xlabel="Reynolds number of the ball")
        upper.legend(loc="upper right")
    return figure


def _label(law: DragLaw) -> str:
    plateau = float(law.product(law.kept_from)) / law.kept_from
    return f"{law.name.replace('_', ' ')}, {law.cd_times_re:.4g}/Re to {plateau:.2g}"


def _axes(axes: Axes, label: str) -> None:
    axes.set(xscale="log", yscale="log", ylabel=label)


# The flow around a ball in its race, and its drag over the Reynolds number.


def ball_drag(found: xr.Dataset) -> Figure:
    """Draw the flow in the plane of the ball centers, seen from the ball, and c_d Re over the Reynolds number.

    Parameters
    ----------
    found
        From :func:`~autobalancer.flow.ball_drag`; the flow is that at its last Reynolds number.

    Returns
    -------
    matplotlib.figure.Figure
    """
    moving = found["reynolds"].values > 0.0
    with look():
        figure = picture(8.2, 6.4 if moving.any() else 3.6)
        panels = figure.subplots(
            2 if moving.any() else 1, 1, squeeze=False, height_ratios=[1.25, 1][: 1 + moving.any()]
        )
        _flow(figure, panels[0, 0], found)
        if moving.any():
            _curve(panels[1, 0], found, moving)
        heading(figure, str(found.attrs["title"]))
    return figure


def _flow(figure: Figure, axes: Axes, dataset: xr.Dataset) -> None:
    x, y = dataset["x"].values * 1e3, dataset["y"].values * 1e3
    u, v = dataset["velocity_x"].values.T, dataset["velocity_y"].values.T
    speed = np.ma.masked_invalid(np.hypot(u, v))
    shade = axes.pcolormesh(x, y, speed, cmap="cividis", shading="gouraud", rasterized=True, vmin=0.0)
    axes.streamplot(
        x,
        y,
        np.ma.masked_invalid(u),
        np.ma.masked_invalid(v),
        color="white",
        linewidth=0.7,
        density=(1.6, 0.9),
        arrowsize=0.7,
    )
    radius = 0.5e3 * float(dataset.attrs["ball_diameter"])
    for center in _centers(dataset):
        axes.add_patch(Circle(center, radius, facecolor=FILL, edgecolor=INK, lw=0.9, zorder=5))
    for wall, beyond in zip(_walls(dataset, x), (y[0] - radius, y[-1] + radius), strict=True):
        axes.fill_between(x, wall, beyond, color="white", lw=0.0, zorder=2.2)
        axes.plot(x, wall, color=INK, lw=1.6, zorder=2.3)
    axes.set_aspect("equal")
    axes.grid(False)
    axes.set(
        xlim=(x[0], x[-1]),
        ylim=(y[0] - 0.05 * radius, y[-1] + 0.05 * radius),
        xlabel="ahead of the ball (mm); outer wall below",
        ylabel="inward (mm)",
    )
    axes.set_title(f"seen from the ball, Re = {float(dataset['reynolds'][-1]):.4g}", fontsize=9.0)
    figure.colorbar(shade, ax=axes, label="speed over that of the ball", shrink=0.8)


def _centers(dataset: xr.Dataset) -> list[tuple[float, float]]:
    """Of the balls, mm."""
    orbit, along = 1e3 * float(dataset.attrs["orbit_radius"]), 1e3 * float(dataset.attrs["ball_ahead"])
    if np.isnan(along):
        return [(0.0, 0.0)]
    angle = along / orbit
    return [(0.0, 0.0), (orbit * np.sin(angle), orbit * (1.0 - np.cos(angle))) if np.isfinite(orbit) else (along, 0.0)]


def _walls(dataset: xr.Dataset, x: Floats) -> list[Floats]:
    """Both walls over x, mm."""
    attrs = dataset.attrs
    radius, orbit = 0.5e3 * float(attrs["ball_diameter"]), 1e3 * float(attrs["orbit_radius"])
    outer = radius * (1.0 + float(attrs["mesh_gap"]))
    depths = [0.0, 1e3 * float(attrs["width"])]
    if not np.isfinite(orbit):
        return [np.full(x.size, depth - outer) for depth in depths]
    return [orbit - np.sqrt(np.maximum((orbit + outer - depth) ** 2 - x**2, 0.0)) for depth in depths]


def _curve(axes: Axes, dataset: xr.Dataset, moving: NDArray[np.bool_]) -> None:
    re, cd_times_re = dataset["reynolds"].values, dataset["cd_times_re"].values
    axes.plot(re[moving], cd_times_re[moving], "o-", color=ball_color(0), label="with inertia of the fluid")
    if not moving.all():
        axes.axhline(cd_times_re[0], color=INK, ls="--", lw=0.9, label="without")
    axes.set_xscale("log")
    axes.set_xticks(re[moving], [f"{number:.4g}" for number in re[moving]])
    axes.minorticks_off()
    axes.set(
        ylim=(0.0, 1.15 * float(cd_times_re.max())), xlabel="Reynolds number of the ball", ylabel=r"$c_d\,\mathrm{Re}$"
    )
    axes.set_title(f"gap of {1e6 * float(dataset.attrs['gap']):.3g} µm", fontsize=9.0)
    axes.legend(loc="lower left")


# Pictures of the equilibrium-angle experiment: the angle over the speed, and the drag that measured angles say.


MARKS = ("o", "s", "^", "v", "D", "P")


def equilibrium_angle(found: xr.Dataset, *, speed_unit: str = "rpm") -> Figure:
    """The angle from the lowest point over the speed, by statics and, if available, by simulation.

    Parameters
    ----------
    found
        From ``ab.measure.equilibrium_angle``.
    speed_unit
        rpm, rad/s or Hz.

    Raises
    ------
    QuestionError
        If the unit is not known.
    """
    unit = speed_axis(speed_unit)
    speed = unit.factor * found["speed"].values
    with look():
        figure = picture(6.4, 4.0)
        axes = figure.subplots()
        axes.plot(speed, np.degrees(found["angle"]), color=INK, label="statics")
        pressed = np.degrees(found["angle_with_pressure"])
        axes.plot(speed, pressed, color=CRITICAL, ls=(0, (5, 3)), label="with the pressure of the turning fluid")
        if "simulated_angle" in found:
            axes.plot(speed, np.degrees(found["simulated_angle"]), "o", ms=3.5, color=BALLS[0], label="simulated")
        legend(axes)
        _angles(axes, unit)
        axes.set_xlim(0.0, None)
    return figure


def measured_drag(found: xr.Dataset, *, pressure_force: str = "left out", speed_unit: str = "rpm") -> Figure:
    """Drag coefficients from measured angles against the law of the machine, and the angles themselves.

    Parameters
    ----------
    found
        From :func:`~autobalancer.measurement.equilibrium_angles.evaluate_angles`.
    pressure_force
        Of the turning fluid: "left out", as in (6.6) of Spannan (2021), or "included".
    speed_unit
        rpm, rad/s or Hz.

    Raises
    ------
    QuestionError
        If a choice or unit is not known.
    """
    one_of("pressure_force", pressure_force, *found["pressure_force"].values.tolist())
    unit, one = speed_axis(speed_unit), found.sel(pressure_force=pressure_force).sortby("reynolds")
    names = list(dict.fromkeys(found["series"].values.tolist()))
    with look():
        figure = picture(9.2, 4.4)
        left, right = figure.subplots(1, 2)
        left.plot(one["reynolds"], one["law_coefficient"], color=INK, lw=1.0, label=f"law: {found.attrs['drag_law']}")
        for number, name in enumerate(names):
            points = one.isel(point=np.flatnonzero(one["series"].values == name))
            color, mark = BALLS[number % len(BALLS)], MARKS[number // len(BALLS) % len(MARKS)]
            seen = points["drag_coefficient"] > 0.0
            left.plot(points["reynolds"][seen], points["drag_coefficient"][seen], mark, ms=3.5, color=color, label=name)
            speed = unit.factor * points["speed"].values
            right.plot(speed, np.degrees(points["measured_angle"]), mark, ms=3.5, color=color)
            right.plot(speed, np.degrees(points["angle"]), color=color, lw=0.9)
        left.set(xscale="log", yscale="log", xlabel="Reynolds number", ylabel="drag coefficient $c_d$")
        coefficient, deviation = (float(one[f"rolling_resistance{end}"]) for end in ("", "_deviation"))
        text = f"{coefficient:.3g}" + (f" ± {deviation:.1g}" if np.isfinite(deviation) else "")
        left.set_title(f"rolling resistance {text}, {found.attrs['rolling_resistance_from']}")
        right.set(xscale="log", title=f"lines: law, pressure force {pressure_force}")
        _angles(right, unit)
        figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure


def _angles(axes: Axes, unit: AxisUnit) -> None:
    axes.axhline(90.0, color=CRITICAL, lw=0.8, ls=(0, (2, 2)))
    axes.set(xlabel=f"rotor speed ({unit.sign})", ylabel="angle from the lowest point (°)", ylim=(0.0, 95.0))
    axes.set_yticks(range(0, 91, 15))


# The flow in an annulus: profiles over the gap, secondary flow, spin-up.


STREAM_LINES = 7  # in each direction of circulation
MODELS = {
    "chebyshev": "Chebyshev collocation",
    "differences": "finite differences",
    "modes": "diffusion modes",
    "azimuthal": "without secondary flow",
}
FINE = 161  # points of a drawn line: those of the solver are few and far between in the middle


def flow(flow: xr.Dataset, *, time: float | str | None = None, speed_unit: str = "rpm") -> Figure:
    """Draw spin-up history, velocity profiles and secondary flow in one picture.

    Parameters
    ----------
    flow
        From :func:`annulus_flow`.
    time
        Of the secondary flow, s; one of the moments of the result, by default the one with the strongest circulation.
    speed_unit
        ``"rpm"``, ``"rad/s"`` or ``"Hz"``.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    QuestionError
        If the result has no field at ``time``, or the unit is unknown.
    """
    time = optional_argument("time", time, "s")
    with look():
        figure = picture(9.6, 6.4)
        panels = figure.subplots(2, 2, width_ratios=(1.4, 1.0))
        _history(panels[0, 0], flow, speed_unit)
        _lag(panels[1, 0], flow, speed_unit)
        _profiles(panels[0, 1], flow)
        _stream_lines(figure, panels[1, 1], flow, _moment(flow, time), speed_unit)
        heading(figure, f"{flow.attrs['title']} ({MODELS.get(flow.attrs['model'], flow.attrs['model'])})")
    return figure


def spin_up(flow: xr.Dataset, *, speed_unit: str = "rpm") -> Figure:
    """Draw the speed of the rotor and of the fluid at the orbit over time, with diffusion alone for comparison.

    ``flow`` is a result of :func:`annulus_flow`; ``speed_unit`` is ``"rpm"``, ``"rad/s"`` or ``"Hz"``.
    """
    with look():
        figure = picture(7.4, 5.4)
        upper, lower = figure.subplots(2, 1, sharex=True)
        _history(upper, flow, speed_unit)
        _lag(lower, flow, speed_unit)
        heading(figure, str(flow.attrs["title"]))
    return figure


def velocity_profiles(flow: xr.Dataset, *, moments: Sequence[float | str] | None = None) -> Figure:
    """Draw the azimuthal velocity over the gap at mid-height at several times, over that of the outer wall.

    ``moments`` (s) are a choice of those of ``flow``, a result of :func:`annulus_flow`.
    The dashed line is solid rotation (Spannan 2021, figure 5.6a); where the
    rotor speeds up the fluid lags behind in the middle of the gap (5.6b).
    """
    moments = None if moments is None else list_argument("moments", moments, "s")
    with look():
        figure = picture(6.0, 4.4)
        axes = figure.subplots()
        chosen = flow if moments is None else flow.isel(moment=[_moment(flow, t) for t in moments])
        _profiles(axes, chosen)
        heading(figure, str(flow.attrs["title"]))
    return figure


def secondary_flow(flow: xr.Dataset, *, time: float | str | None = None, speed_unit: str = "rpm") -> Figure:
    """Draw stream lines in the cross-section at one time, colored with the lag of the fluid behind the rotor.

    ``time`` (s) is one of ``flow``, a result of :func:`annulus_flow`; by default that of the strongest stream.
    ``speed_unit`` is ``"rpm"``, ``"rad/s"`` or ``"Hz"``.
    """
    time = optional_argument("time", time, "s")
    with look():
        figure = picture(6.4, 5.4)
        _stream_lines(figure, figure.subplots(), flow, _moment(flow, time), speed_unit)
        heading(figure, str(flow.attrs["title"]))
    return figure


def _moment(flow: xr.Dataset, time: float | None) -> int:
    moments = flow["moment"].values
    if time is None:
        return int(np.abs(flow["stream_function"].values).max(axis=(1, 2)).argmax())
    near = int(np.abs(moments - time).argmin())
    if abs(moments[near] - time) > 1e-9 * max(abs(time), 1.0):
        known = ", ".join(f"{t:g}" for t in moments)
        raise QuestionError(f"time: given {time:g} s; the result has fields at {known} s; ask annulus_flow for 'times'")
    return near


def _history(axes: Axes, flow: xr.Dataset, speed_unit: str) -> None:
    unit, time = speed_axis(speed_unit), flow["time"].values
    axes.plot(time, flow["speed"] * unit.factor, color=INK, label="rotor")
    axes.plot(time, flow["fluid_speed"] * unit.factor, color=ball_color(0), label="fluid at the orbit")
    axes.plot(time, flow["diffusion_speed"] * unit.factor, "--", color=CRITICAL, lw=1.0, label=_compared(flow))
    axes.set(ylabel=f"speed ({unit.sign})", xlabel="time (s)")
    legend(axes)


def _compared(flow: xr.Dataset) -> str:
    return "viscosity at rest" if flow.attrs["model"] == "azimuthal" else "diffusion alone"


def _lag(axes: Axes, flow: xr.Dataset, speed_unit: str) -> None:
    unit, time = speed_axis(speed_unit), flow["time"].values
    for name, style, color in (("fluid_speed", "-", ball_color(0)), ("diffusion_speed", "--", CRITICAL)):
        axes.plot(time, (flow["speed"] - flow[name]) * unit.factor, style, color=color)
    _uncertainty(axes, flow)
    axes.set(ylabel=f"lag behind the rotor ({unit.sign})", xlabel="time (s)")


def _uncertainty(axes: Axes, flow: xr.Dataset) -> None:
    """Say how far two grids of an unsteady flow differ."""
    share = float(flow.attrs.get("uncertainty", np.nan))
    if share > 0.0:
        text = f"uncertain: two grids differ by up to {100.0 * share:.2g} % of the greatest speed"
        axes.annotate(text, (0.99, 0.95), xycoords="axes fraction", ha="right", va="top", fontsize=8.5, color=INK)


def _smooth(flow: xr.Dataset, field: str, moment: int) -> tuple[NDArray[np.float64], ...]:
    """Radius, height and a field on a fine grid."""
    r, z = flow["radius"].values, flow["height"].values
    radius, height = np.linspace(r[0], r[-1], FINE), np.linspace(z[0], z[-1], FINE)
    return radius, height, RectBivariateSpline(r, z, flow[field].values[moment])(radius, height)


def _profiles(axes: Axes, flow: xr.Dataset) -> None:
    radius = np.linspace(flow.attrs["inner"], flow.attrs["outer"], FINE)
    colors = matplotlib.colormaps["viridis"](np.linspace(0.0, 0.88, flow.sizes["moment"]))
    speeds = flow["moment_speed"].values
    for i, color in enumerate(colors):
        if speeds[i] == 0.0:
            continue
        swirl = _smooth(flow, "fluid_angular_velocity", i)[2][:, FINE // 2]
        axes.plot(
            radius * 1e3,
            swirl * radius / (speeds[i] * radius[-1]),
            color=color,
            label=f"{float(flow['moment'][i]):.3g} s",
        )
    axes.plot(radius * 1e3, radius / radius[-1], "--", color=INK, lw=0.9, label="rigid rotation")
    axes.axvline(flow.attrs["orbit_radius"] * 1e3, color=UNBALANCE, lw=0.8, ls=":", zorder=0.5)
    axes.set(xlabel="radius (mm); dotted: orbit of the balls", ylabel="velocity over that of the outer wall")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4, fontsize=7.5)


def _stream_lines(figure: Figure, axes: Axes, flow: xr.Dataset, moment: int, speed_unit: str) -> None:
    unit = speed_axis(speed_unit)
    radius, height, swirl = _smooth(flow, "fluid_angular_velocity", moment)
    psi = _smooth(flow, "stream_function", moment)[2]
    r, z = radius * 1e3, height * 1e3
    lag = (float(flow["moment_speed"][moment]) - swirl) * unit.factor
    shade = axes.pcolormesh(r, z, lag.T, cmap="cividis_r", shading="gouraud", rasterized=True)
    most = float(np.abs(psi).max())
    if most > 0.0:
        levels = most * np.linspace(-1.0, 1.0, 2 * STREAM_LINES + 2)[1:-1]
        axes.contour(r, z, psi.T, levels=levels, colors=INK, linewidths=0.8, negative_linestyles="solid")
    axes.plot(flow.attrs["orbit_radius"] * 1e3, 0.5 * z[-1], "+", ms=9, mew=1.4, color=UNBALANCE)
    axes.set_aspect("equal")
    axes.grid(False)
    axes.set(xlabel="radius (mm)", ylabel="height (mm)")
    axes.set_title(f"stream lines at {float(flow['moment'][moment]):.4g} s", fontsize=9.0)
    figure.colorbar(shade, ax=axes, label=f"lag ({unit.sign})")
