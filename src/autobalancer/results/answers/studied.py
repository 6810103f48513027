"""The members of a study: shares with their intervals, quantiles, for every point of its grid."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.random_numbers import wilson_interval
from autobalancer.results.answers.answer import FORMS, Answer, Form, Shown
from autobalancer.results.display_units import axis_unit, length_text, moment_text, significant
from autobalancer.results.verdict import WORDS, worse_by
from autobalancer.tables import Column, rpm_and_si

# Runs that end stalled.


def stalled(values: Mapping[str, Any] | xr.Dataset) -> Any:
    """Which runs end stalled, from their measures: with stalled balls, or with a rotor held at a critical speed by its drive."""
    return (np.asarray(values["stalled_balls"]) > 0) | np.isfinite(values["held_at_critical_speed"])


# The members of an ensemble as a table of shares with their intervals, and the quantiles of their measures.


FINISHED, NOT_RUN, IMPOSSIBLE = "finished", "not run", "impossible"
CLASSES = WORDS
MOST_GROUPS = 8  # values of a column that are shown one by one
QUANTILES = (0.05, 0.5, 0.95)
MAIN_MEASURES = (
    "peak_deflection",
    "peak_speed",
    "vibration",
    "residual_unbalance",
    "settling_time",
    "break_away_speed",
)
TEXTS = {"m": length_text, "kg m": moment_text, "rad/s": rpm_and_si, "s": lambda value: f"{significant(value)} s"}


class Ensemble(Answer):
    """The members of an ensemble and what each left."""

    __slots__ = ()
    shown_as = Form(row_of="member", needed=("outcome",))

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
        counts = np.array([[(classes[ran & (values == group)] == end).sum() for end in ends] for group in groups])
        totals = [max(int((ran & (values == group)).sum()), 1) for group in groups]
        low, high = np.moveaxis(np.array([wilson_interval(c, t) for c, t in zip(counts, totals, strict=True)]), 1, 0)
        dims = (by, "end") if by else ("end",)
        entries = {"count": counts, "share": counts / np.array(totals)[:, None], "share_low": low, "share_high": high}
        result = xr.Dataset({name: (dims, v if by else v[0]) for name, v in entries.items()}, {"end": ends})
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
        shares = self.shares(by)
        there = shares if not by else shares.stack(row=(by, "end"))
        there = there.isel({"row" if by else "end": np.flatnonzero(there["count"].values > 0)})
        columns = []
        if by:
            shown, values = axis_unit(self[by], unit or self.form().shown_in), there[by].values
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
        """Members that stall, quantiles of the main measures, members that were interpolated, and what a member took."""
        return [*self._stall(), *self.spread(), *self.without(), *self._interpolated(), *self._cost()]

    def _stall(self) -> Iterator[str]:
        """How many members end stalled, and for how long their balls were."""
        if not {"held_at_critical_speed", "stalled_balls"} <= set(self.data_vars):
            return
        which = self["outcome"].isin([FINISHED]).values & stalled(self)
        share, low, high = (100.0 * value for value in self.share_of(which))
        if share > 0.0:
            long = significant(float(np.median(self["stalled_time"].values[which])))
            yield (
                f"stalled at the end: a ball or the rotor in {share:.3g} % of the members (95 % from "
                f"{significant(low, 2)} to {significant(high, 2)} %); "
                f"half of these have had a stalled ball for {long} s or more"
            )

    def spread(self) -> Iterator[str]:
        """Quantiles of the main measures, a sentence each."""
        for name in MAIN_MEASURES:
            if name in self and np.isfinite(self[name].values).any():
                written = TEXTS[str(self[name].attrs.get("units", ""))]
                low, middle, high = map(written, self.quantiles(name))
                known, ran = int(np.isfinite(self[name].values).sum()), int(self.ran().sum())
                what, _, where = str(self[name].attrs.get("long_name", name)).partition("; ")
                among = f" ({known} of {ran} members{'; ' * bool(where)}{where})" if known < ran else ""
                yield f"{what}: median {middle}, 90 % from {low} to {high}{among}"

    def without(self) -> Iterator[str]:
        """How many members did not run, and why."""
        for outcome in (IMPOSSIBLE, NOT_RUN):
            count = int((self["outcome"].values == outcome).sum())
            if count:
                text = "such members cannot be built" if outcome == IMPOSSIBLE else "the ensemble was interrupted"
                yield f"{outcome}: {count} members; {text}, and they do not count in the shares"

    def _interpolated(self) -> Iterator[str]:
        """How many members have numbers that were interpolated between those of assembled ones, and how well."""
        if count := int(self.attrs.get("interpolated_members", 0)):
            yield (
                f"interpolated: {count} of {self.sizes['member']} members have numbers between those of assembled members; "
                f"others that were assembled as a check are met within {float(self.attrs['interpolation_error']):.1e} of them"
            )

    def _cost(self) -> Iterator[str]:
        each = float(self.attrs.get("run_time_per_member", np.nan))
        if np.isfinite(each):
            how = f", to a tolerance of {float(self.attrs['tolerance']):g}" if "tolerance" in self.attrs else ""
            yield f"a member took {significant(1e3 * each)} ms of a core and {self.attrs['steps_per_member']:.0f} steps{how}"


MAIN = "peak_deflection"  # the number that is shown where nothing else was asked for
HEADS = {"drive_profile_end_and_drive_profile_peak": "speed"}
AGAIN = "settling_time"  # shown besides, where an unbalance appears at speed


class Studied(Ensemble):
    """The members of a study and what each left."""

    __slots__ = ()

    def heading(self) -> str:
        """Whose study it is, and how many members it has."""
        text = f"{self.attrs.get('study_name', 'study')}: {self.attrs.get('machine_name', 'machine')}"
        return f"{text}, {self.sizes['member']} members"

    def numbers(self) -> list[str]:
        """Names of all numbers that each member has."""
        return [
            str(name) for name, one in self.data_vars.items() if one.dims == ("member",) and one.dtype.kind in "fib"
        ]

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
        from autobalancer.machine.path import dimension_of

        names = np.atleast_1d(self.attrs.get("grid", [])).tolist()  # a file keeps a list of one as a text
        return [name for name in map(dimension_of, names) if np.unique(self[name].values.astype(str)).size > 1]

    def point_texts(self, unit: str = "") -> list[str]:
        """The values of the grid at each point, as people write them."""
        result = []
        for where in self.at_points():
            first = int(np.flatnonzero(where)[0])
            columns = [self._of_grid(name, [first], unit) for name in self.grid_names()]
            result.append(", ".join(f"{column.head} {column.cells()[0]} {column.unit}".strip() for column in columns))
        return result

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
        stalls = "stalled" in self and bool(self["stalled"].values[ran].any())
        for share in ("balanced", *["stalled"] * stalls) if "balanced" in self else ():
            counts = np.array([(self[share].values.astype(bool) & where & ran).sum() for where in points])
            totals = np.array([max(int((where & ran).sum()), 1) for where in points])
            low, high = wilson_interval(counts, totals)
            columns += [
                Column(head, 100.0 * values, "%", ".2f")
                for head, values in ((share, counts / totals), ("95 % from", low), ("95 % to", high))
            ]
        for name in self._shown_numbers():
            shown = axis_unit(self[name], unit or self.form().shown_in)
            text = name.replace("_", " ")
            for head, level in ((text, 0.5), ("95 % below", 0.95)):
                values = [_quantile(self[name].values[where & ran], level) for where in points]
                cells = ["never" if np.isinf(value) else float(shown.shown(value)) for value in values]
                columns.append(Column(head, cells, shown.sign, ".4g"))
        return columns

    def _shown_numbers(self) -> list[str]:
        if "show" in self.attrs:  # a file keeps a list of one as a text
            requested = self.attrs["show"]
            return [requested] if isinstance(requested, str) else [str(name) for name in requested]
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
        shown = axis_unit(self[name], unit or self.form().shown_in)
        head = HEADS.get(name, name.removeprefix("drive_profile_").replace("_", " "))
        return Column(head, shown.shown(values), shown.sign)

    def remarks(self) -> Sequence[str]:
        """Why it stopped, what was impossible, and what a member took."""
        return [
            *self._stopped(),
            *self._stall(),
            *([str(self.attrs["passage_text"])] if self.attrs.get("passage_text") else []),
            *self._sudden(),
            *self._dependent(),
            *self._drag(),
            *meanings(self, {name: name.replace("_", " ") for name in self._shown_numbers()}),
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


def meanings(found: xr.Dataset, heads: Mapping[str, str]) -> list[str]:
    """What the columns of a table are, by the long names of their variables, where these say more than the heads."""
    long = {head: str(found[name].attrs.get("long_name", head)) for name, head in heads.items() if name in found}
    return [f"{head}: {text}" for head, text in long.items() if text != head]


def _quantile(values: Any, level: float) -> float:
    """Of those that are known; a border that never comes is above all others."""
    known = values[~np.isnan(values)]
    with np.errstate(invalid="ignore"):
        quantile = float(np.quantile(known, level)) if known.size else np.nan
    return np.inf if known.size and np.isnan(quantile) else quantile


# The ends of runs from many starts as a table: how often each one comes, and what it leaves.


LEFT = (  # variable, what it is called, how it is written, the value without balls
    ("residual_quantile", "residual unbalance", moment_text, "unbalance"),
    ("deflection_quantile", "deflection", length_text, "deflection_without_balls"),
    ("vibration_quantile", "vibration", length_text, "vibration_without_balls"),
    ("peak_quantile", "greatest deflection on the way", length_text, "peak_without_balls"),
)

HELD = "held by friction"


def which_starts(found: xr.Dataset, quantity: str = "") -> str:
    """Over which starts the quantiles of a quantity are, behind its name; empty where all count."""
    name = "residual_starts" if quantity.startswith("residual") and "residual_starts" in found else "quantile_starts"
    return str(found[name].attrs["comment"]) if name in found else ""


class Ends(Answer):
    """Ends of a machine at a speed, from many starts."""

    __slots__ = ()
    shown_as = Form(row_of="end", needed=("share",), there=lambda it: "state" in it and "speed" in it.attrs)

    def columns(self, unit: str = "") -> list[Column]:
        """The ends that came, their shares, and of random starts the intervals of these."""
        there = self.isel(end=np.flatnonzero(self["share"].values > 0.0))
        result = [Column("end", [str(end) for end in there["end"].values])]
        for name, head in (("share", "share"), ("share_low", "95 % from"), ("share_high", "95 % to")):
            if name in there:
                result.append(Column(head, 100.0 * there[name].values, "%", ".2f"))
        return result

    def heading(self) -> str:
        """Whose they are, and at which speed."""
        starts = int(self["state"].size)
        return f"{self.attrs.get('machine_name', 'machine')}: ends of {starts} starts at {rpm_and_si(float(self.attrs['speed']))}"

    def remarks(self) -> Sequence[str]:
        """Which verdicts they had, and what they leave."""
        return [*super().remarks(), *self.left()]

    def left(self) -> Iterator[str]:
        """Verdicts, balls that move, and quantiles of what the ends leave, a sentence each."""
        if "verdict_share" in self:
            shares = zip(self["verdict"].values, self["verdict_share"].values, strict=True)
            if self._held():
                yield f"{HELD}: the balls rest where friction stops them, near balance or far from it; see the verdict"
            yield "verdict: " + ", ".join(f"{word} {100.0 * share:.3g} %" for word, share in shares if share > 0.0)
        of = which_starts(self)
        for plane, own in self.planes().items():
            ends = ", ".join(f"{name} {100.0 * share:.3g} %" for name, share in own["share"].items())
            middle, *_, most = own["residual_unbalance"].values()
            rest = f"; residual unbalance{of or ' at rest'}: median {moment_text(middle)}, at most {moment_text(most)}"
            yield f"plane {plane}: {ends}{rest if middle == middle else ''}; without balls {moment_text(own['unbalance'])}"
        if "moving_share" in self and float(self["moving_share"]) > 0.0:
            stalls = 100.0 * float(self.get("stalled_share", 0.0))
            beside = f", stalled in {stalls:.3g} %" if stalls else ""
            yield f"balls still move at the end of {100.0 * float(self['moving_share']):.3g} % of the runs{beside}"
        if "residual_starts" in self and not int(self["residual_starts"]):
            without = moment_text(float(self["unbalance"]))
            yield f"residual unbalance: none, in each run a ball is stalled or goes round in the rotor; without balls {without}"
        for name, text, written, whole in LEFT:
            if name in self and np.isfinite(self[name].values[0]):
                middle, often, most = map(written, self[name].values)
                how = self.attrs.get("released", "released")
                beside = f"without balls {written(float(self[whole]))}"
                ratio = float(self[name].values[0]) / float(self[whole]) if float(self[whole]) > 0.0 else np.nan
                much = worse_by(ratio) if name == "peak_quantile" else ""
                half = f" (half of the runs at least {much})" * bool(much)
                of = which_starts(self, name)
                yield f"{text}{of}, {how}: median {middle}, 95 % below {often}, at most {most}; {beside}{half}"

    def planes(self) -> dict[str, dict[str, Any]]:
        """Of each of several planes the shares of its ends, quantiles of its residual and its unbalance, SI."""
        if self.sizes.get("plane", 0) < 2:
            return {}
        names, possible = list(self.attrs["plane_states"]), self["state"].size - int(self.attrs["overlapping"])
        quantiles = [str(float(q)) for q in self["quantile"].values]
        answer = {}
        for number, plane in enumerate(self["plane"].values.tolist()):
            own = self.isel(plane=number)
            counts = np.bincount(own["plane_state"].values.ravel(), minlength=len(names))
            shares = {name: int(count) / max(possible, 1) for name, count in zip(names, counts, strict=True)}
            answer[str(plane)] = {
                "share": {name: share for name, share in shares.items() if share and name != "overlapping start"},
                "residual_unbalance": dict(zip(quantiles, own["plane_residual_quantile"].values.tolist(), strict=True)),
                "unbalance": float(own["plane_unbalance"]),
            }
        return answer

    def _held(self) -> bool:
        return HELD in self["end"].values and float(self["share"].sel(end=HELD)) > 0.0


# How much each input adds to the scatter of a quantity, as a table.


SHOWN = {"first": "alone", "total": "in all", "rank_correlation": "rank correlation"}


def _driven(found: Answer, unit: str) -> list[Column]:
    """A row for each input, the strongest first; the points of a grid one after the other."""
    row = "row" if "point" in found.dims else "input"
    flat = found.stack(row=("point", "input")) if row == "row" else found
    key = "total" if "total" in found else "rank_correlation"
    order = np.argsort(-np.abs(flat[key].values), kind="stable")
    if row == "row":
        order = order[np.argsort(flat["point"].values[order], kind="stable")]
    flat = flat.isel({row: order})
    points = "at" if "at" in flat.coords else "point"
    columns = [Column(points, flat[points].values.tolist())] if row == "row" else []
    columns.append(Column("input", [str(name).replace("_", " ") for name in flat["input"].values]))
    for name, head in SHOWN.items():
        if name in found:
            interval = (Shown(f"{name}_low", "95 % from", form=".3f"), Shown(f"{name}_high", "95 % to", form=".3f"))
            columns += flat.shown(unit, Shown(name, head, form=".3f"), *interval)
    return columns


FORMS["Sensitivity"] = Form(
    _driven,
    there=lambda it: "input" in it.dims and any(name in it for name in SHOWN),
    heading=lambda it: f"{it.attrs['study_name']}: what drives the scatter of {it.attrs['quantity'].replace('_', ' ')}",
    remarks=lambda it: [str(text) for text in np.atleast_1d(it.attrs.get("remarks", []))],
)


# The runs of a sweep as a table: one row for each.


EXTRA = ("seed",)  # a dimension that is no parameter of the machine


def _runs(found: Answer, unit: str) -> list[Column]:
    """Parameters, greatest deflection and its speed, what is left, and the verdict."""
    runs = found["verdict"].dims
    flat = found.stack(one_run=runs) if len(runs) > 1 else found
    columns = []
    for name, values in flat.coords.items():
        if values.dims not in ((runs[0],), ("one_run",)) or name == "one_run":
            continue
        if values.dtype.kind in "fi" and name not in EXTRA:
            shown = axis_unit(found.coords[name], unit or "rpm")
            head = str(found.coords[name].attrs.get("long_name", name))
            columns.append(Column(head, shown.shown(values.values), shown.sign))
        else:
            columns.append(Column(str(name), [str(value) for value in values.values]))
    return columns + flat.shown(
        unit,
        Shown("peak_deflection", HEADS_OF_RUNS["peak_deflection"], "µm", ".4g"),
        Shown("peak_speed", "peak at", form=".4g"),
        Shown("vibration", HEADS_OF_RUNS["vibration"], "µm", ".3g"),
        Shown("residual_share", HEADS_OF_RUNS["residual_share"], "%", ".2f"),
        Shown("verdict"),
    )


MEASURED = ("verdict", "outcome", "peak_deflection", "vibration", "residual_share")
HEADS_OF_RUNS = {"peak_deflection": "peak", "vibration": "vibration left", "residual_share": "unbalance left"}
FORMS["Swept"] = Form(
    _runs,
    there=lambda it: all(name in it for name in MEASURED) and bool(it["verdict"].dims),
    remarks=lambda it: meanings(it, HEADS_OF_RUNS),
)
