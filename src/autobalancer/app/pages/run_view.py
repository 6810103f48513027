"""The moving picture of a run as an element of the page."""

from __future__ import annotations

from pathlib import Path

import nicegui
from nicegui.element import Element

SCENE = Path(nicegui.__file__).parent / "elements" / "scene" / "dist"  # NiceGUI brings three.js in one file
VIEW = Path(__file__).parents[1] / "view"


class RunView(Element, component="run_view.js", esm={"nicegui-scene": str(SCENE), "autobalancer-view": str(VIEW)}):
    """Scene, races, orbit and waveforms of one run, animated in the browser."""

    def __init__(self) -> None:
        super().__init__()
        self._props["source"] = ""
        self.classes("view")

    def show(self, name: str) -> None:
        """Show the run of a name; empty for none."""
        self._props["source"] = f"/run/{name}/view.bin" if name else ""
        self.update()
