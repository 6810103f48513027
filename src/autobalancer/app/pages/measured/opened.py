"""What is done with one measurement: looks, runs beside it, fits."""

from __future__ import annotations

from typing import Any

import xarray as xr
from nicegui import ui

from autobalancer.app.pages.bench import Bench
from autobalancer.app.pages.hint import marked
from autobalancer.app.pages.measured.beside import Beside
from autobalancer.app.pages.measured.fit import Fit
from autobalancer.app.pages.measured.looks import Looks
from autobalancer.app.store.measured.shelf import Shelf


class Opened:
    """Three cards; they bring what computes, so they are made when the first measurement is opened."""

    def __init__(self, bench: Bench, shelf: Shelf) -> None:
        with _card("look"):
            self.looks = Looks(bench, shelf)
        with _card("beside a run"):
            self.beside = Beside(bench, lambda: self.looks.asked)
        with _card("fit"):
            self.fit = Fit(bench, shelf, lambda: self.looks.asked)

    def show(self, name: str, data: xr.Dataset, version: str) -> None:
        """Show another measurement."""
        self.looks.show(name, data, version)
        self.beside.show(data)
        self.fit.show(name, data)


def _card(label: str) -> Any:
    return marked(ui.element("section").classes("card"), label=label)
