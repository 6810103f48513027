"""What may be asked of a machine at any speed, as one table: what each question needs, how it is asked, and how it is drawn."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from functools import cached_property
from inspect import signature
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np

import autobalancer as ab
from autobalancer.app.store.jobs import Job
from autobalancer.assembly.drive_train import highest_prescribed
from autobalancer.assembly.quantities import parameter_range, parameter_unit, value_of
from autobalancer.errors import AutobalancerError, QuestionError, ResultError
from autobalancer.files.machine_file import parse_race_machine
from autobalancer.machine import Machine, PlanarRotor
from autobalancer.machine.path import QUANTITIES, si_unit_of, text_of
from autobalancer.machine_kinds import CHAMBERS, machine_kind
from autobalancer.progress import Progress
from autobalancer.results.display_units import length_text
from autobalancer.results.folder_store import read_note, write_note
from autobalancer.results.store import load_run, save_run
from autobalancer.tables import rpm_and_si
from autobalancer.units import argument, shortened
from autobalancer.units.quantity import ends, range_values

# What the forms of analyses need to know of a machine: its speeds, what may be varied, and what is not for it.


RPM = 30.0 / math.pi
UNITS = {"m^2/s": (1e6, "mm^2/s"), "kg": (1e3, "g"), "m": (1e3, "mm"), "kg*m": (1e6, "g*mm")}  # in which people write
EXCLUDED_QUANTITIES = ("count", "temperature")  # whole numbers, and what has no zero
DEEP = "is for balls in races; here they move freely in a deep chamber, which the pages Run and Archive are for"
GRAVITY = (
    "is for machines without gravity across the axis; with it balls never rest in the rotor. Run it, or take the basin"
)
NO_BALLS = "asks what balls do, and this machine has none"
NOT_COMMON = "needs a viscosity, a drag or another quantity that all races share, and this machine has none"
LIQUID = "does not know liquid with a free surface; take the liquid rings out of the machine"


@dataclass(frozen=True)
class Known:
    """Speeds in rpm, nan where there are none; of each quantity that may be varied its value and unit, as people write them."""

    machine: Machine
    low: float
    high: float
    speed: float  # the last that the drive prescribes
    critical: float  # the highest critical speed that a run passes
    quantities: dict[str, tuple[float, str]]
    balls: int

    def refusal(self, *, balls: bool, steady: bool, varied: bool) -> str:
        """Why a question is not for this machine, that asks about balls, about steady states, or over a quantity; else empty."""
        if self.machine.liquid_rings:
            return LIQUID
        if balls and not self.balls:
            return NO_BALLS
        if steady and self.machine.axis == "horizontal" and self.machine.gravity > 0.0:
            return GRAVITY
        return NOT_COMMON if varied and not self.quantities else ""


def known_of(machine: Machine) -> Known:
    """What is known of a machine without running or compiling anything.

    Speeds are from half the lowest critical speed to somewhat above the highest speed of the drive.
    """
    from autobalancer.stability.summary import frame_of

    highest = highest_prescribed(machine) or 0.0
    try:
        critical = [speed for speed in frame_of(machine, highest or None).critical_speeds if speed > 0.0]
    except AutobalancerError:  # the question itself says what is wrong
        critical = []
    lowest = min(critical, default=0.0)
    top = max(1.15 * highest, 1.6 * lowest)
    passed = max((speed for speed in critical if speed < (highest or top)), default=lowest)
    balls = sum(group.count for one in machine.balancers for race in one.races for group in race.balls)
    low = 0.5 * lowest if lowest else 0.02 * top
    last = value_of(machine, "speed")
    found = (low, top, last if last > 0.0 else math.nan, passed)
    speeds = [RPM * speed if speed > 0.0 else math.nan for speed in found]
    return Known(machine, speeds[0], speeds[1], speeds[2], speeds[3], varied(machine), balls)


def varied(machine: Machine) -> dict[str, tuple[float, str]]:
    """The quantities with one value above zero in this machine; viscosity and drag first."""
    found = {}
    for name in QUANTITIES:
        if name in EXCLUDED_QUANTITIES or (name == "unbalance" and not isinstance(machine.rotor, PlanarRotor)):
            continue
        try:
            value = value_of(machine, name)
        except (AutobalancerError, AttributeError):
            continue
        if value > 0.0:
            scale, unit = UNITS.get(si_unit_of(name), (1.0, si_unit_of(name)))
            found[name] = (scale * value, unit)
    return found


def no_analysis_reason(machine: object) -> str:
    """Why no analysis is for what is described; empty for a machine with balls in races."""
    if machine_kind(machine) is CHAMBERS:
        return DEEP
    return (
        ""
        if isinstance(machine, Machine)
        else "waits until the machine is possible; the page Describe says what is missing"
    )


# The questions of the page: ``read_...`` makes arguments of a public function of the texts of a form.
#
# A text that is not possible raises a QuestionError that begins with the name of its entry. What brings compiled
# equations is imported when it is asked for, so that the page opens at once.


Fields = Mapping[str, str]
MOST_POINTS, MOST_STARTS, MOST_SPEEDS, MOST_STEPS, MOST_MODES = 40_000, 5000, 5000, 1000, 40  # of one question here
NEAR = 2.0  # times the highest speed: modes above it say little about the machine


def _number(name: str, text: str, most: int) -> int:
    if not re.fullmatch(r"\s*[0-9]{1,9}\s*", text) or not 1 <= int(text) <= most:
        raise QuestionError(f"{name}: given {shortened(text)}; must be a whole number from 1 to {most}")
    return int(text)


def _values_within(name: str, text: str, unit: str, most: int = MOST_SPEEDS) -> Any:
    found = range_values(name, text, unit)
    if len(found) > most:
        raise QuestionError(f"{name}: given {len(found)} values; on this page at most {most}")
    return found


def _optional(name: str, given: Fields, unit: str) -> float | None:
    return argument(name, given[name], unit) if given.get(name, "").strip() else None


def _over(machine: Machine, given: Fields) -> Any:
    return parameter_range(machine, given["over"], given["values"], "values")


def read_map(machine: Machine, given: Fields) -> dict[str, Any]:
    """Speeds and values of the other quantity, not too many together."""
    speeds, values = _values_within("speed", given["speed"], "rad/s"), _over(machine, given)
    if speeds.size * values.size > MOST_POINTS:
        raise QuestionError(
            f"values: {speeds.size} speeds by {values.size} values are {speeds.size * values.size} points; on this page "
            f"at most {MOST_POINTS}"
        )
    if min(speeds.size, values.size) < 3:
        raise QuestionError("values: a map has at least three values along each axis")
    return {"axes": {"speed": speeds, given["over"]: values}, "borders": 31}


def read_borders(machine: Machine, given: Fields) -> dict[str, Any]:
    """A quantity and its values."""
    values = _over(machine, given)
    if len(values) > MOST_SPEEDS:
        raise QuestionError(f"values: given {len(values)}; on this page at most {MOST_SPEEDS}")
    return {"parameter": given["over"], "values": values}


def read_campbell(_machine: Machine, given: Fields) -> dict[str, Any]:
    """Speeds, and how many modes; none where those near the speeds are meant."""
    few = given["modes"].strip()
    return {
        "speeds": _values_within("speeds", given["speeds"], "rad/s"),
        "modes": _number("modes", few, MOST_MODES) if few else None,
    }


def campbell_near(machine: Machine, speeds: Any, modes: int | None) -> Any:
    """Natural frequencies over the speed, by default those near it."""
    return ab.rotor.campbell(machine, speeds, modes=modes or _modes_near(machine, speeds))


def _modes_near(machine: Machine, speeds: Any) -> int:
    """How many modes are slower than ``NEAR`` times the highest speed, at either end of the range; two at least."""
    top = float(np.max(speeds))
    ends = [
        ab.rotor.modes(machine, float(speed), modes=MOST_MODES)["frequency"].values for speed in (np.min(speeds), top)
    ]
    return max(2, *(int(np.sum(frequencies < NEAR * top)) for frequencies in ends))


def read_response(_machine: Machine, given: Fields) -> dict[str, Any]:
    """Speeds, and which quantity."""
    return {"speeds": _values_within("speeds", given["speeds"], "rad/s"), "quantity": given["quantity"], "smooth": True}


def read_stepped(machine: Machine, given: Fields) -> dict[str, Any]:
    """Speeds, times at each, and the way."""
    return {
        "speeds": _values_within("speeds", given["speeds"], "rad/s", MOST_STEPS),
        "dwell": argument("dwell", given["dwell"], "s"),
        "window": argument("window", given["window"], "s"),
        "direction": given["direction"],
        "keep_on_interrupt": True,  # one that is cancelled has those that were measured
    }


def read_branches(machine: Machine, given: Fields) -> dict[str, Any]:
    """A quantity with its range, and where to begin."""
    first, last = ends("range", given["range"], parameter_unit(machine, given["over"]))
    speed = None if given["over"] == "speed" else _optional("speed", given, "rad/s")
    return {"parameter": given["over"], "start": first, "end": last, "speed": speed, "from_state": given["from_state"]}


def branches_with_progress(machine: Machine, progress: Progress, **asked: Any) -> Any:
    """Branches; the share of the work is the number of the branch and its place in the range."""
    return ab.stability.branches(
        machine, **asked, progress=lambda number, share: progress(number + min(share, 0.99), 1.0)
    )


def read_basin(machine: Machine, given: Fields) -> dict[str, Any]:
    """A speed, and the starts."""
    asked: dict[str, Any] = {
        "speed": argument("speed", given["speed"], "rad/s"),
        "acceleration": _optional("acceleration", given, "rad/s^2"),
        "hold": _optional("hold", given, "s"),
    }
    if given["starts"] == "random":
        return {**asked, "random": _number("number", given["number"], MOST_STARTS)}
    count = _number("number", given["number"], int(math.sqrt(MOST_STARTS)))
    balls = sum(group.count for one in machine.balancers for race in one.races for group in race.balls)
    return {**asked, "axes": {f"ball_angle[{k + 1}]": f"-180:180 deg:{count + 1}" for k in range(min(balls, 2))}}


ANGLES = "angles of balls 1 and 2"
STATES = ("balanced", "all", "coincident", "in line", "mixed", "spread", "stalled", "partly stalled")


@dataclass(frozen=True)
class Entry:
    """One field of the form of a question; ``default`` may depend on what stands in the fields before it."""

    label: str
    help: str
    default: Callable[[Known, Fields], str]
    choices: Callable[[Known], Mapping[str, str]] | None = None
    wide: bool = False


@dataclass(frozen=True)
class Analysis:
    """A question. ``read`` turns the texts of its form into arguments of the function."""

    title: str
    about: str
    entries: Mapping[str, Entry]
    read: Callable[[Machine, Fields], dict[str, Any]]
    function: str | Callable[..., Any]  # what is asked: the name of a public function, or what asks it
    balls: bool = True  # whether it asks what balls do
    steady: bool = True  # whether it asks for states in which they rest
    varied: bool = False  # whether it needs a quantity that can be varied
    table: bool = False  # whether the page shows the table of the answer
    word: Callable[[float], str] = "{:.0%}".format  # how far it is

    def refusal(self, known: Known) -> str:
        """Why it is not for a machine; empty if it is."""
        return known.refusal(balls=self.balls, steady=self.steady, varied=self.varied)

    def ask(self, machine: Machine, asked: dict[str, Any], progress: Progress) -> Any:
        """Ask the function, which says how far it is if it can."""
        function = self.function if callable(self.function) else attrgetter(self.function)(ab)
        if hasattr(function, "shows_progress") or "progress" in signature(function).parameters:
            return function(machine, **asked, progress=progress)
        progress(0.0, 1.0)
        return function(machine, **asked)

    def wrong_entry(self, message: str) -> tuple[str, str]:
        """The entry that a message is about, and the rest of it; no entry where it names none."""
        name, colon, rest = message.partition(": ")
        return (name, rest) if colon and name in self.entries else ("", message)


def _span(known: Known, count: int) -> str:
    return f"{known.low:.4g}:{known.high:.4g} rpm:{count}" if known.high == known.high else ""


def _speeds(count: int) -> Entry:
    return Entry("rotor speeds", "from:to:count", _wide(count), wide=True)


def _quantities(known: Known) -> dict[str, str]:
    return {name: text_of(name) for name in known.quantities}


def _around(count: int, sides: float) -> Callable[[Known, Fields], str]:
    """A range about the value that the machine has."""

    def span(known: Known, given: Fields) -> str:
        if given.get("over") not in known.quantities:
            return ""
        value, unit = known.quantities[given["over"]]
        return f"{value / sides:.4g}:{value * sides:.4g} {unit}".strip() + f":{count}:log"

    return span


def _span_of_branches(known: Known, given: Fields) -> str:
    if given.get("over") == "speed":
        return f"{known.low:.4g}:{known.high:.4g} rpm" if known.high == known.high else ""
    if given.get("over") not in known.quantities:
        return ""
    value, unit = known.quantities[given["over"]]
    return f"{value:.4g}:{3.0 * value:.4g} {unit}".strip()


def _operating(known: Known, _given: Fields) -> str:
    speed = known.speed if known.speed == known.speed else known.high
    return f"{speed:.5g} rpm" if speed == speed else ""


def _is(text: str) -> Callable[[Known, Fields], str]:
    return lambda _known, _given: text


def _same(*words: str) -> Callable[[Known], Mapping[str, str]]:
    return lambda _known: {word: word for word in words}


def _first(known: Known, _given: Fields) -> str:
    return next(iter(known.quantities), "")


def _wide(count: int) -> Callable[[Known, Fields], str]:
    return lambda known, _: _span(known, count)


def _fewer(
    flat: int, other: int, span: Callable[[int], Callable[[Known, Fields], str]]
) -> Callable[[Known, Fields], str]:
    """More values for a planar rotor, whose eigenvalues are compiled, than for others."""
    return lambda known, given: span(flat if isinstance(known.machine.rotor, PlanarRotor) else other)(known, given)


OVER = Entry("over", "what is varied beside the speed", _first, _quantities, wide=True)
VALUES = "from:to:count, and :log for equal ratios"
MODES = "how many, the lowest ones; empty: those slower than twice the highest speed"
NUMBER_OF_STARTS = "of random starts; of ball angles how many of each ball"
ANALYSES: dict[str, Analysis] = {
    "map": Analysis(
        "Stability map",
        "Where the balanced state is stable: green. Move the point to see what another speed or oil does.",
        {
            "speed": Entry("rotor speeds", "from:to:count", _fewer(61, 31, _wide), wide=True),
            "over": OVER,
            "values": Entry("its values", VALUES, _fewer(41, 15, lambda n: _around(n, 10.0)), wide=True),
        },
        read_map,
        "stability.map",
        varied=True,
    ),
    "borders": Analysis(
        "Border speeds",
        "From which speed on the balanced state is stable, and where balls that stall are released, over any quantity.",
        {"over": OVER, "values": Entry("its values", VALUES, _fewer(61, 15, lambda n: _around(n, 10.0)), wide=True)},
        read_borders,
        "stability.border_curve",
        varied=True,
    ),
    "campbell": Analysis(
        "Campbell diagram",
        "Natural frequencies of the rotor over its speed, with the masses of the balls.",
        {"speeds": _speeds(81), "modes": Entry("modes", MODES, _is(""))},
        read_campbell,
        campbell_near,
        balls=False,
        steady=False,
    ),
    "response": Analysis(
        "Unbalance response",
        "Vibration by the unbalance alone: what there is without balls.",
        {
            "speeds": _speeds(301),
            "quantity": Entry(
                "quantity", "what is drawn", _is("displacement"), _same("displacement", "velocity", "acceleration")
            ),
        },
        read_response,
        "rotor.response",
        balls=False,
        steady=False,
    ),
    "stepped": Analysis(
        "Stepped response",
        "As on a test stand: hold a speed, let transients die, measure, go to the next. Balls move as in a run.",
        {
            "speeds": _speeds(25),
            "dwell": Entry("dwell", "time at a speed before it is measured", _is("5 s")),
            "window": Entry("window", "length of the measurement", _is("1 s")),
            "direction": Entry("direction", "up, down, or up and then down", _is("up"), _same("up", "down", "both")),
        },
        read_stepped,
        "stepped_response",
        balls=False,
        steady=False,
    ),
    "branches": Analysis(
        "Branches",
        "States in which balls rest, and motions that repeat, along a quantity: where they begin and lose stability.",
        {
            "over": Entry(
                "along",
                "what is varied",
                _is("speed"),
                lambda known: {"speed": "rotor speed", **_quantities(known)},
                wide=True,
            ),
            "range": Entry("range", "from:to, also downwards", _span_of_branches, wide=True),
            "from_state": Entry("begin with", "states where the range begins", _is("balanced"), _same(*STATES)),
            "speed": Entry("rotor speed", "where the speed itself is not varied", _operating),
        },
        read_branches,
        branches_with_progress,
        table=True,
        word=lambda share: f"branch {int(share)}, {share % 1.0:.0%} of the range",
    ),
    "basin": Analysis(
        "Basin",
        "Runs from many starts, and in how many of them the balls balance.",
        {
            "speed": Entry("rotor speed", "at which the runs end", _operating),
            "starts": Entry("starts", "how they are chosen", _is("random"), _same("random", ANGLES), wide=True),
            "number": Entry("number", NUMBER_OF_STARTS, _fewer(200, 40, lambda n: _is(str(n)))),
            "acceleration": Entry("run-up", 'from rest, such as "10 rad/s^2"; empty: starts at the speed', _is("")),
            "hold": Entry("hold", 'longest time at the speed, such as "30 s"; empty: as long as balls need', _is("")),
        },
        read_basin,
        "basin",
        steady=False,
        table=True,
    ),
}


def defaults(analysis: Analysis, known: Known, own: Fields | None = None) -> dict[str, str]:
    """The texts of a form, where it has none of its own."""
    found: dict[str, str] = {}
    for name, entry in analysis.entries.items():
        found[name] = (own or {}).get(name, "")
        if name not in (own or {}) or (entry.choices is not None and found[name] not in entry.choices(known)):
            found[name] = entry.default(known, found)
    return found


def answer_text(found: Any) -> Sequence[str]:
    """What is said of an answer in words."""
    lines = [text for name, text in found.facts() if name == "stability"]
    if hasattr(found, "branch_rows"):
        lines.append(f"{len(found.branch_rows())} branches with {len(found.special_rows())} special points")
    if "semi_major" in found:
        lines += [_greatest(found["semi_major"].sel(station=name), str(name)) for name in found["station"].values]
    return [*lines, *(text for text in found.remarks() if "special_rows()" not in text)]


def _greatest(values: Any, name: str) -> str:
    peak = int(values.values.argmax())
    size = float(values[peak])
    shown = length_text(size) if values.attrs["units"] == "m" else f"{size:.4g} {values.attrs['units']}"
    return f"{name}: greatest {shown} at {rpm_and_si(float(values['speed'][peak]))}"


# The latest answer of each analysis of a user, kept as a result file, so that it is there when the page is opened
# again.


@dataclass
class About:
    """Of which machine an answer is, and how it was asked."""

    name: str  # of the machine
    text: str  # of the machine
    given: dict[str, str]
    made: str
    seconds: float = 0.0
    notes: list[str] = field(default_factory=list)

    @cached_property
    def machine(self) -> Machine:
        """The machine itself."""
        return parse_race_machine(self.text)


class LatestAnswers:
    """Below the folder of a user, one answer for each analysis; a newer one takes its place."""

    def __init__(self, home: Path) -> None:
        self.folder = home / "stability"

    def ask(
        self, name: str, machine: Machine, text: str, asked: dict[str, Any], given: Mapping[str, str], job: Job
    ) -> str:
        """Work out an answer and keep it; what a cancelled job measured is kept, too. Gives the name of the analysis."""
        found = ANALYSES[name].ask(machine, asked, job.progress)
        about = About(machine.name, text, dict(given), f"{datetime.now(UTC):%Y-%m-%d %H:%M} UTC", notes=job.notes)
        save_run(found, self.path(name))
        write_note(self.folder / name, about)
        return name

    def about(self, name: str) -> About | None:
        """What is known of the latest answer; none if there is none."""
        try:
            found = read_note(self.folder / name, About)
            return found if self.path(name).is_file() else None
        except ResultError:
            return None

    def answer(self, name: str) -> Any:
        """The latest answer itself.

        Raises
        ------
        ResultError
            If it cannot be read.
        """
        return load_run(self.path(name))

    def path(self, name: str) -> Path:
        """The result file of an answer."""
        return self.folder / name / "answer.nc"
