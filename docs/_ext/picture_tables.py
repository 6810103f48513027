"""The table of all pictures, read off the public functions that draw them."""

from __future__ import annotations

import autobalancer as ab
from autobalancer.public_names import NAMES


def pages() -> dict[str, str]:
    """What the documentation includes."""
    return {"pictures.md": pictures()}


def pictures() -> str:
    """Every public function that draws, with the first line of its docstring."""
    text = "| function | what it draws |\n|---|---|\n"
    for name in NAMES["plot"]:
        first = (getattr(ab.plot, name).__doc__ or "").strip().splitlines()[0]
        text += f"| {{py:func}}`ab.plot.{name} <autobalancer.plot.{name}>` | {first} |\n"
    return text
