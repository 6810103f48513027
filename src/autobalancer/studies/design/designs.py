"""Designs as a table: those that ran, the best first, and what ruled the others out."""

from __future__ import annotations

import hashlib
import json
import math
from collections import Counter
from collections.abc import Callable, Collection, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.assembly.places import off_center, places_of
from autobalancer.assembly.quantities import with_value_at
from autobalancer.assembly.system import assemble
from autobalancer.catalog.product_tables import friction
from autobalancer.catalog.resolve import resolve
from autobalancer.errors import AutobalancerError, QuestionError
from autobalancer.files.machine_file import parse_race_machine
from autobalancer.machine import Machine
from autobalancer.results.answers.answer import Answer
from autobalancer.results.answers.studied import Studied
from autobalancer.results.display_units import axis_unit, length_text, moment_text, significant
from autobalancer.results.verdict import wilson_interval
from autobalancer.simulation.fluid_lag import diffusing_lags
from autobalancer.stability.friction import held_by_friction
from autobalancer.studies.chamber_candidates import fronts
from autobalancer.studies.design.candidate import Candidate, Design, driven, machine_of
from autobalancer.studies.design.specification import MASS, MEASURED, OUTER, STALL, Spec
from autobalancer.studies.study.chunk import AssembledMembers
from autobalancer.studies.study.study import study
from autobalancer.studies.study.study_file import read_study, vary
from autobalancer.tables import Column, rpm_and_si

SHOWN = {
    "m": ("mm", 1e3),
    "kg m": ("g mm", 1e6),
    "s": ("s", 1.0),
    "kg": ("g", 1e3),
    "Pa": ("MPa", 1e-6),
    "1": ("times", 1.0),
}
MEETS = {1: "yes", 0: "undecided", -1: "no"}
NEAREST = 3  # reasons of a question that are listed
MOST_PLACES = 8  # that are listed one by one
OPEN = " undecided"  # how a limit ends of which too few runs tell
USUAL = 1.5  # times the unbalance: with a smaller capability balls stand nearly side by side and react slowly
ORDINAL = {1.0: "st", 2.0: "nd", 3.0: "rd"}  # of percentiles above 20
SAME, NOT_RUN = "same race", "not run"
STAGES = ("space", "fluid", "capability", "pressure", SAME, "border", NOT_RUN, "runs")


class Designed(Answer):
    """Candidates over their numbers: what they are, where they were ruled out and why, what the runs left."""

    __slots__ = ()

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
        cold, warm = (attr - 273.15 for attr in self.attrs["temperature_range"])
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
            ("temperature", f"{cold:.4g} to {warm:.4g} °C" if cold < warm else f"{cold:.4g} °C"),
            (
                "limits",
                "; ".join(self._limit(name, value) for name, value in json.loads(self.attrs["limits"]).items())
                or "none",
            ),
            ("candidates", f"{self.sizes['design']}{said}; {ran} ran, {self.attrs['members']} times each"),
            ("searched", str(self.attrs["searched_by"])),
        ]

    def answer(self) -> str:
        """Whether any design keeps all limits; of the first one how many runs stall, and its passage beside held balls."""
        best = self.best()
        if not best.sizes["design"]:
            return self._answer(best)
        stall = f"stalled at the end: {self._interval(best, 'stall', 0)} % of its runs" * (
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
            return f"{kept} of {ran} designs keep{'s' * (kept == 1)} all limits; the best: {first}"
        names = [name for name in str(best["missed"].values[0]).split(", ") if name]
        if left := int((meets == 0).sum()):
            which = ", ".join(name.removesuffix(OPEN) for name in names)
            tell = f"for {left} of {ran} there are too few runs to tell"
            return f"no design is known to keep all limits: {tell}; the best: {first}, undecided by {which}"
        missed = [name for name in names if not name.endswith(OPEN)]
        texts = [f"{name} {self._beyond(best, name.replace(' ', '_'), limits)}" for name in missed]
        return f"no design keeps all limits; the nearest misses {len(missed)}: {', '.join(texts)}; it is {first}"

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
        measures = list(dict.fromkeys(("peak_deflection", "settling_time", *self._measured())))
        return [
            Column("place", [int(one) for one in best["place"].values]),
            Column("design", [str(one) for one in best["label"].values], wraps=True),
            Column("keeps limits", self._keeps(best)),
            *(self._scaled(best, name) for name in measures),
            Column("stall", [self._interval(best, "stall", i) for i in range(best.sizes["design"])], "%"),
            self._speed(best, "release", "release speed", unit),
            self._speed(best, "border", "exact border", unit),
            Column("ball mass", 1e3 * best["ball_mass"].values, "g", ".4g"),
            Column("front in its class", [int(one) + 1 for one in best["front"].values]),
        ]

    def _keeps(self, dataset: xr.Dataset) -> list[str]:
        """Whether each design keeps all limits, or how many it misses."""
        pairs = zip(dataset["meets"].values.astype(int), dataset["misses"].values.astype(int), strict=True)
        return [f"misses {count}" if meets < 0 and count else MEETS[meets] for meets, count in pairs]

    def remarks(self) -> Sequence[str]:
        """What the numbers mean, and examples of what was ruled out."""
        return [*self.meanings(), *(f"ruled out: {text}" for text in self.reasons())]

    def meanings(self) -> list[str]:
        """What the numbers mean."""
        share = 100.0 * float(self.attrs["share"])
        low, high = self.attrs["unbalance_range"]
        texts = [
            f"each value is the {share:g}{ORDINAL.get(share % 10.0, 'th')} percentile of the runs; stall: share of the runs that "
            "end with a stalled ball or rotor, with its 95 % interval",
            "front in its class: Pareto front of the two objectives among the designs that keep, or miss, as many limits",
        ]
        if low < high:
            texts += [
                f"the runs have unbalances of all sizes from {moment_text(low)} to {moment_text(high)}: rotors at either end of "
                "the range may do worse; narrow the range to judge them"
            ]
        texts += [*self._missed(), *self._hardly()]
        texts = [*self.attrs.get("remarks", []), *texts]
        texts += [f"measured rotor: {text}" for text in str(self.attrs.get("rotor_warnings", "")).split("\n") if text]
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
        """One row for each candidate, without the machine files."""
        return self.drop_vars("machine", errors="ignore")

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
        shown = axis_unit(dataset[name], unit or self.shown_in)
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


def designed_machine(designs: xr.Dataset, place: int = 1) -> Machine:
    """The machine of the design at a place, 1 for the best, that can be saved and run.

    Parameters
    ----------
    designs
        From :func:`design`.
    place
        In their order.

    Raises
    ------
    QuestionError
        If no design has this place.
    """
    if "place" not in designs or "machine" not in designs or "specification" not in designs.attrs:
        raise QuestionError("designed_machine: wants the answer of ab.design")
    there = designs["place"].values == place
    if not there.any():
        most = int((designs["place"].values > 0).sum())
        raise QuestionError(f"place: given {place}; the designs that ran have 1 to {most}")
    one = designs.isel(design=int(there.argmax()))
    machine = parse_race_machine(str(one["machine"].values))
    label = str(one["label"].values)
    return machine.model_copy(
        update={"name": f"{machine.name}, {label}", "description": _description(designs, one, machine)}
    )


def _description(designs: xr.Dataset, dataset: xr.Dataset, machine: Machine) -> str:
    fluid = str(dataset["fluid"].values)
    filled = f" Its races are filled with {fluid}{' (shares by mass)' if '%' in fluid else ''}." if fluid else ""
    limits = dict(Designed.of(designs).facts())["limits"]
    low, high = designs.attrs["unbalance_range"]
    cold, warm = (value - 273.15 for value in designs.attrs["temperature_range"])
    keeps = {
        1: "It keeps them",
        0: "Too few runs to say whether it keeps them",
        -1: f"It misses {_missed(dataset)}",
    }
    began = f" The machine that was given: {machine.description}" if machine.description else ""
    return (
        f"Place {int(dataset['place'])} of design {designs.attrs['design_name']!r} for unbalances of {moment_text(low)} to "
        f"{moment_text(high)}, {cold:.4g} to {warm:.4g} °C.{filled} Its numbers here are those at "
        f"{0.5 * (cold + warm):.4g} °C. Limits: {limits}. {keeps[int(dataset['meets'])]} in "
        f"{designs.attrs['members']} runs with the seed {designs.attrs['seed']}.{began}"
    )


def _missed(dataset: xr.Dataset) -> str:
    return ", ".join(name for name in str(dataset["missed"].values).split(", ") if not name.endswith(OPEN))


# Runs of a design with scatter: unbalance, temperature, starts and what else the specification lets vary.


TYPICAL = "bearing ring in a running balancer"  # of the catalog: the friction that is assumed to say what any would do
FRICTION = ("friction", "rolling_resistance", "adherence")  # in names of what may vary
STEPS = 101  # temperatures that stand for a range, where a fluid is no single one of the catalog
Report = Callable[[int, int], None] | None


class Case(NamedTuple):
    """Runs of one kind: to an operating speed, or there and back, which only the peak is asked of."""

    name: str
    found: Studied
    coasting: bool


def runs_of(
    spec: Spec,
    candidate: Candidate,
    folder: Path | None,
    workers: int | None,
    progress: Report,
    seed: int | None = None,
) -> list[Case]:
    """All runs that judge a candidate; finished ones are taken from the folder.

    Raises
    ------
    QuestionError
        If the scatter makes impossible machines.
    """
    machine = machine_of(spec, candidate, 0.5 * sum(spec.temperature), spec.unbalance[1])
    cases = [
        (f"{speed:.6g} rad/s", driven(spec, machine, speed, coasting=False), False) for speed in spec.operation.speeds
    ]
    if spec.operation.coast_down:
        cases.append(("coast-down", driven(spec, machine, spec.fastest, coasting=True), True))
    runs = []
    for name, described, coasting in cases:
        requested = study_of(spec, described, candidate, spec.search.seed if seed is None else seed)
        place = folder / name_of(spec, candidate, name) if folder is not None else None
        runs.append(Case(name, study(requested, folder=place, workers=workers, progress=progress), coasting))
    return runs


def judge_scatter(spec: Spec, design: Design) -> None:
    """Rule out a design of which the scatter makes no possible machine, as its runs would, before anything runs.

    Raises
    ------
    QuestionError
        With the key at fault, for a scatter or temperatures of the machine's own fluid that no design can have.
    """
    if spec.scatter and design.machine is not None:
        vary(design.machine, spec.scatter, "scatter")
    if design.machine is not None and not design.candidate.fluid:
        _temperatures(spec, design.machine, design.candidate)
    if not spec.scatter or design.machine is None:
        return
    machine = driven(spec, design.machine, spec.fastest, coasting=False)
    try:
        AssembledMembers(read_study(study_of(spec, machine, design.candidate, spec.search.seed)), 0, 1)
    except AutobalancerError as reason:
        text = str(reason).removeprefix("impossible: draw 1 made")
        design.rule_out(STAGES[-1], f"the scatter makes{text}" if text != str(reason) else f"cannot be run: {reason}")


def neglected_terms(spec: Spec, machine: Machine) -> str:
    """What the runs leave out of a machine that nobody said is ideal: eccentricity and friction, and what typical ones would do.

    They are no scatter by themselves, since coefficients of friction differ by thousands from race to race: a value that nobody
    gave would decide the order.
    """
    result = list[str]()
    if not any("eccentricity" in name for name in spec.scatter):
        away = off_center(
            places_of(machine, assemble(machine, lags=diffusing_lags(machine))), resolve(machine), spec.fastest
        )
        for plane in away.planes if away is not None else ():
            if not plane.given:
                left = f" and {moment_text(plane.residual)}" * math.isfinite(plane.residual)
                size = length_text(plane.eccentricity)
                result.append(
                    f"eccentricity of the race: {size}, as is typical, would leave a vibration of {size}{left}"
                )
                break
    races = [
        f"balancers[{b}].races[{r}]" for b, part in enumerate(machine.balancers, 1) for r, _ in enumerate(part.races, 1)
    ]
    named = any(word in name for name in spec.scatter for word in FRICTION)
    if not named and all(race.friction is None for balancer in machine.balancers for race in balancer.races):
        typical = next(one for one in friction() if one.name == TYPICAL)
        for race in races:
            rolling = {"adherence": typical.adherence, "rolling_resistance": typical.rolling_resistance}
            machine = with_value_at(machine, f"{race}.friction", rolling)
        held = max((plane.residual_95 for plane in held_by_friction(machine, spec.fastest).planes), default=0.0)
        result.append(
            f"friction: that of a {TYPICAL} (adherence {typical.adherence:g}) would leave up to {moment_text(held)} in 95 % of "
            "starts at this speed, that of others more"
        )
    return "; ".join([*result, "give them in the machine or in [scatter], 0 for none"]) if result else ""


def study_of(spec: Spec, machine: Machine, candidate: Candidate, seed: int) -> dict[str, Any]:
    """The study that runs a machine with the scatter of the specification, as a dict of the form of study files."""
    low, high = spec.unbalance
    vary: dict[str, Any] = {"unbalance": {"distribution": "uniform", "low": low, "high": high}} if low < high else {}
    vary |= _temperatures(spec, machine, candidate) | spec.scatter
    return {
        "machine": machine,
        "members": spec.search.members,
        "seed": seed,
        "tolerance": spec.search.tolerance,
        "impossible": "truncate",
        "settling_from": spec.search.settling_from,
        "vary": vary,
    }


def _temperatures(spec: Spec, machine: Machine, candidate: Candidate) -> dict[str, Any]:
    low, high = spec.temperature
    if low == high:
        return {}
    fluids = {race.fluid for balancer in machine.balancers for race in balancer.races}
    if all(fluid is not None and fluid.name is not None for fluid in fluids):
        return {"temperature": {"distribution": "uniform", "low": low, "high": high}}
    if len(candidate.fillings) != 1:
        which = candidate.fluid or "the fluid of the machine"
        raise QuestionError(
            f"temperature: given from {low - 273.15:.4g} to {high - 273.15:.4g} °C, which is known for fluids of the catalog "
            f"and for one blend in all races, not for {which}; give one temperature"
        )
    middles = low + (high - low) * (np.arange(STEPS) + 0.5) / STEPS
    values = [candidate.fillings[0].at(float(temperature))[1] for temperature in middles]
    return {"viscosity": {"distribution": "discrete", "values": values}}


def name_of(spec: Spec, candidate: Candidate, case: str) -> str:
    """The name of the folder of a design's runs: the same for the same design."""
    return hashlib.sha256(repr((candidate.key(), case)).encode()).hexdigest()[:16]


# Numbers of a design from its runs, and whether it keeps the limits: shares with their 95 % intervals (Wilson 1927).


FINISHED = "finished"
PEAK = "peak_deflection"
Flags = NDArray[np.bool_]
KEPT, UNDECIDED, MISSED = 1, 0, -1


def judge_runs(spec: Spec, design: Design, cases: Sequence[Case]) -> None:
    """Fill the numbers of a design.

    Of several cases the worst one counts. Of a measure: its value that the wanted share of the runs stays below, its median, the
    share of runs above the limit with its interval. of stall those of :func:`stalled`.
    """
    numbers = design.numbers
    for name in MEASURED:
        parts: list[dict[str, float]] = [
            _measure(spec, name, case) for case in cases if name == PEAK or not case.coasting
        ]
        numbers.update(max(parts, key=partial(_badness, name)))
    design.drag_warning = next(filter(None, (str(case.found.attrs.get("drag_warning", "")) for case in cases)), "")
    worst = max((case.found.attrs for case in cases), key=lambda told: np.nan_to_num(told.get("passage_ratio", 0.0)))
    design.passage = str(worst.get("passage_text", ""))
    ups = [case.found for case in cases if not case.coasting]
    numbers |= max((_share("stall", stalled(one)) for one in ups), key=lambda part: part["stall"])
    numbers |= min((_share("balanced", balanced(one)) for one in ups), key=lambda part: part["balanced"])


def _badness(name: str, part: dict[str, float]) -> tuple[float, float]:
    return part.get(f"{name}_over", 0.0), part[name]


def _measure(spec: Spec, name: str, case: Case) -> dict[str, float]:
    values = values_of(case.found, name)
    measure = {name: _level(values, spec.share), f"{name}_median": _level(values, 0.5)}
    limit = spec.limits.get(name)
    return measure if limit is None else measure | _share(f"{name}_over", ~(values <= limit))


def values_of(studied: Studied, name: str) -> NDArray[np.float64]:
    """A measure of all runs; infinite where a run did not end or has no such number, as a ball that never settles."""
    values = (
        np.asarray(studied[name].values, np.float64) if name in studied else np.full(studied.sizes["member"], np.nan)
    )
    return np.where(np.isfinite(values) & (studied["outcome"].values == FINISHED), values, math.inf)


def _level(values: NDArray[np.float64], share: float) -> float:
    """The value that at least this share of the runs does not exceed."""
    ordered = np.sort(values)
    return float(ordered[min(math.ceil(share * ordered.size) - 1, ordered.size - 1)])


def stalled(studied: Studied) -> Flags:
    """Which runs end stalled, or do not end."""
    return np.asarray(studied["stalled"].values.astype(bool) | (studied["outcome"].values != FINISHED))


def balanced(studied: Studied) -> Flags:
    """Which runs end balanced."""
    return np.asarray(studied["balanced"].values.astype(bool) & (studied["outcome"].values == FINISHED))


def _share(name: str, which: Flags) -> dict[str, float]:
    count, total = int(which.sum()), int(which.size)
    low, high = wilson_interval(np.array([count]), total)
    return {name: count / total, f"{name}_low": float(low[0]), f"{name}_high": float(high[0])}


def verdicts(spec: Spec, design: Design) -> dict[str, int]:
    """Each limit on the runs: kept, missed, or open because so few runs cannot tell."""
    shares = {name: (f"{name}_over", 1.0 - spec.share) for name in MEASURED if name in spec.limits}
    if STALL in spec.limits:
        shares[STALL] = ("stall", spec.limits[STALL])
    return {limit: _verdict(design.numbers, share, allowed) for limit, (share, allowed) in shares.items()}


def _verdict(numbers: dict[str, float], share: str, allowed: float) -> int:
    if numbers[f"{share}_high"] <= allowed:
        return KEPT
    return MISSED if numbers[f"{share}_low"] > allowed else UNDECIDED


# The order of the designs that ran: limits, how many are missed and by how much, then the Pareto front.


def objective(design: Design, name: str) -> float:
    """A number of a design that should be small."""
    if name == MASS:
        return design.ball_mass
    return design.candidate.ring.outer if name == OUTER else design.numbers.get(name, math.nan)


def meets(spec: Spec, design: Design) -> int:
    """1: keeps all limits; 0: too few runs to say; -1: misses one."""
    return min(verdicts(spec, design).values(), default=1)


def missed(spec: Spec, design: Design) -> str:
    """The limits that it misses, and those of which too few runs say nothing."""
    found_of = verdicts(spec, design)
    texts = [name.replace("_", " ") for name, one in found_of.items() if one == MISSED]
    return ", ".join(
        texts + [f"{name.replace('_', ' ')} undecided" for name, one in found_of.items() if one == UNDECIDED]
    )


def misses(spec: Spec, design: Design) -> dict[str, float]:
    """The limits that it misses, each with how far it is beyond it, over the limit."""
    beyond = {name: one for name, one in verdicts(spec, design).items() if one == MISSED}
    return {name: design.numbers["stall" if name == STALL else name] / spec.limits[name] - 1.0 for name in beyond}


def _added_up(beyond: Collection[float]) -> tuple[int, float]:
    """How many have no end, as a settling time of balls that never settle, and the sum of the others."""
    finite = [one for one in beyond if math.isfinite(one)]
    return len(beyond) - len(finite), sum(finite)


def used(spec: Spec, design: Design) -> float:
    """The greatest share of a limit that it uses up; 0 without limits on the runs."""
    shares = [design.numbers[name] / spec.limits[name] for name in MEASURED if name in spec.limits]
    if STALL in spec.limits:
        shares.append(design.numbers["stall"] / spec.limits[STALL])
    return max(shares, default=0.0)


def ordered(spec: Spec, ran: Sequence[Design]) -> list[tuple[Design, int]]:
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
        values = np.array([[objective(one, name) for name in spec.search.objectives] for one in group])
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
