"""Where compiled kernels are kept, and which of them still fit their sources.

They lie in the folder named by ``NUMBA_CACHE_DIR``, else beside the kernels, else in the user's folder for caches. Where
none of these can be written (a package of the system, a user without a home) they go to a private folder among the temporary
files, and if that is not possible either, they are compiled in every process. Numba itself would also read a folder that a
file in the working directory names; what it reads there it runs, so its own search is not used.

A kernel is found by content: its name carries a hash of its source and of all kernels that are compiled into it. So an edit
makes what depends on it compile again, and nothing else.

A wheel carries its kernels in ``SHIPPED``, compiled for a level of processors by ``tools/wheel.py``. They are found by the same
names, come first, and are only read: each file as the list of hashes beside them knows it. Where they do not fit, kernels are
compiled as from a checkout.

A kernel is compiled when it is first used; those that a question needs by several processes at once. One that is being compiled
is locked by a file beside its place, which falls with the process that holds it: who wants it meanwhile waits, and loads it.
"""

from __future__ import annotations

import hashlib
import io
import json
import multiprocessing
import os
import pickle
import re
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import llvmlite
import numba

from autobalancer.progress import not_counted

try:
    import fcntl
except ImportError:  # Windows: each process compiles for itself
    fcntl = None  # type: ignore[assignment]

HERE = Path(os.path.abspath(__file__)).parents[1]  # the folder of all kernels
BESIDE = Path("__pycache__")
SHIPPED = HERE / "compiled"
LIST = "kernels.json"  # what the shipped kernels are made for, and the hash of each file
NOT_COMPILED = {f"compiler/{name}.py" for name in ("cache", "kept", "lazy")}  # imported by kernels, not compiled
_IMPORT = re.compile(r"^\s*from (autobalancer\.kernels[\w.]*) import (\([^)]*\)|[^\n]*)", re.MULTILINE)


SWITCH = "AUTOBALANCER_STOCK_NUMBA"  # names pieces that are done as Numba does them, "all" or "none" of them
TRIED = ("0.68",)  # versions of Numba with which all pieces of ours are tried


def stock(piece: str) -> bool:
    """Whether Numba's own way is taken in place of a piece of ours: as the switch says, else with a Numba that is not tried.

    Pieces are ``announce``, ``cache``, ``callbacks``, ``inlining``, ``lazy`` and ``struct``. Results are the same, to the last
    bit; only time is lost. So a new version of Numba whose inside is another one can be used, and tests compare both.
    """
    named = os.environ.get(SWITCH)
    return _is_untried() if named is None else not {piece, "all"}.isdisjoint(named.split(","))


def _is_untried() -> bool:
    return ".".join(numba.__version__.split(".")[:2]) not in TRIED


def _about_numba() -> str:
    """What the user of a version that is not tried should know; empty for others."""
    if SWITCH in os.environ or not _is_untried():
        return ""
    return (
        f"Numba {numba.__version__} is not among the versions tried, {', '.join(TRIED)}: it compiles all equations in its own "
        f"way, anew in each process, which takes minutes; results are the same. Install numba {TRIED[-1]}, or set {SWITCH}=none "
        "to use this one as those"
    )


PATIENCE = 120.0  # s; who has a kernel for longer will not bring it
MOST = 4  # processes
Work = tuple[Any, Any]  # a kernel, and the types of its arguments if it does not declare them


def prepare_cache() -> tuple[bool, str]:
    """Whether kernels can be kept, and what the user should know about it."""
    kept, place_note = (True, "") if stock("cache") else _existing_cache()
    return kept, "; ".join(filter(None, (_about_numba(), place_note)))


def _existing_cache() -> tuple[bool, str]:
    place = cache_place()
    if place is None and shipped() is not None:
        return True, ""
    if place is None:
        return False, f"{_nowhere()}; they are compiled anew each time, which takes half a minute"
    if place == _private_place() and not any_compiled():
        return True, f"{_nowhere()}; they are kept in {place}"
    return True, ""


@cache
def cache_place() -> Path | None:
    """The folder of the kernels, ``BESIDE`` if each lies beside its source; None if there is no place for them."""
    named = os.environ.get("NUMBA_CACHE_DIR")
    if named and _writable(Path(named)) and not _is_foreign(Path(named)):
        return Path(os.path.abspath(named))
    if not named and all(_writable(folder / BESIDE) for folder in {path.parent for path in _sources()}):
        return BESIDE
    if not named and _writable(_users_place()) and not _is_foreign(_users_place()):
        return _users_place()
    return _private_place() if _is_private(_private_place()) else None


def any_compiled() -> bool:
    """Whether any kernel is there that fits its source."""
    return shipped() is not None or any(
        (folder := folder_of(source)) is not None and any(folder.glob(f"{source.stem}.*-{stamp_of(source)}.*.nbi"))
        for source in _sources()
    )


def folder_of(source: Path) -> Path | None:
    """The folder for kernels of a source; those of files outside the package are never kept beside them."""
    place = cache_place()
    if place == BESIDE and source.is_relative_to(HERE):
        return source.parent / BESIDE
    places = [_users_place()] if place == BESIDE and _writable(_users_place()) else [place] if place != BESIDE else []
    if _is_private(_private_place()):
        places.append(_private_place())
    name = f"{source.parent.name}_{hashlib.sha1(str(source.parent).encode()).hexdigest()}"
    return next((place / name for place in places if place is not None and not _is_foreign(place / name)), None)


@cache
def stamp_of(source: Path) -> str:
    """A hash of a source and of all kernels that it uses, directly or through others."""
    below, ahead = {source}, [source]
    while ahead:
        new = _imported(ahead.pop()) - below
        below |= new
        ahead.extend(new)
    return hashlib.sha256(b"".join(sorted(hashlib.sha256(_content(path)).digest() for path in below))).hexdigest()[:12]


@cache
def _sources() -> tuple[Path, ...]:
    return tuple(HERE.rglob("*.py"))


@cache
def _content(path: Path) -> bytes:
    return path.read_bytes()


@cache
def _imported(path: Path) -> frozenset[Path]:
    """The kernels that a file imports; text is quicker than a tree, and a word too many does no harm."""
    candidates: set[Path] = set()
    for module, names in _IMPORT.findall(_content(path).decode("utf-8", "replace")):
        base = HERE.joinpath(*module.split(".")[2:])
        for place in (base, *(base / name for name in re.findall(r"\w+", names))):
            candidates |= {place.with_suffix(".py"), place / "__init__.py"}
    return frozenset((candidates & set(_sources())) - {HERE / name for name in NOT_COMPILED})


class Shipped:
    """Kernels that came with the package. A file that is not as it was when the package was made is never unpickled."""

    def __init__(self, folder: Path) -> None:
        found = json.loads((folder / LIST).read_bytes())
        self._folder = folder
        self._processor: tuple[str, str, str] = tuple(found["processor"])  # as Numba names it
        self._made_with: dict[str, str] = found["made with"]
        self._hashes: dict[str, str] = found["sha256"]

    def unfit(self) -> str:
        """Why nothing of it can be used here; empty if it can."""
        here = compiler_versions()
        if here != self._made_with:
            wrong = [name for name in self._made_with if here.get(name) != self._made_with[name]]
            ours, theirs = (", ".join(f"{name} {of.get(name)}" for name in wrong) for of in (here, self._made_with))
            return f"were made with {theirs}, here is {ours}"
        from numba.core.codegen import get_host_cpu_features

        _, level, features = self._processor
        given = getattr(numba.config, "CPU_FEATURES", None)  # of a user who names another processor
        missing = set(features.split(",")) - set((get_host_cpu_features() if given is None else given).split(","))
        lacks = ", ".join(sorted(name.lstrip("+") for name in missing))
        return f"are for processors of the level {level}, this one lacks {lacks}" if missing else ""

    def magic_tuple(self) -> tuple[str, str, str]:
        """What Numba calls the processor for which kernels are compiled."""
        return self._processor

    def load(self, index: str, key: Any) -> Any:
        """What Numba kept under a key, or None."""
        if index not in self._hashes:
            name, *_ = index.rsplit("-", 2)  # without line and stamp
            if any(other.startswith(f"{name}-") for other in self._hashes):
                complain("do not fit the sources, which were changed")
            return None
        stream = io.BytesIO(self._content(index))
        pickle.load(stream)  # the version of Numba, which fits
        _, files = pickle.load(stream)
        return pickle.loads(self._content(files[key])) if key in files else None

    def _content(self, name: str) -> bytes:
        content = (self._folder / name).read_bytes()
        if hash_of(content) != self._hashes.get(name):
            raise ValueError(f"{name} has another content")
        return content


_complaints: dict[str, bool] = {}  # what was found wrong with the shipped kernels, and whether it was said


def complain(reason: str) -> None:
    """Remember that shipped kernels are not used, until something is compiled in their place."""
    _complaints.setdefault(reason, False)


def complaints() -> list[str]:
    """Why shipped kernels are not used; each reason once."""
    new = [reason for reason, said in _complaints.items() if not said]
    _complaints.update(dict.fromkeys(new, True))
    return [f"the compiled equations of the package {reason}" for reason in new]


@cache
def shipped() -> Shipped | None:
    """The kernels that came with the package, if they fit this computer."""
    if not SHIPPED.is_dir():
        return None
    try:
        found = Shipped(SHIPPED)
        reason = found.unfit()
    except Exception as error:  # whatever a damaged list holds
        found, reason = None, f"have a damaged list ({SHIPPED / LIST}: {error})"
    if reason:
        complain(reason)
        return None
    return found


def compiler_versions() -> dict[str, str]:
    """The versions that compiled kernels need."""
    return {"Python": str(sys.implementation.cache_tag), "Numba": numba.__version__, "llvmlite": llvmlite.__version__}


def hash_of(content: bytes) -> str:
    """By which files are known."""
    return hashlib.sha256(content).hexdigest()


def _writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError:
        return False
    return True


def _is_foreign(folder: Path) -> bool:
    """Whether it belongs to another user, who could put code there."""
    try:
        return hasattr(os, "getuid") and folder.stat().st_uid not in {0, os.getuid()}
    except OSError:
        return False  # it is not there yet


def _users_place() -> Path:
    from numba.misc.appdirs import AppDirs

    return Path(AppDirs(appname="numba", appauthor=False).user_cache_dir)


def _private_place() -> Path:
    user = os.getuid() if hasattr(os, "getuid") else "user"
    try:
        return Path(tempfile.gettempdir()) / f"autobalancer-kernels-{user}"
    except OSError:  # no folder for temporary files
        return HERE


def _is_private(folder: Path) -> bool:
    """Whether nobody else can put code there."""
    try:
        folder.mkdir(mode=0o700, exist_ok=True)
        found = folder.lstat()
    except OSError:
        return False
    owner = os.getuid() if hasattr(os, "getuid") else found.st_uid
    alone = os.name == "nt" or found.st_mode & 0o077 == 0
    return not folder.is_symlink() and found.st_uid == owner and alone and _writable(folder)


def _nowhere() -> str:
    named = os.environ.get("NUMBA_CACHE_DIR")
    if not named:
        return "neither the package nor the home folder can hold compiled equations"
    whose = ", which belongs to another user" if _is_foreign(Path(named)) else ""
    return f"compiled equations cannot be kept in NUMBA_CACHE_DIR ({named}){whose}"


class Missing(Exception):
    """A kernel is not in its place."""


_of_thread = threading.local()  # whether it only loads
_locks: dict[Path, Any] = {}  # files that this process has locked
_helpers: list[Any] = []


@contextmanager
def _loading() -> Iterator[None]:
    _of_thread.loads = True
    try:
        yield
    finally:
        _of_thread.loads = False


def take(place: Path | None) -> bool:
    """Take a kernel that is not there, to compile it; whether another process had it, and may have compiled it."""
    if getattr(_of_thread, "loads", False):
        raise Missing
    if fcntl is None or place is None or place in _locks:
        return False
    waited, until = False, time.monotonic() + PATIENCE
    with suppress(OSError):
        place.parent.mkdir(parents=True, exist_ok=True)
        file = place.open("ab")
        while time.monotonic() < until:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                waited = True
                time.sleep(0.01)
                continue
            _locks[place] = file
            return waited
        file.close()
    return waited


def give(place: Path | None) -> None:
    """Let others have a kernel."""
    if place is not None and place in _locks:
        with suppress(OSError):
            place.unlink()
        _locks.pop(place).close()


def _is_locked(place: Path | None) -> bool:
    """Whether another process has it."""
    if fcntl is None or place is None or place in _locks:
        return False
    try:
        with place.open("rb") as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except FileNotFoundError:
        return False
    except OSError:
        return True
    return False


def compile_in_parallel(works: Iterable[Work], then: tuple[str, ...] = ()) -> None:
    """Load kernels, and compile those that are not there, by as many processes as there are processors.

    The others go on with all kernels of the modules ``then`` while this process uses the first ones.
    """
    if stock("lazy") or stock("cache"):
        return  # Numba has compiled what declares its types, and compiles the rest as it is used
    missing = [work for work in works if not _is_there(*work)]
    others = min(MOST, _processors(), len(missing)) - 1
    if fcntl is not None and multiprocessing.parent_process() is None:
        names = [(kernel.py_func.__module__, kernel.py_func.__name__, types) for kernel, types in missing]
        for _ in range(others):
            _start((names, then))
    _compile(missing)


def _is_there(kernel: Any, types: Any) -> bool:
    if not hasattr(kernel, "overloads"):
        return True  # the compiler is switched off
    try:
        with _loading():
            kernel.compile(types)
    except Missing:
        return False
    return True


def _compile(works: list[Work]) -> None:
    """Those first that nobody else has."""
    later = []
    for kernel, types in works:
        if _is_locked(kernel._cache.lock(types or kernel.declared[0])):
            later.append((kernel, types))
        else:
            kernel.compile(types)
    for kernel, types in later:
        kernel.compile(types)


def _processors() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _start(asked: tuple[list[tuple[str, str, Any]], tuple[str, ...]]) -> None:
    """A process that compiles the same kernels, the last first."""
    root = str(HERE.parents[1])
    code = f"import sys; sys.path.insert(0, {root!r}); from autobalancer.kernels.compiler import cache; cache.help()"
    with suppress(OSError):
        helper = subprocess.Popen(
            [sys.executable, "-P", "-c", code],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        _helpers.append(helper)  # kept, as it goes on by itself
        if helper.stdin is not None:
            with helper.stdin:
                pickle.dump(asked, helper.stdin)


def help() -> None:
    """What such a process does."""
    names, then = pickle.load(sys.stdin.buffer)
    _compile([(getattr(import_module(module), name), types) for module, name, types in reversed(names)])
    for module in then:
        _compile([(kernel, None) for kernel in declared_in(import_module(module))])


def declared_in(module: Any) -> list[Any]:
    """The kernels of a module that declare their types and wait for their use."""
    own = (value for value in vars(module).values() if hasattr(value, "py_func") and getattr(value, "declared", None))
    return [kernel for kernel in own if kernel.py_func.__module__ == module.__name__]


# A line on the terminal, in a pipe or in a notebook for each kind of kernels that is compiled for the first time.

TEXT = "autobalancer: first use of {}: compiling, up to a minute"  # fits 80 columns
SHARED = "this version"
KINDS = {
    "chamber": "deep chambers",
    "annulus_flow": "the flow in a race",
    "planar": "planar rotors",
    "on_stations": "balls on any rotor",
    "resolved_balls": "resolved balls",
    "characteristic": "stability maps",
    "dwell": "stepped responses",
    "many_members": "many runs at once",
}


class Announcement:
    """Writes a line when the first kernel of a kind is compiled in a process; kernels from the cache are not."""

    def __init__(self) -> None:
        self.said: set[str] = set()
        self.begun, self.depth = 0.0, 0  # a kernel compiles those that it calls, of whatever kind

    def on_start(self, event: Any) -> None:
        """Called by Numba when it begins to compile."""
        self.depth += 1
        if self.depth == 1:
            self.begun = time.thread_time()
        for complaint in complaints():
            print(f"autobalancer: {complaint}", file=sys.stderr, flush=True)
        kernel = getattr(event.data.get("dispatcher"), "py_func", None)
        place = (getattr(kernel, "__module__", None) or "").split(".")
        if self.depth > 1 or place[:2] != ["autobalancer", "kernels"]:
            return
        kind = next((KINDS[name] for name in place if name in KINDS), SHARED)
        if kind not in self.said:
            self.said.add(kind)
            print(TEXT.format(kind), file=sys.stderr, flush=True)

    def on_end(self, event: Any) -> None:
        """Called by Numba when a kernel is ready."""
        self.depth -= 1
        if self.depth == 0:
            not_counted(time.thread_time() - self.begun)


def announce_compiling() -> None:
    """From now on."""
    from numba.core import event

    event.register("numba:compile", type("Listener", (Announcement, event.Listener), {})())
