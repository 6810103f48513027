"""Write the type stubs of the public namespaces from the one table of public names.

``python -m tools.write_stubs`` writes them; with ``--check`` it only says which are out of date, by its exit code too.
"""

from __future__ import annotations

import sys
from pathlib import Path

from autobalancer.public_names import ABOUT, MODULES, NAMES

SOURCE = Path(__file__).resolve().parent.parent / "src" / "autobalancer"
HEAD = "# written by tools/write_stubs.py from public_names.py\n\n"


def stubs() -> dict[Path, str]:
    """The stub of each namespace."""
    return {_path(space): _stub(space) for space in NAMES}


def _path(space: str) -> Path:
    package = SOURCE / space
    return package / "__init__.pyi" if (package / "__init__.py").exists() else SOURCE / f"{space}.pyi"


def _stub(space: str) -> str:
    modules = MODULES.get(space, {}) | ({name: name for name in ABOUT} if not space else {})
    lines = []
    for name, home in modules.items():
        above, _, last = f"autobalancer.{home}".rpartition(".")
        lines.append(f"from {above} import {last} as {name}")
    for name, home in NAMES[space].items():
        lines.append(f"from autobalancer.{home} import {name} as {name}")
    listed = "".join(f'    "{name}",\n' for name in sorted([*NAMES[space], *modules]))
    version = "__version__: str\n\n" if not space else ""
    return f"{HEAD}{chr(10).join(sorted(lines))}\n\n{version}__all__ = [\n{listed}]\n"


def main() -> int:
    """Write the stubs, or with ``--check`` compare them."""
    old = [path for path, text in stubs().items() if not path.exists() or path.read_text(encoding="utf-8") != text]
    if "--check" in sys.argv[1:]:
        print("".join(f"out of date: {path}\n" for path in old), end="")
        return int(bool(old))
    for path in old:
        path.write_text(stubs()[path], encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
