"""All kernels of a fresh checkout, each compiled by one of several processes: ``python -m tests.references.compiled [2]``."""

from __future__ import annotations

import ast
import gc
import inspect
import os
import subprocess
import sys
import time
from contextlib import suppress
from functools import cache
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import autobalancer
from autobalancer.kernels.compiler.cache import declared_in

ROOT = Path(autobalancer.__file__).parents[1]
KERNELS = ROOT / "autobalancer/kernels"
IMPORTED, CALLED = "-imported", "-called"  # what declares its types, and what the integrators are given
INTEGRATORS = "autobalancer.kernels.integrators"
TYPES = {f"{INTEGRATORS}.integrator_state", f"{INTEGRATORS}.collocation"}  # of what they are given
PATIENCE = 300.0  # s without any news of the others; then a process goes on by itself


@cache
def modules() -> dict[str, set[str]]:
    """Names of the modules with kernels, and those that each imports."""
    files = {".".join(path.relative_to(ROOT).with_suffix("").parts): path for path in KERNELS.rglob("*.py")}
    found = {name.removesuffix(".__init__"): path for name, path in files.items()}
    return {name: _imported(path) & found.keys() - {name} for name, path in found.items()}


def _imported(path: Path) -> set[str]:
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    return names


@cache
def _all_below(name: str) -> frozenset[str]:
    return frozenset().union({name}, *map(_all_below, modules()[name]))


@cache
def called_by_address(module: str) -> dict[str, Any]:
    """The functions of a module that the integrators get as an argument, known by the names of theirs, and their types."""
    from autobalancer.kernels.integrators.collocation import nodes_type, watch_type
    from autobalancer.kernels.integrators.integrator_state import switch_type
    from autobalancer.kernels.system import rhs_type

    kinds = {
        ("time", "y", "dy", "system"): rhs_type,
        ("ask", "time", "rates", "parameters", "pair"): switch_type,
        ("time", "step", "system", "amplitudes"): nodes_type,
        ("step", "system", "amplitudes"): watch_type,
    }
    functions = inspect.getmembers(import_module(module), lambda value: getattr(value, "py_func", None))
    own = {name: value for name, value in functions if value.py_func.__module__ == module}
    named = {name: kinds.get(tuple(inspect.signature(value.py_func).parameters)) for name, value in own.items()}
    return {name: kind for name, kind in named.items() if kind and not own[name].targetoptions.get("inline")}


class Board:
    """A folder where processes note what they do: who creates a note has the work."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.done: set[str] = set()

    def takes(self, work: str) -> bool:
        """Whether this process has the work; then nobody else has it."""
        try:
            (self.folder / f"{work}.taken").touch(exist_ok=False)
        except FileExistsError:
            return False
        return True

    def note(self, work: str) -> None:
        """It is done."""
        (self.folder / f"{work}.done").touch()

    def look(self) -> None:
        """See what is done by now."""
        self.done = {name.removesuffix(".done") for name in os.listdir(self.folder) if name.endswith(".done")}


def compile_in_turns(folder: Path) -> None:
    """Compile what no other process has taken, until all is done. Modules come before those that import them.

    The equations of motion, which take longest, come first among what is called.
    """
    board, names = Board(folder), sorted(modules(), key=lambda name: len(_all_below(name)))
    waiting = [*((name, IMPORTED) for name in names), *((name, CALLED) for name in reversed(names))]
    news, known, room = time.monotonic(), -1, ""
    while waiting and time.monotonic() - news < PATIENCE:
        board.look()
        if len(board.done) > known:
            known, news = len(board.done), time.monotonic()
        waiting = [work for work in waiting if "".join(work) not in board.done]
        ready = [work for work in waiting if _before(*work) <= board.done]
        ready.sort(key=lambda work: _room(work[0]) != room)  # kernels of one room share parts that no disk keeps
        mine = next((work for work in ready if board.takes("".join(work))), None)
        if mine is None:
            time.sleep(0.05)
            continue
        with suppress(Exception):  # a test will say it better
            _compile(*mine)
        board.note("".join(mine))
        room = _room(mine[0])


def _room(module: str) -> str:
    return module.rpartition(".")[0]


@cache
def _before(module: str, part: str) -> frozenset[str]:
    names = _all_below(module) - {module} if part == IMPORTED else _all_below(module).union(*map(_all_below, TYPES))
    return frozenset(name + IMPORTED for name in names)


def _compile(module: str, part: str) -> None:
    loaded = import_module(module)
    for kernel in declared_in(loaded) if part == IMPORTED else []:
        kernel.compile(None)
    if part == CALLED:
        for name, kind in called_by_address(module).items():
            getattr(loaded, name).compile(kind.signature)


def compile_all(processes: int) -> None:
    """Compile what is not there, by several processes."""
    with TemporaryDirectory() as folder:
        words = [sys.executable, "-m", "tests.references.compiled", "--in-turns", folder]
        others = [subprocess.Popen(words) for _ in range(processes)]
        failed = [one.wait() for one in others]
    if any(failed):
        print(f"compiling ended with {failed}; the tests compile the rest, and say what is wrong")


if __name__ == "__main__":
    if sys.argv[1:2] == ["--in-turns"]:
        gc.set_threshold(200_000, 20, 20)  # as the commands do: looking for garbage takes an eighth of a compilation
        compile_in_turns(Path(sys.argv[2]))
    else:
        compile_all(int(sys.argv[1]) if sys.argv[1:] else os.cpu_count() or 1)
