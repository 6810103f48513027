"""Designs as a table: those that ran, the best first, and what ruled the others out."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import parse_race_machine
from autobalancer.machine import Machine
from autobalancer.results.answers.answer import Answer
from autobalancer.results.display_units import axis_unit
from autobalancer.results.number_text import moment_text, significant
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
        cold, warm = (one - 273.15 for one in self.attrs["temperature_range"])
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
        """Whether any design keeps all limits, what the first one is, and whether its passage is worse than without balls."""
        best = self.best()
        passage = str(best["passage"].values[0]) if best.sizes["design"] and "passage" in best else ""
        return "; ".join(filter(None, (self._answer(best), passage)))

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
        found = self.best()
        measures = list(dict.fromkeys(("peak_deflection", "settling_time", *self._measured())))
        return [
            Column("place", [int(one) for one in found["place"].values]),
            Column("design", [str(one) for one in found["label"].values], wraps=True),
            Column("keeps limits", self._keeps(found)),
            *(self._scaled(found, name) for name in measures),
            Column("stall", [self._interval(found, "stall", i) for i in range(found.sizes["design"])], "%"),
            self._speed(found, "release", unit),
            self._speed(found, "border", unit),
            Column("ball mass", 1e3 * found["ball_mass"].values, "g", ".4g"),
            Column("front", [int(one) + 1 for one in found["front"].values]),
        ]

    def _keeps(self, found: xr.Dataset) -> list[str]:
        """Whether each design keeps all limits, or how many it misses."""
        pairs = zip(found["meets"].values.astype(int), found["misses"].values.astype(int), strict=True)
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
            "end with a stalled ball or rotor, with its 95 % interval"
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
        found = self.best()["drag_warning"].values.astype(str)
        there = np.flatnonzero(found != "")
        if not there.size:
            return []
        who = f"{there.size} of {found.size} designs leave the range of their drag law"
        return [f"{who}; of place {there[0] + 1}: {found[there[0]]}"]

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

    def _scaled(self, found: xr.Dataset, name: str) -> Column:
        sign, factor = SHOWN[found[name].attrs["units"]]
        values = [None if not np.isfinite(one) else factor * float(one) for one in found[name].values]
        return Column(name.replace("_", " "), ["never" if one is None else significant(one) for one in values], sign)

    def _speed(self, found: xr.Dataset, name: str, unit: str) -> Column:
        shown = axis_unit(found[name], unit or self.shown_in)
        return Column(name, shown.shown(found[name].values), shown.sign, ".4g")

    def _interval(self, found: xr.Dataset, name: str, row: int) -> str:
        share, low, high = (100.0 * float(found[f"{name}{end}"].values[row]) for end in ("", "_low", "_high"))
        return f"{share:.3g} ({low:.2g} to {high:.2g})"

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
    return machine.model_copy(update={"name": f"{machine.name}, {label}", "description": _said(designs, one, machine)})


def _said(designs: xr.Dataset, one: xr.Dataset, machine: Machine) -> str:
    fluid = str(one["fluid"].values)
    filled = f" Its races are filled with {fluid}{' (shares by mass)' if '%' in fluid else ''}." if fluid else ""
    limits = dict(Designed.of(designs).facts())["limits"]
    low, high = designs.attrs["unbalance_range"]
    cold, warm = (value - 273.15 for value in designs.attrs["temperature_range"])
    keeps = {
        1: "It keeps them",
        0: "Too few runs to say whether it keeps them",
        -1: f"It misses {_missed(one)}",
    }
    began = f" The machine that was given: {machine.description}" if machine.description else ""
    return (
        f"Place {int(one['place'])} of design {designs.attrs['design_name']!r} for unbalances of {moment_text(low)} to "
        f"{moment_text(high)}, {cold:.4g} to {warm:.4g} °C.{filled} Its numbers here are those at "
        f"{0.5 * (cold + warm):.4g} °C. Limits: {limits}. {keeps[int(one['meets'])]} in "
        f"{designs.attrs['members']} runs with the seed {designs.attrs['seed']}.{began}"
    )


def _missed(one: xr.Dataset) -> str:
    return ", ".join(name for name in str(one["missed"].values).split(", ") if not name.endswith(OPEN))
