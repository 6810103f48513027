"""One look for all pictures; applied while a figure is built, never globally."""

from __future__ import annotations

import io
import re
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from textwrap import fill
from typing import Any

import matplotlib
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backend_bases import RendererBase
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text

from autobalancer.errors import QuestionError
from autobalancer.safe_file import as_path, write_safely

# Okabe and Ito (2008): told apart with every kind of color vision. Vermilion is kept for the unbalance.
INK = "#222222"
FORCE = "#4A5A78"  # symbols of springs, magnets, pins
UNBALANCE = "#D55E00"
CRITICAL = "#707070"
FILL = "#B9C3CC"
RACE = "#E9EDF0"
ALL_BALLS = "#5B6B7A"
BALLS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#8A7A1F")

LOOK: Any = {
    "text.usetex": False,  # whatever a file of settings in the working folder says
    "font.family": "sans-serif",
    "font.size": 9.5,
    "axes.titlesize": 10.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 9.5,
    "figure.titlesize": 10.5,
    "figure.titleweight": "bold",
    "axes.edgecolor": "#606060",
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#E3E3E3",
    "grid.linewidth": 0.7,
    "xtick.color": "#404040",
    "ytick.color": "#404040",
    "xtick.labelsize": 8.5,
    "ytick.labelsize": 8.5,
    "lines.linewidth": 1.3,
    "lines.solid_capstyle": "round",
    "legend.fontsize": 8.5,
    "legend.frameon": False,
    "legend.borderpad": 0.2,
    "legend.handlelength": 1.6,
    "legend.columnspacing": 1.4,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
}


# the formulas of this package, the powers of ten of an axis and the symbol at the end of its label; any other dollar sign
# belongs to a name
FORMULA = r"(?:[^$]|\$(?:\\mathdefault\{[^$]*\}|c_[a-z]|J_p/J_t|c_d\\,\\mathrm\{Re\})\$)*"
GREEK = "alpha|beta|gamma|delta|varepsilon|zeta|eta|theta|kappa|lambda|mu|nu|xi|rho|sigma|tau|varphi|chi|psi|omega"
SYMBOL = rf"(?:[A-Za-z]|\\(?:{GREEK}))(?:_(?:[a-z0-9]|\\infty|\\mathrm\{{[a-z]+\}}))?|c_d \\mathrm\{{Re\}}"
OWN_FORMULA = re.compile(rf"{FORMULA}|[^$]*, \$(?:{SYMBOL})\$(?: \([^$]*\))?")


def as_written(text: Text) -> None:
    """Show a text as it is written unless it is a formula of this package: names are data."""
    if "$" in text.get_text() and not OWN_FORMULA.fullmatch(text.get_text()):
        text.set_parse_math(False)


DRAWING = threading.RLock()  # Matplotlib's settings, fonts and formulas are shared: one thread draws at a time


class Picture(Figure):
    """A figure without pyplot that a notebook shows as an image."""

    def draw(self, renderer: RendererBase) -> None:
        """Draw it, with names as they are written."""
        for axes in self.axes:
            axes.get_xticklabels(), axes.get_yticklabels()  # brings their texts up to date
        for text in self.findobj(Text):
            as_written(text)
        engine = self.get_layout_engine()
        if engine is not None:
            if _titles_fit(self, renderer):
                engine.execute(self)
            engine.execute(self)  # once more than matplotlib does: panels of another size have other ticks
        super().draw(renderer)

    def savefig(self, fname: Any, *, transparent: bool | None = None, **kwargs: Any) -> None:
        """As Matplotlib does, one thread at a time."""
        with DRAWING:
            super().savefig(fname, transparent=transparent, **kwargs)

    def _repr_png_(self) -> bytes:
        buffer = io.BytesIO()
        self.savefig(buffer, format="png", dpi=110)
        return buffer.getvalue()


def _titles_fit(figure: Figure, renderer: RendererBase) -> bool:
    """Break the lines of the title of a figure that is wider than the figure; whether that was so."""
    title: Text | None = figure._suptitle  # type: ignore[attr-defined]
    if title is None or not title.get_text():
        return False
    box = title.get_window_extent(renderer)
    room = figure.bbox.x1 - box.x0
    if box.width <= room:
        return False
    lines = title.get_text().split("\n")
    longest = int(max(map(len, lines)) * room / box.width)
    title.set_text("\n".join(fill(line, max(longest, 20)) for line in lines))
    return True


@contextmanager
def look() -> Iterator[None]:
    """Draw with the look of this package, one thread at a time; the settings of the caller come back afterwards."""
    with DRAWING, matplotlib.rc_context(LOOK):
        yield


def picture(width: float, height: float, dpi: float = 110.0) -> Figure:
    """An empty figure of ``width`` by ``height`` inches with its own Agg canvas and constrained layout."""
    figure = Picture(figsize=(width, height), dpi=dpi, layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def heading(figure: Figure, text: str) -> None:
    """The title of a figure with several panels: left and bold, as that of a panel."""
    if text:
        figure.suptitle(text, x=0.1 / figure.get_figwidth(), ha="left")


def with_ignored(title: str, attributes: Mapping[Any, Any], verb: str = "ignores") -> str:
    """A title that names what the theory of the result ignores of its machine."""
    ignored = str(attributes.get("ignores", ""))
    return f"{title}\n{verb} {ignored}" if ignored else title


def ball_color(number: int) -> str:
    """Color of ball ``number``, counted from 0."""
    return BALLS[number % len(BALLS)]


def ball_label(number: int, count: int) -> str:
    """Legend entry of ball ``number``: one for each of a few balls, one for all of many; "_" hides an entry."""
    if count <= 6:
        return f"ball {number + 1}"
    return f"{count} balls" if number == 0 else "_"


def legend(axes: Axes) -> None:
    """A legend above the panel, where it hides nothing, in as few rows as fit; none if there is nothing to explain."""
    handles, labels = axes.get_legend_handles_labels()
    if not handles:
        return
    figure = axes.get_figure(root=True)
    assert figure is not None
    room = 72.0 * axes.get_position().width * figure.get_figwidth()
    room *= 1.0 if figure.get_layout_engine() is None else 1.12  # constrained layout makes panels wider later
    columns = len(labels)
    while columns > 1 and legend_width(labels, columns) > room:
        columns = min(columns - 1, -(-len(labels) // (-(-len(labels) // (columns - 1)))))
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=columns, borderaxespad=0.1)


def legend_below(figure: Figure, handles: Sequence[Artist], absent: Sequence[str]) -> None:
    """A legend below all panels; above its keys stands in words what is ``absent`` from the picture."""
    words = fill(f"not in the picture: {', '.join(absent)}", 105) if absent else None
    place: Any = {"loc": "outside lower center", "ncols": 3, "handlelength": 2.8}
    figure.legend(handles=list(handles), title=words, title_fontsize=8.5, **place)


def legend_width(labels: list[str], columns: int) -> float:
    """Points that a legend takes, entries going down the columns."""
    most, longer = divmod(len(labels), columns)  # the first columns have one more
    ends = [0, *((i + 1) * most + min(i + 1, longer) for i in range(columns))]
    widest = [max(map(len, labels[first:last])) for first, last in pairwise(ends)]
    return sum(4.7 * width + 33.0 for width in widest)


# Pictures to files.


FORMATS = ("png", "svg", "pdf")


def save_picture(figure: Figure, path: str | Path, *, dpi: float = 150.0) -> Path:
    """Write a picture; the extension says how: ``.png``, ``.svg`` or ``.pdf``.

    Parameters
    ----------
    figure
        From a function of ``ab.plot``.
    path
        The file; its folder is made if there is none.
    dpi
        Pixels per inch of a PNG.

    Returns
    -------
    pathlib.Path
        The file that was written.

    Raises
    ------
    QuestionError
        If the extension is none of these.
    ResultError
        If the file cannot be written.
    """
    path = as_path(path)
    kind = path.suffix.lower().removeprefix(".")
    if kind not in FORMATS:
        raise QuestionError(f"{path}: pictures are saved as .png, .svg or .pdf; end the name with one of these")
    when = {"png": None, "svg": {"Date": None}, "pdf": {"CreationDate": None}}[kind]  # equal runs, equal files
    with DRAWING, matplotlib.rc_context({"svg.hashsalt": "autobalancer"}):
        return write_safely(path, lambda file: figure.savefig(file, format=kind, dpi=dpi, metadata=when))
