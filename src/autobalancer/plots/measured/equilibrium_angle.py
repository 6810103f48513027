"""Pictures of the equilibrium-angle experiment: the angle over the speed, and the drag that measured angles say."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from autobalancer.errors import QuestionError
from autobalancer.plots.drawing.style import BALLS, CRITICAL, INK, legend, look, picture
from autobalancer.results.display_units import AxisUnit, speed_axis
from autobalancer.results.given import Given, result

MARKS = ("o", "s", "^", "v", "D", "P")


def equilibrium_angle(found: Given, *, speed_unit: str = "rpm") -> Figure:
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
        If ``found`` is no such result or the unit is not known.
    """
    found = result(found, "plot.equilibrium_angle", "measure.equilibrium_angle", lambda it: "angle_with_pressure" in it)
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


def measured_drag(found: Given, *, pressure_force: str = "left out", speed_unit: str = "rpm") -> Figure:
    """Drag coefficients from measured angles against the law of the machine, and the angles themselves.

    Parameters
    ----------
    found
        From :func:`~autobalancer.measurement.angle.evaluation.evaluate_angles`.
    pressure_force
        Of the turning fluid: "left out", as in (6.6) of Spannan (2021), or "included".
    speed_unit
        rpm, rad/s or Hz.

    Raises
    ------
    QuestionError
        If ``found`` is no such result, or a choice or unit is not known.
    """
    found = result(found, "plot.measured_drag", "measure.evaluate_angles", lambda it: "measured_angle" in it)
    if pressure_force not in found["pressure_force"].values:
        raise QuestionError(f"pressure_force: given {pressure_force!r}; must be 'left out' or 'included'")
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
        right.set_xscale("log")
        right.set_title(f"lines: law, pressure force {pressure_force}")
        _angles(right, unit)
        figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure


def _angles(axes: Axes, unit: AxisUnit) -> None:
    axes.axhline(90.0, color=CRITICAL, lw=0.8, ls=(0, (2, 2)))
    axes.set(xlabel=f"rotor speed ({unit.sign})", ylabel="angle from the lowest point (°)", ylim=(0.0, 95.0))
    axes.set_yticks(range(0, 91, 15))
