"""The members of an ensemble as a table of shares with their intervals, and the quantiles of their measures."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, ClassVar

import numpy as np
import xarray as xr

from autobalancer.results.answers.answer import Answer
from autobalancer.results.display_units import axis_unit
from autobalancer.results.number_text import length_text, moment_text, significant
from autobalancer.results.shares import wilson_interval
from autobalancer.results.verdict.rule import WORDS
from autobalancer.shown import Column, rpm_and_si

FINISHED, NOT_RUN, IMPOSSIBLE = "finished", "not run", "impossible"
CLASSES = WORDS
MOST_GROUPS = 8  # values of a column that are shown one by one
QUANTILES = (0.05, 0.5, 0.95)
TOLD = ("peak_deflection", "peak_speed", "vibration", "residual_unbalance", "settling_time", "release_speed")
TEXTS = {"m": length_text, "kg m": moment_text, "rad/s": rpm_and_si, "s": lambda value: f"{significant(value)} s"}


class Ensemble(Answer):
    """The members of an ensemble and what each left."""

    __slots__ = ()
    drawn_by = "ensemble"
    needed: ClassVar[tuple[str, ...]] = ("outcome",)

    def heading(self) -> str:
        """Whose they are, and how many ran."""
        count, ran = self.sizes["member"], int(self.ran().sum())
        part = "" if ran == count else f", of which {ran} ran"
        return f"{self.attrs.get('machine_name', 'machine')}: ensemble of {count} members{part}"

    def ran(self) -> Any:
        """Which members ran, (member,)."""
        return ~np.isin(self["outcome"].values, (NOT_RUN, IMPOSSIBLE))

    def classes(self) -> Any:
        """How each member ended, (member,): its verdict if it finished and was asked for one, else its outcome."""
        outcome = self["outcome"].values
        return np.where(outcome == FINISHED, self["verdict"].values, outcome) if "verdict" in self else outcome

    def group(self) -> str:
        """The column of few values over which shares are shown; empty if there is none."""
        names = [name for name in self.coords if self[name].dims == ("member",) and name not in ("member", "seed")]
        few = [str(name) for name in names if 1 < len(set(self[name].values.tolist())) <= MOST_GROUPS]
        return few[0] if len(few) == 1 and len(names) == 1 else ""

    def shares(self, by: str = "") -> xr.Dataset:
        """Shares of the classes among the members that ran, with their 95 % intervals (Wilson 1927).

        Parameters
        ----------
        by
            A coordinate; then for each of its values.

        Returns
        -------
        xarray.Dataset
            ``count``, ``share``, ``share_low``, ``share_high`` over ``end``, after the coordinate if one is given.
        """
        classes, ran = self.classes(), self.ran()
        ends = [*CLASSES, *sorted(set(classes[ran]) - set(CLASSES))]
        values = self[by].values if by else np.zeros(classes.size)
        groups = sorted(set(values.tolist()))
        counts = np.array([[(classes[ran & (values == one)] == end).sum() for end in ends] for one in groups])
        totals = [max(int((ran & (values == one)).sum()), 1) for one in groups]
        low, high = np.moveaxis(np.array([wilson_interval(c, t) for c, t in zip(counts, totals, strict=True)]), 1, 0)
        dims = (by, "end") if by else ("end",)
        found = {"count": counts, "share": counts / np.array(totals)[:, None], "share_low": low, "share_high": high}
        result = xr.Dataset({name: (dims, v if by else v[0]) for name, v in found.items()}, {"end": ends})
        return result.assign_coords({by: (by, groups, self[by].attrs)}) if by else result

    def share_of(self, which: Any) -> tuple[float, float, float]:
        """Share of the members that ran for which ``which`` (member,) is true, and its 95 % interval (Wilson 1927)."""
        ran = self.ran()
        count, total = int((np.asarray(which, bool) & ran).sum()), max(int(ran.sum()), 1)
        low, high = wilson_interval(np.array([count]), total)
        return count / total, float(low[0]), float(high[0])

    def quantiles(self, name: str, at: Sequence[float] = QUANTILES) -> Any:
        """Quantiles of a measure over the members that have it; nan without any."""
        values = self[name].values
        known = values[np.isfinite(values)]
        return np.quantile(known, at) if known.size else np.full(len(at), np.nan)

    def columns(self, unit: str = "") -> list[Column]:
        """The classes that came, with their shares."""
        by = self.group()
        found = self.shares(by)
        there = found if not by else found.stack(row=(by, "end"))
        there = there.isel({"row" if by else "end": np.flatnonzero(there["count"].values > 0)})
        columns = []
        if by:
            shown, values = axis_unit(self[by], unit or self.shown_in), there[by].values
            texts = values.dtype.kind not in "fi"
            columns = [
                Column(
                    by.replace("_", " "),
                    [*map(str, values)] if texts else shown.shown(values),
                    "" if texts else shown.sign,
                )
            ]
        columns += [
            Column("end", [str(end) for end in there["end"].values]),
            Column("members", there["count"].values.tolist()),
        ]
        for name, head in (("share", "share"), ("share_low", "95 % from"), ("share_high", "95 % to")):
            columns.append(Column(head, 100.0 * there[name].values, "%", ".2f"))
        return columns

    def remarks(self) -> Sequence[str]:
        """Quantiles of the main measures, and what a member took."""
        return [*self.spread(), *self.without(), *self._cost()]

    def spread(self) -> Iterator[str]:
        """Quantiles of the main measures, a sentence each."""
        for name in TOLD:
            if name in self and np.isfinite(self[name].values).any():
                written = TEXTS[str(self[name].attrs.get("units", ""))]
                low, middle, high = map(written, self.quantiles(name))
                known = int(np.isfinite(self[name].values).sum())
                among = "" if known == int(self.ran().sum()) else f" ({known} members have one)"
                yield f"{name.replace('_', ' ')}: median {middle}, 90 % from {low} to {high}{among}"

    def without(self) -> Iterator[str]:
        """How many members did not run, and why."""
        for outcome in (IMPOSSIBLE, NOT_RUN):
            count = int((self["outcome"].values == outcome).sum())
            if count:
                text = "such members cannot be built" if outcome == IMPOSSIBLE else "the ensemble was interrupted"
                yield f"{outcome}: {count} members; {text}, and they do not count in the shares"

    def _cost(self) -> Iterator[str]:
        each = float(self.attrs.get("run_time_per_member", np.nan))
        if np.isfinite(each):
            yield f"a member took {significant(1e3 * each)} ms of a core and {self.attrs['steps_per_member']:.0f} steps"

    def has_table(self) -> bool:
        """All members must be there."""
        return all(name in self and self[name].dims == ("member",) for name in self.needed)
