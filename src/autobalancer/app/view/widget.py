"""The moving picture of a run in a notebook: the module of the page, with three.js as NiceGUI brings it."""

from __future__ import annotations

import re
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import xarray as xr

from autobalancer.app.view.packed import packed
from autobalancer.errors import QuestionError

HERE = Path(__file__).parent
PARTS = ("unpack", "scene", "waves", "flat", "view")  # in the order in which they need each other
ENTRY = """
async function loaded(model) {
  const source = model.get("three");
  const url = URL.createObjectURL(new Blob([source], { type: "text/javascript" }));
  return import(url);
}

async function render({ model, el }) {
  const lib = await loaded(model);
  const block = model.get("block");
  const bytes = block.buffer.slice(block.byteOffset, block.byteOffset + block.byteLength);
  const { jpThemeLight, vscodeThemeKind } = document.body.dataset; // a notebook has a look of its own
  const system = window.matchMedia("(prefers-color-scheme: dark)").matches;
  const dark = jpThemeLight ? jpThemeLight === "false" : vscodeThemeKind ? vscodeThemeKind.includes("dark") : system;
  const place = document.createElement("div");
  el.appendChild(place);
  const view = createView(place, bytes, lib, dark);
  return () => view.destroy();
}
export default { render };
"""


def module_text() -> str:
    """The JavaScript of the view as one module without imports."""
    parts = []
    for name in PARTS:
        text = (HERE / f"{name}.js").read_text(encoding="utf-8")
        text = re.sub(r"^import .*?;\n", "", text, flags=re.MULTILINE)
        text = re.sub(r"^export ", "", text, flags=re.MULTILINE)
        parts.append(f"// {name}.js\n{text}")
    return "\n".join(parts) + ENTRY


def three_text() -> str:
    """three.js and its controls as one module, from the files of NiceGUI.

    Raises
    ------
    QuestionError
        If NiceGUI is not installed.
    """
    found = find_spec("nicegui")
    if found is None or found.origin is None:
        raise QuestionError("widget: NiceGUI is not installed; install it with: pip install 'autobalancer[app]'")
    return (Path(found.origin).parent / "elements" / "scene" / "dist" / "index.js").read_text(encoding="utf-8")


def widget(run: xr.Dataset) -> Any:
    """Show a run in a notebook as it moves: rotor and balls in three dimensions, in step with the waveforms.

    The run is sent once and animated in the browser; no other host is asked.

    Parameters
    ----------
    run
        From :func:`autobalancer.simulate` or :func:`autobalancer.load_run`, with samples.

    Returns
    -------
    anywidget.AnyWidget
        Shows itself as the last line of a cell.

    Raises
    ------
    QuestionError
        If the run has no samples, or NiceGUI or anywidget is not installed.
    """
    try:
        import anywidget
        import traitlets
    except ImportError as reason:
        raise QuestionError(f"widget: {reason}; install it with: pip install 'autobalancer[app]'") from None

    class RunWidget(anywidget.AnyWidget):
        """The view with one run."""

        _esm = module_text()
        block = traitlets.Bytes().tag(sync=True)
        three = traitlets.Unicode().tag(sync=True)

    return RunWidget(block=packed(run), three=three_text())
