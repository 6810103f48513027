"""Waveforms of measured signals as an element of the page."""

from __future__ import annotations

from pathlib import Path

from nicegui.element import Element

VIEW = Path(__file__).parents[2] / "view"


class WaveView(Element, component="wave_view.js", esm={"autobalancer-view": str(VIEW)}):
    """All channels over time, drawn and zoomed in the browser."""

    def __init__(self) -> None:
        super().__init__()
        self._props["source"] = ""
        self.classes("w-full")

    def show(self, name: str, version: str = "") -> None:
        """Show the signals of a name; another version fetches them again, and an empty name shows none."""
        self._props["source"] = f"/measured/{name}/wave.bin?v={version}" if name else ""
        self.update()
