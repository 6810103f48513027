"""Which balls and which fluid a deep chamber should have: closed forms, short runs, full runs of the few best."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import xarray as xr

from autobalancer.assembly.quantities import in_author_units
from autobalancer.errors import MachineError, Problem, QuestionError, one_of
from autobalancer.files.machine_file import balls_in_chambers, machine_text, parse_machine
from autobalancer.files.samples import beside
from autobalancer.files.text_files import built_of, question_data
from autobalancer.laws.deep_chamber import covering_fill
from autobalancer.machine import RunPlan
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.machine.keys import bare_numbers
from autobalancer.machine.part import Duration, ForceSize, Label, Length, Quantity, Question, key
from autobalancer.progress import shows_progress
from autobalancer.results.answers.answer import Labeled, provenance
from autobalancer.results.archive import Archive
from autobalancer.results.labels import labeled
from autobalancer.simulation.chamber.bounds import (
    ChamberBounds,
    bounds,
    fill,
    final_speed,
    one_group,
    pressure_between_balls,
)
from autobalancer.studies.chamber_study import Job, RunSettings, measured_runs
from autobalancer.studies.design.candidate import Design
from autobalancer.studies.design.designs import (
    NOT_RUN,
    STAGES,
    Designed,
    dataset_of,
    fronts,
    numbers_of_runs,
    placed,
    refuse_none,
)
from autobalancer.studies.design.specification import (
    MARGIN,
    MASS,
    STALL,
    Asked,
    Limits,
    Sizes,
    Whole,
    Wholes,
    measured_by,
)

# What may be asked: limits, and what there is to choose from.


Shares = Annotated[tuple[float, ...], Quantity("", non_negative=True, shape="values")]


class ChamberLimits(Limits):
    """What designs of a deep chamber must keep; what is not given is not limited."""

    synchronous: Length | None = key("the part of the vibration that turns with the rotor", None)
    bearing_force: ForceSize | None = key("greatest radial force of a bearing in steady state", None)
    contact_force: ForceSize | None = key("force of the hardest contact", None)
    stall_probability: Annotated[float, Quantity("", non_negative=True)] | None = key(
        "share of the runs in which a ball does not go around with the rotor; 0: none of them may", None
    )


class ChamberCandidates(Question):
    """What there is to choose from, all combinations of it; what is not given stays as in the machine."""

    balls: Wholes = key("numbers of balls", ())
    diameter: Sizes = key("of the balls", ())
    total_mass: Annotated[tuple[float, ...], Quantity("kg", positive=True, shape="values")] = key("of all balls", ())
    density: Annotated[tuple[float, ...], Quantity("kg/m^3", positive=True, shape="values")] = key("of the balls", ())
    friction: Shares = key("of all contacts", ())
    ball_friction: Shares = key("of balls on balls", ())
    viscosity: Annotated[tuple[float, ...], Quantity("Pa*s", non_negative=True, shape="values")] = key(
        "dynamic, of a fluid; 0 is a dry chamber", ()
    )
    fluid_density: Annotated[tuple[float, ...], Quantity("kg/m^3", positive=True, shape="values")] = key("of it", ())
    fill: Annotated[tuple[float, ...], Quantity("", non_negative=True, most=1.0, shape="values")] = key(
        "share of the chamber that it fills", ()
    )

    def contradictions(self) -> Iterator[Problem]:
        """Balls described twice, or a fluid described by half."""
        if self.diameter and self.total_mass:
            yield ("diameter",), "given with total_mass; give one of them, the other one follows"
        if (self.fluid_density or self.fill) and not self.viscosity:
            yield ("viscosity",), "missing; fluid_density and fill are of a fluid that has one"
        if any(self.viscosity) and not (self.fluid_density and self.fill):
            yield ("viscosity",), "a fluid with a viscosity needs fluid_density and fill"


RUN_LIMITS = measured_by(
    ChamberLimits,
    *("residual_vibration", "synchronous", "residual_unbalance", "settling_time", "peak_deflection", "bearing_force"),
    *("contact_force", "contact_pressure"),
)
MOST = 2000  # designs


class ChamberRuns(Question):
    """How long the runs of designs last, and how many there are. Balls may be carried up late."""

    duration: Duration = key("of a full run")
    short: Duration | None = key("of a short run; half of a full one unless given", None)
    last: Duration | None = key("time at the end that is the steady state; a tenth of a full run unless given", None)
    fillings: Whole = key("full runs of each design, with the seeds 0, 1, ...", 5)
    budget: Whole = key("designs that get full runs at most", 4)

    def contradictions(self) -> Iterator[Problem]:
        """What is longer than a full run."""
        for name in ("short", "last"):
            if (time := getattr(self, name)) is not None and time > self.duration:
                yield (name,), f"given {time:g} s; a full run lasts {self.duration:g} s only"


class ChamberSpecification(Question):
    """A machine with a deep chamber, for which unbalances it must work, and what there is to choose from."""

    machine: Any = key("machine file with one deep chamber and one group of balls, seen from this file", value="text")
    name: Label = key("of the design", "")
    unbalance: Annotated[tuple[float, ...], Quantity("kg*m", positive=True, shape="values")] = key(
        "sizes for which a design must work, the worst one counts; that of the machine unless given", ()
    )
    limits: ChamberLimits = key("what designs must keep", ChamberLimits(), default_text="–")
    candidates: ChamberCandidates = key("what there is to choose from", ChamberCandidates(), default_text="–")
    runs: ChamberRuns = key("how designs are run")


@dataclass(frozen=True)
class ChamberSpec(Asked):
    """What was asked, read and checked; SI."""

    name: str
    machine: ChamberMachine
    limits: dict[str, float]
    unbalances: tuple[float, ...]
    candidates: ChamberCandidates
    duration: float
    short: float
    last: float
    fillings: int
    budget: int
    remarks: tuple[str, ...] = ()
    archive: Archive | str | Path | None = None
    workers: int | None = None
    progress: Callable[[int, int], None] | None = None
    run_limits = RUN_LIMITS
    usual_share = 1.0  # of few fillings the worst one counts

    @property
    def objectives(self) -> tuple[str, str]:
        """Vibration at the end, and what the balls weigh."""
        return "residual_vibration", MASS


def read_chamber_spec(given: str | Path | Mapping[str, Any]) -> ChamberSpec:
    """A specification of a deep chamber from a file or a dict of the same form.

    Raises
    ------
    QuestionError
        With the file and the key at fault, what was given, and what is allowed.
    MachineFileError
        If its machine cannot be read.
    """
    data, source, folder, name = question_data(given, "specification", "")

    def build(options: Mapping[str, Any]) -> ChamberSpec:
        asked = ChamberSpecification(**options)
        machine = balls_in_chambers(
            beside(folder, asked.machine) if isinstance(asked.machine, (str, Path)) else asked.machine
        )
        limits = {key: float(value) for key, value in asked.limits if value is not None}
        if "contact_pressure" in limits and machine.contact.youngs_modulus is None:
            text = "needs the material of the balls; give contact.youngs_modulus"
            raise QuestionError(text, ("limits", "contact_pressure"))
        own, runs = float(abs(sum(part.vector for part in machine.unbalances))), asked.runs
        if not own > 0.0:
            text = "its rotor has no unbalance to balance; give it one, with its size here if you like"
            raise QuestionError(text, ("machine",))
        return ChamberSpec(
            asked.name or name or machine.name,
            machine,
            limits,
            tuple(sorted(set(map(float, asked.unbalance or (own,))))),
            asked.candidates,
            float(runs.duration),
            float(runs.short or 0.5 * runs.duration),
            float(runs.last or 0.1 * runs.duration),
            runs.fillings,
            runs.budget,
            bare_numbers(asked),
        )

    return built_of(build, data, source)


@shows_progress
def chamber_design(
    given: str | Path | Mapping[str, Any],
    *,
    folder: Archive | str | Path | None = None,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
    seen: Callable[[Designed], None] | None = None,
) -> Designed:
    """Find the balls, the friction and the fluid with which a deep chamber balances best, as :func:`autobalancer.design` says.

    Three stages. Closed forms rule out what cannot be good (:func:`bounds`). Short runs, of one filling at first, halve what is
    left again and again and double the fillings. Full runs with all fillings judge the few best, which are ranked.

    Returns
    -------
    xarray.Dataset
        Over ``design`` what is said of a candidate, with its bounds; over ``design``, ``unbalance`` and ``seed`` the numbers of
        every full run, ``<measure>_of_runs``.

    Raises
    ------
    QuestionError
        For a fault in the specification, or if closed forms rule out every design; the message says why.
    """
    spec = replace(read_chamber_spec(given), archive=folder, workers=workers, progress=progress)

    def candidates(_: Any) -> list[ChamberDesign]:
        designs = [screened(spec, candidate) for candidate in candidates_of(spec.machine, spec.candidates)]
        refuse_none(spec, designs)
        return designs

    designs = built_of(candidates, {}, str(given) if isinstance(given, (str, Path)) else "specification")
    found = _dataset(spec, designs, run_all(spec, designs))
    if seen is not None:
        seen(found)
    return found.assign_attrs({"specification_file": Path(given).name} if isinstance(given, (str, Path)) else {})


# One design of a deep chamber: balls, friction, fluid; and the machine with them.


@dataclass(frozen=True, order=True)
class Candidate:
    """Number of balls, their diameter (m) and density; friction, that of balls on balls; viscosity (Pa s) and density of a fluid,
    share that it fills.

    What is nan stays as the machine has it. With a viscosity of 0 the chamber is dry.
    """

    balls: int
    diameter: float
    density: float
    friction: float
    ball_friction: float = math.nan
    viscosity: float = math.nan
    fluid_density: float = 0.0
    fill: float = 0.0

    @property
    def total_mass(self) -> float:
        """Of the balls, kg."""
        return self.balls * self.density * math.pi / 6.0 * self.diameter**3

    @property
    def label(self) -> str:
        """``8 × 31.3 mm of 7800 kg/m³, friction 0.7``."""
        return ", ".join(filter(None, self.parts().values()))

    def parts(self) -> dict[str, str]:
        """The same piece by piece."""
        between = "" if math.isnan(self.ball_friction) else f" ({self.ball_friction:g} between balls)"
        return {
            "balls": f"{self.balls} × {1e3 * self.diameter:.3g} mm",
            "density": f"{self.density:g} kg/m³",
            "friction": f"friction {self.friction:g}{between}",
            "fluid": self.fluid,
        }

    @property
    def fluid(self) -> str:
        """``10 mPa s, 900 kg/m³, fills 0.6``; empty without one."""
        if not self.viscosity > 0.0:
            return ""
        return f"{1e3 * self.viscosity:.4g} mPa s, {self.fluid_density:g} kg/m³, fills {self.fill:g}"

    def run_name(self, unbalance: float, duration: float, last: float, seed: int) -> str:
        """Of a run in an archive: all on which its measures depend."""
        fluid = f"-v{self.viscosity:g}-d{self.fluid_density:g}-f{self.fill:g}" if self.viscosity >= 0.0 else ""
        between = "" if math.isnan(self.ball_friction) else f"-b{self.ball_friction:g}"
        name = f"n{self.balls}-{1e3 * self.diameter:.6g}mm-{self.density:g}-mu{self.friction:g}{between}{fluid}"
        return f"{name}-u{unbalance:g}-t{duration:g}-l{last:g}-s{seed}"


def candidates_of(machine: ChamberMachine, given: ChamberCandidates) -> list[Candidate]:
    """All combinations of what there is to choose from, each once, ascending; what is not given is as in the machine."""
    chamber, group = one_group(machine, "designs are")
    if chamber.depth is None:
        raise QuestionError("machine: its chamber has no depth, so it would change with the balls; give chambers.depth")
    if group.positions is not None:
        raise QuestionError("machine: its balls have positions; leave them out, so that other balls can be filled in")
    if given.viscosity and (chamber.drag > 0.0 or chamber.square_drag > 0.0):
        text = "the chamber of the machine has a drag already; leave out one of them"
        raise QuestionError(text, ("candidates", "viscosity"))
    dry = [(0.0, 0.0, 0.0)] if 0.0 in given.viscosity else []
    wet = product(filter(None, given.viscosity), given.fluid_density, given.fill)
    own, masses = float(machine.contact.friction), given.total_mass or (group.count * group.ball_mass,)
    entries = {}
    for count, heavy, rough, between, fluid in product(
        given.balls or (group.count,),
        given.density or (float(group.density),),
        given.friction or (own,),
        given.ball_friction or (math.nan,),
        [*dry, *wet] or [(math.nan, 0.0, 0.0)],
    ):
        volumes = (mass / heavy / count for mass in masses)
        for wide in given.diameter or [(6.0 * volume / math.pi) ** (1.0 / 3.0) for volume in volumes]:
            one = Candidate(int(count), *map(float, (wide, heavy, rough, between, *fluid)))
            entries[tuple(-1.0 if math.isnan(value) else value for value in vars(one).values())] = one
        if len(entries) > MOST:
            raise QuestionError(f"candidates: more than {MOST} designs, which is too many; take fewer values of each")
    return [entries[entry] for entry in sorted(entries)]


BLUNT = (
    0.44  # drag coefficient of a sphere at high Reynolds numbers (Newton; Clift, Grace and Weber 1978, below Re = 2e5)
)


def machine_of(machine: ChamberMachine, candidate: Candidate, unbalance: float | None = None) -> ChamberMachine:
    """The machine with these balls, friction and fluid, and with its unbalances in proportion up to ``unbalance`` (kg m).

    Raises
    ------
    MachineError
        If such balls do not go into the chamber.
    """
    data: dict[str, Any] = tomllib.loads(machine_text(machine))
    chamber = data["chambers"][0] if isinstance(data["chambers"], list) else data["chambers"]
    chamber["balls"] = [{"count": candidate.balls, "density": candidate.density, "diameter": candidate.diameter}]
    data["contact"]["friction"] = candidate.friction
    if not math.isnan(candidate.ball_friction):
        data["contact"]["ball_friction"] = candidate.ball_friction
    if not math.isnan(candidate.viscosity):
        # far from walls Stokes' force and Newton's are added: c_d = 24/Re + 0.44
        radius, wet = 0.5 * candidate.diameter, candidate.viscosity > 0.0
        chamber["drag"] = 6.0 * math.pi * candidate.viscosity * radius
        chamber["square_drag"] = 0.5 * BLUNT * candidate.fluid_density * math.pi * radius**2 * wet
        if chamber.get("viscosity") is not None and wet:
            chamber["viscosity"] = candidate.viscosity
    if unbalance is not None:
        factor = unbalance / abs(sum(part.vector for part in machine.unbalances))
        data["unbalances"] = [
            {"moment": part.size * factor, "angle": float(part.angle), "position": float(part.position)}
            for part in machine.unbalances
        ]
    return ChamberMachine(**data)


# What closed forms rule out: where and why, and by how much over what is allowed.


PUSHED = 2.0  # times its friction lifts a ball that others push; without shaking none was seen to be lifted by less
Miss = tuple[str, str, float]


@dataclass
class ChamberDesign(Design):
    """A candidate on its way: bounds and machines by unbalance, and what its runs are judged by, by unbalance and filling."""

    candidate: Any
    bounds: dict[float, ChamberBounds] = field(default_factory=dict)
    machines: dict[float, ChamberMachine] = field(default_factory=dict)
    short: dict[tuple[float, int], dict[str, float]] = field(default_factory=dict)
    full: dict[tuple[float, int], dict[str, float]] = field(default_factory=dict)

    @property
    def short_left(self) -> float:
        """Mean over the short runs of what turns with the rotor, over the vibration without balls, at the worst unbalance."""
        if not self.short:
            return math.nan
        left = [
            np.mean([row["synchronous"] for (case, _), row in self.short.items() if case == size])
            / own.vibration_without_balls
            for size, own in self.bounds.items()
        ]
        return float(max(left))

    def worst(self, name: str, of: Callable[[list[float]], float]) -> float:
        """A number of the bounds, of the unbalance at which it is worst."""
        return of([float(getattr(own, name)) for own in self.bounds.values()]) if self.bounds else math.nan


def screened(spec: ChamberSpec, candidate: Candidate) -> ChamberDesign:
    """A candidate after the closed forms; ``reason`` is empty if it stays."""
    design = ChamberDesign(candidate)
    try:
        for size in spec.unbalances:
            design.machines[size] = machine_of(spec.machine, candidate, size)
            design.bounds[size] = bounds(design.machines[size])
        fill(design.machines[spec.unbalances[0]])
    except MachineError as reason:
        design.rule_out("space", f"does not fit: {reason}")
        return design
    afloat = 1.0 - candidate.fluid_density / candidate.density  # of the weight of a ball
    design.capability = design.worst("capability", min) * (afloat if afloat > 0.0 else 1.0)
    design.margin = min(design.capability / size for size in spec.unbalances)
    design.ball_mass, design.pressure = candidate.total_mass, design.worst("race_pressure", max)
    misses = list(_of_the_fluid(spec.machine, candidate))
    needed, size = spec.capability_margin, spec.unbalances[-1]
    if design.margin < needed:
        text = f"the balls can balance {design.capability:.3g} of {size:.3g} kg m{' in the fluid' * (afloat < 1.0)}"
        misses.append(
            ("capability", text + f"; needed is {needed:g} times" * (needed > 1.0), needed / design.margin - 1.0)
        )
    for own in design.bounds.values():
        misses += ruled_out(own, spec.limits)
    if misses:
        design.rule_out(*min(misses, key=lambda miss: (STAGES.index(miss[0]), -miss[2])))
    return design


def _of_the_fluid(machine: ChamberMachine, candidate: Candidate) -> Iterator[Miss]:
    if not candidate.viscosity > 0.0:
        return
    chamber, given = machine.chambers[0], candidate.fill
    if candidate.fluid_density >= candidate.density:
        yield "fluid", "the balls float", candidate.fluid_density / candidate.density
    needed = covering_fill(float(chamber.radius), 0.5 * candidate.diameter)
    if given < needed:
        text = f"the fluid does not cover the balls at speed: it fills {given:.3g}, needed is {needed:.3g}"
        yield "fluid", text, needed / given - 1.0 if given else math.inf
    volume = math.pi * (float(chamber.radius) ** 2 - float(chamber.inner_radius) ** 2) * chamber.inner_depth
    share = candidate.total_mass / candidate.density / volume
    if given + share > 1.0:
        text = f"fluid ({given:.3g}) and balls ({share:.3g}) do not go into the chamber together"
        yield "fluid", text, given + share - 1.0


def ruled_out(bounds: ChamberBounds, limits: Mapping[str, float]) -> list[Miss]:
    """Why no run of a machine with these bounds can be good; empty if nothing speaks against it."""
    needed, speed = bounds.critical_speed * (1.0 + limits.get(MARGIN, 0.0)), bounds.speed
    if math.isnan(bounds.critical_speed):
        return [("border", "the body has no critical speed: the balls do not feel the unbalance", math.inf)]
    misses: list[Miss] = []
    if not bounds.run_up_time < math.inf or speed < needed:
        text = f"the speed stays below {'the critical speed of' if speed < bounds.critical_speed else ''} {needed:.4g} rad/s"
        misses.append(("border", text.replace("  ", " "), needed / speed - 1.0))
    # a row along the axis acts as one ball, whether the rotor shakes or not
    row, one = bounds.axial_rows == 1, f"one ball needs {bounds.least_friction:.3g}"
    if limits.get(STALL, 1.0) < 1.0 and bounds.friction * (1.0 if row else PUSHED) < bounds.least_friction:
        lacking = bounds.least_friction / bounds.friction - 1.0 if bounds.friction else math.inf
        if row:
            text = f"does not lift the balls, which lie in one row and act as one ball: {one}"
        else:
            text = f"lifts no ball of a calm rotor: {one}, and others that push do not halve that"
        if row or bounds.shaking < 1.0:
            misses.append(("pick-up", f"friction {bounds.friction:g} {text}", lacking))
    for name, least in (
        ("residual_vibration", bounds.least_vibration),
        ("synchronous", bounds.least_vibration),
        ("residual_unbalance", bounds.least_residual),
        ("settling_time", bounds.least_settling_time),
        ("bearing_force", bounds.least_bearing_force),
        ("contact_force", bounds.race_force),
        ("contact_pressure", bounds.race_pressure),
    ):
        if least > limits.get(name, math.inf):
            unit, stage = RUN_LIMITS[name][0], "pressure" if name == "contact_pressure" else "limits"
            text = f"{name.replace('_', ' ')} is at least {least:.3g} {unit}, the limit {limits[name]:.3g} {unit}"
            misses.append((stage, text, least / limits[name] - 1.0))
    return misses


# Fewer and fewer designs, with more and more runs of each: short runs of what closed forms left, then full runs.


HARDLY = 0.9  # of the vibration without balls: balls that leave more than that balance nothing
ALL_CARRIED = 1.0 - 1e-9
OF_A_RUN = {  # by the measures of which the greatest counts
    "residual_vibration": ("vertical_amplitude", "horizontal_amplitude"),
    "synchronous": ("vertical_synchronous", "horizontal_synchronous"),
    "residual_unbalance": ("residual_unbalance",),
    "settling_time": ("settling_time",),
    "peak_deflection": ("vertical_peak", "horizontal_peak"),
    "bearing_force": ("steady_bearing_1_greatest", "steady_bearing_2_greatest"),
    "contact_force": ("hardest_contact",),
}


def numbers_of(machine: ChamberMachine, measures: Mapping[str, Any]) -> dict[str, float]:
    """What a run of a machine is judged by, from its measures; infinite where one is not known, none of its balls carried."""
    known = {name: math.nan if value is None else float(value) for name, value in measures.items() if name != "outcome"}
    numbers = {name: float(np.max([known.get(one, math.nan) for one in of])) for name, of in OF_A_RUN.items()}
    numbers["contact_pressure"] = pressure_between_balls(machine, numbers["contact_force"])
    numbers = {name: math.inf if math.isnan(value) else value for name, value in numbers.items()}
    carried = known.get("share_carried", 0.0)
    return numbers | {"share_carried": carried, "stall": float(not carried >= ALL_CARRIED)}


def judged_runs(jobs: Sequence[Job], spec: Any, duration: float, told: Any = None) -> list[dict[str, float]]:
    """What runs are judged by; of one that did not finish nothing is known."""
    how = RunSettings(duration, min(spec.last, 0.5 * duration), spec.archive, spec.workers)
    rows = measured_runs(jobs, how, told)
    return [
        numbers_of(job.machine, row if row["outcome"] == "finished" else {})
        if isinstance(job.machine, ChamberMachine)
        else dict.fromkeys(RUN_LIMITS, math.inf) | {"share_carried": 0.0, "stall": 1.0}
        for job, row in zip(jobs, rows, strict=True)
    ]


def rounds(alive: int, budget: int, fillings: int) -> list[tuple[int, int]]:
    """Designs and fillings of each round of short runs: half of the designs and twice the fillings from round to round."""
    result, runs = [], 1
    while alive > budget:
        result.append((alive, runs))
        alive, runs = max(budget, math.ceil(alive / 2)), min(2 * runs, fillings)
    return result


def run_all(spec: ChamberSpec, designs: Sequence[ChamberDesign]) -> str:
    """Run what the closed forms left; the designs keep what was found. Says how those with full runs were chosen."""
    alive = [design for design in designs if not design.reason]
    ran, budget = len(alive), spec.budget
    plan = rounds(ran, budget, spec.fillings)
    # a filling is run once: a round adds to those of the round before it
    added = [count * (runs - before) for (count, runs), (_, before) in zip(plan, [(0, 0), *plan], strict=False)]
    total = len(spec.unbalances) * (sum(added) + min(budget, ran) * spec.fillings)
    done = 0

    def run(rows: str, duration: float, fillings: int) -> None:
        nonlocal done
        last, seeds = min(spec.last, 0.5 * duration), range(fillings)
        cases = product(spec.unbalances, seeds)
        keys = [(one, case) for one, case in product(alive, cases) if case not in getattr(one, rows)]
        jobs = [
            Job(one.candidate.run_name(size, duration, last, seed), one.machines[size], seed, {"unbalance": size})
            for one, (size, seed) in keys
        ]

        def told(now: int, _: int) -> None:
            if spec.progress is not None:
                spec.progress(done + now, total)

        for (one, case), row in zip(keys, judged_runs(jobs, spec, duration, told), strict=True):
            getattr(one, rows)[case] = row
        done += len(jobs)

    for number, (_, fillings) in enumerate(plan, 1):
        run("short", spec.short, fillings)
        keep = max(budget, math.ceil(len(alive) / 2))
        alive = _halved(
            alive, f"not run: the budget of {budget} designs was used up; round {number} of short runs", keep
        )
    run("full", spec.duration, spec.fillings)
    for one in alive:
        one.stage = STAGES[-1]
        by_unbalance = [[one.full[size, seed] for seed in range(spec.fillings)] for size in spec.unbalances]
        one.numbers |= numbers_of_runs(spec, [_columns(rows) for rows in by_unbalance])
    looked = (
        f"short runs of {ran} candidates, the better half of them again with twice the fillings, and so on; "
        * bool(plan)
    )
    return f"{looked}of the budget of {budget} designs {len(alive)} were run"


def _columns(rows: Sequence[Mapping[str, float]]) -> dict[str, Any]:
    """Numbers of runs by name, (runs,)."""
    columns = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    return columns | {"stall": columns["stall"] > 0.0}


def _halved(alive: Sequence[ChamberDesign], where: str, keep: int) -> list[ChamberDesign]:
    """The ``keep`` best by what turns with the rotor and the mass of the balls; the others stop here.

    Of those that balance nothing yet, the ones whose balls go around come first.
    """
    left = np.array([design.short_left for design in alive])
    mass = np.array([design.ball_mass for design in alive])
    hopeless = left > HARDLY
    front = fronts(np.where(hopeless, np.nan, left), mass)
    carried = [np.mean([row["share_carried"] for row in design.short.values()]) for design in alive]
    order = sorted(
        range(len(alive)), key=lambda i: (hopeless[i], -carried[i] * hopeless[i], front[i], left[i], mass[i])
    )
    for i in order[keep:]:
        text = f"{where} left {100.0 * left[i]:.3g} % of the vibration without balls, others were better"
        alive[i].rule_out(NOT_RUN, text, float(left[i]))
    return [alive[i] for i in sorted(order[:keep])]


# What became of each design, as the dataset that all searches have.


CHOSEN = (  # of a candidate
    ("balls", "number of balls", ""),
    ("diameter", "of a ball", "m"),
    ("density", "of the balls", "kg/m^3"),
    ("friction", "of all contacts", "1"),
    ("ball_friction", "of balls on balls", "1"),
    ("viscosity", "dynamic viscosity of the fluid", "Pa s"),
    ("fluid_density", "of the fluid", "kg/m^3"),
    ("fill", "share of the chamber that the fluid fills", "1"),
)
BOUNDED = (  # of the bounds, and which of those for several unbalances counts
    ("swung_residual", "kg m", max),
    ("held_residual", "kg m", max),
    ("vibration_without_balls", "m", max),
    ("least_friction", "1", max),
    ("drag_ratio", "1", min),
    ("shaking", "1", max),
    ("decay_rate", "1/s", min),
    ("least_settling_time", "s", max),
    ("race_force", "N", max),
    ("greatest_couple", "kg m^2", max),
    ("couple_bearing_force", "N", max),
)
STALLS = "share of the runs in which a ball does not go around with the rotor"


def _dataset(spec: ChamberSpec, designs: Sequence[ChamberDesign], how: str) -> Designed:
    """Everything that is known of the designs."""

    def text_of(design: ChamberDesign) -> str:
        machine = design.machines[spec.unbalances[-1]].model_copy(update={"run": RunPlan(duration=spec.duration)})
        return machine_text(in_author_units(machine, spec.machine, exact=True))

    described: list[tuple[str, Callable[[ChamberDesign], Any], str, str]] = [
        ("fluid", lambda one: one.candidate.fluid, "fluid of the chamber", ""),
        *((name, lambda one, name=name: getattr(one.candidate, name), text, unit) for name, text, unit in CHOSEN),
        *(
            (name, lambda one, name=name, of=of: one.worst(name, of), name.replace("_", " "), unit)
            for name, unit, of in BOUNDED
        ),
        (
            "short_left",
            lambda one: one.short_left,
            "what turns with the rotor in short runs, over that without balls",
            "1",
        ),
    ]
    few = 100.0 * (1.0 - 0.05 ** (1.0 / spec.fillings))  # if the share is p, all are better with (1 - p)^n
    attributes = {
        "title": f"Designs of {spec.machine.name}",
        "machine": machine_text(spec.machine),
        "machine_name": spec.machine.name,
        "design_name": spec.name,
        "remarks": list(spec.remarks),
        "unbalance_range": [spec.unbalances[0], spec.unbalances[-1]],
        "speeds": [final_speed(spec.machine)],
        "members": spec.fillings * len(spec.unbalances),
        "seed": 0,
        "searched_by": how,
        "duration": spec.duration,
        "short": spec.short,
        "last": spec.last,
        "few": f"fillings: {spec.fillings}; at most {few:.0f} % of all are worse than the worst one, with 95 % confidence",
        "assumed": " Assumed: friction and restitution as in this file; the drag of a fluid is that of balls far from walls, "
        "c_d = 24/Re + 0.44, and buoyancy is left out.",
    }
    dataset = dataset_of(spec, designs, described, STALLS, text_of, attributes)
    dataset = dataset.assign_coords(unbalance=list(spec.unbalances), seed=list(range(spec.fillings)))
    dataset["unbalance"].attrs["units"] = "kg m"
    return Designed.of(dataset.assign(_of_runs("design", [design.full for design in designs], dataset)))


def _of_runs(
    along: str, rows: Sequence[Mapping[tuple[float, int], Mapping[str, float]]], dataset: xr.Dataset
) -> xr.Dataset:
    """Numbers of every full run over ``along``, unbalance and seed; nan of those that did not run or are not known."""
    keys = list(product(dataset["unbalance"].values.tolist(), dataset["seed"].values.tolist()))
    shape = (len(rows), dataset.sizes["unbalance"], dataset.sizes["seed"])
    held = {}
    for name, (unit, text) in {**RUN_LIMITS, "share_carried": ("1", "share of the balls that go around")}.items():
        values = np.array([[row[key][name] if key in row else math.nan for key in keys] for row in rows], np.float64)
        known = np.where(np.isinf(values), np.nan, values).reshape(shape)
        held[f"{name}_of_runs"] = ((along, "unbalance", "seed"), known, f"{text}, of every run", unit)
    return labeled(held)


# How much a design depends on what is never exactly as assumed: unbalance, friction, sizes.


CHANGED = ("unbalance", "friction", "ball_friction", "diameter", "density", "viscosity")
AS_DESIGNED = "as designed"


@shows_progress
def design_sensitivity(
    designs: xr.Dataset,
    changes: Mapping[str, float],
    *,
    place: int = 1,
    archive: Archive | str | Path | None = None,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Run a design again with each of several quantities a little smaller and larger, with the same fillings.

    Parameters
    ----------
    designs
        From :func:`autobalancer.design` of a deep chamber.
    changes
        Shares by which ``unbalance``, ``friction``, ``diameter``, ``density`` or ``viscosity`` is changed, such as 0.2.
    place
        Of the design, 1 for the best.
    archive
        Folder of the search, whose runs of the design itself are not repeated.
    workers, progress
        As for :func:`autobalancer.design`.

    Returns
    -------
    xarray.Dataset
        Over ``change``, the first one none: the worst value and the median of what runs are judged by, and the share in which a
        ball does not go around; infinite where the balls do not fit.

    Raises
    ------
    QuestionError
        For an unknown quantity, a share that is not between 0 and 1, or a place that no design has.
    """
    one, size = placed(designs, place, "design_sensitivity"), float(designs["unbalance"].max())
    candidate = Candidate(int(one["balls"]), *(float(one[name]) for name, _, _ in CHOSEN[1:]))
    machine, seeds = balls_in_chambers(parse_machine(str(designs.attrs["machine"]))), range(designs.sizes["seed"])
    duration, last = float(designs.attrs["duration"]), float(designs.attrs["last"])
    spec = ChamberSpec(
        *("", machine, dict[str, float](), (size,), ChamberCandidates(), duration, duration, last, len(seeds), 1),
        archive=archive,
        workers=workers,
        progress=progress,
    )
    cases = [(AS_DESIGNED, candidate, size), *_cases(candidate, size, changes)]
    jobs = [
        Job(changed.run_name(unbalance, spec.duration, spec.last, seed), made, seed, {"unbalance": unbalance})
        for _, changed, unbalance in cases
        for made in [_machine(machine, changed, unbalance)]
        for seed in seeds
    ]
    rows = judged_runs(jobs, spec, spec.duration, progress)
    by_case = [_columns(rows[k : k + len(seeds)]) for k in range(0, len(rows), len(seeds))]
    numbers_by_case = [numbers_of_runs(spec, [columns]) for columns in by_case]
    numbers = {
        name + ending: ("change", np.array([found[name + ending] for found in numbers_by_case]), text + median, unit)
        for name, (unit, text) in {**RUN_LIMITS, "stall": ("1", STALLS)}.items()
        for ending, median in (("", ""), ("_median", "; median"))
        if name + ending in numbers_by_case[0]
    }
    title = f"{candidate.label}: what changes if something is not as designed"
    dataset = labeled(numbers, {"change": ("change", [name for name, _, _ in cases])})
    return Labeled.of(dataset.assign_attrs(title=title, **provenance(), machine_name=machine.name))


def _machine(machine: ChamberMachine, candidate: Candidate, unbalance: float) -> ChamberMachine | MachineError:
    try:
        return machine_of(machine, candidate, unbalance)
    except MachineError as reason:
        return reason


def _cases(candidate: Candidate, size: float, changes: Mapping[str, float]) -> list[tuple[str, Candidate, float]]:
    if not changes:
        raise QuestionError("changes: given none; give at least one, such as unbalance 0.2")
    cases = []
    for name, share in changes.items():
        one_of("changes", name, *CHANGED)
        if not 0.0 < share < 1.0:
            raise QuestionError(f"changes: {name}: given {share:g}; must be a share between 0 and 1")
        if name in ("viscosity", "ball_friction") and not getattr(candidate, name) > 0.0:
            raise QuestionError(f"changes: {name}: the design has none of its own")
        for sign in (-1.0, 1.0):
            factor, label = 1.0 + sign * share, f"{name} {100.0 * sign * share:+.3g} %"
            changed = (
                candidate if name == "unbalance" else replace(candidate, **{name: getattr(candidate, name) * factor})
            )
            cases.append((label, changed, size * factor if name == "unbalance" else size))
    return cases
