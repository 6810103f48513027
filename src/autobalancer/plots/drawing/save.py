"""Pictures to files."""

from __future__ import annotations

from pathlib import Path

import matplotlib
from matplotlib.figure import Figure

from autobalancer.errors import QuestionError
from autobalancer.plots.drawing.style import DRAWING
from autobalancer.safe_file import as_path, write_safely

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
