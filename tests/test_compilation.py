"""Kernels are compiled once, and do the same as when interpreted."""

from __future__ import annotations

import ast
import json
import os
import pickle
import re
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any, NamedTuple

import numba
import numpy as np
import pytest
from tests.references import compiled
from tools import wheel

from autobalancer.kernels.compiler import cache, flags
from autobalancer.kernels.compiler.cache import KINDS, TEXT, Announcement
from autobalancer.kernels.compiler.callbacks import callback
from autobalancer.kernels.compiler.flags import EXACT, njit
from autobalancer.kernels.compiler.inlining import KernelCompiler
from autobalancer.kernels.compiler.kept import _Files
from autobalancer.kernels.compiler.lazy import Kernel
from autobalancer.kernels.compiler.numba_struct import Struct, passed_by_address, struct_type
from autobalancer.kernels.records import BALL

ROOT = Path(__file__).parents[1]
KERNELS = ROOT / "src/autobalancer/kernels"

RACES = """
import autobalancer as ab
from autobalancer.machine import Machine
from autobalancer.simulation.record import Envelope, LastRevolutions, Samples
from autobalancer.simulation.record import Event
rotor = {"mass": 10.0, "stiffness": 6e5, "damping": 80.0, "inertia": 0.05}
drive = {"kind": "torque", "torque": 3.0}
forces = [{"kind": "race_springs", "stiffness": 30.0}, {"kind": "radial_spring", "stiffness": 9e3, "free_length": 0.05}]
balls = [{"mass": 4e-3, "motion": "point", "count": 2, "start_angles": [0.5, 2.0]}]
race = {"orbit_radius": 0.1, "drag": {"law": "viscous", "damping": 1e-4}, "forces": forces, "balls": balls}
parts = {"unbalances": [{"moment": 4e-4}], "balancers": [{"races": [race]}], "drive": drive}
machine = Machine(name="second", axis="vertical", rotor=rotor, **parts)
run = ab.simulate(machine, duration=1.0, save=[Samples(30), Envelope(5), LastRevolutions(1, 8)],
                  events=[Event("speed", 20.0)])
last = [*run.x.values[-3:], *run.ball_angle_in_rotor.values[-1]]
print("races:", *[float(v).hex() for v in last], float(run.attrs["steps"]).hex())
"""

CHAMBER = """
import numpy as np
from tests.references.chamber_machines import small_machine
from autobalancer.simulation.chamber import simulate_chamber
ball = {"count": 2, "density": 7800.0, "mass": 0.1, "spins": [[9.0, 0.0, 40.0], [0.0, 0.0, 0.0]]}
places = {"positions": [[0.0, 0.0, -0.085], [0.0, 0.03, -0.07]], "velocities": [[1.0, 2.0, -3.0], [0.0, -3.0, -1.0]]}
machine = small_machine(chambers=[{"radius": 0.1, "depth": 0.2, "balls": [ball | places]}], start={"speed": 50.0},
                        contact={"law": "history", "restitution": 0.5, "friction": 0.3, "stiffness": 1e8})
run = simulate_chamber(machine, duration=1e-3, step=2e-5)
values = [run.ball_velocity, run.ball_spin, run.body_position, run.bearing_force, run.speed, run.loss_friction]
print("chamber:", *[float(v).hex() for v in np.concatenate([v.values[-1].ravel() for v in values])])
"""

OTHERS = """
ab.simulate("examples/machines/rigid_rotor.toml", duration=0.05)
ab.simulate("docs/machines/real_race.toml", duration=0.05)
ab.basin("examples/machines/discoidal.toml", 100.0, random=2, hold=0.1)
ab.ensemble("examples/machines/discoidal.toml", {"drag": [1e-4, 2e-4]}, duration=0.05)
ab.stability.map("examples/machines/discoidal.toml", {"speed": [60.0, 64.0], "viscosity": [1e-6, 2e-5]})
"""


def fresh_process(script: str, **environment: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", script],
        env=os.environ | environment,
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout


@pytest.fixture(scope="module")
def second() -> str:
    """What a process says of its kernels and results after another one has done the same."""
    script = RACES + CHAMBER + OTHERS
    fresh_process(script)
    return fresh_process(script, NUMBA_DEBUG_CACHE="1")


def values(said: str, kind: str) -> np.ndarray:
    (line,) = (line for line in said.splitlines() if line.startswith(f"{kind}:"))
    return np.array([float.fromhex(word) for word in line.split()[1:]])


@pytest.mark.slow
def test_a_second_process_compiles_nothing(second: str) -> None:
    assert "index saved to" not in second
    loaded = [line for line in second.splitlines() if "index loaded from" in line]
    for kernel in (
        "planar.planar",
        "race_springs.RaceSprings.force",
        "on_stations.guided",
        "on_stations.guided_rough",
        "integrate",
        "verlet",
        "characteristic",
    ):
        assert any(kernel in line for line in loaded), kernel
    assert any("advance" in line for line in loaded)


@numba.njit(inline="always")
def doubled(x: float) -> float:
    return 2.0 * x


@numba.njit(inline="always")
def bent(x: float, many: int) -> float:
    if x < 0.0:
        return doubled(-x)
    for i in range(many):
        x = doubled(x) - doubled(1.0 / (i + x))
    return x


def called_often(x: float, many: int) -> float:
    return bent(bent(x, many) - many, 3) + bent(doubled(x), 1)


def test_the_own_inlining_gives_the_code_of_numba() -> None:
    """Instruction by instruction; names have the number of the compilation."""
    code = []
    for pipeline in (None, KernelCompiler):
        kernel = numba.njit("f8(f8, i8)", error_model="numpy", pipeline_class=pipeline)(called_often)
        (compiled,) = kernel.overloads.values()
        code.append([line for line in compiled.library.get_asm_str().splitlines() if "_ZN" not in line])
        assert kernel(-1.5, 4) == pytest.approx(called_often(-1.5, 4), rel=1e-14)
    assert len(code[0]) > 50
    assert code[0] == code[1]


def test_an_exact_function_is_not_contracted_by_what_first_compiles_it() -> None:
    """Numba hands on how a function is compiled to those that it calls, if they do not say otherwise."""
    exact = numba.njit("f8(f8, f8)", **{name: value for name, value in EXACT.items() if name != "cache"})
    inner = numba.njit(**{name: value for name, value in EXACT.items() if name != "cache"})(lambda x, y: x * y + 1.0)
    outer = numba.njit("f8(f8)", fastmath={"contract"})(lambda x: inner(x, x) * x)
    alone = exact(lambda x, y: x * y + 1.0)
    assert outer(3.0) == 30.0
    for kernel in (inner, alone):
        (compiled,) = kernel.overloads.values()
        assert "fmul double" in compiled.library.get_llvm_str()


class Inner(NamedTuple):
    """A tuple in a tuple."""

    scale: float
    table: Any


@passed_by_address
class Packed(NamedTuple):
    """As the machines that kernels are given: numbers, arrays of numbers and of records, tuples in it."""

    count: int
    inner: Inner
    rows: Any
    last: float = -0.1


def parts_of(packed: Any, found: Any) -> None:
    """Numbers, and where they lie in arrays."""
    inner = packed.inner
    found[0], found[1], found[2] = packed.count, packed.last, inner.scale
    found[3], found[4], found[5] = inner.table[1, 2], inner.table.shape[0], packed.rows[1].mass


def test_a_tuple_passed_by_address_has_the_parts_that_numba_sees() -> None:
    """Also after a copy that another process could have made, whose arrays lie elsewhere."""
    rows = BALL.rows(2)
    rows.mass = 3.0, 7.0
    first = Packed(4, Inner(2.5, np.arange(6.0).reshape(2, 3)), rows)
    found, kind = np.zeros((3, 6)), numba.typeof(first)
    stock = NamedTuple("Stock", [("count", int), ("inner", Inner), ("rows", Any), ("last", float)])(*first)
    numba.njit(parts_of)(stock, found[0])  # Numba takes two of one name and layout for one
    kernel = numba.njit(numba.void(kind, numba.float64[::1]), _nrt=False)(parts_of)
    kernel(first, found[1])
    copied = pickle.loads(pickle.dumps(first))
    assert copied.address != first.address
    first.inner.table[:] = 0.0
    kernel(copied, found[2])
    assert found.tolist() == [[4.0, -0.1, 2.5, 5.0, 2.0, 7.0]] * 3
    with pytest.raises(TypeError, match="No matching definition"):
        kernel(first._replace(last=1), found[0])  # another layout, so another type


def twice(packed: Any, found: Any) -> None:
    """A number of a tuple, after calls that are inlined."""
    found[0] = doubled(packed.last) + bent(packed.inner.scale, packed.count)


class Kind(NamedTuple):
    """What :func:`twice` takes."""

    count: int
    inner: Inner
    last: float


class StockKind(NamedTuple):
    """The same under another name, as Numba takes two of one name and layout for one."""

    count: int
    inner: Inner
    last: float


PassedKind = passed_by_address(Kind)
PASSED = numba.typeof(PassedKind(4, Inner(2.5, np.ones((2, 3))), -0.1))  # Numba's own cache outlives a type that goes


@pytest.mark.parametrize("piece", ["none", "cache", "callbacks", "inlining", "lazy", "struct"])
def test_a_piece_that_is_left_to_numba_gives_the_same_bits(
    piece: str, place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each can be switched off by itself, should a new version of Numba have another inside."""
    monkeypatch.setenv(cache.SWITCH, piece)
    machine = (passed_by_address(StockKind) if piece == "struct" else PassedKind)(4, Inner(2.5, np.ones((2, 3))), -0.1)
    types, layout = numba.typeof(machine), numba.typeof(StockKind(*machine))
    pipeline = {} if piece == "inlining" else {"pipeline_class": KernelCompiler}
    kernel = njit(numba.void(types, numba.float64[::1]), cache=True, _nrt=False, **pipeline)(twice)
    found = np.zeros(1)
    cache.compile_in_parallel([(kernel, None)])  # as a run does before it begins
    kernel(machine, found)
    assert found[0] == -0.2 + bent.py_func(2.5, 4)
    square = njit(numba.float64(numba.float64), cache=True)(doubled.py_func)
    argument = callback.__wrapped__(square, numba.types.FunctionType(numba.float64(numba.float64)))
    assert {
        "struct": type(machine) is StockKind and struct_type(layout) is layout and not isinstance(types, Struct),
        "lazy": not isinstance(kernel, Kernel),
        "cache": not kept(place),
        "callbacks": argument is square,
    } == {name: name == piece for name in ("struct", "lazy", "cache", "callbacks")}


def test_a_numba_that_was_not_tried_does_all_its_own_way_and_the_user_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """It needs none of the private parts of Numba that our pieces know."""
    script = """
import numba, sys, warnings
numba.__version__ = VERSION
from numba.core import caching, compiler, event, untyped_passes
if VERSION == "9.9.1":  # it lacks names that we know
    del caching._CacheLocator, caching.CompileResultCacheImpl, caching.IndexDataCacheFile, untyped_passes.InlineInlinables
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    from autobalancer.kernels.compiler.flags import NUMBERS
from autobalancer.kernels.trigonometry import sine_cosine
own, announced = "pipeline_class" in NUMBERS, len(event._registered["numba:compile"])
pieces = sum(f"autobalancer.kernels.compiler.{name}" in sys.modules for name in ("inlining", "kept", "lazy"))
print(own, announced, pieces, sine_cosine(0.5)[0].hex(), *{str(one.message).partition(",")[0] for one in caught})
"""
    ours, untried = (
        fresh_process(script.replace("VERSION", repr(version))).split(maxsplit=4)
        for version in (numba.__version__, "9.9.1")
    )
    assert (ours[:3], untried[:3]) == (["True", "1", "1"], ["False", "0", "0"])
    assert ours[3].strip() == untried[3]
    assert untried[4].strip() == "Numba 9.9.1 is not among the versions tried"
    monkeypatch.setenv(cache.SWITCH, "all")
    assert cache.stock("struct")


def kept(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.rglob("*.nb[ic]"))


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder for kernels, named as a user names it."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "kernels"))
    cache.cache_place.cache_clear()
    yield tmp_path / "kernels"
    cache.cache_place.cache_clear()


def kernel_of(file: Path, text: str) -> Any:
    """A kernel in a file, as another process would find it."""
    file.write_text(text, encoding="utf-8")
    cache._content.cache_clear()
    cache.stamp_of.cache_clear()
    sys.modules["law_of_a_test"] = module = ModuleType("law_of_a_test")
    exec(compile(text, str(file), "exec"), vars(module))  # Python's own cache does not see an edit within a second
    return njit("f8(f8)", cache=True)(module.law)


def test_kernels_lie_in_the_place_that_is_named_whatever_numba_was_told(
    place: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Numba takes its place also from a file in the working folder, and runs what it reads there."""
    monkeypatch.setattr("numba.config.CACHE_DIR", str(tmp_path / "foreign"))
    monkeypatch.setattr("numba.config.CACHE_LOCATOR_CLASSES", "foreign.Locator")
    assert kernel_of(tmp_path / "law.py", "def law(x): return 2.0 * x")(1.5) == 3.0
    assert len(kept(place)) == 2
    assert not (tmp_path / "foreign").exists()


def test_a_changed_source_is_compiled_anew_and_the_older_kernel_goes(place: Path, tmp_path: Path) -> None:
    file = tmp_path / "law.py"
    kernel_of(file, "def law(x): return 2.0 * x")
    first = kept(place)
    assert kernel_of(file, "def law(x): return 2.0 * x").stats.cache_hits
    assert kernel_of(file, "# moved\ndef law(x): return 3.0 * x")(1.5) == 4.5
    assert len(kept(place)) == 2
    assert not set(first) & set(kept(place))


@pytest.mark.parametrize("kind", ["nbi", "nbc"])
@pytest.mark.parametrize("content", ["empty", "cut", "other", "half-copied"])
def test_a_damaged_kernel_is_compiled_anew(kind: str, content: str, place: Path, tmp_path: Path) -> None:
    kernel_of(tmp_path / "law.py", "def law(x): return 2.0 * x")
    (file,) = place.rglob(f"*.{kind}")
    whole = file.read_bytes()
    half = whole[: len(whole) // 2].ljust(len(whole), b"\0")  # as a copy to a disk that was full
    file.write_bytes({"empty": b"", "cut": whole[:-5], "other": b"garbage" * 9, "half-copied": half}[content])
    again = kernel_of(tmp_path / "law.py", "def law(x): return 2.0 * x")
    assert again(1.5) == 3.0
    assert not again.stats.cache_hits
    assert kernel_of(tmp_path / "law.py", "def law(x): return 2.0 * x").stats.cache_hits


def test_two_processes_that_keep_kernels_at_once_do_not_mix_them_up(
    place: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each saw an empty folder before it wrote the kernel for its types."""
    kernel_of(tmp_path / "law.py", "def law(x): return x / 2")
    module = sys.modules["law_of_a_test"]
    with monkeypatch.context() as other:
        other.setattr(_Files, "_load_index", lambda self: {})
        njit("f8(i8)", cache=True)(module.law)
    assert len(list(place.rglob("*.nbc"))) == 2  # so whoever writes the index last, it leads to what it says
    made = njit("f8(i8)", cache=True)(module.law)
    assert made.stats.cache_hits
    assert made(3) == 1.5


def test_a_folder_of_another_user_is_not_used_and_said(
    place: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its owner could put code there."""
    place.mkdir()
    if os.getuid() == 0:
        os.chown(place, 2000, -1)
    else:
        monkeypatch.setattr("os.getuid", lambda: 2000)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    kept, note = cache.prepare_cache()
    assert note.startswith(
        f"compiled equations cannot be kept in NUMBA_CACHE_DIR ({place}), which belongs to another user; "
    )
    assert cache.cache_place() == (tmp_path / f"autobalancer-kernels-{os.getuid()}" if kept else None)


@pytest.fixture
def shipped(place: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Two kernels that a wheel carries, on another processor of its level, where nothing can be kept."""
    kernel_of(tmp_path / "law.py", LAW)
    njit("f8(i8)", cache=True)(sys.modules["law_of_a_test"].law)
    wheel.gather(place, tmp_path / "compiled", {cache.stamp_of(tmp_path / "law.py")})
    monkeypatch.setattr(cache, "SHIPPED", tmp_path / "compiled")
    monkeypatch.setattr(cache, "_complaints", {})
    for name in ("on_start", "on_end"):  # else it says the complaints, if a test has loaded it
        monkeypatch.setattr(cache.Announcement, name, lambda listener, event: None)
    monkeypatch.setattr(cache, "_writable", lambda folder: False)
    monkeypatch.setattr("numba.core.codegen.CPUCodegen.magic_tuple", lambda codegen: ("another", "processor", ""))
    cache.cache_place.cache_clear()
    cache.shipped.cache_clear()
    yield tmp_path / "compiled"
    cache.shipped.cache_clear()


LAW = "def law(x): return 2.0 * x"


def test_kernels_of_a_wheel_are_loaded_without_a_place_that_can_be_written(shipped: Path, tmp_path: Path) -> None:
    before = sorted(tmp_path.rglob("*"))
    assert cache.prepare_cache() == (True, "")
    made = kernel_of(tmp_path / "law.py", LAW)
    assert made(1.5) == 3.0
    assert made.stats.cache_hits
    new = njit("f4(f4)", cache=True)(sys.modules["law_of_a_test"].law)  # for types that the wheel does not know
    assert new(1.5) == 3.0
    assert not new.stats.cache_hits
    assert cache.complaints() == []
    assert {path for path in set(tmp_path.rglob("*")) - set(before) if "__pycache__" not in path.parts} == set()


@pytest.mark.parametrize("damage", ["nbi", "nbc", "json"])
def test_a_damaged_kernel_of_a_wheel_is_not_read_but_compiled_and_said(
    damage: str, shipped: Path, tmp_path: Path
) -> None:
    """A pickle may run anything, so what is not in the list, or not as it is there, is not even opened as one."""
    for file in shipped.glob(f"*.{damage}"):
        file.write_bytes(b"cos\nmkdir\n(V" + str(tmp_path / "ran").encode() + b"\ntR.")
    made = kernel_of(tmp_path / "law.py", LAW) if damage != "json" else None
    assert made is None or (made(1.5) == 3.0 and not made.stats.cache_hits)
    assert damage != "json" or cache.shipped() is None
    (said,) = cache.complaints()
    assert said.startswith("the compiled equations of the package")
    assert {"json": "have a damaged list"}.get(damage, f".{damage} has another content") in said
    assert cache.complaints() == []  # once
    assert not (tmp_path / "ran").exists()


def test_a_wheel_for_other_versions_or_processors_says_what_does_not_fit(
    shipped: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    told = json.loads((shipped / cache.LIST).read_text())
    triple, _, features = told["processor"]
    wrong = {"Numba": "0.1", "llvmlite": "0.2"}
    for change, words in (
        ({"made with": told["made with"] | wrong}, "were made with Numba 0.1, llvmlite 0.2, here is Numba "),
        (
            {"processor": [triple, "x86-64-v9", f"{features},+avx2048"]},
            "of the level x86-64-v9, this one lacks avx2048",
        ),
    ):
        (shipped / cache.LIST).write_text(json.dumps(told | change))
        cache.shipped.cache_clear()
        assert cache.shipped() is None
        (said,) = cache.complaints()
        assert words in said


def test_a_source_that_was_changed_does_not_use_the_kernels_of_the_wheel(shipped: Path, tmp_path: Path) -> None:
    made = kernel_of(tmp_path / "law.py", "def law(x): return 3.0 * x")
    assert made(1.5) == 4.5
    assert cache.complaints() == ["the compiled equations of the package do not fit the sources, which were changed"]


def test_an_edit_of_a_kernel_changes_the_stamp_of_those_that_use_it_and_of_no_other(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The stepper uses the record of a system, the roots of the characteristic equation do not use the stepper."""
    system, stepper, roots = (cache.HERE / n for n in ("system.py", "integrators/runge_kutta.py", "characteristic.py"))

    def stamps() -> list[str]:
        cache.stamp_of.cache_clear()
        return [cache.stamp_of(path) for path in (system, stepper, roots)]

    before, read = stamps(), cache._content
    monkeypatch.setattr(cache, "_content", lambda path: read(path) + b"#" * (path == stepper))
    assert [new == old for new, old in zip(stamps(), before, strict=True)] == [True, False, True]
    monkeypatch.setattr(cache, "_content", lambda path: read(path) + b"#" * (path == system))
    assert [new == old for new, old in zip(stamps(), before, strict=True)] == [False, False, False]
    monkeypatch.undo()
    assert stamps() == before


def test_a_kernel_is_compiled_when_it_is_first_used_and_then_for_its_own_types_only(
    place: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(flags, "HERE", tmp_path)
    kernel = kernel_of(tmp_path / "law.py", "def law(x): return 2.0 * x")
    assert not kernel.overloads
    assert kept(place) == []
    assert kernel(3) == 6.0
    assert [str(types) for types in kernel.overloads] == ["(float64,)"]
    with pytest.raises(TypeError, match="No matching definition"):
        kernel("three")
    assert len(kept(place)) == 2


def test_who_wants_a_kernel_that_another_process_compiles_waits_for_it(tmp_path: Path) -> None:
    lock = tmp_path / "kernel.lock"
    holder = f"from pathlib import Path; from autobalancer.kernels.compiler import cache; here = Path({str(lock)!r})"
    script = f"{holder}; print(cache.take(here), flush=True); input(); cache.give(here)"
    with subprocess.Popen([sys.executable, "-c", script], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as other:
        assert other.stdout is not None
        assert other.stdin is not None
        assert other.stdout.readline() == b"False\n"  # it had not to wait
        with ThreadPoolExecutor(1) as worker:
            waiting = worker.submit(cache.take, lock)
            with pytest.raises(TimeoutError):
                waiting.result(0.1)
            other.stdin.write(b"\n")
            other.stdin.flush()
            assert waiting.result(10.0)
    cache.give(lock)
    assert not lock.exists()


def test_a_check_uses_four_kernels_and_no_integrator() -> None:
    script = "from autobalancer.cli import app; app(['check', 'examples/machines/discoidal.toml'])"
    said = fresh_process(script, NUMBA_DEBUG_CACHE="1")
    used = set(re.findall(r"(?:index|data) (?:loaded from|saved to) .*/([\w.]+)-\d+-", said))
    assert {"observables.observe_locked_balls", "characteristic.growth_rates"} <= used
    assert len(used) <= 4, used


def test_without_a_place_that_can_be_written_kernels_go_to_a_private_folder_or_nowhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "file"))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    cache.cache_place.cache_clear()
    kept, note = cache.prepare_cache()
    private = cache.cache_place()
    assert kept
    assert private is not None
    assert private.parent == tmp_path
    assert private.stat().st_mode & 0o777 == 0o700
    assert f"cannot be kept in NUMBA_CACHE_DIR ({tmp_path / 'file'}); they are kept in {private}" in note
    private.chmod(0o777)  # anybody may have put code there
    cache.cache_place.cache_clear()
    kept, note = cache.prepare_cache()
    cache.cache_place.cache_clear()
    assert not kept
    assert "compiled anew each time" in note


def test_a_package_that_cannot_be_written_and_no_home_still_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setattr(cache, "_writable", lambda folder: folder.parent == tmp_path)
    cache.cache_place.cache_clear()
    kept, note = cache.prepare_cache()
    place = cache.cache_place()
    cache.cache_place.cache_clear()
    assert kept
    assert "neither the package nor the home folder" in note
    assert place is not None
    assert place.parent == tmp_path


@pytest.mark.slow
def test_interpreted_kernels_do_the_same_as_compiled_ones(second: str) -> None:
    interpreted = fresh_process(RACES + CHAMBER, NUMBA_DISABLE_JIT="1")
    *states, steps = values(second, "races")
    np.testing.assert_allclose(values(interpreted, "races")[:-1], states, rtol=1e-9, atol=1e-16)
    assert values(interpreted, "races")[-1] == steps
    assert np.abs(values(second, "chamber")).max() > 10.0
    np.testing.assert_allclose(values(interpreted, "chamber"), values(second, "chamber"), rtol=1e-9, atol=1e-12)


@pytest.mark.slow
def test_steps_of_a_chamber_need_no_python_and_take_several_contacts_at_once() -> None:
    from autobalancer.kernels.chamber.time_steps import verlet

    verlet.compile(None)
    (kernel,) = verlet.overloads.values()
    code = str(kernel.library._get_module_for_linking())  # also of a kernel that was loaded
    functions = dict(re.findall(r'^define [^@]*@"?([^"(]+)"?\((.*?)^}', code, re.MULTILINE | re.DOTALL))
    bodies = [body for name, body in functions.items() if not name.startswith("_ZN7cpython")]  # what only Python calls
    needed = {name for body in bodies for name in re.findall(r'(?:call|invoke) [^@\n]*@"?([^"(]+)"?\(', body)}
    outside = {name for name in needed - functions.keys() if not name.startswith("llvm.")}
    assert outside <= {"sqrt", "sin", "cos", "atan2"}
    assert len(bodies) > 1
    assert [name for name in needed if name.startswith("llvm.sqrt.v")]


@pytest.mark.slow
def test_the_first_compilation_is_announced_in_one_line_and_a_second_process_says_nothing(tmp_path: Path) -> None:
    code = "from autobalancer.kernels.derivatives import derivatives; derivatives.compile(None)"
    said = []
    for _ in range(2):
        done = subprocess.run(
            [sys.executable, "-c", code],
            env=os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)},
            capture_output=True,
            text=True,
            check=True,
        )
        assert done.stdout == ""
        said.append(done.stderr)
    assert said[0] == "autobalancer: first use of this version: compiling, up to a minute\n"
    assert said[1] == ""


def test_the_announcement_names_each_kind_once_and_not_the_kernels_within_a_kernel(
    capsys: pytest.CaptureFixture[str],
) -> None:
    def kernel(module: str) -> SimpleNamespace:
        dispatcher = SimpleNamespace(py_func=SimpleNamespace(__module__=module))
        return SimpleNamespace(data={"dispatcher": dispatcher})

    told = Announcement()
    for outer, inner in (
        ("autobalancer.kernels.balls.on_stations", "autobalancer.kernels.laws.contact_law"),
        ("autobalancer.kernels.balls.on_stations", "autobalancer.kernels.balls.planar"),
        ("autobalancer.kernels.chamber.time_steps", "autobalancer.kernels.chamber.time_steps"),
        ("somebody.elses", "autobalancer.kernels.dwell"),
    ):
        told.on_start(kernel(outer))
        told.on_start(kernel(inner))
        told.on_end(kernel(inner))
        told.on_end(kernel(outer))
    lines = capsys.readouterr().err.splitlines()
    assert lines == [
        f"autobalancer: first use of {kind}: compiling, up to a minute"
        for kind in ("balls on any rotor", "deep chambers")
    ]
    assert max(len(TEXT.format(kind)) for kind in KINDS.values()) <= 80


def test_every_kind_that_is_announced_is_a_kernel() -> None:
    assert all((cache.HERE / name).is_dir() or any(cache.HERE.rglob(f"{name}.py")) for name in KINDS)


def test_two_processes_share_the_kernels_and_each_waits_for_what_it_imports(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    parts = (compiled.IMPORTED, compiled.CALLED)
    works = sorted((name, part) for name in compiled.modules() for part in parts)
    assert len(works) > 100
    done: list[tuple[str, str]] = []

    def pretend(module: str, part: str) -> None:
        assert not [name for name in compiled.modules()[module] if (name, compiled.IMPORTED) not in done]
        done.append((module, part))

    monkeypatch.setattr(compiled, "_compile", pretend)
    with ThreadPoolExecutor(2) as workers:
        list(workers.map(compiled.compile_in_turns, [tmp_path, tmp_path]))
    assert sorted(done) == works


def test_what_only_kernels_may_call_is_never_called_from_python() -> None:
    """Such a call ends the process: there is no code that takes arguments of Python."""
    flags = r"\*\*(ADDRESSED|APART|EQUATIONS|MERGED|\w*PART)$"
    unseen = {
        (path.relative_to(KERNELS).with_suffix("").as_posix().replace("/", "."), function.name)
        for path in KERNELS.rglob("*.py")
        for function in _functions(path, flags)
    }
    assert len(unseen) > 200
    for path in (*(ROOT / "src").rglob("*.py"), *(ROOT / "tests").rglob("*.py")):
        if KERNELS in path.parents or "kernels" not in path.read_text(encoding="utf-8"):
            continue
        if imported := _imported(path, unseen):
            compiled_here = {call.lineno for function in _functions(path, "") for call in _calls(function)}
            called = {call.func.id for call in _calls(_tree(path)) if call.lineno not in compiled_here}
            assert not called & imported, path


def _tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def _functions(path: Path, flags: str) -> list[ast.FunctionDef]:
    """Those that are compiled with such flags."""
    functions = [node for node in ast.walk(_tree(path)) if isinstance(node, ast.FunctionDef)]
    decorated = [(node, ast.unparse(d)) for node in functions for d in node.decorator_list]
    return [node for node, text in decorated if text.startswith("njit") and re.search(flags, text.rstrip(")"))]


def _calls(tree: ast.AST) -> set[Any]:
    return {node for node in ast.walk(tree) if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)}


def _imported(path: Path, unseen: set[tuple[str, str]]) -> set[str]:
    imports = [node for node in ast.walk(_tree(path)) if isinstance(node, ast.ImportFrom) and node.module]
    return {
        name.asname or name.name
        for node in imports
        for name in node.names
        if (str(node.module).removeprefix("autobalancer.kernels."), name.name) in unseen
    }
