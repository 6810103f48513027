"""Designs as a table: those that ran, the best first, and what ruled the others out."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.arrays import Floats
from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import parse_machine
from autobalancer.random_numbers import wilson_interval
from autobalancer.results.answers.answer import Answer, Form, provenance
from autobalancer.results.display_units import axis_unit, moment_text, significant
from autobalancer.results.labels import labeled
from autobalancer.studies.design.candidate import Design
from autobalancer.studies.design.specification import MASS, OUTER, STALL, Asked
from autobalancer.tables import Column, rpm_and_si

SHOWN = {
    "m": ("mm", 1e3),
    "kg m": ("g mm", 1e6),
    "s": ("s", 1.0),
    "kg": ("g", 1e3),
    "Pa": ("MPa", 1e-6),
    "N": ("N", 1.0),
    "1": ("times", 1.0),
}
MEETS = {1: "yes", 0: "undecided", -1: "no"}
NEAREST = 3  # reasons of a question that are listed
MOST_PLACES = 8  # that are listed one by one
OPEN = " undecided"  # how a limit ends of which too few runs tell
USUAL = 1.5  # times the unbalance: with a smaller capability balls stand nearly side by side and react slowly
ORDINAL = {1.0: "st", 2.0: "nd", 3.0: "rd"}  # of percentiles above 20
SAME, NOT_RUN = "same race", "not run"
STAGES = ("space", "fluid", "capability", "pressure", SAME, "border", "pick-up", "limits", NOT_RUN, "runs")


class Designed(Answer):
    """Candidates over their numbers: what they are, where they were ruled out and why, what the runs left."""

    __slots__ = ()
    shown_as = Form()

    def order(self) -> list[int]:
        """Where those that ran stand among the candidates, from 0, the best first."""
        places = self["place"].values
        return [int(one) for one in np.argsort(places)[: int(np.isfinite(places).sum())]]

    def best(self) -> xr.Dataset:
        """Those that ran, the best first."""
        return self.isel(design=self.order())

    def ruled_out(self) -> dict[str, int]:
        """How many candidates each question ruled out."""
        counts = Counter(
            str(stage)
            for stage, place in zip(self["stage"].values, self["place"].values, strict=True)
            if np.isnan(place)
        )
        return {stage: counts[stage] for stage in STAGES if counts[stage]}

    def facts(self) -> list[tuple[str, str]]:
        """What was asked, and how many candidates each question left."""
        low, high = self.attrs["unbalance_range"]
        ran = int(np.isfinite(self["place"].values).sum())
        out = self.ruled_out()
        parts = [f"{stage} {count}" for stage, count in out.items() if stage not in (SAME, NOT_RUN)]
        said = f"; ruled out by {', '.join(parts)}" if parts else ""
        said += f"; {out[SAME]} have the race of another one" if SAME in out else ""
        said += f"; {out[NOT_RUN]} were not run" if NOT_RUN in out else ""
        rotor = [("measured rotor", str(self.attrs["rotor"]))] if "rotor" in self.attrs else []
        return [
            ("answer", self.answer()),
            *([("not in the runs", str(self.attrs["left_out"]))] if self.attrs.get("left_out") else []),
            *rotor,
            ("operating speed", ", ".join(rpm_and_si(float(one)) for one in np.atleast_1d(self.attrs["speeds"]))),
            ("unbalance", f"{moment_text(low)} to {moment_text(high)}" if low < high else moment_text(high)),
            *([("temperature", self._temperatures())] if "temperature_range" in self.attrs else []),
            (
                "limits",
                "; ".join(self._limit(name, value) for name, value in json.loads(self.attrs["limits"]).items())
                or "none",
            ),
            ("candidates", f"{self.sizes['design']}{said}; {ran} ran, {self.attrs['members']} times each"),
            ("searched", str(self.attrs["searched_by"])),
        ]

    def _temperatures(self) -> str:
        cold, warm = (kelvin - 273.15 for kelvin in self.attrs["temperature_range"])
        return f"{cold:.4g} to {warm:.4g} °C" if cold < warm else f"{cold:.4g} °C"

    def answer(self) -> str:
        """Whether any design keeps all limits; of the first one how many runs stall, and its passage beside held balls."""
        best = self.best()
        if not best.sizes["design"]:
            return self._answer(best)
        stall = f"{self['stall'].attrs['long_name']}: {self._interval(best, 'stall', 0)} %" * (
            float(best["stall"][0]) > 0.0
        )
        return "; ".join(filter(None, (self._answer(best), stall, str(best["passage"].values[0]))))

    def _answer(self, best: xr.Dataset) -> str:
        limits = json.loads(self.attrs["limits"])
        ran, meets = best.sizes["design"], best["meets"].values
        if not ran:
            return "none ran"
        first = str(best["label"].values[0])
        if not limits.keys() - {"share"}:
            return f"no limits are given; first by {' and '.join(self.attrs['objectives']).replace('_', ' ')}: {first}"
        if kept := int((meets == 1).sum()):
            return f"{kept} of {ran} designs keep{'s' * (kept == 1)} all limits{self._so_far(best)}; the best: {first}"
        names = [name for name in str(best["missed"].values[0]).split(", ") if name]
        if left := int((meets == 0).sum()):
            which = ", ".join(name.removesuffix(OPEN) for name in names)
            tell = f"for {left} of {ran} there are too few runs to tell"
            return f"no design is known to keep all limits: {tell}; the first in order: {first}, undecided by {which}"
        missed = [name for name in names if not name.endswith(OPEN)]
        texts = [f"{name} {self._beyond(best, name.replace(' ', '_'), limits)}" for name in missed]
        return f"no design keeps all limits; the nearest misses {len(missed)}: {', '.join(texts)}; it is {first}"

    def _so_far(self, best: xr.Dataset) -> str:
        """In how many runs limits are kept that no run may exceed, which does not prove that none ever will."""
        limits, count = json.loads(self.attrs["limits"]), int(self.attrs["members"])
        stall = limits.get(STALL, 1.0) == 0.0
        if not stall and not (float(self.attrs["share"]) == 1.0 and limits.keys() - {STALL, "share"}):
            return ""
        most = f", though up to {100.0 * float(best['stall_high'][0]):.2g} % of all may stall (95 % confidence)" * stall
        return f" in {count} run{'s' * (count > 1)} of {count}{most}"

    def _beyond(self, best: xr.Dataset, name: str, limits: dict[str, Any]) -> str:
        """What the first design reaches of a limit, and the limit."""
        if name == "stall_probability":
            return f"{100.0 * float(best['stall'].values[0]):.3g} % for {100.0 * limits[name]:.3g} %"
        sign, factor = SHOWN[self[name].attrs["units"]]
        value = float(best[name].values[0])
        reached = f"{significant(factor * value)} {sign}" if np.isfinite(value) else "never"
        return f"{reached} for {significant(factor * limits[name])}{f' {sign}' * (reached == 'never')}"

    def columns(self, unit: str = "") -> list[Column]:
        """One row for each design that ran, the best first."""
        best = self.best()
        objectives = [name for name in self.attrs["objectives"] if f"{name}_median" in self]
        measures = list(dict.fromkeys((*objectives, "peak_deflection", "settling_time", *self._measured())))
        borders = [name for name in ("release", "border") if name in self]
        return [
            Column("place", [int(one) for one in best["place"].values]),
            Column("design", [str(one) for one in best["label"].values], wraps=True),
            Column("keeps limits", self._keeps(best)),
            *(self._scaled(best, name) for name in measures),
            Column("stall", [self._interval(best, "stall", i) for i in range(best.sizes["design"])], "%"),
            *(
                self._speed(best, name, {"release": "release speed", "border": "exact border"}[name], unit)
                for name in borders
            ),
            Column("ball mass", 1e3 * best["ball_mass"].values, "g", ".4g"),
            Column("front in its class", [int(one) + 1 for one in best["front"].values]),
        ]

    def _keeps(self, dataset: xr.Dataset) -> list[str]:
        """Whether each design keeps all limits, or how many it misses."""
        pairs = zip(dataset["meets"].values.astype(int), dataset["misses"].values.astype(int), strict=True)
        said = MEETS | ({1: so_far} if (so_far := self._so_far(dataset).partition(",")[0].strip()) else {})
        return [f"misses {count}" if meets < 0 and count else said[meets] for meets, count in pairs]

    def remarks(self) -> Sequence[str]:
        """What the numbers mean, and examples of what was ruled out."""
        return [*self.meanings(), *(f"ruled out: {text}" for text in self.reasons())]

    def meanings(self) -> list[str]:
        """What the numbers mean."""
        share = 100.0 * float(self.attrs["share"])
        low, high = self.attrs["unbalance_range"]
        value = f"{share:g}{ORDINAL.get(share % 10.0, 'th')} percentile" if share < 100.0 else "greatest"
        texts = [
            f"each value is the {value} of the runs; stall: {self['stall'].attrs['long_name']}, with its 95 % interval",
            "front in its class: Pareto front of the two objectives among the designs that keep, or miss, as many limits",
        ]
        if low < high and "unbalance" not in self.dims:
            texts += [
                f"the runs have unbalances of all sizes from {moment_text(low)} to {moment_text(high)}: rotors of one "
                "unbalance, at an end or between, may do worse; the report of a machine runs both ends, each alone"
            ]
        texts += [*self._missed(), *self._hardly()]
        texts = [*self.attrs.get("remarks", []), *texts]
        texts += [f"measured rotor: {text}" for text in str(self.attrs.get("rotor_warnings", "")).split("\n") if text]
        texts += np.atleast_1d(self.attrs.get("few", [])).tolist()
        return [*texts, *np.atleast_1d(self.attrs.get("borders_ignore", [])).tolist(), *self._drag()]

    def _drag(self) -> list[str]:
        """How many of those that ran leave the range of their drag law, and what one of them says of it."""
        if "drag_warning" not in self:
            return []
        drag = self.best()["drag_warning"].values.astype(str)
        there = np.flatnonzero(drag != "")
        if not there.size:
            return []
        who = f"{there.size} of {drag.size} designs leave the range of their drag law"
        return [f"{who}; of place {there[0] + 1}: {drag[there[0]]}"]

    def _missed(self) -> list[str]:
        """Which limits are missed, and of which too few runs tell; each with the places."""
        if "missed" not in self:
            return []
        places: dict[str, list[str]] = {}
        for place, text in enumerate(self.best()["missed"].values.astype(str), start=1):
            for name in filter(None, text.split(", ")):
                places.setdefault(name, []).append(str(place))
        lines = []
        for word, end in (("limits not met", False), ("undecided, too few runs", True)):
            said = [
                f"{name.removesuffix(OPEN)} ({_listed(where)})"
                for name, where in places.items()
                if name.endswith(OPEN) == end
            ]
            lines += [f"{word}: {'; '.join(said)}"] if said else []
        return lines

    def _hardly(self) -> list[str]:
        """That the first design balances hardly more than the largest unbalance, where no margin was asked for."""
        margin = float(self.best()["capability_margin"].values[0]) if self.best().sizes["design"] else np.inf
        if "capability_margin" in json.loads(self.attrs["limits"]) or not margin < USUAL:
            return []
        return [
            f"place 1 can balance {margin:.3g} times the largest unbalance; with less than {USUAL:g} to 2 times balls react "
            "slowly near it, see limits.capability_margin"
        ]

    def reasons(self) -> list[str]:
        """Why candidates were ruled out: alike ones together, for each question the nearest misses first."""
        out = self.isel(design=np.flatnonzero(np.isnan(self["place"].values)))
        out = out.isel(design=np.argsort(out["excess"].values, kind="stable"))
        shown = []
        for stage in STAGES:
            if stage == SAME:  # the labels say it
                continue
            alike: dict[str, list[str]] = {}
            for one, label, reason in zip(*(out[name].values for name in ("stage", "label", "reason")), strict=True):
                if one == stage:
                    alike.setdefault(str(reason), []).append(str(label))
            for reason, labels in list(alike.items())[:NEAREST]:
                more = f" and {len(labels) - 1} more" if len(labels) > 1 else ""
                shown.append(f"{labels[0]}{more}: {reason}")
            left = sum(map(len, list(alike.values())[NEAREST:]))
            shown += [f"{left} more{'' if stage == NOT_RUN else f' by {stage}, which miss it by more'}"] if left else []
        return shown

    def in_si(self) -> xr.Dataset:
        """One row for each candidate, without the machine files and the numbers of single runs."""
        return self.drop_vars("machine", errors="ignore").drop_dims(["unbalance", "seed"], errors="ignore")

    def has_table(self) -> bool:
        """All that the table needs must be there."""
        return {"label", "place", "misses", "stage", "reason", "peak_deflection"} <= set(self) and self[
            "label"
        ].dims == ("design",)

    def _measured(self) -> list[str]:
        return [name for name in json.loads(self.attrs["limits"]) if name in self]

    def _scaled(self, dataset: xr.Dataset, name: str) -> Column:
        sign, factor = SHOWN[dataset[name].attrs["units"]]
        values = [None if not np.isfinite(one) else factor * float(one) for one in dataset[name].values]
        return Column(name.replace("_", " "), ["never" if one is None else significant(one) for one in values], sign)

    def _speed(self, dataset: xr.Dataset, name: str, head: str, unit: str) -> Column:
        shown = axis_unit(dataset[name], unit or "rpm")
        return Column(head, shown.shown(dataset[name].values), shown.sign, ".4g")

    def _interval(self, dataset: xr.Dataset, name: str, row: int) -> str:
        share, low, high = (100.0 * float(dataset[f"{name}{end}"].values[row]) for end in ("", "_low", "_high"))
        return f"{share:.3g} ({significant(low, 2)} to {significant(high, 2)})"

    def _limit(self, name: str, value: Any) -> str:
        words = name.replace("_", " ")
        if name == "capability_margin":
            return f"{words} {value:g} times"
        if name in self and (unit := self[name].attrs.get("units")) in SHOWN:
            sign, factor = SHOWN[unit]
            return f"{words} {significant(factor * value)} {sign}"
        return f"{words} {1e-6 * value:.4g} MPa" if name == "contact_pressure" else f"{words} {100.0 * value:.3g} %"


def _listed(places: Sequence[str]) -> str:
    """Places as people list them; many as their number."""
    if len(places) > MOST_PLACES:
        return f"{len(places)} designs"
    return f"place{'s' * (len(places) > 1)} {', '.join(places)}"


# The machine of a design, with what it was chosen for in its description.


def designed_machine(designs: xr.Dataset, place: int = 1) -> Any:
    """The machine of the design at a place, 1 for the best, that can be saved and run.

    Parameters
    ----------
    designs
        From :func:`autobalancer.design`.
    place
        In their order.

    Raises
    ------
    QuestionError
        If no design has this place.
    """
    one = placed(designs, place, "designed_machine")
    machine = parse_machine(str(one["machine"].values))
    label = str(one["label"].values)
    return machine.model_copy(
        update={"name": f"{machine.name}, {label}", "description": _description(designs, one, machine)}
    )


def placed(designs: xr.Dataset, place: int, name: str) -> xr.Dataset:
    """The design at a place, for the question called ``name``."""
    if "place" not in designs or "machine" not in designs or "searched_by" not in designs.attrs:
        raise QuestionError(f"{name}: wants the answer of a search for designs")
    there = designs["place"].values == place
    if not there.any():
        most = int((designs["place"].values > 0).sum())
        raise QuestionError(f"place: given {place}; the designs that ran have 1 to {most}")
    return designs.isel(design=int(there.argmax()))


def _description(designs: xr.Dataset, dataset: xr.Dataset, machine: Any) -> str:
    fluid = str(dataset["fluid"].values)
    filled = f" It is filled with {fluid}{' (shares by mass)' if '%' in fluid else ''}." if fluid else ""
    facts, at = dict(Designed.of(designs).facts()), ""
    sizes = ", ".join(facts[name] for name in ("unbalance", "temperature") if name in facts)
    if "temperature_range" in designs.attrs:
        at = f" Its numbers here are those at {float(np.mean(designs.attrs['temperature_range'])) - 273.15:.4g} °C."
    missed = ", ".join(name for name in str(dataset["missed"].values).split(", ") if not name.endswith(OPEN))
    keeps = {1: "It keeps them", 0: "Too few runs to say whether it keeps them", -1: f"It misses {missed}"}
    runs, seed = int(designs.attrs["members"]), int(designs.attrs["seed"])
    last = seed + designs.sizes.get("seed", 1) - 1
    said = f"{runs} run{'s' * (runs > 1)} with the seed{f's {seed} to {last}' if last > seed else f' {seed}'}"
    began = f" The machine that was given: {machine.description}" if machine.description else ""
    return (
        f"Place {int(dataset['place'])} of design {designs.attrs['design_name']!r} for unbalances of {sizes}.{filled}{at} "
        f"Limits: {facts['limits']}. {keeps[int(dataset['meets'])]} in {said}.{designs.attrs.get('assumed', '')}{began}"
    )


# Numbers of a design from its runs, and whether it keeps the limits: shares with their 95 % intervals (Wilson 1927).


KEPT, UNDECIDED, MISSED = 1, 0, -1


def numbers_of_runs(spec: Asked, cases: Sequence[Mapping[str, NDArray[Any]]]) -> dict[str, float]:
    """Numbers of a design of its runs: of several cases, each with the measures of all its runs by name, the worst one counts.

    Of a measure: its value that the wanted share of the runs stays below, its median, the share of runs above the limit with its
    interval; of flags, which runs end stalled or balanced, their share. A measure is infinite where a run has none.
    """
    numbers: dict[str, float] = {}
    for name in spec.run_limits:
        parts = [_measure(spec, name, case[name]) for case in cases if name in case]
        numbers |= max(parts, key=lambda part, name=name: (part.get(f"{name}_over", 0.0), part[name]))  # type: ignore[misc]
    for name, worst in (("stall", max), ("balanced", min)):
        shares = [_share(name, case[name]) for case in cases if name in case]
        numbers |= worst(shares, key=lambda part, name=name: part[name]) if shares else {}  # type: ignore[misc]
    return numbers


def _measure(spec: Asked, name: str, values: Floats) -> dict[str, float]:
    measure = {name: level(values, spec.share), f"{name}_median": level(values, 0.5)}
    limit = spec.limits.get(name)
    return measure if limit is None else measure | _share(f"{name}_over", ~(values <= limit))


def level(values: Floats, share: float) -> float:
    """The value that at least this share of the runs does not exceed."""
    ordered = np.sort(values)
    return float(ordered[min(math.ceil(share * ordered.size) - 1, ordered.size - 1)])


def _share(name: str, which: NDArray[np.bool_]) -> dict[str, float]:
    count, total = int(which.sum()), int(which.size)
    low, high = wilson_interval(np.array([count]), total)
    return {name: count / total, f"{name}_low": float(low[0]), f"{name}_high": float(high[0])}


def verdicts(spec: Asked, design: Design) -> dict[str, int]:
    """Each limit on the runs: kept, missed, or open because so few runs cannot tell."""
    shares = {name: (f"{name}_over", 1.0 - spec.share) for name in spec.run_limits if name in spec.limits}
    if STALL in spec.limits:
        shares[STALL] = ("stall", spec.limits[STALL])
    return {limit: _verdict(design.numbers, share, allowed) for limit, (share, allowed) in shares.items()}


def _verdict(numbers: dict[str, float], share: str, allowed: float) -> int:
    if not allowed:  # no run may: the worst one decides
        return MISSED if numbers[share] > 0.0 else KEPT
    if numbers[f"{share}_high"] <= allowed:
        return KEPT
    return MISSED if numbers[f"{share}_low"] > allowed else UNDECIDED


# The order of the designs that ran: limits, how many are missed and by how much, then the Pareto front.


def objective(design: Design, name: str) -> float:
    """A number of a design that should be small."""
    if name == MASS:
        return design.ball_mass
    return design.candidate.ring.outer if name == OUTER else design.numbers.get(name, math.nan)


def meets(spec: Asked, design: Design) -> int:
    """1: keeps all limits; 0: too few runs to say; -1: misses one."""
    return min(verdicts(spec, design).values(), default=1)


def missed(spec: Asked, design: Design) -> str:
    """The limits that it misses, and those of which too few runs say nothing."""
    found_of = verdicts(spec, design)
    texts = [name.replace("_", " ") for name, one in found_of.items() if one == MISSED]
    return ", ".join(
        texts + [f"{name.replace('_', ' ')} undecided" for name, one in found_of.items() if one == UNDECIDED]
    )


def misses(spec: Asked, design: Design) -> dict[str, float]:
    """The limits that it misses, each with how far it is beyond it, over the limit."""
    beyond = {name: one for name, one in verdicts(spec, design).items() if one == MISSED}
    return {name: _share_of_limit(spec, design, name) - 1.0 for name in beyond}


def _share_of_limit(spec: Asked, design: Design, name: str) -> float:
    """How much of a limit a design uses up; of a limit of zero one more than what it reaches."""
    value, limit = design.numbers["stall" if name == STALL else name], spec.limits[name]
    return value / limit if limit > 0.0 else (1.0 + value) * (value > 0.0)


def _added_up(beyond: Collection[float]) -> tuple[int, float]:
    """How many have no end, as a settling time of balls that never settle, and the sum of the others."""
    finite = [one for one in beyond if math.isfinite(one)]
    return len(beyond) - len(finite), sum(finite)


def used(spec: Asked, design: Design) -> float:
    """The greatest share of a limit that it uses up; 0 without limits on the runs."""
    return max((_share_of_limit(spec, design, name) for name in verdicts(spec, design)), default=0.0)


def ordered(spec: Asked, ran: Sequence[Design]) -> list[tuple[Design, int]]:
    """Designs that ran, the best first, each with the number of its front.

    First those that keep all limits, then those of which the runs cannot tell, then those that miss one, two and so on: classes.
    On front 0 of a class nothing is better in both objectives. Those that miss limits are ordered by how far they are beyond
    them, in shares of each added up; all others front by front, and on a front the one whose two objectives have the smallest
    product: a little of one is given for much of the other, in shares of each.
    """
    result: list[tuple[Design, int]] = []
    beyond = {id(one): misses(spec, one) for one in ran}
    classes = {id(one): (-meets(spec, one), len(beyond[id(one)])) for one in ran}
    for level in sorted(set(classes.values())):
        group = [one for one in ran if classes[id(one)] == level]
        values = np.array([[objective(one, name) for name in spec.objectives] for one in group])
        front = fronts(values[:, 0], values[:, 1])
        with np.errstate(invalid="ignore"):
            product = np.where(np.isfinite(values).all(axis=1), values.prod(axis=1), math.inf)
        excess = [_added_up(beyond[id(one)].values()) for one in group]
        order = sorted(
            range(len(group)),
            key=lambda i: (excess[i], front[i], product[i], used(spec, group[i]), group[i].candidate.label),
        )
        result += [(group[i], int(front[i])) for i in order]
    return result


def fronts(first: Floats, second: Floats) -> NDArray[np.int64]:
    """Number of the front of each point: on front 0 none is better in both; front 1 is that without front 0, and so on.

    Both are better where smaller; points with nan or infinity come last, all on one front.
    """
    result = np.full(first.size, -1, np.int64)
    known = np.isfinite(first) & np.isfinite(second)
    front = 0
    while (left := np.flatnonzero(known & (result < 0))).size:
        a, b = first[left], second[left]
        no_worse = (a[:, None] <= a[None, :]) & (b[:, None] <= b[None, :])
        better = no_worse & ((a[:, None] < a[None, :]) | (b[:, None] < b[None, :]))
        result[left[~better.any(axis=0)]] = front
        front += 1
    result[result < 0] = front
    return result


def refuse_none(spec: Any, designs: Sequence[Design]) -> None:
    """Refuse a specification that leaves no candidate.

    Raises
    ------
    QuestionError
        With how many each question ruled out, and the nearest miss of the question that ruled the last ones out.
    """
    if not designs:
        raise QuestionError("candidates: there is none; races and fluids do not go together")
    if any(not design.reason for design in designs):
        return
    counts = {stage: sum(design.stage == stage for design in designs) for stage in STAGES}
    said = ", ".join(f"{stage} {count}" for stage, count in counts.items() if count)
    last = max((design.stage for design in designs), key=STAGES.index)
    nearest = min((design for design in designs if design.stage == last), key=lambda one: one.excess)
    text = (
        f"candidates: none of {len(designs)} is left; ruled out by {said}. The last ones were ruled out by {last}, the nearest: "
        f"{nearest.candidate.label}: {nearest.reason}{nearest.cure()}"
    )
    raise QuestionError(". ".join([text, *spec.remarks]))


# All candidates of a design as a labeled dataset: what they are, where they were ruled out and why, what the runs
# left.


ENDS = {"low": "lower end of its 95 % interval", "high": "upper end of its 95 % interval"}
DesignColumn = tuple[str, Callable[[Any], Any], str, str]  # name, number or text, what it is, unit
OF_ALL: tuple[DesignColumn, ...] = (
    ("capability", lambda d: d.capability, "unbalance that the balls of a plane can balance", "kg m"),
    ("capability_margin", lambda d: d.margin, "capability over what is to be balanced, the least of all planes", "1"),
    ("ball_mass", lambda d: d.ball_mass, "mass of all balls", "kg"),
    ("pressure", lambda d: d.pressure, "greatest pressure between ball and race (Hertz)", "Pa"),
)


def dataset_of(
    spec: Asked,
    designs: Sequence[Design],
    described: Sequence[DesignColumn],
    stalls: str,
    text_of: Callable[[Any], str],
    attributes: Mapping[str, Any],
) -> Designed:
    """Over ``design``: candidates in their order; ``place`` is 1 for the best, nan for those that did not run.

    Parameters
    ----------
    spec
        What was asked.
    designs
        All candidates that were looked at.
    described
        Name, number or text, meaning and unit of what else is said of a candidate of this kind of machine.
    stalls
        Which share of the runs counts as stalled.
    text_of
        The machine file of one that ran.
    attributes
        What else was asked, and how those that ran were chosen.
    """
    # order: those that keep all limits first, then by how many and by how much they miss
    ranked = ordered(spec, [design for design in designs if design.numbers])
    place = {id(one): number for number, (one, _) in enumerate(ranked, start=1)}
    front = {id(one): level for one, level in ranked}
    labels = {id(one): label for one, label in zip(designs, _labels(designs), strict=True)}
    beyond = {id(one): misses(spec, one) if one.numbers else {} for one in designs}
    # what the runs gave: the share that the specification names, the median, shares with their intervals
    measured: list[tuple[str, str, str]] = []
    for name, (unit, text) in spec.run_limits.items():
        at_share = f"{text}; {100.0 * spec.share:g} % of the runs stay below"
        measured += [(name, at_share, unit), (f"{name}_median", f"{text}; median", unit)]
    over = "share of the runs with more than the limit"
    shares = {f"{name}_over": f"{over}: {text}" for name, (_, text) in spec.run_limits.items()}
    for name, text in {"stall": stalls, "balanced": "share of the runs that end balanced", **shares}.items():
        if any(name in design.numbers for design in designs):
            measured += [(name, text, "1"), *((f"{name}_{end}", f"{text}; {said}", "1") for end, said in ENDS.items())]
    on_front = "number of its Pareto front among designs that keep or miss as many limits, 0 for the first"
    kept = "1: keeps all limits in its runs; 0: too few runs to say; -1: does not"
    far = "how far it misses that, or limits on the runs added up, over what is allowed"
    columns: list[DesignColumn] = [
        ("label", lambda d: labels[id(d)], "what it is", ""),
        ("place", lambda d: float(place.get(id(d), np.nan)), "place among those that ran, 1 for the best", ""),
        ("front", lambda d: float(front.get(id(d), np.nan)), on_front, ""),
        ("meets", lambda d: float(meets(spec, d)) if d.numbers else -1.0, kept, ""),
        # by how much limits are missed, or why a candidate was not run
        ("misses", lambda d: float(len(beyond[id(d)])), "limits on the runs that it misses, their number", "1"),
        (
            "missed",
            lambda d: missed(spec, d) if d.numbers else d.stage,
            "limits that it misses, or what ruled it out",
            "",
        ),
        ("stage", lambda d: d.stage, f"what ruled it out: {', '.join(STAGES[:-1])}; {STAGES[-1]!r} if it ran", ""),
        ("reason", lambda d: d.reason, "why it was ruled out", ""),
        ("excess", lambda d: d.excess if d.reason else sum(beyond[id(d)].values()), far, "1"),
        *described,
        *OF_ALL,
        *((name, lambda d, name=name: d.numbers.get(name, np.nan), text, unit) for name, text, unit in measured),
        ("drag_warning", lambda d: d.drag_warning, "where its balls leave the range of their drag law", ""),
        ("passage", lambda d: d.passage, "where its passage is worse than without balls", ""),
        ("used", lambda d: used(spec, d) if d.numbers else np.nan, "greatest share of a limit that it uses up", "1"),
        ("machine", lambda d: text_of(d) if id(d) in place else "", "machine file", ""),
    ]
    data = {}
    for name, of, text, unit in columns:
        values = [of(design) for design in designs]
        kind = object if values and isinstance(values[0], str) else np.float64
        data[name] = ("design", np.array(values, dtype=kind), text, *filter(None, [unit]))
    numbered = {"design": ("design", np.arange(1, len(designs) + 1), "number of the candidate")}
    asked = {"limits": json.dumps(spec.limits), "objectives": list(spec.objectives), "share": spec.share}
    return Designed.of(labeled(data, numbered, {**provenance(), **asked, **attributes}))


def _labels(designs: Sequence[Design]) -> list[str]:
    """What each is, without what all have in common."""
    parts = [design.candidate.parts() for design in designs]
    for part, design in zip(parts, designs, strict=True):
        if design.twins:
            part["ring"] += f" (same race: {', '.join(design.twins)})"
    common = {
        key
        for one in parts[:1]
        for key in one
        if key not in ("count", "balls") and len({one.get(key) for one in parts}) == 1
    }
    return [", ".join(text for key, text in one.items() if key not in common) for one in parts]
