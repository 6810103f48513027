"""How well a chamber balances over the number of balls and their friction: Pakuła (2021), figures 10 and 12."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from threading import Event
from typing import Any, NamedTuple

import numpy as np
import pandas as pd  # type: ignore[import-untyped]
import xarray as xr

from autobalancer.arrays import Floats
from autobalancer.errors import AutobalancerError, MachineError, QuestionError, one_of
from autobalancer.files.machine_file import balls_in_chambers, machine_text
from autobalancer.laws.impacts import contact_time, energy_error
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.progress import shows_progress
from autobalancer.random_numbers import generator
from autobalancer.results.answers.answer import Answer, Labeled, provenance
from autobalancer.results.archive import Archive, RunFolder
from autobalancer.results.chamber_measures import READ, catalog_numbers, catalog_unit
from autobalancer.simulation.chamber import simulate_chamber
from autobalancer.simulation.chamber.bounds import one_group
from autobalancer.simulation.chamber.chamber_run import default_step
from autobalancer.studies.variations import in_threads
from autobalancer.units import argument, list_argument, optional_argument
from autobalancer.units.quantity import listed, whole_numbers

MOST_RUNS = 100_000  # of one study


@shows_progress
def amplitudes(
    machine: ChamberMachine | str | Path,
    counts: Sequence[int] | Mapping[str, Sequence[int]] | str,
    frictions: Sequence[float] | str,
    *,
    duration: float | str,
    layers: Sequence[str] = ("deep", "single"),
    archive: Archive | str | Path | None = None,
    step: float | str | None = None,
    sample: float | str = 1e-3,
    seeds: Sequence[int] = (0,),
    last: float | str | None = None,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Run a machine with every number of balls and every friction, at equal total mass of the balls.

    Parameters
    ----------
    machine
        With one deep chamber and one group of balls; their total mass is kept.
    counts
        Numbers of balls, for all or for each of ``layers``; for all also as one text such as ``"3,8,20"``.
    frictions
        Coefficients of friction, also as one text.
    duration, step, sample
        As for ``simulate_chamber``, in s.
    layers
        ``"deep"``, ``"single"`` or both.
    archive
        Folder in which all runs are kept. With an archive, a study that was stopped continues; finished runs are not repeated.
    seeds
        Seeds of the filling. How balls pile up and when they are carried along depends on tiny differences at the start.
    last
        Seconds at the end that are the steady state.
    workers
        Threads; the answer does not depend on it.
    progress
        Called with (runs done, runs in all).

    Returns
    -------
    xarray.Dataset
        Over ``layers``, ``friction``, ``balls`` and ``seed`` every measure of :func:`chamber_measures` as a number, nan where
        the balls do not fit or a run failed, and ``outcome``. :func:`over_seeds` makes means and spreads of it.

    Raises
    ------
    QuestionError
        For an empty list, a machine with several chambers, or runs that are too short to be measured.
    MachineError
        For a friction that is not possible.
    """
    counts = whole_numbers("counts", counts) if isinstance(counts, str) else counts
    frictions = listed("frictions", frictions, "") if isinstance(frictions, str) else frictions
    machine, duration = balls_in_chambers(machine), argument("duration", duration, "s")
    step = optional_argument("step", step, "s")
    sample = argument("sample", sample, "s")
    last = optional_argument("last", last, "s")
    each = {name: list(counts[name] if isinstance(counts, Mapping) else counts) for name in layers}
    numbers = sorted({number for several in each.values() for number in several})
    for name, values in (("counts", numbers), ("frictions", frictions), ("layers", layers), ("seeds", seeds)):
        if len(values) == 0:
            raise QuestionError(f"{name}: given none; give at least one")
    requested = len(frictions) * len(seeds) * sum(map(len, each.values()))
    if requested > MOST_RUNS:
        raise QuestionError(
            f"amplitudes: {requested} runs are asked for; at most {MOST_RUNS} are possible, ask for fewer"
        )
    refuse_unmeasurable(duration, sample, last)
    own = machine.chambers[0]
    for friction in frictions:  # refused here, not noted as a gap
        variant(machine, balls=own.balls[0].count, friction=friction, layers="single" if own.depth is None else "deep")
    cells = [Cell(*cell) for cell in product(layers, frictions, numbers, seeds) if cell[2] in each[cell[0]]]

    jobs = [_job(machine, cell) for cell in cells]
    how = RunSettings(duration, last, archive, workers, step, sample)
    result = gathered(cells, measured_runs(jobs, how, progress))
    title = f"Amplitudes of {machine.name} over balls and friction"
    about = {"machine": machine_text(machine), "machine_name": machine.name, "duration": duration}
    result.attrs = {"title": title, **result.attrs, **about}
    return result


def _job(machine: ChamberMachine, cell: Cell) -> Job:
    name = f"{cell.layers}-n{cell.balls}-mu{cell.friction:g}-s{cell.seed}"
    try:
        varied = variant(machine, balls=cell.balls, friction=cell.friction, layers=cell.layers)
    except MachineError as reason:
        return Job(name, reason, cell.seed, {})
    return Job(name, varied, cell.seed, {"layers": cell.layers})


# The same machine with other balls, another friction, a chamber of one layer.


LAYERS = ("deep", "single")


def variant(
    machine: ChamberMachine | str | Path,
    *,
    balls: int,
    friction: float | None = None,
    layers: str = "deep",
    body: str | None = None,
) -> ChamberMachine:
    """A machine with another number of balls of the same total mass, in its deep chamber or in one of a single layer.

    Parameters
    ----------
    machine
        With one chamber and one group of balls.
    balls
        How many; the smaller, the more there are. Cylinders keep their length over their diameter.
    friction
        Of all contacts; by default that of the machine.
    layers
        ``"deep"``: depth as described; ``"single"``: as deep as a ball and a hundredth.
    body
        ``"ball"`` for balls in place of cylinders, of the same mass together; by default as the machine has them.

    Raises
    ------
    QuestionError
        If the machine has several chambers or groups of balls, or ``layers`` or ``body`` is none of these.
    MachineError
        If balls of this size do not go into the chamber.
    """
    one_of("layers", layers, *LAYERS)
    machine = balls_in_chambers(machine)
    own, group = one_group(machine, "variants are", cylinders=True)
    data: dict[str, Any] = tomllib.loads(machine_text(machine))
    chamber = data["chambers"][0] if isinstance(data["chambers"], list) else data["chambers"]
    chamber["balls"] = [{"count": balls, "density": group.density, "total_mass": group.count * group.ball_mass}]
    body = group.body if body is None else body
    if body not in ("ball", group.body):
        also = "; describe cylinders in the machine file" if group.body == "ball" else f" and {group.body!r}"
        raise QuestionError(f"body: given {body!r}; a machine with {group.body}s has variants with 'ball'{also}")
    if group.length is not None and body != "ball":
        same = {"body": group.body, "length": group.length * (group.count / balls) ** (1.0 / 3.0)}
        chamber["balls"][0].update(same)
    if layers == "single":
        chamber.pop("depth", None)
    elif own.depth is None:
        raise QuestionError(
            "machine: its chamber has no depth, so it is one of a single layer; give chambers.depth, or ask for the "
            "single layer alone"
        )
    if friction is not None:
        data["contact"]["friction"] = friction
    return ChamberMachine(**data)


# Runs of deep chambers that are kept in an archive while they are computed, and go on after a stop.


PART = 1000  # samples


def archived_run(
    archive: Archive,
    name: str,
    machine: ChamberMachine | str | Path,
    *,
    duration: float | str,
    parameters: Mapping[str, Any] | None = None,
    step: float | str | None = None,
    sample: float | str = 1e-3,
    method: str = "verlet",
    seed: int = 0,
    last: float | str | None = None,
    part: int = PART,
    progress: Callable[[float, float], Any] | None = None,
) -> RunFolder:
    """Run a machine into an archive. The same call after a stop, a crash or a full disk continues where the archive ends.

    Samples are written to disk in parts, so memory use does not grow with the length of the run. A finished run
    is not computed again.

    Parameters
    ----------
    archive, name
        The archive in which the run is stored, and its name.
    machine
        With chambers.
    duration, step, sample, method, seed
        As for ``simulate_chamber``, in s.
    parameters
        Names and values by which the run is found in the catalogue; number of balls, friction, restitution and seed are
        always included.
    last
        Seconds at the end that count as steady state in the measures. If it changes, a finished run is measured again.
    part
        Samples in a part, which is also how much is computed again after a stop.
    progress
        Called with (time, duration).

    Returns
    -------
    RunFolder
        With ``samples()``.

    Raises
    ------
    QuestionError
        If the archive has a run of this name with other settings, or the run is too short for its measures.
    ResultError
        If the disk is full; what was written is kept. If another process writes the run; the message names it.
    """
    duration = argument("duration", duration, "s")
    step = optional_argument("step", step, "s")
    sample = argument("sample", sample, "s")
    last = optional_argument("last", last, "s")
    machine = balls_in_chambers(machine)
    refuse_unmeasurable(duration, sample, last)
    told = {**standard_parameters(machine), "seed": seed, **(parameters or {})}
    question = {"duration": duration, "step": step, "sample": sample, "method": method, "seed": seed, "part": part}
    run = archive.start(name, machine_text(machine), told, question)
    if run.state == "finished" and run.note.measured_last == last:
        return run
    with run.writing():
        if run.state != "finished":  # another process may have ended it by now
            _go_on(run, machine, question, last, progress)
        elif run.note.measured_last != last:  # measured over another time
            _measured(run, last)
    return run


def refuse_unmeasurable(duration: float, sample: float, last: float | None) -> None:
    """Refuse, before it begins, a run that is too short for its measures.

    Raises
    ------
    QuestionError
        If it has fewer than two samples, or ``last`` is not within it.
    """
    if not duration >= sample * (1.0 - 1e-9):
        raise QuestionError(
            f"duration: given {duration:g} s; a run to measure must be {sample:g} s or longer, one sample"
        )
    if last is not None and not 0.0 < last <= duration * (1.0 + 1e-9):
        raise QuestionError(f"last: given {last:g} s; must be above zero and within the {duration:g} s of a run")


def measured_run(
    archive: Archive | None,
    name: str,
    machine: ChamberMachine,
    parameters: Mapping[str, Any],
    *,
    last: float | None,
    progress: Callable[[float, float], Any] | None = None,
    **question: Any,
) -> dict[str, Any]:
    """Outcome and measures of a run by name, as single numbers, from the archive if there is one.

    ``question`` has duration, step, sample and seed, as for :func:`archived_run`. A run that did not finish has no measures.
    """
    if archive is not None:
        run = archived_run(archive, name, machine, parameters=parameters, last=last, progress=progress, **question)
        return {"outcome": run.note.outcome.get("outcome", run.state), **run.note.measures}
    ended = simulate_chamber(machine, progress=progress, **question)
    outcome = str(ended.attrs["outcome"])
    if outcome != "finished":
        return {"outcome": outcome}
    return {"outcome": outcome, **catalog_numbers(ended, last)}


def _go_on(
    run: RunFolder,
    machine: ChamberMachine,
    question: Mapping[str, Any],
    last: float | None,
    progress: Callable[[float, float], Any] | None,
) -> None:
    checkpoint = run.checkpoint()
    run.end("running")
    options = {key: value for key, value in question.items() if key != "part"}
    try:
        ended = simulate_chamber(
            machine,
            **options,
            resume=checkpoint,
            on_chunk=run.append,
            keep=False,
            chunk=question["part"],
            progress=progress,
        )
    except KeyboardInterrupt:
        run.end("interrupted")
        raise
    except AutobalancerError as reason:
        _note_failure(run, reason)
        raise
    outcome = {key: ended.attrs[key] for key in ("outcome", "outcome_text") if key in ended.attrs}
    state = "finished" if outcome.get("outcome") == "finished" else "failed"
    if state == "finished":
        _measured(run, last, outcome)
    else:
        run.end(state, outcome, {})


def _measured(run: RunFolder, last: float | None, outcome: Mapping[str, Any] | None = None) -> None:
    numbers = catalog_numbers(run.samples(READ), last)
    run.note.measured_last = last
    run.end("finished", outcome, numbers)


def standard_parameters(machine: ChamberMachine) -> dict[str, Any]:
    """What is always in the catalogue."""
    groups = [balls for chamber in machine.chambers for balls in chamber.balls]
    return {
        "machine_name": machine.name,
        "balls": sum(group.count for group in groups),
        "ball_mass_total": sum(group.count * group.ball_mass for group in groups),
        "body": groups[0].body,
        "ball_diameter": 2.0 * groups[0].radius,
        "depth": machine.chambers[0].inner_depth,
        "friction": float(machine.contact.friction),
        "restitution": float(machine.contact.restitution),
        "freedom": machine.body.freedom,
    }


def _note_failure(run: RunFolder, reason: AutobalancerError) -> None:
    """On a full disk even the note may fail; the error that is raised says it all."""
    try:
        run.end("failed", {"outcome": "failed", "outcome_text": str(reason)})
    except AutobalancerError:
        return


# Many runs of deep chambers for a study: on all cores, the longest first, in an archive, stopped by Ctrl-C at once;
# and their measures as arrays over layers, friction, number of balls and seed.


DIMS = ("layers", "friction", "balls", "seed")
NOT_ASKED = "not asked"


class Job(NamedTuple):
    """One run: its name in an archive, its machine or why there is none, the seed of its filling, what the catalogue adds."""

    name: str
    machine: ChamberMachine | MachineError
    seed: int
    parameters: Mapping[str, Any]


@dataclass(frozen=True)
class RunSettings:
    """How all runs of a study are made: s, where they are kept, and on how many threads; ``None`` for one each core."""

    duration: float
    last: float | None
    archive: Archive | str | Path | None
    workers: int | None
    step: float | None = None
    sample: float = 1e-3


def measured_runs(
    jobs: Sequence[Job], how: RunSettings, progress: Callable[[int, int], None] | None = None
) -> list[dict[str, Any]]:
    """Outcome and measures of each run by name, as :func:`measured_run` has them; ``does not fit`` with the reason as outcome.

    The answers do not depend on the number of threads. After Ctrl-C every run stops within a fraction of a second; an archive
    keeps what it computed. ``progress`` is called with (runs done, runs in all).
    """
    stop, archive = Event(), how.archive
    kept = archive if isinstance(archive, Archive) or archive is None else Archive(archive)

    def watch(now: float, end: float) -> None:
        if stop.is_set():
            raise KeyboardInterrupt

    def one(job: Job) -> dict[str, Any]:
        if isinstance(job.machine, MachineError):
            return {"outcome": f"does not fit: {job.machine}"}
        options = {"duration": how.duration, "step": how.step, "sample": how.sample, "seed": job.seed}
        try:
            return measured_run(kept, job.name, job.machine, job.parameters, last=how.last, progress=watch, **options)
        except MachineError as reason:
            return {"outcome": f"does not fit: {reason}"}

    return in_threads(one, jobs, how.workers, progress, cost=lambda job: _cost(job, how.step), stop=stop)


def _cost(job: Job, step: float | None) -> float:
    """Balls times steps in a second: the time that a run takes is in proportion."""
    if isinstance(job.machine, MachineError):
        return 0.0
    balls = sum(group.count for chamber in job.machine.chambers for group in chamber.balls)
    return balls / (default_step(job.machine) if step is None else step)


class Cell(NamedTuple):
    """One run of a study: ``"deep"`` or ``"single"``, friction, number of balls, seed of the filling."""

    layers: str
    friction: float
    balls: int
    seed: int


def gathered(cells: Sequence[Cell], rows: Sequence[Mapping[str, Any]]) -> xr.Dataset:
    """Runs as one dataset.

    Parameters
    ----------
    cells
        Which run each row is of.
    rows
        ``outcome`` and measures by name; a missing or unknown one counts as nan.

    Returns
    -------
    xarray.Dataset
        Over ``layers``, ``friction``, ``balls`` and ``seed``: every measure, nan where there is none, and ``outcome``.

    Raises
    ------
    QuestionError
        If there is no run.
    """
    if not cells:
        raise QuestionError("study: no runs were asked for; give at least one of each")
    table = pd.DataFrame(rows, index=pd.MultiIndex.from_tuples(cells, names=DIMS))
    outcome = table.pop("outcome")
    order = np.array(list(dict.fromkeys(cell.layers for cell in cells)))
    dataset = xr.Dataset.from_dataframe(table[sorted(table)].astype(float)).reindex(layers=order)
    for name, values in dataset.data_vars.items():
        values.attrs = {"units": catalog_unit(str(name)), "long_name": str(name).replace("_", " ")}
    dataset["outcome"] = xr.DataArray.from_series(outcome).reindex(layers=order).fillna(NOT_ASKED)
    return Answer.of(dataset.assign_attrs(provenance()), "ChamberStudy")


# What a study of a chamber says as a whole: means over seeds and over ranges, and what it takes to carry the balls.


OPTIMAL = {"deep": (8, 50), "single": (3, 10)}  # ranges of figure 12 of Pakuła (2021)


def over_seeds(study: xr.Dataset) -> xr.Dataset:
    """Every measure of ``study`` as its mean over the seeds, ``<measure>_spread`` as their standard deviation, and ``runs``.

    A run that failed, or has no such measure, is left out; with fewer than two the spread is nan.
    """
    if "seed" not in study.dims:
        return study
    names = _measures(study)
    dataset = xr.Dataset(attrs=study.attrs)
    for name in names:
        dataset[name] = study[name].mean("seed", skipna=True, keep_attrs=True)
        dataset[f"{name}_spread"] = _spread(study[name])
    if names:
        dataset["runs"] = _counted(study[names[0]], "seed")
    return Answer.of(dataset, "ChamberStudy")


def optimal_means(study: xr.Dataset, ranges: Mapping[str, tuple[int, int]] | None = None) -> xr.Dataset:
    """Means of the amplitudes over the numbers of balls in a range for each of ``layers`` (Pakuła 2021, figure 12).

    ``ranges`` has the least and the greatest number of each of the ``layers`` of ``study``; by default those of the source.

    Returns
    -------
    xarray.Dataset
        Over ``layers`` and ``friction``: means of the amplitudes over balls and seeds, ``<amplitude>_spread``, the standard
        deviation over the seeds of the mean of one seed, and ``runs``, how many of the study are in each.

    Raises
    ------
    QuestionError
        If the study has no number of balls in a range.
    """
    chosen = {**OPTIMAL, **(ranges or {})}
    names = [name for name in _measures(study) if name.endswith(("_amplitude", "_synchronous"))]
    several = study if "seed" in study.dims else study[names].expand_dims(seed=[0])
    pieces = []
    for layer in study["layers"].values:
        low, high = chosen[str(layer)]
        within = several[names].sel(layers=layer, balls=(study["balls"] >= low) & (study["balls"] <= high))
        if within.sizes["balls"] == 0:
            raise QuestionError(f"ranges: the study has no number of balls from {low} to {high} for {str(layer)!r}")
        each = within.mean("balls", skipna=True, keep_attrs=True)
        mean = each.mean("seed", skipna=True, keep_attrs=True)
        for name in names:
            mean[f"{name}_spread"] = _spread(each[name])
        mean["runs"] = _counted(within[names[0]], "balls", "seed")
        pieces.append(mean)
    return Answer.of(xr.concat(pieces, "layers", coords="minimal", compat="override"), "ChamberStudy")


def pick_up_borders(study: xr.Dataset, share: float = 0.9) -> xr.Dataset:
    """The least friction and number of balls at which balls are carried around instead of staying at the bottom.

    Parameters
    ----------
    study
        From :func:`amplitudes`.
    share
        Share of the balls that must go around, in the mean over the seeds.

    Returns
    -------
    xarray.Dataset
        ``least_friction`` over ``layers`` and ``balls``, and ``least_balls`` over ``layers`` and ``friction``: the least
        values of the study with which they do; nan where none of them is enough.
    """
    if not 0.0 < share <= 1.0:
        raise QuestionError(f"share: given {share:g}; must be above 0, at most 1")
    carried = over_seeds(study)["share_carried"] >= share
    dataset = xr.Dataset()
    for name, along in (("least_friction", "friction"), ("least_balls", "balls")):
        least = study[along].where(carried).min(along, skipna=True)
        dataset[name] = least.assign_attrs(long_name=f"least {along} with which {share:.0%} of the balls go around")
    return Labeled.of_run(study, "Borders of being carried", dataset)


def _measures(study: xr.Dataset) -> list[str]:
    return [str(name) for name, values in study.data_vars.items() if values.dtype.kind == "f"]


def _counted(values: xr.DataArray, *over: str) -> xr.DataArray:
    return values.notnull().sum(over).drop_attrs().assign_attrs(units="1", long_name="number of runs")


def _spread(values: xr.DataArray) -> xr.DataArray:
    enough = values.notnull().sum("seed") > 1
    # where there is one run, or none, numpy would warn of what is meant
    with np.errstate(invalid="ignore", divide="ignore"):
        spread = values.where(enough, 0.0).std("seed", ddof=min(1, values.sizes["seed"] - 1), skipna=True)
    units = values.attrs.get("units", "")
    return spread.where(enough).assign_attrs(units=units, long_name="standard deviation over the seeds")


# Which step a contact needs: two equal balls collide head on, again and again, at another phase of the step.


SCHEMES = ("runge_kutta", "velocity_verlet")


def step_size(
    speeds: Sequence[float | str] = (4.0, 6.0, 8.0, 10.0),
    steps: Sequence[float | str] = (1e-4, 1e-5, 1e-6, 1e-7),
    *,
    stiffness_over_mass: float,
    restitution: float = 1.0,
    phases: int = 200,
    seed: int = 0,
    scheme: str = "runge_kutta",
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Error of the energy after a central collision, over the step, the speed, and where in a step the contact begins.

    Law of Pakuła (2021), (15): k d^1.5 in approach, the square of the restitution of it in separation; appendix 2 and
    table 5 take an elastic one. The source uses one phase for each entry and therefore finds one sign only.

    Parameters
    ----------
    speeds
        Relative speeds of the balls (m/s).
    steps
        Steps of the integration (s).
    stiffness_over_mass
        k/m of one ball (m^-0.5 s^-2), such as 1e10.
    restitution
        Ratio of the speeds after and before.
    phases
        Number of collisions, with the beginning of the contact anywhere in a step.
    seed
        Of these beginnings.
    scheme
        ``"runge_kutta"``, the classical one of the source, or ``"velocity_verlet"``.
    progress
        Called with (collisions done, in all) after each pair of speed and step.

    Returns
    -------
    xarray.Dataset
        Over ``relative_speed``, ``step`` and ``phase_number``: ``energy_error``, relative to the energy before; over the
        first two ``greatest``, ``least``, ``mean``, ``root_mean_square`` of it, ``share_of_gains`` with more energy than
        exact, ``contact_time`` (s); for the elastic contact under Runge-Kutta ``expected_root_mean_square``, that of the
        leading order for these collisions, and ``typical_root_mean_square`` with the end of the contact, too, anywhere in a
        step, which grows with the step to the power 2.5 and the root of the speed.

    Raises
    ------
    QuestionError
        If a number is not possible.
    """
    speeds = list_argument("speeds", speeds, "m/s")
    steps = list_argument("steps", steps, "s")
    _check(speeds, steps, stiffness_over_mass, restitution, phases, scheme)
    start = generator(seed).random(phases)
    error = np.empty((len(speeds), len(steps), phases))
    expected = np.full(error.shape[:2], np.nan)
    typical = np.full_like(expected, np.nan)
    other = generator(seed).random((2, 4000))
    done = 0
    for i, speed in enumerate(speeds):
        for j, step in enumerate(steps):
            after = _collide(speed, step, stiffness_over_mass, restitution, start, scheme)
            error[i, j] = (after / speed) ** 2 - restitution**2
            if scheme == "runge_kutta" and restitution == 1.0:
                ended = start + contact_time(speed, stiffness_over_mass) / step
                for cell, entry, end in ((expected, start, ended), (typical, *other)):
                    likely = energy_error(speed, step, stiffness_over_mass, 1.0 - entry, 1.0 - (-end) % 1.0)
                    cell[i, j] = np.sqrt(np.mean(likely**2))
            done += phases
            if progress is not None:
                progress(done, error.size)
    over = ("relative_speed", "step")
    energy, times = "energy error", [contact_time(speed, stiffness_over_mass) for speed in speeds]
    about: dict[str, tuple[Any, Any, str, str]] = {
        "relative_speed": ("relative_speed", speeds, "m/s", "relative speed"),
        "step": ("step", steps, "s", "step"),
        "energy_error": ((*over, "phase_number"), error, "1", f"{energy} after the collision over the energy before"),
        "greatest": (over, error.max(axis=2), "1", f"greatest {energy}"),
        "least": (over, error.min(axis=2), "1", f"least {energy}"),
        "mean": (over, error.mean(axis=2), "1", f"mean {energy}"),
        "root_mean_square": (over, np.sqrt((error**2).mean(axis=2)), "1", f"root mean square of the {energy}"),
        "share_of_gains": (over, (error > 0.0).mean(axis=2), "1", "share of the collisions that gain energy"),
        "expected_root_mean_square": (over, expected, "1", "root mean square to leading order in the step"),
        "typical_root_mean_square": (over, typical, "1", "the same with the end of the contact anywhere in a step"),
        "contact_time": ("relative_speed", times, "s", "duration of the contact, elastic"),
    }
    dataset = xr.Dataset(
        {name: (dims, values, {"units": unit, "long_name": text}) for name, (dims, values, unit, text) in about.items()}
    )
    title = "Energy error of a step in a central collision"
    asked = {"stiffness_over_mass": stiffness_over_mass, "restitution": restitution, "seed": seed, "scheme": scheme}
    return Labeled.of(dataset.assign_attrs(title=title, **asked, **provenance()))


def _collide(speed: float, step: float, k: float, restitution: float, phase: Floats, scheme: str) -> Floats:
    """Relative speeds after the collision; the distance closes from a part of a step before the contact."""
    gap = speed * step * phase
    rate = np.full_like(gap, -speed)
    recovered = restitution**2
    end = 1.5 * contact_time(speed, k) * (1.0 + 1.0 / max(restitution, 0.1)) + 20.0 * step

    def pull(gap: Floats, rate: Floats) -> Floats:
        depth = np.maximum(-gap, 0.0)
        return 2.0 * k * depth * np.sqrt(depth) * np.where(rate > 0.0, recovered, 1.0)

    for _ in range(int(np.ceil(end / step))):
        if scheme == "velocity_verlet":
            rate = rate + 0.5 * step * pull(gap, rate)
            gap = gap + step * rate
            rate = rate + 0.5 * step * pull(gap, rate)
            continue
        a1 = pull(gap, rate)
        v2 = rate + 0.5 * step * a1
        a2 = pull(gap + 0.5 * step * rate, v2)
        v3 = rate + 0.5 * step * a2
        a3 = pull(gap + 0.5 * step * v2, v3)
        v4 = rate + step * a3
        a4 = pull(gap + step * v3, v4)
        gap = gap + step / 6.0 * (rate + 2.0 * v2 + 2.0 * v3 + v4)
        rate = rate + step / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
    return rate


def _check(
    speeds: Sequence[float], steps: Sequence[float], k: float, restitution: float, phases: int, scheme: str
) -> None:
    for name, values in (("speeds", speeds), ("steps", steps), ("stiffness_over_mass", [k])):
        if len(values) == 0 or not all(np.isfinite(value) and value > 0.0 for value in values):
            raise QuestionError(f"{name}: given {list(values)}; must be numbers greater than zero")
    if not 0.0 < restitution <= 1.0:
        raise QuestionError(f"restitution: given {restitution:g}; must be above 0, at most 1")
    if phases < 1:
        raise QuestionError(f"phases: given {phases}; must be at least 1")
    one_of("scheme", scheme, *SCHEMES)
