"""Namespaces of the public interface: a name is imported when it is first used."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

from autobalancer.public_names import ABOUT, FIGURES, MODULES, NAMES

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


def function_of(command: str) -> str:
    """The public function of a command, without ``ab.``: its last word, wherever it lives; empty if there is none."""
    if command in FIGURES:
        return FIGURES[command]
    *group, last = command.replace("-", "_").split()
    spaces = [*group, *(space for space in ("", *ABOUT) if space not in group and space != "plot")]
    return next((f"{space}.{last}".lstrip(".") for space in spaces if last in NAMES.get(space, ())), "")


def hint(space: str, name: str) -> str:
    """Where a name is that somebody looked for in a namespace, or which one was meant; empty if there is none."""
    if name.startswith("_"):
        return ""
    places = [_path(other, name) for other in NAMES if name in NAMES[other]]
    if places:
        return f"; there is {' and '.join(places)}"
    from difflib import get_close_matches

    near = [_path(space, one) for one in get_close_matches(name, NAMES[space], n=2, cutoff=0.75)]
    near += [
        _path(other, one) for other in NAMES if other != space for one in get_close_matches(name, NAMES[other], 1, 0.85)
    ]
    return f"; did you mean {' or '.join(near[:3])}?" if near else ""


def _path(space: str, name: str) -> str:
    return f"ab.{space}.{name}" if space else f"ab.{name}"
