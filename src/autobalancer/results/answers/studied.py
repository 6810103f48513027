"""The members of a study: shares with their intervals, quantiles, for every point of its grid."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, ClassVar

import numpy as np

from autobalancer.results.answers.ensemble import Ensemble
from autobalancer.results.display_units import axis_unit
from autobalancer.results.shares import wilson_interval
from autobalancer.shown import Column

MAIN = "peak_deflection"  # the number that is shown where nothing else was asked for
HEADS = {"drive_profile_end_and_drive_profile_peak": "speed"}
AGAIN = "settling_time"  # shown besides, where an unbalance appears at speed


class Studied(Ensemble):
    """The members of a study and what each left."""

    __slots__ = ()
    drawn_by = "study"
    needed: ClassVar[tuple[str, ...]] = ("outcome",)

    def heading(self) -> str:
        """Whose study it is, and how many members it has."""
        text = f"{self.attrs.get('study_name', 'study')}: {self.attrs.get('machine_name', 'machine')}"
        return f"{text}, {self.sizes['member']} members"

    @property
    def sudden(self) -> bool:
        """Whether an unbalance appears at speed, from which peak and settling count."""
        return "sudden_unbalance" in self.attrs

    def group(self) -> str:
        """The only parameter of the grid; empty if there are several or none."""
        grid = self.grid_names()
        return grid[0] if len(grid) == 1 else ""

    def grid_names(self) -> list[str]:
        """The coordinates of the grid, but for those with a single value."""
        from autobalancer.machine.plain_names import dimension_of

        names = np.atleast_1d(self.attrs.get("grid", [])).tolist()  # a file keeps a list of one as a text
        return [name for name in map(dimension_of, names) if np.unique(self[name].values.astype(str)).size > 1]

    def point_texts(self, unit: str = "") -> list[str]:
        """The values of the grid at each point, as people write them."""
        found = []
        for where in self.at_points():
            first = int(np.flatnonzero(where)[0])
            columns = [self._of_grid(name, [first], unit) for name in self.grid_names()]
            found.append(", ".join(f"{one.head} {one.cells()[0]} {one.unit}".strip() for one in columns))
        return found

    def at_points(self) -> list[Any]:
        """Which members belong to each point of the grid, (member,) each."""
        return [self["point"].values == point for point in np.unique(self["point"].values)]

    def counted(self) -> Any:
        """Which members ran and are independent of each other, (member,): only these tell how sure a share is.

        For Sobol' indices each two of them have others, which share numbers with them.
        """
        if self.attrs.get("plan") != "sensitivity":
            return self.ran()
        of_one = np.atleast_1d(self.attrs["inputs"]).size + 2
        return self.ran() & ((self["draw"].values - 1) % of_one < 2)

    def columns(self, unit: str = "") -> list[Column]:
        """A row for each point of the grid: its values, share of balanced runs, medians and 95 % quantiles of numbers."""
        points, ran = self.at_points(), self.counted()
        first = [int(np.flatnonzero(where)[0]) for where in points]
        columns = [self._of_grid(name, first, unit) for name in self.grid_names()]
        columns.append(Column("members", [int((where & ran).sum()) for where in points]))
        if "balanced" in self:
            counts = np.array([(self["balanced"].values & where & ran).sum() for where in points])
            totals = np.array([max(int((where & ran).sum()), 1) for where in points])
            low, high = wilson_interval(counts, totals)
            columns += [
                Column(head, 100.0 * values, "%", ".2f")
                for head, values in (("balanced", counts / totals), ("95 % from", low), ("95 % to", high))
            ]
        for name in self._shown_numbers():
            shown = axis_unit(self[name], unit or self.shown_in)
            text = name.replace("_", " ")
            for head, level in ((text, 0.5), ("95 % below", 0.95)):
                values = [_quantile(self[name].values[where & ran], level) for where in points]
                columns.append(Column(head, shown.shown(np.array(values)), shown.sign, ".4g"))
        return columns

    def _shown_numbers(self) -> list[str]:
        if "show" in self.attrs:  # a file keeps a list of one as a text
            asked = self.attrs["show"]
            return [asked] if isinstance(asked, str) else [str(name) for name in asked]
        standing = [
            str(name)
            for name in self.data_vars
            if self[name].dims == ("member",) and self[name].dtype.kind == "f" and "balanced" not in self
        ]
        shown = (MAIN, AGAIN) if self.sudden else (MAIN,)
        return standing or [name for name in shown if name in self]

    def _of_grid(self, name: str, first: list[int], unit: str) -> Column:
        values = self[name].values[first]
        if values.dtype.kind not in "fi":
            return Column(name, [str(value) for value in values])
        shown = axis_unit(self[name], unit or self.shown_in)
        head = HEADS.get(name, name.removeprefix("drive_profile_").replace("_", " "))
        return Column(head, shown.shown(values), shown.sign)

    def remarks(self) -> Sequence[str]:
        """Why it stopped, what was impossible, and what a member took."""
        return [
            *self._stopped(),
            *self._sudden(),
            *self._dependent(),
            *self._drag(),
            *(self.spread() if len(self.at_points()) == 1 else ()),
            *self.without(),
            *self._cost(),
        ]

    def _stopped(self) -> Iterator[str]:
        draws = np.unique(self["draw"].values).size
        why = {
            "confidence": f"stopped after {draws} draws: the interval that was asked for is reached",
            "interrupted": "interrupted; the same call goes on if the study has a folder",
        }.get(str(self.attrs.get("stopped_by")))
        if why:
            yield why
        if "drawn_again" in self and (again := int((self["drawn_again"].values > 0).sum())):
            share = 100.0 * again / self.sizes["member"]
            yield f"{share:.3g} % of the draws were taken again, since they made no possible machine"

    def _drag(self) -> Iterator[str]:
        if text := self.attrs.get("drag_warning"):
            yield f"range of the drag law: {text}"

    def _dependent(self) -> Iterator[str]:
        counted, ran = int(self.counted().sum()), int(self.ran().sum())
        if counted < ran:
            others = f"the other {ran - counted}, for Sobol' indices, share numbers with them"
            yield f"shares and quantiles are those of {counted} members; {others}"

    def spread(self) -> Iterator[str]:
        """Quantiles of the main measures over the members that count, a sentence each."""
        return Ensemble.of(self.isel(member=np.flatnonzero(self.counted()))).spread()

    def _sudden(self) -> Iterator[str]:
        if not self.sudden:
            return
        yield "peak and settling count from the moment at which the unbalance appears"
        ran = self.ran()
        for count, text in (
            (int((ran & ~self["balanced_before"].values.astype(bool)).sum()), "was not balanced before"),
            (
                int((ran & np.isnan(self[AGAIN].values)).sum()),
                "has balls that do not settle; the times are of the others",
            ),
        ):
            if count:
                yield f"{count} of {int(ran.sum())} members: the rotor {text}"


def _quantile(values: Any, level: float) -> float:
    known = values[np.isfinite(values)]
    return float(np.quantile(known, level)) if known.size else np.nan
