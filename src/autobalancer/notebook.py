"""The picture with which a machine or an answer shows itself in a notebook."""

from __future__ import annotations

from base64 import b64encode
from html import escape
from importlib import import_module
from typing import Any

from autobalancer.errors import AutobalancerError
from autobalancer.progress import in_notebook
from autobalancer.public_names import NAMES


def picture_html(thing: Any, about: str, name: str = "answer") -> str:
    """What the public function ``ab.plot.NAME`` draws of it, as an image; empty elsewhere than in a notebook.

    It is also empty where there is no such picture of this thing. ``about`` is read to those who do not see it.
    """
    if not in_notebook():
        return ""
    draw = getattr(import_module(f"autobalancer.{NAMES['plot'][name]}"), name)
    try:
        figure = draw(thing)
    except AutobalancerError:
        return ""
    image = b64encode(figure._repr_png_()).decode("ascii")
    width = round(96.0 * min(figure.get_figwidth(), 9.0))
    return f'<img src="data:image/png;base64,{image}" width="{width}" alt="{escape(about)}">'
