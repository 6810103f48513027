"""The compiled kernels of a function on disk, as Numba asks for them."""

from __future__ import annotations

import inspect
import os
import pickle
import re
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

from numba.core import caching
from numba.core.sigutils import normalize_signature

from autobalancer.kernels.compiler.cache import complain, folder_of, give, hash_of, shipped, stamp_of, take


class _Locator(caching._CacheLocator):
    """Tells Numba's cache where the kernels of a function are, and under which name."""

    def __init__(self, function: Any) -> None:
        self._py_file = inspect.getfile(function)
        source = Path(os.path.abspath(self._py_file))
        self.folder = folder_of(source) if source.is_file() else None
        if not source.is_file() or (self.folder is None and shipped() is None):
            raise RuntimeError(f"cannot cache function {function.__qualname__}: there is no place for it")
        self._stamp, self._line = stamp_of(source), function.__code__.co_firstlineno

    def get_cache_path(self) -> str:
        return str(self.folder)

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


class _Files(caching.IndexDataCacheFile):
    """Kernels with their hash in the name: what is cut is found, and no two processes give one name to two kernels."""

    def save(self, key: Any, data: Any) -> None:
        """Keep a kernel, and then the way to it."""
        content = self._dump(data)
        name = f"{self._index_name.removesuffix('.nbi')}.{hash_of(content)[:12]}.nbc"
        with self._open_for_write(self._data_path(name)) as file:
            file.write(content)
        self._save_index(self._load_index() | {key: name})

    def _load_data(self, name: str) -> Any:
        content = Path(self._data_path(name)).read_bytes()
        if not name.endswith(f".{hash_of(content)[:12]}.nbc"):
            raise ValueError(f"{name} is damaged")
        return pickle.loads(content)


class KernelCache(caching.FunctionCache):
    """The compiled kernels of one function, found by the content of its source."""

    _impl_class = _Kernels

    def __init__(self, function: Any) -> None:
        super().__init__(function)
        place = self._impl.locator
        self._cache_file = _Files(place.get_cache_path(), self._impl.filename_base, place.get_source_stamp())
        if place.folder is None:
            self.disable()  # nothing can be kept, but kernels are shipped

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The compiled function, or None: then this process alone compiles it."""
        found = self._shipped_overload(sig, target_context) or self._kept_overload(sig, target_context)
        if found is None and take(self.lock(sig)):  # another process has compiled it meanwhile
            found = self._kept_overload(sig, target_context)
            if found is not None:
                give(self.lock(sig))
        return found

    def lock(self, sig: Any) -> Path | None:
        """The file that is locked while the function is compiled for these types; None where nothing can be kept."""
        types = hash_of(str(normalize_signature(sig)[0]).encode())[:12]
        return Path(f"{self._cache_file._index_path}.{types}.lock") if self._enabled else None

    def _kept_overload(self, sig: Any, target_context: Any) -> Any:
        """What is damaged is removed, and compiled again."""
        try:
            return super().load_overload(sig, target_context)
        except Exception:  # a damaged pickle may raise anything
            with suppress(OSError):
                Path(self._cache_file._index_path).unlink()
            return None

    def _shipped_overload(self, sig: Any, target_context: Any) -> Any:
        kernels = shipped()
        if kernels is None:
            return None
        target_context.refresh()
        try:
            data = kernels.load(self._cache_file._index_name, self._index_key(sig, kernels))
            return data and self._impl.rebuild(target_context, data)
        except Exception as error:  # also of a file that cannot be read
            complain(f"are damaged ({error})")
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep a compiled function, and drop those of older sources. What cannot be kept is compiled again next time."""
        if not self._enabled:
            return
        try:
            super().save_overload(sig, data)
        except Exception:  # a full disk; a function that stands in no module
            return
        finally:
            give(self.lock(sig))
        stamp, folder = self._cache_file._source_stamp, Path(self.cache_path)
        name = Path(self._cache_file._index_path).name.partition(f"-{stamp}")[0].rpartition("-")[0]
        older = re.compile(rf"{re.escape(name)}-\d+-(?!{stamp})[0-9a-f]{{12}}\..*\.nb[ic]")
        for path in folder.iterdir():
            if older.fullmatch(path.name):
                with suppress(OSError):
                    path.unlink()
