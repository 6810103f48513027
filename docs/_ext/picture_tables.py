"""The table of all pictures, read off the public functions that draw them."""

from __future__ import annotations

import autobalancer as ab
from autobalancer.plots.answer import PICTURES
from autobalancer.public_names import NAMES


def pages() -> dict[str, str]:
    """What the documentation includes."""
    return {"pictures.md": pictures()}


def pictures() -> str:
    """Every public function that draws, and every picture of an answer, with the first line of its docstring."""
    text = "| function | what it draws |\n|---|---|\n"
    for name in NAMES["plot"]:
        first = (getattr(ab.plot, name).__doc__ or "").strip().splitlines()[0]
        text += f"| {{py:func}}`ab.plot.{name} <autobalancer.plot.{name}>` | {first} |\n"
    text += "\n| picture of `ab.plot.answer` | of a result of | what it draws | options |\n|---|---|---|---|\n"
    for name, one in PICTURES.items():
        first = (one.draw.__doc__ or "").strip().splitlines()[0]
        options = ", ".join(f"`{option}`" for option in one.options)
        text += f"| `{name}` | `ab.{one.of.replace(',', ' ').split()[0]}` | {first} | {options} |\n"
    return text
