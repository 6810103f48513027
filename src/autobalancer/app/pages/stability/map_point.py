"""A point that is dragged over the picture of a stability map, as an element of the page."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from nicegui.element import Element

from autobalancer.app.store.map_point import DrawnMap

Moved = Callable[[float, float, bool], None]
LOOKS = {"stable": "stable", "unstable": "unstable"}


class MapPoint(Element, component="map_point.js"):
    """Lies over the picture of a map; ``moved`` gets the shares of both axes, and whether the point was let go."""

    def __init__(self, moved: Moved) -> None:
        super().__init__()
        self._props |= {"size": [1, 1], "area": [0, 0, 1, 1], "point": None, "machine": None, "answer": 0}
        self._props |= {"words": "", "look": "", "label": "operating point: arrow keys move it"}
        self.on("moved", lambda event: self._tell(event.args, moved))
        self.moves = 0  # how many the browser has told

    def show(self, drawn: DrawnMap) -> None:
        """Lie over another map."""
        self._props |= {"size": list(drawn.size), "area": list(drawn.area)}
        self.update()

    def put(self, point: tuple[float, float] | None, machine: tuple[float, float] | None) -> None:
        """Put the point, and the mark of the machine itself, at these shares."""
        self._props |= {"point": point and list(point), "machine": machine and list(machine), "answer": self.moves}
        self.update()

    def say(self, words: str, verdict: str) -> None:
        """What is known at the point, for those who do not see it."""
        self._props |= {"words": words, "look": LOOKS.get(verdict, "")}
        self.update()

    def _tell(self, args: Any, moved: Moved) -> None:
        try:
            x, y, self.moves = float(args["x"]), float(args["y"]), int(args["number"])
        except (TypeError, KeyError, ValueError):
            return  # nothing that our page sends
        if 0.0 <= x <= 1.0 and 0.0 <= y <= 1.0:
            moved(x, y, bool(args.get("last")))
