"""Where compiled kernels are kept, and which of them still fit their sources.

They lie in the folder named by ``NUMBA_CACHE_DIR``, else beside the kernels, else in the user's folder for caches. Where
none of these can be written (a package of the system, a user without a home) they go to a private folder among the temporary
files, and if that is not possible either, they are compiled in every process. Numba itself would also read a folder that a
file in the working directory names; what it reads there it runs, so its own search is not used.

A kernel is found by content: its name carries a hash of its source and of all kernels that are compiled into it. So an edit
makes what depends on it compile again, and nothing else.
"""

from __future__ import annotations

import hashlib
import inspect
import os
import re
import sys
import tempfile
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

from numba import njit as numba_njit
from numba.core import caching, typeinfer

HERE = Path(os.path.abspath(__file__)).parent
BESIDE = Path("__pycache__")
NOT_COMPILED = {"cache.py", "announce.py"}  # kernels import these, but nothing of them is compiled
_IMPORT = re.compile(r"^\s*from (autobalancer\.kernels[\w.]*) import (\([^)]*\)|[^\n]*)", re.MULTILINE)


def njit(signature: Any = None, *, cache: bool = False, **options: Any) -> Any:
    """Numba's decorator of the same name, but kernels are kept in :func:`cache_place`, not where Numba looks.

    Parameters
    ----------
    signature
        Types for which the function is compiled at once, or a list of them; else they follow from its calls.
    cache
        Whether the compiled function is kept for other processes.
    options
        Those of Numba.
    """
    if not cache:
        return numba_njit(signature, **options)

    def decorate(function: Any) -> Any:
        kernel = numba_njit(**options)(function)
        if hasattr(kernel, "_cache"):  # else the compiler is switched off
            kernel._cache = KernelCache(function)
            signatures = signature if isinstance(signature, list) else [signature] if signature is not None else []
            with typeinfer.register_dispatcher(kernel):  # as Numba does, for functions that call themselves
                for each in signatures:
                    kernel.compile(each)
            if signatures:
                kernel.disable_compile()
        return kernel

    return decorate


def prepare_cache() -> tuple[bool, str]:
    """Whether kernels can be kept, and what the user should know about it."""
    place = cache_place()
    if place is None:
        return False, f"{_nowhere()}; they are compiled anew each time, which takes half a minute"
    if place == _private_place() and not any_compiled():
        return True, f"{_nowhere()}; they are kept in {place}"
    return True, ""


@cache
def cache_place() -> Path | None:
    """The folder of the kernels, ``BESIDE`` if each lies beside its source; None if there is no place for them."""
    named = os.environ.get("NUMBA_CACHE_DIR")
    if named and _writable(Path(named)):
        return Path(os.path.abspath(named))
    if not named and all(_writable(folder / BESIDE) for folder in {path.parent for path in _sources()}):
        return BESIDE
    if not named and _writable(_users_place()):
        return _users_place()
    return _private_place() if _is_private(_private_place()) else None


def any_compiled() -> bool:
    """Whether any kernel is there that fits its source."""
    return any(
        (folder := folder_of(source)) is not None and any(folder.glob(f"{source.stem}.*-{stamp_of(source)}.*.nbi"))
        for source in _sources()
    )


def folder_of(source: Path) -> Path | None:
    """The folder for kernels of a source; those of files outside the package are never kept beside them."""
    place = cache_place()
    if place == BESIDE and source.is_relative_to(HERE):
        return source.parent / BESIDE
    if place == BESIDE:
        place = (
            _users_place() if _writable(_users_place()) else _private_place() if _is_private(_private_place()) else None
        )
    if place is None:
        return None
    return place / f"{source.parent.name}_{hashlib.sha1(str(source.parent).encode()).hexdigest()}"


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


class _Locator(caching._CacheLocator):
    """Tells Numba's cache where the kernels of a function are, and under which name."""

    def __init__(self, function: Any) -> None:
        self._py_file = inspect.getfile(function)
        source = Path(os.path.abspath(self._py_file))
        folder = folder_of(source) if source.is_file() else None
        if folder is None:
            raise RuntimeError(f"cannot cache function {function.__qualname__}: there is no place for it")
        self._folder, self._stamp, self._line = folder, stamp_of(source), function.__code__.co_firstlineno

    def get_cache_path(self) -> str:
        return str(self._folder)

    def get_source_stamp(self) -> str:
        return self._stamp

    def get_disambiguator(self) -> str:
        """Functions may share a name, so the line; and the source."""
        return f"{self._line}-{self._stamp}"


class _Kernels(caching.CompileResultCacheImpl):
    def __init__(self, function: Any) -> None:
        self._lineno = function.__code__.co_firstlineno
        self._locator = _Locator(function)
        name = f"{Path(self._locator._py_file).stem}.{function.__qualname__}"
        self._filename_base = self.get_filename_base(name, getattr(sys, "abiflags", ""))


class KernelCache(caching.FunctionCache):
    """The compiled kernels of one function, found by the content of its source."""

    _impl_class = _Kernels

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The compiled function, or None. What is damaged is removed, and compiled again."""
        try:
            return super().load_overload(sig, target_context)
        except Exception:  # a damaged pickle may raise anything
            with suppress(OSError):
                Path(self._cache_file._index_path).unlink()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep a compiled function, and drop those of older sources. What cannot be kept is compiled again next time."""
        try:
            super().save_overload(sig, data)
        except Exception:  # a full disk; a function that stands in no module
            return
        stamp, folder = self._cache_file._source_stamp, Path(self.cache_path)
        name = Path(self._cache_file._index_path).name.partition(f"-{stamp}")[0].rpartition("-")[0]
        older = re.compile(rf"{re.escape(name)}-\d+-(?!{stamp})[0-9a-f]{{12}}\..*\.nb[ic]")
        for path in folder.iterdir():
            if older.fullmatch(path.name):
                with suppress(OSError):
                    path.unlink()


def _writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError:
        return False
    return True


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
    where = f"NUMBA_CACHE_DIR ({named})" if named else "the package nor the home folder"
    return f"compiled equations cannot be kept in {where}" if named else f"neither {where} can hold compiled equations"
