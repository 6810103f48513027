"""A machine in other programs: a library in C and FMUs, beside runs of the package."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import autobalancer as ab
from autobalancer.assembly.number_block import change_by, parameters_of
from autobalancer.errors import QuestionError
from autobalancer.exchange import _image_of
from autobalancer.machine.path import with_entry

MACHINES = Path(__file__).parents[1] / "examples" / "machines"
compiler = pytest.mark.skipif(shutil.which("cc") is None, reason="no compiler of C")
END = 0.6


class Library:
    """The functions of a library, called from Python."""

    def __init__(self, folder: Path) -> None:
        (path,) = folder.glob("lib*.so")
        self.c = ctypes.CDLL(str(path))
        for name, result in {
            "ab_create": ctypes.c_void_p, "ab_time": ctypes.c_double, "ab_parameter": ctypes.c_double,
            "ab_saved_size": ctypes.c_size_t, "ab_list": ctypes.POINTER(Variable), "ab_steps_taken": ctypes.c_int64,
        }.items():  # fmt: skip
            getattr(self.c, name).restype = result
        self.states, self.outputs, self.parameters = (self.names(kind) for kind in range(3))

    def names(self, kind: int) -> list[str]:
        return [self.c.ab_list(kind)[i].name.decode() for i in range(self.c.ab_count(kind))]

    def create(self) -> Any:
        return ctypes.c_void_p(self.c.ab_create())

    def step(self, one: Any, time: float) -> np.ndarray:
        assert self.c.ab_step(one, ctypes.c_double(time)) == 0
        return self.state(one)

    def state(self, one: Any) -> np.ndarray:
        state = np.zeros(len(self.states))
        self.c.ab_state(one, ctypes.c_void_p(state.ctypes.data))
        return state

    def run(self, one: Any, times: np.ndarray) -> np.ndarray:
        kept = np.zeros((times.size, len(self.states)))
        given = (ctypes.c_double(times[-1]), ctypes.c_void_p(times.ctypes.data), ctypes.c_size_t(times.size))
        assert self.c.ab_run(one, *given, ctypes.c_void_p(kept.ctypes.data)) == 0
        return kept


class Variable(ctypes.Structure):
    _fields_ = [(name, ctypes.c_char_p) for name in ("name", "unit", "description")] + [
        (name, ctypes.c_double) for name in ("start", "least", "greatest")
    ]


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> tuple[Library, Path]:
    folder = tmp_path_factory.mktemp("c") / "released"
    ab.export(MACHINES / "stall_and_release.toml", folder, duration=END)
    return Library(folder), folder


def in_python(times: np.ndarray, **options: Any) -> Any:
    machine = ab.load_machine(MACHINES / "stall_and_release.toml")
    for path, value in options.items():
        machine = with_entry(machine, path.replace("__", "."), value)
    return ab.simulate(machine, duration=float(times[-1]), save=ab.SampleTimes(tuple(times)), method="dormand_prince_8")


@compiler
def test_the_c_example_runs_as_the_package_to_the_last_bit(library: tuple[Library, Path]) -> None:
    _, folder = library
    program = folder / "example"
    sources = ["example.c", "autobalancer.c", "kernels_linux.o"]
    flags = ["-std=c11", "-O2", "-Wall", "-Wextra", "-Werror", "-fno-strict-aliasing"]
    subprocess.run(["cc", *flags, *sources, "-o", str(program), "-lm"], cwd=folder, check=True)
    said = subprocess.run([str(program), repr(END), "7"], capture_output=True, text=True, check=True).stdout
    rows = np.array([[float(word) for word in line.split()] for line in said.splitlines() if line[0] != "#"])
    run = in_python(rows[:, 0])
    assert (rows[:, 7:9] == run["ball_angle_in_rotor"].values).all()
    assert (rows[:, 6] == run["speed"].values).all()
    assert f"# {run.attrs['steps']} steps" in said
    x = next(float(line.split()[3]) for line in said.splitlines() if line.startswith("# x = "))
    assert x == pytest.approx(run["x"].values[-1], rel=1e-10)  # turned into space by NumPy there


@compiler
def test_where_somebody_looks_does_not_change_the_steps(library: tuple[Library, Path]) -> None:
    """Also where he looks at times that he did not look at in equal distances before."""
    c, _ = library
    times = np.array([0.0, 0.1, 0.1003, 0.11, 0.3, 0.301, END])
    expected = c.run(c.create(), times)
    one = c.create()
    assert (np.array([c.state(one), *(c.step(one, time) for time in times[1:])]) == expected).all()


@compiler
def test_a_changed_parameter_is_the_changed_machine(library: tuple[Library, Path]) -> None:
    c, _ = library
    times, one = np.array([0.0, END]), c.create()
    for path, factor in {
        "rotor.mass": 1.1,
        "balancers[1].races[1].balls[1].mass": 0.9,
        "rotor.stiffness": 1.03,
    }.items():
        number = c.parameters.index(path)
        c.c.ab_set_parameter(one, number, ctypes.c_double(factor * c.c.ab_parameter(one, number)))
    old = ab.load_machine(MACHINES / "stall_and_release.toml")
    run = in_python(times, **{
        "rotor__mass": 1.1 * old.rotor.mass, "rotor__stiffness": 1.03 * old.rotor.stiffness,
        "balancers[1]__races[1]__balls[1]__mass": 0.9 * old.balancers[0].races[0].balls[0].mass,
    })  # fmt: skip
    assert c.run(one, times)[-1, 6:8] == pytest.approx(run["ball_angle_in_rotor"].values[-1], abs=1e-6)
    assert abs(c.run(c.create(), times)[-1, 6] - run["ball_angle_in_rotor"].values[-1, 0]) > 1e-3


@compiler
def test_a_saved_machine_goes_on_as_if_it_had_never_stopped(library: tuple[Library, Path]) -> None:
    c, _ = library
    one, other = c.create(), c.create()
    c.step(one, 0.2)
    kept = ctypes.create_string_buffer(c.c.ab_saved_size())
    c.c.ab_save(one, kept)
    assert c.c.ab_restore(other, kept) == 0
    assert (c.step(one, 0.4) == c.step(other, 0.4)).all()


@compiler
def test_a_host_that_integrates_finds_impacts_by_indicators(library: tuple[Library, Path]) -> None:
    """Balls that meet leave each other with the restitution of the race, and their common angular momentum stays."""
    c, _ = library
    one, state, signs = c.create(), np.zeros(len(c.states)), np.zeros(c.c.ab_indicator_count())

    def asked(function: Any, *arrays: np.ndarray) -> None:
        assert function(one, ctypes.c_double(0.0), *(ctypes.c_void_p(each.ctypes.data) for each in arrays)) == 0

    c.c.ab_state(one, ctypes.c_void_p(state.ctypes.data))
    asked(c.c.ab_event, state)
    asked(c.c.ab_indicators, state, signs)
    assert signs.size == 3
    assert (signs > 0.0).all()
    state[7] -= signs[0] + 1e-9  # the second ball back to the first one
    state[8:10] = 1.0, -1.0
    asked(c.c.ab_indicators, state, signs)
    assert signs[0] < 0.0 < signs[1]
    asked(c.c.ab_event, state)
    asked(c.c.ab_indicators, state, signs)
    assert (signs > 0.0).all()
    assert state[8] == pytest.approx(-state[9], rel=1e-6)
    assert -1.0 < state[8] < -0.1


@compiler
def test_what_is_not_possible_is_refused_and_changes_nothing(library: tuple[Library, Path]) -> None:
    c, _ = library
    one = c.create()
    before = c.step(one, 0.1)
    assert c.c.ab_step(one, ctypes.c_double(0.05)) == 5
    assert c.c.ab_set_parameter(one, 0, ctypes.c_double(float("nan"))) == 5
    assert c.c.ab_set_parameter(one, 99, ctypes.c_double(1.0)) == 5
    for path, value in {"rotor.mass": 0.0, "rotor.inertia": -1.0, "rotor.damping": -1.0}.items():
        assert c.c.ab_set_parameter(one, c.parameters.index(path), ctypes.c_double(value)) == 5
    assert c.c.ab_set_input(one, ctypes.c_double(1.0)) == 5
    assert (c.state(one) == before).all()


@pytest.mark.parametrize("name", ["rigid_rotor", pytest.param("variant_magnets", marks=pytest.mark.slow)])
def test_parameters_change_the_numbers_of_a_machine_as_the_assembly_does(name: str) -> None:
    machine = ab.load_machine(MACHINES / f"{name}.toml")
    known = parameters_of(machine, _image_of)
    factors = np.linspace(0.9, 1.1, len(known.parameters))
    for about, factor in zip(known.parameters, factors, strict=True):
        machine = with_entry(machine, about.name, factor * about.start)
    base, image = _image_of(ab.load_machine(MACHINES / f"{name}.toml")), _image_of(machine)
    changes: dict[int, float] = {}
    for term in known.terms:
        changes[term.word] = changes.get(term.word, 0.0) + change_by(term, factors)
    said = np.array([base.values[word] + change for word, change in changes.items()])
    assert np.abs(said - image.values[list(changes)]).max() <= 1e-8 * np.abs(said).max()
    assert (
        np.abs(said / image.values[list(changes)] - 1.0)[base.noise[list(changes)] < 1e-12 * np.abs(said)] < 1e-8
    ).all()
    assert len(changes) > 10
    assert any(about.name.startswith("unbalances[1]") for about in known.parameters)


@compiler
def test_balls_alone_are_the_element_of_the_package(tmp_path: Path) -> None:
    text = (
        (MACHINES / "rigid_rotor.toml")
        .read_text()
        .replace("[[balancers.races]]", "[[balancers.races]]\ncollisions = false")
    )
    machine = ab.parse_machine(text)
    ab.export(machine, tmp_path / "balls", part="balancer")
    c, element = Library(tmp_path / "balls"), ab.balancer_element(machine)
    rows, n, draw = len(element.rows), element.state.size // 2, np.random.default_rng(1)
    shaft, rotor, balls = 1e-4 * draw.normal(size=2 * rows), np.array([0.3, 200.0]), draw.normal(size=2 * n)
    shapes = (rows + 1,), (rows + 1, rows + 1), (n,), (n, rows + 1)
    found = [np.zeros(shape) for shape in shapes]
    given = (ctypes.c_void_p(each.ctypes.data) for each in (shaft, rotor, balls, *found))
    assert c.c.ab_element(c.create(), ctypes.c_double(0.0), *given) == 0
    for one, other in zip(found, element.forms(0.0, shaft, rotor, balls), strict=True):
        assert one == pytest.approx(other, rel=1e-14, abs=1e-300)
    # a step with a shaft that accelerates, beside SciPy
    one, acceleration = c.create(), np.array([0.3, -0.2, 50.0])
    for i, value in enumerate([*shaft, *acceleration[:rows], *rotor, acceleration[rows]]):
        assert c.c.ab_set_input(one, i, ctypes.c_double(value)) == 0

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        q, v, a = shaft[:rows], shaft[rows:], acceleration[:rows]
        moved = np.concatenate([q + t * v + 0.5 * t * t * a, v + t * a])
        turned = np.array(
            [rotor[0] + t * rotor[1] + 0.5 * t * t * acceleration[rows], rotor[1] + t * acceleration[rows]]
        )
        return element.rates(t, moved, turned, y, acceleration)[1]

    exact = solve_ivp(rates, (0.0, 0.05), element.state, method="DOP853", rtol=1e-11, atol=1e-12).y[:, -1]
    assert c.step(one, 0.05) == pytest.approx(exact, abs=1e-7)
    assert set(c.parameters) >= {"balancers[1].races[1].drag.damping"}
    assert not any(path.startswith("drive") for path in c.parameters)
    names = [*c.states, *c.outputs, *c.parameters, *c.names(3)]
    assert len(set(names)) == len(names) == 4 + 3 + 4 + 3 + 9 + len(c.parameters) + 9


def test_a_drive_from_outside_must_be_of_the_kind_of_the_machine(tmp_path: Path) -> None:
    with pytest.raises(QuestionError, match="this one gives a speed: take 'speed'"):
        ab.export(MACHINES / "discoidal.toml", tmp_path / "out", drive="torque")
    with pytest.raises(QuestionError, match="follows a target speed"):
        ab.export(MACHINES / "stall_and_release.toml", tmp_path / "out", drive="torque")
    with pytest.raises(QuestionError, match="which is a file; must be a folder"):
        ab.export(MACHINES / "discoidal.toml", MACHINES / "discoidal.toml")
    with pytest.raises(QuestionError, match="tolerance"):
        ab.export(MACHINES / "discoidal.toml", tmp_path / "out", tolerance=0.0)
    with pytest.raises(QuestionError, match="lags behind a speed that is not known beforehand"):
        ab.export(MACHINES / "real_race.toml", tmp_path / "out", drive="speed")


@compiler
@pytest.mark.parametrize("version", ["2.0", pytest.param("3.0", marks=pytest.mark.slow)])
def test_an_fmu_is_valid_and_runs_as_the_package(version: Any, tmp_path: Path) -> None:
    fmpy = pytest.importorskip("fmpy")
    from fmpy.validation import validate_fmu

    text = (MACHINES / "variant_partitions.toml").read_text()
    times, speeds = '"10 s", "30 s", "45 s"', '"40 rad/s", "40 rad/s"'  # a corner of the drive within the run
    assert times in text
    assert speeds in text
    machine = ab.parse_machine(
        text.replace(times, '"1.8 s", "30 s", "45 s"').replace(speeds, '"7.2 rad/s", "40 rad/s"')
    )
    unit = tmp_path / "partitions.fmu"
    ab.export(machine, unit, fmi=version, duration=2.0)
    assert unit.stat().st_size < 3e6
    assert validate_fmu(str(unit)) == []
    run = ab.simulate(machine, duration=2.0, save=ab.Samples(51), method="dormand_prince_8")
    expected = {"x": run.x, "speed": run.speed, "ball_angle_in_rotor[1]": run.ball_angle_in_rotor[:, 0]}
    asked: Any = {"stop_time": 2.0, "output_interval": 0.04, "output": [*expected]}
    found = fmpy.simulate_fmu(str(unit), fmi_type="CoSimulation", **asked)
    for name, values in expected.items():
        assert np.abs(found[name] - values.values).max() < 1e-9 * np.abs(values.values).max()
    # integrated by the importer, with its own error: both balls strike a partition and come to rest there
    asked |= {"solver": "CVode", "relative_tolerance": 1e-9}
    found = fmpy.simulate_fmu(str(unit), fmi_type="ModelExchange", **asked)
    assert 10 < found.size - run.time.size < 100  # each event twice, before and after
    regular = np.searchsorted(found["time"], run.time.values - 1e-9)
    assert np.abs(found["ball_angle_in_rotor[1]"][regular] - run.ball_angle_in_rotor.values[:, 0]).max() < 1e-6
    assert np.abs(found["speed"][regular] - run.speed.values).max() < 1e-9  # an importer goes over no corner
    assert (run.ball_speed_in_rotor.values[[0, -1]] == 0.0).all()
