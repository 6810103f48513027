"""Every speed, unbalance and duration that a function takes may be a text with a unit."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest

import autobalancer as ab
from autobalancer.errors import UnitError
from autobalancer.files.examples import rig
from autobalancer.flow.annulus import Annulus
from autobalancer.laws.stall import held_whirl
from autobalancer.measurement.equilibrium_angles import TurnedRace, equilibrium_angles
from autobalancer.units import argument, ends_argument, to_si
from autobalancer.units.quantity import example

PLANAR = ab.load_machine(Path(__file__).parents[1] / "examples" / "machines" / "stall_and_release.toml")
RIG = rig("rodrigues_rig")
SPEED, UNBALANCE = "4000 rpm", "100 g*mm"
IN_SI = {
    SPEED: 418.879020478639,
    "1000 rpm": 104.71975511966,
    UNBALANCE: 1e-4,
    "3000 rpm": 314.159265358979,
    "0.2 s": 0.2,
    "0.1 s": 0.1,
    "77 mm": 0.077,
    "12.3 mm": 0.0123,
    "7800 kg/m^3": 7800.0,
    "20 mm^2/s": 20e-6,
    "10 kg": 10.0,
    "400 kN/m": 4e5,
    "200 N*s/m": 200.0,
    "6.6 g": 6.6e-3,
    "5e-6 N*m*s": 5e-6,
    "40 degC": 313.15,
    "30 deg": 0.523598775598299,
}
RUN = ab.simulate(PLANAR, duration=0.5, save=ab.Samples(101))
CURVE = ab.laws.DragCurve(ab.laws.free_sphere(), 760.0, 1e-6, 0.0123)
CHAMBER = Annulus(0.068, 0.086, 0.018, 0.077, 20e-6, 950.0)


def receptance(mass: Any, stiffness: Any, damping: Any) -> list[complex]:
    return [complex(value) for value in ab.laws.planar_receptance(mass, stiffness, damping)(np.array([100.0, 300.0]))]


def turned(q: Callable[[str], Any]) -> list[float]:
    race = TurnedRace(q("12.3 mm"), q("6.6 g"), q("77 mm"), 950.0, q("20 mm^2/s"))
    found: list[float] = equilibrium_angles(race, ab.laws.free_sphere(), [q("1000 rpm")]).tolist()
    return found


def film(q: Callable[[str], Any]) -> bytes:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "film.gif"
        ab.animate(RUN, path, start=q("0.1 s"), end=q("0.2 s"), duration=q("0.2 s"), fps=10, width=320)
        return path.read_bytes()


def line_ends(figure: Any) -> list[float]:
    return [float(x) for x in figure.axes[0].get_xlim()]


CALLS: dict[str, Callable[[Callable[[str], Any]], Any]] = {
    "stable_windows": lambda q: ab.stability.stable_windows(PLANAR, q(SPEED), unbalance=q(UNBALANCE)),
    "border_speeds": lambda q: ab.stability.borders(PLANAR, unbalance=q(UNBALANCE)),
    "equilibria": lambda q: ab.stability.equilibria(PLANAR, q(SPEED), unbalance=q(UNBALANCE))[
        "growth_rate"
    ].values.tolist(),
    "eigenvalues": lambda q: str(ab.stability.eigenvalues(PLANAR, [q(SPEED)], unbalance=q(UNBALANCE)).data_vars),
    "unbalance_response": lambda q: ab.rotor.response(RIG, [q("3000 rpm"), q(SPEED)], unbalance=q(UNBALANCE))[
        "semi_major"
    ].values.tolist(),
    "response_peaks": lambda q: str(
        ab.rotor.response_peaks(RIG, lowest=q("1000 rpm"), highest=q("3000 rpm"), unbalance=q(UNBALANCE)).data_vars
    ),
    "modes": lambda q: ab.rotor.modes(RIG, q(SPEED))["frequency"].values.tolist(),
    "stepped_response": lambda q: ab.stepped_response(RIG, [q(SPEED)], dwell=q("0.2 s"), window=q("0.1 s"))[
        "amplitude"
    ].values.tolist(),
    "suitable_bearings": lambda q: len(ab.catalog.suitable_bearings(q(UNBALANCE))),
    "sweep": lambda q: ab.sweep(PLANAR, {"unbalances[1].mass": ["4 g"]}, duration=q("0.2 s"))[
        "peak_deflection"
    ].values.tolist(),
    "capability": lambda q: ab.laws.capability(q("77 mm"), q("12.3 mm"), q("7800 kg/m^3"), 2),
    "largest_useful_count": lambda q: ab.laws.largest_useful_count(q("77 mm"), q("12.3 mm")),
    "rest_interval": lambda q: ab.laws.rest_interval(
        q(UNBALANCE),
        q(UNBALANCE),
        q("77 mm"),
        0.001,
        mass=q("10 kg"),
        stiffness=q("400 kN/m"),
        damping=q("200 N*s/m"),
        speed=q("3000 rpm"),
    ),
    "held_whirl": lambda q: held_whirl(q("77 mm"), 0.001),
    "balance_grade": lambda q: ab.laws.balance_grade(q(UNBALANCE), q("10 kg"), q("3000 rpm")),
    "permissible_unbalance": lambda q: ab.laws.permissible_unbalance(6.3, q("10 kg"), q("3000 rpm")),
    "DragCurve": lambda q: (
        ab.laws.DragCurve(ab.laws.free_sphere(), q("7800 kg/m^3"), q("20 mm^2/s"), q("12.3 mm")).viscous
    ),
    "planar_receptance": lambda q: receptance(q("10 kg"), q("400 kN/m"), q("200 N*s/m")),
    "stall_ranges": lambda q: ab.laws.stall_ranges(
        ab.laws.StalledBall(q(UNBALANCE), q(UNBALANCE), q("77 mm"), lambda slip: CURVE.torque(slip, 0.077)),
        ab.laws.planar_receptance(10.0, 4e5, 200.0),
        [q("1000 rpm")],
    ),
    "slipstream_factors": lambda q: ab.laws.slipstream_factors(
        [0.0, q("30 deg")], [1.0, 1.0], q("77 mm"), q("12.3 mm"), q("20 mm^2/s")
    ).tolist(),
    "equal_balls": lambda q: str(ab.measure.equal_balls(2, q("6.6 g"), q("77 mm"), q("5e-6 N*m*s"), spin_ratio=0.4)),
    "fluid": lambda q: ab.catalog.fluid("silicone oil 20", q("40 degC")),
    "equilibrium_angles": turned,
    "annulus_flow": lambda q: ab.flow.annulus_flow(
        CHAMBER, q("1000 rpm"), initial_speed=0.0, duration=q("0.2 s"), samples=5
    )["fluid_speed"].values.tolist(),
    "plot_run_up": lambda q: line_ends(ab.plot.run_up(RUN, start=q("0.1 s"), end=q("0.2 s"))),
    "plot_race": lambda q: ab.plot.race(RUN, time=q("0.2 s")).axes[0].get_title(),
    "animate": film,
}


@pytest.mark.parametrize("name", CALLS)
def test_a_text_with_a_unit_is_the_same_as_its_number(name: str) -> None:
    assert repr(CALLS[name](str)) == repr(CALLS[name](IN_SI.__getitem__))


@pytest.mark.parametrize("name", CALLS)
def test_what_is_no_such_quantity_is_refused_by_the_name_of_the_argument(name: str) -> None:
    def wrong(_: str) -> str:
        return "3 kg"

    with pytest.raises(UnitError, match=r"^[a-z_]+(\[\d\])?: given '3 kg', but a quantity in "):
        CALLS[name](wrong)


@pytest.mark.parametrize(("given", "said"), [(None, 'give a number or a text such as "0.02"'), ("x", 'example "0.02"')])
def test_a_message_about_a_number_without_a_unit_shows_one(given: Any, said: str) -> None:
    with pytest.raises(UnitError, match=said):
        argument("share", given, "")
    with pytest.raises(UnitError, match=r"write a number such as 0\.02"):
        to_si(None, "")  # type: ignore[arg-type]


@pytest.mark.parametrize("unit", ["", "kg", "rad/s", "m^2/s", "N*m*s"])
def test_the_range_that_a_message_shows_ascends_and_can_be_read(unit: str) -> None:
    low, high = ends_argument("range", example(unit).strip('"'), unit)
    assert low < high
