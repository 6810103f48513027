"""Forces of one's own: from a file, by a decorator, from an installed package; and those that are refused, with the reason."""

from __future__ import annotations

import math
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any, ClassVar, Literal

import numpy as np
import pytest
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.cli.main import app
from autobalancer.errors import MachineError, QuestionError
from autobalancer.machine import Force, Machine, PairForce, key
from autobalancer.machine import plugins as leaves

FILE = '''
"""Two forces of our own."""
import math
from typing import Annotated, Literal
from autobalancer.machine import Force, Quantity, key

class Brush(Force):
    """A brush in the race that holds balls back where they pass it."""
    kind: Literal["brush"] = "brush"
    interface = 1
    drag: Annotated[float, Quantity("N*s/m", positive=True)] = key("force over speed in the middle of the brush")
    width: Annotated[float, Quantity("rad", positive=True)] = key("half its width")

    @staticmethod
    def force(at, own):
        angle = math.atan2(at.y, at.x)
        hold = own.drag * math.exp(-((angle / own.width) ** 2))
        return -hold * at.vx, -hold * at.vy

class SpeedDrag(Force):
    """The same everywhere."""
    kind: Literal["plain_drag"] = "plain_drag"
    interface = 1
    drag: Annotated[float, Quantity("N*s/m", positive=True)] = key("force over speed")

    @staticmethod
    def force(at, own):
        return -own.drag * at.vx, -own.drag * at.vy
'''
MACHINE = """
name = "own"
axis = "vertical"
rotor = { mass = "1 t", stiffness = "600 MN/m", damping = 80.0 }
drive = { kind = "speed", profile = { kind = "constant", speed = "0 rpm" } }
run = { duration = "1 s" }
[[balancers]]
[[balancers.races]]
orbit_radius = "100 mm"
collisions = false
drag = { law = "viscous", damping = 0.0 }
balls = [{ mass = "10 g", motion = "point", start_angles = [1.0], start_speeds = [8.0] }]
[[balancers.races.forces]]
kind = "plain_drag"
drag = "20 mN*s/m"
"""


@pytest.fixture(autouse=True)
def _unknown_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a test registers, the next one does not know."""
    monkeypatch.setattr(leaves, "_registered", dict(leaves._registered))


def machine(*forces: Any) -> Machine:
    bare = ab.parse_machine(MACHINE.split("[[balancers.races.forces]]")[0])
    return ab.with_parameter(bare, "balancers[1].races[1].forces", forces)


def test_a_force_from_a_file_that_is_named_on_the_command_line_acts_in_a_run(tmp_path: Path) -> None:
    """phi' = phi_0' e^(-c t/m) by drag of the user's own, without any other."""
    (tmp_path / "ours.py").write_text(FILE)
    (tmp_path / "machine.toml").write_text(MACHINE)
    words = ["simulate", str(tmp_path / "machine.toml"), "--out", str(tmp_path / "run.nc")]
    refused = CliRunner().invoke(app, words)
    assert refused.exit_code == 2
    assert "forces[1].kind: given 'plain_drag'" in refused.output
    assert "--load FILE" in " ".join(refused.output.split())
    done = CliRunner().invoke(app, ["--load", str(tmp_path / "ours.py"), *words])
    assert done.exit_code == 0, done.output
    run = ab.load_run(tmp_path / "run.nc")
    np.testing.assert_allclose(run.ball_speed_in_rotor[:, 0], 8.0 * np.exp(-0.02 / 0.01 * run.time), rtol=1e-6)
    assert "force_energy" not in run
    shown = CliRunner().invoke(app, ["--load", str(tmp_path / "ours.py"), "keys", "balancers.races.forces"])
    assert "force over speed in the middle of the brush" in " ".join(shown.output.split())


def test_the_example_of_the_documentation_is_complete(tmp_path: Path) -> None:
    page = (Path(__file__).parents[1] / "docs" / "forces.md").read_text()
    code = page.split("## A force of your own")[1].split("```python\n")[1].split("```")[0]
    keys = page.split("## A force of your own")[1].split("```toml\n")[1].split("```")[0]
    (tmp_path / "felt.py").write_text(code)
    (felt,) = ab.laws.load(tmp_path / "felt.py")
    text = MACHINE.split("[[balancers.races.forces]]")[0] + keys
    run = ab.simulate(ab.parse_machine(text), duration=2.0)
    assert felt.__name__ == "Felt"
    assert 0.0 < float(run.ball_speed_in_rotor[-1, 0]) < 1.0 < float(run.ball_speed_in_rotor[0, 0])


@pytest.mark.slow
def test_a_file_that_was_loaded_may_be_imported_later(tmp_path: Path) -> None:
    """What was kept on disk under the name of the one module is of no use to the other, and no reason to refuse the force."""
    (tmp_path / "ours.py").write_text(FILE)
    (tmp_path / "machine.toml").write_text(MACHINE)
    asked = "import autobalancer as ab; run = ab.simulate('machine.toml', duration=0.01); print(run.attrs['outcome'])"
    for start in (
        "import autobalancer as ab; ab.laws.load('ours.py')",
        "import autobalancer as ab, ours; ab.laws.register(ours.SpeedDrag)",
    ):
        done = subprocess.run(
            [sys.executable, "-c", f"{start}; {asked}"], cwd=tmp_path, capture_output=True, text=True, check=False
        )
        assert done.stdout.strip() == "finished", done.stderr


class Detent(Force):
    """A ball rests at the mark of the rotor."""

    kind: Literal["detent"] = "detent"
    interface: ClassVar[int] = 1
    depth: float = key("J")

    @staticmethod
    def force(at: Any, own: Any) -> tuple[float, float]:
        square = at.x * at.x + at.y * at.y
        back = -own.depth * at.y / (square * math.sqrt(square))
        return -back * at.y, back * at.x

    @staticmethod
    def energy(at: Any, own: Any) -> float:
        return float(-own.depth * at.x / math.sqrt(at.x * at.x + at.y * at.y))


def test_a_registered_force_is_known_to_files_and_a_class_need_not_even_be_registered_in_python() -> None:
    with pytest.raises(ValueError, match="given 'detent'"):
        machine({"kind": "detent", "depth": 0.1})
    assert ab.laws.register(Detent) is Detent
    described = machine({"kind": "detent", "depth": 0.1})
    leaves._registered.clear()
    assert machine(Detent(depth=0.1)) == described  # known by being used
    assert ab.parse_machine(ab.machine_text(described)) == described
    run = ab.simulate(described, duration=2.0, mass_spread=0.0, tolerance=1e-11)
    stored = run.force_energy.values
    energy = 0.5 * 0.01 * (0.1 * run.ball_speed_in_rotor.values[:, 0]) ** 2 + stored
    assert np.ptp(stored) > 1e-3
    # the rotor, 1e5 times as heavy, takes part a little
    np.testing.assert_allclose(energy, energy[0], rtol=2e-6)


def test_both_balls_of_a_pair_know_by_how_much_they_are_ahead() -> None:
    def force(at: Any, next: Any, own: Any) -> Any:
        turn = at.ahead + next.ahead
        return -turn * at.y, turn * at.x, 0.0, 0.0

    def energy(at: Any, next: Any, own: Any) -> float:
        return float(at.ahead + next.ahead)

    balls = {
        "mass": 0.01,
        "count": 3,
        "motion": "point",
        "start_angles": [0.0, 1.0, 3.0],
        "start_speeds": [8.0, 8.0, 8.0],
    }
    both = ab.with_parameter(
        machine(leaf("both", PairForce, force=force, energy=energy)()), "balancers[1].races[1].balls", [balls]
    )
    run = ab.simulate(both, duration=0.2)
    np.testing.assert_allclose(
        run.ball_speed_in_rotor, 8.0, rtol=1e-3
    )  # the rotor, 3e4 times as heavy, shakes a little
    np.testing.assert_array_equal(run.force_energy, 0.0)


def test_an_installed_package_brings_its_force_by_an_entry_point(monkeypatch: pytest.MonkeyPatch) -> None:
    point = SimpleNamespace(name="detent", dist=SimpleNamespace(name="ours"), load=lambda: Detent)
    monkeypatch.setattr(leaves, "entry_points", lambda group: [point] if group == "autobalancer.forces" else [])
    assert machine({"kind": "detent", "depth": 0.1}).balancers[0].races[0].forces[0] == Detent(depth=0.1)
    other = SimpleNamespace(name="spring", dist=SimpleNamespace(name="ours"), load=lambda: Detent)
    monkeypatch.setattr(leaves, "entry_points", lambda group: [other])
    with pytest.raises(MachineError, match="entry point 'spring' of ours: is the force 'detent'; it must be"):
        machine({"kind": "spring", "depth": 0.1})


def leaf(word: str, base: Any = Force, *, interface: int | None = 1, **methods: Any) -> Any:
    """A class of a force with these methods."""
    body = {"__annotations__": {"kind": Literal[word]}, "kind": word, "__module__": __name__}  # type: ignore[valid-type]
    body |= {name: staticmethod(method) for name, method in methods.items()}
    return type(word.title(), (base,), body | ({} if interface is None else {"interface": interface}))


def fails(leaf: Any) -> str:
    """What is said when a force is used."""
    with pytest.raises(MachineError) as refused:
        ab.simulate(machine(leaf()), duration=0.01)
    return str(refused.value)


PLACE = "balancers[1].races[1].forces[1]: the force"


def test_a_force_of_another_version_is_refused_with_both() -> None:
    old = leaf("old", interface=7, force=lambda at, own: (0.0, 0.0))
    with pytest.raises(MachineError, match=r"Old was written for version 7 .* this autobalancer\s+has version 1"):
        ab.laws.register(old)
    with pytest.raises(MachineError, match="written for version 7"):
        machine(old())
    with pytest.raises(MachineError, match=r"does not say for which version .* write interface = 1"):
        ab.laws.register(leaf("silent", interface=None, force=lambda at, own: (0.0, 0.0)))


def test_what_is_no_force_or_takes_the_name_of_a_built_in_one_is_refused() -> None:
    with pytest.raises(MachineError, match="must be a class that inherits from a base class"):
        ab.laws.register(3)
    with pytest.raises(MachineError, match="has the kind 'magnets', which is a force of autobalancer; take another"):
        ab.laws.register(leaf("magnets", force=lambda at, own: (0.0, 0.0)))


def test_a_force_without_mathematics_or_with_too_few_numbers_is_refused() -> None:
    assert f"{PLACE} 'empty' has no 'force'; it is a static method that must return 2" in fails(leaf("empty"))
    said = fails(leaf("few", PairForce, force=lambda at, next, own: (0.0, 0.0)))
    assert "it must return 4 numbers: force(at, next, own) -> (fx, fy, fx_next, fy_next)" in said


def test_a_key_that_can_be_changed_is_refused_with_what_to_write() -> None:
    class Spots(Detent):
        kind: Literal["spots"] = "spots"  # type: ignore[assignment]
        angles: list[float] = key("rad", [])

    class Spotted(Detent):
        kind: Literal["spotted"] = "spotted"  # type: ignore[assignment]
        angles: tuple[float, ...] = key("rad", ())

    said = r"forces\[1\]\.angles: its values are of the type list, .* as a tuple, such as tuple\[float, \.\.\.\]"
    with pytest.raises(MachineError, match=said):
        machine(Spots(depth=0.1))
    with pytest.raises(MachineError, match=said):
        machine({"kind": "spots", "depth": 0.1, "angles": [1.0]})
    assert "angles" not in machine(Spotted(depth=0.1, angles=[1.0])).balancers[0].races[0].forces[0].numbers()


def test_a_force_that_allocates_is_refused() -> None:
    def force(at: Any, own: Any) -> Any:
        both = np.array([at.x, at.y])
        return -both[0], -both[1]

    assert f"{PLACE} 'array' does not compile: in 'force', memory is allocated" in fails(leaf("array", force=force))


def test_a_force_that_does_not_compile_is_refused_with_the_reason() -> None:
    said = fails(leaf("typo", force=lambda at, own: (at.z, at.y)))
    assert f"{PLACE} 'typo' does not compile: in 'force', " in said
    assert "nothing has the name 'z'; at has x, y, vx, vy, " in said


def test_a_force_that_is_not_a_number_is_refused_with_the_place() -> None:
    said = fails(leaf("root", force=lambda at, own: (math.sqrt(at.x), 0.0)))
    assert f"{PLACE} 'root' is not a number at x = -" in said
    assert "at a velocity of 0 and 0 m/s and a rotor speed of" in said  # not of -0


def test_a_force_whose_energy_does_not_match_is_refused_with_both() -> None:
    spring = {"force": lambda at, own: (-2.0 * at.x, -2.0 * at.y)}
    said = fails(leaf("wrong", **spring, energy=lambda at, own: 2.0 * (at.x * at.x + at.y * at.y)))
    assert "says it is conservative, but its energy does not match: at x = " in said
    assert "the force is (" in said
    assert "negative gradient of the energy (" in said
    ab.simulate(machine(leaf("right", **spring, energy=lambda at, own: at.x * at.x + at.y * at.y)()), duration=0.01)
    rubs = {"force": lambda at, own: (-2.0 * at.x - 0.1 * at.vx, -2.0 * at.y - 0.1 * at.vy)}
    assert "does not match" in fails(leaf("rubs", **rubs, energy=lambda at, own: at.x * at.x + at.y * at.y))
    faster = {"force": lambda at, own: (-at.speed * at.x, -at.speed * at.y)}
    said = fails(leaf("faster", **faster, energy=lambda at, own: 0.5 * at.speed * (at.x * at.x + at.y * at.y)))
    assert "has an energy that depends on the speed of the rotor" in said


def test_a_run_that_ends_because_a_force_is_no_number_says_which_and_where() -> None:
    """It is one at all ordinary places, but not for a ball of 0.9 m/s."""

    def force(at: Any, own: Any) -> Any:
        fast = math.sqrt(at.vx * at.vx + at.vy * at.vy)
        return -at.y * math.sqrt(0.85 - fast) if fast > 0.85 and fast < 0.95 else -at.y, at.x

    run = ab.simulate(machine(leaf("late", force=force)()), duration=5.0)
    assert run.attrs["outcome"] == "not finite"
    text = run.attrs["outcome_text"]
    assert "the force 'late' (balancers[1].races[1].forces[1]) was not a number on ball 1 at x = " in text
    assert "m in the race, at a velocity of" in text


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("import nothing_of_this_name", "line 1: ModuleNotFoundError"),
        ("x = 1\ny = = 2", "line 2: SyntaxError"),
        ("x = 1", "defines no force, drag law, friction law, joint or shear law"),
        (FILE.replace("interface = 1", "interface = 7"), "ours.py: Brush was written for version 7"),
    ],
)
def test_a_file_that_cannot_be_loaded_is_refused_with_its_line(text: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "ours.py").write_text(text)
    told = CliRunner().invoke(app, ["--load", str(tmp_path / "ours.py"), "check", "machine.toml"])
    assert told.exit_code == 2
    assert said in " ".join(told.output.split())
    assert "machine.toml" not in told.output
    with pytest.raises(QuestionError, match=r"ours\.py") as refused:
        ab.laws.load(tmp_path / "ours.py")
    assert said in str(refused.value)
    with pytest.raises(QuestionError, match="no such file"):
        ab.laws.load(tmp_path / "nothing.py")
