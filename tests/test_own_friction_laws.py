"""A friction law from outside the package: compiled and called as those from within, refused where it would drive a ball."""

from __future__ import annotations

import math
import re
from typing import Any, ClassVar, Literal

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import autobalancer as ab
from autobalancer.assembly.system import assemble
from autobalancer.errors import MachineError
from autobalancer.machine import FrictionLaw
from autobalancer.machine import plugins as leaves
from autobalancer.machine.part import Ratio, key
from references.every_key import BALL, PAIR, machine
from references.resolved import chamber, free

RUBS: dict[str, Any] = {"restitution": 0.6, "sliding_friction": 0.2, "slip_speed": 0.02}


class OwnPeak(FrictionLaw):
    """(5.7) once more, typed anew."""

    kind: Literal["own_peak"] = "own_peak"
    interface: ClassVar[int] = 1
    more: Ratio = key("greatest coefficient less that of sliding")
    fade: Ratio = key("slip over which it decreases, m/s")

    @staticmethod
    def coefficient(at: Any, own: Any) -> float:
        return (at.sliding + own.more * math.exp(-abs(at.slip) / own.fade)) * math.tanh(at.slip / at.slip_speed)  # type: ignore[no-any-return]


class Viscous(FrictionLaw):
    """A lubricated wall: friction in proportion to the slip, whatever presses."""

    kind: Literal["viscous"] = "viscous"
    interface: ClassVar[int] = 1
    constant: Ratio = key("force over slip, N s/m")

    @staticmethod
    def coefficient(at: Any, own: Any) -> float:
        return own.constant * at.slip / at.pressed  # type: ignore[no-any-return]


class Thickens(FrictionLaw):
    """More friction as the ball becomes faster."""

    kind: Literal["thickens"] = "thickens"
    interface: ClassVar[int] = 1
    growth: Ratio = key("per velocity, s/m")

    @staticmethod
    def coefficient(at: Any, own: Any) -> float:
        return at.sliding * (1.0 + own.growth * abs(at.slip)) * math.tanh(at.slip / at.slip_speed)  # type: ignore[no-any-return]


class NoNumber(Viscous):
    kind: Literal["no_number"] = "no_number"  # type: ignore[assignment]

    @staticmethod
    def coefficient(at: Any, own: Any) -> float:
        return math.sqrt(0.5 - abs(at.slip)) * at.slip if abs(at.slip) < 0.5 else math.nan


class Drives(Viscous):
    kind: Literal["drives"] = "drives"  # type: ignore[assignment]

    @staticmethod
    def coefficient(at: Any, own: Any) -> float:
        return 0.1 * math.tanh(at.slip / at.slip_speed) - 0.05 * at.slip  # type: ignore[no-any-return]


class Creeps(Viscous):
    kind: Literal["creeps"] = "creeps"  # type: ignore[assignment]

    @staticmethod
    def coefficient(at: Any, own: Any) -> float:
        return 0.1 * math.copysign(1.0, at.slip)


class Lists(Viscous):
    kind: Literal["lists"] = "lists"  # type: ignore[assignment]

    @staticmethod
    def coefficient(at: Any, own: Any) -> float:
        return sum([at.slip, 0.0])  # type: ignore[no-any-return]


class Nothing(FrictionLaw):
    kind: Literal["nothing"] = "nothing"
    interface: ClassVar[int] = 1


@pytest.fixture(autouse=True)
def _known_here_only(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(leaves, "_registered", dict(leaves._registered))


def last(law: Any, duration: float = 0.4, **more: Any) -> np.ndarray:
    run = ab.simulate(free(friction_law=law, **RUBS, **more), duration=duration)
    return np.array([run[name].values[-1].ravel() for name in ("ball_angle_in_rotor", "ball_spin")])


def test_a_law_from_outside_moves_the_balls_as_the_same_law_from_within() -> None:
    ours = last({"kind": "stribeck", "peak": 0.4, "peak_speed": 0.1})
    theirs = last(OwnPeak(more=0.2, fade=0.1))
    np.testing.assert_allclose(theirs, ours, rtol=1e-7)
    assert np.abs(last({"kind": "coulomb"}) - ours).max() > 1e-3
    np.testing.assert_allclose(last(None), last({"kind": "coulomb"}), rtol=1e-12)


def test_slip_on_a_lubricated_wall_decays_as_the_exponential_of_its_law() -> None:
    c, mass, radius, speed = 0.05, 5e-3, 5e-3, 100.0
    machine = chamber(
        speed=speed, restitution=0.0, sliding_friction=0.1, slip_speed=1e-3, friction_law=Viscous(constant=c),
        balls={"start_speeds": [5.0]}, start_gap=1e-6,  # a ball that starts off the wall does not spin
    )  # fmt: skip
    run = ab.simulate(machine, duration=0.05, save=ab.SampleTimes([0.01, 0.03, 0.05]))
    slip = 0.1 * run["ball_speed_in_rotor"].values.ravel() + radius * (run["ball_spin"].values.ravel() - speed)
    rate = c / mass * (1.0 + 5.0 / 2.0)  # of a full sphere
    # 1e-3: depth of the contact over the orbit radius, and its vibration after the start
    np.testing.assert_allclose(slip[1:] / slip[:-1], math.exp(-0.02 * rate), rtol=1e-3)


def test_a_registered_law_is_read_and_written() -> None:
    ab.laws.register(Viscous)
    machine = chamber(sliding_friction=0.1, friction_law={"kind": "viscous", "constant": 0.3})
    assert ab.parse_machine(ab.machine_text(machine)) == machine
    assert "force over slip" in repr(ab.keys("balancers.races.friction.rolling_law"))


@pytest.mark.parametrize(
    ("law", "message"),
    [
        (
            NoNumber(constant=0.0),
            r"'no_number' is not a number at a slip of .* m/s on a wall that presses with 0.01 N",
        ),
        (Drives(constant=0.0), "'drives' drives the ball at a slip of 3.* its coefficient is -"),
        (Creeps(constant=0.0), "'creeps' drives a ball that does not slip, with the coefficient 0.1"),
        (Lists(constant=0.0), "'lists' does not compile: memory is allocated"),
        (Nothing(), "'nothing' has no 'coefficient'"),
    ],
)
def test_a_law_that_does_not_brake_is_named(law: FrictionLaw, message: str) -> None:
    with pytest.raises(
        MachineError, match=rf"balancers\[1\]\.races\[1\]\.resolved\.friction_law: the friction law {message}"
    ):
        assemble(chamber(sliding_friction=0.1, friction_law=law))


class FailsFast(Viscous):
    kind: Literal["fails_fast"] = "fails_fast"  # type: ignore[assignment]

    @staticmethod
    def coefficient(at: Any, own: Any) -> float:
        return 0.1 * math.tanh(at.slip / at.slip_speed) if abs(at.slip) < 20.0 else math.nan


def test_a_run_that_a_friction_law_ends_names_the_law_and_the_slip() -> None:
    machine = chamber(
        sliding_friction=0.1, restitution=0.0, friction_law=FailsFast(constant=0.0), start_gap=1e-6,
        balls={"start_speeds": [250.0]},
    )  # fmt: skip
    run = ab.simulate(machine, duration=0.1)
    assert run.attrs["outcome"] == "not finite"
    told = re.search(
        r"the friction law 'fails_fast' was not a number on ball 1 at a slip of (\S+) m/s", run.attrs["outcome_text"]
    )
    assert told is not None
    assert float(told[1]) == pytest.approx(25.0, rel=1e-3)


def test_a_law_for_another_version_is_refused_with_both_versions() -> None:
    class Newer(Viscous):
        kind: Literal["newer"] = "newer"  # type: ignore[assignment]
        interface: ClassVar[int] = 3

    with pytest.raises(MachineError, match=r"version 3 .* version 1"):
        ab.laws.register(Newer)


def guided(law: Any, **friction: float) -> Any:
    """Two guided balls that balance each other, slower than their rotor."""
    balls = [{"count": 2, **BALL, "start_angles": [0.0, math.pi], "start_speeds": [-30.0, -30.0]}]
    rubs = {"rolling_resistance": 4e-3, "adherence": 0.01} | friction | {"rolling_law": law}
    return machine(PAIR | {"balls": balls, "friction": rubs}, unbalances=[])


def test_a_guided_ball_is_braked_by_the_law_of_its_rolling_resistance() -> None:
    orbit, speed, growth = PAIR["orbit_radius"], 120.0, 0.2
    inertia = 1.4 * 7800.0 * math.pi / 6.0 * BALL["diameter"] ** 3 * orbit**2  # of a full sphere that rolls

    def rates(time: float, state: Any) -> list[float]:
        rolling = 4e-3 * (1.0 + growth * orbit * abs(state[0]))
        return [rolling * (speed + state[0]) ** 2 / 1.4 - PAIR["drag"]["damping"] * state[0] / inertia]

    expected = solve_ivp(rates, (0.0, 0.2), [-30.0], rtol=1e-10).y[0, -1]
    run = ab.simulate(guided(Thickens(growth=growth)), duration=0.2, tolerance=1e-9)
    assert run["ball_speed_in_rotor"].values[-1] == pytest.approx(expected, rel=1e-6)
    plain, constant = (ab.simulate(guided(law), duration=0.2, tolerance=1e-9) for law in (None, {"kind": "coulomb"}))
    ends = [float(one["ball_speed_in_rotor"].values[-1, 0]) for one in (plain, constant)]
    assert ends[0] == pytest.approx(ends[1], rel=1e-6)
    assert abs(ends[0] - expected) > 0.1


def test_a_law_that_does_not_fit_guided_balls_is_refused() -> None:
    for law, friction, message in (
        (Viscous(constant=1.0), {}, r"friction\.rolling_law: .* 'viscous' is not a number at a slip of 1e-09 m/s"),
        (
            {"kind": "stribeck", "peak": 0.02, "peak_speed": 0.1},
            {},
            "begins to roll with 0.02; the adherence must not be",
        ),
        ({"kind": "coulomb"}, {"rolling_resistance": 0.0}, "rolling_law: changes the 'rolling_resistance'"),
    ):
        with pytest.raises(MachineError, match=message):
            assemble(guided(law, **friction))
