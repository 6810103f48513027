"""A drag law from outside the package: found by its name, the same as one from within, refused where it is no law."""

from __future__ import annotations

import math
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any, ClassVar, Literal

import numpy as np
import pytest

import autobalancer as ab
from autobalancer.catalog.resolve import resolve
from autobalancer.errors import MachineError, QuestionError
from autobalancer.laws.drag_coefficient import DragCurve, DragLaw
from autobalancer.machine import BallInRace, Drag, Machine
from autobalancer.machine import plugins as leaves
from autobalancer.machine.part import Positive, Ratio, key

SAMPLE = Path("examples/machines/discoidal.toml")


def cheng(re: float) -> float:
    """Drag coefficient of a free sphere (Cheng 2009), typed anew."""
    return 24.0 / re * (1.0 + 0.27 * re) ** 0.43 + 0.47 * (1.0 - math.exp(-0.04 * re**0.38))


class OwnSphere(Drag):
    """A sphere in the middle of a wide race, rougher than a smooth one by a factor."""

    law: Literal["own_sphere"] = "own_sphere"
    interface: ClassVar[int] = 1
    rough: Positive = key("factor of the drag coefficient", 1.0, symbol="f")

    def curve(self, ball: BallInRace) -> DragLaw:
        return ab.laws.sampled_drag_law(lambda re: self.rough * cheng(re), name="own_sphere", source="Cheng (2009)")


class OwnLinear(Drag):
    """Drag of a narrow gap."""

    law: Literal["own_linear"] = "own_linear"
    interface: ClassVar[int] = 1
    gap: Positive = key("gap over ball radius", 0.5)

    def curve(self, ball: BallInRace) -> DragLaw:
        return ab.laws.linear_drag_law(387.0 * 0.5 / self.gap)


class EddyCurrents(Drag):
    """A brake that needs no fluid."""

    law: Literal["eddy_currents"] = "eddy_currents"
    interface: ClassVar[int] = 1
    needs_fluid: ClassVar[bool] = False
    strength: Ratio = key("of the magnets")

    def torque(self, ball: BallInRace) -> float:
        return 2e-4 * self.strength * (ball.orbit_radius / 0.07695) ** 2


def broken(function: Callable[[BallInRace], Any]) -> Drag:
    class Broken(Drag):
        law: Literal["broken"] = "broken"
        interface: ClassVar[int] = 1

        def curve(self, ball: BallInRace) -> DragLaw:
            return function(ball)  # type: ignore[no-any-return]

    return Broken()


def with_drag(drag: Any) -> Machine:
    machine: Machine = ab.with_parameter(ab.load_machine(SAMPLE), "balancers[1].races[1].drag", drag)
    return machine


@pytest.fixture(autouse=True)
def _known_here_only(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(leaves, "_registered", dict(leaves._registered))


@pytest.mark.parametrize("re", [1e-3, 0.2, 7.0, 480.0, 1.3e4, 1.9e5])
def test_a_sampled_law_is_its_function(re: float) -> None:
    law = ab.laws.sampled_drag_law(cheng)
    assert float(law.coefficient(re)) == pytest.approx(cheng(re), rel=1e-5)
    step = 1e-4
    slope = math.log(cheng(re * math.exp(step)) / cheng(re * math.exp(-step))) / (2.0 * step)
    if 1e-3 < re < 1e5:
        assert float(law.log_slope(re)) == pytest.approx(slope, abs=2e-4)
    assert pickle.loads(pickle.dumps(law)) == law


def test_a_law_from_outside_moves_the_balls_as_the_same_law_from_within_does() -> None:
    ours, theirs = (ab.simulate(with_drag(drag), duration=1.0) for drag in ({"law": "free_sphere"}, OwnSphere()))
    assert theirs.attrs["drag_law"] == "own_sphere"
    moved = float(np.abs(np.diff(ours["ball_angle_in_rotor"].values[[0, -1]], axis=0)).max())
    assert moved > 0.5
    far = np.abs(ours["ball_angle_in_rotor"].values[-1] - theirs["ball_angle_in_rotor"].values[-1]).max()
    assert float(far) < 1e-4 * moved
    rough = ab.simulate(with_drag(OwnSphere(rough=3.0)), duration=1.0)
    far = np.abs(ours["ball_angle_in_rotor"].values[-1] - rough["ball_angle_in_rotor"].values[-1]).max()
    assert float(far) > 0.1 * moved


def test_stability_knows_a_law_from_outside() -> None:
    def speeds(drag: Any) -> dict[str, float]:
        return {border.name: border.speed for border in ab.stability.borders(with_drag(drag))}

    ours, theirs, rough = speeds({"law": "free_sphere"}), speeds(OwnSphere()), speeds(OwnSphere(rough=2.0))
    assert theirs == pytest.approx(ours, rel=2e-3, nan_ok=True)
    assert rough["release speed"] < 0.97 * ours["release speed"]
    assert (
        resolve(with_drag(OwnLinear()))[0].drag
        == resolve(with_drag({"law": "cd_times_re", "cd_times_re": 387.0}))[0].drag
    )


def test_a_law_without_fluid_gives_its_torque() -> None:
    machine = ab.load_machine("examples/machines/stall_and_release.toml")
    ball = resolve(ab.with_parameter(machine, "balancers[1].races[1].drag", EddyCurrents(strength=3.0)))[0]
    assert ball.drag == pytest.approx(6e-4 * (ball.orbit_radius / 0.07695) ** 2, rel=1e-12)
    assert ball.drag_curve is None


def test_a_registered_law_is_read_written_listed_and_explained() -> None:
    ab.laws.register(OwnSphere)
    machine = with_drag({"law": "own_sphere", "rough": 1.2})
    assert ab.parse_machine(ab.machine_text(machine)) == machine
    assert 'law = "own_sphere"\nrough = 1.2' in ab.machine_text(machine)
    assert "factor of the drag coefficient" in repr(ab.keys("balancers.races.drag"))
    with pytest.raises(MachineError, match=r"drag\.rough: given -1; must be greater than zero"):
        with_drag({"law": "own_sphere", "rough": -1})
    with pytest.raises(MachineError, match="did you mean 'own_sphere'"):
        with_drag({"law": "own_spheres"})


def test_a_law_of_an_installed_package_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "foreign_drag.py").write_text(
        "from typing import ClassVar, Literal\n"
        "from autobalancer.machine import BallInRace, Drag\nimport autobalancer as ab\n\n\n"
        "class Foreign(Drag):\n"
        '    """Of another package."""\n\n'
        '    law: Literal["foreign"] = "foreign"\n    interface: ClassVar[int] = 1\n\n'
        "    def curve(self, ball: BallInRace):\n        return ab.laws.linear_drag_law(400.0)\n"
    )
    folder = tmp_path / "foreign_drag-1.0.dist-info"
    folder.mkdir()
    (folder / "METADATA").write_text("Metadata-Version: 2.1\nName: foreign-drag\nVersion: 1.0\n")
    (folder / "entry_points.txt").write_text(
        "[autobalancer.drag]\nforeign = foreign_drag:Foreign\nlost = foreign_drag:No\n"
    )
    monkeypatch.syspath_prepend(str(tmp_path))
    assert with_drag({"law": "foreign"}).balancers[0].races[0].drag.word() == "foreign"
    with pytest.raises(MachineError, match=r"'lost' of foreign-drag: cannot be loaded: .*No"):
        with_drag({"law": "lost"})


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (lambda re: 30.0 / re if re < 90.0 else math.nan, "gives c_d = nan at Re = 9"),
        (lambda re: 30.0 / re - 0.01, "gives c_d = -.* at Re = 3"),
        (lambda re: 30.0 / re**1.2, "c_d Re falls from 119.4 at Re = 0.001 to"),
        (lambda re: 30.0 / (re - re), "fails at Re = 0.001: ZeroDivisionError"),
        (lambda re: "much", "fails at Re = 0.001: ValueError"),
    ],
)
def test_a_function_that_is_no_drag_coefficient_is_named_with_the_place(function: Any, message: str) -> None:
    with pytest.raises(QuestionError, match=message):
        ab.laws.sampled_drag_law(function, name="bad")
    with pytest.raises(MachineError, match=rf"races\[1\]\.drag: drag law 'bad': .*{message}"):
        resolve(with_drag(broken(lambda ball: ab.laws.sampled_drag_law(function, name="bad"))))


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (lambda ball: 387.0, "'broken' gives 387.0; its 'curve' must return what ab.laws.sampled_drag_law or"),
        (
            lambda ball: ab.laws.sampled_drag_law(lambda re: math.nan),
            "drag law 'broken': gives c_d = nan at Re = 0.001",
        ),
        (lambda ball: ball.diameter, "'broken' fails: AttributeError"),
        (lambda ball: ab.laws.linear_drag_law(-3.0), "given c_d Re = -3; must be positive"),
    ],
)
def test_a_class_that_is_no_drag_law_is_named(function: Any, message: str) -> None:
    with pytest.raises(MachineError, match=message):
        resolve(with_drag(broken(function)))


def test_a_law_without_a_name_has_the_word_of_its_class() -> None:
    curve = resolve(with_drag(broken(lambda ball: ab.laws.sampled_drag_law(cheng))))[0].drag_curve
    assert curve is not None
    assert (curve.law.name, curve.law) == ("broken", ab.laws.sampled_drag_law(cheng, name="broken"))


def test_a_law_for_another_version_is_refused_with_both_versions() -> None:
    class Newer(OwnSphere):
        law: Literal["newer"] = "newer"  # type: ignore[assignment]
        interface: ClassVar[int] = 7

    with pytest.raises(MachineError, match=r"written for version 7 .* version 1"):
        ab.laws.register(Newer)


def test_a_curve_of_an_own_law_is_made_in_one_line() -> None:
    curve = DragCurve(ab.laws.sampled_drag_law(lambda re: 322.0 / re + 0.7), 950.0, 2e-5, 0.012)
    assert float(curve.force(1.0)) == pytest.approx(0.5 * 950.0 * math.pi * 0.006**2 * (322.0 / 600.0 + 0.7), rel=1e-5)
