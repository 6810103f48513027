"""The page of the balls in their race: force and pressure on the wall, how fast they roll, what rolling asks of friction."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from autobalancer.catalog.resolve import Ball, resolve
from autobalancer.laws.hertz import STEEL, greatest_pressure
from autobalancer.machine import Machine
from autobalancer.reporting.page import Decisive, Paragraph, Rows, Section, yes_or_no
from autobalancer.results.number_text import force_text, significant
from autobalancer.stability.summary.summary import Summary

STATIC = 4.2e9  # Pa, ISO 76: pressure of a point contact at the static load rating of ball bearings
LEAST = 1e-5  # of the rotor speed, below which a slip is none
PRESSED = (
    0.5  # of the lowest critical speed: slower balls are not pressed to the wall well enough for a word on rolling
)


def balls_page(machine: Machine, found: Summary, run: xr.Dataset, command: str) -> Section:
    """Force and pressure between ball and race at the highest speed; slip during a run.

    Parameters
    ----------
    machine, found
        The machine, and what is known of it.
    run
        Its run-up, with samples.
    command
        Makes the run-up again.
    """
    page = Section("Balls in their race", replay=f"autobalancer check machine.toml\n{command}")
    balls = resolve(machine)
    top = found.highest_speed
    if top is None:
        page.blocks.append(Paragraph("Force and pressure are not stated: the drive names no highest speed."))
    else:
        _pressure(page, balls, top)
    _slip(page, balls, found, run)
    return page


def _races(balls: tuple[Ball, ...]) -> dict[str, list[int]]:
    """The balls of each race, counted from 0."""
    found: dict[str, list[int]] = {}
    for number, ball in enumerate(balls):
        found.setdefault(f"balancer {ball.balancer + 1}, race {ball.race + 1}", []).append(number)
    return found


def _pressure(page: Section, balls: tuple[Ball, ...], top: float) -> None:
    rows = []
    for name, numbers in _races(balls).items():
        force, ball = max(
            ((float(balls[i].effective_mass) * float(balls[i].orbit_radius) * top**2, balls[i]) for i in numbers),
            key=lambda one: one[0],
        )
        text = "not known: no diameter"
        if ball.diameter > 0.0:
            radius = 0.5 * float(ball.diameter)
            pressure = greatest_pressure(force, STEEL, radius, float(ball.orbit_radius) + radius)
            text = f"{1e-6 * pressure:.0f} MPa, {100.0 * pressure / STATIC:.3g} % of the static limit of ball bearings (4200 MPa)"
            enough = yes_or_no(pressure <= STATIC)
            page.decisive.append(Decisive(f"pressure of a ball, {name}", text, enough, "the highest speed of the run"))
        rows.append((name, force_text(force), text))
    page.blocks.append(Rows(("race", "greatest force of a ball on the wall", "greatest pressure (Hertz)"), tuple(rows)))
    page.blocks.append(
        Paragraph(
            "A steel ball on a cylindrical steel wall (Johnson 1985); a groove that fits the ball closely lowers the pressure. "
            "Impacts are not counted. Limit: ISO 76."
        )
    )


def _slip(page: Section, balls: tuple[Ball, ...], found: Summary, run: xr.Dataset) -> None:
    """How fast the balls move in their race, and the friction without which they would slide."""
    if "ball_speed_in_space" not in run or not run.sizes.get("time", 0) or not found.critical_speeds:
        return
    time, rotor = run["time"].values, run["speed"].values
    own = _by_time(run["ball_speed_in_space"])
    pressed = np.abs(own) > PRESSED * found.critical_speeds[0]
    rate = np.gradient(own - rotor[:, None], time, axis=0)
    rows = []
    for name, numbers in _races(balls).items():
        relative = np.abs(own[:, numbers] - rotor[:, None])
        fastest = float((relative * [float(balls[i].orbit_radius) for i in numbers]).max())
        spin = np.array([float(balls[i].spin_ratio * balls[i].mass / balls[i].effective_mass) for i in numbers])
        with np.errstate(divide="ignore", invalid="ignore"):
            asked = np.where(pressed[:, numbers], spin * np.abs(rate[:, numbers]) / own[:, numbers] ** 2, 0.0)
        rows.append(
            (
                name,
                f"{significant(fastest)} m/s",
                _share(float(relative[-1].max() / max(abs(rotor[-1]), 1e-12))),
                significant(float(asked.max())) if spin.max() > 0.0 else "- (point balls)",
            )
        )
    heads = (
        "race",
        "greatest speed of a ball in it",
        "slip at the end, of the rotor speed",
        "friction that rolling needs",
    )
    page.blocks.append(Rows(heads, tuple(rows), (False, True, True, True)))
    page.blocks.append(
        Paragraph(
            "Slip is the speed of a ball against the rotor. A ball rolls without sliding as long as the coefficient of friction "
            "at the wall is greater than its spin ratio times its acceleration in the race over the square of its speed in "
            "space, a little more in a fluid that carries part of it. Taken from samples every "
            f"{significant(float(np.diff(time).mean()))} s, above half of the lowest critical speed."
        )
    )


def _share(share: float) -> str:
    return f"{significant(100.0 * share)} %" if share > LEAST else f"< {100.0 * LEAST:g} %"


def _by_time(values: Any) -> np.ndarray:
    return np.asarray(values.transpose("time", "ball").values, np.float64)
