"""How much a design depends on what is never exactly as assumed: unbalance, friction, sizes."""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.stats import beta, t

from autobalancer.assembly.quantities import in_author_units
from autobalancer.errors import MachineError, QuestionError
from autobalancer.files.machine_file import machine_text, of_kind, parse_machine
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.machine_kinds import CHAMBERS
from autobalancer.progress import shows_progress
from autobalancer.results.answers.answer import Labeled
from autobalancer.results.archive import Archive
from autobalancer.results.provenance import provenance
from autobalancer.simulation.chamber.bounds import ChamberBounds, pressure_between_balls
from autobalancer.studies.chamber_study import Job, RunSettings, measured_runs
from autobalancer.units.quantity import is_range, list_argument, listed, whole_numbers

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
        From :func:`design`.
    changes
        Shares by which ``unbalance``, ``friction``, ``diameter``, ``density`` or ``viscosity`` is changed, such as 0.2.
    place
        Of the design, 1 for the best.
    archive
        That of the search, whose runs of the design itself are not repeated.
    workers, progress
        As for :func:`design`.

    Returns
    -------
    xarray.Dataset
        Over ``change``, the first one none: mean vibration with its interval (m), worst values and pick-up; over ``change``
        and ``seed`` the numbers of every run. nan where the balls do not fit.

    Raises
    ------
    QuestionError
        For an unknown quantity, a share that is not between 0 and 1, or a place that no design has.
    """
    one, machine = _placed(designs, place, "design_sensitivity")
    candidate, size = candidate_of(one), float(designs["unbalance"].max())
    cases = [(AS_DESIGNED, candidate, size), *_cases(candidate, size, changes)]
    duration, last = float(designs.attrs["duration"]), float(designs.attrs["last"])
    seeds = [int(seed) for seed in designs["seed"].values]

    jobs = []
    for _, changed, unbalance in cases:
        made = _machine(machine, changed, unbalance)
        names = [changed.run_name(unbalance, duration, last, seed) for seed in seeds]
        jobs += [Job(name, made, seed, {"unbalance": unbalance}) for name, seed in zip(names, seeds, strict=True)]
    judged = judged_runs(jobs, RunSettings(duration, last, archive, workers), progress)
    rows = np.array(judged, object).reshape(len(cases), len(seeds))
    dataset = xr.Dataset(coords={"change": [name for name, _, _ in cases], "seed": seeds})
    values = {name: np.array([[row.get(name, np.nan) for row in several] for several in rows]) for name in JUDGED}
    means = np.array([mean_interval(several) for several in values["vibration"]])
    for k, name in enumerate(("vibration_mean", "vibration_low", "vibration_high")):
        dataset[name] = ("change", means[:, k], {"units": "m"})
    for name in ("vibration", "synchronous", "settling_time"):
        dataset[f"worst_{name}"] = ("change", values[name].max(axis=1), {"units": JUDGED[name].unit})
    carried = [share_interval(int((shares >= 1.0 - 1e-9).sum()), len(seeds))[0] for shares in values["share_carried"]]
    dataset["pick_up"] = ("change", np.array(carried), {"units": "1"})
    for name, entry in JUDGED.items():
        dataset[name] = (("change", "seed"), values[name], {"units": entry.unit, "long_name": entry.text})
    title = f"{candidate.label}: what changes if something is not as designed"
    dataset.attrs = {"title": title, **provenance(), "machine_name": machine.name}
    return Labeled.of(dataset)


def _machine(machine: ChamberMachine, candidate: Candidate, unbalance: float) -> ChamberMachine | MachineError:
    try:
        return machine_of(machine, candidate, unbalance)
    except MachineError as reason:
        return reason


def refuse_changes(changes: Mapping[str, float]) -> None:
    """Refuse quantities that no design has, and shares that are none.

    Raises
    ------
    QuestionError
        With what is allowed.
    """
    for name, share in changes.items():
        if name not in CHANGED:
            raise QuestionError(f"changes: given {name!r}; must be one of {', '.join(CHANGED)}")
        if not 0.0 < share < 1.0:
            raise QuestionError(f"changes: {name}: given {share:g}; must be a share between 0 and 1")


def _cases(candidate: Candidate, size: float, changes: Mapping[str, float]) -> list[tuple[str, Candidate, float]]:
    if not changes:
        raise QuestionError("changes: given none; give at least one, such as unbalance 0.2")
    refuse_changes(changes)
    cases = []
    for name, share in changes.items():
        if name in ("viscosity", "ball_friction") and not getattr(candidate, name) > 0.0:
            raise QuestionError(f"changes: {name}: the design has none of its own")
        for sign in (-1.0, 1.0):
            factor, label = 1.0 + sign * share, f"{name} {100.0 * sign * share:+.3g} %"
            changed = (
                candidate if name == "unbalance" else replace(candidate, **{name: getattr(candidate, name) * factor})
            )
            cases.append((label, changed, size * factor if name == "unbalance" else size))
    return cases


# The machine of a design, with what was assumed written into its description.


NUMBERS = ("diameter", "density", "friction", "ball_friction", "viscosity", "fluid_density", "fill")


def designed_machine(designs: xr.Dataset, place: int = 1, *, unbalance: float | None = None) -> ChamberMachine:
    """The machine of the design at a place, 1 for the best, that can be saved and run.

    Parameters
    ----------
    designs
        From :func:`design`.
    place
        In their order.
    unbalance
        kg m; by default the greatest for which they were made.

    Raises
    ------
    QuestionError
        If no design has this place.
    """
    one, machine = _placed(designs, place, "designed_machine")
    candidate = candidate_of(one)
    size = float(designs["unbalance"].max()) if unbalance is None else unbalance
    made = in_author_units(machine_of(machine, candidate, size), machine)
    return made.model_copy(
        update={"name": f"{machine.name}, {candidate.label}", "description": _description(designs, one, candidate)}
    )


def _placed(designs: xr.Dataset, place: int, name: str) -> tuple[xr.Dataset, ChamberMachine]:
    """The design at a place, and the machine that the designs were made from."""
    if "place" not in designs or "machine" not in designs.attrs:
        raise QuestionError(f"{name}: wants the answer of chamber.design")
    there = designs["place"].values == place
    if not there.any():
        raise QuestionError(f"place: given {place}; the designs have 1 to {int(designs['place'].max())}")
    machine: ChamberMachine = of_kind(parse_machine(str(designs.attrs["machine"])), CHAMBERS, name)
    return designs.isel(design=int(there.argmax())), machine


def candidate_of(dataset: xr.Dataset) -> Candidate:
    """The candidate of one design of the answer."""
    return Candidate(int(dataset["balls"]), *(float(dataset[name]) for name in NUMBERS))


def _description(designs: xr.Dataset, dataset: xr.Dataset, candidate: Candidate) -> str:
    limits = json.loads(designs.attrs["limits"])
    requested = ", ".join(f"{name} {value:g}" for name, value in limits.items()) or "none"
    sizes = ", ".join(f"{size:g}" for size in designs["unbalance"].values)
    meets = "It meets them." if int(dataset["meets"]) else f"It misses {str(dataset['missed'].values) or 'them'}."
    fluid = ""
    if candidate.viscosity > 0.0:
        fluid = (
            f" Fluid of {candidate.viscosity:g} Pa s and {candidate.fluid_density:g} kg/m^3 that fills {candidate.fill:g} of the "
            f"chamber, its drag that of balls far from walls, c_d = 24/Re + 0.44; buoyancy is left out."
        )
    worst = float(dataset["worst_vibration"])
    text = f"Worst vibration {worst:.3g} m" if not math.isnan(worst) else "Worst vibration not known"
    return (
        f"Design {int(dataset['place'])} of {designs.sizes['design']} for unbalances of {sizes} kg m. Limits (SI): "
        f"{requested}. {meets} "
        f"{text} in {designs.sizes['seed']} fillings of {designs.attrs['duration']:g} s. Assumed: a friction of "
        f"{candidate.friction:g}, restitution and rolling resistance of the machine it was made from.{fluid}"
    )


# One design of a deep chamber: balls, friction, fluid; and the machine with them.


UNITS = {
    "balls": "",
    "diameter": "m",
    "total_mass": "kg",
    "density": "kg/m^3",
    "friction": "",
    "ball_friction": "",
    "viscosity": "Pa*s",
    "fluid_density": "kg/m^3",
    "fill": "",
}
MOST = 2000  # designs


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
        """``8 × 31.3 mm, friction 0.7``."""
        fluid = f", {1e3 * self.viscosity:.4g} mPa s" if self.viscosity > 0.0 else ""
        between = "" if math.isnan(self.ball_friction) else f" ({self.ball_friction:g} between balls)"
        return f"{self.balls} × {1e3 * self.diameter:.3g} mm, friction {self.friction:g}{between}{fluid}"

    def run_name(self, unbalance: float, duration: float, last: float, seed: int) -> str:
        """Of a run in an archive: all on which its measures depend."""
        return f"{self.name}-u{unbalance:g}-t{duration:g}-l{last:g}-s{seed}"

    @property
    def name(self) -> str:
        """The first part of the names of its runs in an archive."""
        fluid = f"-v{self.viscosity:g}-d{self.fluid_density:g}-f{self.fill:g}" if self.viscosity >= 0.0 else ""
        between = "" if math.isnan(self.ball_friction) else f"-b{self.ball_friction:g}"
        return f"n{self.balls}-{1e3 * self.diameter:.6g}mm-{self.density:g}-mu{self.friction:g}{between}{fluid}"


def candidates(machine: ChamberMachine, shelf: Mapping[str, Any]) -> list[Candidate]:
    """All combinations of what there is to choose from, each once, ascending; what is not on the shelf is as in the machine."""
    if len(machine.chambers) != 1 or len(machine.chambers[0].balls) != 1:
        raise QuestionError(
            "machine: has several chambers or groups of balls; a design is of one chamber with equal balls"
        )
    group, chamber = machine.chambers[0].balls[0], machine.chambers[0]
    if group.body != "ball":
        raise QuestionError(
            "machine: its chamber has cylinders; designs are compared for balls only; simulate runs cylinders"
        )
    if chamber.depth is None:
        raise QuestionError("machine: its chamber has no depth, so it would change with the balls; give chambers.depth")
    if group.positions is not None:
        raise QuestionError("machine: its balls have positions; leave them out, so that other balls can be filled in")
    values = _read(shelf)
    balls = [int(value) for value in values.pop("balls", [group.count])]
    density = values.pop("density", [float(group.density)])
    friction = values.pop("friction", [float(machine.contact.friction)])
    between = values.pop("ball_friction", [math.nan])
    fluids = _fluids(values, chamber.drag > 0.0 or chamber.square_drag > 0.0)
    sizes = values if values else {"total_mass": [group.count * group.ball_mass]}
    entries: dict[tuple[float | None, ...], None] = {}
    for count, heavy, rough, own, fluid in product(balls, density, friction, between, fluids):
        for kind, several in sizes.items():
            for size in several:
                wide = size if kind == "diameter" else (6.0 * size / (math.pi * heavy * count)) ** (1.0 / 3.0)
                entries[
                    tuple(None if math.isnan(value) else value for value in (count, wide, heavy, rough, own, *fluid))
                ] = None
    if len(entries) > MOST:
        raise QuestionError(
            f"candidates: {len(entries)} designs; at most {MOST} are possible. Take fewer values of each"
        )
    ordered = sorted(entries, key=lambda entry: tuple(-1.0 if value is None else value for value in entry))
    plain = [[math.nan if value is None else value for value in entry] for entry in ordered]
    return [Candidate(int(entry[0]), *entry[1:]) for entry in plain]


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
    balls = {"count": candidate.balls, "density": candidate.density, "diameter": candidate.diameter}
    chamber["balls"] = [balls]
    data["contact"]["friction"] = candidate.friction
    if not math.isnan(candidate.ball_friction):
        data["contact"]["ball_friction"] = candidate.ball_friction
    if not math.isnan(candidate.viscosity):
        drag = _free_drag(candidate.viscosity, candidate.fluid_density, 0.5 * candidate.diameter)
        chamber["drag"], chamber["square_drag"] = drag if candidate.viscosity > 0.0 else (0.0, 0.0)
        if chamber.get("viscosity") is not None and candidate.viscosity > 0.0:
            chamber["viscosity"] = candidate.viscosity
    if unbalance is not None:
        factor = unbalance / abs(sum(part.vector for part in machine.unbalances))
        data["unbalances"] = [
            {"moment": part.size * factor, "angle": float(part.angle), "position": float(part.position)}
            for part in machine.unbalances
        ]
    return ChamberMachine(**data)


def _free_drag(viscosity: float, density: float, ball_radius: float) -> tuple[float, float]:
    """Force on a ball over its speed (N s/m) and over the square of it (N s^2/m^2), far from walls.

    ``viscosity`` is dynamic, Pa s; ``density`` that of the fluid. Stokes' force and Newton's are added: c_d = 24/Re + 0.44.
    """
    return 6.0 * math.pi * viscosity * ball_radius, 0.5 * BLUNT * density * math.pi * ball_radius**2


def _read(shelf: Mapping[str, Any]) -> dict[str, list[float]]:
    values = {}
    for name, given in shelf.items():
        if name not in UNITS:
            raise QuestionError(f"candidates: given {name!r}; must be one of {', '.join(UNITS)}")
        if name == "balls":
            given = whole_numbers("balls", given) if isinstance(given, str) and not is_range(given) else given
            read = [float(value) for value in list_argument("balls", given, "")]
            if any(value != round(value) or value < 1.0 for value in read):
                raise QuestionError(f"balls: given {given!r}; must be whole numbers from 1 on")
        else:
            listing = isinstance(given, str) and "," in given
            read = listed(name, given, UNITS[name]) if listing else list_argument(name, given, UNITS[name])
        if not read:
            raise QuestionError(f"{name}: given none; give at least one, or leave it out")
        low = 0.0 if name in ("friction", "ball_friction", "viscosity", "fill", "fluid_density") else math.ulp(0.0)
        if any(not value >= low or math.isinf(value) for value in read):
            raise QuestionError(
                f"{name}: given {min(read):g}; must be {'above' if low else 'at least'} zero, and finite"
            )
        values[name] = [float(value) for value in read]  # however it was written, the machine is the same
    if "diameter" in values and "total_mass" in values:
        raise QuestionError("candidates: given diameter and total_mass; give one of them, the other one follows")
    if any(value > 1.0 for value in values.get("fill", ())):
        raise QuestionError(f"fill: given {max(values['fill']):g}; the share that the fluid fills is at most 1")
    return values


def _fluids(values: dict[str, list[float]], has_drag: bool) -> Sequence[tuple[float, float, float]]:
    """Viscosity, density and fill of each fluid; those of a dry chamber are zero."""
    viscosity = values.pop("viscosity", None)
    density, fill = values.pop("fluid_density", None), values.pop("fill", None)
    if viscosity is None:
        if density is not None or fill is not None:
            raise QuestionError("viscosity: missing; fluid_density and fill are of a fluid that has one")
        return [(math.nan, 0.0, 0.0)]
    if has_drag:
        raise QuestionError("viscosity: the chamber of the machine has a drag already; leave out one of them")
    wet = [value for value in viscosity if value > 0.0]
    if wet and (density is None or fill is None):
        raise QuestionError("fluid_density, fill: missing; a fluid with a viscosity needs both")
    dry = [(0.0, 0.0, 0.0)] if len(wet) < len(viscosity) else []
    return [*dry, *product(wet, density or (), fill or ())]


# What a design is judged by: numbers of a run, and limits to them.


PUSHED = 2.0  # times its friction lifts a ball that others push; without shaking none was seen to be lifted by less


class Judged(NamedTuple):
    """A number of a run: its unit, its meaning, and how it follows from the measures of the run."""

    unit: str
    text: str
    of: Callable[[Mapping[str, Any]], float]


def _greater(*names: str) -> Callable[[Mapping[str, Any]], float]:
    def found(measures: Mapping[str, Any]) -> float:
        values = [measures.get(name) for name in names]  # an archive keeps what is not known as None
        return math.nan if None in values else max(map(float, values))  # type: ignore[arg-type]

    return found


JUDGED = {
    "vibration": Judged(
        "m",
        "amplitude in steady state, the greater of both directions",
        _greater("vertical_amplitude", "horizontal_amplitude"),
    ),
    "synchronous": Judged(
        "m", "the part of it that turns with the rotor", _greater("vertical_synchronous", "horizontal_synchronous")
    ),
    "residual_unbalance": Judged("kg m", "mean residual unbalance in steady state", _greater("residual_unbalance")),
    "settling_time": Judged("s", "settling time of the last ball", _greater("settling_time")),
    "run_up_peak": Judged(
        "m", "greatest deflection before the steady state", _greater("vertical_peak", "horizontal_peak")
    ),
    "bearing_force": Judged(
        "N",
        "greatest radial force of a bearing in steady state",
        _greater("steady_bearing_1_greatest", "steady_bearing_2_greatest"),
    ),
    "contact_force": Judged("N", "force of the hardest contact", _greater("hardest_contact")),
    "contact_pressure": Judged(
        "Pa", "its pressure if it is between two balls, the greatest possible", _greater("contact_pressure")
    ),
    "share_carried": Judged("1", "share of the balls that go around with the rotor", _greater("share_carried")),
}


def numbers_of(machine: ChamberMachine, measures: Mapping[str, Any]) -> dict[str, float]:
    """What a run of a machine is judged by, from its measures; nan where one is not known."""
    hardest = measures.get("hardest_contact")
    pressure = math.nan if hardest is None else pressure_between_balls(machine, float(hardest))
    known = {**measures, "contact_pressure": pressure}
    return {name: float(entry.of(known)) for name, entry in JUDGED.items()}


def judged_runs(
    jobs: Sequence[Job], how: RunSettings, progress: Callable[[int, int], None] | None = None
) -> list[dict[str, Any]]:
    """What runs are judged by, with their outcome; nothing else of one that did not finish."""
    result = []
    for job, row in zip(jobs, measured_runs(jobs, how, progress), strict=True):
        machine, ended = job.machine, row["outcome"] == "finished"
        numbers = numbers_of(machine, row) if ended and not isinstance(machine, MachineError) else {}
        result.append({"outcome": row["outcome"], **numbers})
    return result


def ruled_out(bounds: ChamberBounds, limits: Mapping[str, float]) -> list[str]:
    """Why no run of a machine with these bounds can be good; empty if nothing speaks against it."""
    reasons = []
    if bounds.capability < bounds.unbalance:
        reasons.append(f"the balls can balance {bounds.capability:.3g} of {bounds.unbalance:.3g} kg m")
    if not bounds.run_up_time < math.inf:
        reasons.append(f"the speed stays below the critical speed of {bounds.critical_speed:.4g} rad/s")
    if math.isnan(bounds.critical_speed):
        reasons.append("the body has no critical speed: the balls do not feel the unbalance")
    if "pick_up" in limits:
        reasons += _not_lifted(bounds)
    for name, least, unit in (
        ("vibration", bounds.least_vibration, "m"),
        ("synchronous", bounds.least_vibration, "m"),
        ("residual_unbalance", bounds.least_residual, "kg m"),
        ("settling_time", bounds.least_settling_time, "s"),
        ("bearing_force", bounds.least_bearing_force, "N"),
        ("contact_force", bounds.race_force, "N"),
        ("contact_pressure", bounds.race_pressure, "Pa"),
    ):
        if name in limits and least > limits[name]:
            reasons.append(
                f"{name.replace('_', ' ')} is at least {least:.3g} {unit}, the limit {limits[name]:.3g} {unit}"
            )
    return reasons


def _not_lifted(bounds: ChamberBounds) -> list[str]:
    """Why no ball is carried up from the bottom. A row along the axis acts as one ball, whether the rotor shakes or not."""
    needed = f"one ball needs {bounds.least_friction:.3g}"
    if bounds.axial_rows == 1 and bounds.friction < bounds.least_friction:
        return [
            f"friction {bounds.friction:g} does not lift the balls, which lie in one row and act as one ball: {needed}"
        ]
    if bounds.shaking < 1.0 and PUSHED * bounds.friction < bounds.least_friction:
        return [
            f"friction {bounds.friction:g} lifts no ball of a calm rotor: {needed}, and others that push do not halve that"
        ]
    return []


# What few runs tell: intervals of a mean and of a share, and which designs none is better than.


SURE = 0.95  # confidence of all intervals
Floats = NDArray[np.float64]


def mean_interval(values: Sequence[float] | Floats) -> tuple[float, float, float]:
    """Mean, and the ends of its interval by Student's t; infinitely wide of one run. Values that are nan are left out."""
    known = np.asarray(values, np.float64)
    known = known[~np.isnan(known)]
    if known.size < 2:
        return (float(known[0]), -math.inf, math.inf) if known.size else (math.nan, math.nan, math.nan)
    mean = float(known.mean())
    half = float(t.ppf(0.5 + 0.5 * SURE, known.size - 1) * known.std(ddof=1) / math.sqrt(known.size))
    return mean, mean - half, mean + half


def share_interval(successes: int, runs: int) -> tuple[float, float, float]:
    """Share, and the ends of its exact interval (Clopper and Pearson 1934)."""
    if not runs:
        return math.nan, 0.0, 1.0
    low = float(beta.ppf(0.5 - 0.5 * SURE, successes, runs - successes + 1)) if successes else 0.0
    high = float(beta.ppf(0.5 + 0.5 * SURE, successes + 1, runs - successes)) if successes < runs else 1.0
    return successes / runs, low, high


def worse_than_worst(runs: int) -> float:
    """Share of fillings that are worse than the worst of so many runs, at most, with the confidence of the intervals.

    If the share is p, all runs are better than that with the probability (1 - p)^runs.
    """
    return 1.0 - (1.0 - SURE) ** (1.0 / runs) if runs else 1.0


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
