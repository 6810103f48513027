"""The flow in an annulus: profiles over the gap, secondary flow, spin-up."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.interpolate import RectBivariateSpline

from autobalancer.errors import QuestionError
from autobalancer.plots.drawing.style import CRITICAL, INK, UNBALANCE, ball_color, heading, legend, look, picture
from autobalancer.results.display_units import speed_axis
from autobalancer.results.run_argument import Given, result
from autobalancer.units import list_argument, optional_argument

STREAM_LINES = 7  # in each direction of circulation
MODELS = {
    "chebyshev": "Chebyshev collocation",
    "differences": "finite differences",
    "modes": "diffusion modes",
    "azimuthal": "without secondary flow",
}
FINE = 161  # points of a drawn line: those of the solver are few and far between in the middle


def flow(flow: Given, *, time: float | str | None = None, speed_unit: str = "rpm") -> Figure:
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
    flow = result(flow, "plot.flow", "flow.annulus_flow", _is_flow)
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


def spin_up(flow: Given, *, speed_unit: str = "rpm") -> Figure:
    """Draw the speed of the rotor and of the fluid at the orbit over time, with diffusion alone for comparison.

    ``flow`` is a result of :func:`annulus_flow`; ``speed_unit`` is ``"rpm"``, ``"rad/s"`` or ``"Hz"``.
    """
    flow = result(flow, "plot.spin_up", "flow.annulus_flow", _is_flow)
    with look():
        figure = picture(7.4, 5.4)
        upper, lower = figure.subplots(2, 1, sharex=True)
        _history(upper, flow, speed_unit)
        _lag(lower, flow, speed_unit)
        heading(figure, str(flow.attrs["title"]))
    return figure


def velocity_profiles(flow: Given, *, moments: Sequence[float | str] | None = None) -> Figure:
    """Draw the azimuthal velocity over the gap at mid-height at several times, over that of the outer wall.

    ``moments`` (s) are a choice of those of ``flow``, a result of :func:`annulus_flow`.
    The dashed line is solid rotation (Spannan 2021, figure 5.6a); where the
    rotor speeds up the fluid lags behind in the middle of the gap (5.6b).
    """
    flow = result(flow, "plot.velocity_profiles", "flow.annulus_flow", _is_flow)
    moments = None if moments is None else list_argument("moments", moments, "s")
    with look():
        figure = picture(6.0, 4.4)
        axes = figure.subplots()
        chosen = flow if moments is None else flow.isel(moment=[_moment(flow, t) for t in moments])
        _profiles(axes, chosen)
        heading(figure, str(flow.attrs["title"]))
    return figure


def secondary_flow(flow: Given, *, time: float | str | None = None, speed_unit: str = "rpm") -> Figure:
    """Draw stream lines in the cross-section at one time, colored with the lag of the fluid behind the rotor.

    ``time`` (s) is one of ``flow``, a result of :func:`annulus_flow`; by default that of the strongest stream.
    ``speed_unit`` is ``"rpm"``, ``"rad/s"`` or ``"Hz"``.
    """
    flow = result(flow, "plot.secondary_flow", "flow.annulus_flow", _is_flow)
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
    axes.set_ylabel(f"speed ({unit.sign})")
    axes.set_xlabel("time (s)")
    legend(axes)


def _compared(flow: xr.Dataset) -> str:
    return "viscosity at rest" if flow.attrs["model"] == "azimuthal" else "diffusion alone"


def _lag(axes: Axes, flow: xr.Dataset, speed_unit: str) -> None:
    unit, time = speed_axis(speed_unit), flow["time"].values
    for name, style, color in (("fluid_speed", "-", ball_color(0)), ("diffusion_speed", "--", CRITICAL)):
        axes.plot(time, (flow["speed"] - flow[name]) * unit.factor, style, color=color)
    _uncertainty(axes, flow)
    axes.set_ylabel(f"lag behind the rotor ({unit.sign})")
    axes.set_xlabel("time (s)")


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
    axes.set_xlabel("radius (mm); dotted: orbit of the balls")
    axes.set_ylabel("velocity over that of the outer wall")
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
    axes.set_xlabel("radius (mm)")
    axes.set_ylabel("height (mm)")
    axes.set_title(f"stream lines at {float(flow['moment'][moment]):.4g} s", fontsize=9.0)
    figure.colorbar(shade, ax=axes, label=f"lag ({unit.sign})")


def _is_flow(dataset: xr.Dataset) -> bool:
    return "fluid_speed" in dataset and "moment" in dataset.dims
