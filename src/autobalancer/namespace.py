"""Namespaces of the public interface: a name is imported when it is first used."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

from autobalancer.public_names import ABOUT, MODULES, NAMES, hint

PACKAGE = "autobalancer"


def public(space: str, names: dict[str, Any]) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """``__getattr__``, ``__dir__`` and ``__all__`` of a module whose public names are those of ``space``.

    ``names`` are the globals of the module, which keep what was imported. The types are in the stub beside the module, which
    ``tools/write_stubs.py`` writes from the same table.
    """
    homes, modules = NAMES[space], dict(MODULES.get(space, {}))
    if not space:
        modules |= {name: name for name in ABOUT}
    listed = sorted([*homes, *modules])

    def get(name: str) -> Any:
        if name in modules:
            value: Any = import_module(f"{PACKAGE}.{modules[name]}")
        elif name in homes:
            value = getattr(import_module(f"{PACKAGE}.{homes[name]}"), name)
        else:
            raise AttributeError(f"module {names['__name__']!r} has no attribute {name!r}{hint(space, name)}")
        names[name] = value
        return value

    return get, lambda: sorted([*listed, *(["__version__"] if not space else [])]), listed
