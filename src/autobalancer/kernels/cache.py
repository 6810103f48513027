"""Where Numba keeps compiled kernels, and which of them are out of date or damaged.

Numba keeps them in the folder named by ``NUMBA_CACHE_DIR``, else beside the kernels, else in the user's folder for caches. Where
none of these can be written (a package of the system, a user without a home) they go to a private folder among the temporary
files, and if that is not possible either, they are compiled in every process.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

HERE = Path(os.path.abspath(__file__)).parent
BESIDE = Path("__pycache__")


def prepare_cache() -> tuple[bool, str]:
    """Tell Numba where to keep kernels, and remove those that are out of date or damaged.

    Returns
    -------
    bool, str
        Whether kernels are kept, and what the user should know about it.
    """
    place = cache_place()
    if place is None:
        return False, f"{_nowhere()}; they are compiled anew each time, which takes half a minute"
    told = ""
    if place == _private_place():
        told = "" if any(_indexes()) else f"{_nowhere()}; they are kept in {place}"
        import numba

        numba.config.CACHE_DIR = str(place)  # type: ignore[attr-defined]
    forget_outdated()
    return True, told


def cache_place() -> Path | None:
    """The folder of the kernels, ``BESIDE`` if each lies beside its source; None if there is no place for them."""
    named = os.environ.get("NUMBA_CACHE_DIR")
    if named and _writable(Path(named)):
        return Path(named)
    if not named and all(_writable(folder / BESIDE) for folder in _sources()):
        return BESIDE
    if not named and _writable(_users_place()):
        return _users_place()
    return _private_place() if _is_private(_private_place()) else None


def forget_outdated() -> None:
    """Remove what was compiled before the newest change in any kernel, and what is damaged.

    Numba itself looks only at the file of a compiled function, not at those of the functions compiled into it.
    """
    newest = max(path.stat().st_mtime for path in HERE.rglob("*.py"))
    for path in _indexes():
        try:
            if path.stat().st_mtime < newest or _damaged(path):
                path.unlink()
        except OSError:  # another process was faster, or the folder cannot be written to
            continue


def _sources() -> dict[Path, set[str]]:
    """The folders of kernels, and the modules in each."""
    found: dict[Path, set[str]] = {}
    for path in HERE.rglob("*.py"):
        found.setdefault(path.parent, set()).add(path.stem)
    return found


def _indexes() -> Iterator[Path]:
    """The index files of compiled kernels of this package, and of no other."""
    place = cache_place()
    if place is None:
        return
    for source, modules in _sources().items():
        folder = source / BESIDE if place == BESIDE else place / _folder_of(source)
        yield from (path for path in folder.glob("*.nbi") if path.name.split(".")[0] in modules)


def _folder_of(source: Path) -> str:
    """What Numba calls the folder of a source in a cache that it shares with other packages."""
    return f"{source.name}_{hashlib.sha1(str(source).encode()).hexdigest()}"


class _Anything:
    """Stands for whatever a pickle makes."""

    def __init__(self, *_: Any, **__: Any) -> None: ...

    def __setstate__(self, _: Any) -> None: ...

    def __setitem__(self, _: Any, __: Any) -> None: ...

    def append(self, _: Any) -> None: ...


class _Reader(pickle.Unpickler):
    """Reads a pickle through without importing or running anything."""

    def find_class(self, _module: str, _name: str) -> Any:
        return _Anything


def _damaged(index: Path) -> bool:
    """Whether Numba would fail to read an index or the code it names: empty, cut short or overwritten."""
    codes = (path for path in index.parent.glob("*.nbc") if path.name.startswith(f"{index.stem}."))
    return not (_readable(index, 2) and all(_readable(code, 1) for code in codes))


def _readable(file: Path, pickles: int) -> bool:
    with file.open("rb") as stored:
        try:
            for _ in range(pickles):
                _Reader(stored).load()
        except Exception:  # a damaged pickle may raise anything
            return False
    return True


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
